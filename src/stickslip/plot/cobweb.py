"""Cobweb plots: orbits as steps between a map and the diagonal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.plot.event_map import cobweb, event_map, mark_orbit
from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from collections.abc import Iterable

    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

COLORS: Final = tuple(PALETTE[name] for name in ("sky", "orange", "green", "purple", "vermillion"))


def draw_cobweb(
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
        cobweb(ax, path[skip:], color=COLORS[k % len(COLORS)])
    for orbit in orbits:  # those outside the window must not widen the picture
        mark_orbit(ax, orbit.points, stable=bool(orbit.stable), clip_on=window is not None)
    return ax
