"""The numbers that the paper prints, computed: one function per number or family of numbers.

Each is the root of a scalar condition; the bracket comes from the paper's figure or text.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any, Final

from stickslip import examples
from stickslip.analysis.power import PowerMap
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.paper.galvanetto2001.roots import ACCURACY, cusp, fixed_point, jump, root
from stickslip.paper.values import Value

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator


EXACT: Final = ACCURACY["exact"]
ADAPTIVE: Final = ACCURACY["adaptive"]

WINDOW: Final = (0.379, 0.390)
"""Range of d in which section 4 studies law (9)."""

BRACKETS: Final = {"S1": (-0.06, -0.02), "U1": (0.07, 0.10), "U2": (0.36, 0.38)}
"""Around the fixed points of figure 5."""

S4_POINT: Final = (0.27, 0.2785)
"""Around the point of S4 next to the jump (point 1 of figure 5)."""

JUMP_OF_S4: Final = (0.2785, 0.285)
"""Around that jump, for every V of figure 4."""

INSIDE: Final = 1e-6
"""How far from the cusp slopes are taken: at the last float they may be the other branch's."""


def coulomb_orbits() -> Iterator[Value]:
    """Solve for the fixed points and the period-4 orbit of figure 5, with multipliers."""
    f = EventMap(examples.coulomb())
    for name, bracket in BRACKETS.items():
        found = fixed_point(f, *bracket, noise=EXACT)
        yield Value(f"d of {name}", found.value, found.error, 5, "f(d) = d")
        yield _multiplier(name, f, found.value, 5)
    f4 = PowerMap(f, 4)
    found = fixed_point(f4, *S4_POINT, noise=EXACT)
    for point, d in enumerate(f.iterate(found.value, 3), start=1):
        yield Value(f"d of S4, point {point}", float(d), found.error, 5, "f^4(d) = d")
    yield _multiplier("S4", f4, found.value, 5)


def infinitely_unstable_orbit() -> Iterator[Value]:
    """U4 of section 4: through the jump, where the map takes every value in between."""
    f = EventMap(examples.coulomb())
    left, right = jump(f, *JUMP_OF_S4)
    low, high = sorted((f(left), f(right)))
    f3 = PowerMap(f, 3)
    image = root(lambda y: float(f3(y)) - left, low, high, noise=EXACT)
    points = [left, *f.iterate(image.value, 2)]
    printed = ("0.279", "-0.254", "0.492", "-0.466")
    how = "a jump of f at d, f^3(y) = d for a y inside the jump"
    for number, (d, text) in enumerate(zip(points, printed, strict=True), start=1):
        yield Value(f"d of U4, point {number}", float(d), image.error, 10, how, text)


def collision_of_s4() -> Iterator[Value]:
    """V at which S4 meets the jump of the map: f^4(c-) = c."""

    def gap(V: float) -> float:
        f = EventMap(examples.coulomb(V=V))
        left, _ = jump(f, *JUMP_OF_S4)
        return float(PowerMap(f, 4)(left)) - left

    found = root(gap, 0.0366, 0.0372, noise=EXACT)
    yield Value("V where S4 meets the jump", found.value, found.error, 4, "f^4(c-) = c", "0.03698")


def cusp_of_figure_17() -> Iterator[Value]:
    """Cusp of f for alpha = 1.208."""
    left, _ = cusp(EventMap(examples.law9()), WINDOW)
    how = "f' changes sign between adjacent floats"
    yield Value("d of the cusp, alpha = 1.208", left, 1e-13, 17, how, "0.3815")


def fixed_point_p1() -> Iterator[Value]:
    """P1 for alpha = 1.208, with its multiplier."""
    f = EventMap(examples.law9())
    found = fixed_point(f, *_right_of_cusp(f), noise=ADAPTIVE)
    yield Value("d of P1, alpha = 1.208", found.value, found.error, 12, "f(d) = d")
    yield _multiplier("P1, alpha = 1.208", f, found.value, 12)


def law9_bifurcations() -> Iterator[Value]:
    """Solve for the five values of alpha in section 4, each from a condition on the map."""
    conditions = (
        ("cusps of f^2 on the diagonal", _cusp_of_square, (1.2085, 1.2095), 13, "1.20915"),
        ("flip of P1", _flip, (1.209, 1.2105), 11, "1.2099"),
        ("fold of S1 and U1", _fold, (1.2145, 1.2155), 14, "1.2151"),
        ("collision of the chaotic attractor with U1", _crisis, (1.2152, 1.2155), 15, "1.2153"),
        ("cusp of f on the diagonal", _cusp_on_diagonal, (1.2180, 1.2190), 16, "1.21865"),
    )
    for name, condition, bracket, figure, text in conditions:
        found = root(partial(_over_alpha, condition), *bracket, noise=ADAPTIVE)
        how = (condition.__doc__ or "").rstrip(".")
        note = _NOTES.get(figure, "")
        yield Value(f"alpha of the {name}", found.value, found.error, figure, how, text, note)


_NOTES: Final = {
    13: 'the paper says "approximately" and draws its figure 13 at 1.20915 "just after" the '
    "bifurcation, which fits the computed value",
    16: 'the paper says "close to"; its last digit does not stand',
}


def _over_alpha(condition: Callable[[EventMap], float], alpha: float) -> float:
    return condition(EventMap(examples.law9(alpha=alpha)))


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


def _multiplier(name: str, f: Any, d: float, figure: int) -> Value:
    """Slope of the map at a periodic point; relative error 1e-10 (tested against differences)."""
    slope = float(f.evaluate(d).derivative)
    how = "product of f' over the orbit"
    return Value(f"multiplier of {name}", slope, 1e-10 * max(1.0, abs(slope)), figure, how)


_TABLE: Final[tuple[tuple[frozenset[int], Callable[[], Iterator[Value]]], ...]] = (
    (frozenset({5}), coulomb_orbits),
    (frozenset({10}), infinitely_unstable_orbit),
    (frozenset({4}), collision_of_s4),
    (frozenset({17}), cusp_of_figure_17),
    (frozenset({12}), fixed_point_p1),
    (frozenset({11, 13, 14, 15, 16}), law9_bifurcations),
)


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
    wanted = None if figures is None else set(figures)
    values = [
        value
        for owners, numbers in _TABLE
        if wanted is None or owners & wanted
        for value in numbers()
        if wanted is None or value.figure in wanted
    ]
    return tuple(sorted(values, key=lambda value: value.figure))
