"""Formulas evaluated in any arithmetic, and differentiated exactly."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from stickslip.numerics.expression import (
    ELEMENTARY,
    Expression,
    Graph,
    elementary,
    is_constant,
    power,
)

ARITHMETIC: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "negative": lambda a: -a,
    "multiply": lambda a, b: a * b,
    "divide": lambda a, b: a / b,
    "reciprocal": lambda a: 1.0 / a,
    "power": lambda a, b: a**b,
}


def reachable(graph: Graph, outputs: Sequence[int]) -> list[int]:
    """Return the numbers of all nodes that `outputs` are made of, operands first."""
    found: set[int] = set()
    waiting = list(outputs)
    while waiting:
        number = waiting.pop()
        if number not in found:
            found.add(number)
            waiting.extend(graph.nodes[number].args)
    return sorted(found)


def evaluate(
    graph: Graph,
    outputs: Sequence[int],
    values: Mapping[str, Any],
    functions: Mapping[str, Callable[[Any], Any]] | None = None,
) -> list[Any]:
    """Evaluate some nodes, in the arithmetic of whatever numbers are given; numpy's by default."""
    known: dict[int, Any] = {}
    for number in reachable(graph, outputs):
        node = graph.nodes[number]
        arguments = [known[arg] for arg in node.args]
        if node.op == "constant":
            known[number] = node.value
        elif node.op == "symbol":
            known[number] = values[node.name]
        elif node.op in ARITHMETIC:
            known[number] = ARITHMETIC[node.op](*arguments)
        elif functions is not None:
            known[number] = functions[node.op](*arguments)
        else:
            known[number] = ELEMENTARY[node.op].ufunc(*arguments)
    return [known[number] for number in outputs]


def derivative(term: Expression, by: Expression) -> Expression:
    """Differentiate `term` by the symbol `by`, in further nodes of its graph."""
    graph = term.graph
    known: dict[int, Expression] = {}
    for number in reachable(graph, [term.number]):
        known[number] = _node_derivative(graph[number], known, by)
    return known[term.number]


def _node_derivative(u: Expression, known: dict[int, Expression], by: Expression) -> Expression:
    graph, node = u.graph, u.node
    if u.number == by.number:
        return graph.constant(1.0)
    if not node.args:
        return graph.constant(0.0)
    x, dx = graph[node.args[0]], known[node.args[0]]
    y, dy = graph[node.args[-1]], known[node.args[-1]]
    match node.op:
        case "add":
            return dx + dy
        case "subtract":
            return dx - dy
        case "negative":
            return -dx
        case "multiply":
            return dx * y + x * dy
        case "divide":
            return (dx - u * dy) / y
        case "reciprocal":
            return -(u * u) * dx
        case "power":
            result = y * power(x, y - 1.0) * dx
            return result if is_constant(dy, 0.0) else result + u * elementary("log", x) * dy
    rule = ELEMENTARY[node.op]
    if is_constant(dx, 0.0):
        return dx
    if rule.factor is not None:
        return rule.factor(x, u) * dx
    assert rule.divisor is not None
    return dx / rule.divisor(x, u)


def is_analytic(graph: Graph, outputs: Sequence[int], values: Mapping[str, float]) -> bool:
    """Whether no root, logarithm, power or quotient is singular at a point: a sufficient test."""
    numbers = reachable(graph, outputs)
    point = {name: np.float64(value) for name, value in values.items()}
    with np.errstate(all="ignore"):
        known = dict(zip(numbers, evaluate(graph, numbers, point), strict=True))
    for number in numbers:
        node = graph.nodes[number]
        if not graph.varies[number] or not node.args:
            continue
        first, last = known[node.args[0]], known[node.args[-1]]
        regular = {
            "divide": last != 0.0,
            "reciprocal": first != 0.0,
            "power": first > 0.0,
            "sqrt": first > 0.0,
            "log": first > 0.0,
            "log1p": first > -1.0,
        }.get(node.op, True)
        if not (regular and math.isfinite(known[number])):
            return False
    return True
