"""Section 4, law (9): S1 and U1 are born in a fold, the chaotic attractor ends on U1."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.bifurcations.conditions.conditions import Flip
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.bifurcations.normal_forms import (
    FoldCoefficient,
    flip_coefficient,
    fold_coefficient,
)
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import cusp_of, in_window

FOLD: Final = "alpha of the fold of S1 and U1"
CRISIS: Final = "alpha of the collision of the chaotic attractor with U1"
APPROACH: Final = (1.208, 1.211, 1.213, 1.215)  # 1.211 is figure 14
BETWEEN: Final = 1.2152  # between fold and crisis
AFTER: Final = 1.2154  # past the crisis, S1 not yet doubled
BESIDE: Final = 1e-7  # of alpha: just below and just above a bifurcation
ASIDE: Final = 1e-7  # of d, on both sides of U1
STEPS: Final = 1000  # of a transient
FLIPS: Final = 4  # of the cascade that are located
FEIGENBAUM: Final = 4.669201609


@dataclass(frozen=True)
class Lobe:
    """The minimum of the map left of its cusp: its d, and the least f(d) - d beside it."""

    alpha: float
    flat: float
    lowest: float


@dataclass(frozen=True)
class Side:
    """Fixed points left of the cusp, ascending, at one alpha."""

    alpha: float
    fixed: tuple[PeriodicOrbit, ...]
    clearance: float  # f^2(c) - U1, how far the attractor stays from U1; NaN without U1


@dataclass(frozen=True)
class Doubling:
    """A flip of the cascade; ``criticality`` from its normal form."""

    period: int
    value: Value
    criticality: str | None


@dataclass(frozen=True)
class Facts:
    """Lobes, sides of fold and crisis, attractors around them, and the flips of S1."""

    lobes: tuple[Lobe, ...]
    below_fold: Side
    above_fold: Side
    coefficient: FoldCoefficient
    break_distance: float  # of the fold from the map's nearest breakpoint
    between: Side
    attractors_between: tuple[Attractor, ...]
    # of orbits from just left and right of U1 after `STEPS` steps at alpha = 1.2152
    ends: tuple[float, float]
    below_crisis: Side
    above_crisis: Side
    attractors_after: tuple[Attractor, ...]
    cascade: tuple[Doubling, ...]
    numbers: dict[str, Value]


def facts() -> Facts:
    """Follow the lobe, list fixed points and attractors around fold and crisis, double S1."""
    numbers = printed.numbers(14, 15)
    fold, crisis = numbers[FOLD].computed, numbers[CRISIS].computed
    above_fold, between = _side(fold + BESIDE), _side(BETWEEN)
    meeting = float(np.mean([o.points[0] for o in above_fold.fixed]))
    return Facts(
        lobes=tuple(map(_lobe, APPROACH)),
        below_fold=_side(fold - BESIDE),
        above_fold=above_fold,
        coefficient=fold_coefficient(in_window(fold), [meeting], "alpha"),
        break_distance=min(abs(item.d - meeting) for item in breakpoints(in_window(fold))),
        between=between,
        attractors_between=tuple(attractors(in_window(BETWEEN))),
        ends=_from_both_sides(between),
        below_crisis=_side(crisis - BESIDE),
        above_crisis=_side(crisis + BESIDE),
        attractors_after=tuple(attractors(in_window(AFTER))),
        cascade=tuple(_cascade(fold)),
        numbers=numbers,
    )


def _lobe(alpha: float) -> Lobe:
    f = in_window(alpha)
    d = np.linspace(f.domain[0], cusp_of(f).d - 1e-9, 401)
    values = f.evaluate(d)
    flat = int(np.argmin(values.value))
    return Lobe(alpha, float(d[flat]), float(np.min(values.value - d)))


def _side(alpha: float) -> Side:
    f = in_window(alpha)
    cusp = cusp_of(f).d
    fixed = tuple(o for o in periodic_orbits(f).orbits if o.points[0] < cusp)
    second = float(f.iterate(cusp, 2)[-1])
    u1 = [float(o.points[0]) for o in fixed if not o.stable]
    return Side(alpha, fixed, second - u1[-1] if u1 else np.nan)


def _from_both_sides(side: Side) -> tuple[float, float]:
    f = in_window(side.alpha)
    (u1,) = (float(o.points[0]) for o in side.fixed if not o.stable)
    left, right = f.iterate(np.array([u1 - ASIDE, u1 + ASIDE]), STEPS)[:, -1]
    return float(left), float(right)


def _cascade(fold: float) -> Iterator[Doubling]:
    """Locate the first flips of S1, each of the stable orbit that the one before it made."""
    last, alpha = fold, AFTER
    for _ in range(FLIPS):
        f = in_window(alpha)
        orbit = next(a.orbit for a in attractors(f, starts=[cusp_of(f).d]) if a.orbit is not None)
        # Since the last flip (for S1, the fold) the multiplier has come down from 1 to m.
        m = orbit.multiplier
        guess = last + 2.0 * (alpha - last) / (1.0 - m)
        condition = Flip(orbit.period, tuple(orbit.points.tolist()))
        found = solve_near(condition, in_window, guess, step=0.2 * (guess - last))
        name = f"alpha where S1 goes from period {orbit.period} to {2 * orbit.period}"
        value = Value(name, found.value, found.error, 11, "(f^p)' = -1 along the orbit")
        normal = flip_coefficient(in_window(found.value), found.reading.points)
        yield Doubling(orbit.period, value, normal.criticality)
        # Not far into the next gap: it is shorter by a factor that tends to Feigenbaum's.
        alpha, last = found.value + 0.3 * (found.value - last) / FEIGENBAUM, found.value


def _lobe_approaches(facts: Facts) -> Claim:
    listing = ", ".join(f"{one.lowest:.3e} (alpha = {one.alpha})" for one in facts.lobes)
    flat = ", ".join(f"{one.flat:.5f}" for one in facts.lobes)
    heights = [one.lowest for one in facts.lobes]
    return claim(
        "law9.lobe",
        "section 4, second example",
        "The first iterated map has a lobe with a horizontal tangent, which approaches the "
        "diagonal as alpha grows",
        Finding(
            "least distance of f from the diagonal left of the cusp: falls and stays positive",
            f"{listing}; horizontal tangents at d = {flat}",
            all(a > b for a, b in pairwise(heights)) and heights[-1] > 0.0,
        ),
        note="The fold itself is where the slope is one, beside the horizontal tangent.",
    )


def _fold(facts: Facts) -> Claim:
    below, above = facts.below_fold, facts.above_fold
    kinds = sorted(orbit.kind for orbit in above.fixed)
    listing = ", ".join(f"{o.points[0]:.8f} (multiplier {o.multiplier:.6f})" for o in above.fixed)
    c = facts.coefficient
    return claim(
        "law9.fold",
        "section 4, second example",
        "At 1.2151 a smooth fold of f gives birth to two period-1 orbits, the stable S1 and the "
        "unstable U1",
        Finding(
            "no fixed point left of the cusp below, a stable and an unstable one above",
            f"{len(below.fixed)} just below; just above: {listing}",
            not below.fixed and kinds == ["stable", "unstable"],
        ),
        Finding(
            "it is smooth: f'' is not zero, and no breakpoint of f is near",
            f"f'' = {c.curvature:.3f} ± {c.error:.0e}; nearest breakpoint "
            f"{facts.break_distance:.2e} away, the orbits "
            f"{np.ptp([o.points[0] for o in above.fixed]):.2e} apart",
            abs(c.curvature) > c.error
            and facts.break_distance > np.ptp([o.points[0] for o in above.fixed]),
        ),
        values=(facts.numbers[FOLD],),
    )


def _collision(facts: Facts) -> Claim:
    between, below, above = facts.between, facts.below_crisis, facts.above_crisis
    return claim(
        "law9.crisis",
        "section 4, second example",
        "At 1.2153 the chaotic attractor collides with U1 and is gone",
        Finding(
            "the attractor's end f^2(c), c the cusp, comes down to U1 and passes it",
            f"f^2(c) - U1 = {between.clearance:.3e} at alpha = {between.alpha}, "
            f"{below.clearance:.1e} and {above.clearance:.1e} at {BESIDE:.0e} on either side",
            between.clearance > below.clearance > 0.0 > above.clearance,
        ),
        Finding(
            "there is chaos before and none after",
            f"attractors in the window at {BETWEEN}: {_kinds(facts.attractors_between)}; at "
            f"{AFTER}: {_kinds(facts.attractors_after)}",
            "chaotic" in _kinds(facts.attractors_between)
            and "chaotic" not in _kinds(facts.attractors_after),
        ),
        values=(facts.numbers[CRISIS],),
        mechanism="a boundary crisis: the image of the cusp meets the orbit that bounds the basin",
    )


def _kinds(found: tuple[Attractor, ...]) -> str:
    return ", ".join(f"{item.kind} of period {item.period}" for item in found) or "none"


def _boundary(facts: Facts) -> Claim:
    left, right = facts.ends
    s1 = next((float(o.points[0]) for o in facts.between.fixed if o.stable), np.nan)
    chaotic = [item for item in facts.attractors_between if item.kind == "chaotic"]
    caught = bool(chaotic) and bool(chaotic[0].contains(right, 1e-9))
    return claim(
        "law9.boundary",
        "section 4, second example",
        "U1 bounds the basin of the chaotic attractor",
        Finding(
            "from just left of U1 orbits go to S1, from just right of it to the chaos",
            f"at alpha = {BETWEEN}, {STEPS} steps from U1 - {ASIDE:.0e}: {left:.9f} (S1 = "
            f"{s1:.9f}); from U1 + {ASIDE:.0e}: {right:.6f}, "
            f"{'inside' if caught else 'outside'} the bands",
            abs(left - s1) < 1e-9 and caught,
        ),
    )


def _afterwards(facts: Facts) -> Claim:
    found = facts.attractors_after
    orbits = [item.orbit for item in found if item.orbit is not None]
    return claim(
        "law9.afterwards",
        "section 4, second example",
        "After the collision the transients that it attracted before go to S1",
        Finding(
            "S1 is the only attractor in the window",
            f"at alpha = {AFTER}: {_kinds(found)}"
            + "".join(f", d = {o.points[0]:.10f}, multiplier {o.multiplier:.6f}" for o in orbits),
            len(found) == 1 and found[0].kind == "periodic" and found[0].period == 1,
        ),
    )


def _doublings(facts: Facts) -> Claim:
    values = [one.value for one in facts.cascade]
    gaps = np.diff([value.computed for value in values])
    ratios = gaps[:-1] / gaps[1:]
    doubles = all(2 * a.period == b.period for a, b in pairwise(facts.cascade))
    end = values[-1].computed + gaps[-1] / (FEIGENBAUM - 1.0)
    return claim(
        "law9.cascade",
        "section 4, second example",
        "S1 then goes through a smooth period-doubling cascade",
        Finding(
            "its period doubles again and again",
            f"flips of the periods {', '.join(str(one.period) for one in facts.cascade)}; "
            f"ratios of successive gaps {', '.join(f'{ratio:.4f}' for ratio in ratios)}",
            len(facts.cascade) == FLIPS and doubles and bool((gaps > 0.0).all()),
        ),
        Finding(
            "each flip is supercritical",
            ", ".join(f"{one.criticality}" for one in facts.cascade),
            all(one.criticality == "super" for one in facts.cascade),
        ),
        values=tuple(values),
        note=f"With Feigenbaum's ratio {FEIGENBAUM:.6f} they accumulate near alpha = {end:.7f}.",
    )


CLAIMS: Final = {
    11: (_doublings,),
    14: (_lobe_approaches, _fold),
    15: (_collision, _boundary, _afterwards),
}
