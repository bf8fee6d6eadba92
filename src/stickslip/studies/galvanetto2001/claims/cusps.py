"""Section 4, law (9) at alpha = 1.208: P1, the cusps, and the motions tangent to the belt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from stickslip import examples
from stickslip.analysis.attractors.attractor import AttractorList
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.orbits.orbit import OrbitList
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import WINDOW, in_window

ALPHA: Final = 1.208
BLOCK: Final = 2
STARTS: Final = (0.3812, 0.3818)  # figure 17
FEW_ULP: Final = 64  # from the cusp: there the touch is still within ROUNDING of a tangency
ROUNDING: Final = 1e-6  # of a force at a touch, which goes with the root of the distance


@dataclass(frozen=True)
class Transient:
    """Motion from a start to the first stick of block 2."""

    # `touched` tells whether the block sticks in the first lobe towards the belt, which the other
    # side of the cusp misses.

    start: float
    time: float
    force: float  # needed force there


@dataclass(frozen=True)
class Facts:
    """The whole map, the window, corners of f and f^2 in it, and motions beside the cusp."""

    orbits: OrbitList
    breaks: tuple[Breakpoint, ...]
    attractors: AttractorList
    corners: tuple[Breakpoint, ...]
    corners_of_square: tuple[Breakpoint, ...]
    transients: tuple[Transient, ...]  # of figure 17
    beside: tuple[Transient, ...]  # from a few ulp left and right of the cusp
    limit: float  # needed force at which block 2 leaves the belt, beta
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits and breakpoints of the map and of its window; simulate beside the cusp."""
    f = event_map(examples.law9())
    window = in_window(ALPHA)
    corners = breakpoints(window).of_kind("corner")
    cusp = corners[0]
    beside = [
        end + sign * FEW_ULP * 2.0**-54
        for end, sign in zip(cusp.interval, (-1.0, 1.0), strict=True)
    ]
    return Facts(
        orbits=periodic_orbits(f, 2),
        breaks=tuple(breakpoints(f)),
        attractors=attractors(f),
        corners=corners,
        corners_of_square=breakpoints(window.power(2)).of_kind("corner"),
        transients=tuple(_transient(d) for d in STARTS),
        beside=tuple(_transient(d) for d in beside),
        limit=f.model.beta,
        numbers=printed.numbers(12, 17),
    )


def _transient(d: float) -> Transient:
    model = examples.law9()
    motion = simulate(model, d=d, until="stick")
    touch = next(e for e in motion.events if e.block == BLOCK and e.kind == "stick")
    x1, x2 = motion.x(touch.time)
    return Transient(d, touch.time, float(x2 + model.alpha * (x2 - x1)))


def _several(facts: Facts) -> Claim:
    stable = facts.orbits.stable
    listing = "; ".join(
        f"period {o.period} at {', '.join(f'{x:.6f}' for x in o.points)}, multiplier "
        f"{o.multiplier:.5f}"
        for o in stable
    )
    kinds = [f"{item.kind} of period {item.period}" for item in facts.attractors]
    lo, hi = WINDOW
    outside = [o for o in stable if not all(lo < x < hi for x in o.points)]
    return claim(
        "law9.several",
        "section 4, second example",
        "For these parameters several attractors may exist, of which only those in "
        "0.379 < d < 0.390 are studied",
        Finding(
            "more than one attractor",
            f"over the whole domain, alpha = {ALPHA}: {', '.join(kinds)}; stable orbits up to "
            f"period 2: {listing}",
            len(facts.attractors) > 1,
        ),
        note=(
            "Besides P1 there is a stable orbit that the range of d cuts: one of its points lies "
            "inside, the other outside."
            if outside
            else ""
        ),
    )


