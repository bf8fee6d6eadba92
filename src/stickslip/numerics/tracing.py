"""Recording what a plain Python function computes, whichever library its functions come from."""

from __future__ import annotations

import math
import types
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from stickslip.numerics.expression import ELEMENTARY, Expression, Graph, NotTraceable, elementary


def _traced(name: str, plain: Callable[..., Any]) -> Callable[..., Any]:
    def function(x: Any) -> Any:
        return elementary(name, x) if isinstance(x, Expression) else plain(x)

    return function


def _pow(x: Any, y: Any) -> Any:
    return x**y if isinstance(x, Expression) or isinstance(y, Expression) else math.pow(x, y)


# Functions of the math module that accept expressions; the others are left as they are, and
# refuse an expression with a TypeError of their own.
_MATH: dict[str, Callable[..., Any]] = {
    **{entry.scalar.__name__: _traced(name, entry.scalar) for name, entry in ELEMENTARY.items()},
    "pow": _pow,
    "fabs": lambda x: abs(x) if isinstance(x, Expression) else math.fabs(x),
}
_REPLACED = {getattr(math, name): function for name, function in _MATH.items()}


class _TracedMath:
    """Stands for the math module inside a traced function."""

    def __getattr__(self, name: str) -> Any:
        return _MATH.get(name) or getattr(math, name)


def plain_function(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the Python function behind one that numba compiled; others as they are."""
    plain: Callable[..., Any] = getattr(function, "py_func", function)
    return plain


def _retargeted(value: Any, done: dict[int, Any]) -> Any:
    """`value`, with every use of the math module in it redirected to expressions."""
    if value is math:
        return _TracedMath()
    if isinstance(value, types.BuiltinFunctionType):
        return _REPLACED.get(value, value)
    if isinstance(value, partial):
        return partial(_retargeted(value.func, done), *value.args, **value.keywords)
    if isinstance(value, types.MethodType):
        return types.MethodType(_retargeted(value.__func__, done), value.__self__)
    function = plain_function(value)
    if not isinstance(function, types.FunctionType):
        return value
    if function.__module__ and function.__module__.partition(".")[0] == "numpy":
        return value
    if id(function) in done:
        return done[id(function)]
    names: dict[str, Any] = dict(function.__globals__)
    copy = types.FunctionType(
        function.__code__,
        names,
        function.__name__,
        function.__defaults__,
        tuple(types.CellType() for _ in function.__closure__ or ()),
    )
    copy.__kwdefaults__ = function.__kwdefaults__
    done[id(function)] = copy
    for name in function.__code__.co_names:
        if name in names:
            names[name] = _retargeted(names[name], done)
    for cell, original in zip(copy.__closure__ or (), function.__closure__ or (), strict=True):
        cell.cell_contents = _retargeted(original.cell_contents, done)
    return copy


def recorded(
    function: Callable[..., Any], variable: Any, graph: Graph, parameters: Sequence[str]
) -> Any:
    """Call a function with symbols for its parameters; whatever fails is `NotTraceable`."""
    symbols = {name: graph.symbol(name) for name in parameters}
    try:
        return _retargeted(function, {})(variable, **symbols)
    except NotTraceable:
        raise
    except Exception as error:
        raise NotTraceable(f"{type(error).__name__}: {error}") from error


def trace(function: Callable[..., Any], graph: Graph, parameters: Sequence[str] = ()) -> Expression:
    """Record ``function(variable, **parameters)`` in `graph`, numpy and math in helpers as well."""
    result = recorded(function, graph.symbol(graph.variable), graph, parameters)
    if isinstance(result, Expression):
        return result
    if isinstance(result, (bool, np.bool_)) or not isinstance(result, (int, float, np.number)):
        raise NotTraceable(f"it returned {type(result).__name__}")
    if isinstance(result, np.complexfloating):
        raise NotTraceable("it returned a complex number")
    return graph.constant(float(result))
