"""Lists just beside events: which orbits these concern, and whether they add up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision, SteepFlip
from stickslip.analysis.bifurcations.conditions.locate import NEARBY
from stickslip.analysis.bifurcations.normal_forms import flip_coefficient
from stickslip.analysis.bifurcations.scan.events import Suspect
from stickslip.analysis.orbits.newton import turned

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange
    from stickslip.analysis.bifurcations.scan.events import Event
    from stickslip.analysis.bifurcations.scan.nodes import Node
    from stickslip.analysis.bifurcations.scan.tracking import Piece, Span
    from stickslip.analysis.orbits.orbit import PeriodicOrbit


TRUST: Final = 0.5  # of the way from a fold to a flip: how well that is foretold
PARENT: Final = 1e-3  # of the domain: how far the orbit that flips may be from where it does


@dataclass(frozen=True, eq=False)
class Concerned:
    """The orbits that an event concerns, by their places in the lists beside it."""

    before: tuple[int, ...]  # those that persist included
    after: tuple[int, ...]
    lost: tuple[int, ...]  # of `before`, those that do not cross the span; `born` likewise
    born: tuple[int, ...]


def concerned_orbits(span: Span) -> tuple[list[Concerned], list[UnresolvedChange]]:
    """Share out the orbits that do not cross a span among its events; the rest stays open."""
    lost = _shared_out(span, span.left, span.loose_left)
    born = _shared_out(span, span.right, span.loose_right)
    result, unresolved = [], []
    for event, gone, new in zip(span.events, lost, born, strict=True):
        before, after = set(gone), set(new)
        if event.kind == "flip":
            parents = _parents(event, span)
            before, after = before | parents[0], after | parents[1]
        # A list in the very middle of an event, at an end of the range, shows neither side.
        middle = any(event.is_at(node.q) for node in (span.left, span.right))
        orbits = [span.left.orbits[k] for k in gone], [span.right.orbits[k] for k in new]
        if not middle and not _adds_up(event, *orbits, span):
            reason = f"the orbits beside the {event.kind.replace('_', ' ')} do not add up"
            unresolved.append(span.open(reason, event.period, event.points, event.points))
        result.append(
            Concerned(tuple(sorted(before)), tuple(sorted(after)), tuple(gone), tuple(new))
        )
    return result, unresolved


def adds_up(span: Span) -> bool:
    """Whether the events of a span explain all orbits that do not cross it."""
    return all(change.is_outside for change in concerned_orbits(span)[1])


def flips_at_folds(span: Span) -> Iterator[Suspect]:
    """Suspect flips between folds and the lists beside these, as the orbits' multipliers foretell.

    These leave 1 in proportion to the orbit's way from the fold, the root of the parameter's.
    """
    for node, places in ((span.left, span.loose_left), (span.right, span.loose_right)):
        for event, share in zip(span.events, _shared_out(span, node, places), strict=True):
            for orbit in node.select(share) if event.kind == "fold" else ():
                if orbit.multiplier < -1 and orbit.period == event.period:
                    part = 2 / (1 - orbit.multiplier)
                    start = turned(event.points, orbit.points)
                    points = start + part * (orbit.points - start)
                    way = part**2 * (node.q - event.value)
                    flip = SteepFlip(event.period, tuple(points.tolist()))
                    reach = max(TRUST * abs(way), NEARBY * math.ulp(event.value))
                    yield Suspect(flip, event.value + way, reach)


def _shared_out(span: Span, node: Node, places: list[int]) -> list[list[int]]:
    """Give each orbit to the event that it comes closest to."""
    shares: list[list[int]] = [[] for _ in span.events]
    for k in places:
        orbit = node.orbits[k]
        distance = [
            # Nothing begins at a flip but doubled orbits.
            math.inf
            if event.kind == "flip" and orbit.period != 2 * event.period
            else np.abs(orbit.points[:, None] - event.points).min()
            for event in span.events
        ]
        shares[int(np.argmin(distance))].append(k)
    return shares


def _parents(event: Event, span: Span) -> tuple[set[int], set[int]]:
    """Places of the orbit that flips, in both lists; in one beside a fold that is as close."""

    def off_event(piece: Piece) -> float:
        near = piece.points[np.argmin(np.abs(piece.values - event.value))]
        return float(np.abs(turned(event.points, near) - near).max())

    alike = (piece for piece in span.pieces if piece.period == event.period)
    passing = (one for one in alike if (one.multipliers[0] + 1) * (one.multipliers[-1] + 1) < 0)
    piece = min(passing, key=off_event, default=None)
    if piece is not None and piece.left is not None and piece.right is not None:
        return {piece.left}, {piece.right}  # in lists that may be as far away as those of a grid
    nodes, loose = (span.left, span.right), (span.loose_left, span.loose_right)
    # Beyond a fold that is as close, the other one of its two orbits may be nearer.
    places = [
        node.find(event.points, PARENT * node.width, lambda orbit: orbit.multiplier < 1)
        for node in nodes
    ]
    found = [set[int]() if place is None else {place} for place in places]
    ends = [place in one for place, one in zip(places, loose, strict=True)]
    if all(found) and ends[0] != ends[1]:
        # One of the two crosses the span, and the other does not: they are not one orbit.
        off = [
            np.abs(orbit.points - event.points).max()
            for node, place in zip(nodes, found, strict=True)
            for orbit in node.select(place)
        ]
        nearer = int(np.argmin(off))
        pairs = ((piece.left, piece.right) for piece in span.pieces)
        own = (pair[1 - nearer] for pair in pairs if pair[nearer] == places[nearer])
        found[1 - nearer] = {place for place in own if place is not None}
    return found[0], found[1]


def _adds_up(
    event: Event, orbits_lost: list[PeriodicOrbit], orbits_born: list[PeriodicOrbit], span: Span
) -> bool:
    """Check the orbits lost and born against what the kind of event allows."""
    lost, born = ([orbit.period for orbit in some] for some in (orbits_lost, orbits_born))
    smooth = event.kind in ("fold", "transcritical", "pitchfork", "flip")
    if smooth and any(orbit.multiplier < -1.0 for orbit in orbits_lost + orbits_born):
        # All begin with 1: a flip is as close, and must be known.
        flips = (other.period for other in span.events if other.kind == "flip")
        if event.kind != "fold" or event.period not in flips:
            return False
    if event.kind == "fold":
        pair = [event.period] * 2
        return sorted([lost, born]) == [[], pair]
    if event.kind in ("transcritical", "pitchfork"):
        # One of two crossing curves may lie outside the domain on one side.
        if set(lost + born) != {event.period} or not 2 <= max(len(lost), len(born)) <= 3:
            return False
        three = max(orbits_lost, orbits_born, key=len)
        return len(three) < 3 or _as_foretold(event, three)
    if event.kind == "flip":
        doubled = [2 * event.period]
        within = doubled[0] <= span.left.orbits.max_period
        # On a straight branch the doubled orbit is born on the break at its end, at that value.
        within &= not any(
            isinstance(other.condition, Collision) and other.period == doubled[0]
            for other in span.events
        )
        if sorted([lost, born]) != [[], doubled if within else []]:
            return not (lost or born) and _leaves_at_once(event, span)
        return not within or _as_foretold(event, orbits_lost + orbits_born)
    # Beyond a fold that is as close, the other one of two orbits is there.
    there = np.array(event.located.reading.multipliers) - 1.0
    same = (orbit for orbit in orbits_lost + orbits_born if orbit.period == event.period)
    folded = any((there * (orbit.multiplier - 1.0) < 0).all() for orbit in same)
    return bool(lost or born) and not folded


def _leaves_at_once(event: Event, span: Span) -> bool:
    """Whether a doubled orbit would be larger than the domain in both lists, u^2 = |m + 1| / |c|.

    So it is on straight branches and others without a cubic coefficient: it lives at the flip only.
    """
    f = span.left.f
    cubic = flip_coefficient(getattr(f, "whole", f), event.points)
    least = (abs(cubic.value) + cubic.error) * span.left.width**2
    lists = zip((span.left, span.right), _parents(event, span), strict=True)
    parents = [orbit for node, places in lists for orbit in node.select(places)]
    return all(abs(orbit.multiplier + 1) > least for orbit in parents)


def _as_foretold(event: Event, orbits: list[PeriodicOrbit]) -> bool:
    """Whether a flip's doubled orbit, or a pitchfork's three, attract as the normal form says.

    Those of a fold that is as close have the other stability.
    """
    attract = sum(orbit.multiplier < 1 for orbit in orbits)
    expected = (event.kind == "pitchfork") + (event.criticality == "super")
    return event.criticality is None or attract == expected
