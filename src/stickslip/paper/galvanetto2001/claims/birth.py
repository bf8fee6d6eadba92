"""Section 4, law (9): the cusps of f^2 meet the diagonal, chaos is born, P1 flips."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.one_d.normal_forms import flip_coefficient
from stickslip.paper.claim import Claim, Finding
from stickslip.paper.galvanetto2001 import printed
from stickslip.paper.galvanetto2001.orbits import cusp_of, in_window
from stickslip.paper.values import Value
from stickslip.study.maps import attractors, periodic_orbits

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.attractors import Attractor
    from stickslip.analysis.one_d.normal_forms import FlipCoefficient
    from stickslip.analysis.orbits import PeriodicOrbit

FIGURES: Final = (11, 13, 14)

BIRTH: Final = "alpha of the cusps of f^2 on the diagonal"
FLIP: Final = "alpha of the flip of P1"
CRISIS: Final = "alpha of the collision of the chaotic attractor with U1"
DRAWN: Final = 1.20915  # figure 13
SAMPLES: Final = (1.2093, 1.2095, 1.2097)  # between birth and flip
CHAOS: Final = (1.2095, 1.2103, 1.211, 1.213, 1.215)  # between birth and crisis; 1.211 is figure 14
BESIDE: Final = 1e-7  # of alpha: just below and just above a bifurcation
SMALL: Final = 0.02  # of an interval: "almost indistinguishable"


@dataclass(frozen=True)
class Moment:
    """The map of the window at one alpha.

    ``twice`` are its orbits of period 2; ``a``, ``b`` those born at the cusp, None where they do
    not exist: b has a negative multiplier. ``images`` are f(c) .. f^4(c), c the cusp.
    """

    alpha: float
    cusp: float
    images: NDArray[np.float64]
    p1: PeriodicOrbit
    twice: tuple[PeriodicOrbit, ...]
    a: PeriodicOrbit | None
    b: PeriodicOrbit | None

    @property
    def bands(self) -> NDArray[np.float64]:
        """Widths of the two bands between images of the cusp, and the gap between them."""
        first, second, third, fourth = self.images
        return np.array([fourth - second, first - third, third - fourth])


@dataclass(frozen=True)
class Facts:
    """Moments around birth and flip, the attractors between, and numbers.

    ``cusps_off`` is how far each of the two cusps of f^2 is from the diagonal at the birth,
    ``off_diagonal`` the largest distance of f^2 from it between the cusps for alpha = 1.20915, as
    a share of the interval; ``attractors`` maps alpha to what starts beside the cusp reach;
    ``before_birth`` holds the attractors in the window just below it.
    """

    below_birth: Moment
    above_birth: Moment
    approach: tuple[Moment, ...]
    below_flip: Moment
    above_flip: Moment
    chaos: tuple[Moment, ...]
    before_birth: tuple[Attractor, ...]
    attractors: dict[float, tuple[Attractor, ...]]
    cusps_off: tuple[float, float]
    off_diagonal: float
    coefficient: FlipCoefficient
    merging: Value
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits on both sides of birth and flip, find attractors between birth and crisis."""
    numbers = printed.numbers(11, 13, 15)
    birth, flip = numbers[BIRTH].computed, numbers[FLIP].computed
    at_flip = _moment(flip)
    return Facts(
        below_birth=_moment(birth - BESIDE),
        above_birth=_moment(birth + BESIDE),
        approach=tuple(map(_moment, SAMPLES)),
        below_flip=_moment(flip - BESIDE),
        above_flip=_moment(flip + BESIDE),
        chaos=tuple(map(_moment, CHAOS)),
        before_birth=tuple(attractors(in_window(birth - BESIDE))),
        attractors={alpha: _from_cusp(alpha) for alpha in CHAOS},
        cusps_off=_cusps_off(birth),
        off_diagonal=_off_diagonal(DRAWN),
        coefficient=flip_coefficient(in_window(flip), at_flip.p1.points),
        merging=printed.BANDS_MERGE.value(14),
        numbers=numbers,
    )


def _moment(alpha: float) -> Moment:
    f = in_window(alpha)
    cusp = cusp_of(f).d
    found = periodic_orbits(f, 2)
    (p1,) = (o for o in found.of_period(1) if o.points[0] > cusp)
    twice = found.of_period(2)
    # A and B have a point on either side of P1, all four between the cusp's first two images.
    images = f.iterate(cusp, 4)[1:]
    born = [o for o in twice if o.points[0] > images[1] and o.points[1] < images[0]]
    a, b = (next((o for o in born if (o.multiplier > 0) is up), None) for up in (True, False))
    return Moment(alpha, cusp, images, p1, twice, a, b)


def _from_cusp(alpha: float) -> tuple[Attractor, ...]:
    f = in_window(alpha)
    return tuple(attractors(f, seeds=[cusp_of(f).d]))


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


def claims(facts: Facts) -> Iterator[Claim]:
    """Figures 11, 13 and 14."""
    yield _p1(facts)
    yield _on_the_diagonal(facts)
    yield _indistinguishable(facts)
    yield _period_two(facts)
    yield _chaos_is_born(facts)
    yield _lifetime(facts)
    yield _flip(facts)
    yield _approach(facts)
    yield _bands(facts)
    yield _embedded(facts)


def _p1(facts: Facts) -> Claim:
    below, above = (m.p1.multiplier for m in (facts.below_flip, facts.above_flip))
    return Claim(
        "law9.p1_stability",
        11,
        "section 4, second example",
        "As alpha grows P1 changes stability at about 1.2099",
        (
            Finding(
                "the multiplier of P1 leaves the unit circle at -1",
                f"{below:.9f} just below, {above:.9f} just above",
                -1.0 < below < -0.99 and above < -1.0,
            ),
        ),
        (facts.numbers[FLIP],),
    )


