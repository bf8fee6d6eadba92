"""Maps of an interval by formulas: the text is read anew, and computed with power series."""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from itertools import pairwise
from math import inf
from typing import Any, Final, NamedTuple

from flint import arb, arb_series

from stickslip.proofs.verify.words import Formulas, Refused, ball, enclosed

DEEPEST: Final = 60
LONGEST_EXPONENT: Final = 4  # with its sign, of a number
DIGITS: Final = "[0-9]+(?:_[0-9]+)*"
TOKEN: Final = re.compile(
    r" *(?:(0[xX](?:_?[0-9a-fA-F])+|0[oO](?:_?[0-7])+|0[bB](?:_?[01])+"
    rf"|(?:{DIGITS}\.?(?:{DIGITS})?|\.{DIGITS})(?:[eE][-+]?{DIGITS})?)"
    r"|([A-Za-z_][A-Za-z0-9_]*)|(\*\*|[-+*/()])|$)"
)


class _Node(NamedTuple):
    """An operation on parts: their places in the list of all; or a number, or a name."""

    operation: str
    parts: tuple[int, ...] = ()
    value: Any = None


class _Reader:
    """Reads a text into a list of operations, parts before what they are parts of."""

    def __init__(self, text: str) -> None:
        self.text, self.place, self.depth = text, 0, 0
        self.nodes: list[_Node] = []
        self.next()
        self.sum()
        if self.token:
            raise self.strange()

    def next(self) -> None:
        match = TOKEN.match(self.text, self.place)
        if match is None:
            raise self.strange()
        self.number, self.name, self.sign = match.groups()
        self.token, self.place = match[0].strip(), match.end()

    def strange(self) -> Refused:
        return Refused(f"cannot be read near character {self.place}: the formula {self.text!r}")

    def add(self, operation: str, *parts: int, value: Any = None) -> int:
        self.nodes.append(_Node(operation, parts, value))
        return len(self.nodes) - 1

    def among(self, *signs: str) -> str:
        sign: str = self.sign or ""
        if sign in signs:
            self.next()
            return sign
        return ""

    def sum(self) -> int:
        term = self.product()
        while sign := self.among("+", "-"):
            term = self.add(sign, term, self.product())
        return term

    def product(self) -> int:
        term = self.factor()
        while sign := self.among("*", "/"):
            term = self.add(sign, term, self.factor())
        return term

    def factor(self) -> int:
        self.depth += 1
        if self.depth > DEEPEST:
            raise Refused(f"nested too deep: the formula {self.text!r}")
        if sign := self.among("+", "-"):
            term = self.factor()
            term = self.add("negative", term) if sign == "-" else term
        else:
            term = self.atom()
            if self.among("**"):
                term = self.add("**", term, self.factor())
        self.depth -= 1
        return term

    def atom(self) -> int:
        if self.among("("):
            return self.closed()
        number, name = self.number, self.name
        if not number and not name:
            raise self.strange()
        self.next()
        if number:
            return self.add("number", value=_number(number))
        if not self.among("("):
            return self.add("name", value=name)
        if name not in FUNCTIONS:
            raise Refused(f"{name} is no function")
        return self.add(name, self.closed())

    def closed(self) -> int:
        term = self.sum()
        if not self.among(")"):
            raise self.strange()
        return term


def _number(text: str) -> Fraction:
    """Read a number exactly."""
    if text[:2].lower() not in ("0x", "0o", "0b"):
        if len(text.lower().partition("e")[2]) > LONGEST_EXPONENT:
            raise Refused(f"the exponent of {text} is too large")
        return Fraction(text.replace("_", ""))
    return Fraction(int(text.replace("_", ""), base=0))


def _computed(nodes: list[_Node], values: Mapping[str, Any]) -> Any:
    """Compute a formula in balls, or in power series where x is one."""
    known: list[Any] = []
    for operation, parts, value in nodes:
        if operation == "number":
            known.append(enclosed(value))
        elif operation == "name":
            known.append(values[value])
        else:
            known.append(OPERATIONS[operation](*(known[part] for part in parts)))
    return known[-1]


def _quotient(a: Any, b: Any) -> Any:
    if _leading(b).contains(0):
        raise Refused("a divisor may be 0")
    return a / b


def _leading(x: Any) -> arb:
    return x[0] if isinstance(x, arb_series) else x


def _power(base: Any, exponent: Any) -> Any:
    whole = exponent.unique_fmpz() if isinstance(exponent, arb) else None
    if whole is not None and exponent.is_exact():
        n, result = abs(int(whole)), base * 0 + 1
        for bit in f"{n:b}":
            result = result * result
            result = result * base if bit == "1" else result
        return result if exponent >= 0 else _quotient(arb(1), result)
    if _leading(base) > 0:
        return (exponent * base.log()).exp()
    # Of an exponent such as 0.1*30, a ball around 3, negative numbers may have powers too.
    fractional = isinstance(exponent, arb) and exponent > 0 and not exponent.contains_integer()
    if isinstance(base, arb) and fractional:
        return _of_nonnegative(base, lambda x: (exponent * x.log()).exp())
    raise Refused("a power of a number that may be negative")


