"""Periodic orbits on the plane (d_n, d_{n+1})."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from stickslip.plot.bifurcations import coordinate_label, name_steps, symbol_of
from stickslip.plot.maps import mark_orbit
from stickslip.plot.style import PALETTE, axes_or_new, label_once


def draw_orbit(orbit: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Mark the points of a periodic orbit over their predecessors.

    Filled circles if stable, open squares if unstable, crosses if the orbit passes through a jump.
    """
    return draw_orbits([orbit], ax, **style)


def draw_orbits(orbits: Sequence[Any], ax: Axes | None = None, **style: Any) -> Axes:
    """Mark several periodic orbits; as `draw_orbit`, on new axes with the diagonal."""
    bare = ax is None
    ax = axes_or_new(ax)
    for orbit in orbits:
        crossing = {"marker": "x", "mec": PALETTE["purple"], "mew": 1.0}
        looks: dict[str, Any] = crossing if orbit.infinitely_unstable else {}
        name = "stable" if orbit.stable else "through a jump" if looks else "unstable"
        looks["label"] = label_once(ax, name)
        mark_orbit(ax, orbit.points, stable=bool(orbit.stable), **{**looks, **style})
    if bare:
        ax.axline((0.0, 0.0), slope=1.0, color=PALETTE["grey"], lw=0.5, zorder=1)
        name_steps(ax, symbol_of(orbits[0] if orbits else None))
        points = [np.asarray(orbit.points) for orbit in orbits]
        if points:
            ends = np.concatenate(points)
            pad = 0.05 * float(np.ptp(ends)) + 0.01 * float(np.abs(ends).max()) + 1e-12
            ax.set_xlim(ends.min() - pad, ends.max() + pad)
            ax.set_ylim(ax.get_xlim())
    return ax


def draw_orbit_nd(orbit: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Mark the points of a periodic orbit of a map of R^n; as `draw_orbits_nd`."""
    return draw_orbits_nd([orbit], ax, **style)


def draw_orbits_nd(orbits: Sequence[Any], ax: Axes | None = None, **style: Any) -> Axes:
    """Mark orbits in the plane of two coordinates; a single one over the points' numbers.

    A colour for each period; filled if stable.
    """
    ax = axes_or_new(ax)
    periods = list(dict.fromkeys(orbit.period for orbit in orbits))
    for orbit in orbits:
        points, flat = orbit.points, orbit.points.shape[1] == 1
        x, y = (np.arange(len(points)) + 1, points[:, 0]) if flat else points.T[:2]
        looks: dict[str, Any] = {} if orbit.stable else {"mfc": "white"}
        looks["color"] = f"C{periods.index(orbit.period)}"
        name = f"period {orbit.period}"
        looks["label"] = label_once(ax, name)
        ax.plot(x, y, "o", **{**looks, **style})
    if len(periods) > 1:
        ax.legend(loc="best", fontsize="small")
    names = [coordinate_label(orbits[0] if orbits else None, k) for k in range(2)]
    several = any(orbit.points.shape[1] > 1 for orbit in orbits)
    ax.set(xlabel=names[0] if several else "point", ylabel=names[several])
    return ax
