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
    power: Floats  # (n, n), as the next
    spare: Floats
    unit: Floats  # (n,): of each number, so that what it does to others weighs what they do to it


def new_loop(n: int) -> Loop:
    """Arrays for states of n numbers."""
    turn, power, spare = np.zeros((3, n, n))
    return Loop(np.zeros(n), np.zeros(n), turn, power, spare, np.ones(n))


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
def balance(loop: Loop) -> None:
    """Choose units in which rows and columns of the turn are alike: its powers tell more then."""
    turn, unit = loop.turn, loop.unit
    unit[:] = 1.0
    for _ in range(4):  # more change little
        for j in range(unit.shape[0]):
            row = column = 0.0
            for k in range(unit.shape[0]):
                if k != j:
                    row += abs(turn[j, k])
                    column += abs(turn[k, j])
            if row > 0.0 and column > 0.0:
                factor = math.sqrt(row / column)
                unit[j] *= factor
                for k in range(unit.shape[0]):
                    turn[j, k] /= factor
                    turn[k, j] *= factor
    for j in range(unit.shape[0]):
        loop.earlier[j] /= unit[j]
        loop.moved[j] /= unit[j]


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
    balance(loop)
    earlier, moved, turn, power, spare, unit = loop
    size, bend = largest(earlier), 0.0
    for j in range(moved.shape[0]):
        straight = moved[j]
        for k in range(moved.shape[0]):
            straight -= turn[j, k] * earlier[k]
        bend = max(bend, abs(straight))
        if earlier[j] == 0.0 and moved[j] != 0.0:
            return math.inf  # not at the same events: the turn has no tangent in j
    # The sum of the norms of T^n, n < 2 q, is at most 1 + |T^q| times that for n < q.
    for j in range(moved.shape[0]):
        earlier[j] = 0.0
        for k in range(moved.shape[0]):
            power[j, k] = turn[j, k]
    norm, powers = row_norm(power), 1.0
    for _ in range(SQUARINGS):
        powers *= 1.0 + norm
        if norm <= 0.5:
            break
        product(power, power, spare)
        power, spare = spare, power
        norm = row_norm(power)
    if not (norm <= 0.5 and room > 0.0):
        return math.inf
    powers /= 1.0 - norm * norm
    # How far straight turns lead at most, and in the end: to their fixed point.
    reach, rest, way, most = 0.0, math.inf, 0.0, largest(unit)
    for _ in range(TURNS):
        add_turn(loop)
        reach, rest = max(reach, largest(earlier)), powers * largest(moved)
        for j in range(moved.shape[0]):
            way = max(way, abs(unit[j] * earlier[j]))
        if rest <= REST * reach and most * rest <= REST * way:
            break
    reach, way = reach + rest, way + most * rest
    # Turns that bend, with a second derivative of 2 bend / size^2, change T on the way: they do
    # contract if that, times the sum of all powers' norms, is below 1, and lead up to twice as far.
    bent = 2.0 * powers * bend * reach / (size * size) if bend > ROUNDING else 0.0
    return max(bent, 4.0 * way / (room * (1.0 + math.sqrt(max(0.0, 1.0 - bent)))))
