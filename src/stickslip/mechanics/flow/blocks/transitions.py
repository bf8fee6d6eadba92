"""Transitions of m contacts: needed forces, onset, modes at an event."""

from __future__ import annotations

import math

from stickslip.mechanics.flow.blocks.system import (
    BlockDirections,
    BlockMotion,
    BlockSystem,
    Floats,
    RowChanges,
    Rows,
)
from stickslip.mechanics.flow.system import (
    AT_LOWER_LIMIT,
    AT_UPPER_LIMIT,
    BACKWARD,
    FORWARD,
    LANDING,
    STICK,
)
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.numerics.trigonometry import sincos

# Rounding of a needed force, in units of EPSILON x the terms that make it up.
FORCE_ROUNDING = 16.0


# --- rows ---------------------------------------------------------------------------------------


@kernel(inline=True)
def needed_row(motion: BlockMotion, block: int) -> int:
    """Row of a contact's needed force."""
    return motion.y.shape[0] + block


@kernel(inline=True)
def limit_row(motion: BlockMotion, block: int) -> int:
    """Row of a contact's static limit."""
    return motion.z.shape[0] + block


@kernel(inline=True)
def is_loaded(system: BlockSystem, motion: BlockMotion, block: int) -> bool:
    """Whether the static limit of a contact varies."""
    row = limit_row(motion, block)
    return system.first[row + 1] > system.first[row]


@kernel(inline=True)
def row_value(system: BlockSystem | Rows, motion: BlockMotion, row: int) -> tuple[float, float]:
    """Present value of a row, and the size of the terms that make it up."""
    total = system.constant[row]
    size = abs(total)
    for k in range(system.first[row], system.first[row + 1]):
        term = system.entry[k] * motion.z[system.column[k]]
        total += term
        size += abs(term)
    return total, size


@kernel
def row_rate(system: BlockSystem, motion: BlockMotion, rates: Floats, row: int) -> float:
    """Rate of change of a row; `rates`: w' of all contacts."""
    n_free = motion.y.shape[0]
    rate = 0.0
    for k in range(system.first[row], system.first[row + 1]):
        j = system.column[k]
        if j < n_free:
            flow, _ = row_value(system, motion, j)
            rate += system.entry[k] * flow
        else:
            rate += system.entry[k] * rates[j - n_free]
    return rate


@kernel
def row_tangent(
    system: BlockSystem | Rows,
    directions: BlockDirections | RowChanges,
    motion: BlockMotion,
    row: int,
    column: int,
) -> float:
    """Differentiate a row at the present state."""
    change = 0.0
    for k in range(system.first[row], system.first[row + 1]):
        change += system.entry[k] * motion.tangent_z[system.column[k], column]
    if directions.varies[column]:
        change += directions.constant[column, row]
        for k in range(directions.first[column, row], directions.first[column, row + 1]):
            change += directions.entry[k] * motion.z[directions.column[k]]
    return change


# --- needed forces ------------------------------------------------------------------------------


@kernel(inline=True)
def force_tolerance(motion: BlockMotion, block: int) -> float:
    """How near its static limit the needed force of a contact counts as being there."""
    return FORCE_ROUNDING * EPSILON * (motion.limit[block] + motion.size[block])


@kernel(inline=True)
def set_waves(system: BlockSystem, motion: BlockMotion) -> None:
    """Compute the waves from the clock."""
    n_harmonics = system.frequency.shape[0]
    for k in range(n_harmonics):
        sine, cosine = sincos(system.frequency[k] * motion.clock[0] + system.phase[k])
        motion.z[k], motion.z[n_harmonics + k] = cosine, sine


@kernel
def update_needed(system: BlockSystem, motion: BlockMotion) -> None:
    """Compute the needed forces from the state; exactly the limit where rounding explains it."""
    set_waves(system, motion)
    for i in range(motion.w.shape[0]):
        force, size = row_value(system, motion, needed_row(motion, i))
        limit = system.constant[limit_row(motion, i)]
        if is_loaded(system, motion, i):
            limit, more = row_value(system, motion, limit_row(motion, i))
            size += more
        motion.limit[i] = limit
        motion.size[i] = size
        if abs(abs(force) - limit) <= force_tolerance(motion, i):
            force = limit if force > 0.0 else -limit
        motion.e[i] = force


@kernel
def excess_rate(
    system: BlockSystem, motion: BlockMotion, rates: Floats, block: int, side: float
) -> float:
    """Rate at which a needed force passes its upper limit (`side` 1) or lower limit (-1)."""
    rate = row_rate(system, motion, rates, needed_row(motion, block))
    if is_loaded(system, motion, block):
        rate -= side * row_rate(system, motion, rates, limit_row(motion, block))
    return rate


# --- elastic contacts ---------------------------------------------------------------------------

