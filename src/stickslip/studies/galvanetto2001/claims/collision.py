"""Section 4, Coulomb friction: S4 and U4 meet at the jump."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.basins import Basins, basins
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.numerics.arrays import Floats
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import from_point_1, jump_of_s4

COLLISION: Final = "V where S4 meets the jump"
BESIDE: Final = 1e-8  # of V: just below and just above the collision
RANGE: Final = (0.0366, 0.0372)
CLOSE_TO_ONE: Final = 0.1  # what a multiplier close to one differs by at most


@dataclass(frozen=True)
class Side:
    """The map at one driving velocity near the collision."""

    V: float
    jump: float
    gap: float  # f^4(c-) - c at the jump c
    slopes: tuple[float, float]  # of f^4 left and right of the jump
    # starts with the point at the jump, as u4; empty where the orbit does not exist
    s4: Floats
    u4: Floats
    multiplier: float  # of S4, NaN without it
    basins: Basins

    @property
    def basin_of_s1(self) -> Floats:
        """Ends of the intervals of the basin of S1, shape (n, 2)."""
        found = self.basins
        ends = np.stack([found.edges[:-1], found.edges[1:]], axis=1)
        owned = [k >= 0 and found.attractors[k].period == 1 for k in found.index]
        return np.asarray(ends[owned])

    @property
    def others(self) -> tuple[Attractor, ...]:
        """The attractors besides S1."""
        return tuple(item for item in self.basins.attractors if item.period != 1)


@lru_cache(maxsize=8)  # the claims about the collision and about what follows share two
def side(V: float) -> Side:
    """List orbits around the jump that S4 meets, and find the basins."""
    f = event_map(examples.coulomb(V=V))
    jump = jump_of_s4(f)
    f4 = f.power(4)
    left, right = jump.interval
    inside = 1e-9  # at the last float the slope may be the other branch's
    slopes = f4.evaluate([left - inside, right + inside]).derivative
    found = periodic_orbits(f, period=4, infinitely_unstable=True)
    stable = [orbit for orbit in found if orbit.stable]
    crossing = [o for o in found if o.jump is not None and o.jump.d == jump.d]
    return Side(
        V,
        jump.d,
        float(f4(left)) - left,
        (float(slopes[0]), float(slopes[1])),
        from_point_1(stable[0], jump.d) if stable else np.empty(0),
        from_point_1(crossing[0], jump.d) if crossing else np.empty(0),
        stable[0].multiplier if stable else float("nan"),
        basins(f),
    )


@dataclass(frozen=True)
class Facts:
    """Both sides of the collision and the ends of the range of V."""

    before: Side
    after: Side
    start: Side
    end: Side
    # at these ends, with multipliers: (n, 2) arrays
    fixed_points: tuple[Floats, Floats]
    numbers: dict[str, Value]


def facts() -> Facts:
    """Solve for the collision, then list orbits and attractors around it."""
    numbers = printed.numbers(4)
    at = numbers[COLLISION].computed
    return Facts(
        before=side(at - BESIDE),
        after=side(at + BESIDE),
        start=side(RANGE[0]),
        end=side(RANGE[1]),
        fixed_points=(_fixed_points(RANGE[0]), _fixed_points(RANGE[1])),
        numbers=numbers,
    )


def _fixed_points(V: float) -> Floats:
    found = periodic_orbits(examples.coulomb(V=V))
    return np.array([(orbit.points[0], orbit.multiplier) for orbit in found])


def _steady_motions(facts: Facts) -> Claim:
    first, last = facts.fixed_points
    stable = [np.abs(found[:, 1]) < 1.0 for found in facts.fixed_points]
    return claim(
        "collision.range",
        "figure 4",
        "Over 0.0366 < V < 0.0372 the stable S1 and the unstable U1 and U2 go on",
        Finding(
            "three fixed points of the same stability at both ends of the range",
            f"V = {RANGE[0]}: {_list(first)}; V = {RANGE[1]}: {_list(last)}",
            len(first) == len(last) == 3
            and bool((stable[0] == stable[1]).all())
            and stable[0].sum() == 1,
        ),
    )


def _list(found: Floats) -> str:
    return ", ".join(f"{d:.10f} (multiplier {slope:.6f})" for d, slope in found)


def _meets_the_line(facts: Facts) -> Claim:
    before, start = facts.before, facts.start
    gaps = [abs(side.s4[0] - side.jump) if side.s4.size else np.nan for side in (start, before)]
    return claim(
        "collision.value",
        "section 4, first paragraph",
        "For V of about 0.03698 a point of S4 meets a line of discontinuity of the map (D in "
        "figure 4)",
        Finding(
            "the distance of point 1 from the jump falls to zero",
            f"{gaps[0]:.6e} at V = {start.V}, {gaps[1]:.1e} at {BESIDE:.0e} below",
            bool(gaps[1] < 100 * BESIDE and gaps[1] < gaps[0]),
        ),
        Finding(
            "f^4(c-) - c changes its sign there",
            f"{before.gap:.2e} below, {facts.after.gap:.2e} above",
            before.gap < 0.0 < facts.after.gap,
        ),
        values=tuple(facts.numbers.values()),
        mechanism="block 2 grazes its stick interval (figure 7)",
    )


def _sudden(facts: Facts) -> Claim:
    before, after = facts.before, facts.after
    periods = [sorted(item.period for item in side.others) for side in (before, after)]
    return claim(
        "collision.sudden",
        "section 4, first paragraph",
        "There S4 is lost in a sudden transition to another motion",
        Finding(
            "S4 attracts below the collision and is no orbit of the map above it",
            f"attractors besides S1: period {_words(periods[0])} below, "
            f"{_words(periods[1])} above ({BESIDE:.0e} on either side); stable orbits of "
            f"period 4 above: {int(after.s4.size > 0)}",
            periods[0] == [4] and 4 not in periods[1] and after.s4.size == 0,
        ),
    )


def _words(periods: list[int]) -> str:
    return " and ".join(map(str, periods)) or "none"


def _fold(facts: Facts) -> Claim:
    before, after, end = facts.before, facts.after, facts.end
    apart = [
        float(np.abs(side.s4 - side.u4).max()) if side.s4.size and side.u4.size else np.nan
        for side in (facts.start, before)
    ]
    return claim(
        "collision.s4_u4",
        "section 4, around figures 8 to 10",
        "S4 and U4 collide, as a stable and an infinitely unstable orbit do in a discontinuous "
        "fold",
        Finding(
            "both exist below and their distance falls to zero",
            f"largest distance of their points {apart[0]:.4e} at V = {facts.start.V}, "
            f"{apart[1]:.1e} at {BESIDE:.0e} below the collision",
            bool(apart[1] < 100 * BESIDE < apart[0]),
        ),
        Finding(
            "neither exists above, nor at V = 0.0372 (figure 8(c))",
            f"above: {_present(after)}; at V = {end.V}: {_present(end)}",
            all(side.s4.size == side.u4.size == 0 for side in (after, end)),
        ),
    )


def _present(one: Side) -> str:
    stable, crossing = int(one.s4.size > 0), int(one.u4.size > 0)
    return f"{stable} stable orbits of period 4, {crossing} infinitely unstable ones at the jump"


def _multiplier(facts: Facts) -> Claim:
    first, last = facts.start.multiplier, facts.before.multiplier
    left, right = facts.before.slopes
    rises = facts.before.gap < 0.0
    return claim(
        "collision.multiplier",
        "section 4, below figure 10",
        "At the bifurcation a multiplier jumps across the unit circle, from a positive value close "
        "to one to infinity",
        Finding(
            "the multiplier of S4 is inside the unit circle and positive",
            f"{last:.10f} just below the collision; one-sided slopes of f^4 there: {left:.6f} "
            f"and {right:.6f}",
            0.0 < last < 1.0,
        ),
        Finding(
            "it becomes infinite: f^4 with its jumps filled in rises across the jump",
            f"f^4(c-) - c = {facts.before.gap:.1e}, and U4 crosses the jump upwards"
            if facts.before.u4.size
            else "no orbit crosses the jump",
            bool(facts.before.u4.size) and rises,
        ),
        Finding(
            f"it is close to one (within {CLOSE_TO_ONE})",
            f"{first:.6f} at V = {facts.start.V}, {last:.6f} at the collision: it moves away "
            "from one"
            if last < first
            else f"{first:.6f} at V = {facts.start.V}, {last:.6f} at the collision",
            abs(last - 1.0) < CLOSE_TO_ONE,
            essential=False,
        ),
        note=(
            "So linear stability gives no warning: S4 is lost while it still attracts well."
            if abs(last) < 1.0 - CLOSE_TO_ONE
            else ""
        ),
    )


def _discontinuous(facts: Facts) -> Claim:
    before, after = facts.before, facts.after
    orbits = [int(side.s4.size > 0) + int(side.u4.size > 0) for side in (before, after)]
    last = before.multiplier
    return claim(
        "collision.definition",
        "section 2, definition of a discontinuous bifurcation, and section 5",
        "The number of periodic solutions changes, and the multipliers at the bifurcation are a "
        "set that meets the unit circle",
        Finding(
            "the number of period-4 orbits at the jump changes",
            f"{orbits[0]} below, {orbits[1]} above",
            orbits[0] != orbits[1],
        ),
        Finding(
            "one lies between the two ends of the set",
            f"the set reaches from {last:.6f} to infinity",
            last < 1.0 and bool(before.u4.size),
        ),
    )


CLAIMS: Final = {
    4: (_steady_motions, _meets_the_line, _sudden),
    8: (_fold,),
    10: (_multiplier, _discontinuous),
}
