"""What goes into the event map's kernels besides a motion, and what comes out of them.

Not part of the template: one class for all engines, or numba would look its type up by the
slow way at every call.
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
    """What a motion leaves, an entry (``derivative``: a row) for each starting point.

    Of n > 2 blocks ``value`` is (m, n - 1) and ``derivative`` (m, n - 1, columns).
    """

    value: Floats
    derivative: Floats
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]


class Scratch(NamedTuple):
    """Arrays of one thread: a motion, its twin with the columns of a loop, a saved state.

    ``work`` belongs to the engine.
    """

    motion: Motion
    long_motion: Motion
    saved: Motion
    work: Any


class Pools(NamedTuple):
    """Three pools of motions (`flow.lanes.layout`), and arrays for the one at an event.

    ``laws``: parameter rows of `friction.series`; ``x`` (3, KEPT): numbers of the motions;
    ``taken`` (SIZE of the law's steps,): the step that was taken last, of one of the pools;
    ``tags`` (3, places, 4), ``labels`` (3, places): `Tags`; ``counts`` (3,): motions in each pool;
    ``flagged``, ``rows``: lanes with an event, rows that may go on; ``w``, ``e``, ``signal``:
    polynomials of the step; ``reciprocals``: 1 / k.
    """

    laws: Floats
    x: Floats
    taken: Floats
    tags: NDArray[np.int64]
    labels: NDArray[np.uint64]
    counts: NDArray[np.int64]
    flagged: NDArray[np.int64]
    rows: NDArray[np.int64]
    motion: Motion
    w: Floats
    e: Floats
    signal: Floats
    reciprocals: Floats


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
