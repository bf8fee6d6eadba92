"""Section 4, Coulomb friction: S4 and U4 meet at the jump, and what follows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.analysis.one_d.basins import Basins, basins
from stickslip.analysis.one_d.outcomes import predicted_at_jump
from stickslip.paper.claim import Claim, Finding
from stickslip.paper.galvanetto2001 import printed
from stickslip.paper.galvanetto2001.orbits import from_point_1, jump_of_s4
from stickslip.study.event_map import event_map
from stickslip.study.maps import attractors, periodic_orbits

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.attractors import Attractor, AttractorList
    from stickslip.analysis.outcome import LocalAttractor, Outcome
    from stickslip.paper.values import Value

FIGURES: Final = (4, 6, 8, 10)

COLLISION: Final = "V where S4 meets the jump"
RANGE: Final = (0.0366, 0.0372)
BESIDE: Final = 1e-8  # of V: just below and just above the collision
SAMPLES: Final = (0.0370, 0.0371, 0.0372)  # past it; 0.0370 is the paper's figure 6
CLOSE_TO_ONE: Final = 0.1  # what a multiplier close to one differs by at most
SAME_EDGE: Final = 1e-5  # basins on both sides of the collision, 2 BESIDE apart


@dataclass(frozen=True)
class Side:
    """The map at one driving velocity near the collision.

    ``gap`` is f^4(c-) - c at the jump c; ``slopes`` those of f^4 left and right of it. ``s4`` and
    ``u4`` start with the point at the jump and are empty where the orbit does not exist;
    ``multiplier`` is that of S4 (NaN without it), ``fixed_points`` the number of fixed points.
    """

    V: float
    jump: float
    gap: float
    slopes: tuple[float, float]
    s4: NDArray[np.float64]
    u4: NDArray[np.float64]
    multiplier: float
    basins: Basins

    @property
    def basin_of_s1(self) -> NDArray[np.float64]:
        """Ends of the intervals of the basin of S1, shape (n, 2)."""
        found = self.basins
        ends = np.stack([found.edges[:-1], found.edges[1:]], axis=1)
        owned = [k >= 0 and found.attractors[k].period == 1 for k in found.index]
        return np.asarray(ends[owned])

    @property
    def others(self) -> tuple[Attractor, ...]:
        """The attractors besides S1."""
        return tuple(item for item in self.basins.attractors if item.period != 1)


@dataclass(frozen=True)
class Facts:
    """Both sides of the collision, the ends of the range of V, and attractors past it.

    ``fixed_points`` holds (n, 2) arrays of fixed points and multipliers at the ends of the range;
    ``predicted`` what the shape of the map at the collision foretells.
    """

    before: Side
    after: Side
    start: Side
    fixed_points: tuple[NDArray[np.float64], NDArray[np.float64]]
    past: dict[float, AttractorList]
    predicted: Outcome
    numbers: dict[str, Value]


def facts() -> Facts:
    """Solve for the collision, then list orbits and attractors around it."""
    numbers = printed.numbers(4)
    at = numbers[COLLISION].computed
    return Facts(
        before=_side(at - BESIDE),
        after=_side(at + BESIDE),
        start=_side(RANGE[0]),
        fixed_points=(_fixed_points(RANGE[0]), _fixed_points(RANGE[1])),
        past={V: attractors(examples.coulomb(V=V)) for V in SAMPLES},
        predicted=_predicted(at),
        numbers=numbers,
    )


def _side(V: float) -> Side:
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


def _predicted(V: float) -> Outcome:
    """Predict what follows when S4, left of the jump, rises on to it as V grows."""
    f = event_map(examples.coulomb(V=V))
    return predicted_at_jump(f, jump_of_s4(f), side=-1, direction=1, period=4)


def _fixed_points(V: float) -> NDArray[np.float64]:
    found = periodic_orbits(examples.coulomb(V=V))
    return np.array([(orbit.points[0], orbit.multiplier) for orbit in found])


def claims(facts: Facts) -> Iterator[Claim]:
    """Figures 4, 6, 8 and 10."""
    yield _steady_motions(facts)
    yield _meets_the_line(facts)
    yield _sudden(facts)
    yield _non_periodic(facts)
    yield _fold(facts)
    yield _same_basin(facts)
    yield _multiplier(facts)
    yield _discontinuous(facts)


def _steady_motions(facts: Facts) -> Claim:
    first, last = facts.fixed_points
    stable = [np.abs(found[:, 1]) < 1.0 for found in facts.fixed_points]
    return Claim(
        "collision.range",
        4,
        "figure 4",
        "Over 0.0366 < V < 0.0372 the stable S1 and the unstable U1 and U2 go on",
        (
            Finding(
                "three fixed points of the same stability at both ends of the range",
                f"V = {RANGE[0]}: {_list(first)}; V = {RANGE[1]}: {_list(last)}",
                len(first) == len(last) == 3
                and bool((stable[0] == stable[1]).all())
                and stable[0].sum() == 1,
            ),
        ),
    )


def _list(found: NDArray[np.float64]) -> str:
    return ", ".join(f"{d:.10f} (multiplier {slope:.6f})" for d, slope in found)


def _meets_the_line(facts: Facts) -> Claim:
    before, start = facts.before, facts.start
    gaps = [abs(side.s4[0] - side.jump) if side.s4.size else np.nan for side in (start, before)]
    return Claim(
        "collision.value",
        4,
        "section 4, first paragraph",
        "For V of about 0.03698 a point of S4 meets a line of discontinuity of the map (D in "
        "figure 4)",
        (
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
        ),
        tuple(facts.numbers.values()),
        mechanism="block 2 grazes its stick interval (figure 7)",
    )


def _sudden(facts: Facts) -> Claim:
    before, after = facts.before, facts.after
    periods = [sorted(item.period for item in side.others) for side in (before, after)]
    return Claim(
        "collision.sudden",
        4,
        "section 4, first paragraph",
        "There S4 is lost in a sudden transition to another motion",
        (
            Finding(
                "S4 attracts below the collision and is no orbit of the map above it",
                f"attractors besides S1: period {_words(periods[0])} below, "
                f"{_words(periods[1])} above ({BESIDE:.0e} on either side); stable orbits of "
                f"period 4 above: {int(after.s4.size > 0)}",
                periods[0] == [4] and 4 not in periods[1] and after.s4.size == 0,
            ),
        ),
    )


def _words(periods: list[int]) -> str:
    return " and ".join(map(str, periods)) or "none"


def _non_periodic(facts: Facts) -> Claim:
    lists = {**facts.past, facts.after.V: facts.after.basins.attractors}
    found = sorted((V, item) for V, items in lists.items() for item in items if item.period != 1)
    texts = [f"V = {V:.10g}: {_describe(item)}" for V, item in found]
    family = facts.predicted.after
    return Claim(
        "collision.non_periodic",
        6,
        "section 4, first paragraph, and figures 6 and 7(b)",
        "The attractor that follows S4 is not periodic",
        (
            Finding(
                "at no driving velocity examined is it a stable periodic orbit",
                "; ".join(texts),
                all(item.kind != "periodic" for _, item in found),
            ),
            Finding(
                "the shape of the map at the collision foretells something else than cycles",
                f"it foretells {family}: {facts.predicted.text}",
                family is None or "period" not in family.kind,
            ),
        ),
        note=_family(family, [item.period for _, item in found]),
    )


def _family(family: LocalAttractor | None, periods: list[int]) -> str:
    """Explain the periods, if they are of the family foretold."""
    if family is None or not family.base:
        return ""
    if any(period % family.base != family.offset % family.base for period in periods):
        return ""
    return (
        f"The periods {', '.join(map(str, sorted(periods)))} are all {family.base} n + "
        f"{family.offset}: the orbit climbs for n rounds beside the place where S4 was, crosses "
        f"the jump, and is back after {family.offset} more steps. n grows without bound towards "
        "the collision. A period of dozens of global stick phases looks like none."
    )


def _describe(item: Attractor) -> str:
    if item.orbit is None:
        return f"{item.kind}, exponent {item.lyapunov.value:.4f}"
    return f"period {item.period}, multiplier {item.orbit.multiplier:.6f}"


def _fold(facts: Facts) -> Claim:
    before, after = facts.before, facts.after
    apart = [
        float(np.abs(side.s4 - side.u4).max()) if side.s4.size and side.u4.size else np.nan
        for side in (facts.start, before)
    ]
    return Claim(
        "collision.s4_u4",
        8,
        "section 4, around figures 8 to 10",
        "S4 and U4 collide, as a stable and an infinitely unstable orbit do in a discontinuous "
        "fold",
        (
            Finding(
                "both exist below and their distance falls to zero",
                f"largest distance of their points {apart[0]:.4e} at V = {facts.start.V}, "
                f"{apart[1]:.1e} at {BESIDE:.0e} below the collision",
                bool(apart[1] < 100 * BESIDE < apart[0]),
            ),
            Finding(
                "neither exists above",
                f"above: {int(after.s4.size > 0)} stable orbits of period 4, "
                f"{int(after.u4.size > 0)} infinitely unstable ones through this jump",
                after.s4.size == after.u4.size == 0,
            ),
        ),
        note="Figure 8(c), V = 0.0372, shows the consequence: no intersection is left there.",
    )


def _same_basin(facts: Facts) -> Claim:
    first, second = facts.before.basin_of_s1, facts.after.basin_of_s1
    same_shape = first.shape == second.shape
    moved = float(np.abs(first - second).max()) if same_shape else np.inf
    rest = [1.0 - side.basins.undecided - side.basins.left for side in (facts.before, facts.after)]
    return Claim(
        "collision.same_basin",
        10,
        "section 4, below figure 10",
        "The collision merges no basins: the new attractor has the basin that S4 had",
        (
            Finding(
                "the basin of S1 is the same on both sides",
                f"{len(first)} and {len(second)} intervals whose ends differ by {moved:.1e} over "
                f"2 x {BESIDE:.0e} in V",
                moved < SAME_EDGE,
            ),
            Finding(
                "all the rest belongs to what follows S4",
                f"decided: {rest[0]:.6f} of the domain below, {rest[1]:.6f} above",
                min(rest) > 1.0 - 1e-9,
            ),
        ),
    )


def _multiplier(facts: Facts) -> Claim:
    first, last = facts.start.multiplier, facts.before.multiplier
    left, right = facts.before.slopes
    rises = facts.before.gap < 0.0
    return Claim(
        "collision.multiplier",
        10,
        "section 4, below figure 10",
        "At the bifurcation a multiplier jumps across the unit circle, from a positive value close "
        "to one to infinity",
        (
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
        ),
        note="So linear stability gives no warning: S4 is lost while it still attracts well.",
    )


def _discontinuous(facts: Facts) -> Claim:
    before, after = facts.before, facts.after
    orbits = [int(side.s4.size > 0) + int(side.u4.size > 0) for side in (before, after)]
    last = before.multiplier
    return Claim(
        "collision.definition",
        10,
        "section 2, definition of a discontinuous bifurcation, and section 5",
        "The number of periodic solutions changes, and the multipliers at the bifurcation are a "
        "set that meets the unit circle",
        (
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
        ),
    )
