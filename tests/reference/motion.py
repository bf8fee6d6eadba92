"""One step of the event map: phases between events, and the rules that join them.

Design, section 3, rules 1-6, for two blocks on a belt. What moves inside a phase is the business
of `coulomb.py` and `law9.py`; here are only the limits, the contacts and who changes mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from flint import arb

from .precision import TIE, exact
from .roots import NotPositive

Pair = tuple[arb, arb]
Modes = tuple[int, int]
MARK = {0: ".", -1: "-", 1: "+"}

OK = "OK"
NEVER_SLIPPING = "NEVER_SLIPPING"
NEVER_CYCLE = "NEVER_CYCLE"
EVENT_LIMIT = "EVENT_LIMIT"
TIME_LIMIT = "TIME_LIMIT"
UNDECIDED = "UNDECIDED"

# A cycle without global stick (rule 6 asks for 1e-10 and a contracting loop): the state comes back
# closer than this, and came back closer each of the last three times by this factor.
RECURS = 1e-16
CONTRACTS = 0.9
LONGEST_LOOP = 64  # events


@dataclass(frozen=True)
class Event:
    """A change of mode: when, where, from what to what."""

    time: arb
    x: Pair
    v: Pair
    before: Modes
    after: Modes


@dataclass(frozen=True)
class Motion:
    """What became of one start ``d``."""

    status: str
    value: arb | None
    events: tuple[Event, ...]
    phases: tuple[tuple[Phase, arb], ...] = field(repr=False)  # each with its length
    explored: float  # the motion is known up to this time

    @property
    def itinerary(self) -> str:
        """Modes after each event, as "-. -- .- .."."""
        return " ".join(MARK[e.after[0]] + MARK[e.after[1]] for e in self.events)

    @property
    def n_events(self) -> int:
        """Changes of mode after the onset."""
        return len(self.events) - 1

    @property
    def duration(self) -> arb:
        """Time from the onset to the last event."""
        return self.events[-1].time


class Phase(Protocol):
    """A stretch of motion with constant modes, from time 0 of its own clock."""

    def first_event(self, longest: arb) -> tuple[arb, frozenset[int]] | None:
        """When, and at which blocks, the first contact or limit comes; None: later than that."""

    def state(self, t: arb) -> tuple[Pair, Pair]:
        """Positions and velocities."""

    def never_ends(self) -> bool:
        """Both blocks slip, and it is proved that neither reaches the belt's velocity."""


class Plant:
    """Two blocks and their springs and dampers: m X'' + C X' + K X = friction."""

    def __init__(
        self, mass: Pair, stiffness: tuple[Pair, Pair], damping: tuple[Pair, Pair], limits: Pair,
        V: arb,
    ) -> None:  # fmt: skip
        self.mass, self.stiffness, self.damping = mass, stiffness, damping
        self.limits, self.V = limits, V
        self.damped = any(c != 0 for row in damping for c in row)

    @property
    def ends(self) -> Pair:
        """Of the domain: d of the states at two limits of opposite kind."""
        (a, b), (c, d) = self.stiffness
        determinant = a * d - b * c
        found = []
        for sides in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            first, second = (
                side * limit - sum(row) * self.V
                for side, limit, row in zip(sides, self.limits, self.damping, strict=True)
            )
            found.append((second * (a + b) - first * (c + d)) / determinant)
        return min(found), max(found)


def equal(alpha: arb, beta: arb, V: arb) -> Plant:
    """The paper's two blocks (eqs. 5a-7a)."""
    zero = (arb(0), arb(0))
    rows = ((1 + alpha, -alpha), (-alpha, 1 + alpha))
    return Plant((arb(1), arb(1)), rows, (zero, zero), (arb(1), beta), V)


class System(Protocol):
    """Two blocks and their friction."""

    plant: Plant
    V: arb
    limits: Pair

    def phase(self, x: Pair, v: Pair, modes: Modes) -> Phase:
        """The motion from this state as long as the modes last."""

    def acceleration(self, block: int, x: Pair, v: Pair, mode: int) -> arb:
        """X'' of a slipping block."""


