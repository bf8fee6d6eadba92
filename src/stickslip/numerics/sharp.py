"""Straight-line kernel text for values of a formula as sums of two doubles.

Sums, products and quotients keep what rounding leaves out (`numerics.rounding`); powers and
elementary functions follow what their arguments left out, and keep their own rounding.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from stickslip.numerics.calculus import reachable
from stickslip.numerics.expression import ELEMENTARY, Graph
from stickslip.numerics.series import Lines, value_text

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
