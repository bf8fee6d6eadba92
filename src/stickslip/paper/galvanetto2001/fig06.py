"""Figure 6: event map of the Coulomb system for V = 0.0370 and its attractor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.paper.galvanetto2001.printed import S4_POINT
from stickslip.plot.curve import Curve, trace
from stickslip.plot.event_map import draw_curve, mark_orbit
from stickslip.study.event_map import EventMap, event_map

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

TITLE: Final = "Event map of the Coulomb system, V = 0.0370"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3

SETTLING: Final = 4000
LONGEST: Final = 1000
RECURRENCE: Final = 1e-12


@dataclass(frozen=True)
class Data:
    """The map's graph, and successive points (n,) of the attractor: one period if it has one.

    ``multiplier`` is the product of the slopes over them.
    """

    model: TwoBlock
    curve: Curve
    attractor: NDArray[np.float64]
    periodic: bool
    multiplier: float


def compute() -> Data:
    """Trace the map and follow the motion that starts where S4 was."""
    model = examples.coulomb(V=0.0370)
    f = event_map(model)
    attractor, periodic = follow(f, S4_POINT[0])
    multiplier = float(np.prod(f.derivative(attractor)))
    return Data(model, trace(f, f.domain), attractor, periodic, multiplier)


def follow(f: EventMap, d0: float) -> tuple[NDArray[np.float64], bool]:
    """Iterate towards an attractor and keep one period of it.

    Parameters
    ----------
    f : EventMap
        The map.
    d0 : float
        Where to start.

    Returns
    -------
    points : ndarray of float64, shape (n,)
        In their order; `LONGEST` of them where none comes back to the first.
    periodic : bool
        Whether one does, to within `RECURRENCE`.
    """
    settled = float(f.iterate(d0, SETTLING)[-1])
    points = np.asarray(f.iterate(settled, LONGEST))
    (back,) = np.nonzero(np.abs(points[1:] - points[0]) < RECURRENCE)
    return (points[: back[0] + 1], True) if back.size else (points, False)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map; bold points mark the attractor, as in the paper."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    mark_orbit(ax, data.attractor, ms=2.6)


def caption(data: Data) -> str:
    """Describe the picture; say what the attractor is."""
    kind = (
        f"periodic: it recurs to {RECURRENCE:g} after {data.attractor.size} global stick phases, "
        f"with the multiplier {data.multiplier:.3g}; the paper calls it non-periodic"
        if data.periodic
        else f"{data.attractor.size} points, none of which recurs to {RECURRENCE:g}"
    )
    p = data.model.parameters
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}, "
        f"V = {p['V']:.4f}. Bold points: the attractor that follows S4 after its collision with "
        f"the jump, {kind}."
    )
