"""Slips as objects: blocks that move over the belt together, told apart from the others."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from stickslip.mechanics.model.structure import Structure
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

    def __init__(self, structure: Structure, *, from_belt: bool) -> None:
        n = structure.n_blocks
        coupled = (structure.stiffness != 0.0) | (structure.damping != 0.0)
        self._neighbours = [
            np.flatnonzero(row).tolist() for row in coupled & ~np.eye(n, dtype=bool)
        ]
        self._V = structure.V
        self._mode = np.zeros(n, dtype=np.int64)
        self._left: list[float] = [0.0] * n  # belt position less displacement at the start
        self._slip: dict[int, _Growing] = {}  # of each moving block
        self._unknown = not from_belt

    def see(self, t: float, x: Floats, mode: Ints) -> Iterator[Slip]:
        """Take the state as a step begins; yield the slips that are over by then."""
        moved, moves = self._mode != 0, mode != 0
        for block in np.flatnonzero(moves & ~moved).tolist():
            self._begin(block, t, x)
        self._unknown = False
        for block in np.flatnonzero(moved & ~moves).tolist():
            slip = self._slip.pop(block)
            slip.moving.remove(block)
            slip.moment += self._V * t - float(x[block]) - self._left[block]
            if not slip.moving and slip.start > -math.inf:
                blocks = tuple(k + 1 for k in sorted(slip.blocks))
                yield Slip(slip.start, t - slip.start, blocks, slip.moment)
        self._mode = mode.copy()

    def _begin(self, block: int, t: float, x: Floats) -> None:
        """Let a block join the slips of its neighbours, which are one from now on."""
        self._left[block] = self._V * t - float(x[block])
        slip = _Growing(-math.inf if self._unknown else float(t), {block}, {block})
        self._slip[block] = slip
        beside = (self._slip.get(k) for k in self._neighbours[block])
        for other in {id(found): found for found in beside if found is not None}.values():
            slip.start = min(slip.start, other.start)
            slip.moving |= other.moving
            slip.blocks |= other.blocks
            slip.moment += other.moment
            self._slip.update(dict.fromkeys(other.moving, slip))
