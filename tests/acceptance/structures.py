"""Random structures of two and three contacts, against an integration of another kind.

    python -m tests.acceptance.structures own shared elastic --n 100000
    python -m tests.acceptance.structures maps returns --n 1000 --first 500
    python -m tests.acceptance.structures near --n 1000

Every structure is told by its kind and its number. Motions: `own`, contacts on inertias of their
own; `shared`, contacts on the same bodies and full mass matrices; `elastic`, with Jenkins contacts;
`near`, any of these from starts beside one where the sequence of events changes. Maps: `maps`, two
unequal blocks, asked together in lanes and pools and one at a time; `returns`, return maps.

The oracle is `tests/reference/dormand.py`, positions and velocities in steps of order eight. Where
it and the package differ by more than the tolerance times kappa, what a change at any event grows
to, noise of 64 kappa ulp tells whether the sequence of events is one that rounding decides
(excused), then `structures.py` or `elastic.py` in short steps whether the package is wrong.
A thousandth of the motions that agree is settled so, too. Counts go to `docs/evidence.csv`. Exit
code 1 if any is wrong.
"""

from __future__ import annotations

import argparse
import math
import secrets
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tests.mechanics.eventmap.unequal import sprung
from tests.reference.dormand import ARRIVED, ENDED, LOST, Follower, Motion
from tests.reference.elastic import Elastic, random_elastic
from tests.reference.settle import EXCUSED, GAVE_UP, RIGHT, WRONG
from tests.reference.structures import Plain, random_structure

import stickslip as ss
from stickslip.mechanics.flow.trajectory import EVENT_KINDS
from stickslip.status import NAMES, OK

from . import counts
from .pieces import add_options, carried_out

Floats = NDArray[np.float64]
Event = tuple[float, int, int]

MODES = {kind: mode for mode, kind in EVENT_KINDS.items()}
T_END = 6.0
FINE = 0.002  # steps of the slow reference
SETTLES = 1e-9  # what it tells apart
SAME = 1e-13  # of an instant
TOLERANCE = 5e-13  # more than doubles lose on either side: 1.5e-13 at most of 40 000 motions
ULPS = 64 * np.finfo(float).eps
NOISES = (1e-8, 1e-10, 1e-12)
SHARE = 1e-3  # of motions that agree and are settled all the same
POINTS = 12  # of a map
LONGEST, SHORTER = 300.0, 60.0  # of a map's motions in the oracle; of those without a return
MAX_EVENTS = 300
PIECE = 50
CLASSES: Sequence[Sequence[str]] = ("C", "CP", "S", "CS")
SAMPLES = {
    "own": "random structures, contacts on inertias of their own",
    "shared": "random structures, contacts that share inertia",
    "elastic": "random structures, elastic contacts",
    "near": "random structures, starts next to other sequences of events",
    "maps": "unequal blocks, lanes, pools and one at a time",
    "returns": "return maps of random structures",
}


@dataclass
class Count(counts.Count):
    """What came out."""

    structures: int = 0
    answers: int = 0
    alike: int = 0
    worst: float = 0.0

    def agrees(self, off: float, kappa: float) -> bool:
        """Count an answer that is right; whether it is."""
        if not off <= TOLERANCE * kappa:
            return False
        self.alike += 1
        self.worst = max(self.worst, off / kappa)
        return True

    def merge(self, other: Count) -> None:
        """Both counts together."""
        worst = max(self.worst, other.worst)
        super().merge(other)
        self.worst = worst

    def __str__(self) -> str:
        head = (
            f"{self.structures} structures, {self.answers} answers, {self.alike} alike, "
            f"{self.endless} given up, {self.differ} differ; settled: {dict(self.verdicts)}; "
            f"largest right error {self.worst:.1e}"
        )
        return self.listed(head)


# --- what is drawn ------------------------------------------------------------------------------


