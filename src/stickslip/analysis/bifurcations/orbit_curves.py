"""The orbits of a surveyed range as curves: pieces between lists, joined through folds."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Collision
from stickslip.analysis.bifurcations.scan.events import Event, orbit_at
from stickslip.analysis.branches.along.tracked import DomainEnd
from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
from stickslip.analysis.continuation.orbit_follower import OrbitProblem
from stickslip.analysis.maps.protocol import Floats, sample
from stickslip.analysis.orbits.newton import turned

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from stickslip.analysis.bifurcations.scan.adding_up import Concerned
    from stickslip.analysis.bifurcations.scan.nodes import Node
    from stickslip.analysis.bifurcations.scan.survey import Survey
    from stickslip.analysis.bifurcations.scan.tracking import Piece, Span

Side: TypeAlias = Literal[-1, 1]
Port: TypeAlias = tuple[int, int, int]  # number of a node, place in its list, side: -1 down, 1 up

REASONS: Final[dict[str, str]] = {
    "border_collision": "breakpoint",
    "enters_gap": "gap",
    "flip": "period halves",
    "fold": "step limit",
    "transcritical": "crossing",
    "pitchfork": "crossing",
}


@dataclass(frozen=True, eq=False)
class Row:
    """An orbit at one value of the parameter; `event` if it is a fold or flip of its own."""

    value: float
    points: Floats
    multiplier: float
    event: Event | None = None


@dataclass(frozen=True, eq=False)
class Link:
    """What follows beyond a port: rows, then another orbit's port, or an end."""

    rows: tuple[Row, ...]
    to: Port | None
    event: Event | None = None
    reason: str = ""


@dataclass(eq=False)
class _Web:
    """All orbits of all lists, linked."""

    nodes: list[Node]
    links: dict[Port, Link] = field(default_factory=dict)

    def row(self, number: int, place: int) -> Row:
        """Return an orbit of a list as a row."""
        node = self.nodes[number]
        orbit = node.orbits[place]
        return Row(node.q, orbit.points, orbit.multiplier)

    def tie(self, one: Port, other: Port, *rows: Row) -> None:
        """Let two orbits be one, with rows between them."""
        self.links[one], self.links[other] = Link(rows, other), Link(rows[::-1], one)


def orbit_curves(survey: Survey, concerned: dict[int, list[Concerned]]) -> tuple[Curve, ...]:
    """Join all orbits of a survey to curves, once; ``concerned`` goes by the span's number."""
    with survey.joining:
        if survey.curves is None:
            ends = [span.right for span in survey.spans[-1:]]
            web = _Web([*(span.left for span in survey.spans), *ends])
            for number, span in enumerate(survey.spans):
                shares = list(zip(span.events, concerned.get(number, ()), strict=True))
                _link_pieces(web, number, span, shares)
                for event, share in shares:
                    _link_event(web, number, event, share, span.events)
            chains = _chains(web)
            chains.sort(key=lambda chain: (len(chain[1][0].points), chain[1][0].value))
            curves = [columns_of(rows) for _, rows, _ in chains]
            parts = zip(chains, curves, _seen_on(survey, curves), strict=True)
            survey.curves = tuple(_joined(survey, *part) for part in parts)
        return survey.curves


def _link_pieces(web: _Web, number: int, span: Span, shares: list[tuple[Event, Concerned]]) -> None:
    """Link orbits that cross a span; those that leave the window in it end there."""
    for piece in span.pieces:
        assert piece.left is not None
        assert piece.right is not None
        low, high = (number, piece.left, 1), (number + 1, piece.right, -1)
        web.tie(low, high, *_inner_rows(piece, shares))
    for ending in span.endings:
        rows = _rows(ending.piece)
        if ending.piece.left is not None:
            port = (number, ending.piece.left, 1)
            web.links.setdefault(port, Link(rows[1:], None, ending.event, ending.reason))
        elif ending.piece.right is not None:
            port = (number + 1, ending.piece.right, -1)
            web.links.setdefault(port, Link(rows[:-1][::-1], None, ending.event, ending.reason))


