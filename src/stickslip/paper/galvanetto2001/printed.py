"""The numbers that the paper prints, computed: one function per number or family of numbers.

Each is the root of a scalar condition; the bracket comes from the paper's figure or text.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.paper.galvanetto2001.orbits import (
    WINDOW,
    Window,
    coulomb_orbits,
    cusp_of,
    fixed_points,
    from_point_1,
    jump_of_s4,
    u4,
)
from stickslip.paper.galvanetto2001.roots import ACCURACY, cusp, fixed_point, jump, root
from stickslip.paper.values import Value
from stickslip.study.event_map import EventMap, event_map

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from stickslip.analysis.orbits import PeriodicOrbit

EXACT: Final = ACCURACY["exact"]
ADAPTIVE: Final = ACCURACY["adaptive"]

AT_CUSP: Final = 10 * ADAPTIVE
"""Error of f(c): that of the cusp's place, times the steeper slope beside it (about 7)."""

SLOPE: Final = 1e-10
"""Error of a multiplier of law (9), relative to max(1, abs(multiplier)); Coulomb's is smaller."""

JUMP_OF_S4: Final = (0.2785, 0.285)
"""Around the jump that S4 meets, for every V of figure 4."""

INSIDE: Final = 1e-6
"""How far from the cusp slopes are taken: at the last float they may be the other branch's."""


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


def collision_of_s4() -> Iterator[Value]:
    """V at which S4 meets the jump of the map: f^4(c-) = c."""

    def gap(V: float) -> float:
        f = event_map(examples.coulomb(V=V))
        left, _ = jump(f, *JUMP_OF_S4)
        return float(f.power(4)(left)) - left

    found = root(gap, 0.0366, 0.0372, noise=EXACT)
    yield Value("V where S4 meets the jump", found.value, found.error, 4, "f^4(c-) = c", "0.03698")


def cusp_of_figure_17() -> Iterator[Value]:
    """Cusp of f for alpha = 1.208."""
    left = cusp_of(Window(event_map(examples.law9())))
    how = "f' changes sign between adjacent floats"
    yield Value("d of the cusp, alpha = 1.208", left, 1e-13, 17, how, "0.3815")


def fixed_point_p1() -> Iterator[Value]:
    """P1 for alpha = 1.208, with its multiplier."""
    p1 = fixed_points(Window(event_map(examples.law9())))[-1]
    d, error = float(p1.points[0]), _error(p1, ADAPTIVE)
    yield Value("d of P1, alpha = 1.208", d, error, 12, "f(d) = d")
    yield _multiplier("P1, alpha = 1.208", p1, 12)


def _over_alpha(condition: Callable[[EventMap], float], alpha: float) -> float:
    return condition(event_map(examples.law9(alpha=alpha)))


def _cusp_of_square(f: EventMap) -> float:
    """f(f(c)) = c, c the cusp of f."""
    left, _ = cusp(f, WINDOW)
    return float(f(f(left)) - left)


def _cusp_on_diagonal(f: EventMap) -> float:
    """f(c) = c, c the cusp of f."""
    left, _ = cusp(f, WINDOW)
    return float(f(left) - left)


def _flip(f: EventMap) -> float:
    """f'(P1) = -1."""
    p1 = fixed_point(f, *_right_of_cusp(f), noise=ADAPTIVE)
    return float(f.derivative(p1.value)) + 1.0


def _fold(f: EventMap) -> float:
    """f(d) = d where f' = 1, left of the cusp."""
    d = _unit_slope(f)
    return float(f(d) - d)


def _crisis(f: EventMap) -> float:
    """f(f(c)) = U1, c the cusp of f."""
    left, _ = cusp(f, WINDOW)
    u1 = fixed_point(f, _unit_slope(f), left, noise=ADAPTIVE)
    return float(f(f(left)) - u1.value)


def _unit_slope(f: EventMap) -> float:
    """Point of the lobe left of the cusp at which f' = 1: there f(d) - d is smallest."""
    left, _ = cusp(f, WINDOW)
    end = left - INSIDE
    return root(lambda d: float(f.derivative(d)) - 1.0, WINDOW[0], end, noise=ADAPTIVE).value


def _right_of_cusp(f: EventMap) -> tuple[float, float]:
    _, right = cusp(f, WINDOW)
    return right, WINDOW[1]


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
class _Bifurcation:
    """A value of alpha that the paper prints: where a condition on the map changes its sign."""

    name: str
    condition: Callable[[EventMap], float]
    bracket: tuple[float, float]
    printed: str
    noise: float
    note: str = ""

    def value(self, figure: int) -> Value:
        found = root(partial(_over_alpha, self.condition), *self.bracket, noise=self.noise)
        how = (self.condition.__doc__ or "").rstrip(".")
        name = f"alpha of the {self.name}"
        return Value(name, found.value, found.error, figure, how, self.printed, self.note)


_OVER_ALPHA: Final = {
    11: _Bifurcation("flip of P1", _flip, (1.209, 1.2105), "1.2099", SLOPE),
    13: _Bifurcation(
        "cusps of f^2 on the diagonal",
        _cusp_of_square,
        (1.2085, 1.2095),
        "1.20915",
        AT_CUSP,
        'the paper says "approximately" and draws its figure 13 at 1.20915 "just after" the '
        "bifurcation, which fits the computed value",
    ),
    14: _Bifurcation("fold of S1 and U1", _fold, (1.2145, 1.2155), "1.2151", ADAPTIVE),
    15: _Bifurcation(
        "collision of the chaotic attractor with U1", _crisis, (1.2152, 1.2155), "1.2153", AT_CUSP
    ),
    16: _Bifurcation(
        "cusp of f on the diagonal",
        _cusp_on_diagonal,
        (1.2180, 1.2190),
        "1.21865",
        AT_CUSP,
        'the paper says "close to"; its last digit does not stand',
    ),
}

_OTHERS: Final[dict[int, Callable[[], Iterator[Value]]]] = {
    4: collision_of_s4,
    5: orbits_of_figure_5,
    10: infinitely_unstable_orbit,
    12: fixed_point_p1,
    17: cusp_of_figure_17,
}


def compute(figures: Iterable[int] | None = None) -> tuple[Value, ...]:
    """Compute the numbers that belong to some figures.

    Parameters
    ----------
    figures : iterable of int, optional
        By default every number, also of figures that cannot be drawn yet.

    Returns
    -------
    tuple of Value
        Ordered by figure.
    """
    numbered = {*_OVER_ALPHA, *_OTHERS}
    wanted = numbered if figures is None else numbered & set(figures)
    return tuple(value for figure in sorted(wanted) for value in _of_figure(figure))


def numbers(*figures: int) -> dict[str, Value]:
    """Compute the numbers that belong to some figures.

    Parameters
    ----------
    *figures : int
        Figures to which they belong.

    Returns
    -------
    dict of str to Value
        By name.
    """
    return {value.name: value for value in compute(figures)}


@lru_cache(maxsize=len(_OVER_ALPHA) + len(_OTHERS))  # claims and table ask for the same
def _of_figure(figure: int) -> tuple[Value, ...]:
    if figure in _OVER_ALPHA:
        return (_OVER_ALPHA[figure].value(figure),)
    return tuple(_OTHERS[figure]())
