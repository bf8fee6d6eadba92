"""Functions of a point of R^n, written with NumPy, recorded as formulas of its coordinates.

What a comparison chooses between is recorded, too: the comparisons tell the smooth pieces apart.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.expression import (
    ELEMENTARY,
    Expression,
    Graph,
    NotTraceable,
    as_expression,
    derivative,
    evaluate,
    grow,
    reachable,
    where,
)
from stickslip.numerics.series import indented, value_text
from stickslip.numerics.tracing import recorded

Floats = NDArray[np.float64]
Arguments = Mapping[str, float]

COORDINATE: Final = "x "  # no name of a parameter begins so
HEADER: Final = '''\
"""A map of R^n generated from its formula; see stickslip.numerics.point_function."""

import math

import numpy as np

from stickslip.numerics.targets import kernel
'''


class PointGraph(Graph):
    """A graph whose variables are coordinates, and that records comparisons."""

    def is_variable(self, name: str) -> bool:
        """Tell whether a symbol is a coordinate."""
        return name.startswith(COORDINATE)


def _less(a: Expression, b: Expression) -> Expression:
    return grow("less", a, b)


def _not(a: Expression) -> Expression:
    return 1.0 - a


def _modulus(a: Expression) -> Expression:
    return where(a < 0.0, -a, a)


def _by_ufunc(ufunc: Any) -> Any:
    return lambda self, other: ufunc(self, other)


class PointExpression(Expression):
    """An expression that may be compared: a comparison is 1 where it is true, else 0."""

    __slots__ = ()
    recorded: ClassVar = Expression.recorded | {
        "less": _less,
        "greater": lambda a, b: _less(b, a),
        "less_equal": lambda a, b: _not(_less(b, a)),
        "greater_equal": lambda a, b: _not(_less(a, b)),
        "logical_and": lambda a, b: a * b,
        "bitwise_and": lambda a, b: a * b,
        "logical_or": lambda a, b: _not(_not(a) * _not(b)),
        "bitwise_or": lambda a, b: _not(_not(a) * _not(b)),
        "logical_not": _not,
        "invert": _not,
        "absolute": _modulus,
        "fabs": _modulus,
        "sign": lambda a: (0.0 < a) - (a < 0.0),
        "minimum": lambda a, b: where(b < a, b, a),
        "maximum": lambda a, b: where(a < b, b, a),
        "floor": partial(grow, "floor"),
        "remainder": lambda a, b: a - b * grow("floor", a / b),
    }

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """Record what numpy's functions do, of arrays element by element."""
        if any(isinstance(value, np.ndarray) for value in inputs):
            return by_element(ufunc, method, inputs, kwargs)
        return super().__array_ufunc__(ufunc, method, *inputs, **kwargs)

    def __array_function__(self, function: Any, _: Any, args: Any, kwargs: Any) -> Any:
        """Record a choice, and let numpy put together arrays."""
        return _array_function(function, args, kwargs)

    def __getitem__(self, key: Any) -> Any:
        """Add axes, as to a single number: ``(x > 0)[..., None]``."""
        return coordinates(np.asarray(self, dtype=object)[key])

    __lt__, __le__, __gt__, __ge__, __and__, __or__, __mod__ = map(
        _by_ufunc,
        (
            *(np.less, np.less_equal, np.greater, np.greater_equal),
            *(np.logical_and, np.logical_or, np.remainder),
        ),
    )
    __invert__, __abs__ = _not, _modulus


PointGraph.kind = PointExpression


class Coordinates(np.ndarray[Any, Any]):
    """An array of expressions: a point, or what is made of one."""

    def __getitem__(self, key: Any) -> Any:
        """Return an expression itself, not an array that holds it."""
        got = super().__getitem__(key)
        return got.item() if isinstance(got, np.ndarray) and got.ndim == 0 else got

    def __setitem__(self, key: Any, value: Any) -> None:
        """Set elements; numpy's own way asks for an array of one."""
        self.view(np.ndarray)[key] = value

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """Record what numpy's functions do, element by element."""
        return by_element(ufunc, method, inputs, kwargs)

    def __array_function__(self, function: Any, _: Any, args: Any, kwargs: Any) -> Any:
        """Record a choice, and let numpy put together arrays."""
        return _array_function(function, args, kwargs)