FEET: bool  # bound in templates: whether contacts are elastic


@kernel(inline=True)
def slides(system: BlockSystem, motion: BlockMotion, block: int) -> bool:
    """Whether a contact is the foot of a spring, and slips."""
    return bool(system.foot[block] >= 0 and motion.mode[block] != STICK)


@kernel
def put_foot(system: BlockSystem, laws: Floats, motion: BlockMotion, block: int) -> None:
    """Put a sliding foot where its spring carries kinetic friction, and give it the velocity."""
    needed, limit = needed_row(motion, block), limit_row(motion, block)
    share = kinetic_share(laws, motion, block)
    force, _ = row_value(system, motion, needed)
    most, _ = row_value(system, motion, limit)
    motion.z[system.foot[block]] -= (force + share * most) / system.mass[block]
    motion.w[block] = 0.0
    rate = row_rate(system, motion, motion.w, needed)
    rate += share * row_rate(system, motion, motion.w, limit)
    motion.w[block] = -rate / system.mass[block]


@kernel
def foot_rate(
    system: BlockSystem, laws: Floats, motion: BlockMotion, rates: Floats, block: int
) -> float:
    """Rate w' of a sliding foot from those of contacts with inertia."""
    rates[block] = total = 0.0
    share = 1.0
    for row in (needed_row(motion, block), limit_row(motion, block)):
        for k in range(system.first[row], system.first[row + 1]):
            total += share * system.entry[k] * row_rate(system, motion, rates, system.column[k])
        share = kinetic_share(laws, motion, block)
    return -total / system.mass[block]


@kernel(inline=True)
def kinetic_share(laws: Floats, motion: BlockMotion, block: int) -> float:
    """Force that a sliding foot needs for its spring over the limit, with its sign turned."""
    mode = motion.mode[block]
    return float(mode * laws[block, STATIC_COLUMN + (mode == FORWARD)])


@kernel
def relieve(system: BlockSystem, laws: Floats, motion: BlockMotion) -> None:
    """Let go what rests on inertia and cannot stick any more, as springs of feet have relaxed."""
    for block in range(motion.mode.shape[0]):
        if slides(system, motion, block):
            put_foot(system, laws, motion, block)
    update_needed(system, motion)
    for block in range(motion.mode.shape[0]):
        if motion.mode[block] == STICK and abs(motion.e[block]) > motion.limit[block]:
            motion.mode[block] = BACKWARD if motion.e[block] > 0.0 else FORWARD


# --- global stick -------------------------------------------------------------------------------


@kernel(inline=True)
def growth(system: BlockSystem, motion: BlockMotion, block: int) -> float:
    """Growth of a needed force per displacement of all blocks together, with the belt."""
    row = needed_row(motion, block)
    total = 0.0
    for k in range(system.first[row], system.first[row + 1]):
        if system.column[k] < motion.y.shape[0]:
            total += system.entry[k]
    return math.copysign(total, total * system.V[0])


@kernel
def onset(system: BlockSystem, motion: BlockMotion, d: Floats) -> int:
    """End of the global stick phase with differences `d`; return how many blocks leave."""
    n = motion.mode.shape[0]
    motion.y[0] = 0.0
    for i in range(n):
        if i > 0:
            motion.y[i] = motion.y[i - 1] + d[i - 1]
        motion.w[i] = 0.0
        motion.mode[i] = STICK
        motion.event[i] = 0
    update_needed(system, motion)
    shift = math.inf
    leader = 0
    for i in range(n):
        room = room_to_limit(system, motion, i)
        if room < shift:
            shift, leader = room, i
    for i in range(n):
        motion.y[i] += math.copysign(1.0, system.V[0]) * shift
    update_needed(system, motion)
    leaving = 0
    for i in range(n):
        side = 1.0 if growth(system, motion, i) > 0.0 else -1.0
        limit = side * motion.limit[i]
        if i == leader or abs(motion.e[i] - limit) <= force_tolerance(motion, i):
            leaving += 1
            motion.mode[i] = BACKWARD if side > 0.0 else FORWARD
            motion.e[i] = limit
        else:
            motion.e[i] = min(max(motion.e[i], -motion.limit[i]), motion.limit[i])
    onset_tangents(system, motion, leader)
    return leaving


@kernel(inline=True)
def room_to_limit(system: BlockSystem, motion: BlockMotion, block: int) -> float:
    """How far all blocks can move together before this one is at a limit."""
    per_length = growth(system, motion, block)
    if per_length == 0.0:
        return math.inf
    side = 1.0 if per_length > 0.0 else -1.0
    return (side * motion.limit[block] - motion.e[block]) / per_length


