"""What kernels know of a plant with dry contacts and of its motion: plain tuples and arrays."""

# Coordinates z = (y, w): friction acts on the relative velocities w alone; y begins with the waves
# of the harmonics. Rows of one sparse matrix say y', the needed forces e and the static limits L
# (`mechanics.model.plant.Reduced`);
#     mass w' = -mode L F(|w|) - e, or 0 while sticking.
# Contacts that share inertia: mass w' = coupling f - own, and the forces f of sticking contacts are
# solved for (`transitions.couple`); e is then what each contact needs while all others go on.
# The foot of an elastic contact has no mass: its place, or sliding its velocity too, follows from
# f = e, and `mass` is the stiffness of its spring (`transitions.put_foot`).
# With the clock as part of the state the flow is autonomous: events restart it.

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.model.orders import order, orders

if TYPE_CHECKING:
    from stickslip.mechanics.model.plant import Plant, Reduced

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]

GROUP = 4  # tangents whose series are found together


class JointSystem(NamedTuple):
    """Numbers of m contacts that share inertia."""

    coupling: Floats  # (m, m)
    mechanisms: Floats  # (ways, m): slips that begin together


class BlockSystem(NamedTuple):
    """Numbers of n coordinates and m contacts; a row is entries ``first[row]:first[row + 1]``."""

    mass: Floats  # (m,)
    joint: Any  # JointSystem; None where no contacts share inertia, as below
    first: Ints  # (n + m + 1,)
    column: Ints
    entry: Floats
    constant: Floats  # (n + m,)
    frequency: Floats  # (harmonics,), as phase
    phase: Floats
    V: Floats  # (m,)
    foot: Ints  # (m,): where y holds the place of an elastic contact's foot; -1 of other contacts
    inverse: Floats  # (m, m), of the stiffness, where energy bounds the motion; else (0, 0)
    order: Floats  # (n,), of magnitude, of z
    longest: float  # step


class BlockDirections(NamedTuple):
    """Derivatives of the numbers in some directions, the leading axis; as in `BlockSystem`."""

    mass: Floats
    coupling: Floats
    first: Ints  # (directions, n + m + 1), into column and entry of all directions
    column: Ints
    entry: Floats
    constant: Floats
    laws: Floats  # (directions, m, parameters of a law)
    start: Floats  # (directions, m - 1): of the first differences
    varies: Bools  # anything but the starting state


class Joint(NamedTuple):
    """What a motion of m contacts that share inertia has besides."""

    response: Floats  # (m, m): of forces of sticking contacts and of pulls to `drive`
    tangent: Floats  # (m, columns), of `drive`
    bears: Bools  # whether a sticking contact's force is determined by the others'
    before: Ints  # modes
    way: Ints  # mechanism that begins, counted from 1; negative: the other way; 0: none
    fastest: Floats  # relative velocity so far, its rounding is that of all
    drive: Floats  # friction of slipping contacts, own needed force of sticking ones
    rate: Floats  # of `drive`
    own: Floats  # needed forces but for what other contacts do
    size: Floats  # of the terms that make it up
    pull: Floats  # mass w'


class Rows(NamedTuple):
    """Rows "matrix z + constant", as in `BlockSystem`."""

    first: Ints
    column: Ints
    entry: Floats
    constant: Floats


class RowChanges(NamedTuple):
    """Derivatives of rows in some directions, as in `BlockDirections`."""

    first: Ints
    column: Ints
    entry: Floats
    constant: Floats
    varies: Bools


class BlockMotion(NamedTuple):
    """One motion, changed in place by kernels; an entry per contact, unless said otherwise."""

    z: Floats  # (n,): y, then w, which are parts of it
    y: Floats
    w: Floats
    e: Floats
    size: Floats  # of the terms that make up e and the limit, for their rounding
    limit: Floats
    mode: Ints
    event: Ints
    clock: Floats
    tangent_z: Floats  # (n, columns)
    tangent_y: Floats
    tangent_w: Floats
    tangent_clock: Floats
    shift: Floats  # (columns,) of the clock at the last event; NaN if that was a touch
    directions: BlockDirections  # one for each column
    joint: Any  # Joint


