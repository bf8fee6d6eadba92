"""What a friction law computes, apart from the values of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any, ClassVar

import numpy as np

from stickslip.numerics.expression import (
    Expression,
    Graph,
    Node,
    derivative,
    evaluate,
    is_analytic,
    reachable,
)
from stickslip.numerics.tracing import trace

Function = Callable[..., Any]


@dataclass(frozen=True)
class TracedFormula:
    """A law recorded as a graph in s = |w|; equal graphs are equal formulas."""

    parameters: tuple[str, ...]
    nodes: tuple[Node, ...]
    backward: int  # node of the force; the same as forward in a symmetric law
    forward: int

    @property
    def symmetric(self) -> bool:
        """Whether both directions of slip have the same force."""
        return self.backward == self.forward

    def graph(self) -> Graph:
        """Return a new graph, to which derivatives may be added."""
        return Graph("s", self.nodes)

    def output(self, forward: bool) -> int:
        """Return the node of the force in one direction."""
        return self.forward if forward else self.backward

    def without(self, zero: Collection[str]) -> TracedFormula:
        """Return the law with some parameters zero; it keeps their names."""
        graph = Graph("s")
        symbols = {
            name: graph.constant(0.0) if name in zero else graph.symbol(name)
            for name in ("s", *self.parameters)
        }
        results = evaluate(self.graph(), [self.backward, self.forward], symbols)
        backward, forward = (
            x.number if isinstance(x, Expression) else graph.constant(x).number for x in results
        )
        return _pruned(self.parameters, graph, backward, forward)

    @cached_property
    def _forces(self) -> Graph:
        return self.graph()

    @cached_property
    def _slopes(self) -> tuple[Graph, int, int]:
        graph = self.graph()
        s = graph.symbol("s")
        backward = derivative(graph[self.backward], s).number
        return graph, backward, derivative(graph[self.forward], s).number

    def force(
        self,
        s: Any,
        arguments: Mapping[str, Any],
        forward: bool = False,
        functions: Mapping[str, Function] | None = None,
    ) -> Any:
        """F in the arithmetic of `s` and `arguments`; see `expression.evaluate`."""
        output = self.output(forward)
        return evaluate(self._forces, [output], {"s": s, **arguments}, functions)[0]

    def slope(
        self,
        s: Any,
        arguments: Mapping[str, Any],
        forward: bool = False,
        functions: Mapping[str, Function] | None = None,
    ) -> Any:
        """dF/ds, like `force`."""
        graph, *outputs = self._slopes
        return evaluate(graph, [outputs[forward]], {"s": s, **arguments}, functions)[0]

    def is_analytic_at_rest(self, arguments: Mapping[str, float]) -> bool:
        """Whether F has a Taylor series at s = 0 in both directions."""
        outputs = [self.backward, self.forward]
        return is_analytic(self.graph(), outputs, {"s": 0.0, **arguments})


@dataclass(frozen=True)
class UserFunction:
    """A plain Python function of the speed and of some parameters, by name."""

    function: Function
    parameters: tuple[str, ...]

    def __call__(self, s: Any, arguments: Mapping[str, Any]) -> Any:
        """Call it with those parameters that it takes."""
        return self.function(s, **{name: arguments[name] for name in self.parameters})

    def compiled(self) -> UserFunction:
        """Return the same for use in kernels, compiled once in this process."""
        return UserFunction(_compiled(self.function), self.parameters)


@lru_cache(maxsize=256)
def _compiled(function: Function) -> Function:
    if hasattr(function, "py_func"):  # by numba already
        return function
    from stickslip.numerics.targets import kernel_uncached

    return kernel_uncached(function)


@dataclass(frozen=True)
class CallableFormula:
    """A law known by its values only; equal if the functions are the same ones."""

    ROLES: ClassVar = ("backward", "forward", "slope")
    parameters: tuple[str, ...]
    backward: UserFunction
    forward: UserFunction
    slope: UserFunction | None = None  # of the backward direction, or of both

    @property
    def symmetric(self) -> bool:
        """Whether both directions of slip have the same force."""
        return self.forward == self.backward

    def addresses(self) -> list[float]:
        """Where kernels find the functions of the roles, as functions of s and all parameters."""
        functions = (self.backward, self.forward, self.slope or self.backward)
        return [_address(function, self.parameters) for function in functions]


@lru_cache(maxsize=256)
def _address(user: UserFunction, names: tuple[str, ...]) -> float:
    from stickslip.numerics.by_address import address_of

    given = ", ".join(f"{name}=x{names.index(name)}" for name in user.parameters)
    numbers = ", ".join(["s", *(f"x{j}" for j in range(len(names)))])
    text = f"lambda {numbers}: 1.0 * user(s, {given})"  # 1.0 *: it may return an integer
    return address_of(eval(text, {"user": user.compiled().function}), 1 + len(names))


Formula = TracedFormula | CallableFormula


def traced_formula(
    parameters: Sequence[str], backward: UserFunction, forward: UserFunction | None = None
) -> TracedFormula:
    """Record a law; NotTraceable if that cannot be done."""
    graph = Graph("s")
    for name in parameters:
        graph.symbol(name)
    functions = [backward, backward if forward is None else forward]
    results = [trace(user.function, graph, user.parameters).number for user in functions]
    return _pruned(tuple(parameters), graph, *results)


def _pruned(
    parameters: tuple[str, ...], graph: Graph, backward: int, forward: int
) -> TracedFormula:
    """Without the nodes left over from tracing, so that equal laws are equal formulas."""
    symbols = [graph.symbol(name).number for name in ("s", *parameters)]
    kept = reachable(graph, [*symbols, backward, forward])
    position = {number: i for i, number in enumerate(kept)}
    nodes = tuple(
        graph.nodes[number]._replace(args=tuple(position[arg] for arg in graph.nodes[number].args))
        for number in kept
    )
    return TracedFormula(parameters, nodes, position[backward], position[forward])


@lru_cache(maxsize=256)
def builtin_formula(
    expression: Function, names: tuple[str, ...], options: tuple[tuple[str, Any], ...]
) -> TracedFormula:
    """Trace the ``expression`` of a law class; `options` are its fixed arguments."""
    return traced_formula(names, UserFunction(partial(expression, **dict(options)), names))


def quietly(function: Function, *args: Any, **kwargs: Any) -> Any:
    """Call without numpy's warnings: what overflows is told by its value."""
    with np.errstate(all="ignore"):
        return function(*args, **kwargs)
