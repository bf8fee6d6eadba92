"""What kernels know of a model and of a motion: plain tuples and arrays."""

#     w_i' = -mode_i limit_i F(|w_i|) - e_i     (0 while riding), w = X' - V
#     e_1' = (1 + alpha) w_1 - alpha w_2 + V    (2 likewise), e = X + alpha (X - X_other)
#     d    = (e_2 - e_1) / (1 + 2 alpha)        see docs/theory/flow.md

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.targets import kernel

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

BACKWARD, STICK, FORWARD = -1, 0, 1

# Steps or events in zero time, for each block, after which the modes count as undecidable (rule 5).
MAX_INSTANT = 4

# What the end of a step brings to a block, besides nothing (0):
LANDING, AT_UPPER_LIMIT, AT_LOWER_LIMIT, LOST = 1, 2, 3, 4

# Entries of a row of `directions`: derivatives of alpha, beta, V, the starting d and, from
# LAWS on, the law parameters of block 1 and of block 2.
ALPHA, BETA, VELOCITY, START, LAWS = 0, 1, 2, 3, 4


class System(NamedTuple):
    """Parameters of two blocks (eqs. 5a-7a); the limits are 1 and `beta`."""

    alpha: float
    beta: float
    V: float


class Motion(NamedTuple):
    """One motion, changed in place by kernels; ``w``, ``e``, ``mode``, ``event``: one per block."""

    z: Floats  # (4,): w, then e, which are parts of it
    w: Floats
    e: Floats
    w_low: Floats  # what rounding left out, where an engine keeps it
    e_low: Floats
    mode: Ints
    event: Ints
    tangent_z: Floats  # (4, columns), a column for each row of directions
    tangent_w: Floats
    tangent_e: Floats
    directions: Floats  # (columns, LAWS + law parameters of both blocks)


class Phases(NamedTuple):
    """States at the starts of phases, an entry (n, 2) for each block."""

    w: NDArray[np.float64]
    e: NDArray[np.float64]
    mode: NDArray[np.int64]


def new_motion(n_columns: int, n_law_parameters: int) -> Motion:
    """Arrays for one motion with `n_columns` tangents."""
    z, tangent = np.zeros(4), np.zeros((4, n_columns))
    return Motion(
        z=z,
        w=z[:2],
        e=z[2:],
        w_low=np.zeros(2),
        e_low=np.zeros(2),
        mode=np.zeros(2, dtype=np.int64),
        event=np.zeros(2, dtype=np.int64),
        tangent_z=tangent,
        tangent_w=tangent[:2],
        tangent_e=tangent[2:],
        directions=np.zeros((n_columns, LAWS + 2 * n_law_parameters)),
    )


@kernel(inline=True)
def put_exactly(motion: Motion, block: int, w: float, e: float) -> None:
    """Give a block a state that is not rounded."""
    motion.w[block], motion.w_low[block] = w, 0.0
    motion.e[block], motion.e_low[block] = e, 0.0


@kernel(inline=True)
def limit(system: System, block: int) -> float:
    """Return the static limit of a block: 1 or beta."""
    return 1.0 if block == 0 else system.beta


@kernel(inline=True)
def loading_rate(system: System, w: Floats, block: int) -> float:
    """Rate e' of a block: how fast the force that it needs in order to ride grows."""
    return (1.0 + system.alpha) * w[block] - system.alpha * w[1 - block] + system.V


@kernel(inline=True)
def law_parameters(motion: Motion) -> int:
    """Count the friction parameters of one block in a row of `directions`."""
    return (motion.directions.shape[1] - LAWS) // 2


Rows = NDArray[np.float64]


class TaylorWork(NamedTuple):
    """Scratch of the engine."""

    w: Floats  # (2, ORDER + 1): series of the step, as e
    e: Floats
    rows: Rows  # series of each block's law
    signal: Floats  # the polynomial that is searched
    w_low: Floats  # what the first coefficients leave out
    e_low: Floats
    d_w: Floats  # of one tangent
    d_e: Floats
    margin: Floats
    watch: Floats
    sliding: Floats


class CollocationWork(NamedTuple):
    """Scratch of the engine."""

    w: Rows  # polynomials of the step in powers of time, as e
    e: Rows
    node_w: Rows  # values at the nodes
    node_e: Rows
    node_a: Rows
    d_node_w: Rows  # d_...: of one tangent
    d_node_e: Rows
    d_node_a: Rows
    d_w: Rows
    d_e: Rows
    signal: Floats
    gradient: Floats  # of a law
    length: Floats  # proposed, of the next step
    margin: Floats
    watch: Floats
    sliding: Floats  # time since the motion began, 0 for a new one
