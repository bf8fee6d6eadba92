"""Slips as objects: blocks that move over the belt together, told apart from the others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

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

    start: float
    moving: set[int] = field(default_factory=set)
    blocks: set[int] = field(default_factory=set)
    moment: float = 0.0


class SlipTracker:
    """Joins changes of mode to slips while a motion goes on; holds no more than the open ones."""

    # Slips that had begun before the start are left out, unless it is `from_belt`.

    def __init__(self, plant: Plant, *, from_belt: bool) -> None:
        m = plant.n_contacts
        self._plant = plant
        self._mode = np.zeros(m, dtype=np.int64)
        self._left: list[float] = [0.0] * m  # how far the belt had left each behind at the start
        self._slip: dict[int, _Growing] = {}  # of each moving block
        self._unknown = not from_belt

    def see(self, t: float, x: Floats, mode: Ints) -> Iterator[Slip]:
        """Take the state as a step begins; yield the slips that are over by then."""
        moved, moves = self._mode != 0, mode != 0
        travel = self._plant.travel(x, t)
        for block in np.flatnonzero(moves & ~moved).tolist():
            self._begin(block, t, float(travel[block]))
        self._unknown = False
        for block in np.flatnonzero(moved & ~moves).tolist():
            slip = self._slip.pop(block)
            slip.moving.remove(block)
            slip.moment += float(travel[block]) - self._left[block]
            if not slip.moving and slip.start > -math.inf:
                blocks = tuple(k + 1 for k in sorted(slip.blocks))
                yield Slip(slip.start, t - slip.start, blocks, slip.moment)
        self._mode = mode.copy()

    def _begin(self, block: int, t: float, travel: float) -> None:
        """Let a block join the slips of its neighbours, which are one from now on."""
        self._left[block] = travel
        slip = _Growing(-math.inf if self._unknown else float(t), {block}, {block})
        self._slip[block] = slip
        beside = (self._slip.get(k) for k in self._plant.neighbours[block])
        for other in {id(found): found for found in beside if found is not None}.values():
            slip.start = min(slip.start, other.start)
            slip.moving |= other.moving
            slip.blocks |= other.blocks
            slip.moment += other.moment
            self._slip.update(dict.fromkeys(other.moving, slip))
