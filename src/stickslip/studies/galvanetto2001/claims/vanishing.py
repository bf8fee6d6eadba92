"""Section 4, law (9): P1, U1 and B vanish together; why two like cusps do unlike things."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from stickslip.analysis.bifurcations.border_collision.skew_tent import (
    attractor_of_skew_tent,
    paired_side,
)
from stickslip.analysis.bifurcations.outcome import LocalAttractor
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.orbits.orbit import OrbitList, PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.orbits import cusp_of, in_window

BIRTH: Final = "alpha of the cusps of f^2 on the diagonal"
END: Final = "alpha of the cusp of f on the diagonal"
DRAWN: Final = 1.2182  # figure 16
BESIDE: Final = 1e-7  # of alpha: just below and just above a bifurcation
CLOSE: Final = 100 * BESIDE  # of d: orbits this near to the cusp take part
PERIODS: Final = 4
STEPS: Final = 400  # of the orbit of the cusp, in iterates of the power that has the cusp


@dataclass(frozen=True)
class Cusp:
    """A cusp of f^p on the diagonal and what is around it on the side where orbits exist."""

    power: int
    d: float  # at the bifurcation
    beside: float  # on the side
    own: tuple[float, float]  # slopes of f left and right
    slopes: tuple[float, float]  # of f^p
    local: LocalAttractor  # attractor that the slopes alone foretell
    # of f, up to period `PERIODS`, with all points beside the cusp or its images
    orbits: tuple[PeriodicOrbit, ...]
    # of the cusp's orbit under f^p, over that of the farthest of `orbits`; NaN: left the window
    reach: float


@dataclass(frozen=True)
class Facts:
    """The two cusps, and the lists on both sides of the last bifurcation, up to `PERIODS`."""

    first: Cusp
    last: Cusp
    below: OrbitList
    above: OrbitList
    figure: tuple[float, float, float]  # P1, U1 and the cusp at alpha = 1.2182
    numbers: dict[str, Value]


def facts() -> Facts:
    """List orbits around both cusps."""
    numbers = printed.numbers(13, 16)
    birth, end = numbers[BIRTH].computed, numbers[END].computed
    below = periodic_orbits(in_window(end - BESIDE), PERIODS)
    return Facts(
        first=_cusp(birth, birth + BESIDE, 2),
        last=_cusp(end, end - BESIDE, 1),
        below=below,
        above=periodic_orbits(in_window(end + BESIDE), PERIODS),
        figure=_figure(in_window(DRAWN)),
        numbers=numbers,
    )


def _cusp(alpha: float, beside: float, power: int) -> Cusp:
    """Read slopes of f^p at the bifurcation, orbits and the cusp's own orbit beside it."""
    f = in_window(alpha)
    item = cusp_of(f)
    further = float(np.prod(f.evaluate(f.iterate(item.d, power)[1:power]).derivative))
    left, right = item.left_slope * further, item.right_slope * further
    g = in_window(beside)
    c = cusp_of(g).d
    images = g.iterate(c, power)[:power]
    orbits = tuple(o for o in periodic_orbits(g, PERIODS) if _is_near(o, images))
    far = max((float(np.abs(o.points - c).min()) for o in orbits), default=np.nan)
    path = g.power(power).iterate(c, STEPS)
    return Cusp(
        power,
        item.d,
        c,
        (item.left_slope, item.right_slope),
        (left, right),
        attractor_of_skew_tent(left, right, paired_side(left, right)),
        orbits,
        float(np.abs(path - c).max() / far),
    )


def _is_near(orbit: PeriodicOrbit, places: Any) -> bool:
    """Tell whether all points of an orbit lie beside one of a few places."""
    distance = np.abs(orbit.points[:, None] - np.atleast_1d(places))
    return bool((distance.min(axis=1) < CLOSE).all())


def _figure(f: WindowMap) -> tuple[float, float, float]:
    cusp = cusp_of(f).d
    fixed = np.array([o.points[0] for o in periodic_orbits(f)])
    u1 = fixed[fixed < cusp].max()
    p1 = fixed[fixed > cusp].min()
    return float(u1), cusp, float(p1)


