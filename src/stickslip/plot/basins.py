"""Strips along the axis of a map: basins of attraction, bands of attractors, densities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from stickslip.plot.style import PALETTE, axes_or_new

BASIN_COLORS: Final = tuple(
    PALETTE[name] for name in ("sky", "orange", "green", "purple", "vermillion", "blue")
)
HATCHES: Final = ("", "////", "\\\\\\\\", "....", "xxxx")  # tell basins apart in print
LEFT, UNDECIDED = -2, -1


def draw_basins(basins: Any, ax: Axes | None = None, *, attractors: bool = True) -> Axes:
    """Draw basins as a strip: a colour and hatch per attractor, light grey where orbits leave."""
    ax = axes_or_new(ax)
    widths = np.diff(basins.edges)
    for k in np.unique(basins.index):
        mine = basins.index == k
        spans = list(zip(basins.edges[:-1][mine], widths[mine], strict=True))
        ax.broken_barh(spans, (0.0, 1.0), label=_name(basins, int(k)), **_looks(int(k)))
    if attractors:
        for k, attractor in enumerate(basins.attractors):
            _draw_attractor(ax, attractor, k, height=1.12)
    ax.set_xlim(basins.edges[0], basins.edges[-1])
    return _as_strip(ax, top=1.25 if attractors else 1.0)


def draw_bands(attractors: Sequence[Any], ax: Axes | None = None) -> Axes:
    """Draw the bands of attractors as strips, the first one lowest, cycles as points."""
    ax = axes_or_new(ax)
    for k, attractor in enumerate(attractors):
        _draw_attractor(ax, attractor, k, height=k + 0.5)
    return _as_strip(ax, top=max(len(attractors), 1))


def draw_attractor(attractor: Any, ax: Axes | None = None) -> Axes:
    """Draw the bands of one attractor; as `draw_bands`."""
    return draw_bands([attractor], ax)


def draw_density(density: Any, ax: Axes | None = None) -> Axes:
    """Draw an invariant density over its bands."""
    # The highest half per cent of the density may reach above the axes: inverse square roots have
    # no height.
    ax = axes_or_new(ax)
    breaks = np.flatnonzero(density.left[1:] > density.right[:-1]) + 1
    for cells in np.split(np.arange(len(density.left)), breaks):
        edges = np.append(density.left[cells], density.right[cells[-1]])
        ax.stairs(density.density[cells], edges, color=PALETTE["blue"], lw=0.8)
    ax.set_xlim(density.left[0], density.right[-1])
    ax.set_ylim(0.0, 1.1 * float(np.quantile(density.density, 0.995)))
    ax.set_xlabel("$d$")
    ax.set_ylabel("probability density")
    return ax


def _draw_attractor(ax: Axes, attractor: Any, k: int, height: float) -> None:
    color = BASIN_COLORS[k % len(BASIN_COLORS)]
    if attractor.kind in ("chaotic", "neutral"):
        left, right = attractor.bands.T
        ax.hlines(np.full(len(left), height), left, right, colors=color, lw=3.0)
        return
    marker = "o" if attractor.kind == "periodic" else "x"
    points = attractor.bands[:, 0]
    ax.plot(points, np.full(len(points), height), marker, color=color, ms=4.0, clip_on=False)


def _looks(k: int) -> dict[str, Any]:
    if k == LEFT:
        return {"facecolor": PALETTE["light"], "edgecolor": "none"}
    if k == UNDECIDED:
        return {"facecolor": "white", "edgecolor": PALETTE["grey"], "linewidth": 0.3}
    return {
        "facecolor": BASIN_COLORS[k % len(BASIN_COLORS)],
        "edgecolor": "white",
        "linewidth": 0.0,
        "hatch": HATCHES[(k // len(BASIN_COLORS)) % len(HATCHES)],
    }


def _name(basins: Any, k: int) -> str:
    if k == UNDECIDED:
        return "not proved"
    share, error = basins.sampled(k)
    name = "leaves"
    if k != LEFT:
        attractor = basins.attractors[k]
        name = f"attractor {k}: {attractor.kind}, period {attractor.period}"
    return f"{name} (and {share:.3f} ± {error:.1g}, sampled)" if share else name


def _as_strip(ax: Axes, top: float) -> Axes:
    ax.set_ylim(0.0, top)
    ax.set_yticks([])
    ax.set_xlabel("$d$")
    return ax