class TangentSteps(NamedTuple):
    """Starts of the steps of a motion, an entry each, with tangents in some directions."""

    t: Floats
    z: Floats  # (steps, n without waves)
    mode: Ints
    tangent: Floats  # (steps, n, columns)
    clock: Floats  # (steps, columns)


def block_system(plant: Plant) -> BlockSystem:
    """Numbers of a model in the form that kernels take."""
    reduced = plant.reduced
    rows = sparse(reduced.matrix, reduced.constant)
    foot = np.full(plant.n_contacts, -1)
    foot[list(plant.elastic)] = plant.n_waves + plant.n_bodies + np.arange(len(plant.elastic))
    inverse = np.linalg.inv(plant.stiffness) if plant.dissipates else np.zeros((0, 0))
    size = orders(plant)
    return BlockSystem(
        mass=reduced.mass.copy(),
        joint=JointSystem(reduced.coupling, plant.mechanisms) if plant.is_coupled else None,
        **rows._asdict(),
        frequency=reduced.frequency.copy(),
        phase=reduced.phase.copy(),
        V=np.array(reduced.V, dtype=np.float64),
        foot=foot,
        inverse=np.asarray(inverse, dtype=np.float64),
        order=np.append(np.ones(plant.n_waves), order(size.state)),
        longest=size.time,
    )


def sparse(matrix: Floats, constant: Floats) -> Rows:
    """Rows of a matrix as entries that are not zero, and where each begins."""
    rows, columns = np.nonzero(matrix)
    first = np.concatenate([[0], np.cumsum(np.bincount(rows, minlength=len(matrix)))])
    entry = matrix[rows, columns].copy()
    return Rows(first.astype(np.int64), columns.astype(np.int64), entry, constant.copy())


def sparse_changes(changes: list[Rows | None], n_rows: int, varies: list[bool]) -> RowChanges:
    """Collect derivatives of rows in some directions, None where there is none."""
    nothing = sparse(np.zeros((n_rows, 1)), np.zeros(n_rows))
    rows = [nothing if change is None else change for change in changes]
    before = np.cumsum([0, *(len(row.entry) for row in rows)])[:-1]
    count = len(rows)
    first = [row.first + start for row, start in zip(rows, before, strict=True)]
    return RowChanges(
        first=np.array(first, dtype=np.int64).reshape(count, n_rows + 1),
        column=np.concatenate([np.zeros(0, np.int64), *(row.column for row in rows)]),
        entry=np.concatenate([np.zeros(0), *(row.entry for row in rows)]),
        constant=np.array([row.constant for row in rows]).reshape(count, n_rows),
        varies=np.array(varies, dtype=bool),
    )


def block_directions(
    system: BlockSystem, changes: list[Reduced | None], laws: Floats, start: Floats
) -> BlockDirections:
    """Directions of change for kernels: of the numbers (or None), of laws, of the start."""
    m = len(system.mass)
    varies = [change is not None or bool(laws[k].any()) for k, change in enumerate(changes)]
    rows = [change and sparse(change.matrix, change.constant) for change in changes]
    moved = sparse_changes(rows, len(system.constant), varies)

    def stacked(name: str, *shape: int) -> Floats:
        none = np.zeros(shape)
        each = [none if change is None else getattr(change, name) for change in changes]
        return np.array(each).reshape(len(changes), *shape)

    return BlockDirections(
        mass=stacked("mass", m),
        coupling=stacked("coupling", *([0 if system.joint is None else m] * 2)),
        laws=laws,
        start=start,
        **moved._asdict(),
    )


def widened(directions: BlockDirections, n_more: int) -> BlockDirections:
    """Directions with some more that change nothing."""

    def more(values: Any) -> Any:
        return np.concatenate([values, np.zeros((n_more, *values.shape[1:]), values.dtype)])

    wide = BlockDirections(*map(more, directions))
    return wide._replace(column=directions.column, entry=directions.entry)


