"""Section 4, Coulomb friction at V = 0.0366: attractors, unstable orbits, U4 and basins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stickslip import examples
from stickslip.analysis.attractors.basins import Basins, basins
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.numerics.arrays import Floats
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import coulomb_orbits, from_point_1, jump_of_s4, u4

ROUNDS: Final = 60  # of the fourth iterate: transients settle at 0.75 per round
NEAR: Final = 0.01  # of the domain: "close to" a discontinuity
BESIDE: Final = 1e-9  # of an orbit's point, to see which basin is on either side
STEP: Final = 1e-6  # of the difference quotient
ROUNDING: Final = 1e-13


@dataclass(frozen=True)
class Facts:
    """All that is known of the map at V = 0.0366."""

    width: float
    orbits: dict[str, PeriodicOrbit]
    unstable: PeriodicOrbit
    jump: Breakpoint
    jumps: Floats
    s4: Floats  # starts with the point at the jump, as u4
    u4: Floats
    basins: Basins
    # of f^4 from the floats left and right of the jump, shape (2, ROUNDS + 1)
    transients: Floats
    # periods of attractors reached left and right of each point of U4, shape (4, 2)
    owners: NDArray[np.int64]
    quotient: float  # slope of S4 by differences of simulated motions
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits, find attractors and basins, follow transients."""
    f = event_map(examples.coulomb())
    orbits, jump, unstable = coulomb_orbits(f), jump_of_s4(f), u4(f)
    s4, points = (from_point_1(orbit, jump.d) for orbit in (orbits["S4"], unstable))
    found = basins(f)
    sides = points[:, None] + BESIDE * np.array([-1.0, 1.0])
    return Facts(
        width=f.domain[1] - f.domain[0],
        orbits=orbits,
        unstable=unstable,
        jump=jump,
        jumps=np.array([item.d for item in breakpoints(f).of_kind("jump")]),
        s4=s4,
        u4=points,
        basins=found,
        transients=f.power(4).iterate(np.array(jump.interval), ROUNDS),
        owners=_owners(found, sides),
        quotient=_difference_quotient(f, float(s4[0])),
        numbers=printed.numbers(5, 10),
    )


def _owners(found: Basins, d: Floats) -> NDArray[np.int64]:
    """Return the period of the attractor that each start reaches; 0 for none."""
    periods = np.array([*(attractor.period for attractor in found.attractors), 0])
    return np.asarray(periods[np.maximum(found.at(d), -1)])


def _difference_quotient(f: EventMap, d: float) -> float:
    """Slope of the fourth iterate from two motions in time, four global stick phases long."""
    longest = 2.0 * (1.0 + f.model.beta) / f.model.V
    ends = [simulate(f.model, d=start, t_end=5 * longest).d[4] for start in (d - STEP, d + STEP)]
    return float(ends[1] - ends[0]) / (2.0 * STEP)


def _two_attractors(facts: Facts) -> Claim:
    periods = sorted(a.period for a in facts.basins.attractors if a.kind == "periodic")
    stable = sorted(orbit.period for orbit in facts.orbits.values() if orbit.stable)
    return claim(
        "coulomb.attractors",
        "section 4, first paragraph",
        "For V = 0.0366 there are at least two attractors, S1 of period 1 and S4 of period 4",
        Finding(
            "attractors of the periods 1 and 4",
            f"{facts.basins.attractors.n_starts} starts over the domain reach attractors of "
            f"the periods {periods}",
            {1, 4} <= set(periods),
        ),
        Finding(
            "the complete list of orbits up to period 4 holds both as stable orbits",
            f"its stable orbits have the periods {stable}",
            {1, 4} <= set(stable),
        ),
        values=tuple(v for name, v in facts.numbers.items() if "S1" in name or "S4" in name),
        note=(
            "There are no others above the resolution of the search: the basins of the two fill "
            "the domain (figure 9)."
        ),
    )


def _unstable_orbits(facts: Facts) -> Claim:
    fixed = {name: orbit for name, orbit in facts.orbits.items() if orbit.period == 1}
    unstable = [name for name, orbit in fixed.items() if not orbit.stable]
    return claim(
        "coulomb.u1_u2",
        "section 4, first paragraph",
        "The unstable period-1 motions U1 and U2 are present too",
        Finding(
            "two unstable fixed points",
            f"the complete list holds {len(fixed)} fixed points, {len(unstable)} unstable",
            len(unstable) == 2,
        ),
        values=tuple(v for name, v in facts.numbers.items() if "U1" in name or "U2" in name),
    )


def _near_the_jump(facts: Facts) -> Claim:
    distance = np.abs(facts.s4[:, None] - facts.jumps)
    nearest = int(distance.min(axis=1).argmin())
    gap = float(distance.min())
    return claim(
        "coulomb.near_jump",
        "section 4, first paragraph",
        "Point 1 of S4 is close to a discontinuity of the map",
        Finding(
            f"a jump within {NEAR:.0%} of the domain",
            f"the nearest jump of the map is {gap:.3e} away, {gap / facts.width:.3%} of the domain",
            gap < NEAR * facts.width,
        ),
        Finding(
            "it is the jump at which block 2 grazes",
            f"the nearest jump is {facts.jumps[distance[nearest].argmin()]:.15g}; block 2 "
            f"grazes at {facts.jump.d:.15g}",
            bool(facts.jumps[distance[nearest].argmin()] == facts.jump.d),
        ),
        mechanism=facts.jump.mechanism,
    )