@kernel
def onset_tangents(system: BlockSystem, motion: BlockMotion, leader: int) -> None:
    """Differentiate the displacements at the onset, which keeps the leader at its limit."""
    per_length = growth(system, motion, leader)
    side = 1.0 if per_length > 0.0 else -1.0
    for column in range(motion.tangent_y.shape[1]):
        change = 0.0
        for i in range(motion.mode.shape[0]):
            if i > 0:
                change += motion.directions.start[column, i - 1]
            motion.tangent_y[i, column] = change
            motion.tangent_w[i, column] = 0.0
        motion.tangent_clock[column] = 0.0
        needed = row_tangent(system, motion.directions, motion, needed_row(motion, leader), column)
        moved = row_tangent(system, motion.directions, motion, limit_row(motion, leader), column)
        shift = (side * moved - needed) / per_length
        for i in range(motion.mode.shape[0]):
            motion.tangent_y[i, column] += math.copysign(1.0, system.V[0]) * shift


# --- events -------------------------------------------------------------------------------------


@kernel(inline=True)
def mode_on_belt(system: BlockSystem, motion: BlockMotion, rates: Floats, block: int) -> int:
    """Mode of a contact whose relative velocity is zero; ``motion.e`` is exact at the limits."""
    limit = motion.limit[block]
    force = motion.e[block]
    if abs(force) < limit:
        return STICK
    if abs(force) == limit:
        side = 1.0 if force > 0.0 else -1.0
        if side * excess_rate(system, motion, rates, block, side) <= 0.0:
            return STICK
    return BACKWARD if force > 0.0 else FORWARD


@kernel(inline=True)
def stop(motion: BlockMotion, block: int) -> None:
    """Take away the relative velocity of a contact, and how it changes with anything."""
    motion.w[block] = 0.0
    for column in range(motion.tangent_w.shape[1]):
        motion.tangent_w[block, column] = 0.0


@kernel(inline=True)
def settle(system: BlockSystem, laws: Floats, motion: BlockMotion, rates: Floats) -> bool:
    """Change the modes of all contacts at an event, once; tell whether any changed."""
    # Needed forces are continuous there; `rates` (w' just before) matter exactly at a limit alone.
    n = motion.mode.shape[0]
    for block in range(n):
        if motion.event[block] != 0:
            stop(motion, block)
            rates[block] = 0.0
    changed = jumps = False
    for block in range(n):
        event = motion.event[block]
        before = motion.mode[block]
        if event == LANDING and slides(system, motion, block):
            motion.mode[block] = STICK
        elif event == LANDING:
            motion.mode[block] = mode_on_belt(system, motion, rates, block)
        elif event == AT_UPPER_LIMIT:
            motion.mode[block] = BACKWARD
        elif event == AT_LOWER_LIMIT:
            motion.mode[block] = FORWARD
        changed = changed or motion.mode[block] != before
        jumps = jumps or (event != 0 and slides(system, motion, block))
    if jumps:
        relieve(system, laws, motion)
    return changed


@kernel
def saltation(system: BlockSystem, motion: BlockMotion, rates: Floats) -> None:
    """Move the tangents to the event that ``motion.event`` names, if any."""
    # `rates`: w' just before. The first contact with an event sets the time; at a touch (rate 0)
    # nothing is moved, and ``motion.shift`` is NaN.
    n, n_columns = motion.mode.shape[0], motion.tangent_z.shape[1]
    for block in range(n):
        event = motion.event[block]
        if event == 0:
            continue
        landing = event == LANDING
        side = 1.0 if event == AT_UPPER_LIMIT else -1.0
        rate = rates[block]
        if not landing:
            rate = excess_rate(system, motion, rates, block, side)
        if abs(rate) <= force_tolerance(motion, block):
            motion.shift[:] = math.nan
            continue
        for column in range(n_columns):
            if landing:
                motion.shift[column] = -motion.tangent_w[block, column] / rate
            else:
                needed = row_tangent(
                    system, motion.directions, motion, needed_row(motion, block), column
                )
                moved = row_tangent(
                    system, motion.directions, motion, limit_row(motion, block), column
                )
                motion.shift[column] = (side * moved - needed) / rate
        move_tangents(system, motion, rates)
        return


@kernel(inline=True)
def move_tangents(system: BlockSystem, motion: BlockMotion, rates: Floats) -> None:
    """Move the tangents by ``motion.shift`` in time."""
    n_columns = motion.shift.shape[0]
    for i in range(motion.y.shape[0]):
        flow, _ = row_value(system, motion, i)
        for column in range(n_columns):
            motion.tangent_y[i, column] += flow * motion.shift[column]
    for i in range(motion.mode.shape[0]):
        for column in range(n_columns):
            motion.tangent_w[i, column] += rates[i] * motion.shift[column]
    for column in range(n_columns):
        motion.tangent_clock[column] += motion.shift[column]
