"""How close a motion comes to a change of modes, and the cycle with other modes beside one."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from stickslip.mechanics.cycle.section import SAME, Section, Shooting, coordinates, word_of
from stickslip.mechanics.cycle.shooting import Shooter, State, sizes_of
from stickslip.mechanics.flow.system import AT_LOWER_LIMIT, AT_UPPER_LIMIT, LANDING, MAX_INSTANT
from stickslip.mechanics.model.orders import orders
from stickslip.numerics.continuation import ArclengthCurve, CurvePoint, LeavesRegion, StepTooLong
from stickslip.numerics.polynomial import NO_ROOT, jet, lowest_minimum, value

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.cycle.section import Shot
    from stickslip.numerics.arrays import Floats

TouchKind: TypeAlias = Literal["grazing", "limit", "landing", "tie"]

NOT_SOLVED: Final = (
    "the cycle cannot be solved for with its own sequence of modes: it stands at a bifurcation, "
    "touches a change of modes, turns round only where modes change, or has a contact that never "
    "slips and could rest elsewhere"
)
SIDES: Final = ((AT_UPPER_LIMIT, -1.0), (AT_LOWER_LIMIT, 1.0))


class Touch(NamedTuple):
    """A place of a motion that is about to change its modes."""

    # grazing: a slip turns back `room` (of velocity) before the belt, or beyond it (negative).
    # limit: a rider's needed force turns back. landing: static limit to spare; negative: no stick.
    # tie: two blocks have events `room` apart in time. All in orders of magnitude of the plant.
    kind: TouchKind
    time: float
    block: int  # from 0
    room: float


def touches(shooter: Shooter, state: State, duration: float) -> list[Touch]:
    """Collect them along a motion, by ascending size of the room."""
    motion, feet = shooter.motion, shooter.model.plant.elastic
    shooter.place(state)
    alone = motion.joint is None and not feet  # else an event may bring about another one
    found: list[Touch] = []
    t, last, instant = 0.0, (-np.inf, -1), 0
    while t < duration:
        mode, needed = motion.mode.copy(), motion.e.copy()
        h, status = shooter.follow(0.0, duration - t, steps=1)
        instant = instant + 1 if h == 0.0 else 0
        if status or instant > MAX_INSTANT * shooter.n_contacts:
            break
        for block in range(shooter.n_contacts):
            found += _inside(shooter, block, int(mode[block]), float(needed[block]), t, h)
        t += h
        if motion.event.any():
            at_once = alone and np.count_nonzero(motion.event) > 1
            # Who lands without a step has just left, to rounding, or ties with another one.
            event = motion.event if h > 0.0 else np.zeros_like(motion.event)
            for i in map(int, np.flatnonzero(event == LANDING)):
                # A foot that comes to rest is at its kinetic force, with F(0) = 1 at its limit, and
                # sticks: the force turns back as the velocity does.
                if i not in feet:
                    spare = float(motion.limit[i] - abs(motion.e[i]))
                    found.append(Touch("landing", t, i, spare))
                found += _barely_reached("grazing", mode[i] * shooter.work.w[i], t, i, h)
            for side, sign in SIDES:
                for i in map(int, np.flatnonzero((event == side) & (mode == 0))):
                    room = _room(shooter, i, float(needed[i]), sign)
                    found += _barely_reached("limit", room, t, i, h)
            shooter.engine.settle(motion, shooter.work)
            changed = np.flatnonzero(motion.mode != mode)
            for i in changed[:1]:
                if at_once or (i != last[1] and (alone or t > last[0])):
                    found.append(Touch("tie", t, int(i), 0.0 if at_once else t - last[0]))
                last = (t, int(i))
    known = orders(shooter.model.plant)

    def in_orders(touch: Touch) -> Touch:
        forces = known.force[touch.block]
        unit = {"grazing": known.velocity, "tie": known.time}.get(touch.kind, forces)
        return touch._replace(room=float(touch.room / unit))

    return sorted(map(in_orders, found), key=lambda touch: abs(touch.room))


def _barely_reached(
    kind: TouchKind, signal: Floats, time: float, block: int, h: float
) -> list[Touch]:
    """How far beyond belt or limit a slip or a force would have turned back, cut at t^2."""
    _, slope, curvature = jet(signal, h)
    if curvature <= 0.0:
        return []
    return [Touch(kind, time, block, -(slope**2) / (2.0 * curvature))]


def _room(shooter: Shooter, block: int, needed: float, sign: float) -> Floats:
    """Series of what is left between a rider's needed force and one of its limits."""
    motion, work, kernels = shooter.motion, shooter.work, shooter.engine.kernels
    if work.joint is not None:
        force = work.joint.force[block]
    else:
        row, powers = motion.y.size + block, range(1, kernels.ORDER + 1)
        later = (kernels.row_coefficient(shooter.system, work, row, k) for k in powers)
        force = np.array([needed, *later])
    return np.asarray(work.limit[block] + sign * force)


