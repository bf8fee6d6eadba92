"""One step of a plant: Taylor series of high order, whose polynomials locate the events."""

# Template (`numerics.targets.instantiate`): a law's kernels are bound. Derivation:
# docs/theory/blocks.md, plant.md. Only what a slip or a force of its own bends has series; all else
# is a straight line.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from stickslip.mechanics.flow._sliding_kernels import CLEARANCE
from stickslip.mechanics.flow.blocks.joint import DEPENDENT, begin, couple, saltation_together
from stickslip.mechanics.flow.blocks.system import (
    GROUP,
    BlockMotion,
    BlockSystem,
    BlockWork,
    Floats,
    Ints,
    TangentSteps,
)
from stickslip.mechanics.flow.blocks.transitions import (
    FORCE_ROUNDING,
    foot_rate,
    force_tolerance,
    is_loaded,
    limit_row,
    needed_row,
    put_foot,
    row_value,
    saltation,
    set_waves,
    slides,
    update_needed,
)
from stickslip.mechanics.flow.dense import (
    MOST_HALVINGS,
    OFF,
    OVERLAP,
    PLACES,
    at_place,
    clearance,
    is_followed,
    leaving_time,
    piece_row,
)
from stickslip.mechanics.flow.system import AT_LOWER_LIMIT, AT_UPPER_LIMIT, LANDING, LOST
from stickslip.numerics.polynomial import NO_ROOT, UNFINISHED, first_contact, jet, value
from stickslip.numerics.roots import EPSILON
from stickslip.numerics.targets import kernel
from stickslip.status import (
    AT_REST,
    CONTACT_LOST,
    LAW_FAILED,
    NEVER_SLIPPING,
    OK,
    STEP_FAILED,
)

if TYPE_CHECKING:
    from stickslip.mechanics.flow._sliding_kernels import least_slope
    from stickslip.mechanics.flow.blocks.joint import COUPLED
    from stickslip.mechanics.flow.blocks.transitions import FEET
    from stickslip.mechanics.friction.interface import (
        FORCE_ROW,
        GRADIENT_ROW,
        SLOPE_ROW,
        force,
        series,
        series_tangent,
        static_value,
    )

ORDER = 18
# Times that are never reached; what underflows ends as a series, too.
FOR_EVER = 1e100
# Rounding of a step's coefficients, in units of EPSILON.
SLACK = 4.0


@kernel(inline=True, short_loops=True)
def advance(
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    rtol: float,
    cap: float,
) -> tuple[float, int]:
    """Take one step, up to an event if one comes; return its length and a status.

    `CONTACT_LOST` is told of a step that was taken: the motion ends there.
    """
    list_active(system, motion, work)
    expand(system, laws, motion, work)
    h = min(cap, step_length(system, motion, work, rtol))
    if not h > 0.0:
        return 0.0, LAW_FAILED if has_no_law(laws, motion, work) else STEP_FAILED
    h = stay_on_pieces(system, laws, motion, work, h)
    if not h > 0.0:
        return 0.0, STEP_FAILED
    h = find_events(system, motion, work, h)
    if h < 0.0 or h == math.inf:
        return 0.0, STEP_FAILED if h < 0.0 else AT_REST
    for _ in range(MOST_HALVINGS):
        if follows_laws(system, laws, motion, work, h, rtol):
            break
        h = find_events(system, motion, work, 0.5 * h)
        if h < 0.0:
            return 0.0, STEP_FAILED
    if work.watch[0] != 0.0:
        work.margin[0] = min(work.margin[0], watch_step(system, motion, work, h))
    if motion.tangent_z.shape[1] > 0:
        tangents(system, laws, motion, work, h)
    move(system, laws, motion, work, h)
    if motion.tangent_z.shape[1] > 0:
        if COUPLED:
            saltation_together(system, motion, work.rates)
        else:
            saltation(system, motion, work.rates)
    return h, CONTACT_LOST if is_lost(motion) else OK


@kernel(short_loops=True)
def to_event(
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    rtol: float,
    t: float,
    end: float,
    most: int,
) -> tuple[float, int]:
    """Take at most so many steps from t, to an event or to `end`; the time there and a status."""
    status = OK
    for _ in range(most):
        if end == math.inf and slides_for_ever(system, laws, motion, work):
            return t, NEVER_SLIPPING
        h, status = advance(system, laws, motion, work, rtol, end - t)
        t += h
        if status != OK or not t < end or h == 0.0 or is_at_event(motion):
            break
    return t, status


@kernel
def is_at_event(motion: BlockMotion) -> bool:
    """Whether a contact is at an event."""
    for i in range(motion.mode.shape[0]):
        if motion.event[i] != 0:
            return True
    return False


@kernel(inline=True)
def is_lost(motion: BlockMotion) -> bool:
    """Whether a load vanishes at the end of a step."""
    lost = False
    for i in range(motion.mode.shape[0]):
        lost = lost or motion.event[i] == LOST
    return lost


