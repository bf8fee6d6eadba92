"""Slips as objects: blocks that move over the belt together, told apart from the others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from stickslip.mechanics.model.plant import Plant
from stickslip.numerics.arrays import Floats, Ints
from stickslip.results.parts import part


@part
class Slip(NamedTuple):
    """Blocks that slip together: coupled ones, at times that overlap.

    ``start``, ``duration`` in units of sqrt(m / k); ``blocks`` that slipped, counted from 1;
    ``moment``: how far the belt left the blocks behind, summed over them, units of f_s1 / k.
    """

    start: float
    duration: float
    blocks: tuple[int, ...]
    moment: float


@dataclass
class _Growing:
    """A slip that goes on: blocks that move now, all that did, the moment of those at rest."""

    start: Any
    moving: set[int] = field(default_factory=set)
    blocks: set[int] = field(default_factory=set)
    moment: Any = 0.0


class SlipTracker:
    """Joins changes of mode to slips while a motion goes on; holds no more than the open ones."""

    # Slips that had begun before the start are left out: contacts that moved there, with `w`, the
    # relative velocities. One at rest beyond its limit is let go, and its slip begins. Times and
    # travels are numbers, or arrays of a number and its derivatives.

    def __init__(self, plant: Plant, w: Floats) -> None:
        m = plant.n_contacts
        self._neighbours = plant.neighbours
        self._mode = np.zeros(m, dtype=np.int64)
        self._left: list[Any] = [0.0] * m  # how far the belt had left each behind at the start
        self._slip: dict[int, _Growing] = {}  # of each moving block
        self._moved_before = w != 0.0

    def see(self, t: Any, travel: Sequence[Any] | Floats, mode: Ints) -> Iterator[Slip]:
        """Take time and ``Plant.travel`` as a step begins; yield the slips that are over."""
        moved, moves = self._mode != 0, mode != 0
        for block in np.flatnonzero(moves & ~moved).tolist():
            self._begin(block, t, travel[block])
        self._moved_before[:] = False
        for block in np.flatnonzero(moved & ~moves).tolist():
            slip = self._slip.pop(block)
            slip.moving.remove(block)
            slip.moment = slip.moment + (travel[block] - self._left[block])
            if not slip.moving and _time(slip.start) > -math.inf:
                blocks = tuple(k + 1 for k in sorted(slip.blocks))
                yield Slip(slip.start, t - slip.start, blocks, slip.moment)
        self._mode = mode.copy()

    def _begin(self, block: int, t: Any, travel: Any) -> None:
        """Let a block join the slips of its neighbours, which are one from now on."""
        self._left[block] = travel
        slip = _Growing(-math.inf if self._moved_before[block] else t, {block}, {block})
        self._slip[block] = slip
        beside = (self._slip.get(k) for k in self._neighbours[block])
        for other in {id(found): found for found in beside if found is not None}.values():
            slip.start = min(slip.start, other.start, key=_time)
            slip.moving |= other.moving
            slip.blocks |= other.blocks
            slip.moment = slip.moment + other.moment
            self._slip.update(dict.fromkeys(other.moving, slip))


def _time(start: Any) -> float:
    """Return the time itself, without its derivatives."""
    return start if isinstance(start, float) else float(start[0])