def _inside(
    shooter: Shooter, block: int, mode: int, needed: float, start: float, h: float
) -> list[Touch]:
    """List turning points of one block's signals inside a step."""
    work = shooter.work
    signals: list[tuple[TouchKind, Floats]]
    if mode != 0:
        signals = [("grazing", mode * work.w[block])]
    else:
        signals = [("limit", _room(shooter, block, needed, sign)) for _, sign in SIDES]
        if block in shooter.model.plant.elastic:  # at its limit it has just landed, and turns back
            signals = [each for each in signals if each[1][0] > ROUNDING * work.limit[block][0]]
    found = []
    for kind, signal in signals:
        at = lowest_minimum(signal, h)
        if at != NO_ROOT:
            found.append(Touch(kind, start + at, block, float(value(signal, at))))
    return found


SAMPLES: Final = 48  # per radian of the slowest contact, when extremes are looked for
FAR: Final = 0.1  # of the period: an event this far from the section is far
BESIDE: Final = 1e-6  # of the range: how far beside a change of modes cycles are sought
SCALES: Final = tuple(10.0**k for k in range(-8, -1))  # of displacements from the cycle there
N_DIRECTIONS: Final = 3
SEED: Final = 1998
CLOSER: Final = 1 / 16  # of that: where the cycle found must be nearer to the one at the change,
SHRINKS: Final = 0.6  # at this share of the distance (a square root: a quarter)
ROUNDING: Final = 1e-10
SOLVED: Final = 1e-11  # residual of a cycle, of the states' sizes
PAIR: Final = "; so far symmetric, it stays so: two other cycles, mirror images, meet it there"
ALONE: Final = "; so far symmetric, it is not from there on"


def on_section(cycle: Cycle, name: str, *, rtol: float = 1e-15) -> tuple[Shooting, Floats]:
    """Equations of a cycle along a parameter, with its sequence of modes, and its unknowns."""
    model, plant = cycle.model, cycle.model.plant
    shooter = Shooter(model, rtol=rtol, tangents=False)
    start = shooter.start(cycle.x, cycle.v)
    time, along = beginning(cycle)
    rounds = round(cycle.period / plant.period) if plant.is_forced else 1
    if time > 0.0:
        start = shooter.leg(start, max_time=time).state
    section = Section.through(plant, start, along)
    start = start._replace(t=section.time)
    leg = shooter.leg(start, max_time=cycle.period)
    shooting = Shooting(model, name, section, word=word_of(leg), rounds=rounds, rtol=rtol)
    return shooting, shooting.unknowns(start, cycle.period, model.parameters[name])


def beginning(cycle: Cycle) -> tuple[float, Floats | None]:
    """Time since the start of a cycle at which its section is, and what is extreme there."""
    if cycle.model.plant.is_forced:
        return between_events([event.time for event in cycle.events], cycle.period), None
    return _extreme(cycle)


def between_events(times: Sequence[float], period: float) -> float:
    """Time in the middle of the longest way from an event of a cycle to the next."""
    if not times:
        return 0.0
    ways = np.diff(times, append=times[0] + period)
    k = int(np.argmax(ways))
    return float((times[k] + 0.5 * ways[k]) % period)