def random_laws(classes: str, rng: np.random.Generator, n: int = 4) -> list[ss.FrictionLaw]:
    """Constant, falling and growing laws."""
    return [random_law(classes[k % len(classes)], rng) for k in range(n)]


def random_law(kind: str, rng: np.random.Generator) -> ss.FrictionLaw:
    """Coulomb, law (9), Stribeck; numbers at the ends of their ranges now and then."""
    slow = rng.random() < 0.4
    if kind == "C":
        mu = float(rng.choice([0.0, 1.0, *rng.uniform(0.05, 1.0, 8)]))
        return ss.Coulomb(mu=mu, viscous=0.0 if slow else rng.uniform(0.0, 0.2))
    if kind == "P":
        delta, eta = (0.0, 0.0) if slow else (rng.uniform(0, 0.5), rng.uniform(0, 0.1))
        return ss.PoppStelter(gamma=rng.uniform(0.3, 4.0), delta=delta, eta=eta)
    viscous = 0.0 if slow else rng.uniform(0.0, 0.1)
    return ss.Stribeck(rng.uniform(0.2, 0.9), rng.uniform(0.1, 1.0), viscous)


def full_mass(model: ss.Structure, rng: np.random.Generator) -> ss.Structure:
    """The same with a full mass matrix."""
    n = len(model.mass)
    root = rng.normal(size=(n, n)) * 0.5
    return model.replace(mass=root @ root.T + np.diag(model.mass))