def _participants(cusp: Cusp) -> dict[str, PeriodicOrbit]:
    """P1, U1 and B among the orbits beside the cusp of f."""
    named: dict[str, PeriodicOrbit] = {}
    for orbit in cusp.orbits:
        if orbit.period == 1:
            named["P1" if orbit.points[0] > cusp.beside else "U1"] = orbit
        elif orbit.period == 2:
            named["B"] = orbit
    return named


def _p1_ends(facts: Facts) -> Claim:
    named = _participants(facts.last)
    fixed = [o.points[0] for o in facts.above.of_period(1)]
    return claim(
        "law9.p1_ends",
        "section 4, second example",
        "P1 disappears at about 1.21865",
        Finding(
            "P1 exists just below and not just above",
            f"just below at {named['P1'].points[0]:.10f}; fixed points just above: "
            + ", ".join(f"{d:.10f}" for d in fixed)
            if "P1" in named
            else "P1 is not in the list just below",
            "P1" in named and not any(abs(d - facts.last.d) < CLOSE for d in fixed),
        ),
        values=(facts.numbers[END],),
    )


def _together(facts: Facts) -> Claim:
    c = facts.last.d
    named = _participants(facts.last)
    apart = {name: float(np.abs(orbit.points - c).max()) for name, orbit in named.items()}
    left = [o for o in facts.above if _is_near(o, c)]
    lost = Counter(o.period for o in facts.below) - Counter(o.period for o in facts.above)
    listing = ", ".join(f"{n} of period {p}" for p, n in sorted(lost.items()))
    return claim(
        "law9.together",
        "section 4, second example",
        "The unstable P1, U1 and B vanish together, near 1.21865, when the cusp of f meets the "
        "diagonal; there the three coincide",
        Finding(
            "all three are unstable and shrink on to the cusp",
            f"at {BESIDE:.0e} below: "
            + ", ".join(
                f"{name} within {apart[name]:.1e} (multiplier {orbit.multiplier:.4f})"
                for name, orbit in sorted(named.items())
            ),
            set(named) == {"P1", "U1", "B"} and not any(orbit.stable for orbit in named.values()),
        ),
        Finding(
            "none is left above",
            f"orbits up to period {PERIODS} near the cusp just above: {len(left)}",
            not left,
        ),
        values=(facts.numbers[END],),
        note=(
            f"More goes with them: the complete lists lose {listing}, which is all that two full "
            "branches have. Orbits of every period vanish at this point."
        ),
    )


def _figure_16(facts: Facts) -> Claim:
    u1, cusp, p1 = facts.figure
    return claim(
        "law9.before_the_end",
        "figure 16",
        "At alpha = 1.2182, slightly below the bifurcation, the cusp is still above the diagonal",
        Finding(
            "U1, the cusp and P1 lie in this order, close together",
            f"{u1:.8f}, {cusp:.8f}, {p1:.8f}",
            u1 < cusp < p1 and p1 - u1 < 1e-3,
        ),
    )


def _finite_slopes(facts: Facts) -> Claim:
    pairs = [cusp.slopes for cusp in (facts.first, facts.last)]
    listing = "; ".join(f"{left:.6f} and {right:.6f}" for left, right in pairs)
    return claim(
        "law9.finite_slopes",
        "section 4, second example",
        "At both bifurcations the slope is set-valued with a finite difference, and the set meets "
        "the unit circle",
        Finding(
            "the one-sided slopes of f^2 at the first and of f at the second are finite and differ",
            listing,
            all(np.isfinite(pair).all() and abs(pair[0] - pair[1]) > 0.1 for pair in pairs),
        ),
        Finding(
            "1 or -1 lies between them",
            listing,
            all(min(pair) < 1.0 < max(pair) or min(pair) < -1.0 < max(pair) for pair in pairs),
        ),
    )


