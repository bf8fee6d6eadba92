"""Infinitely unstable orbits: periodic orbits of a map with its jumps filled in.

One point is a jump d, its image any value y between f(d-) and f(d+) with f^(p-1)(y) = d. The
solutions y are known already: they are the ends of pieces of f^p that meet the jump after
p - 1 maps.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.discontinuities import Unresolved
from stickslip.analysis.maps.protocol import sample
from stickslip.analysis.orbits.orbit import JumpCrossing, PeriodicOrbit

if TYPE_CHECKING:
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.branches.laps import Indices
    from stickslip.analysis.branches.pieces import Pieces
    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Floats

SAME: Final = 1e-12  # of the scale: solutions that coincide, or lie on an end of the jump
ROUNDING: Final = 4 * float(np.finfo(np.float64).eps)  # of the scale: of one evaluation


def orbits_through_jumps(
    pieces: Pieces, table: BranchTable
) -> tuple[list[PeriodicOrbit], list[Unresolved]]:
    """Find the infinitely unstable orbits of one period; unresolved where on an end of a jump."""
    slack = SAME * max(abs(end) for end in table.f.domain)
    crossings: list[tuple[Breakpoint, Floats, Indices]] = []
    unresolved: list[Unresolved] = []
    for number, jump in enumerate(table.breakpoints):
        if jump.kind != "jump":
            continue
        low, high = sorted((jump.left, jump.right))
        for path, word in _ways_to(pieces, number, slack):
            if min(abs(path[0] - low), abs(path[0] - high)) <= slack:
                reason = "an orbit is on an end of the jump"
                unresolved.append(Unresolved(reason, jump.d, jump.d, len(path)))
            elif low < path[0] < high:
                crossings.append((jump, path, word))
    # All points in the map's order, the jump first, evaluated together.
    points = np.array([np.roll(path, 1) for _, path, _ in crossings])
    values = sample(table.f, points.reshape(len(crossings), pieces.power)[:, 1:])
    orbits = [
        _orbit(table, jump, path, word, values.value[k], values.derivative[k])
        for k, (jump, path, word) in enumerate(crossings)
    ]
    return orbits, unresolved


def _ways_to(pieces: Pieces, number: int, slack: float) -> list[tuple[Floats, Indices]]:
    """Orbits of p points that end on a break, and the laps of all points but the last."""
    p = pieces.power
    found: list[tuple[Floats, Indices]] = []
    for ends in (pieces.left, pieces.right):
        for k in np.flatnonzero((ends.number == number) & (ends.depth == p - 1)):
            found.append((ends.orbit[k, :p], pieces.word[k, : p - 1]))
    found.sort(key=lambda way: float(way[0][0]))
    # Two neighbouring pieces share each end.
    return [
        way
        for k, way in enumerate(found)
        if k == 0 or float(way[0][0] - found[k - 1][0][0]) > slack
    ]


def _orbit(
    table: BranchTable,
    jump: Breakpoint,
    path: Floats,
    word: Indices,
    images: Floats,
    slopes: Floats,
) -> PeriodicOrbit:
    """Describe the orbit d, y, f(y), ..., with f of its last point d."""
    points = np.roll(path, 1)
    residual = np.abs(images - np.roll(points, -1)[1:])
    error = _errors(slopes, residual, ROUNDING * max(map(abs, table.f.domain)))
    labels = table.labels_at(points)
    texts = [table.text(int(label)) for label in labels]
    texts[0] = f"{table.text(jump.left_label)} | {table.text(jump.right_label)}"
    crossing = JumpCrossing(
        d=jump.d,
        y=float(path[0]),
        share=float((path[0] - jump.left) / (jump.right - jump.left)),
        rising=bool((jump.right > jump.left) == (table.pieces.direction[word].prod() > 0)),
    )
    start = int(np.argmin(points))
    return PeriodicOrbit(
        points=np.roll(points, -start),
        period=len(points),
        multiplier=math.inf,
        stable=False,
        itinerary=tuple(texts[start:] + texts[:start]),
        labels=np.roll(labels, -start),
        quality="located",
        interval=np.roll(points[:, None] + error[:, None] * np.array([-1.0, 1.0]), -start, axis=0),
        residual=float(residual.max(initial=0.0)),
        jump=crossing,
        system=table.f,
    )


def _errors(slopes: Floats, residual: Floats, rounding: float) -> Floats:
    """Errors of the points, from the jump backwards: each map divides by its slope."""
    error = np.zeros(len(slopes) + 1)
    error[0] = after = rounding
    for k in range(len(slopes) - 1, -1, -1):
        after = (after + residual[k] + rounding) / abs(slopes[k]) if slopes[k] != 0 else math.inf
        error[k + 1] = after
    return error