def _root(x: Any) -> Any:
    if _leading(x) > 0:
        return x.sqrt()
    if isinstance(x, arb):
        return _of_nonnegative(x, arb.sqrt)
    raise Refused("a root of a number that may be negative")


def _of_nonnegative(x: arb, increasing: Callable[[arb], arb]) -> arb:
    """Enclose a function that is 0 at 0 and has no value below, on a ball that holds 0."""
    top = x.upper()
    if top < 0:
        raise Refused("a root of a negative number")
    return arb(0).union(increasing(top)) if top > 0 else arb(0)


def _tanh(x: Any) -> Any:
    return 1 - _quotient(arb(2), (2 * x).exp() + 1)


FUNCTIONS: Final[dict[str, Callable[[Any], Any]]] = {
    "exp": lambda x: x.exp(),
    "expm1": lambda x: x.exp() - 1,
    "log": lambda x: x.log(),
    "log1p": lambda x: (1 + x).log(),
    "sqrt": _root,
    "sin": lambda x: x.sin(),
    "cos": lambda x: x.cos(),
    "tan": lambda x: x.tan(),
    "sinh": lambda x: (x.exp() - (-x).exp()) / 2,
    "cosh": lambda x: (x.exp() + (-x).exp()) / 2,
    "tanh": _tanh,
    "atan": lambda x: x.atan(),
    "arctan": lambda x: x.atan(),
    "asinh": lambda x: (x + (x * x + 1).sqrt()).log(),
    "arcsinh": lambda x: (x + (x * x + 1).sqrt()).log(),
}
OPERATIONS: Final[dict[str, Callable[..., Any]]] = {
    "negative": operator.neg,
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": _quotient,
    "**": _power,
    **FUNCTIONS,
}


class FormulaMotion:
    """A map by formulas, stepped like `motion.Motion`; a branch has its number as itinerary."""

    coarse = inf  # possibilities are listed on intervals of any width

    def __init__(self, formulas: Formulas) -> None:
        self.values = {name: ball(text) for name, text in formulas.parameters.items()}
        if "x" in self.values:
            raise Refused("a parameter is named x")
        edges = [_computed(self._read(text), self.values) for text in formulas.breakpoints]
        self.ends = [arb.neg_inf(), *edges, arb.pos_inf()]
        self.domain = tuple(ball(text) for text in formulas.domain)
        if not all(a < b for a, b in pairwise(self.ends)) or not self.domain[0] < self.domain[1]:
            raise Refused("the breakpoints or the ends of the domain are not shown to be in order")
        self.branches = [self._read(text, "x") for text in formulas.branches]

    def _read(self, text: str, *others: str) -> list[_Node]:
        nodes = _Reader(text).nodes
        for node in nodes:
            if node.operation == "name" and node.value not in (*self.values, *others):
                raise Refused(f"{node.value} is not given")
        return nodes

    def inside(self, x: arb) -> bool:
        """Whether a ball is proven to lie in the domain."""
        return bool(self.domain[0] <= x <= self.domain[1])

    def boxes(self, n: int) -> list[arb]:
        """Cut the domain into intervals that overlap."""
        low, high = self.domain
        cuts = [low + (high - low) * k / n for k in range(n + 1)]
        return [a.union(b) for a, b in pairwise(cuts)]

    def outcomes(self, x: arb) -> Iterator[tuple[str, arb, None]]:
        """Yield branch and next x: all that is possible from a ball."""
        for k, (left, right) in enumerate(pairwise(self.ends)):
            low, high = x.lower(), x.upper()
            for end in (left, self.domain[0]):
                low = end if end > low else low
            for end in (right, self.domain[1]):
                high = end if end < high else high
            if not low > high:
                yield str(k), self._value(k, low.union(high)), None

    def step(self, x: arb) -> tuple[str, arb, arb]:
        """Return the one outcome from a ball; the value by the mean value theorem."""
        if not self.inside(x):
            raise Refused(f"x = {x.str(12)} may be outside of the domain")
        for k, (left, right) in enumerate(pairwise(self.ends)):
            if left <= x < right:
                value, slope = self._series(k, x)
                if x.rad() > 0:
                    middle = self._value(k, x.mid())
                    value = value.intersection(middle + slope * (x - x.mid()))
                return str(k), value, slope
        raise Refused(f"x = {x.str(12)} may be a breakpoint")

    def _series(self, k: int, x: arb) -> tuple[arb, arb]:
        found = _computed(self.branches[k], {**self.values, "x": arb_series([x, 1])})
        found = found if isinstance(found, arb_series) else arb_series([found])
        value, slope = found[0], found[1]
        if not (value.is_finite() and slope.is_finite()):
            raise Refused(f"branch {k} or its slope has no value at x = {x.str(12)}")
        return value, slope

    def _value(self, k: int, x: arb) -> arb:
        value = _computed(self.branches[k], {**self.values, "x": x})
        if not value.is_finite():
            raise Refused(f"branch {k} has no value at x = {x.str(12)}")
        return value
