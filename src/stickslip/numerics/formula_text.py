"""Formulas as text, read by a grammar of our own onto graphs: nothing runs as Python.

sum     = product (("+" | "-") product)*
product = signed (("*" | "/") signed)*
signed  = ("+" | "-") signed | power
power   = atom ("**" signed)?
atom    = number | name | function "(" sum ")" | "(" sum ")"

Numbers are written as in Python and TOML: underscores, and 0x, 0o and 0b, included.
"""

from __future__ import annotations

import inspect
import math
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from functools import lru_cache, partial
from typing import Any, Final

from stickslip.checks import shown
from stickslip.numerics.expression import (
    ELEMENTARY,
    Expression,
    Graph,
    NotTraceable,
    as_expression,
    derivative,
    elementary,
    evaluate,
)
from stickslip.vocabulary import did_you_mean

MOST_CHARACTERS: Final = 1000
MOST_NESTED: Final = 50
MOST_PARAMETERS: Final = 20
MOST_OPERATIONS: Final = 300  # powers written out count: compiling takes some 0.15 s for each
LARGEST_EXPONENT: Final = 100
MOST_EXPONENT_DIGITS: Final = 4  # with the sign, of a number taken exactly
SPEED: Final = "s"  # the variable of friction laws, which is not negative: its modulus is itself
DIGITS: Final = r"\d+(?:_\d+)*"
TOKEN: Final = re.compile(
    r"\s*(?:(?P<whole>0[xX](?:_?[\da-fA-F])+|0[oO](?:_?[0-7])+|0[bB](?:_?[01])+)"
    rf"|(?P<number>(?:{DIGITS}\.?(?:{DIGITS})?|\.{DIGITS})(?:[eE][+-]?{DIGITS})?)"
    r"|(?P<name>[A-Za-z_]\w*)|(?P<sign>\*\*|[-+*/()])|(?P<end>$)|(?P<strange>.))",
    re.ASCII | re.DOTALL,
)
Value = float | Expression
"""What a part of a formula is while it is read: constants stay numbers, as in Python."""


def _power(base: Any, exponent: Any) -> Any:
    is_number = isinstance(base, float) and isinstance(exponent, float)
    return math.pow(base, exponent) if is_number else base**exponent


def _function(name: str, x: Value) -> Value:
    return elementary(name, x) if isinstance(x, Expression) else ELEMENTARY[name].scalar(x)


OPERATIONS: Final[dict[str, Callable[[Any, Any], Any]]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": _power,
}
KNOWN: Final[dict[str, Callable[[Any], Any]]] = {
    **{name: partial(_function, name) for name in ELEMENTARY},
    "abs": abs,
}
FUNCTIONS: Final = KNOWN | {entry.ufunc.__name__: KNOWN[n] for n, entry in ELEMENTARY.items()}
"""By all their names: numpy writes arctan."""
OPERAND: Final = "a number, a name or ("
PRODUCT: Final = "; products are written *"
HINTS: Final = {
    "^": "; powers are written **",
    "%": "; a formula has no jumps: write one for either side",
    ".": "; functions stand alone: exp(...), not np.exp(...)",
    ",": "; functions take one argument",
    "=": "; values follow a comma",
    "name": f"{PRODUCT}, values follow a comma",
    **dict.fromkeys(("number", "whole", "("), PRODUCT),
}
"""What is told of a token, or of a kind of token, that stands in place of an operator."""