def coordinates(values: Any) -> Any:
    """Return numbers and expressions as an array of them, and a single one as it is."""
    array = np.asarray(values, dtype=object)
    return array.view(Coordinates) if array.ndim else array.item()


def by_element(
    function: Callable[..., Any], method: str, inputs: Sequence[Any], options: Mapping[str, Any]
) -> Any:
    """Apply a function to each row of elements; sums and products of matrices numpy knows."""
    arrays = [np.asarray(value, dtype=object) for value in inputs]
    if method != "__call__" or function is np.matmul:
        return coordinates(getattr(function, method)(*arrays, **options))
    if options:
        raise NotTraceable(f"{function.__name__} with {', '.join(options)} is not recorded")
    rows = np.broadcast_arrays(*arrays)
    found = np.empty(rows[0].shape, dtype=object)
    found.reshape(-1)[:] = [function(*row) for row in zip(*(a.ravel() for a in rows), strict=True)]
    return coordinates(found)


def _array_function(function: Any, args: Any, kwargs: Any) -> Any:
    if function is np.where and len(args) == 3:
        return by_element(_chosen, "__call__", args, kwargs)
    return function._implementation(*args, **kwargs)


def _chosen(condition: Any, a: Any, b: Any) -> Any:
    if not isinstance(condition, Expression):
        return a if condition else b
    a, b = (as_expression(condition.graph, value) for value in (a, b))
    return where(condition, a, b)


FUNCTIONS: Final[dict[str, Callable[..., Any]]] = {
    **{name: entry.ufunc for name, entry in ELEMENTARY.items()},
    "less": lambda a, b: 1.0 * np.less(a, b),
    "where": lambda c, a, b: np.where(np.not_equal(c, 0.0), a, b),
    "floor": np.floor,
}