def drawn(kind: str, number: int) -> tuple[ss.Structure, Floats, Floats, np.random.Generator]:
    """The structure of that number, of two or three contacts, and a start."""
    rng = np.random.default_rng([number, list(SAMPLES).index(kind)])
    if kind == "near":
        kind = ("own", "shared", "elastic")[number % 3]
    classes = CLASSES[number // PIECE % len(CLASSES)]
    while True:
        try:
            if kind == "elastic":
                laws = [ss.Coulomb(mu=law.mu) for law in random_laws("C", rng)]  # type: ignore[attr-defined]
                model = random_elastic(rng, laws, shared=bool(number % 2))
            else:
                model = random_structure(rng, random_laws(classes, rng), shared=kind == "shared")
            if kind != "own" and rng.random() < 0.3:
                model = full_mass(model, rng)
        except ValueError:
            continue  # contacts that nearly depend on each other
        if 2 <= len(model.contacts) <= 3 + (kind == "elastic"):
            n = len(model.mass)
            return model, rng.normal(size=n) * 0.5, rng.normal(size=n) * 0.5, rng


# --- motions ------------------------------------------------------------------------------------


@dataclass
class Told:
    """A motion as the package tells it."""

    events: list[Event]
    t: float
    q: Floats
    v: Floats
    status: int


def told(model: ss.Structure, q: Floats, v: Floats) -> Told:
    """The package's motion."""
    motion = ss.simulate(model, q, v, t_end=T_END, record="events")
    events = [(event.time, event.block - 1, MODES[event.kind]) for event in motion.events]
    end, n = motion.final_state, len(q)
    return Told(sorted(events), end.t, end.x[:n], end.v[:n], int(motion.status))


def difference(one: Told | Motion, other: Motion, same: float = SAME) -> float:
    """Largest difference of ends, of signals at times of events; infinite if events differ."""
    ours, theirs = by_time(one, same), by_time(other, same)
    if [each[1:] for each in ours] != [each[1:] for each in theirs]:
        return math.inf
    pairs = zip(ours, theirs, other.paces, strict=True)
    times = [(a[0] - b[0]) * min(pace, 1.0) for a, b, pace in pairs]
    off = (*times, one.t - other.t, *(one.q - other.q), *(one.v - other.v))
    return float(np.abs(off).max())


UNSURE = 5e-12  # a decision of the oracle that is as close


def by_time(motion: Told | Motion, same: float = SAME) -> list[Event]:
    """Changes of mode, those at one instant by contact."""
    found: list[Event] = []
    start = -math.inf
    for time, k, m in motion.events:
        start = start if time - start < same else time
        found.append((start, k, m))
    order = sorted(range(len(found)), key=lambda i: found[i])
    return [(motion.events[i][0], *found[i][1:]) for i in order]


def growth(run: Callable[[float], Motion], motion: Motion) -> float:
    """To what a unit of noise at any event grows, at least 1."""
    for noise in NOISES:
        found = [difference(run(sign * noise), motion) for sign in (-1.0, 1.0)]
        if max(found) < math.inf:
            return max(1.0, max(found) / noise)
    return math.inf


def doubted(run: Callable[[float], Motion], motion: Motion, kappa: float) -> str:
    """Excused if noise of 64 kappa ulp changes the sequence of events, undecided, or wrong."""
    if motion.margin < UNSURE or motion.ending not in (ENDED, LOST, ARRIVED):
        return GAVE_UP
    noises = (-kappa * ULPS, kappa * ULPS)
    if kappa == math.inf or any(difference(run(noise), motion) == math.inf for noise in noises):
        return EXCUSED
    return WRONG


def settled(model: ss.Structure, q: Floats, v: Floats, own: Told, kappa: float) -> str:
    """What a slow integration in short steps says."""
    try:
        for step in (0.05, FINE):
            if any(contact.stiffness is not None for contact in model.contacts):
                slow = Elastic(model).follow_feet(q, v, T_END, step, own.events)
            else:
                slow = Plain(model).follow(q, v, T_END, step, own.events)
            events = sorted(slow.events)
            expected = Motion(OK, slow.t, slow.q, slow.v, q[:0], events, [1.0] * len(events), 0.0)
            if difference(own, expected, SETTLES) < SETTLES * kappa:
                lost = own.status == ss.status.CONTACT_LOST
                return RIGHT if lost == slow.lost else WRONG
    except (ArithmeticError, np.linalg.LinAlgError):
        return GAVE_UP
    return WRONG


def judge_motion(
    count: Count, name: str, model: ss.Structure, q: Floats, v: Floats, share: bool
) -> None:
    """One motion."""
    follower = Follower(model)
    own = told(model, q, v)

    def run(noise: float) -> Motion:
        by = noise * np.where(np.arange(len(q)) % 2, 1.0, -1.0)
        return follower.follow(q + by, v + abs(by), T_END, choices=own.events, noise=noise)

    motion = run(0.0)
    count.answers += 1
    off, kappa = difference(own, motion), 1.0
    wanted = {ENDED: OK, LOST: ss.status.CONTACT_LOST}.get(motion.ending)
    if own.status == wanted and count.agrees(off, kappa):
        if share:
            count.add(settled(model, q, v, own, kappa), f"{name} and the oracle too")
        return
    kappa = growth(run, motion)
    if own.status == wanted and count.agrees(off, kappa):
        return
    count.differ += 1
    verdict = doubted(run, motion, kappa)
    if verdict == WRONG and (off == math.inf or own.status != wanted):
        verdict = settled(model, q, v, own, kappa)
    first = [(a, b) for a, b in zip(by_time(own), by_time(motion), strict=False) if a[1:] != b[1:]]
    count.add(
        verdict,
        f"{name}: off {off:.1e}, kappa {kappa:.1e}, {NAMES[own.status]} against {motion.ending}, "
        f"margin {motion.margin:.1e}, {len(own.events)} and {len(motion.events)} events, "
        f"{first[:1]}",
    )


def motions(kind: str, number: int) -> Count:
    """One structure and its motion, or those next to where events change."""
    count = Count(structures=1)
    model, q, v, rng = drawn(kind, number)
    name = f"{kind} {number}"
    if kind != "near":
        judge_motion(count, name, model, q, v, rng.random() < SHARE)
        return count
    follower = Follower(model)
    q_2, v_2 = (x + 0.3 * rng.normal(size=len(q)) for x in (q, v))

    def at(share: float) -> tuple[Floats, Floats]:
        return q + share * (q_2 - q), v + share * (v_2 - v)

    def word(share: float) -> list[tuple[int, int]]:
        return [event[1:] for event in follower.follow(*at(share), T_END).events]

    low, high, left = 0.0, 1.0, word(0.0)
    if left == word(1.0):
        return count
    while high - low > 1e-15:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if word(middle) == left else (low, middle)
    for reach in 10.0 ** -np.arange(2.0, 13.0):
        for share in (low - reach, high + reach):
            judge_motion(count, f"{name} at {share!r}", model, *at(share), share=False)
    return count


# --- maps ---------------------------------------------------------------------------------------


def two_blocks(number: int) -> tuple[ss.Structure, bool, np.random.Generator]:
    """Unequal blocks on a belt, and whether `ss.Blocks` holds them.

    Half of them damped; some with stiffness of no symmetry, or on a belt that runs the other way.
    """
    rng = np.random.default_rng([number, list(SAMPLES).index("maps")])
    support = rng.uniform(0.3, 3.0, 2)
    coupling = rng.uniform(0.1, 3.0) if number % 5 else rng.uniform(-0.25, 0.0) * support.min()
    dampers = rng.uniform(0.0, 0.3, 3) * rng.integers(2)
    skew = rng.normal() * 0.2 * (rng.random() < 0.25)
    classes = CLASSES[number // PIECE % len(CLASSES)]
    one, two = (random_law(classes[-k], rng) for k in (0, 1))
    V = rng.uniform(0.005 if classes == "C" else 0.02, 0.3) * rng.choice([1.0, 1.0, 1.0, -1.0])
    contacts = [
        ss.Contact(at=k, friction=law, static=rng.uniform(0.5, 2.0), V=V)
        for k, law in enumerate([one, two] if number % 3 else [one, one])
    ]
    model = ss.Structure(
        mass=rng.uniform(0.3, 3.0, 2),
        stiffness=sprung(support, coupling) + skew * np.array([[0.0, 1.0], [-1.0, 0.0]]),
        damping=sprung(dampers[:2], dampers[2]),
        contacts=contacts,
    )
    return model, bool(skew == 0.0 and V > 0.0), rng


def as_blocks(model: ss.Structure) -> ss.Blocks:
    """The same by the other class."""
    return ss.Blocks(
        model.mass,
        model.stiffness,
        model.damping,
        static=[contact.static for contact in model.contacts],
        friction=list(model.friction),
        V=model.V,
    )


def carried(structure: ss.Structure, d: float) -> tuple[Floats, Floats]:
    """A state of the global stick phase, half a unit of time before its end or in its middle."""
    V = structure.V
    load = structure.stiffness.sum(axis=1)
    need = structure.stiffness @ [0.0, d] + structure.damping.sum(axis=1) * V
    limits = np.array([contact.static for contact in structure.contacts])
    with np.errstate(divide="ignore"):
        ends = np.sort([(-limits - need) / load, (limits - need) / load], axis=0)
    low, high = ends[0].max(), ends[1].min()
    x = (
        max(0.5 * (low + high), high - 0.5 * V)
        if V > 0.0
        else min(0.5 * (low + high), low - 0.5 * V)
    )
    return np.array([x, x + d]), np.array([V, V])


def map_drivers(f: ss.EventMap) -> dict[str, Callable[[Floats], Floats]]:
    """Ways in which the package carries motions of this map."""
    ways: dict[str, Callable[[Floats], Floats]] = {"together": f}
    backend = f._backend
    while (backend := getattr(backend, "scalar", None)) is not None:
        ways[type(backend).__name__] = lambda d, own=backend: own.carry(d).value
    return ways


def starts(f: ss.EventMap, rng: np.random.Generator) -> Floats:
    """Half of them anywhere, the others next to a place where the itinerary changes."""
    low, high = f.domain
    d = rng.uniform(low, high, POINTS // 2)
    labels = f.evaluate(np.sort(d)).label
    changes = np.flatnonzero(labels[1:] != labels[:-1])
    if changes.size == 0:
        return d
    i = int(rng.choice(changes))
    a, b = np.sort(d)[i : i + 2]
    left = labels[i]
    while b - a > 1e-15:
        middle = 0.5 * (a + b)
        if middle in (a, b):
            break
        a, b = (middle, b) if f.evaluate(middle).label == left else (a, middle)
    reach = 10.0 ** -rng.uniform(2.0, 13.0, POINTS // 4)
    near = np.concatenate([d, a - reach, b + reach])
    return near[(near > low) & (near < high)]


def maps(_: str, number: int) -> Count:
    """One pair of blocks and a number of starts."""
    structure, usual, rng = two_blocks(number)
    model = as_blocks(structure) if usual and number % 2 else structure
    f = ss.event_map(model, max_events=MAX_EVENTS, threads=1)
    d = starts(f, rng)
    count = Count(structures=1)
    follower = Follower(structure)
    values = {name: way(d) for name, way in map_drivers(f).items()}
    slopes, durations = np.asarray(f.derivative(d)), f.evaluate(d).duration
    for i, start in enumerate(d.tolist()):
        x, v = carried(structure, start)
        returned = any(math.isfinite(found[i]) for found in values.values())
        longest = min(1.1 * float(durations[i]) + 10.0, LONGEST) if returned else SHORTER

        def run(noise: float, x: Floats = x, v: Floats = v, t_end: float = longest) -> Motion:
            at = x + noise * np.array([0.0, 1.0])
            return follower.follow(at, v, t_end, mode=(0, 0), until=(1, 0, 0, 0), noise=noise)

        motion = run(0.0)
        wanted = motion.q[1] - motion.q[0] if motion.ending == ARRIVED else math.nan
        for name, all_values in values.items():
            value = float(all_values[i])
            count.answers += 1
            if math.isnan(value) and math.isnan(wanted):
                count.endless += 1
                continue
            off = abs(value - wanted)
            kappa = max(1.0, abs(float(slopes[i])))
            if not off <= TOLERANCE * kappa:
                kappa = max(kappa, growth(run, motion))
            if count.agrees(off, kappa):
                continue
            if motion.ending == ENDED and float(durations[i]) > 0.9 * longest:
                count.endless += 1  # longer than the oracle follows it
                continue
            count.differ += 1
            count.add(
                doubted(run, motion, kappa),
                f"maps {number} d={start!r} by {name}: {value!r} instead of {wanted!r} "
                f"({motion.ending}), kappa {kappa:.1e}, margin {motion.margin:.1e}",
            )
    return count


def returns(_: str, number: int) -> Count:
    """A return map, at a point of a motion and at others near it, asked together."""
    model, q, v, rng = drawn("own", number)
    count = Count(structures=1)
    frequencies = [name for name in model.parameters if name.endswith("frequency")]
    model = model.replace(**dict.fromkeys(frequencies, rng.uniform(0.3, 3.0)))
    contact, event = int(rng.integers(len(model.contacts))), ("release", "landing")[number % 2]
    motion = ss.simulate(model, q, v, t_end=40.0)
    try:
        f = ss.return_map(model, contact=contact, event=event, max_events=MAX_EVENTS, threads=1)  # type: ignore[arg-type]
    except ValueError:
        return count  # one state, or no interval that returns
    mode = {"backward": -1, "forward": 1}[f.direction]
    before, after = (0, mode) if event == "release" else (mode, 2)
    times = [
        t
        for t, one, two in zip(
            motion.t[1:], motion.modes[:-1, contact], motion.modes[1:, contact], strict=False
        )
        if one == before and (two == after or (after == 2 and two != before))
    ]
    points = [np.atleast_1d(f.point(motion.x(t), motion.v(t), t)) for t in times[:3]]
    if not points:
        return count
    near = [points[0] + size * rng.normal(size=f.dimension) for size in (0.1, 0.1, 1e-2, 1e-6)]
    shape = (-1, f.dimension) if f.dimension > 1 else (-1,)
    follower = Follower(model)
    for row in np.reshape([*points, *near], shape):
        try:
            x, u, t = f.state(row)
        except ValueError:
            continue  # outside
        found = f.evaluate(row)
        value = np.atleast_1d(found.value)
        wanted_end = {OK: ARRIVED, ss.status.CONTACT_LOST: LOST}.get(int(found.status))
        count.answers += 1
        if wanted_end is None:
            count.endless += 1
            continue
        last = t + 1.1 * float(found.duration) + 1.0

        def run(
            noise: float, x: Floats = x, u: Floats = u, t: float = t, last: float = last
        ) -> Motion:
            until = (2, contact, before, after)
            return follower.follow(x, u, last, t=t, until=until, noise=noise)

        end = run(0.0)
        if end.ending != wanted_end:
            count.differ += 1
            count.add(doubted(run, end, growth(run, end)), f"returns {number} at {row!r}: {end}")
            continue
        off, kappa, wanted = abs(float(found.duration) - (end.t - t)), 1.0, np.empty(0)
        if wanted_end == ARRIVED:
            wanted = np.atleast_1d(f.point(end.q, end.v, end.t))
            apart, turns = np.abs(value - wanted), f.periods
            apart = np.where(turns < np.inf, np.minimum(apart, np.abs(turns - apart)), apart)
            off = max(off, float(apart.max()))
            kappa = max(kappa, float(np.abs(found.derivative).max()))
        if off > TOLERANCE * kappa:
            kappa = max(kappa, growth(run, end))
        if count.agrees(off, kappa):
            continue
        count.differ += 1
        count.add(
            doubted(run, end, kappa),
            f"returns {number} {contact} {event} at {row!r}: {value!r} instead of {wanted!r}, "
            f"off {off:.1e}, kappa {kappa:.1e}, margin {end.margin:.1e}",
        )
    return count


CARRIED: dict[str, Callable[[str, int], Count]] = dict.fromkeys(SAMPLES, motions) | {
    "maps": maps,
    "returns": returns,
}


def piece(task: tuple[str, int, int]) -> tuple[str, Count]:
    """Some structures of one kind."""
    kind, first, stop = task
    count = Count()
    for number in range(first, stop):
        count.merge(CARRIED[kind](kind, number))
    return kind, count


def tasks(kinds: Sequence[str], first: int, n: int) -> Iterator[tuple[str, int, int]]:
    """The sample in pieces, of all kinds in turn."""
    for start in range(first, first + n, PIECE):
        for kind in kinds:
            yield kind, start, min(start + PIECE, first + n)


def main(arguments: list[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", nargs="*", help=f"of {', '.join(SAMPLES)}; all by default")
    parser.add_argument("--n", type=int, default=1000, help="structures of each kind")
    parser.add_argument("--first", type=int, default=secrets.randbits(31), help="default: any")
    add_options(parser)
    options = parser.parse_args(arguments)
    kinds = options.kind or list(SAMPLES)
    if unknown := set(kinds) - set(SAMPLES):
        parser.error(f"no kind {', '.join(sorted(unknown))}: give some of {', '.join(SAMPLES)}")
    print(f"{', '.join(kinds)} from {options.first}", flush=True)
    totals, elapsed = {kind: Count() for kind in kinds}, 0.0
    work = tasks(kinds, options.first, options.n)
    for (kind, count), took in carried_out(piece, work, options.jobs, options.seconds):
        totals[kind].merge(count)
        elapsed += took
        count.keep(SAMPLES[kind], count.answers, took, options.table)
        print(f"{elapsed:.0f} s: {kind}: {totals[kind]}", flush=True)
    return 1 if any(total.wrong for total in totals.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
