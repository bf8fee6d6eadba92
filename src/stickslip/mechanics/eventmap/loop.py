"""Whether a motion that came near an earlier state goes round for ever (rule 6)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel

# Squarings of a turn's tangent within which it has to contract: 1024 turns.
SQUARINGS = 10
# The errors of a turn itself, in the units of states: a bend as small tells nothing.
ROUNDING = 1e-12


class Loop(NamedTuple):
    """Two turns of a motion: how far each moves the state, and the tangent of the second."""

    earlier: Floats  # (n,)
    moved: Floats  # (n,)
    turn: Floats  # (n, n)
    power: Floats  # (n, n)


def new_loop(n: int) -> Loop:
    """Arrays for states of n numbers."""
    return Loop(np.zeros(n), np.zeros(n), np.zeros((n, n)), np.zeros((n, n)))


@kernel
def largest(row: Floats) -> float:
    """Largest absolute entry."""
    size = 0.0
    for k in range(row.shape[0]):
        size = max(size, abs(row[k]))
    return size


@kernel
def row_norm(matrix: Floats) -> float:
    """Largest row sum of absolute entries; NaN if one is NaN."""
    norm = 0.0
    for j in range(matrix.shape[0]):
        row = 0.0
        for k in range(matrix.shape[1]):
            row += abs(matrix[j, k])
        norm = row if not row <= norm else norm
    return norm


@kernel
def add_image(matrix: Floats, row: Floats, spare: Floats) -> None:
    """Add ``matrix row`` to a row."""
    for j in range(row.shape[0]):
        spare[j] = 0.0
        for k in range(row.shape[0]):
            spare[j] += matrix[j, k] * row[k]
    for j in range(row.shape[0]):
        row[j] += spare[j]


@kernel
def square(matrix: Floats, result: Floats) -> None:
    """Multiply a matrix by itself."""
    for j in range(matrix.shape[0]):
        for k in range(matrix.shape[0]):
            result[j, k] = 0.0
            for i in range(matrix.shape[0]):
                result[j, k] += matrix[j, i] * matrix[i, k]


@kernel
def settles(loop: Loop, room: float) -> bool:
    """Whether turns of a loop contract within half the room that its itinerary leaves."""
    earlier, moved, turn, power = loop
    size, bend = largest(earlier), 0.0
    for j in range(moved.shape[0]):
        straight = moved[j]
        for k in range(moved.shape[0]):
            straight -= turn[j, k] * earlier[k]
        bend = max(bend, abs(straight))
    # Of powers T^n, n < q, and of T^q: the sum of norms is at most `total`, none is above
    # `highest`, and `moved` becomes the sum of what they move. Doubled until T^q is small.
    total = highest = 1.0
    norm = row_norm(turn)
    for _ in range(SQUARINGS):
        add_image(turn, moved, earlier)
        if norm <= 0.5:
            break
        total *= 1.0 + norm
        highest = max(highest, norm)
        square(turn, power)
        turn, power = power, turn
        norm = row_norm(turn)
    if not norm <= 0.5:
        return False
    ahead = largest(moved) / (1.0 - norm * norm)  # to the fixed point of the straight turn
    # Turns that bend, with a second derivative of 2 bend / size^2: where twice Kantorovich's number
    # is below 1 they have a fixed point hardly farther away, and contract on the way.
    bent = 0.0
    if bend > ROUNDING:
        bent = 4.0 * total * bend * ahead / ((1.0 - norm) * size * size)
    if bent > 1.0:
        return False
    return 2.0 * (1.0 + highest) * ahead / (1.0 + math.sqrt(1.0 - bent)) < 0.5 * room
