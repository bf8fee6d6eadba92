"""Formulas as text, read by a grammar of our own onto graphs: nothing runs as Python.

sum     = product (("+" | "-") product)*
product = signed (("*" | "/") signed)*
signed  = ("+" | "-") signed | power
power   = atom ("**" signed)?
atom    = number | name | function "(" sum ")" | "(" sum ")"
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from stickslip.checks import shown
from stickslip.numerics import expression
from stickslip.numerics.expression import (
    ELEMENTARY,
    Expression,
    Graph,
    NotTraceable,
    elementary,
    evaluate,
)
from stickslip.vocabulary import did_you_mean

MOST_CHARACTERS: Final = 1000
MOST_NESTED: Final = 50
TOKEN: Final = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign>\*\*|[-+*/()])|(?P<end>$)|(?P<strange>.))",
    re.ASCII | re.DOTALL,
)
OPERATIONS: Final[dict[str, Callable[[Expression, Expression], Expression]]] = {
    "+": expression.add,
    "-": expression.subtract,
    "*": expression.multiply,
    "/": expression.divide,
    "**": expression.power,
}


@dataclass(frozen=True)
class FormulaText:
    """A formula in s and named parameters; called, it computes in the arithmetic of its arguments.

    ValueError says what cannot be read, and where.
    """

    text: str
    _graph: Graph = field(init=False, compare=False, repr=False)
    _output: int = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        """Read the text once."""
        parser = _Parser(self.text)
        object.__setattr__(self, "_output", parser.whole().number)
        object.__setattr__(self, "_graph", parser.graph)

    def __call__(self, s: Any, **values: Any) -> Any:
        """Compute it."""
        return evaluate(self._graph, [self._output], {"s": s, **values})[0]

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
        speed = inspect.Parameter("s", inspect.Parameter.POSITIONAL_OR_KEYWORD)
        others = (inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY) for name in self.names)
        return inspect.Signature([speed, *others])


class _Parser:
    """Descends through the grammar; `depth` bounds how far."""

    def __init__(self, text: str) -> None:
        self.text, self.graph, self.depth, self.place = text, Graph("s"), 0, 0
        if len(text) > MOST_CHARACTERS:
            raise self.wrong(f"has {len(text)} characters: at most {MOST_CHARACTERS} are read")
        self.advance()

    def advance(self) -> None:
        """Read the next token, its kind and its place."""
        match = TOKEN.match(self.text, self.place)
        assert match is not None  # what is no token is "strange"
        self.kind = str(match.lastgroup)
        self.token, self.start, self.place = match[self.kind], match.start(self.kind), match.end()

    def wrong(self, what: str) -> ValueError:
        return ValueError(f"the formula {shown(self.text)} {what}")

    def unexpected(self, expected: str) -> ValueError:
        where = f"where {expected} is expected"
        if self.kind == "end":
            return self.wrong(f"ends {where}")
        powers = "; powers are written **" if self.token == "^" else ""
        place = f"at character {self.start + 1}"
        return self.wrong(f"has {shown(self.token)} {place}, {where}{powers}")

    def taken(self, *tokens: str) -> str:
        """Go past one of these tokens, or return ''."""
        token = self.token
        if token not in tokens:
            return ""
        self.advance()
        return token

    def made(self, operation: Callable[..., Expression], *terms: Any) -> Expression:
        try:
            return operation(*terms)
        except (NotTraceable, ArithmeticError, ValueError) as reason:
            raise self.wrong(f"has no value before character {self.start + 1}: {reason}") from None

    def whole(self) -> Expression:
        result = self.sum()
        if self.kind != "end":
            raise self.unexpected("an operator or the end")
        return result

    def sum(self) -> Expression:
        term = self.product()
        while sign := self.taken("+", "-"):
            term = self.made(OPERATIONS[sign], term, self.product())
        return term

    def product(self) -> Expression:
        term = self.signed()
        while sign := self.taken("*", "/"):
            term = self.made(OPERATIONS[sign], term, self.signed())
        return term

    def signed(self) -> Expression:
        self.depth += 1
        if self.depth > MOST_NESTED:
            raise self.wrong(f"is nested more than {MOST_NESTED} deep")
        if sign := self.taken("+", "-"):
            term = self.signed()
            term = -term if sign == "-" else term
        else:
            term = self.power()
        self.depth -= 1
        return term

    def power(self) -> Expression:
        base = self.atom()
        if self.taken("**"):
            return self.made(OPERATIONS["**"], base, self.signed())
        return base

    def atom(self) -> Expression:
        token, kind = self.token, self.kind
        if self.taken("("):
            return self.closed()
        if kind not in ("number", "name"):
            raise self.unexpected("a number, a name or (")
        self.advance()
        return self.named(token) if kind == "name" else self.made(self.graph.constant, float(token))

    def named(self, name: str) -> Expression:
        if self.taken("("):
            if name not in ELEMENTARY:
                known = did_you_mean(name, ELEMENTARY)
                raise self.wrong(f"calls {shown(name)}, which is no function. {known}")
            return self.made(partial(elementary, name), self.closed())
        if name in ELEMENTARY:
            raise self.wrong(f"names {name} without an argument: write {name}(...)")
        return self.graph.symbol(name)

    def closed(self) -> Expression:
        result = self.sum()
        if not self.taken(")"):
            raise self.unexpected(")")
        return result
