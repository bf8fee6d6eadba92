"""Section 4, law (9): the cusps of f^2 meet the diagonal, and chaos is born."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.attractors import attractors
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import Moment, cusp_of, in_window, moment

BIRTH: Final = "alpha of the cusps of f^2 on the diagonal"
CRISIS: Final = "alpha of the collision of the chaotic attractor with U1"
DRAWN: Final = 1.20915  # figure 13
CHAOS: Final = (1.2095, 1.2103, 1.211, 1.213, 1.215)  # between birth and crisis; 1.211 is figure 14
BESIDE: Final = 1e-7  # of alpha: just below and just above a bifurcation
SMALL: Final = 0.02  # of an interval: "almost indistinguishable"


@dataclass(frozen=True)
class Facts:
    """Moments around birth and flip, the attractors between, and numbers."""

    below_birth: Moment
    above_birth: Moment
    chaos: tuple[Moment, ...]
    before_birth: tuple[Attractor, ...]  # in the window just below it
    attractors: dict[float, tuple[Attractor, ...]]  # by alpha: what starts beside the cusp reach
    cusps_off: tuple[float, float]  # of f^2: distances from the diagonal at the birth
    # largest distance of f^2 between the cusps for alpha = 1.20915, over theirs from each other
    off_diagonal: float
    merging: Value
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits on both sides of birth and flip, find attractors between birth and crisis."""
    numbers = printed.numbers(13, 15)
    birth = numbers[BIRTH].computed
    return Facts(
        below_birth=moment(birth - BESIDE),
        above_birth=moment(birth + BESIDE),
        chaos=tuple(map(moment, CHAOS)),
        before_birth=tuple(attractors(in_window(birth - BESIDE))),
        attractors={alpha: _from_cusp(alpha) for alpha in CHAOS},
        cusps_off=_cusps_off(birth),
        off_diagonal=_off_diagonal(DRAWN),
        merging=printed.BANDS_MERGE.value(14),
        numbers=numbers,
    )


def _from_cusp(alpha: float) -> tuple[Attractor, ...]:
    f = in_window(alpha)
    return tuple(attractors(f, starts=[cusp_of(f).d]))


def _cusps_off(alpha: float) -> tuple[float, float]:
    """Distance of f^2 from the diagonal at its two cusps: c, and the d that f takes to c."""
    f = in_window(alpha)
    cusp = cusp_of(f).d
    before = float(f.preimages(cusp).max())
    return abs(float(f(f(cusp))) - cusp), abs(float(f(f(before))) - before)


def _off_diagonal(alpha: float) -> float:
    f = in_window(alpha)
    cusp = cusp_of(f).d
    x = np.linspace(cusp, float(f(cusp)), 401)
    return float(np.abs(f.power(2)(x) - x).max() / (x[-1] - x[0]))


def _on_the_diagonal(facts: Facts) -> Claim:
    first, second = facts.cusps_off
    return claim(
        "law9.birth",
        "section 4, second example",
        "At about 1.20915 the two cusps of the second iterated map meet the diagonal together",
        Finding(
            "both cusps are on the diagonal at one alpha",
            f"distances {first:.0e} and {second:.0e}",
            max(first, second) < 1e-11,
        ),
        values=(facts.numbers[BIRTH],),
        note="They have to: the one is the image of the other under f.",
    )


def _indistinguishable(facts: Facts) -> Claim:
    return claim(
        "law9.near_diagonal",
        "section 4, second example",
        "Just after the bifurcation, at alpha = 1.20915, the second iterated map is almost "
        "indistinguishable from the diagonal",
        Finding(
            f"between its cusps f^2 is within {SMALL:.0%} of that interval of the diagonal",
            f"within {facts.off_diagonal:.3%}",
            facts.off_diagonal < SMALL,
        ),
        Finding(
            "1.20915 is just after the bifurcation",
            f"{DRAWN - facts.numbers[BIRTH].computed:.2e} above it",
            0.0 < DRAWN - facts.numbers[BIRTH].computed < 1e-4,
        ),
    )


def _period_two(facts: Facts) -> Claim:
    below, above = facts.below_birth, facts.above_birth
    born = {name: o for name, o in (("A", above.a), ("B", above.b)) if o is not None}
    early = [orbit for orbit in (below.a, below.b) if orbit is not None]
    listing = "; ".join(
        f"{name}: {', '.join(f'{x:.9f}' for x in o.points)}, multiplier {o.multiplier:.5f}"
        for name, o in born.items()
    )
    return claim(
        "law9.period_two",
        "section 4, second example",
        "At least two unstable orbits of period 2, A and B, are born there",
        Finding(
            "two unstable period-2 orbits above that are not there below",
            f"the complete lists hold {len(below.twice)} orbits of period 2 just below and "
            f"{len(above.twice)} just above; {listing}",
            len(born) == 2
            and not early
            and len(above.twice) - len(below.twice) >= 2
            and not any(orbit.stable for orbit in born.values()),
        ),
        note=(
            "Exactly two, of period 2: the third orbit of this period in the window, at "
            f"{', '.join(f'{x:.6f}' for x in below.twice[0].points)}, has nothing to do with it."
            if len(above.twice) - len(below.twice) == 2 and below.twice
            else ""
        ),
    )


