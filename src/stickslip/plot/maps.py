"""The event map as a picture: its graph, sampled for drawing, orbits on it and cobwebs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from stickslip.numerics.arrays import Floats
from stickslip.plot.bifurcations import name_steps, symbol_of
from stickslip.plot.style import PALETTE, axes_or_new

_ROUNDS = 40  # bisections; enough for 1e-9 of the window, and a bound in every case
_MOST_POINTS = 50_000
_RESOLUTION = 1e-9  # of the window, to which changes of label are bisected


class _Map(Protocol):
    def evaluate(self, x: Any, /) -> Any: ...


@dataclass(frozen=True)
class Curve:
    """Graph of a map, ready to draw: points in ascending order, NaN between segments."""

    x: Floats
    y: Floats
    jumps: Floats  # where the value jumps, or the map becomes undefined


def trace(f: _Map, window: tuple[float, float], *, points: int = 801) -> Curve:
    """Sample a map for drawing: broken where the label changes *and* the value jumps."""
    # Branches thinner than the first sample of so many `points` can be missed: ask `branches` for a
    # complete list.
    x = np.linspace(*window, points)
    y, label = _evaluate(f, x)
    width = x[-1] - x[0]
    for _ in range(_ROUNDS):
        gap = np.diff(x)
        changes = (label[1:] != label[:-1]) & (gap > _RESOLUTION * width)
        steep = (np.abs(np.diff(y)) > 0.01 * _height(y)) & (gap > 1e-6 * width)
        (where,) = np.nonzero(changes | steep)
        if where.size == 0 or x.size > _MOST_POINTS:
            break
        middle = 0.5 * (x[where] + x[where + 1])
        y_middle, label_middle = _evaluate(f, middle)
        x = np.insert(x, where + 1, middle)
        y = np.insert(y, where + 1, y_middle)
        label = np.insert(label, where + 1, label_middle)
    return _broken(x, y, label)


def _evaluate(f: _Map, x: Floats) -> tuple[Floats, NDArray[np.uint64]]:
    result = f.evaluate(x)
    return np.asarray(result.value, dtype=np.float64), np.asarray(result.label)


def _height(y: Floats) -> float:
    finite = y[np.isfinite(y)]
    return float(np.ptp(finite)) if finite.size else 0.0


def _broken(x: Floats, y: Floats, label: NDArray[np.uint64]) -> Curve:
    """Put NaN between neighbours that a change of label and a jump separate."""
    # A bisected change is 1e-9 of the window wide; across it even a square root moves by less than
    # 1e-4 of the height. So a larger difference is a jump.
    jumps = (label[1:] != label[:-1]) & ~(np.abs(np.diff(y)) <= 1e-4 * _height(y))
    (where,) = np.nonzero(jumps)
    line = np.where(np.isfinite(y), x, np.nan)
    return Curve(
        x=np.insert(line, where + 1, np.nan),
        y=np.insert(y, where + 1, np.nan),
        jumps=0.5 * (x[where] + x[where + 1]),
    )


def event_map(
    f: Any,
    ax: Axes | None = None,
    *,
    window: tuple[float, float] | None = None,
    points: int = 801,
    power: int = 1,
) -> Axes:
    """Draw an event map, a return map of the line, or a power of one.

    Parameters
    ----------
    f : EventMap, LineReturnMap or PiecewiseMap
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
    curve = trace(f, window, points=points)
    return draw_curve(curve, ax, window=window, power=power, symbol=symbol_of(f))


def draw_curve(
    curve: Curve,
    ax: Axes,
    *,
    window: tuple[float, float],
    power: int = 1,
    linewidth: float = 1.0,
    ticks: int = 7,
    symbol: str = "d",
    jumps: bool = False,
) -> Axes:
    """Draw a traced map with the diagonal, dotted at `jumps` for views that cut a side off."""
    ax.plot(window, window, color=PALETTE["grey"], lw=0.5, zorder=1)
    ax.plot(curve.x, curve.y, color="black", lw=linewidth, zorder=2)
    for jump in curve.jumps if jumps else ():
        ax.axvline(jump, color=PALETTE["grey"], lw=0.7, ls=":", zorder=1)
    ax.set_xlim(window)
    ax.set_ylim(window)
    ax.set_aspect("equal")
    for axis in (ax.xaxis, ax.yaxis):  # the same numbers on both
        axis.set_major_locator(MaxNLocator(nbins=ticks, steps=[1, 2, 5, 10]))
    name_steps(ax, symbol, power)
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


def draw_steps(ax: Axes, d: ArrayLike, **line: Any) -> None:
    """Draw an orbit, successive values, as steps between the map and the diagonal."""
    d = np.asarray(d, dtype=float)
    steps = np.repeat(d, 2)
    ax.plot(steps[:-1], steps[1:], **{"color": PALETTE["sky"], "lw": 0.6, "zorder": 1.5, **line})


def draw_branch_table(table: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the map of a table of branches over its domain; as `event_map`."""
    return event_map(table.f, ax, **style)


COLORS: Final = tuple(PALETTE[name] for name in ("sky", "orange", "green", "purple", "vermillion"))


def cobweb(
    f: Any,
    start: ArrayLike,
    ax: Axes | None = None,
    *,
    steps: int = 50,
    skip: int = 0,
    orbits: Iterable[Any] = (),
    window: tuple[float, float] | None = None,
) -> Axes:
    """Draw a map and orbits on it, as steps to the diagonal and back.

    Parameters
    ----------
    f : EventMap or PiecewiseMap
        With ``domain``, ``evaluate`` and ``iterate``.
    start : array_like of float, any shape
        Starting points, one orbit and one colour each.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    steps : int
        Steps drawn of each orbit.
    skip : int
        Steps left out before, so that only the steady motion shows.
    orbits : iterable of PeriodicOrbit
        Marked on the map: filled circles if stable, open squares if not.
    window : pair of float, optional
        Range of both axes; by default the whole domain.

    Returns
    -------
    matplotlib.axes.Axes
        An orbit that leaves ends where it left.

    Raises
    ------
    ValueError
        No step to draw, or a negative number of steps to skip.
    """
    if steps < 1 or skip < 0:
        raise ValueError(f"steps = {steps} must be at least 1, skip = {skip} not negative")
    ax = event_map(f, axes_or_new(ax), window=window)
    paths = np.reshape(f.iterate(np.ravel(start), skip + steps), (-1, skip + steps + 1))
    for k, path in enumerate(paths):
        draw_steps(ax, path[skip:], color=COLORS[k % len(COLORS)])
    for orbit in orbits:  # those outside the window must not widen the picture
        mark_orbit(ax, orbit.points, stable=bool(orbit.stable), clip_on=window is not None)
    return ax
