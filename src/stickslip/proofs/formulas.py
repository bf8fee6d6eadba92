"""Maps of the line by formulas, on a box: every branch that it may meet, and the values there.

Docs: proofs, maps of one's own.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from math import inf
from typing import TYPE_CHECKING, Any, Final

from flint import arb

from stickslip.analysis.maps.formulas import VARIABLE, Formulas
from stickslip.checks import instance, shown
from stickslip.numerics.formula_text import FormulaText
from stickslip.proofs.flow import Piece
from stickslip.proofs.germ import like
from stickslip.proofs.jet import HALF, Jet, Number, power
from stickslip.proofs.system import Exact, decimal, fraction, number
from stickslip.proofs.wave import Undecided

if TYPE_CHECKING:
    from stickslip.analysis.maps.piecewise_map import PiecewiseMap

MARGINS: Final = (Fraction(7, 997), Fraction(11, 983))  # of the domain: see `FormulaMap.boxes`


def formula_map_values(f: PiecewiseMap, exact: Mapping[str, Exact] | None = None) -> dict[str, Any]:
    """Return formulas and exact numbers of a map as a certificate holds them."""
    if not isinstance(f.func, Formulas):
        raise ValueError(
            f"{f!r} cannot be certified: a Python function cannot be computed in ball arithmetic. "
            'Give the branches as formulas, PiecewiseMap(["a - x", "a - x**2"], ..., '
            "breakpoints=[0])."
        )
    if exact is not None:
        instance("exact", exact, Mapping, 'values by name, such as {"a": "1.2"}')
        for name in exact:
            if name not in f.parameters:
                raise ValueError(f"exact names {shown(name)}, which is no parameter of the map")
    given: dict[str, Exact] = {**f.parameters, **(exact or {})}
    return {
        "branches": [branch.text for branch in f.func.branches],
        "breakpoints": [edge.text for edge in f.func.edges.formulas],
        "domain": [decimal(fraction("domain", end)) for end in f.domain],
        "parameters": {name: decimal(fraction(name, value)) for name, value in given.items()},
    }


class FormulaMap:
    """A map of an interval whose branches are formulas; its parameters are exact."""

    coarse = inf  # a branch more costs little
    shares: Sequence[int] = (100, 1000, 10000)

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._branches = [FormulaText(text, VARIABLE) for text in values["branches"]]
        self._edges = [FormulaText(text, VARIABLE) for text in values["breakpoints"]]
        self._ends = [Fraction(end) for end in values["domain"]]
        self._parameters = {name: Fraction(text) for name, text in values["parameters"].items()}

    def boxes(self, n: int) -> list[arb]:
        """Cut the domain; a little more, so that no round number is the end of a box."""
        low, high = self._ends
        left, right = (margin * (high - low) for margin in MARGINS)
        half = (high - low + left + right) / (2 * n)
        start = low - left
        width = number(half).upper()
        return [number(start + (2 * k + 1) * half) + arb(0, width) for k in range(n)]

    def images(
        self, d: Number, parameters: Sequence[Jet], *, forks: int, at_touch: bool
    ) -> list[Piece]:
        """Return the map on a box, a piece for each branch: none if the whole box is outside.

        On a box with a breakpoint or an end of the domain in it only values are told.
        """
        low, high = map(number, self._ends)
        if d.range < low or d.range > high:
            return self._forked([], forks)
        inside = bool(low <= d.range <= high)
        pieces = []
        for k, (left, right) in enumerate(pairwise(self._breakpoints())):
            if d.range < left or d.range >= right:
                continue
            if inside and left <= d.range < right:
                return [Piece(str(k), self._value(k, d), ())]
            part = _between(d.range, (left, low), (right, high))
            if part is not None:
                nothing = tuple(arb.nan() for _ in d.box)
                told = self._value(k, Jet(part, part, nothing, d.box)).range
                pieces.append(Piece(str(k), Jet(arb.nan(), told, nothing, d.box), ()))
        return self._forked(pieces, forks)

    def _forked(self, pieces: list[Piece], forks: int) -> list[Piece]:
        if not forks:
            raise Undecided("the point may lie on a breakpoint, or outside of the domain")
        return pieces

    def _breakpoints(self) -> list[arb]:
        values = [self._computed(edge, arb.nan()) for edge in self._edges]
        ends = [arb.neg_inf(), *values, arb.pos_inf()]
        if not all(a < b for a, b in pairwise(ends)):
            raise Undecided("the breakpoints are not in order")
        return ends

    def _value(self, k: int, x: Jet) -> Jet:
        value = like(x, self._computed(self._branches[k], x))  # a branch may be constant
        if not value.range.is_finite():
            raise Undecided(f"the formula of branch {k} has no value on all of the box")
        return value

    def _computed(self, formula: FormulaText, x: Number) -> Number:
        values = {name: number(value) for name, value in self._parameters.items()}
        return formula.exactly(number, FUNCTIONS, x, **values)


def _between(x: arb, lows: Sequence[arb], highs: Sequence[arb]) -> arb | None:
    """Return the part of a ball above and below some numbers, if there may be one."""
    low, high = x.lower(), x.upper()
    for end in lows:
        low = end if end > low else low
    for end in highs:
        high = end if end < high else high
    return None if low > high else low.union(high)


def _function(
    value: Callable[[arb], arb], slope: Callable[[arb], arb]
) -> Callable[[Number], Number]:
    """Return a function of balls and jets."""

    def function(x: Number) -> Number:
        if isinstance(x, Jet):
            return x.chain(value(x.centre), value(x.range), slope(x.range))
        return value(x)

    return function


def _square(x: arb) -> arb:
    return power(x, arb(2))


FUNCTIONS: Final[dict[str, Callable[[Number], Number]]] = {
    "exp": _function(arb.exp, arb.exp),
    "expm1": _function(arb.expm1, arb.exp),
    "log": _function(arb.log, lambda x: 1 / x),
    "log1p": _function(arb.log1p, lambda x: 1 / (1 + x)),
    "sqrt": _function(lambda x: power(x, HALF), lambda x: HALF / power(x, HALF)),
    "sin": _function(arb.sin, arb.cos),
    "cos": _function(arb.cos, lambda x: -x.sin()),
    "tan": _function(arb.tan, lambda x: 1 + _square(x.tan())),
    "sinh": _function(arb.sinh, arb.cosh),
    "cosh": _function(arb.cosh, arb.sinh),
    "tanh": _function(arb.tanh, lambda x: 1 - _square(x.tanh())),
    "atan": _function(arb.atan, lambda x: 1 / (1 + _square(x))),
    "asinh": _function(arb.asinh, lambda x: 1 / (1 + _square(x)).sqrt()),
}
"""Of the grammar, with their slopes; where one has no value the result is not finite."""
