"""What kernels know of a model with n blocks and of its motion: plain tuples and arrays."""

#     e = K x + C (w + V) - amplitude cos(phase)           needed force, w = X' - V
#     m w' = -mode limit F(|w|) - e, or 0 while riding;  x' = w + V
# With the phase as part of the state the flow is autonomous: events restart its clock.

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.model.structure import Structure

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class BlockSystem(NamedTuple):
    """Numbers of n blocks; row i of the matrices is entries ``first[i]:first[i + 1]``."""

    mass: Floats
    static: Floats
    first: Ints
    column: Ints
    stiffness: Floats
    damping: Floats
    amplitude: Floats
    frequency: float
    V: float
    inverse: Floats  # (n, n), of the stiffness
    forced: bool  # forces depend on time


class BlockDirections(NamedTuple):
    """Derivatives of the numbers in some directions, the leading axis; as in `BlockSystem`."""

    mass: Floats
    static: Floats
    stiffness: Floats
    damping: Floats
    amplitude: Floats
    frequency: Floats
    phase: Floats
    V: Floats
    laws: Floats  # (directions, n, parameters of a law)
    start: Floats  # (directions, n - 1): of the first differences
    varies: NDArray[np.bool_]  # anything but the starting state


class BlockMotion(NamedTuple):
    """One motion, changed in place by kernels; an entry per block."""

    x: Floats
    w: Floats
    e: Floats
    size: Floats  # of the terms that make up e, for its rounding
    mode: Ints
    event: Ints
    phase: Floats
    tangent_x: Floats  # (n, columns)
    tangent_w: Floats
    tangent_phase: Floats


def block_system(structure: Structure) -> BlockSystem:
    """Numbers of a model in the form that kernels take."""
    present = (structure.stiffness != 0.0) | (structure.damping != 0.0)
    np.fill_diagonal(present, True)
    rows, columns = np.nonzero(present)
    first = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=structure.n_blocks))])
    return BlockSystem(
        mass=structure.mass.copy(),
        static=structure.static.copy(),
        first=first.astype(np.int64),
        column=columns.astype(np.int64),
        stiffness=structure.stiffness[rows, columns].copy(),
        damping=structure.damping[rows, columns].copy(),
        amplitude=structure.amplitude.copy(),
        frequency=structure.frequency,
        V=structure.V,
        inverse=np.asarray(np.linalg.inv(structure.stiffness), dtype=np.float64),
        forced=structure.is_forced,
    )


def block_directions(
    system: BlockSystem, changes: list[Structure | None], laws: Floats, start: Floats
) -> BlockDirections:
    """Directions of change for kernels: of the structure (or None), of laws, of the start."""
    n, count = len(system.mass), len(changes)
    varies = [change is not None or bool(laws[k].any()) for k, change in enumerate(changes)]
    rows = np.repeat(np.arange(n), np.diff(system.first))
    directions = BlockDirections(
        mass=np.zeros((count, n)),
        static=np.zeros((count, n)),
        stiffness=np.zeros((count, len(rows))),
        damping=np.zeros((count, len(rows))),
        amplitude=np.zeros((count, n)),
        frequency=np.zeros(count),
        phase=np.zeros(count),
        V=np.zeros(count),
        laws=laws,
        start=start,
        varies=np.array(varies, dtype=bool),
    )
    for k, change in enumerate(changes):
        if change is None:
            continue
        for name in ("mass", "static", "amplitude", "frequency", "phase", "V"):
            getattr(directions, name)[k] = getattr(change, name)
        directions.stiffness[k] = change.stiffness[rows, system.column]
        directions.damping[k] = change.damping[rows, system.column]
    return directions


def new_block_motion(n_blocks: int, n_columns: int) -> BlockMotion:
    """Arrays for one motion with some tangents."""
    n = n_blocks
    return BlockMotion(
        x=np.zeros(n),
        w=np.zeros(n),
        e=np.zeros(n),
        size=np.zeros(n),
        mode=np.zeros(n, dtype=np.int64),
        event=np.zeros(n, dtype=np.int64),
        phase=np.zeros(1),
        tangent_x=np.zeros((n, n_columns)),
        tangent_w=np.zeros((n, n_columns)),
        tangent_phase=np.zeros(n_columns),
    )


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