@kernel(inline=True)
def list_active(system: BlockSystem, motion: BlockMotion, work: BlockWork) -> None:
    """Collect the contacts that slip and the coordinates y that they or forces bend."""
    n_free = motion.y.shape[0]
    count = 0
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != 0:
            work.active[count] = i
            count += 1
        else:
            work.rates[i] = 0.0
    work.n_active[0] = count
    count = 0
    for i in range(n_free):
        bends = moves(system, motion, i)
        if not bends:
            for k in range(system.first[i], system.first[i + 1]):
                bends = bends or motion.mode[system.column[k] - n_free] != 0
        work.bends[i] = bends
        if bends:
            work.flowing[count] = i
            count += 1
    work.n_active[1] = count


@kernel(inline=True)
def moves(system: BlockSystem, motion: BlockMotion, i: int) -> bool:
    """Whether y'_i depends on y, not on relative velocities alone."""
    first = system.first[i]
    return first < system.first[i + 1] and system.column[first] < motion.y.shape[0]


@kernel(inline=True)
def rate(system: BlockSystem, laws: Floats, motion: BlockMotion, block: int) -> float:
    """Rate w' of a contact in its mode."""
    if motion.mode[block] == 0:
        return 0.0
    if COUPLED:
        return motion.joint.pull[block] / system.mass[block]
    return (friction(laws, motion, block) - motion.e[block]) / system.mass[block]


@kernel(inline=True)
def find_rates(system: BlockSystem, laws: Floats, motion: BlockMotion, rates: Floats) -> None:
    """Rates w' of all contacts in their modes."""
    for i in range(motion.mode.shape[0]):
        rates[i] = rate(system, laws, motion, i)
    if FEET:
        for i in range(motion.mode.shape[0]):
            if slides(system, motion, i):
                rates[i] = foot_rate(system, laws, motion, rates, i)


@kernel
def has_no_law(laws: Floats, motion: BlockMotion, work: BlockWork) -> bool:
    """Whether a law has no value at the speed of its contact."""
    for a in range(work.n_active[0]):
        i = work.active[a]
        if math.isfinite(motion.w[i]) and math.isnan(friction(laws, motion, i)):
            return True
    return False


@kernel(inline=True)
def friction(laws: Floats, motion: BlockMotion, block: int) -> float:
    """Friction force of a slipping contact."""
    mode = motion.mode[block]
    s = max(mode * motion.w[block], 0.0)
    return -mode * motion.limit[block] * force(laws[piece_row(laws, block, s)], mode, s)


@kernel(inline=True)
def refresh(system: BlockSystem, laws: Floats, motion: BlockMotion) -> None:
    """Compute the needed forces in the present state and modes, and where feet slide."""
    if FEET:
        set_waves(system, motion)
        for i in range(motion.mode.shape[0]):
            if slides(system, motion, i):
                put_foot(system, laws, motion, i)
    update_needed(system, motion)
    if COUPLED:
        for i in range(motion.mode.shape[0]):
            if motion.mode[i] != 0:
                motion.joint.drive[i] = friction(laws, motion, i)
                motion.joint.fastest[0] = max(motion.joint.fastest[0], abs(motion.w[i]))
        couple(system, motion)


@kernel(inline=True)
def move(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork, h: float) -> None:
    """Go to the end of the step."""
    for i in range(motion.y.shape[0]):
        if work.bends[i]:
            motion.y[i] = value(work.y[i], h)
        else:
            motion.y[i] += work.y[i, 1] * h
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != 0:
            motion.w[i] = value(work.w[i], h)
    motion.clock[0] += h
    refresh(system, laws, motion)
    for i in range(motion.mode.shape[0]):
        if motion.event[i] == AT_UPPER_LIMIT:
            motion.e[i] = motion.limit[i]
        elif motion.event[i] == AT_LOWER_LIMIT:
            motion.e[i] = -motion.limit[i]
    find_rates(system, laws, motion, work.rates)


# --- series -----------------------------------------------------------------------------------


@kernel(inline=True)
def expand(system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork) -> None:
    """Taylor series: (k + 1) mass w_{k+1} = -mode (L F)_k - e_k, and y likewise."""
    z, w = work.z, work.w
    for j in range(motion.z.shape[0]):
        z[j] = 0.0
        z[j, 0] = motion.z[j]
    for i in range(motion.y.shape[0]):
        if not work.bends[i]:
            z[i, 1] = system.constant[i]
    for k in range(ORDER + COUPLED):
        if FEET and k > 0:
            expand_feet(system, motion, work, k)
        for a in range(work.n_active[0]):
            i = work.active[a]
            mode = motion.mode[i]
            work.rows[i, 0, k] = mode * w[i, k]
            row = piece_row(laws, i, mode * motion.w[i])
            series(laws[row], mode, work.rows[i], k)
            drive = -mode * friction_coefficient(system, motion, work, i, k)
            if COUPLED:
                work.joint.drive[i, k] = drive
                continue
            if FEET and system.foot[i] >= 0:
                continue
            needed = motion.e[i]
            if k > 0:
                needed = row_coefficient(system, work, needed_row(motion, i), k)
            pull = drive - needed
            if k == 0 and w[i, 0] == 0.0 and abs(pull) <= force_tolerance(motion, i):
                pull = 0.0  # F(0) = 1: a slip starts at a double root
            w[i, k + 1] = pull / (system.mass[i] * (k + 1))
        if COUPLED:
            couple_series(system, motion, work, k)
        if k == ORDER:
            break
        for a in range(work.n_active[1]):
            i = work.flowing[a]
            z[i, k + 1] = row_coefficient(system, work, i, k) / (k + 1)
    if FEET and not COUPLED:
        expand_feet(system, motion, work, ORDER)
    for i in range(motion.mode.shape[0]):
        work.limit[i, 0] = motion.limit[i]
        if is_loaded(system, motion, i):
            for k in range(1, ORDER + 1):
                work.limit[i, k] = row_coefficient(system, work, limit_row(motion, i), k)


