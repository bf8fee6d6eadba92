"""Straight-line kernel text for values, sharp values and truncated Taylor series of a formula.

With ``rows[r, k]`` the k-th Taylor coefficient of the quantity in row r, each nonlinear node obeys
a recurrence (docs/theory/friction-laws.md). The sums of all nodes share one inner loop: terms
0 < j < k need nothing of index k. A product that looks back at c x + d, with constants c and d,
looks at the row of x, and its sum is scaled.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from stickslip.numerics.expression import ELEMENTARY, Graph, Node, reachable

Lines = list[str]

_INFIX = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}


def indented(lines: Iterable[str], depth: int = 1) -> Lines:
    """Indent lines of text by some levels."""
    return ["    " * depth + line for line in lines]


@dataclass
class Scalars:
    """Kernel text of what does not depend on the variable: columns of the array ``p``."""

    # Behind the parameters stands a column for each other constant of the formula made of them.

    graph: Graph
    parameter_columns: Mapping[str, int]
    first_constant: int
    constants: list[int] = field(default_factory=list)

    def text(self, number: int) -> str:
        """Return the text that stands for a node without the variable."""
        node = self.graph.nodes[number]
        if node.op == "constant":
            return repr(node.value) if node.value >= 0 else f"({node.value!r})"
        if node.op == "symbol":
            return f"p[{self.parameter_columns[node.name]}]"
        if number not in self.constants:
            self.constants.append(number)
        return f"p[{self.first_constant + self.constants.index(number)}]"


def value_lines(scalars: Scalars, targets: Mapping[str, int]) -> Lines:
    """Write the assignments that compute nodes from the variable, each to a text: ``out[2]``."""
    graph = scalars.graph
    names = _names(scalars, targets.values(), f"{graph.variable}")
    lines = [
        f"{names[number]} = {value_text(graph.nodes[number], names)}"
        for number in reachable(graph, list(targets.values()))
        if graph.varies[number] and graph.nodes[number].args
    ]
    return lines + [f"{target} = {names[number]}" for target, number in targets.items()]


def _names(scalars: Scalars, outputs: Iterable[int], variable: str) -> dict[int, str]:
    """Text that stands for each node and each operand: a local name, or a scalar."""
    graph = scalars.graph
    names: dict[int, str] = {}
    for number in reachable(graph, list(outputs)):
        if graph.varies[number]:
            names[number] = f"u{number}" if graph.nodes[number].args else variable
            for arg in graph.nodes[number].args:
                if not graph.varies[arg]:
                    names[arg] = scalars.text(arg)
    for number in outputs:
        if not graph.varies[number]:
            names[number] = scalars.text(number)
    return names


def value_text(node: Node, names: Mapping[int, str]) -> str:
    """Write an operation on operands whose text is known."""
    x, y = names[node.args[0]], names[node.args[-1]]
    if node.op in _INFIX:
        return f"{x} {_INFIX[node.op]} {y}"
    if node.op == "negative":
        return f"-{x}"
    if node.op == "reciprocal":
        return f"1.0 / {x}"
    if node.op == "power":
        return f"math.pow({x}, {y})"
    return f"math.{ELEMENTARY[node.op].scalar.__name__}({x})"


@dataclass
class SeriesText:
    """Text that advances the Taylor series of some nodes by one coefficient."""

    # ``start`` computes coefficient 0 and ``advance`` coefficient k >= 1; both expect ``rows``,
    # ``p`` and the local names that they read to exist.

    scalars: Scalars
    outputs: Mapping[int, int]  # row: the node that it shall hold
    known: Mapping[int, int]  # node: the row in which its series is already; the variable is one
    first_row: int  # the first row free for other nodes

    start: Lines = field(init=False)
    advance: Lines = field(init=False)
    rows: dict[int, int] = field(init=False)
    next_row: int = field(init=False)

    def __post_init__(self) -> None:
        """Choose rows, then write the text."""
        graph = self.scalars.graph
        self._partners: dict[int, int] = {}
        self._nodes = self._closure()
        self.rows = dict(self.known)
        self.next_row = self.first_row
        for row, number in self.outputs.items():
            if graph.varies[number]:
                self.rows.setdefault(number, row)
        looked_back_at = [n for n in self._looked_back_at() if n not in self.rows]
        for number in sorted({self._source(number)[0] for number in looked_back_at}):
            self._give_row(number, self.rows)
        self._first_terms: dict[int, int] = {}  # rows of which only index 0 is filled
        for number in looked_back_at:
            self._give_row(number, self._first_terms)
        wanted = [*self._nodes, *self.outputs.values(), *self.known]
        self._names = _names(self.scalars, wanted, f"u_{graph.variable}")
        self.start = self._start()
        self.advance = self._advance()

    @property
    def n_recurrences(self) -> int:
        """Nodes that a coefficient of costs a sum."""
        return sum(map(self._is_nonlinear, self._nodes))

    def _closure(self) -> list[int]:
        """All varying nodes that are to be computed: what outputs need, and partners of it."""
        graph = self.scalars.graph
        wanted = list(self.outputs.values())
        found: set[int] = set()
        while wanted:
            number = wanted.pop()
            if number in found or number in self.known or not graph.varies[number]:
                continue
            found.add(number)
            wanted.extend(graph.nodes[number].args)
            if (partner := self._partner(number)) is not None:
                wanted.append(partner)
        return sorted(found)

    def _partner(self, number: int) -> int | None:
        """Return the node w with u' = w x', or v with u' = x' / v, of an elementary u."""
        graph = self.scalars.graph
        rule = ELEMENTARY.get(graph.nodes[number].op)
        if rule is None:
            return None
        if number not in self._partners:
            builder = rule.factor or rule.divisor
            assert builder is not None
            argument = graph[graph.nodes[number].args[0]]
            self._partners[number] = builder(argument, graph[number]).number
        return self._partners[number]

    def _looked_back_at(self) -> list[int]:
        """Nodes of which a sum needs earlier coefficients, in order."""
        graph = self.scalars.graph
        found: set[int] = set()
        for number in self._nodes:
            if not self._is_nonlinear(number):
                continue
            node = graph.nodes[number]
            found.update(arg for arg in node.args if graph.varies[arg])
            if node.op != "multiply":
                found.add(number)
            if (partner := self._partner(number)) is not None:
                found.add(partner)
        return sorted(found)

    def _give_row(self, number: int, rows: dict[int, int]) -> None:
        if number not in self.rows:
            rows[number] = self.next_row
            self.next_row += 1

    def _source(self, number: int) -> tuple[int, list[str]]:
        """Return the node x of number = c x + d, and what multiplies it to c."""
        graph = self.scalars.graph
        if number in self.rows or number in self.known or self._is_nonlinear(number):
            return number, []
        node = graph.nodes[number]
        varying = [arg for arg in node.args if graph.varies[arg]]
        if len(varying) != 1:
            return number, []
        source, factors = self._source(varying[0])
        constant = next((arg for arg in node.args if not graph.varies[arg]), None)
        match node.op:
            case "negative":
                return source, [*factors, "* -1.0"]
            case "subtract" if node.args[1] == varying[0]:
                return source, [*factors, "* -1.0"]
            case "multiply" if constant is not None:
                return source, [*factors, f"* {self.scalars.text(constant)}"]
            case "divide" if constant is not None:
                return source, [*factors, f"/ {self.scalars.text(constant)}"]
        return source, factors

    def _is_nonlinear(self, number: int) -> bool:
        graph = self.scalars.graph
        node = graph.nodes[number]
        if node.op in ("add", "subtract", "negative"):
            return False
        if node.op == "multiply":
            return all(graph.varies[arg] for arg in node.args)
        if node.op == "divide":
            return graph.varies[node.args[1]]
        return True

    def _loads(self, index: str) -> Lines:
        """Read what is known already and used by the nodes to come."""
        graph = self.scalars.graph
        used = {arg for number in self._nodes for arg in graph.nodes[number].args}
        used.update(self.outputs.values())
        return [
            f"{self._names[number]} = rows[{row}, {index}]"
            for number, row in self.known.items()
            if number in used
        ]

    def _stores(self, index: str, constant_part: bool) -> Lines:
        """Write the outputs that are not computed in their own row: copies and constants."""
        graph = self.scalars.graph
        lines = []
        for row, number in self.outputs.items():
            if not graph.varies[number]:
                value = self._names[number] if constant_part else "0.0"
                lines.append(f"rows[{row}, {index}] = {value}")
            elif self.rows[number] != row:
                lines.append(f"rows[{row}, {index}] = {self._names[number]}")
        return lines

    def _assign(self, number: int, index: str, text: str) -> Lines:
        lines = [f"{self._names[number]} = {text}"]
        rows = self.rows | self._first_terms if index == "0" else self.rows
        if number in rows:
            lines.append(f"rows[{rows[number]}, {index}] = {self._names[number]}")
        return lines

    def _start(self) -> Lines:
        lines = self._loads("0")
        for number in self._nodes:
            node = self.scalars.graph.nodes[number]
            lines += self._assign(number, "0", value_text(node, self._names))
        return lines + self._stores("0", constant_part=True)

    def _advance(self) -> Lines:
        terms: Lines = []
        for number in self._nodes:
            nonlinear = self._is_nonlinear(number)
            text = self._nonlinear(number) if nonlinear else self._linear(number)
            terms += self._assign(number, "k", text)
        return [
            *self._sums([number for number in self._nodes if self._is_nonlinear(number)]),
            *self._loads("k"),
            *terms,
            *self._stores("k", constant_part=False),
        ]

    def _sums(self, numbers: Sequence[int]) -> Lines:
        """Sum the terms 0 < j < k of every node, j and k - j together in one pass of the loop.

        From the middle outwards: the newest coefficients come last, so that no sum waits for
        them. Two partial sums need not wait for each other either. (Half the passes and two
        sums: measured an eighth faster for eq. (9) at order 18 than one sum over all j.)
        """
        if not numbers:
            return []
        starts, middles, terms, joins = [], [], [], []
        for number in numbers:
            node = self.scalars.graph.nodes[number]
            square = node.op == "multiply" and node.args[0] == node.args[1]
            starts += [f"a{number} = 0.0", f"b{number} = 0.0"]
            middles.append(f"b{number} = {self._summand(number, 'j', 'j')}")
            terms.append(f"a{number} += {self._summand(number, 'j', 'i')}")
            if not square:
                terms.append(f"b{number} += {self._summand(number, 'i', 'j')}")
            joins.append(f"a{number} = {'2.0 * ' if square else ''}a{number} + b{number}")
            joins += [f"a{number} = a{number} {factor}" for factor in self._factors(number)]
        return [
            *starts,
            "if k % 2 == 0:",
            *indented(["j = k // 2", *middles]),
            "for j in range((k - 1) // 2, 0, -1):",
            *indented(["i = k - j", *terms]),
            *joins,
            *(["share = 1.0 / k"] if any(map(self._is_weighted, numbers)) else []),
        ]

    def _is_weighted(self, number: int) -> bool:
        """Whether the terms of its sum carry weights, and the sum a divisor k."""
        op = self.scalars.graph.nodes[number].op
        return op == "power" or op in ELEMENTARY

    def _row(self, number: int, index: str) -> str:
        """Element of a row; of a multiple of another row that one's, but for index 0."""
        if index == "0" and number in self._first_terms:
            return f"rows[{self._first_terms[number]}, 0]"
        return f"rows[{self.rows[self._source(number)[0]]}, {index}]"

    def _pair(self, number: int) -> tuple[int, int]:
        """Nodes whose coefficients j and k - j the sum of a node multiplies."""
        node = self.scalars.graph.nodes[number]
        x, y = node.args[0], node.args[-1]
        match node.op:
            case "multiply":
                return x, y
            case "reciprocal" | "power":
                return x, number
            case "divide":
                return y, number
        followed = x if ELEMENTARY[node.op].factor is not None else number
        return followed, self._partners[number]

    def _factors(self, number: int) -> list[str]:
        """Return what the sum of a node is to be scaled by."""
        return [factor for node in self._pair(number) for factor in self._source(node)[1]]

    def _summand(self, number: int, j: str, i: str) -> str:
        """Return what 0 < j < k adds to the sum of a node; i stands for k - j."""
        one, other = self._pair(number)
        product = f"{self._row(one, j)} * {self._row(other, i)}"
        node = self.scalars.graph.nodes[number]
        if node.op == "power":
            return f"({self._names[node.args[-1]]} * {j} - {i}) * {product}"
        return f"{j} * {product}" if node.op in ELEMENTARY else product

    def _nonlinear(self, number: int) -> str:
        """Coefficient k of a node, from its sum and the terms that have index k."""
        node = self.scalars.graph.nodes[number]
        x, y = node.args[0], node.args[-1]
        total, x_k, x_0 = f"a{number}", self._names[x], self._row(x, "0")
        match node.op:
            case "multiply" if x == y:
                return f"{total} + 2.0 * {x_0} * {x_k}"
            case "multiply":
                return f"{total} + {x_0} * {self._names[y]} + {x_k} * {self._row(y, '0')}"
            case "reciprocal":
                u_0 = self._row(number, "0")
                source, factors = self._source(x)  # as short a way from x_k as there is
                square = " ".join([f"{u_0} * {u_0}", *factors])
                return f"-{total} * {u_0} - {self._names[source]} * ({square})"
            case "divide":
                last = f"{self._names[y]} * {self._row(number, '0')}"
                return f"({x_k} - {total} - {last}) / {self._row(y, '0')}"
            case "power":
                u_0 = self._row(number, "0")
                return f"({total} * share + {self._names[y]} * {x_k} * {u_0}) / {x_0}"
        partner_0 = self._row(self._partners[number], "0")
        if ELEMENTARY[node.op].factor is not None:
            return f"{total} * share + {x_k} * {partner_0}"
        return f"({x_k} - {total} * share) / {partner_0}"

    def _linear(self, number: int) -> str:
        """Coefficient k >= 1 of a sum, or of a multiple: constants drop out of sums."""
        graph = self.scalars.graph
        node = graph.nodes[number]
        if node.op in ("add", "subtract"):
            x, y = node.args
            if not graph.varies[y]:
                return self._names[x]
            if not graph.varies[x]:
                return self._names[y] if node.op == "add" else f"-{self._names[y]}"
        return value_text(node, self._names)