def _on_the_diagonal(facts: Facts) -> Claim:
    first, second = facts.cusps_off
    return Claim(
        "law9.birth",
        13,
        "section 4, second example",
        "At about 1.20915 the two cusps of the second iterated map meet the diagonal together",
        (
            Finding(
                "both cusps are on the diagonal at one alpha",
                f"distances {first:.0e} and {second:.0e}",
                max(first, second) < 1e-11,
            ),
        ),
        (facts.numbers[BIRTH],),
        note="They have to: the one is the image of the other under f.",
    )


def _indistinguishable(facts: Facts) -> Claim:
    return Claim(
        "law9.near_diagonal",
        13,
        "section 4, second example",
        "Just after the bifurcation, at alpha = 1.20915, the second iterated map is almost "
        "indistinguishable from the diagonal",
        (
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
        ),
    )


def _period_two(facts: Facts) -> Claim:
    below, above = facts.below_birth, facts.above_birth
    born = [orbit for orbit in (above.a, above.b) if orbit is not None]
    early = [orbit for orbit in (below.a, below.b) if orbit is not None]
    listing = "; ".join(
        f"{name}: {', '.join(f'{x:.9f}' for x in o.points)}, multiplier {o.multiplier:.5f}"
        for name, o in zip("AB", born, strict=False)
    )
    return Claim(
        "law9.period_two",
        13,
        "section 4, second example",
        "At least two unstable orbits of period 2, A and B, are born there",
        (
            Finding(
                "two unstable period-2 orbits above that are not there below",
                f"the complete lists hold {len(below.twice)} orbits of period 2 just below and "
                f"{len(above.twice)} just above; {listing}",
                len(born) == 2
                and not early
                and len(above.twice) - len(below.twice) >= 2
                and not any(orbit.stable for orbit in born),
            ),
        ),
        note="Exactly two, of period 2: the third orbit of this period in the window, at "
        f"{', '.join(f'{x:.6f}' for x in below.twice[0].points)}, has nothing to do with it."
        if len(above.twice) - len(below.twice) == 2 and below.twice
        else "",
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
    return Claim(
        "law9.chaos",
        13,
        "section 4, second example",
        "Numerically, a non-periodic attractor is born at the same point",
        (
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
    return Claim(
        "law9.lifetime",
        11,
        "section 4, second example",
        "The non-periodic attractor appears suddenly at about 1.20915 and disappears at about "
        "1.2153",
        (
            Finding(
                "it is there between the two values",
                "; ".join(texts),
                all(item.kind == "chaotic" for items in found.values() for item in items),
            ),
        ),
        (facts.numbers[BIRTH], facts.numbers[CRISIS]),
    )


def _flip(facts: Facts) -> Claim:
    below, above = facts.below_flip, facts.above_flip
    c = facts.coefficient
    distance = np.nan
    if below.a is not None:
        distance = float(np.abs(below.a.points - below.p1.points[0]).max())
    return Claim(
        "law9.flip",
        11,
        "section 4, second example",
        "At 1.2099 P1 and A meet in a smooth subcritical flip: the unstable period-2 orbit is gone "
        "and P1 is unstable",
        (
            Finding(
                "A exists below, unstable, and not above",
                f"A just below: {'no' if below.a is None else f'{below.a.multiplier:.9f}'} "
                f"(multiplier), {distance:.2e} from P1; above: {'yes' if above.a else 'gone'}",
                below.a is not None and not below.a.stable and above.a is None,
            ),
            Finding(
                "the normal form is that of a subcritical flip",
                f"cubic coefficient {c.value:.6g} ± {c.error:.1g}",
                c.criticality == "sub",
            ),
        ),
        (facts.numbers[FLIP],),
    )


def _approach(facts: Facts) -> Claim:
    moments = (facts.above_birth, *facts.approach, facts.below_flip)
    apart = [
        float(np.abs(m.a.points - m.p1.points[0]).max()) if m.a is not None else np.nan
        for m in moments
    ]
    listing = ", ".join(
        f"{gap:.3e} (alpha = {m.alpha:.7f})" for m, gap in zip(moments, apart, strict=True)
    )
    return Claim(
        "law9.approach",
        11,
        "section 4, second example",
        "As alpha grows, A approaches P1",
        (
            Finding(
                "its distance from P1 falls",
                listing,
                all(a > b for a, b in pairwise(apart)),
            ),
        ),
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
    return Claim(
        "law9.bands",
        14,
        "section 4, second example",
        "As alpha grows the two bands of the chaotic attractor become wider and their distance "
        "smaller",
        (
            Finding(
                "both widths grow and the distance falls",
                listing,
                len(two) > 1
                and bool((np.diff(bands[:, :2], axis=0) > 0).all())
                and bool((np.diff(bands[:, 2]) < 0).all()),
            ),
        ),
        (facts.merging,),
        note=f"The distance falls to zero before the attractor ends, which the paper does not "
        f"mention: at alpha = {last} there is one band."
        if numbers[last] == 1
        else "",
    )


def _embedded(facts: Facts) -> Claim:
    slack = 1e-12
    inside = {}
    for moment in facts.chaos:
        held = [
            bool(item.contains(moment.b.points, slack).all())
            for item in facts.attractors[moment.alpha]
            if moment.b is not None and item.kind == "chaotic"
        ]
        inside[moment.alpha] = any(held)
    return Claim(
        "law9.embedded",
        11,
        "section 4, second example",
        "The unstable orbit B is embedded in the chaotic attractor",
        (
            Finding(
                "both points of B lie in the bands",
                ", ".join(f"alpha = {a}: {'yes' if yes else 'no'}" for a, yes in inside.items()),
                all(inside.values()),
            ),
        ),
    )