def _outcomes(facts: Facts) -> Claim:
    first, last = facts.first, facts.last
    stable = [o for cusp in (first, last) for o in cusp.orbits if o.stable]
    counts = [
        ", ".join(
            f"{n} of period {p}" for p, n in sorted(Counter(o.period for o in c.orbits).items())
        )
        for c in (first, last)
    ]
    return claim(
        "law9.outcomes",
        "section 4, second example",
        "At the first a chaotic attractor is created together with an unknown number of unstable "
        "orbits, at the second, for falling alpha, only unstable orbits",
        Finding(
            "all orbits born are unstable",
            f"first: {counts[0]}; second: {counts[1]}, both up to period {PERIODS}; "
            f"stable: {len(stable)}",
            not stable and bool(first.orbits) and bool(last.orbits),
        ),
        Finding(
            "the first keeps the cusp's own orbit beside it, the second does not",
            f"{STEPS} iterates reach {_reach(first)} and {_reach(last)}",
            first.reach < 10.0 and not last.reach < 10.0,
        ),
    )


def _reach(cusp: Cusp) -> str:
    if np.isnan(cusp.reach):
        return "beyond the window"
    return f"{cusp.reach:.2f} times as far as the orbits born"


def _local_shape(facts: Facts) -> Claim:
    first, last = facts.first, facts.last
    seen = [cusp.reach < 10.0 for cusp in (first, last)]
    observed = (
        f"observed: {'chaos' if seen[0] else 'none'} and {'chaos' if seen[1] else 'no attractor'}"
    )
    alone = attractor_of_skew_tent(*first.own, paired_side(*first.own))
    return claim(
        "law9.local_shape",
        "section 4, second example",
        "The different outcome cannot be inferred only from the local shape of the map, the slopes "
        "of the two branches that meet at the cusp; the shape away from the cusp matters, too",
        Finding(
            "the slopes of f beside its cusp do not tell",
            f"first: {_foretold(first.own, alone)}; second: {_foretold(last.own, last.local)}; "
            f"{observed} at the cusp",
            (alone.kind == "chaotic") != seen[0],
        ),
        Finding(
            "at the first, the slopes of f^2 beside its cusp do not tell either",
            f"first: {_foretold(first.slopes, first.local)}; {observed} at the cusp",
            (first.local.kind == "chaotic") != seen[0],
            essential=False,
        ),
        note=(
            "With slopes a > 1 and b < -1 a map of two lines keeps an interval beside its corner "
            "if and only if (a - 1) (|b| - 1) <= 1, and then fills bands in it with chaos; "
            "otherwise orbits leave. At the first bifurcation the cusp of f is not on the "
            "diagonal, that of f^2 is: its slopes hold the slope of f at the cusp's image, away "
            "from the cusp. From them the outcome follows, without any other part of the map."
        ),
    )


def _foretold(slopes: tuple[float, float], local: LocalAttractor) -> str:
    a, b = sorted(slopes, reverse=True)
    measure = (a - 1.0) * (-b - 1.0)
    outcome = {"none": "no attractor", "chaotic": "chaos"}.get(local.kind, str(local))
    return f"slopes {a:.6f}, {b:.6f}, (a - 1) (|b| - 1) = {measure:.6f}: {outcome}"


def _folding(facts: Facts) -> Claim:
    first, last = facts.first, facts.last
    return claim(
        "law9.folding",
        "section 4, second example",
        "At the first the map is folded so that orbits that leave the zone of the cusp are brought "
        "back; at the second there is no folding back",
        Finding(
            "first: the cusp's orbit comes back for ever",
            f"{STEPS} iterates of f^2 reach {_reach(first)}",
            first.reach < 10.0,
        ),
        Finding(
            "second: it goes away",
            f"{STEPS} iterates of f reach {_reach(last)}",
            not last.reach < 10.0,
        ),
        note="The folding back is that of the two branches at the cusp themselves.",
    )


CLAIMS: Final = {
    11: (_p1_ends,),
    16: (_together, _figure_16, _finite_slopes, _outcomes, _local_shape, _folding),
}
