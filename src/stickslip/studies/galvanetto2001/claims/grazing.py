"""Section 4, figure 7 and equations (13) to (15): the motion of block 2 that grazes the belt."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import Event, Trajectory, simulate
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.studies.claim import Claim, Finding, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.claims.collision import BESIDE, COLLISION
from stickslip.studies.galvanetto2001.orbits import jump_of_s4

BLOCK: Final = 2
PAST: Final = 0.0370  # the paper's figure 7(b)
APPROACH: Final = (0.0366, 0.0368, 0.0369)  # driving velocities below the collision
FRICTIONS: Final = (0.22, 0.5, 0.9)  # mu, at V = 0.0366
SAMPLES: Final = 20_001  # times over one slip
NEAR_ZERO: Final = 0.05  # of the stick interval's length: "in proximity to X_2 = 0"
FLOATS: Final = 16  # on each side of a jump, where its two motions are looked for
APART: Final = 1e-3  # times of first sticks that no rounding moves as far
ROUNDING: Final = 1e-9  # of a force
# Of a force next to a touch: the contact of a lobe as deep as a rounding of d comes earlier by the
# square root of that.
NEXT_TO_TOUCH: Final = 2.0**-26


@dataclass(frozen=True)
class Touch:
    """A graze at one value of mu: needed force at the touch and at the next release of block 2."""

    mu: float
    place: float
    force: float
    release: float
    ride: float  # how long the block then stays with the belt
    jump: float  # step of the map


@dataclass(frozen=True)
class Facts:
    """Lobes, touches, sticks, and the breakpoints of law (9), where F(0) is the static limit."""

    jump: Breakpoint
    beta: float
    lobes: tuple[tuple[float, float], ...]  # of S4: (V, largest w)
    touches: tuple[Touch, ...]
    sticks: tuple[float, ...]  # X_2 at which block 2 comes to rest in one period past the collision
    period: int
    length: float  # of its stick interval
    law9: tuple[Breakpoint, ...]


def facts() -> Facts:
    """Simulate S4, what follows it, and the motions beside grazes."""
    at = printed.numbers(4)[COLLISION].computed
    model = examples.coulomb()
    period, sticks = _sticks_past()
    return Facts(
        jump=jump_of_s4(event_map(model)),
        beta=model.beta,
        lobes=tuple((V, _lobe(examples.coulomb(V=V))) for V in (*APPROACH, at - BESIDE)),
        touches=tuple(_touch(examples.coulomb(mu=mu)) for mu in FRICTIONS),
        sticks=sticks,
        period=period,
        length=2.0 * model.beta / (1.0 + model.alpha),
        law9=tuple(breakpoints(examples.law9())),
    )


def _lobe(model: TwoBlock) -> float:
    """Largest relative velocity at which block 2 turns back in the slip from point 1 of S4."""
    f = event_map(model)
    jump = jump_of_s4(f)
    (s4,) = (item.orbit for item in attractors(f) if item.period == 4)
    assert s4 is not None
    start = float(s4.points[np.abs(s4.points - jump.d).argmin()])
    motion = simulate(model, d=start, until="stick")
    t = np.linspace(0.0, motion.t[-1], SAMPLES)
    w = motion.v(t)[:, BLOCK - 1] - model.V
    turns = (w[1:-1] > w[:-2]) & (w[1:-1] >= w[2:]) & (w[1:-1] < 0.0)
    return float(w[1:-1][turns].max())


def _touch(model: TwoBlock) -> Touch:
    """Follow the motion from the touching side of the first graze of block 2."""
    found = breakpoints(model).of_kind("jump")
    jump = next(item for item in found if item.block == BLOCK and "grazes" in item.mechanism)
    # The touch is the first stick of the motion that sticks earlier.
    motion = min(_beside(model, jump), key=lambda one: _first(one, "stick").time)
    touch = _first(motion, "stick")
    release = _first(motion, "slip backward", after=touch.time)
    return Touch(
        model.parameters["mu"],
        float(motion.x(touch.time)[BLOCK - 1]),
        _needed_force(motion, touch.time),
        _needed_force(motion, release.time),
        release.time - touch.time,
        jump.jump,
    )


def _beside(model: TwoBlock, jump: Breakpoint) -> tuple[Trajectory, Trajectory]:
    """Follow the motions next to a jump that differ: some floats apart, as simulation rounds."""
    left, right = jump.interval
    t_end = 4.0 * (1.0 + model.beta) / model.V
    for _ in range(FLOATS):
        before, after = (simulate(model, d=d, t_end=t_end) for d in (left, right))
        if abs(_first(after, "stick").time - _first(before, "stick").time) > APART:
            return before, after
        left, right = np.nextafter(left, -np.inf), np.nextafter(right, np.inf)
    raise RuntimeError(f"the motions beside the jump at d = {jump.d!r} do not differ")


def _first(motion: Trajectory, kind: str, after: float = 0.0) -> Event:
    events = (e for e in motion.events if e.block == BLOCK and e.kind == kind)
    return next(event for event in events if event.time > after)


def _needed_force(motion: Trajectory, t: float) -> float:
    """R_2 = X_2 + alpha (X_2 - X_1): what friction has to carry if block 2 is to ride."""
    return float(motion.needed_force(t)[BLOCK - 1])


def _sticks_past() -> tuple[int, tuple[float, ...]]:
    """Where block 2 comes to rest in one period of the attractor past the collision."""
    model = examples.coulomb(V=PAST)
    orbit = next(a.orbit for a in attractors(model) if a.orbit is not None and a.period != 1)
    longest = 2.0 * (1.0 + model.beta) / model.V
    motion = simulate(model, d=float(orbit.points[0]), t_end=(orbit.period + 1) * longest)
    end = motion.slips[orbit.period].start
    sticks = (e for e in motion.events if e.block == BLOCK and e.kind == "stick" and e.time < end)
    return orbit.period, tuple(float(motion.x(e.time)[BLOCK - 1]) for e in sticks)


def _grazing(facts: Facts) -> Claim:
    jump = facts.jump
    return claim(
        "grazing.orbit",
        "section 4, second paragraph",
        "The transition is linked to a grazing motion of block 2",
        Finding(
            "at the jump that S4 meets block 2 grazes",
            f"of the motions on either side, adjacent floats at d = {jump.d:.15g}, one makes "
            f"an event that the other does not: {jump.mechanism}",
            jump.block == BLOCK and "grazes" in jump.mechanism,
        ),
        mechanism=jump.mechanism,
    )


def _lobe_approaches(facts: Facts) -> Claim:
    heights = [w for _, w in facts.lobes]
    listing = ", ".join(f"{w:.3e} (V = {V:.10g})" for V, w in facts.lobes)
    rising = all(a < b < 0.0 for a, b in pairwise(heights))
    return claim(
        "grazing.lobe",
        "section 4, second paragraph",
        "A lobe of S4 is close to a tangency with the belt velocity, comes closer as V grows, and "
        "touches at the collision",
        Finding(
            "the lobe's top rises towards the belt velocity",
            f"largest w of the lobe: {listing}",
            rising,
        ),
        Finding(
            "it is there at the collision",
            f"{heights[-1]:.1e} at {BESIDE:.0e} below it",
            abs(heights[-1]) < 1e-3 * abs(heights[0]),
        ),
    )


def _keeps_touching(facts: Facts) -> Claim:
    near = [x for x in facts.sticks if abs(x) < NEAR_ZERO * facts.length]
    place = facts.touches[0].place
    return claim(
        "grazing.near_zero",
        "section 4, second paragraph",
        "Past the collision the motion keeps meeting the stick interval near X_2 = 0",
        Finding(
            f"at V = {PAST} block 2 sticks near X_2 = 0 (within {NEAR_ZERO:.0%} of the "
            "interval's length) in every period",
            f"in {len(near)} of its {len(facts.sticks)} sticks per {facts.period} global stick "
            f"phases, at X_2 = {', '.join(f'{x:.5f}' for x in near) or 'no such place'}",
            len(near) > 0,
        ),
        Finding(
            "the place of the graze is near X_2 = 0 in the same sense",
            f"X_2 = {place:.6f}, in an interval of length {facts.length:.4f}",
            abs(place) < NEAR_ZERO * facts.length,
        ),
    )


def _tangency(facts: Facts) -> Claim:
    off = [abs(one.force - one.mu * facts.beta) for one in facts.touches]
    listing = ", ".join(f"{one.force:.12f} (mu = {one.mu})" for one in facts.touches)
    return claim(
        "grazing.tangency",
        "section 4, eq. (14)",
        "The motion is tangent to the stick interval where X_2 + alpha (X_2 - X_1) = beta mu_k "
        "while block 2 has the belt's velocity",
        Finding(
            "at the touch the force in eq. (14) is beta mu_k",
            f"{listing}; off by {max(off):.0e} at most",
            max(off) < NEXT_TO_TOUCH,
        ),
    )


def _becomes_sticking(facts: Facts) -> Claim:
    one = facts.touches[0]
    return claim(
        "grazing.sticks",
        "section 4, eq. (15)",
        "The tangent point becomes a sticking point, which block 2 leaves at the right end of its "
        "interval, where X_2 + alpha (X_2 - X_1) = beta",
        Finding(
            "block 2 rides with the belt after the touch",
            f"for a time of {one.ride:.6f} (mu = {one.mu})",
            one.ride > 0.0,
        ),
        Finding(
            "at the end of the ride the force of eq. (15) is beta",
            f"{one.release:.12f}, beta = {facts.beta}",
            abs(one.release - facts.beta) < ROUNDING,
        ),
        mechanism="the touch sticks because the force there, beta mu_k, is inside the interval",
    )


def _avoided(facts: Facts) -> Claim:
    rooms = [facts.beta - one.force for one in facts.touches]
    falls = all(
        abs(room - facts.beta * (1.0 - one.mu)) < NEXT_TO_TOUCH
        for room, one in zip(rooms, facts.touches, strict=True)
    )
    rides = [one.ride for one in facts.touches]
    shorter = all(a > b for a, b in pairwise(rides))
    grazes = [item for item in facts.law9 if "grazes" in item.mechanism]
    jumps = [item for item in facts.law9 if item.kind == "jump"]
    return claim(
        "grazing.avoided",
        "section 4, below eq. (15), and section 5",
        "The cause is a kinetic friction below the static one: with mu_k = 1 such a bifurcation "
        "would be avoided",
        Finding(
            "the force at the touch lies beta (1 - mu_k) inside the interval: nothing at mu_k = 1",
            ", ".join(
                f"{room:.9f} (mu = {one.mu})"
                for room, one in zip(rooms, facts.touches, strict=True)
            ),
            falls,
        ),
        Finding(
            "so the ride after the touch gets shorter as mu_k grows",
            ", ".join(f"{one.ride:.4f} (mu = {one.mu})" for one in facts.touches),
            shorter,
        ),
        Finding(
            "with law (9), whose force starts at the static limit (mu_k = 1), no graze is a jump",
            f"its map has {len(grazes)} grazes: "
            + (", ".join(f"a {item.kind} at {item.d:.8f}" for item in grazes) or "none"),
            len(grazes) > 0 and all(item.kind != "jump" for item in grazes),
        ),
        note=(
            f"Only jumps by grazing are avoided: the map of law (9) at alpha = 1.208 has "
            f"{len(jumps)} jumps of other kinds "
            f"({'; '.join(sorted({item.mechanism for item in jumps}))})."
            if jumps
            else ""
        ),
    )


CLAIMS: Final = {
    7: (_grazing, _lobe_approaches, _keeps_touching, _tangency, _becomes_sticking, _avoided)
}