def _chaos_is_born(facts: Facts) -> Claim:
    above = facts.above_birth
    first, second, third, fourth = above.images
    # On either side A is the first point that f^2 moves away from the images.
    lower, upper = above.a.points if above.a is not None else (np.nan, np.nan)
    trapped = second < above.cusp < fourth < lower and upper < third < first
    kinds = [item.kind for item in facts.before_birth]
    earliest = facts.attractors[CHAOS[0]]
    later = [f"{item.kind}, exponent {_exponent(item)}" for item in earliest]
    return claim(
        "law9.chaos",
        "section 4, second example",
        "Numerically, a non-periodic attractor is born at the same point",
        Finding(
            "no chaotic attractor in the window below",
            f"just below: {', '.join(kinds) or 'none'}",
            "chaotic" not in kinds,
        ),
        Finding(
            "f takes two intervals around the cusp's images into each other just above",
            f"f^2(c) = {second:.10f} < c = {above.cusp:.10f} < f^4(c) = {fourth:.10f} < A; "
            f"A < f^3(c) = {third:.10f} < f(c) = {first:.10f}"
            if trapped
            else f"the cusp's images {above.images} are not in such an order",
            bool(trapped),
        ),
        Finding(
            "nothing is stable in them",
            f"alpha = {CHAOS[0]}: {'; '.join(later)}",
            all(item.kind == "chaotic" for item in earliest),
        ),
        mechanism="a cusp of f^2 crosses the diagonal; its slopes there decide what is born",
    )


def _exponent(item: Attractor) -> str:
    return f"{item.lyapunov.value:.5f} ± {item.lyapunov.error:.0e}"


def _lifetime(facts: Facts) -> Claim:
    found = facts.attractors
    texts = [
        f"alpha = {alpha}: {item.kind}, exponent {_exponent(item)}"
        for alpha, items in found.items()
        for item in items
    ]
    return claim(
        "law9.lifetime",
        "section 4, second example",
        "The non-periodic attractor appears suddenly at about 1.20915 and disappears at about "
        "1.2153",
        Finding(
            "it is there between the two values",
            "; ".join(texts),
            all(item.kind == "chaotic" for items in found.values() for item in items),
        ),
        values=(facts.numbers[BIRTH], facts.numbers[CRISIS]),
    )


def _bands(facts: Facts) -> Claim:
    two = [m for m in facts.chaos if m.alpha < facts.merging.computed]
    bands = np.array([m.bands for m in two])
    listing = "; ".join(
        f"alpha = {m.alpha}: {m.bands[0]:.3e}, {m.bands[1]:.3e}, distance {m.bands[2]:.3e}"
        for m in two
    )
    numbers = {alpha: len(items[0].bands) for alpha, items in facts.attractors.items() if items}
    last = max(numbers)
    return claim(
        "law9.bands",
        "section 4, second example",
        "As alpha grows the two bands of the chaotic attractor become wider and their distance "
        "smaller",
        Finding(
            "both widths grow and the distance falls",
            listing,
            len(two) > 1
            and bool((np.diff(bands[:, :2], axis=0) > 0).all())
            and bool((np.diff(bands[:, 2]) < 0).all()),
        ),
        values=(facts.merging,),
        note=(
            f"The distance falls to zero before the attractor ends, which the paper does not "
            f"mention: at alpha = {last} there is one band."
            if numbers[last] == 1
            else ""
        ),
    )


def _embedded(facts: Facts) -> Claim:
    slack = 1e-12
    inside = {}
    for m in facts.chaos:
        held = [
            bool(item.contains(m.b.points, slack).all())
            for item in facts.attractors[m.alpha]
            if m.b is not None and item.kind == "chaotic"
        ]
        inside[m.alpha] = any(held)
    return claim(
        "law9.embedded",
        "section 4, second example",
        "The unstable orbit B is embedded in the chaotic attractor",
        Finding(
            "both points of B lie in the bands",
            ", ".join(f"alpha = {a}: {'yes' if yes else 'no'}" for a, yes in inside.items()),
            all(inside.values()),
        ),
    )


CLAIMS: Final = {
    11: (_lifetime, _embedded),
    13: (_on_the_diagonal, _indistinguishable, _period_two, _chaos_is_born),
    14: (_bands,),
}