@kernel
def expand_feet(system: BlockSystem, motion: BlockMotion, work: BlockWork, k: int) -> None:
    """Coefficient k of sliding feet's velocities, with which e + mode L F stays 0."""
    for a in range(work.n_active[0]):
        i = work.active[a]
        if system.foot[i] >= 0:
            work.w[i, k] = 0.0
            rate = rate_coefficient(system, work, needed_row(motion, i), k)
            share = motion.mode[i] * work.rows[i, FORCE_ROW, 0]
            rate += share * rate_coefficient(system, work, limit_row(motion, i), k)
            work.w[i, k] = -rate / system.mass[i]


@kernel
def rate_coefficient(system: BlockSystem, work: BlockWork, row: int, k: int) -> float:
    """Coefficient k of the rate of a row that depends on y alone."""
    total = 0.0
    for entry in range(system.first[row], system.first[row + 1]):
        total += system.entry[entry] * row_coefficient(system, work, system.column[entry], k)
    return total


@kernel
def couple_series(system: BlockSystem, motion: BlockMotion, work: BlockWork, k: int) -> None:
    """Coefficient k of the forces of sticking contacts, k + 1 of relative velocities."""
    joint, n = motion.joint, motion.mode.shape[0]
    for i in range(n):
        if motion.mode[i] == 0:
            own = row_coefficient(system, work, needed_row(motion, i), k)
            work.joint.drive[i, k] = own if joint.bears[i] else 0.0
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += joint.response[i, j] * work.joint.drive[j, k]
        work.joint.force[i, k] = total if joint.bears[i] else work.joint.drive[i, k]
        if FEET and system.foot[i] >= 0:
            continue
        if motion.mode[i] != 0 and k < ORDER:
            pull = total - row_coefficient(system, work, needed_row(motion, i), k)
            rounding = force_tolerance(motion, i) * max(joint.response[i, i], DEPENDENT)
            if k == 0 and work.w[i, 0] == 0.0 and motion.mode[i] * pull <= rounding:
                pull = 0.0  # as in `expand`; what goes against the slip is rounding
            work.w[i, k + 1] = pull / (system.mass[i] * (k + 1))


@kernel(inline=True)
def friction_coefficient(
    system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int, k: int
) -> float:
    """Coefficient k of L F."""
    if not is_loaded(system, motion, block):
        return motion.limit[block] * work.rows[block, FORCE_ROW, k]
    work.limit[block, k] = row_coefficient(system, work, limit_row(motion, block), k)
    total = 0.0
    for j in range(k + 1):
        total += work.limit[block, j] * work.rows[block, FORCE_ROW, k - j]
    return total


@kernel(inline=True)
def row_coefficient(system: BlockSystem, work: BlockWork, row: int, k: int) -> float:
    """Coefficient k of a row."""
    total = system.constant[row] if k == 0 else 0.0
    for entry in range(system.first[row], system.first[row + 1]):
        total += system.entry[entry] * work.z[system.column[entry], k]
    return total


@kernel(inline=True)
def step_length(system: BlockSystem, motion: BlockMotion, work: BlockWork, rtol: float) -> float:
    """Step after which the last two terms of every series are below `rtol` of its order.

    Or below its rounding, where it has grown far beyond its order; 0 where a series has no value.
    """
    # None is longer than `longest`: a polynomial that happens to end early says nothing beyond.
    n_free = motion.y.shape[0]
    if work.n_active[0] == 0 and work.n_active[1] == 0:
        return system.longest if COUPLED else straight_length(system, motion, work)
    largest, rounding = 0.0, EPSILON / rtol
    for k in (ORDER - 1, ORDER):
        size = 0.0
        for a in range(work.n_active[0]):
            i = work.active[a]
            own = max(system.order[n_free + i], rounding * abs(work.w[i, 0]))
            if not math.isfinite(work.w[i, k]):
                return 0.0
            size = max(size, abs(work.w[i, k]) / own)
        for a in range(work.n_active[1]):
            i = work.flowing[a]
            if moves(system, motion, i):  # else w bends y, and tells its size
                own = max(system.order[i], rounding * abs(work.z[i, 0]))
                if not math.isfinite(work.z[i, k]):
                    return 0.0
                size = max(size, abs(work.z[i, k]) / own)
        if COUPLED:  # forces that hold contacts follow from rates, which converge later
            for i in range(motion.mode.shape[0]):
                if motion.mode[i] == 0:
                    size = max(size, abs(work.joint.force[i, k]) / motion.limit[i])
        if size > 0.0:
            largest = max(largest, math.exp(math.log(size / rtol) / k))
    if largest == 0.0 and work.n_active[0] == 0 and not COUPLED:
        return straight_length(system, motion, work)
    return min(system.longest, 1.0 / largest) if largest > 0.0 else system.longest