def _rows(piece: Piece) -> tuple[Row, ...]:
    samples = zip(piece.values, piece.points, piece.multipliers, strict=True)
    return tuple(Row(float(q), x, float(m)) for q, x, m in samples)


def _inner_rows(piece: Piece, shares: list[tuple[Event, Concerned]]) -> tuple[Row, ...]:
    """Return the samples between both lists; at a flip of the orbit, the flip itself."""
    for event, share in shares:
        flips = event.kind == "flip" and event.period == piece.period
        if flips and piece.left in share.before and piece.right in share.after:
            return (_at_flip(event, piece.points[0]),)
    return _rows(piece)[1:-1]


def _at_flip(event: Event, near: Floats) -> Row:
    return Row(event.value, turned(event.points, near), -1.0, event)


def _link_event(
    web: _Web, number: int, event: Event, share: Concerned, events: list[Event]
) -> None:
    """Link the orbits of a fold or crossing; let all others that do not cross end at the event."""
    below: list[Port] = [(number, place, 1) for place in share.lost]
    above: list[Port] = [(number + 1, place, -1) for place in share.born]
    ports = [*below, *above]
    own = all(len(web.row(n, k).points) == event.period for n, k, _ in ports)
    pairs: list[tuple[Port, Port]] = []
    if own and event.kind == "fold":
        pairs = [(side[0], side[1]) for side in (below, above) if len(side) == 2]
    elif own and event.kind in ("transcritical", "pitchfork"):
        # The upper orbit goes on as the lower one; of a pitchfork's three the middle one goes on.
        below, above = _by_place(web, below, event), _by_place(web, above, event)
        few, many = sorted((below, above), key=len)
        if (len(few), len(many)) == (2, 2):
            pairs = [(below[0], above[1]), (below[1], above[0])]
        elif (len(few), len(many)) == (1, 3):
            pairs = [(few[0], many[1]), (many[0], many[2])]
    row = Row(event.value, event.points, 1.0, event)
    web.links |= dict.fromkeys(ports, Link((), None, event))
    alike = (other for other in events if other.period == event.period)
    flips = [_at_flip(other, event.points) for other in alike if other.kind == "flip"]
    for one, other in pairs:
        passed = (flips if web.row(*port[:2]).multiplier < -1 else [] for port in (one, other))
        web.tie(one, other, *next(passed), row, *next(passed))


def _by_place(web: _Web, ports: list[Port], event: Event) -> list[Port]:
    """Return the ports of orbits, ascending by their point next to the event's first one."""

    def beside(port: Port) -> float:
        points = web.row(*port[:2]).points
        return float(turned(points, event.points)[0])

    return sorted(ports, key=beside)


# ------------------------------------------------------------------ from link to link

Chain: TypeAlias = "tuple[Link | None, list[Row], Link | None]"


def _chains(web: _Web) -> list[Chain]:
    """Follow links from every port that is an end; then the closed curves that remain."""
    seen: set[tuple[int, int]] = set()
    chains: list[Chain] = []
    orbits = [(n, k) for n, node in enumerate(web.nodes) for k in range(len(node.orbits))]
    for only_ends in (True, False):
        for orbit in orbits:
            for side in (-1, 1):
                link = web.links.get((*orbit, side))
                is_end = link is None or link.to is None
                if orbit not in seen and (is_end or not only_ends):
                    chains.append(_chain(web, (*orbit, side), seen))
    return chains


def _chain(web: _Web, port: Port, seen: set[tuple[int, int]]) -> Chain:
    """Walk away from a port, from orbit to orbit."""
    first = web.links.get(port)
    rows: list[Row] = []
    if first is not None and first.to is None:
        rows += first.rows[::-1]
    while True:
        number, place, side = port
        seen.add((number, place))
        rows.append(web.row(number, place))
        link = web.links.get((number, place, -side))
        if link is None:
            return first, rows, None
        rows += link.rows
        if link.to is None:
            return first, rows, link
        if link.to[:2] in seen:
            return first, rows, link
        port = link.to


