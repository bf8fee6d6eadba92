"""Scratch arrays of the steppers of n blocks (one class for all laws)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.blocks.system import Floats, Ints

Rows = NDArray[np.float64]


class BlockWork(NamedTuple):
    """Series of one step and what is searched in them."""

    x: Rows
    w: Rows
    e: Floats  # one needed force
    rows: Rows  # (n, rows of a law, order + 1)
    cosine: Floats  # of the forcing's phase, as sine
    sine: Floats
    d_x: Rows  # of one tangent, as d_w
    d_w: Rows
    rates: Floats  # w' at the end of a step
    deviation: Floats  # from steady sliding
    factor: Rows
    active: Ints  # blocks that slip: the first n_active[0]
    n_active: Ints
    margin: Floats
    watch: Floats


def new_block_work(n_blocks: int, n_rows: int, order: int) -> BlockWork:
    """Scratch arrays for one motion."""
    n, size = n_blocks, order + 1
    return BlockWork(
        x=np.zeros((n, size)),
        w=np.zeros((n, size)),
        e=np.zeros(size),
        rows=np.zeros((n, n_rows, size)),
        cosine=np.zeros(size),
        sine=np.zeros(size),
        d_x=np.zeros((n, size)),
        d_w=np.zeros((n, size)),
        rates=np.zeros(n),
        deviation=np.zeros(n),
        factor=np.zeros((n, n)),
        active=np.zeros(n, dtype=np.int64),
        n_active=np.zeros(1, dtype=np.int64),
        margin=np.full(1, np.inf),
        watch=np.zeros(1),
    )