@dataclass(frozen=True)
class FormulaText:
    """A formula in a variable and parameters; called, it computes in its arguments' arithmetic.

    ValueError says what cannot be read, and where.
    """

    text: str
    variable: str = SPEED
    _graph: Graph = field(init=False, compare=False, repr=False)
    _output: int = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Read the text once."""
        parser = _Parser(self.text, Graph(self.variable), {})
        object.__setattr__(self, "_output", parser.whole().number)
        object.__setattr__(self, "_graph", parser.graph)

    def __call__(self, s: Any, /, **values: Any) -> Any:
        """Compute it; of expressions, in their graph what a function would leave there."""
        given = {self.variable: s, **values}
        if isinstance(s, Expression):
            return _Parser(self.text, s.graph, given).whole()
        return evaluate(self._graph, [self._output], given)[0]

    def slope(self, by: str, s: Any, /, **values: Any) -> Any:
        """Compute the derivative by the variable or a parameter."""
        graph, output = _slope(self, by)
        return evaluate(graph, [output], {self.variable: s, **values})[0]

    def exactly(
        self,
        number: Callable[[Fraction], Any],
        functions: Mapping[str, Callable[[Any], Any]],
        s: Any,
        /,
        **values: Any,
    ) -> Any:
        """Compute it with the numbers as they are written, none of them rounded to a double."""
        graph, output, numbers = _exact(self)
        written = {text: number(value) for text, value in numbers.items()}
        return evaluate(graph, [output], {self.variable: s, **written, **values}, functions)[0]

    @property
    def varies(self) -> bool:
        """Whether it depends on its variable."""
        return self._graph.varies[self._output]

    @property
    def __name__(self) -> str:
        return self.text

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters, in the order of their first appearance."""
        symbols = (node.name for node in self._graph.nodes if node.op == "symbol")
        return tuple(name for name in symbols if name != self._graph.variable)

    @property
    def __signature__(self) -> inspect.Signature:
        speed = inspect.Parameter(self.variable, inspect.Parameter.POSITIONAL_ONLY)
        others = (inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in self.names)
        return inspect.Signature([speed, *others])


@lru_cache(maxsize=1000)
def _slope(formula: FormulaText, by: str) -> tuple[Graph, int]:
    """Return a graph with the derivative of a formula in it."""
    graph = Graph(formula.variable)
    term = _Parser(formula.text, graph, {}).whole()
    return graph, derivative(term, graph.symbol(by)).number


@lru_cache(maxsize=1000)
def _exact(formula: FormulaText) -> tuple[Graph, int, dict[str, Fraction]]:
    """Return the graph of a formula with symbols for its numbers, and these numbers."""
    parser = _Parser(formula.text, Graph(formula.variable), {}, exact=True)
    return parser.graph, parser.whole().number, parser.numbers