@kernel
def straight_length(system: BlockSystem, motion: BlockMotion, work: BlockWork) -> float:
    """Step that no needed force can leave its limits in at once; inf where none changes.

    While all contacts stick the motion is linear: series that end are all of it, as in an
    integrator's ramp.
    """
    h = math.inf
    for i in range(motion.mode.shape[0]):
        if is_exposed(system, motion, work, i):
            ride_signal(system, motion, work, i, AT_UPPER_LIMIT)
            for k in range(1, ORDER + 1):
                size = abs(work.signal[k])
                if size * FOR_EVER > motion.limit[i]:
                    h = min(h, math.exp(math.log(motion.limit[i] / size) / k))
    return max(h, system.longest)


# --- events -----------------------------------------------------------------------------------


@kernel(inline=True)
def stay_on_pieces(
    system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork, h: float
) -> float:
    """Length of a step on which all laws stay smooth, at most `h`; <= 0 if a search failed."""
    if laws.shape[0] > motion.mode.shape[0]:
        for a in range(work.n_active[0]):
            i = work.active[a]
            if h > 0.0:
                slip_signal(motion, work, i)
                h = leaving_time(laws, i, work.signal, h, system.order[motion.y.shape[0] + i])
    return h


@kernel
def follows_laws(
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    h: float,
    rtol: float,
) -> bool:
    """Whether the series of all laws are those of the laws, as far as places on a step tell."""
    for a in range(work.n_active[0]):
        i = work.active[a]
        mode = motion.mode[i]
        row = piece_row(laws, i, mode * motion.w[i])
        order = system.order[motion.y.shape[0] + i]
        most = OFF * rtol * order * system.mass[i] / (motion.limit[i] * h)
        for k in range(1, PLACES + 1):
            s, told = at_place(k, h, mode, work.w[i], work.rows[i, FORCE_ROW, :ORDER])
            exact = force(laws[row], mode, max(s, 0.0))
            if s >= -OVERLAP * order and not is_followed(exact, told, most):
                return False
    return True


@kernel(inline=True)
def find_events(system: BlockSystem, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """Length of the step up to its first event, or all of it; negative if a search failed."""
    # ``motion.event`` names the event of each contact; events closer than rounding are one.
    motion.event[:] = 0
    for i in range(motion.mode.shape[0]):
        loaded = is_loaded(system, motion, i)
        if motion.mode[i] != 0:
            slip_signal(motion, work, i)
            slack = SLACK * EPSILON * system.order[motion.y.shape[0] + i]
            t = first_contact(work.signal, h, work.signal[0] == 0.0, slack)
            if FEET and system.foot[i] >= 0:
                if first_term(system, motion, work, i, 0, system.mass[i]) > ORDER:
                    t = 0.0  # its body has come to rest with another contact
            h = keep_first(motion, i, LANDING, t, h)
        elif COUPLED:
            pass  # below
        elif is_exposed(system, motion, work, i):
            if h == math.inf:
                continue  # nothing changes
            slack = SLACK * EPSILON * motion.limit[i]
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, motion, work, i, event)
                t = first_contact(work.signal, h, work.signal[0] == 0.0, slack)
                h = keep_first(motion, i, event, t, h)
        else:
            growth = straight_growth(system, motion, work, i)
            event = AT_UPPER_LIMIT if growth > 0.0 else AT_LOWER_LIMIT
            side = 1.0 if growth > 0.0 else -1.0
            if growth != 0.0:
                t = max((side * motion.limit[i] - motion.e[i]) / growth, 0.0)
                h = keep_first(motion, i, event, t if t <= h else NO_ROOT, h)
        if loaded and h >= 0.0:
            t = first_contact(work.limit[i], h, False, SLACK * EPSILON * motion.size[i])
            h = keep_first(motion, i, LOST, t, h)
        if h < 0.0:
            return h
    return find_mechanisms(system, motion, work, h) if COUPLED else h


