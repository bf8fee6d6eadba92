"""What goes into the event map's kernels besides a motion, and what comes out of them.

One class for all engines, not part of a template: numba would look its type up slowly.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.blocks.system import BlockDirections, BlockMotion
from stickslip.mechanics.flow.blocks.work import BlockWork
from stickslip.mechanics.flow.system import Floats, Motion


class Controls(NamedTuple):
    """Tolerance of the adaptive engine and the limits of a motion."""

    rtol: float
    max_events: int
    max_time: float


class Outputs(NamedTuple):
    """What a motion leaves, an entry for each start; of n > 2 blocks `value` is (m, n - 1)."""

    value: Floats
    derivative: Floats  # (m, columns), (m, n - 1, columns)
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]


class Scratch(NamedTuple):
    """Arrays of one thread."""

    motion: Motion
    long_motion: Motion  # twin with the columns of a loop
    saved: Motion
    work: Any  # of the engine


class Pools(NamedTuple):
    """Three pools of motions (`flow.lanes.layout`), and arrays for the one at an event."""

    laws: Floats  # parameter rows of `friction.series`
    x: Floats  # (3, KEPT): numbers of the motions
    taken: Floats  # (SIZE,): the step taken last, of one of the pools
    tags: NDArray[np.int64]  # (3, places, 4), as labels: `Tags`
    labels: NDArray[np.uint64]
    counts: NDArray[np.int64]  # motions in each pool
    flagged: NDArray[np.int64]  # lanes with an event
    rows: NDArray[np.int64]  # that may go on
    motion: Motion
    w: Floats
    e: Floats
    signal: Floats
    reciprocals: Floats  # 1 / k


class Tags(NamedTuple):
    """What a motion in a pool is known by: its row, events so far, modes, last event, label."""

    row: int
    n_events: int
    code: int
    before: int
    label: np.uint64


class Clock(NamedTuple):
    """What a motion in a pool adds up: steps, time of its earlier phases, smallest margin."""

    steps: float
    duration: float
    margin: float


class BlockScratch(NamedTuple):
    """Arrays of one thread for n blocks; as `Scratch`."""

    motion: BlockMotion
    directions: BlockDirections
    long_motion: BlockMotion
    long_directions: BlockDirections
    saved: BlockMotion
    work: BlockWork


def new_outputs(shape: tuple[int, ...], n_columns: int) -> Outputs:
    """Arrays for what the motions from points of that shape leave."""
    n = shape[0]
    return Outputs(
        value=np.full(shape, np.nan),
        derivative=np.full((*shape, n_columns), np.nan),
        duration=np.zeros(n),
        n_events=np.zeros(n, dtype=np.int64),
        label=np.zeros(n, dtype=np.uint64),
        margin=np.full(n, np.inf),
        status=np.zeros(n, dtype=np.int64),
    )