@dataclass(frozen=True, eq=False)
class PointFunction:
    """A function from R^n to R^n as formulas of coordinates and parameters."""

    dimension: int
    parameters: tuple[str, ...]
    graph: PointGraph
    outputs: tuple[int, ...]

    def values(self, x: Floats, arguments: Arguments) -> Floats:
        """Values at points (..., n)."""
        return self._evaluated(self.outputs, x, arguments)

    def jacobians(self, x: Floats, arguments: Arguments) -> Floats:
        """Exact Jacobians (..., n, n)."""
        entries = [self._slope(f"{COORDINATE}{k}") for k in range(self.dimension)]
        rows = self._evaluated(np.transpose(entries).ravel().tolist(), x, arguments)
        return rows.reshape(*x.shape, self.dimension)

    def rates(self, x: Floats, name: str, arguments: Arguments) -> Floats:
        """Exact derivatives by a parameter (..., n)."""
        return self._evaluated(self._slope(name), x, arguments)

    def pieces(self, x: Floats, arguments: Arguments) -> Floats:
        """Return whole numbers (..., k) that are the same all over a smooth piece."""
        return self._evaluated(self._choices, x, arguments)

    @cached_property
    def _choices(self) -> list[int]:
        kept = reachable(self.graph, self.outputs)
        return [k for k in kept if self.graph.nodes[k].op in ("less", "floor")]

    @cached_property
    def _slopes(self) -> dict[str, list[int]]:
        return {}

    def _slope(self, name: str) -> list[int]:
        if name not in self._slopes:
            by = self.graph.symbol(name)
            self._slopes[name] = [derivative(self.graph[k], by).number for k in self.outputs]
        return self._slopes[name]

    def _evaluated(self, numbers: Sequence[int], x: Floats, arguments: Arguments) -> Floats:
        given = {f"{COORDINATE}{k}": x[..., k] for k in range(self.dimension)} | dict(arguments)
        with np.errstate(all="ignore"):
            found = evaluate(self.graph, numbers, given, FUNCTIONS)
        made = np.empty((*x.shape[:-1], len(numbers)))
        for k, values in enumerate(found):
            made[..., k] = values
        return made

    @cached_property
    def n_operations(self) -> int:
        """Operations of one value: what compiling costs."""
        return len(reachable(self.graph, self.outputs))

    def text(self, low: Sequence[float], periods: Sequence[float]) -> str:
        """Write a module of kernels of points as tuples; coordinates with a period are angles."""
        n, kept = range(self.dimension), reachable(self.graph, self.outputs)
        names: dict[int, str] = {}
        lines = []
        for number in kept:
            node = self.graph.nodes[number]
            if node.op == "constant":
                names[number] = f"({node.value!r})"
            elif node.op == "symbol" and node.name.startswith(COORDINATE):
                names[number] = f"x[{node.name.removeprefix(COORDINATE)}]"
            elif node.op == "symbol":
                names[number] = f"p[{self.parameters.index(node.name)}]"
            else:
                names[number] = f"u{number}"
                operands = [names[arg] for arg in node.args]
                text = _TEXTS[node.op](*operands) if node.op in _TEXTS else value_text(node, names)
                lines.append(f"u{number} = {text}")
        values = [names[number] for number in self.outputs]
        for k in n:
            if math.isfinite(periods[k]):
                turns = f"math.floor(({values[k]} - ({low[k]!r})) / {periods[k]!r})"
                lines.append(f"v{k} = {values[k]} - {periods[k]!r} * {turns}")
                lines.append(f"v{k} = min(max(v{k}, {low[k]!r}), {low[k] + periods[k]!r})")
                values[k] = f"v{k}"
        place = [f"np.int64((x[{k}] - box[{k}, 0]) * per_cell[{k}])" for k in n]
        key = [f"key = {place[0]}", *(f"key = key * counts[{k}] + {place[k]}" for k in n[1:])]
        within = " and ".join(f"box[{k}, 0] <= x[{k}] <= box[{k}, 1]" for k in n)
        loaded = "".join(f"x[i, {k}], " for k in n)
        return HEADER + "\n".join(
            [
                *_function("step(x, p)", [*lines, f"return ({', '.join(values)},)"]),
                *_function("load(x, i)", [f"return ({loaded})"]),
                *_function("store(z, x, i)", [f"x[i, {k}] = z[{k}]" for k in n]),
                *_function("inside(x, box)", [f"return {within}"]),
                *_function("cell(x, box, per_cell, counts)", [*key, "return np.uint64(key)"]),
            ]
        )


def _function(signature: str, lines: Sequence[str]) -> list[str]:
    return ["", "@kernel(inline=True)", f"def {signature}:", *indented(lines), ""]


_TEXTS: Final[dict[str, Callable[..., str]]] = {
    "less": lambda a, b: f"1.0 if {a} < {b} else 0.0",
    "where": lambda c, a, b: f"{a} if {c} != 0.0 else {b}",
    "floor": lambda a: f"float(math.floor({a})) if abs({a}) < 1e15 else {a}",
}


def point_function(
    function: Callable[..., Any], dimension: int, parameters: Sequence[str]
) -> PointFunction:
    """Record ``function(x, **parameters)`` of points (..., n); NotTraceable if that cannot be."""
    graph = PointGraph()
    point = coordinates([graph.symbol(f"{COORDINATE}{k}") for k in range(dimension)])
    result = np.asarray(recorded(function, point, graph, parameters), dtype=object)
    if result.shape != (dimension,):
        raise NotTraceable(f"of one point it returned the shape {result.shape}")
    outputs = tuple(as_expression(graph, value).number for value in result.tolist())
    return PointFunction(dimension, tuple(parameters), graph, outputs)