def _extreme(cycle: Cycle) -> tuple[float, Floats]:
    """Time at which a coordinate is extreme, and the coordinate: sharp, and far from events."""
    trajectory, plant = cycle.trajectory, cycle.model.plant

    def rate(time: Floats | float) -> Floats:
        return plant.rows(plant.coordinates(trajectory.x(time), trajectory.v(time)))[0]

    t = np.linspace(0.0, cycle.period, max(400, int(SAMPLES * cycle.period / orders(plant).time)))
    rows, events = coordinates(plant), np.array([event.time for event in cycle.events])
    values, best = rate(t) @ rows.T, (-1.0, 0.0, 0)
    for k in range(len(rows)):
        v = values[:, k]
        for i in np.flatnonzero(v[:-1] * v[1:] <= 0.0):
            sharpness = abs(v[i + 1] - v[i]) / (t[i + 1] - t[i])
            apart = np.abs((t[i] - events + 0.5 * cycle.period) % cycle.period - 0.5 * cycle.period)
            room = min(float(apart.min(initial=np.inf)), FAR * cycle.period)
            best = max(best, (float(sharpness) * room, float(t[i]), k))
    _, near, k = best

    def speed(time: float) -> float:
        return float(rate(time) @ rows[k])

    after = min(near + t[1], cycle.period)
    if speed(near) * speed(after) >= 0.0:
        return (near if abs(speed(near)) < abs(speed(after)) else after), rows[k]
    from scipy.optimize import brentq  # not for the first value

    return float(brentq(speed, near, after, xtol=1e-14)), rows[k]


class Partner(NamedTuple):
    """A cycle with other modes beside a change of modes: its equations, unknowns, way on."""

    shooting: Shooting
    y: Floats
    outcome: Literal["persists", "fold"]
    rising: bool
    # What a mirror symmetry, x(t + T/2) = -x(t), that the cycle has up to here adds.
    symmetry: str = ""