class _Parser:
    """Descends through the grammar; `depth` bounds how far; `exact` numbers become symbols."""

    def __init__(
        self, text: str, graph: Graph, given: Mapping[str, Value], *, exact: bool = False
    ) -> None:
        self.text, self.graph, self.given = text, graph, given
        self.exact, self.numbers = exact, dict[str, Fraction]()
        self.depth, self.place, self.names = 0, 0, {graph.variable}
        self.most_nodes = len(graph.nodes) + MOST_OPERATIONS
        if len(text) > MOST_CHARACTERS:
            raise self.wrong(f"has {len(text)} characters: at most {MOST_CHARACTERS} are read")
        self.advance()

    def advance(self) -> None:
        """Read the next token, its kind and its place."""
        match = TOKEN.match(self.text, self.place)
        assert match is not None  # what is no token is "strange"
        self.kind = str(match.lastgroup)
        self.token, self.start, self.place = match[self.kind], match.start(self.kind), match.end()

    def wrong(self, what: str, start: int | None = None, reason: str = "") -> ValueError:
        place = "" if start is None else f" at character {start + 1}"
        return ValueError(f"the formula {shown(self.text)} {what}{place}{reason}")

    def unexpected(self, expected: str) -> ValueError:
        where = f"where {expected} is expected"
        if self.kind == "end":
            return self.wrong(f"ends {where}")
        hint = HINTS.get(self.token, HINTS.get(self.kind, "")) if expected != OPERAND else ""
        return self.wrong(f"has {shown(self.token)}", self.start, f", {where}{hint}")

    def taken(self, *tokens: str) -> str:
        """Go past one of these tokens, or return ''."""
        token = self.token
        if token not in tokens:
            return ""
        self.advance()
        return token

    def made(self, start: int, operation: Callable[..., Value], *terms: Any) -> Value:
        """Carry out an operation that is written at `start`."""
        try:
            result = operation(*terms)
            if isinstance(result, float) and not math.isfinite(result):
                raise NotTraceable(f"the constant {result} is not finite")
        except (NotTraceable, ArithmeticError, ValueError) as reason:
            raise self.wrong("fails", start, f": {reason}") from None
        if len(self.graph.nodes) > self.most_nodes:
            raise self.wrong(f"takes more than {MOST_OPERATIONS} operations", start)
        return result

    def whole(self) -> Expression:
        result = self.sum()
        if self.kind != "end":
            raise self.unexpected("an operator or the end")
        return as_expression(self.graph, result)

    def chain(self, signs: tuple[str, ...], operand: Callable[[], Value]) -> Value:
        """Read operands between signs, from left to right."""
        term, start = operand(), self.start
        while sign := self.taken(*signs):
            term = self.made(start, OPERATIONS[sign], term, operand())
            start = self.start
        return term

    def sum(self) -> Value:
        return self.chain(("+", "-"), self.product)

    def product(self) -> Value:
        return self.chain(("*", "/"), self.signed)

    def signed(self) -> Value:
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise self.wrong(f"is nested more than {MOST_NESTED} deep", self.start)
        if sign := self.taken("+", "-"):
            term = self.signed()
            term = -term if sign == "-" else term
        else:
            term = self.power()
        self.depth -= 1
        return term

    def power(self) -> Value:
        base, start = self.atom(), self.start
        if not self.taken("**"):
            return base
        exponent = self.signed()
        constant = exponent.node.value if isinstance(exponent, Expression) else exponent
        if abs(constant) > LARGEST_EXPONENT:
            reason = f": {constant:g}, at most {LARGEST_EXPONENT} is allowed"
            raise self.wrong("has a large exponent", start, reason)
        return self.made(start, OPERATIONS["**"], base, exponent)

    def atom(self) -> Value:
        token, kind, start = self.token, self.kind, self.start
        if self.taken("("):
            return self.closed()
        if kind not in ("number", "whole", "name"):
            raise self.unexpected(OPERAND)
        self.advance()
        if kind == "name":
            return self.named(token, start)
        if self.exact:  # by its text, which no name begins like
            if len(token.lower().partition("e")[2]) > MOST_EXPONENT_DIGITS and kind == "number":
                raise self.wrong("has a number too long to be exact", start)
            self.numbers[token] = Fraction(token if kind == "number" else int(token, base=0))
            return self.graph.symbol(token)
        return self.made(start, float, token if kind == "number" else int(token, base=0))

    def named(self, name: str, start: int) -> Value:
        if self.taken("("):
            if name not in FUNCTIONS:
                known = f", which is no function. {did_you_mean(name, KNOWN)}"
                raise self.wrong(f"calls {shown(name)}", start, f"{known} Products are written *.")
            if name == "abs" and self.graph.variable != SPEED:
                sides = ": name the breakpoint and write a formula for either side"
                raise self.wrong(f"calls {name}, which is not smooth", start, sides)
            return self.made(start, FUNCTIONS[name], self.closed())
        if name in FUNCTIONS:
            raise self.wrong(f"names {name} without an argument", start, f": write {name}(...)")
        if name in ("inf", "nan"):
            raise self.wrong(f"has {name}", start, ": its numbers are finite")
        self.names.add(name)
        if len(self.names) > 1 + MOST_PARAMETERS:
            raise self.wrong(f"has more than {MOST_PARAMETERS} parameters", start)
        return self.given[name] if name in self.given else self.graph.symbol(name)

    def closed(self) -> Value:
        result = self.sum()
        if not self.taken(")"):
            raise self.unexpected(")")
        return result
