"""Scratch arrays of the steppers of n blocks (one class for all laws)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.blocks.system import Floats, Ints

Rows = NDArray[np.float64]


class BlockWork(NamedTuple):
    """Series of one step and what is searched in them.

    ``x``, ``w`` (n, order + 1): displacements and relative velocities; ``e``: one needed
    force; ``rows`` (n, rows of a law, order + 1); ``cosine``, ``sine``: of the forcing's phase;
    ``d_x``, ``d_w``: of one tangent; ``rates``: w' at the end of a step; ``deviation``: from
    steady sliding; ``factor`` (n, n): of a matrix; ``active``: blocks that slip, the first of
    ``n_active[0]``. ``margin``, ``watch``: as in the exact engine.
    """

    x: Rows
    w: Rows
    e: Floats
    rows: Rows
    cosine: Floats
    sine: Floats
    d_x: Rows
    d_w: Rows
    rates: Floats
    deviation: Floats
    factor: Rows
    active: Ints
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