def partners(shooting: Shooting, point: CurvePoint, ends: tuple[float, float]) -> Partner | None:
    """Look for the cycle with other modes that a cycle meets or becomes."""
    word = shooting.word
    if word is None or not is_mirrored(point.note):
        return _partner(shooting, point, ends)
    # Both halves change their modes at once: of their cycles with one stick more or less, one
    # is symmetric, others come in pairs.
    half = replace(shooting, word=word[: len(word) // 2], mirrored=True)
    alike, unlike = _partner(half, point, ends), _partner(shooting, point, ends, symmetric=False)
    if alike is not None:
        told = "" if unlike is None else PAIR
        return alike._replace(shooting=_whole(alike.shooting), symmetry=told)
    return None if unlike is None else unlike._replace(symmetry=ALONE)


def is_mirrored(shot: Shot) -> bool:
    """Tell whether the second half of a cycle is the mirror image of the first, by its events."""
    events, half = shot.leg.events, 0.5 * shot.leg.duration
    first, second = events[: len(events) // 2], events[len(events) // 2 :]
    return (
        bool(events)
        and len(first) == len(second)
        and all(
            a[1:] == (b[1], -b[2]) and abs(b[0] - a[0] - half) <= np.sqrt(SAME) * half
            for a, b in zip(first, second, strict=True)
        )
    )


def _whole(shooting: Shooting) -> Shooting:
    """Equations of all of a cycle."""
    if not shooting.mirrored:
        return shooting
    half = shooting.word or ()
    turned = tuple((block, -mode) for block, mode in half)
    return replace(shooting, word=half + turned, mirrored=False)


def _partner(
    shooting: Shooting, point: CurvePoint, ends: tuple[float, float], *, symmetric: bool = True
) -> Partner | None:
    # Newton's method starts just beyond the change, then just before: there both may meet and
    # vanish.
    ahead = 1.0 if point.tangent[-1] > 0.0 else -1.0
    free = replace(shooting, word=None)
    width = ends[1] - ends[0]
    sides: tuple[tuple[Literal["persists", "fold"], float], ...] = (
        ("persists", ahead),
        ("fold", -ahead),
    )

    def wanted(y: Floats) -> bool:
        shot = free.shot(y)
        there = _whole(replace(shooting, word=shot.word))
        if same_modes(there, _whole(shooting)) or repeats(there, y):
            return False
        return symmetric or not is_mirrored(shot)

    for outcome, way in sides:
        value = point.parameter + way * BESIDE * width
        if not ends[0] <= value <= ends[1]:
            continue
        y = _beside(free, wanted, point, value, width)
        if y is not None:
            found = replace(shooting, word=free.shot(y).word)
            return Partner(found, y, outcome, way > 0.0)
    return None


def same_modes(one: Shooting, other: Shooting) -> bool:
    """Tell whether cycles have the same modes in turn: begun later one may be the other."""
    a, b = one.word or (), other.word or ()
    return any(a[k:] + a[:k] == b for k in range(len(a) or 1))


def repeats(shooting: Shooting, y: Floats) -> bool:
    """Tell whether a cycle closes in a part of its period."""
    word, free = shooting.word or (), shooting.free
    for k in range(2, (len(word) if free else shooting.rounds) + 1):
        first, shorter = word[: len(word) // k], y.copy()
        if k * first == word and (free or shooting.rounds % k == 0):
            shorter[shooting.n_states : -1] /= k
            one = replace(shooting, word=first, rounds=1 if free else shooting.rounds // k)
            if _solves(one, shorter):
                return True
    return False


def _beside(
    free: Shooting, wanted: Callable[[Floats], bool], point: CurvePoint, value: float, width: float
) -> Floats | None:
    """Cycle with other modes at a parameter beside a change, which tends to the one there."""
    scale = free.scale(width, point.y)
    for guess in _guesses(free, point, value):
        y = converged(free, guess, width)
        if y is None or not wanted(y):
            continue
        nearer = y.copy()
        nearer[-1] += (1.0 - CLOSER) * (point.parameter - value)
        limit = converged(free, nearer, width)
        far, near = (
            np.inf if z is None else float(np.abs((z - point.y) / scale)[:-1].max())
            for z in (y, limit)
        )
        if near <= SHRINKS * far + ROUNDING:
            return y
    return None


def _guesses(free: Shooting, point: CurvePoint, value: float) -> Iterator[Floats]:
    """Yield starts about the cycle at a change, near ones first, each also a period later."""
    n_states = free.n_states
    sizes = np.abs(free.section.ways).T @ sizes_of(free.model.plant)
    plain = np.append(point.y[:-1], value)
    directions = np.random.default_rng(SEED).normal(size=(N_DIRECTIONS, n_states))
    for scale, direction, sign in itertools.product(SCALES, directions, (1.0, -1.0)):
        guess = plain.copy()
        guess[:n_states] += sign * scale * sizes * direction
        yield guess
        try:
            yield _once_around(free, guess)
        except ValueError:
            continue


def converged(shooting: Shooting, guess: Floats, width: float) -> Floats | None:
    """Cycle at the parameter of a guess, of whatever modes."""
    try:
        y = ArclengthCurve(shooting, shooting.scale(width, guess)).point(guess).y
    except (LeavesRegion, StepTooLong, ValueError):
        return None
    # Where the curve turns back just there the point found has another parameter; steps to and
    # fro across a change of modes may look like rounding, but leave a residual.
    there = abs(y[-1] - guess[-1]) <= 1e-12 * width
    return y if there and _solves(shooting, y) else None


def _solves(shooting: Shooting, y: Floats) -> bool:
    """Tell whether a motion closes, with the modes that it must have."""
    own = slice(shooting.n_states)
    try:
        off = shooting(y)[0][own] / shooting.scale(1.0, y)[own]
    except (LeavesRegion, ValueError):
        return False
    return float(np.abs(off).max(initial=0.0)) <= SOLVED


def _once_around(shooting: Shooting, guess: Floats) -> Floats:
    """Replace a guess by where its motion is one period later: sticking leads onto the cycle."""
    model, state, period = shooting.start(guess)
    shooter = Shooter(model, rtol=shooting.rtol, tangents=False)
    end: State = shooter.leg(state, max_time=period).state
    if (end.mode != state.mode).any():
        return guess
    return shooting.unknowns(end, period, float(guess[-1]))
