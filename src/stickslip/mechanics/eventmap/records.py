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
    """What a motion leaves, an entry (``derivative``: a row) for each starting point."""

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


class BlockOutputs(NamedTuple):
    """As `Outputs`, for n blocks; ``value`` (m, n - 1), ``derivative`` (m, n - 1, columns)."""

    value: Floats
    derivative: Floats
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]


class BlockScratch(NamedTuple):
    """Arrays of one thread for n blocks; as `Scratch`."""

    motion: BlockMotion
    directions: BlockDirections
    long_motion: BlockMotion
    long_directions: BlockDirections
    saved: BlockMotion
    work: BlockWork