def need(system: System, block: int, x: Pair, v: Pair) -> arb:
    """R: the friction force the block needs in order to stay with the belt (eq. 6a)."""
    (first, second), plant = system.plant.stiffness[block], system.plant
    force = first * x[0] + second * x[1]
    if plant.damped:
        force += plant.damping[block][0] * v[0] + plant.damping[block][1] * v[1]
    return force


def loading(system: System, block: int) -> int:
    """Side of its limits that a rider among riders is carried to."""
    return 1 if sum(system.plant.stiffness[block]) * system.V > 0 else -1


def onset(system: System, d: arb) -> Pair:
    """Where the global stick phase of this d ends (figure 2): at the first limit ahead."""
    v = (system.V, system.V)
    ahead = []
    for i, row in enumerate(system.plant.stiffness):
        room = loading(system, i) * system.limits[i] - need(system, i, (arb(0), d), v)
        ahead.append(room / sum(row))
    x1 = min(ahead) if system.V > 0 else max(ahead)
    return (x1.mid(), (x1 + d).mid())


def inside(system: System, d: arb) -> arb:
    """``d``, or the end of the domain if it lies up to 4 ulp (2^-50 relative) beyond."""
    low, high = system.plant.ends
    if low <= d <= high:
        return d
    slack = abs(low).max(abs(high)) * arb(2) ** -50
    if not low - slack <= d <= high + slack:
        raise ValueError(f"d = {float(d)} is outside [{float(low)}, {float(high)}]")
    return (high if d > high else low).mid()


def mode_at_contact(system: System, block: int, x: Pair, v: Pair, other: int) -> int:
    """Mode of a block that moves with the belt at this moment; ``other``: its neighbour's mode."""
    force, limit = need(system, block, x, v), system.limits[block]
    if abs(force) < limit - TIE:
        return 0
    side = 1 if force > 0 else -1
    if abs(force) <= limit + TIE and side * rate_of_need(system, block, x, v, other) < 0:
        return 0
    return -side


def rate_of_need(system: System, block: int, x: Pair, v: Pair, other: int) -> arb:
    """The first derivative of R that is not zero, if the block rides.

    R' = k_b . X' + c_bj X_j'', without dampers R'' = k_bj X_j''; if both vanish then
    R''' = -k_bj k_j . X' / m_j, whatever the law: its slope multiplies X_j'' = 0.
    """
    plant, neighbour = system.plant, 1 - block
    v = (system.V, v[1]) if block == 0 else (v[0], system.V)
    acceleration = system.acceleration(neighbour, x, v, other) if other else arb(0)
    rate = plant.stiffness[block][0] * v[0] + plant.stiffness[block][1] * v[1]
    rate += plant.damping[block][neighbour] * acceleration
    if abs(rate) > TIE:
        return rate
    assert not plant.damped
    coupling = plant.stiffness[block][neighbour]
    if abs(acceleration) > TIE:
        return coupling * acceleration
    row = plant.stiffness[neighbour]
    return -coupling * (row[0] * v[0] + row[1] * v[1]) / plant.mass[neighbour]


def motion(
    system: System, d: object, *, max_events: int = 10_000, max_time: float = 20_000
) -> Motion:
    """Carry ``d`` from one global stick phase to the next."""
    x, v = onset(system, inside(system, exact(d))), (system.V, system.V)
    time, modes = arb(0), (0, 0)
    forces = [loading(system, i) * need(system, i, x, v) for i in (0, 1)]
    concerned = [i for i in (0, 1) if forces[i] > system.limits[i] - TIE]
    events: list[Event] = []
    phases: list[tuple[Phase, arb]] = []

    def result(status: str, value: arb | None = None) -> Motion:
        known = max_time if status == TIME_LIMIT else float(time)
        return Motion(status, value, tuple(events), tuple(phases), known)

    loops = Loops()
    while True:
        after = list(modes)
        for block in concerned:
            # Both concerned: the neighbour moves with the belt too, its mode does not matter.
            after[block] = mode_at_contact(system, block, x, v, modes[1 - block])
        if tuple(after) != modes:
            events.append(Event(time, x, v, modes, (after[0], after[1])))
            modes = (after[0], after[1])
            if modes == (0, 0):
                return result(OK, (x[1] - x[0]).mid())
            if loops.closed_by(events):
                return result(NEVER_CYCLE)
        if len(phases) > max_events:  # touches that change no mode count as well
            return result(EVENT_LIMIT)
        phase = system.phase(x, v, modes)
        try:
            if phase.never_ends():
                return result(NEVER_SLIPPING)
            found = phase.first_event(max_time - time)
        except NotPositive:
            return result(UNDECIDED)
        if found is None:
            return result(TIME_LIMIT)
        t, hit = found
        phases.append((phase, t))
        concerned = sorted(hit)
        x, v = phase.state(t)
        v = tuple(system.V if i in hit or modes[i] == 0 else v[i].mid() for i in (0, 1))
        x, time = (x[0].mid(), x[1].mid()), (time + t).mid()


