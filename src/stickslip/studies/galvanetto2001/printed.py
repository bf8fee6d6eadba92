"""The numbers that the paper prints, computed: one function per number or family of numbers.

Bifurcations are zeros of conditions on the map (`analysis.bifurcations.conditions`); their
brackets come from the paper's figures or text.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.analysis.bifurcations.conditions.conditions import (
    Collision,
    Condition,
    Connection,
    Flip,
    Fold,
)
from stickslip.analysis.bifurcations.conditions.locate import MapAt, solve
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.studies.claim import Value
from stickslip.studies.galvanetto2001.orbits import (
    coulomb_orbits,
    cusp_of,
    fixed_points,
    from_point_1,
    in_window,
    jump_of_s4,
    u4,
)

EXACT: Final = 1e-14
ADAPTIVE: Final = 1e-13
"""Error of one map value by engine (docs/design.md, section 3), for well-conditioned motions."""

SLOPE: Final = 1e-10
"""Error of a multiplier of law (9), relative to max(1, abs(multiplier)); Coulomb's is smaller."""


def orbits_of_figure_5() -> Iterator[Value]:
    """Orbits of figure 5 with multipliers."""
    f = event_map(examples.coulomb())
    orbits = coulomb_orbits(f)
    for name in ("S1", "U1", "U2"):
        orbit = orbits[name]
        yield Value(f"d of {name}", float(orbit.points[0]), _error(orbit, EXACT), 5, "f(d) = d")
        yield _multiplier(name, orbit, 5)
    s4 = orbits["S4"]
    for point, d in enumerate(from_point_1(s4, jump_of_s4(f).d), start=1):
        yield Value(f"d of S4, point {point}", float(d), _error(s4, EXACT), 5, "f^4(d) = d")
    yield _multiplier("S4", s4, 5)


def infinitely_unstable_orbit() -> Iterator[Value]:
    """U4 of section 4: through the jump, where the map takes every value in between."""
    f = event_map(examples.coulomb())
    orbit, jump_ = u4(f), jump_of_s4(f)
    printed = ("0.279", "-0.254", "0.492", "-0.466")
    how = "a jump of f at d, f^3(y) = d for a y inside the jump"
    note = (
        f"rounded to three digits -0.253; the map's value on the left side of the jump, "
        f"{jump_.left:.5f}, would give -0.254"
    )
    error = _error(orbit, EXACT)
    points = from_point_1(orbit, jump_.d)
    for number, (d, text) in enumerate(zip(points, printed, strict=True), start=1):
        name = f"d of U4, point {number}"
        yield Value(name, float(d), error, 10, how, text, note if number == 2 else "")


def cusp_of_figure_17() -> Iterator[Value]:
    """Cusp of f for alpha = 1.208."""
    cusp = cusp_of(in_window(1.208))
    how = "f' changes sign between adjacent floats"
    yield Value("d of the cusp, alpha = 1.208", cusp.d, ADAPTIVE, 17, how, "0.3815")


def fixed_point_p1() -> Iterator[Value]:
    """P1 for alpha = 1.208, with its multiplier."""
    p1 = fixed_points(in_window(1.208))[-1]
    d, error = float(p1.points[0]), _error(p1, ADAPTIVE)
    yield Value("d of P1, alpha = 1.208", d, error, 12, "f(d) = d")
    yield _multiplier("P1, alpha = 1.208", p1, 12)


def _error(orbit: PeriodicOrbit, noise: float) -> float:
    """Error of an orbit's points from that of a map value, and at least what Newton left."""
    left = float(np.ptp(orbit.interval, axis=1).max()) / 2.0
    pinned = orbit.infinitely_unstable  # by the place of the jump
    return max(left, noise if pinned else noise / abs(1.0 - orbit.multiplier))


def _multiplier(name: str, orbit: PeriodicOrbit, figure: int) -> Value:
    """Slope of the map over an orbit."""
    slope = orbit.multiplier
    how = "product of f' over the orbit"
    return Value(f"multiplier of {name}", slope, SLOPE * max(1.0, abs(slope)), figure, how)


@dataclass(frozen=True)
class Bifurcation:
    """A parameter value that section 4 speaks of: where a condition on the map holds."""

    name: str
    how: str
    # makes the condition near which it is solved, by following it inside the bracket
    start: Callable[[], Condition]
    bracket: tuple[float, float]
    printed: str = ""
    note: str = ""
    family: MapAt = in_window

    def value(self, figure: int) -> Value:
        """Solve for it."""
        found = solve(self.start(), self.family, *self.bracket)
        return Value(self.name, found.value, found.error, figure, self.how, self.printed, self.note)