def new_block_motion(system: BlockSystem, directions: BlockDirections) -> BlockMotion:
    """Arrays for one motion with a tangent for each direction."""
    m, n_columns = len(system.mass), len(directions.varies)
    n = len(system.constant) - m
    z, tangent = np.zeros(n), np.zeros((n, n_columns))
    return BlockMotion(
        z=z,
        y=z[: n - m],
        w=z[n - m :],
        e=np.zeros(m),
        size=np.zeros(m),
        limit=np.zeros(m),
        mode=np.zeros(m, dtype=np.int64),
        event=np.zeros(m, dtype=np.int64),
        clock=np.zeros(1),
        tangent_z=tangent,
        tangent_y=tangent[: n - m],
        tangent_w=tangent[n - m :],
        tangent_clock=np.zeros(n_columns),
        shift=np.zeros(n_columns),
        directions=directions,
        joint=system.joint and _new_joint(m, n_columns),
    )


def _new_joint(m: int, n_columns: int) -> Joint:
    ints = np.zeros((2, m), dtype=np.int64)
    wide, bears = np.zeros((m, n_columns)), np.zeros(m, dtype=np.bool_)
    each = np.zeros((m, m)), wide, bears, *ints, np.zeros(1), *np.zeros((5, m))
    return Joint._make(each)


class JointWork(NamedTuple):
    """Series of one step of m contacts that share inertia, (m, order + 1)."""

    drive: Floats  # as in `Joint`
    force: Floats  # of all contacts
    d_drive: Floats  # (m, order + 1, GROUP), of tangents
    d_own: Floats  # (m, GROUP), a coefficient


def _new_joint_work(m: int, size: int) -> JointWork:
    drive, force = np.zeros((2, m, size))
    return JointWork(drive, force, np.zeros((m, size, GROUP)), np.zeros((m, GROUP)))


class BlockWork(NamedTuple):
    """Series of one step and what is searched in them."""

    z: Floats  # (n, order + 1): y, then w, which are parts of it
    y: Floats
    w: Floats
    signal: Floats  # the polynomial that is searched
    limit: Floats  # (m, order + 1)
    rows: Floats  # (m, rows of a law, order + 1)
    d_z: Floats  # (n, order + 1, GROUP), of tangents: y, then w
    d_w: Floats
    d_limit: Floats  # (m, order + 1, GROUP), as d_force
    d_force: Floats
    d_row: Floats  # (GROUP,), a coefficient or values of tangents
    d_rates: Floats  # (2, GROUP)
    joint: Any  # JointWork
    rates: Floats  # w' at the end of a step
    deviation: Floats  # from steady sliding
    factor: Floats
    active: Ints  # contacts that slip: the first n_active[0]
    flowing: Ints  # y that are no straight lines: the first n_active[1]
    bends: Bools  # (n - m,): whether y is one of them
    n_active: Ints
    margin: Floats
    watch: Floats  # whether to; units of clearances: of velocity, of force at each contact


def new_block_work(system: BlockSystem, n_rows: int, order: int) -> BlockWork:
    """Scratch arrays for one motion."""
    m, size = len(system.mass), order + 1
    n = len(system.constant) - m
    z, d_z = np.zeros((n, size)), np.zeros((n, size, GROUP))
    return BlockWork(
        z=z,
        y=z[: n - m],
        w=z[n - m :],
        signal=np.zeros(size),
        limit=np.zeros((m, size)),
        rows=np.zeros((m, n_rows, size)),
        d_z=d_z,
        d_w=d_z[n - m :],
        d_limit=np.zeros((m, size, GROUP)),
        d_force=np.zeros((m, size, GROUP)),
        d_row=np.zeros(GROUP),
        d_rates=np.zeros((2, GROUP)),
        joint=system.joint and _new_joint_work(m, size),
        rates=np.zeros(m),
        deviation=np.zeros(m),
        factor=np.zeros((m, m)),
        active=np.zeros(m, dtype=np.int64),
        flowing=np.zeros(n - m, dtype=np.int64),
        bends=np.zeros(n - m, dtype=np.bool_),
        n_active=np.zeros(2, dtype=np.int64),
        margin=np.full(1, np.inf),
        watch=np.array([0.0, *np.ones(1 + m)]),
    )