@kernel
def find_mechanisms(system: BlockSystem, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """As `find_events`, of contacts that share inertia and begin to slip, after other events."""
    motion.joint.way[0] = 0
    none = True
    for i in range(motion.mode.shape[0]):
        none = none and motion.event[i] == 0
    for way in range(system.joint.mechanisms.shape[0]):
        for side in (1, -1):
            size = mechanism_signal(system, motion, work, way, side)
            if size == 0.0:
                continue
            t = first_contact(work.signal, h, work.signal[0] == 0.0, SLACK * EPSILON * size)
            if t == NO_ROOT:
                continue
            if t == UNFINISHED:
                return t
            if none or t < h - 2.0 * EPSILON * h:
                motion.event[:] = 0
                motion.joint.way[0] = side * (way + 1)
                none = False
            begin(system, motion, way, side)
            h = min(t, h)
    return h


@kernel
def mechanism_signal(
    system: BlockSystem, motion: BlockMotion, work: BlockWork, way: int, side: float
) -> float:
    """Distance of needed forces from what limits hold in a mechanism, a series; size of terms."""
    size = rounding = 0.0
    work.signal[:] = 0.0
    for i in range(motion.mode.shape[0]):
        share = side * system.joint.mechanisms[way, i]
        if motion.mode[i] == 0 and share != 0.0:
            size += abs(share) * motion.limit[i]
            rounding += abs(share) * force_tolerance(motion, i)
            for k in range(ORDER + 1):
                work.signal[k] += abs(share) * work.limit[i, k] - share * work.joint.force[i, k]
    if abs(work.signal[0]) <= rounding:
        work.signal[0] = 0.0
        if FEET:
            for i in range(motion.mode.shape[0]):
                if system.joint.mechanisms[way, i] != 0.0 and motion.mode[i] == 0:
                    calm(system, motion, work, i)
    return size


@kernel(inline=True)
def is_exposed(system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int) -> bool:
    """Whether a sticking contact's needed force or limit is anything but a straight line."""
    row, n_free = needed_row(motion, block), motion.y.shape[0]
    if is_loaded(system, motion, block) or (FEET and system.foot[block] >= 0):
        return True
    for entry in range(system.first[row], system.first[row + 1]):
        j = system.column[entry]
        if work.bends[j] if j < n_free else motion.mode[j - n_free] != 0:
            return True
    return False


@kernel(inline=True)
def straight_growth(system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int) -> float:
    """Rate of a needed force that is a straight line."""
    row = needed_row(motion, block)
    total = 0.0
    for entry in range(system.first[row], system.first[row + 1]):
        total += system.entry[entry] * work.z[system.column[entry], 1]
    return total


@kernel(inline=True)
def slip_signal(motion: BlockMotion, work: BlockWork, block: int) -> None:
    """|w| of a slipping contact, a series."""
    for k in range(ORDER + 1):
        work.signal[k] = motion.mode[block] * work.w[block, k]


@kernel(inline=True)
def ride_signal(
    system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int, event: int
) -> None:
    """Distance of a sticking contact's needed force from its upper or lower limit, a series."""
    sign = -1.0 if event == AT_UPPER_LIMIT else 1.0
    work.signal[0] = motion.limit[block] + sign * motion.e[block]
    for k in range(1, ORDER + 1):
        work.signal[k] = sign * row_coefficient(system, work, needed_row(motion, block), k)
    if is_loaded(system, motion, block):
        for k in range(1, ORDER + 1):
            work.signal[k] += work.limit[block, k]
    if FEET and work.signal[0] == 0.0:
        calm(system, motion, work, block)


@kernel
def calm(system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int) -> None:
    """Take rounding out of the rates of a signal at 0 of a foot, as where it has just landed."""
    if system.foot[block] < 0:
        return
    first = first_term(system, motion, work, block, 1, 1.0)
    for k in range(1, first):
        work.signal[k] = 0.0
    if first > ORDER:
        work.signal[0] = 1.0  # the body rests, and the foot stays at its limit


@kernel
def first_term(
    system: BlockSystem, motion: BlockMotion, work: BlockWork, block: int, start: int, unit: float
) -> int:
    """First coefficient of a foot's signal, in this unit, that rounding does not explain."""
    size = system.mass[block]
    for row in (needed_row(motion, block), limit_row(motion, block)):
        for entry in range(system.first[row], system.first[row + 1]):
            _, terms = row_value(system, motion, system.column[entry])
            size += abs(system.entry[entry]) * terms
    for k in range(start, ORDER + 1):
        if unit * abs(work.signal[k]) > FORCE_ROUNDING * EPSILON * size:
            return k
    return ORDER + 1


@kernel(inline=True)
def keep_first(motion: BlockMotion, block: int, event: int, t: float, h: float) -> float:
    """Note an event at `t` unless there is an earlier one; return the step's new length."""
    if t == NO_ROOT:
        return h
    if t == UNFINISHED:
        return t
    if h == math.inf or t < h - 2.0 * EPSILON * h:
        motion.event[:] = 0
    motion.event[block] = event
    return min(t, h)


@kernel
def watch_step(system: BlockSystem, motion: BlockMotion, work: BlockWork, h: float) -> float:
    """Smallest clearance on a step: lobes of |w| that turned back, extremes of riders."""
    margin = math.inf
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != 0:
            slip_signal(motion, work, i)
            margin = min(margin, clearance(work.signal, h) / work.watch[1])
        elif is_exposed(system, motion, work, i):
            for event in (AT_UPPER_LIMIT, AT_LOWER_LIMIT):
                ride_signal(system, motion, work, i, event)
                margin = min(margin, clearance(work.signal, h) / work.watch[2 + i])
    return margin


# --- tangents ---------------------------------------------------------------------------------


@kernel
def tangents(
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    h: float,
) -> None:
    """Carry every tangent column over the step by its own Taylor series."""
    law_gradients(laws, motion, work)
    if COUPLED:
        for j in range(motion.mode.shape[0]):
            _, motion.joint.rate[j], _ = jet(work.joint.drive[j], h)
    n_columns = motion.tangent_z.shape[1]
    for first in range(0, n_columns, GROUP):
        last = min(first + GROUP, n_columns)
        tangent_series(system, motion, work, first, last)
        for j in range(motion.z.shape[0]):
            values_of_group(work.d_z[j], h, work.d_row)
            for column in range(first, last):
                motion.tangent_z[j, column] = work.d_row[column - first]
        if COUPLED:
            for j in range(motion.mode.shape[0]):
                values_of_group(work.joint.d_drive[j], h, work.d_row)
                for column in range(first, last):
                    motion.joint.tangent[j, column] = work.d_row[column - first]


@kernel
def tangents_at_times(
    system: BlockSystem,
    laws: Floats,
    motion: BlockMotion,
    work: BlockWork,
    steps: TangentSteps,
    step: Ints,
    t: Floats,
    z: Floats,
    moved: Floats,
) -> None:
    """Find (y, w) and its derivatives at fixed times `t` since the starts of ascending steps."""
    waves = 2 * system.frequency.shape[0]
    first = 0
    while first < t.shape[0]:
        end = first
        while end < t.shape[0] and step[end] == step[first]:
            end += 1
        place_step(motion, steps, step[first])
        refresh(system, laws, motion)
        list_active(system, motion, work)
        expand(system, laws, motion, work)
        law_gradients(laws, motion, work)
        for k in range(first, end):
            for j in range(waves, motion.z.shape[0]):
                here, rate, _ = jet(work.z[j], t[k])
                z[k, j - waves] = here
                for column in range(motion.tangent_z.shape[1]):
                    moved[k, j - waves, column] = -rate * motion.tangent_clock[column]
        n_columns = motion.tangent_z.shape[1]
        for group in range(0, n_columns, GROUP):
            last = min(group + GROUP, n_columns)
            tangent_series(system, motion, work, group, last)
            for k in range(first, end):
                for j in range(waves, motion.z.shape[0]):
                    values_of_group(work.d_z[j], t[k], work.d_row)
                    for column in range(group, last):
                        moved[k, j - waves, column] += work.d_row[column - group]
        first = end


@kernel(inline=True)
def place_step(motion: BlockMotion, steps: TangentSteps, k: int) -> None:
    """Take the start of a step that was kept as the present state."""
    waves = motion.z.shape[0] - steps.z.shape[1]
    for j in range(steps.z.shape[1]):
        motion.z[waves + j] = steps.z[k, j]
    for i in range(motion.mode.shape[0]):
        motion.mode[i] = steps.mode[k, i]
        motion.event[i] = 0
    motion.clock[0] = steps.t[k]
    for column in range(motion.tangent_clock.shape[0]):
        motion.tangent_clock[column] = steps.clock[k, column]
        for j in range(motion.z.shape[0]):
            motion.tangent_z[j, column] = steps.tangent[k, j, column]


@kernel
def law_gradients(laws: Floats, motion: BlockMotion, work: BlockWork) -> None:
    """Series of the derivatives of laws over the step that has been expanded."""
    varied = False
    for column in range(motion.directions.varies.shape[0]):
        varied = varied or motion.directions.varies[column]
    for a in range(work.n_active[0]):
        i = work.active[a]
        mode = motion.mode[i]
        work.rows[i, 0, ORDER] = mode * work.w[i, ORDER]
        row = piece_row(laws, i, mode * motion.w[i])
        series(laws[row], mode, work.rows[i], ORDER)
        series_tangent(laws[row], mode, work.rows[i], ORDER, varied)


@kernel(inline=True)
def values_of_group(c: Floats, t: float, values: Floats) -> None:
    """Sum ``c[k] t^k`` for each of a group of tangents."""
    # Here and below the group is written out: of four sums the compiler makes one of vectors.
    p = q = r = s = 0.0
    for k in range(c.shape[0] - 1, -1, -1):
        p = p * t + c[k, 0]
        q = q * t + c[k, 1]
        r = r * t + c[k, 2]
        s = s * t + c[k, 3]
    values[0], values[1], values[2], values[3] = p, q, r, s


@kernel
def tangent_series(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    first: int,
    last: int,
) -> None:
    """Series of a group of tangent columns: the linearised equations, driven by their directions.

    Columns from `last` on are zeros.
    """
    # All of a group is written at once: to read it together, a processor waits for single entries.
    d_z, d_w = work.d_z, work.d_w
    n_varied = 0  # columns of the group up to the last whose parameters vary
    for column in range(first, last):
        if motion.directions.varies[column]:
            n_varied = column - first + 1
    for j in range(motion.z.shape[0]):
        d_z[j] = 0.0
        for column in range(first, last):
            d_z[j, 0, column - first] = motion.tangent_z[j, column]
    for i in range(motion.y.shape[0]):
        if not work.bends[i]:
            row_tangents(system, motion, work, i, first, n_varied, 0, d_z[i, 1])
    for k in range(ORDER + COUPLED):
        if FEET:
            foot_tangents(system, motion, work, first, n_varied, k)
        for a in range(work.n_active[0]):
            i = work.active[a]
            pulls = work.joint.d_drive[i, k] if COUPLED else d_w[i, k + 1]
            friction_tangents(system, motion, work, i, first, n_varied, k, pulls)
            if not COUPLED and not (FEET and system.foot[i] >= 0):
                row = needed_row(motion, i)
                row_tangents(system, motion, work, row, first, n_varied, k, work.d_row)
                for c in range(GROUP):
                    pulls[c] -= work.d_row[c]
                for c in range(n_varied):
                    change = motion.directions.mass[first + c, i]
                    pulls[c] -= change * (k + 1) * work.w[i, k + 1]
                for c in range(GROUP):
                    pulls[c] /= system.mass[i] * (k + 1)
        if COUPLED:
            couple_tangents(system, motion, work, first, n_varied, k)
        if k == ORDER:
            break
        for a in range(work.n_active[1]):
            i = work.flowing[a]
            row_tangents(system, motion, work, i, first, n_varied, k, d_z[i, k + 1])
            for c in range(GROUP):
                d_z[i, k + 1, c] /= k + 1
    if FEET and not COUPLED:
        foot_tangents(system, motion, work, first, n_varied, ORDER)


@kernel
def foot_tangents(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    first: int,
    n_varied: int,
    k: int,
) -> None:
    """Differentiate `expand_feet`, and for k = 0 where the feet are."""
    for a in range(work.n_active[0]):
        i = work.active[a]
        if system.foot[i] < 0:
            continue
        d_w = work.d_w[i, k]
        d_w[:] = 0.0
        needed, limit = needed_row(motion, i), limit_row(motion, i)
        own, of_limit = work.d_rates[0], work.d_rates[1]
        if k == 0:
            foot = work.d_z[system.foot[i], 0]
            friction_tangents(system, motion, work, i, first, n_varied, 0, own)
            row_tangents(system, motion, work, needed, first, n_varied, 0, work.d_row)
            for c in range(GROUP):
                foot[c] -= (work.d_row[c] - own[c]) / system.mass[i]
        share = motion.mode[i] * work.rows[i, FORCE_ROW, 0]
        rate_tangents(system, motion, work, needed, first, n_varied, k, own)
        rate_tangents(system, motion, work, limit, first, n_varied, k, of_limit)
        for c in range(GROUP):
            d_w[c] = own[c] + share * of_limit[c]
        for c in range(n_varied):
            change = 0.0
            for j in range(motion.directions.laws.shape[2]):
                d_parameter = motion.directions.laws[first + c, i, j]
                change += d_parameter * work.rows[i, GRADIENT_ROW + j, 0]
            d_w[c] += motion.mode[i] * change * rate_coefficient(system, work, limit, k)
        for c in range(GROUP):
            d_w[c] = -d_w[c] / system.mass[i]


@kernel
def rate_tangents(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    row: int,
    first: int,
    n_varied: int,
    k: int,
    rates: Floats,
) -> None:
    """Coefficient k of the derivatives of the rate of a row that depends on y alone."""
    rates[:] = 0.0
    for entry in range(system.first[row], system.first[row + 1]):
        row_tangents(system, motion, work, system.column[entry], first, n_varied, k, work.d_row)
        for c in range(GROUP):
            rates[c] += system.entry[entry] * work.d_row[c]
    for c in range(n_varied):
        places = motion.directions.first[first + c]
        for entry in range(places[row], places[row + 1]):
            own = motion.directions.column[entry]
            rates[c] += motion.directions.entry[entry] * row_coefficient(system, work, own, k)


@kernel
def couple_tangents(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    first: int,
    n_varied: int,
    k: int,
) -> None:
    """Differentiate what `couple_series` finds."""
    joint, n = motion.joint, motion.mode.shape[0]
    for i in range(n):
        own = work.joint.d_own[i]
        row_tangents(system, motion, work, needed_row(motion, i), first, n_varied, k, own)
        for c in range(n_varied):
            for j in range(n):
                own[c] -= motion.directions.coupling[first + c, i, j] * work.joint.force[j, k]
        if motion.mode[i] == 0:
            for c in range(GROUP):
                work.joint.d_drive[i, k, c] = own[c] if joint.bears[i] else 0.0
    for i in range(n):
        if FEET and system.foot[i] >= 0:
            continue
        if motion.mode[i] != 0 and k < ORDER:
            pulls = work.d_w[i, k + 1]
            for c in range(GROUP):
                pulls[c] = -work.joint.d_own[i, c]
            for c in range(n_varied):
                change = motion.directions.mass[first + c, i]
                pulls[c] -= change * (k + 1) * work.w[i, k + 1]
            for j in range(n):
                for c in range(GROUP):
                    pulls[c] += joint.response[i, j] * work.joint.d_drive[j, k, c]
            for c in range(GROUP):
                pulls[c] /= system.mass[i] * (k + 1)


@kernel(inline=True)
def row_tangents(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    row: int,
    first: int,
    n_varied: int,
    k: int,
    total: Floats,
) -> None:
    """Coefficient k of the derivatives of a row."""
    d_z = work.d_z
    p = q = r = s = 0.0
    for entry in range(system.first[row], system.first[row + 1]):
        share, j = system.entry[entry], system.column[entry]
        p += share * d_z[j, k, 0]
        q += share * d_z[j, k, 1]
        r += share * d_z[j, k, 2]
        s += share * d_z[j, k, 3]
    total[0], total[1], total[2], total[3] = p, q, r, s
    for c in range(n_varied):
        if k == 0:
            total[c] += motion.directions.constant[first + c, row]
        places = motion.directions.first[first + c]
        for entry in range(places[row], places[row + 1]):
            total[c] += motion.directions.entry[entry] * work.z[motion.directions.column[entry], k]


@kernel(inline=True)
def friction_tangents(
    system: BlockSystem,
    motion: BlockMotion,
    work: BlockWork,
    block: int,
    first: int,
    n_varied: int,
    k: int,
    total: Floats,
) -> None:
    """Coefficient k of the derivatives of the force -mode L F(mode w; parameters)."""
    mode, slope, d_w = motion.mode[block], work.rows[block, SLOPE_ROW], work.d_w[block]
    p = q = r = s = 0.0
    for j in range(k + 1):
        p += slope[j] * d_w[k - j, 0]
        q += slope[j] * d_w[k - j, 1]
        r += slope[j] * d_w[k - j, 2]
        s += slope[j] * d_w[k - j, 3]
    changed = work.d_force[block, k]
    changed[0], changed[1], changed[2], changed[3] = mode * p, mode * q, mode * r, mode * s
    for c in range(GROUP):
        total[c] = -mode * motion.limit[block] * changed[c]
    loaded = is_loaded(system, motion, block)
    if loaded or n_varied > 0:
        row = limit_row(motion, block)
        row_tangents(system, motion, work, row, first, n_varied, k, work.d_limit[block, k])
        for c in range(GROUP if loaded else n_varied):
            total[c] = -mode * varied_friction(motion, work, block, first, n_varied, c, k)


@kernel
def varied_friction(
    motion: BlockMotion, work: BlockWork, block: int, first: int, n_varied: int, c: int, k: int
) -> float:
    """Coefficient k of the derivative of L F where parameters or L vary too."""
    # ``work.d_force`` holds that of F by the speed, ``work.d_limit`` that of L.
    d_limit, d_force = work.d_limit[block], work.d_force[block]
    if c < n_varied:
        for j in range(motion.directions.laws.shape[2]):
            d_parameter = motion.directions.laws[first + c, block, j]
            if d_parameter != 0.0:
                d_force[k, c] += d_parameter * work.rows[block, GRADIENT_ROW + j, k]
    changed = 0.0
    for j in range(k + 1):
        changed += work.limit[block, j] * d_force[k - j, c]
        changed += d_limit[j, c] * work.rows[block, FORCE_ROW, k - j]
    return changed


# --- what the driver of a motion asks ------------------------------------------------------------


@kernel
def landing_rate(system: BlockSystem, laws: Floats, motion: BlockMotion, block: int) -> float:
    """Rate w' of a slipping contact as its relative velocity reaches 0."""
    mode = motion.mode[block]
    drive = -mode * motion.limit[block] * static_value(laws[block], mode)
    return (drive - motion.e[block]) / system.mass[block]


@kernel
def slides_for_ever(
    system: BlockSystem, laws: Floats, motion: BlockMotion, work: BlockWork
) -> bool:
    """Whether blocks that all slip backward can be shown never to reach the belt again."""
    # The energy of deviations from steady sliding bounds every speed: docs/theory/blocks.md.
    n = motion.mode.shape[0]
    if system.inverse.shape[0] == 0:
        return False
    deviation = work.deviation
    energy = 0.0
    for i in range(n):
        if motion.mode[i] != -1:
            return False
        V = system.V[i]
        v = motion.w[i] + V
        energy += system.mass[i] * v * v
        deviation[i] = motion.e[i] - motion.limit[i] * force(laws[piece_row(laws, i, V)], -1, V)
        row = needed_row(motion, i)
        for entry in range(system.first[row], system.first[row + 1]):
            j = system.column[entry] - n
            if j >= 0:
                deviation[i] -= system.entry[entry] * (motion.w[j] + system.V[j])
    for i in range(n):
        for j in range(n):
            energy += deviation[i] * system.inverse[i, j] * deviation[j]
    falls = False
    for i in range(n):
        reach = math.sqrt(energy / system.mass[i])
        V = system.V[i]
        if not reach < V * (1.0 - CLEARANCE):
            return False
        steepest = least_slope(laws, i, V - reach, V + reach)
        work.deviation[i] = motion.limit[i] * steepest
        falls = falls or steepest < 0.0
    return damping_outweighs(system, motion, work) if falls else True


@kernel
def damping_outweighs(system: BlockSystem, motion: BlockMotion, work: BlockWork) -> bool:
    """Whether C plus the slopes in ``work.deviation`` is positive definite (by Cholesky)."""
    factor = work.factor
    n = factor.shape[0]
    for i in range(n):
        factor[i] = 0.0
        row = needed_row(motion, i)
        for entry in range(system.first[row], system.first[row + 1]):
            if system.column[entry] >= n:
                factor[i, system.column[entry] - n] = system.entry[entry]
        factor[i, i] += work.deviation[i]
        for j in range(i + 1):
            rest = factor[i, j]
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            if j < i:
                factor[i, j] = rest / factor[j, j]
            elif not rest > 0.0:
                return False
            else:
                factor[i, i] = math.sqrt(rest)
    return True
