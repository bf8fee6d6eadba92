"""Whether a motion that came near an earlier state goes round for ever (rule 6)."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from stickslip.mechanics.flow.system import Floats
from stickslip.numerics.targets import kernel

# Squarings of a turn's tangent within which it has to contract.
SQUARINGS = 10
# Turns within which a motion has to be nearly where they lead: as many.
TURNS = 2**SQUARINGS
# Share of the farthest way that later turns may add.
REST = 0.1
# The errors of a turn itself, in the units of states: a bend as small tells nothing.
ROUNDING = 1e-12


class Loop(NamedTuple):
    """Two turns of a motion: how far each moves the state, and the tangent of the second."""

    earlier: Floats  # (n,)
    moved: Floats  # (n,)
    turn: Floats  # (n, n)
    power: Floats  # (n, n), as the rest
    spare: Floats
    total: Floats


def new_loop(n: int) -> Loop:
    """Arrays for states of n numbers."""
    turn, power, spare, total = np.zeros((4, n, n))
    return Loop(np.zeros(n), np.zeros(n), turn, power, spare, total)


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
def product(one: Floats, other: Floats, result: Floats) -> None:
    """Multiply two matrices."""
    for j in range(one.shape[0]):
        for k in range(one.shape[0]):
            result[j, k] = 0.0
            for i in range(one.shape[0]):
                result[j, k] += one[j, i] * other[i, k]


@kernel
def add_turn(loop: Loop) -> None:
    """Add what a turn moves to ``earlier``, and turn that."""
    _, moved, turn, _, spare, _ = loop
    for j in range(moved.shape[0]):
        loop.earlier[j] += moved[j]
        spare[0, j] = 0.0
        for k in range(moved.shape[0]):
            spare[0, j] += turn[j, k] * moved[k]
    for j in range(moved.shape[0]):
        moved[j] = spare[0, j]


@kernel
def excess(loop: Loop, room: float) -> float:
    """How many times too far apart two turns are to contract within half a room; inf: or grow."""
    earlier, moved, turn, power, spare, total = loop
    size, bend = largest(earlier), 0.0
    for j in range(moved.shape[0]):
        straight = moved[j]
        for k in range(moved.shape[0]):
            straight -= turn[j, k] * earlier[k]
        bend = max(bend, abs(straight))
        if earlier[j] == 0.0 and moved[j] != 0.0:
            return math.inf  # not at the same events: the turn has no tangent in j
    # The sum of the powers T^n, n < 2 q, and T^q: doubled until that is small.
    for j in range(moved.shape[0]):
        earlier[j] = 0.0
        for k in range(moved.shape[0]):
            power[j, k] = turn[j, k]
            total[j, k] = 1.0 if j == k else 0.0
    norm = row_norm(power)
    for _ in range(SQUARINGS):
        product(power, total, spare)
        for j in range(moved.shape[0]):
            for k in range(moved.shape[0]):
                total[j, k] += spare[j, k]
        if norm <= 0.5:
            break
        product(power, power, spare)
        power, spare = spare, power
        norm = row_norm(power)
    if not (norm <= 0.5 and room > 0.0):
        return math.inf
    inverse = row_norm(total) / (1.0 - norm * norm)  # bounds 1 / (1 - T)
    # How far straight turns lead at most, and in the end: to their fixed point.
    reach, rest = 0.0, math.inf
    for _ in range(TURNS):
        add_turn(loop)
        reach, rest = max(reach, largest(earlier)), inverse * largest(moved)
        if rest <= REST * reach:
            break
    reach, ahead = reach + rest, largest(earlier) + rest
    # Turns that bend, with a second derivative of 2 bend / size^2: where twice Kantorovich's number
    # is below 1 they have a fixed point hardly farther away, and contract on the way.
    bent = 4.0 * inverse * bend * ahead / (size * size) if bend > ROUNDING else 0.0
    return max(bent, 4.0 * reach / (room * (1.0 + math.sqrt(max(0.0, 1.0 - bent)))))