class Loops:
    """Looks for a cycle among the events so far."""

    def __init__(self) -> None:
        self.seen: list[tuple[float, ...]] = []

    def closed_by(self, events: list[Event]) -> bool:
        """Whether the last event closes a loop for the third time, ever closer."""
        last = events[-1]
        self.seen.append((*map(float, last.x), *map(float, last.v)))
        here, n = self.seen[-1], len(events)
        for p in range(1, min(LONGEST_LOOP, (n - 1) // 3) + 1):
            there = self.seen[-1 - p]
            if max(abs(a - b) for a, b in zip(here, there, strict=True)) > 1e-10:
                continue
            laps = [distance(events[n - 1 - k * p], events[n - 1 - (k + 1) * p]) for k in range(3)]
            closer = laps[0] <= CONTRACTS * laps[1] and laps[1] <= CONTRACTS * laps[2]
            if laps[0] < RECURS and closer:
                return True
        return False


def distance(a: Event, b: Event) -> float:
    """Largest difference between the states of two events; infinite for different ones."""
    if (a.before, a.after) != (b.before, b.after):
        return float("inf")
    return max(float(abs(p - q)) for p, q in zip(a.x + a.v, b.x + b.v, strict=True))


def sensitivity(
    system: System, d: object, base: Motion | None = None, **limits: float
) -> tuple[float, float]:
    """(derivative of the value, kappa), by a second motion 1e-25 away with the same itinerary.

    kappa is the largest |d state / d d| over the motion's events, at least 1; infinite where the
    itinerary changes within 1e-25 on both sides, NaN derivative where there is no value.
    The derivative of the state is taken at fixed time, just before and just after each event, as
    the tangent of the flow has it. That of the states *at* the events would have the shift along
    the motion in it, which grows without bound where a block is about to graze the belt, although
    nothing that follows depends on it: a test with that kappa would excuse what it is there for.
    """
    d = inside(system, exact(d))
    base = base or motion(system, d, **limits)
    low, high = system.plant.ends
    for step in (arb("1e-25"), arb("-1e-25")):
        if not low <= d + step <= high:
            continue
        near = motion(system, d + step, **limits)
        if near.itinerary != base.itinerary:
            continue
        pairs = zip(base.events, near.events, strict=True)
        kappa = max(1.0, *(growth(system, a, b, step) for a, b in pairs))
        if base.value is None or near.value is None:
            return float("nan"), kappa
        return float((near.value - base.value) / step), kappa
    return float("nan"), float("inf")


def growth(system: System, a: Event, b: Event, step: arb) -> float:
    """|d state / d d| at fixed time, the larger of before and after one event."""
    later = b.time - a.time
    sizes = []
    for modes in (a.before, a.after):
        squares = arb(0)
        for i, mode in enumerate(modes):
            rate = system.acceleration(i, a.x, a.v, mode) if mode else arb(0)
            squares += (b.x[i] - a.x[i] - a.v[i] * later) ** 2
            squares += (b.v[i] - a.v[i] - rate * later) ** 2
        sizes.append(float(squares.sqrt() / abs(step)))
    return max(sizes)
