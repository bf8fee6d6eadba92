"""The event map d_n -> d_{n+1}: branches as lines, the diagonal, orbits (figures 5, 6, 12)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.ticker import MaxNLocator

from stickslip.plot.curve import Curve, trace
from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike


def event_map(
    f: Any,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    points: int = 801,
    power: int = 1,
) -> Axes:
    """Draw an event map, or a power of one.

    Parameters
    ----------
    f : EventMap or PiecewiseMap
        With ``domain`` and ``evaluate``.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    window : pair of float, optional
        Range of d on both axes; by default the whole domain.
    points : int
        Size of the first sample, refined where the map bends or breaks.
    power : int
        Which power of a map `f` already is; names the vertical axis.

    Returns
    -------
    matplotlib.axes.Axes
        The same range on both axes.
    """
    ax = axes_or_new(ax)
    window = f.domain if window is None else window
    return draw_curve(trace(f, window, points=points), ax, window=window, power=power)


def draw_curve(
    curve: Curve,
    ax: Axes,
    *,
    window: tuple[float, float],
    power: int = 1,
    color: str = "black",
    linewidth: float = 1.0,
    ticks: int = 7,
    jumps: bool = False,
) -> Axes:
    """Draw a traced map with the diagonal.

    Parameters
    ----------
    curve : Curve
        From `stickslip.plot.curve.trace`.
    ax : matplotlib.axes.Axes
        Where to draw.
    window : pair of float
        Range of both axes.
    power : int
        Names the vertical axis: d_{n+power}.
    color : str
        Of the map's line.
    linewidth : float
        Of the map's line, in points.
    ticks : int
        Most intervals between numbers on an axis.
    jumps : bool
        Whether to dot a vertical line at each jump, for views in which one side is out
        of the picture.

    Returns
    -------
    matplotlib.axes.Axes
        The axes given.
    """
    ax.plot(window, window, color=PALETTE["grey"], lw=0.5, zorder=1)
    ax.plot(curve.x, curve.y, color=color, lw=linewidth, zorder=2)
    for jump in curve.jumps if jumps else ():
        ax.axvline(jump, color=PALETTE["grey"], lw=0.7, ls=":", zorder=1)
    ax.set_xlim(window)
    ax.set_ylim(window)
    ax.set_aspect("equal")
    for axis in (ax.xaxis, ax.yaxis):  # the same numbers on both
        axis.set_major_locator(MaxNLocator(nbins=ticks, steps=[1, 2, 5, 10]))
    ax.set_xlabel(r"$d_n$")
    ax.set_ylabel(rf"$d_{{n+{power}}}$")
    return ax


def mark_orbit(
    ax: Axes, d: ArrayLike, *, power: int = 1, stable: bool = True, **marker: Any
) -> None:
    """Mark a periodic orbit on a map: filled circles if stable, open squares if not.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Where to draw.
    d : array_like of float, shape (p,)
        Points in the order in which the motion visits them.
    power : int
        The map drawn is the power-th iterate; under it a point stands over itself
        when the period divides `power`.
    stable : bool
        Which marker.
    **marker
        Passed on to ``Axes.plot``.
    """
    d = np.atleast_1d(np.asarray(d, dtype=float))
    looks: dict[str, Any] = {"ls": "none", "zorder": 4, "clip_on": False}
    if stable:
        looks |= {"marker": "o", "ms": 4.0, "mfc": PALETTE["blue"], "mec": PALETTE["blue"]}
    else:
        looks |= {"marker": "s", "ms": 4.5, "mfc": "white", "mec": PALETTE["vermillion"]}
        looks |= {"mew": 1.0}
    ax.plot(d, np.roll(d, -power), **{**looks, **marker})


def cobweb(ax: Axes, d: ArrayLike, **line: Any) -> None:
    """Draw an orbit as steps between the map and the diagonal.

    Parameters
    ----------
    ax : matplotlib.axes.Axes
        Axes of a map.
    d : array_like of float, shape (n + 1,)
        Successive values, such as ``f.iterate(d0, n)``.
    **line
        Passed on to ``Axes.plot``.
    """
    d = np.asarray(d, dtype=float)
    steps = np.repeat(d, 2)
    ax.plot(steps[:-1], steps[1:], **{"color": PALETTE["sky"], "lw": 0.6, "zorder": 1.5, **line})


def draw_branch_table(table: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the map of a table of branches over its domain; as `event_map`."""
    return event_map(table.f, ax, **style)