def _multiplier(facts: Facts) -> Claim:
    slope = facts.orbits["S4"].multiplier
    return claim(
        "coulomb.multiplier",
        "section 4, below figure 9",
        "The slope of the map at the points of a periodic motion is its Floquet multiplier",
        Finding(
            "differences of motions simulated in time over one period give the slope of f^4",
            f"S4: {facts.quotient:.8f} by differences, {slope:.8f} as product of slopes",
            abs(facts.quotient - slope) < 1e-5,
        ),
        note=(
            "The other multipliers of the flow are 1 (along the motion) and zeros: a global "
            "stick phase forgets everything but d."
        ),
    )


def _basins(facts: Facts) -> Claim:
    found = facts.basins
    shares = {a.period: found.share(k) for k, a in enumerate(found.attractors)}
    owned = sum(1 for k in found.index if k >= 0 and found.attractors[k].period == 1)
    inner = zip(found.edges[1:-1], found.causes[1:], strict=False)
    causes = "; ".join(f"{edge:.12f}: {cause}" for edge, cause in inner)
    return claim(
        "coulomb.basins",
        "figure 9",
        "Part of the interval is the basin of S1, all the rest is the basin of S4",
        Finding(
            "S1 owns a part of the interval",
            f"S1 owns {owned} intervals, {shares.get(1, 0.0):.4%} of the domain",
            0.0 < shares.get(1, 0.0) < 1.0,
        ),
        Finding(
            "nothing is left over",
            f"S4 owns {shares.get(4, 0.0):.4%}; {found.undecided:.1e} undecided, "
            f"{found.left:.1e} leaves",
            abs(shares.get(1, 0.0) + shares.get(4, 0.0) - 1.0) < ROUNDING,
        ),
        note=f"Inner edges and their causes: {causes}.",
    )


def _no_separatrix(facts: Facts) -> Claim:
    left, right = facts.owners[0]
    return claim(
        "coulomb.no_separatrix",
        "section 4, below figure 7",
        "Both branches of the map at the discontinuity belong to one basin: no orbit there "
        "separates basins, unlike in the one-block system with which it is compared",
        Finding(
            "starts on both sides of the jump reach the same attractor",
            f"from the left side the attractor of period {left}, from the right that of "
            f"period {right}",
            bool(left == right > 0),
        ),
    )


def _u4(facts: Facts) -> Claim:
    orbit, numbers = facts.unstable, facts.numbers
    values = tuple(numbers[f"d of U4, point {k}"] for k in range(1, 5))
    share = orbit.jump.share if orbit.jump is not None else float("nan")
    return claim(
        "coulomb.u4",
        "section 4, below figure 9",
        "An infinitely unstable orbit U4 of period 4 exists, approximately "
        "(-0.466, -0.254, 0.279, 0.492)",
        Finding(
            "the map with its jumps filled in has such an orbit through the grazing jump",
            f"it crosses the jump {facts.jump.d:.12f} at {100 * share:.4f} % of its height "
            f"and closes to {orbit.residual:.0e}",
            orbit.period == 4 and 0.0 < share < 1.0 and orbit.residual < ROUNDING,
        ),
        values=values,
        mechanism=facts.jump.mechanism,
    )


def _in_the_basin(facts: Facts) -> Claim:
    return claim(
        "coulomb.u4_basin",
        "section 4, below figure 9",
        "U4 lies in the basin of S4",
        Finding(
            "starts on both sides of all four points reach S4",
            "periods of the attractors reached, left and right of each point: "
            + ", ".join(f"{a} {b}" for a, b in facts.owners.tolist()),
            bool((facts.owners == 4).all()),
        ),
    )


def _transients(facts: Facts) -> Claim:
    left, right = facts.transients
    s4 = facts.s4
    ends = [int(np.abs(s4 - path[-1]).argmin()) for path in (left, right)]
    settled = [float(np.abs(s4 - path[-1]).min()) for path in (left, right)]
    # On the multiplier's slow side rounding ends the approach: steps below it have no sign.
    steps = np.diff(left)
    steps = steps[np.abs(steps) > ROUNDING]
    one_sided = bool((steps < 0.0).all() or (steps > 0.0).all())
    jumped = abs(float(right[1] - right[0]))
    return claim(
        "coulomb.transients",
        "section 4, below figure 9, and figure 10",
        "Orbits that start on different sides of the discontinuity are attracted by S4 in "
        "different ways",
        Finding(
            "both end on S4",
            f"after {ROUNDS} rounds they are {settled[0]:.0e} and {settled[1]:.0e} from it",
            max(settled) < 1e-6,
        ),
        Finding(
            "they take different ways",
            f"from the left the fourth iterates approach point {ends[0] + 1} "
            f"{'from one side' if one_sided else 'from both sides'}; from the right the "
            f"first step is {jumped:.4f} and the end is point {ends[1] + 1}",
            one_sided and jumped > 10.0 * abs(float(left[1] - left[0])),
        ),
    )


CLAIMS: Final = {
    5: (_two_attractors, _unstable_orbits, _near_the_jump),
    9: (_basins, _no_separatrix),
    10: (_multiplier, _u4, _in_the_basin, _transients),
}