def _coulomb(V: float) -> EventMap:
    return event_map(examples.coulomb(V=V))


def _s4_at_the_jump() -> Condition:
    return Collision(4, TrackedDiscontinuity.of(jump_of_s4(_coulomb(0.0366))), side=-1)


def _cusp_returns(alpha: float, period: int) -> Condition:
    return Collision(period, TrackedDiscontinuity.of(cusp_of(in_window(alpha))), side=-1)


def _cusp_meets(alpha: float, images: int, which: int) -> Condition:
    """Make the condition that an image of the cusp is on a fixed point, counted from the left."""
    f = in_window(alpha)
    point = fixed_points(f)[which].points
    return Connection(TrackedDiscontinuity.of(cusp_of(f)), -1, images, tuple(point.tolist()))


def _p1_flips() -> Condition:
    return Flip(1, tuple(fixed_points(in_window(1.209))[-1].points.tolist()))


def _lobe_touches() -> Condition:
    s1, u1, _ = fixed_points(in_window(1.2152))
    return Fold(1, (float(s1.points[0] + u1.points[0]) / 2.0,))


_BIFURCATIONS: Final = {
    4: Bifurcation(
        "V where S4 meets the jump",
        "f^4(c-) = c",
        _s4_at_the_jump,
        (0.0366, 0.0372),
        "0.03698",
        family=_coulomb,
    ),
    11: Bifurcation("alpha of the flip of P1", "f'(P1) = -1", _p1_flips, (1.209, 1.2105), "1.2099"),
    13: Bifurcation(
        "alpha of the cusps of f^2 on the diagonal",
        "f(f(c)) = c, c the cusp of f",
        partial(_cusp_returns, 1.2085, 2),
        (1.2085, 1.2095),
        "1.20915",
        'the paper says "approximately" and draws its figure 13 at 1.20915 "just after" the '
        "bifurcation, which fits the computed value",
    ),
    14: Bifurcation(
        "alpha of the fold of S1 and U1",
        "f(d) = d where f' = 1, left of the cusp",
        _lobe_touches,
        (1.2145, 1.2155),
        "1.2151",
    ),
    15: Bifurcation(
        "alpha of the collision of the chaotic attractor with U1",
        "f(f(c)) = U1, c the cusp of f",
        partial(_cusp_meets, 1.2152, 2, 1),
        (1.2152, 1.2155),
        "1.2153",
    ),
    16: Bifurcation(
        "alpha of the cusp of f on the diagonal",
        "f(c) = c, c the cusp of f",
        partial(_cusp_returns, 1.2180, 1),
        (1.2180, 1.2190),
        "1.21865",
        'the paper says "close to"; its last digit does not stand',
    ),
}

BANDS_MERGE: Final = Bifurcation(
    "alpha where the two bands merge",
    "f(f(f(c))) = P1, c the cusp of f",
    partial(_cusp_meets, 1.2120, 3, 0),
    (1.2120, 1.2135),
)
"""Of the chaotic attractor; the paper does not mention it."""

_OTHERS: Final[dict[int, Callable[[], Iterator[Value]]]] = {
    5: orbits_of_figure_5,
    10: infinitely_unstable_orbit,
    12: fixed_point_p1,
    17: cusp_of_figure_17,
}


def compute(figures: Iterable[int] | None = None) -> tuple[Value, ...]:
    """Compute the numbers that belong to some figures, by default every number."""
    numbered = {*_BIFURCATIONS, *_OTHERS}
    wanted = numbered if figures is None else numbered & set(figures)
    return tuple(value for figure in sorted(wanted) for value in _of_figure(figure))


def numbers(*figures: int) -> dict[str, Value]:
    """Compute the numbers that belong to some figures, by name."""
    return {value.name: value for value in compute(figures)}


@lru_cache(maxsize=len(_BIFURCATIONS) + len(_OTHERS))  # claims and table ask for the same
def _of_figure(figure: int) -> tuple[Value, ...]:
    if figure in _BIFURCATIONS:
        return (_BIFURCATIONS[figure].value(figure),)
    return tuple(_OTHERS[figure]())