# Sums of two: sums, products and quotients keep what rounding leaves out (`numerics.rounding`);
# powers and elementary functions follow their arguments' rests, and keep their own rounding.

Pair = tuple[str, str]
EXACT = "0.0"

_PAIRS: dict[str, Callable[..., str]] = {
    "negative": lambda a: f"-{a[0]}, -{a[1]}",
    "add": lambda a, b: f"sum_of_two({a[0]}, {b[0]}, {a[1]} + {b[1]})",
    "subtract": lambda a, b: f"sum_of_two({a[0]}, -{b[0]}, {a[1]} - {b[1]})",
    "multiply": lambda a, b: f"product({', '.join(a + b)})",
    "divide": lambda a, b: f"quotient({', '.join(a + b)})",
    "reciprocal": lambda a: f"quotient(1.0, {EXACT}, {', '.join(a)})",
}


def sharp_lines(graph: Graph, output: int, symbols: Mapping[str, Pair], target: Pair) -> Lines:
    """Write assignments that compute a node as a sum of two; graph gains elementary slopes."""
    names: dict[int, Pair] = {}
    lines: Lines = []
    for number in reachable(graph, [output]):
        node = graph.nodes[number]
        pairs = [names[arg] for arg in node.args]
        if node.op == "constant":
            names[number] = f"({node.value!r})", EXACT
            continue
        if node.op == "symbol":
            names[number] = symbols[node.name]
            continue
        names[number] = name, low = f"v{number}", f"v{number}_low"
        if node.op in _PAIRS:
            lines.append(f"{name}, {low} = {_PAIRS[node.op](*pairs)}")
            continue
        lines.append(f"{name} = {value_text(node, _rounded(names))}")
        slope = _slope(graph, number, names, lines)
        lines.append(f"{low} = {slope} * {pairs[0][1]}")
    return [*lines, f"{target[0]}, {target[1]} = {', '.join(names[output])}"]


def _rounded(names: Mapping[int, Pair]) -> dict[int, str]:
    return {number: high for number, (high, _) in names.items()}


def _slope(graph: Graph, number: int, names: dict[int, Pair], lines: Lines) -> str:
    """Text of the derivative of a function by its first argument, rounded; may add lines."""
    node = graph.nodes[number]
    x = node.args[0]
    if node.op == "power":
        (base, _), (exponent, _) = names[x], names[node.args[1]]
        return f"{exponent} * math.pow({base}, {exponent} - 1.0)"
    rule = ELEMENTARY[node.op]
    build = rule.factor or rule.divisor
    assert build is not None
    partner = build(graph[x], graph[number]).number
    known = _rounded(names)
    for new in reachable(graph, [partner]):
        if new not in known:
            inner = graph.nodes[new]
            if inner.op == "constant":
                known[new] = f"({inner.value!r})"
            else:
                known[new] = f"w{new}"
                lines.append(f"w{new} = {value_text(inner, known)}")
    return known[partner] if rule.factor else f"1.0 / {known[partner]}"
