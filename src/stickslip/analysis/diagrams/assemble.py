"""The orbits of a surveyed range as curves: each from where it begins to where it ends."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.scan.events import orbit_at
from stickslip.analysis.diagrams.at_values import SampledOrbit
from stickslip.analysis.orbits.newton import turn_towards

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.scan.events import Event
    from stickslip.analysis.bifurcations.scan.nodes import Family, Node
    from stickslip.analysis.bifurcations.scan.survey import Span, Survey
    from stickslip.analysis.bifurcations.scan.tracking import Piece
    from stickslip.analysis.maps.protocol import Floats

ROOTS: Final = ("fold", "flip", "standstill", "doubling")  # where points move like a square root
CLOSE: Final = 0.05  # of the domain's width: how far an orbit may be from the event that ends it


@dataclass(frozen=True, eq=False)
class OrbitCurveEnd:
    """Where an orbit begins or ends.

    Attributes
    ----------
    value : float
        Of the parameter.
    points : ndarray of float, shape (p,)
        The orbit there, as far as it is known.
    reason : str
        "end of range", "fold", "flip", "border_collision", "enters_gap", "outside" (it leaves
        the window), or how an orbit ends that no event explains.
    """

    value: float
    points: Floats
    reason: str


@dataclass(frozen=True, eq=False)
class Traced:
    """An orbit with both ends, the lower first."""

    sampled: SampledOrbit
    ends: tuple[OrbitCurveEnd, OrbitCurveEnd]


@dataclass
class _Open:
    """An orbit that still grows: samples in ascending order of the parameter."""

    start: str
    values: list[float] = field(default_factory=list)
    points: list[Floats] = field(default_factory=list)
    multipliers: list[float] = field(default_factory=list)

    def add(self, values: Floats, points: Floats, multipliers: Floats) -> None:
        """Append samples, turned so that each column goes on with the same point."""
        if self.points:
            points = np.roll(points, -turn_towards(points[0], self.points[-1]), axis=1)
        for q, x, multiplier in zip(values, points, multipliers, strict=True):
            if not self.values or q > self.values[-1]:
                self.values.append(float(q))
                self.points.append(x)
                self.multipliers.append(float(multiplier))

    def closed(self, reason: str) -> Traced:
        """Finish the orbit."""
        values, points = np.array(self.values), np.array(self.points)
        roots = (self.start in ROOTS, reason in ROOTS)
        sampled = SampledOrbit(values, points, np.array(self.multipliers), roots)
        return Traced(
            sampled,
            (
                OrbitCurveEnd(float(values[0]), points[0], self.start),
                OrbitCurveEnd(float(values[-1]), points[-1], reason),
            ),
        )


def trace_orbits(survey: Survey) -> list[Traced]:
    """Link what a survey found between its values: by period, then by lower end and place."""
    done: list[Traced] = []
    first = survey.spans[0].left
    growing = {k: _begun(first, k, "end of range") for k in range(len(first.orbits))}
    for span in survey.spans:
        pieces = [*span.pieces, *(ending.piece for ending in span.endings)]
        arrived: dict[int, _Open] = {}
        for piece in pieces:
            sampled = _grown(growing, piece, _reason(span, piece))
            if piece.right is not None:
                arrived[piece.right] = sampled
            else:
                done.append(sampled.closed(_reason(span, piece)))
        for k in span.loose_left:
            sampled = growing.pop(k) if k in growing else _begun(span.left, k, "unexplained")
            done.append(_ended(sampled, span, survey.family))
        for k in span.loose_right:
            arrived[k] = _born(span, k, survey.family)
        growing = arrived
    done += [sampled.closed("end of range") for sampled in growing.values()]
    return sorted(done, key=lambda t: (t.sampled.period, t.ends[0].value, t.sampled.points[0, 0]))


def _begun(node: Node, k: int, reason: str) -> _Open:
    orbit, sampled = node.orbits[k], _Open(reason)
    sampled.add(np.array([node.q]), orbit.points[None], np.array([orbit.multiplier]))
    return sampled


def _grown(growing: dict[int, _Open], piece: Piece, reason: str) -> _Open:
    """Append a piece to the orbit that it continues, or begin one with it."""
    sampled = None if piece.left is None else growing.pop(piece.left, None)
    sampled = _Open(reason) if sampled is None else sampled
    sampled.add(piece.values, piece.points, piece.multipliers)
    return sampled


def _reason(span: Span, piece: Piece) -> str:
    """Why a piece ends inside a span."""
    return next(
        (e.event.kind if e.event else e.reason for e in span.endings if e.piece is piece),
        "unexplained",
    )


def _ended(sampled: _Open, span: Span, family: Family) -> Traced:
    """Lead an orbit up to the event in a span, and end it there."""
    event, points = _event_at(span, sampled.points[-1], family)
    if event is None:
        return sampled.closed("unexplained")
    if points is not None:
        multiplier = _multiplier_at(event, sampled.multipliers[-1])
        sampled.add(np.array([event.value]), points[None], np.array([multiplier]))
    return sampled.closed(event.kind)


def _born(span: Span, k: int, family: Family) -> _Open:
    """Begin an orbit at the event in a span."""
    orbit = span.right.orbits[k]
    event, points = _event_at(span, orbit.points, family)
    sampled = _Open("unexplained" if event is None else event.kind)
    if event is not None and points is not None:
        multiplier = _multiplier_at(event, orbit.multiplier)
        sampled.add(np.array([event.value]), points[None], np.array([multiplier]))
    sampled.add(np.array([span.right.q]), orbit.points[None], np.array([orbit.multiplier]))
    return sampled


def _event_at(span: Span, points: Floats, family: Family) -> tuple[Event | None, Floats | None]:
    """Choose the event of a span that an orbit ends at, and the orbit's points there."""
    best, best_gap, best_points = None, CLOSE * span.left.width, None
    for event in span.events:
        there = orbit_at(event, points, family)
        if there is None:
            continue
        gap = float(np.abs(there - points).max())
        if gap < best_gap:
            best, best_gap, best_points = event, gap, there
    if best is None and span.events:
        return span.events[0], None
    return best, best_points


def _multiplier_at(event: Event, beside: float) -> float:
    """Multiplier of an orbit that ends in an event, from its multiplier just beside."""
    return 1.0 if event.kind in ("fold", "flip", "transcritical", "pitchfork") else beside