# ------------------------------------------------------------------ as results


def columns_of(rows: Sequence[Row]) -> tuple[Floats, Floats]:
    """Values of the parameter, and the points, each orbit turned to be next to the one before."""
    points = [rows[0].points]
    for row in rows[1:]:
        points.append(turned(row.points, points[-1]))
    return np.array([row.value for row in rows]), np.array(points)


def _joined(
    survey: Survey, chain: Chain, curve: tuple[Floats, Floats], known: dict[str, Any]
) -> Curve:
    """Make a curve of rows and what lies at its ends."""
    first, rows, last = chain
    values, points = curve
    name = survey.family.name
    multipliers = np.array([row.multiplier for row in rows])
    passed = []
    for k, row in enumerate(rows):
        if (event := row.event) is not None:
            where = {name: row.value}, points[k], row.multiplier
            passed.append(CurveEvent(event.kind, *where, event.located.error, k))
    return Curve(
        kind="orbit",
        period=len(points[0]),
        parameters={name: values},
        points=points,
        multipliers=multipliers,
        stable=np.abs(multipliers) < 1,
        ends=(_end(survey, first, rows[0], points[0]), _end(survey, last, rows[-1], points[-1])),
        bifurcations=tuple(passed),
        data=known,
        problem=OrbitProblem(survey.family.at(rows[0].value)),
    )


def _seen_on(survey: Survey, curves: list[tuple[Floats, Floats]]) -> Iterator[dict[str, Any]]:
    """Yield columns of all curves; each map is asked once, for all that pass it."""
    if not curves:
        return
    q = np.concatenate([np.repeat(values, points.shape[1]) for values, points in curves])
    x = np.concatenate([points.ravel() for _, points in curves])
    label = np.zeros(x.size, dtype=np.uint64)
    value, margin = np.empty((2, x.size))
    order = np.argsort(q, kind="stable")
    for here in np.split(order, np.flatnonzero(np.diff(q[order])) + 1):
        got = sample(survey.family.at(q[here[0]]), x[here])
        label[here], value[here], margin[here] = got.label, got.value, got.margin
    start = 0
    for _, points in curves:
        own = slice(start, start := start + points.size)
        labels, images, room = (seen[own].reshape(points.shape) for seen in (label, value, margin))
        off = np.abs(images - np.roll(points, -1, axis=1))
        yield {"labels": labels, "margin": room.min(axis=1), "residual": off.max(axis=1)}


def _end(survey: Survey, link: Link | None, row: Row, points: Floats) -> CurveEnd:
    """Say why a curve ends."""
    name = survey.family.name
    here: Any = {name: row.value}, points, row.multiplier
    if link is None:
        at_end = row.value in (survey.lo, survey.hi)
        return CurveEnd("end of range" if at_end else "step limit", *here)
    if link.to is not None:
        return CurveEnd("closed", *here)
    event = link.event
    there = None if event is None else orbit_at(event, points, survey.family)
    if event is None or there is None:
        return CurveEnd(link.reason if link.reason == "end of domain" else "step limit", *here)
    reading, at = event.located.reading, {name: event.value}
    if not isinstance(reading.condition, Collision) or reading.critical is None:
        return CurveEnd(REASONS[event.kind], at, there, row.multiplier)
    border = reading.critical
    index = int(np.argmin(np.abs(there - border.x)))
    side = -1 if points[index] < border.x else 1
    multiplier = row.multiplier
    if len(there) == event.period:
        multiplier = reading.multipliers[0 if side < 0 else 1]
    left = isinstance(border.critical, DomainEnd)
    reason = "end of domain" if left else REASONS[event.kind]
    met: dict[str, Any] = {"index": index, "side": side, "border": border.critical}
    return CurveEnd(reason, at, there, multiplier, **met)