def _p1(facts: Facts) -> Claim:
    lo, hi = WINDOW
    fixed = [o for o in facts.orbits.of_period(1) if lo < o.points[0] < hi]
    return claim(
        "law9.p1",
        "section 4, second example",
        "For alpha = 1.208 the map has the stable fixed point P1",
        Finding(
            "one stable fixed point in the range of d",
            f"fixed points there: {len(fixed)}, multiplier "
            + ", ".join(f"{o.multiplier:.6f}" for o in fixed),
            sum(o.stable for o in fixed) == 1,
        ),
        values=tuple(value for name, value in facts.numbers.items() if "P1" in name),
    )


def _cusps(facts: Facts) -> Claim:
    one, two = facts.corners, facts.corners_of_square
    slopes = ", ".join(
        f"{item.d:.9f} (slopes {item.left_slope:.4f}, {item.right_slope:.4f})"
        for item in (*one, *two)
    )
    return claim(
        "law9.cusps",
        "section 4, second example",
        "The first iterated map has one cusp in the range of d, the second has two",
        Finding(
            "one corner of f where the slope changes its sign",
            f"corners of f in the range: {len(one)}",
            len(one) == 1 and one[0].left_slope > 0.0 > one[0].right_slope,
        ),
        Finding("two corners of f^2", f"corners of f and f^2: {slopes}", len(two) == 2),
        note="The second cusp of f^2 lies where f has the first one's d as its value.",
    )


def _transients(facts: Facts) -> Claim:
    first, second = facts.transients
    cusp = facts.corners[0].d
    value = next(value for name, value in facts.numbers.items() if "cusp" in name)
    return claim(
        "law9.transients",
        "section 4, second example, figure 17",
        "Starts at 0.3812 and 0.3818 lie on the two sides of the cusp, d of about 0.3815, and "
        "block 2 first comes to rest in different ways",
        Finding("the cusp lies between", f"at {cusp:.12f}", first.start < cusp < second.start),
        Finding(
            "the motion from the left turns back before the belt, that from the right sticks",
            f"block 2 first sticks at the times {first.time:.4f} and {second.time:.4f}, with "
            f"needed forces {first.force:.4f} and {second.force:.4f}",
            first.time > second.time + 0.1,
        ),
        values=(value,),
    )


def _tangent(facts: Facts) -> Claim:
    cusp = facts.corners[0]
    sticking = min(facts.beside, key=lambda one: one.time)
    off = abs(sticking.force - facts.limit)
    return claim(
        "law9.tangent",
        "section 4, second example, below figure 16",
        "The cusps correspond to motions tangent to the sticking interval",
        Finding(
            "at the cusp block 2 grazes",
            f"adjacent floats at d = {cusp.d:.15g} differ in this: {_mechanism(facts)}",
            "block 2 grazes" in _mechanism(facts),
        ),
        Finding(
            "at the touch beside the cusp the acceleration in eq. (16) vanishes",
            f"F(0) = 1 leaves beta - R_2 = {off:.1e} there",
            off < ROUNDING,
        ),
        mechanism=_mechanism(facts),
    )


def _mechanism(facts: Facts) -> str:
    """Mechanism of the cusp, from the whole map's list: windows do not know the motion."""
    cusp = facts.corners[0].d
    return min(facts.breaks, key=lambda item: abs(item.d - cusp)).mechanism


def _only_end_points(facts: Facts) -> Claim:
    grazes = [item for item in facts.breaks if "grazes" in item.mechanism]
    listing = "; ".join(f"{item.d:.8f}, a {item.kind}: {item.mechanism}" for item in grazes)
    return claim(
        "law9.end_points",
        "section 4, eq. (16)",
        "With law (9) a motion can be tangent to the sticking interval only at its end points",
        Finding(
            "every graze of the map, over its whole domain, is at an end point",
            f"{len(grazes)} grazes: {listing}",
            bool(grazes) and all(item.mechanism.endswith("at an end point") for item in grazes),
        ),
        mechanism="F(0) is the static limit: a touch without acceleration needs the full force",
    )


CLAIMS: Final = {11: (_several,), 12: (_p1, _cusps), 17: (_transients, _tangent, _only_end_points)}
