"""Bifurcation diagrams: orbits as lines over a parameter, attractors that are no cycles as dots."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from stickslip.numerics.arrays import Floats
from stickslip.plot.bifurcations import (
    BREAK,
    MARKS,
    coordinate_label,
    draw_bifurcation,
    draw_stretches,
    mark,
    parameter_label,
)
from stickslip.plot.style import PALETTE, axes_or_new

DOTS: Final[dict[str, Any]] = {
    "color": PALETTE["blue"],
    "ls": "none",
    "marker": ",",
    "zorder": 2,
    "rasterized": True,  # half a million dots: lines would make files that no viewer opens
}


def draw_diagram(
    diagram: Any,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    periods: Iterable[int] | None = None,
    breakpoints: bool = True,
    marks: bool = True,
    bifurcations: Any = None,
    dots: int = 64,
) -> Axes:
    """Draw a bifurcation diagram.

    Parameters
    ----------
    diagram : Diagram
        From `stickslip.bifurcation_diagram`.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    window : pair of float, optional
        Vertical range; by default the diagram's own, or what the orbits need.
    periods : iterable of int, optional
        Periods of the orbits to draw; by default all.
    breakpoints : bool
        Whether to draw the lines on which the map breaks.
    marks : bool
        Whether to mark where orbits begin and end: folds, flips, border collisions.
    bifurcations : BifurcationList, optional
        Marked instead, if given: crises are among them.
    dots : int
        Points drawn of an attractor at each value.

    Returns
    -------
    matplotlib.axes.Axes
        Stable orbits heavy, unstable ones thin, other attractors as dots, breakpoints dashed.
        Kinds of bifurcations are labels of their marks: ``ax.legend()`` explains them.
    """
    ax = axes_or_new(ax)
    chosen = None if periods is None else set(periods)
    draw_attractors(diagram, ax, dots=dots)
    for orbit in diagram.orbits:
        if chosen is None or orbit.period in chosen:
            draw_orbit_curve(diagram, orbit, ax)
    if breakpoints:
        draw_breakpoints(diagram, ax)
    if bifurcations is not None:
        for item in bifurcations:
            draw_bifurcation(item, ax)
    elif marks:
        _mark_ends(diagram, ax, chosen)
    ax.set_xlim(diagram.values[0], diagram.values[-1])
    if window is None and diagram.window is not None:
        window = diagram.window
    if window is not None:
        ax.set_ylim(window)
    ax.set_xlabel(parameter_label(diagram.parameter, diagram))
    in_space = diagram.attractors.points.ndim > 2
    ax.set_ylabel(coordinate_label(diagram, 0 if in_space else None))
    return ax


def _mark_ends(diagram: Any, ax: Axes, periods: set[int] | None) -> None:
    for orbit in diagram.orbits:
        for end in orbit.ends:
            if end.reason in MARKS and (periods is None or orbit.period in periods):
                mark(ax, end.reason, np.full(len(end.points), end.value), end.points, ms=3.5)


def draw_orbit_curve(diagram: Any, orbit: Any, ax: Axes, **style: Any) -> None:
    """Draw one orbit of a diagram: heavy where it is stable, thin where not, up to its ends."""
    draw_stretches(ax, *_with_ends(diagram, orbit), **style)


def _with_ends(diagram: Any, orbit: Any) -> tuple[Floats, Floats, Floats]:
    """Return values, points and multipliers of an orbit from its first end to its last."""
    exists = np.flatnonzero(np.isfinite(orbit.multipliers))
    low, high = orbit.ends
    inside = slice(exists[0], exists[-1] + 1) if exists.size else slice(0, 0)
    middle = orbit.multipliers[inside]
    beside = (middle[0], middle[-1]) if exists.size else (np.nan, np.nan)
    values = np.concatenate([[low.value], diagram.values[inside], [high.value]])
    points = np.vstack([low.points[None], orbit.points[inside], high.points[None]])
    return values, points, np.concatenate([beside[:1], middle, beside[1:]])


def draw_attractors(
    diagram: Any, ax: Axes, *, dots: int = 64, kinds: Iterable[str] | None = None, **style: Any
) -> None:
    """Draw attractors that are none of the diagram's orbits as dots, cycles whole."""
    table = diagram.attractors
    if not len(table):
        return
    others = (table.kind != "periodic") | (table.period > diagram.max_period)
    if kinds is not None:
        others &= np.isin(table.kind, list(kinds))
    points = table.points[others]
    points = points[..., 0] if points.ndim > 2 else points
    last = np.where(table.kind[others] == "periodic", points.shape[1], dots)
    points = np.where(np.arange(points.shape[1]) < last[:, None], points, np.nan)
    values = np.broadcast_to(diagram.values[table.where[others], None], points.shape)
    known = np.isfinite(points)
    ax.plot(values[known], points[known], **{**DOTS, **style})


def draw_breakpoints(diagram: Any, ax: Axes, **style: Any) -> None:
    """Draw the lines on which the map breaks."""
    for line in diagram.breakpoints:
        ax.plot(diagram.values, line.d, **{**BREAK, **style})
