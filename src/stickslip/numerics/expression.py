"""Formulas as graphs, grown by numbers that record what is done to them.

A friction law is written once; slope, derivatives, series and enclosures come from its graph.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

# A constant integer power becomes products up to this exponent.
LARGEST_PRODUCT_POWER = 64


class NotTraceable(TypeError):
    """The formula does something that cannot be recorded, such as branch on its argument."""


class Node(NamedTuple):
    """One operation; ``args`` are the numbers of earlier nodes of the same graph."""

    op: str
    args: tuple[int, ...] = ()
    value: float = 0.0
    name: str = ""


class Elementary(NamedTuple):
    """An elementary function u = f(x): ``u' = factor(x, u) x'`` or ``u' = x' / divisor(x, u)``."""

    scalar: Callable[[float], float]
    ufunc: np.ufunc
    factor: Callable[[Expression, Expression], Expression] | None = None
    divisor: Callable[[Expression, Expression], Expression] | None = None


class Graph:
    """Grows nodes, each distinct one once; `variable` varies with time, other symbols do not."""

    kind: type[Expression]

    def __init__(self, variable: str = "s", nodes: Sequence[Node] = ()) -> None:
        self.variable = variable
        self.nodes: list[Node] = []
        self.varies: list[bool] = []
        self._numbers: dict[Node, int] = {}
        self.reached: dict[tuple[int, ...], list[int]] = {}  # what `reachable` has found
        for node in nodes:
            self.add(node)

    def add(self, node: Node) -> Expression:
        """Return the expression of a node, new or not."""
        number = self._numbers.get(node)
        if number is None:
            number = len(self.nodes)
            self.nodes.append(node)
            self.varies.append(
                any(self.varies[arg] for arg in node.args)
                or (node.op == "symbol" and self.is_variable(node.name))
            )
            self._numbers[node] = number
        return self[number]

    def is_variable(self, name: str) -> bool:
        """Tell whether a symbol is the variable, or one of several."""
        return name == self.variable

    def symbol(self, name: str) -> Expression:
        """Return the variable or a parameter."""
        return self.add(Node("symbol", name=name))

    def constant(self, value: float) -> Expression:
        """Return a number, which has to be finite."""
        if not math.isfinite(value):
            raise NotTraceable(f"the constant {value} is not finite")
        return self.add(Node("constant", value=float(value) + 0.0))  # no second, negative zero

    def __getitem__(self, number: int) -> Expression:
        """Return the expression with this number."""
        return self.kind(self, number)


Operation = Callable[..., "Expression"]


def _operator(operation: Operation) -> Callable[[Expression, Any], Expression]:
    def method(self: Expression, other: Any) -> Any:
        if isinstance(other, np.ndarray):  # whose own operators go through its elements
            return NotImplemented
        return operation(self, as_expression(self.graph, other))

    return method


def _reflected(operation: Operation) -> Callable[[Expression, Any], Expression]:
    return _operator(lambda a, b: operation(b, a))


def _refuse(*_: Any) -> Any:
    raise NotTraceable("its steps depend on the value of its argument")


class Expression:
    """A node of a graph that behaves like a number and records what is done to it."""

    __slots__ = ("graph", "number")
    recorded: ClassVar[dict[str, Operation]] = {}

    def __init__(self, graph: Graph, number: int) -> None:
        self.graph = graph
        self.number = number

    @property
    def node(self) -> Node:
        """What the graph holds under its number."""
        return self.graph.nodes[self.number]

    @property
    def varies(self) -> bool:
        """Whether it depends on the graph's variable."""
        return self.graph.varies[self.number]

    __add__ = _operator(lambda a, b: add(a, b))
    __radd__ = _reflected(lambda a, b: add(a, b))
    __sub__ = _operator(lambda a, b: subtract(a, b))
    __rsub__ = _reflected(lambda a, b: subtract(a, b))
    __mul__ = _operator(lambda a, b: multiply(a, b))
    __rmul__ = _reflected(lambda a, b: multiply(a, b))
    __truediv__ = _operator(lambda a, b: divide(a, b))
    __rtruediv__ = _reflected(lambda a, b: divide(a, b))
    __pow__ = _operator(lambda a, b: power(a, b))
    __rpow__ = _reflected(lambda a, b: power(a, b))

    def __neg__(self) -> Expression:
        """Record a change of sign."""
        return negative(self)

    def __pos__(self) -> Expression:
        """Return it as it is."""
        return self

    def __abs__(self) -> Expression:
        """Return the variable itself: it is a speed. Nothing else has a smooth modulus."""
        if self.node == Node("symbol", name=self.graph.variable):
            return self
        raise NotTraceable("abs() is not smooth")

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: Any, **kwargs: Any) -> Any:
        """Record what numpy's functions do."""
        recorded = self.recorded.get(ufunc.__name__)
        if recorded is None or method != "__call__" or kwargs:
            raise NotTraceable(f"numpy.{ufunc.__name__} is not among the functions recorded")
        return recorded(*(as_expression(self.graph, value) for value in inputs))

    # Comparing and rounding would make the steps depend on the value.
    __lt__ = __le__ = __gt__ = __ge__ = __eq__ = __ne__ = _refuse
    __bool__ = __float__ = __int__ = __index__ = __complex__ = __round__ = _refuse
    __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = __divmod__ = _refuse
    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Show it as nested calls."""
        node = self.node
        if node.op == "constant":
            return repr(node.value)
        if node.op == "symbol":
            return node.name
        return f"{node.op}({', '.join(repr(self.graph[arg]) for arg in node.args)})"


def as_expression(graph: Graph, value: Any) -> Expression:
    """Return an expression as it is, and a number as a constant."""
    if isinstance(value, Expression):
        return value
    is_real = isinstance(value, (int, float, np.integer, np.floating))
    if not is_real or isinstance(value, bool):
        raise NotTraceable(f"{type(value).__name__} is not a real number")
    return graph.constant(float(value))


# --- operations, constants folded ----------------------------------------------------------------


def _constants(*terms: Expression) -> list[float] | None:
    """Values of the terms if all are constants."""
    values = [term.node.value for term in terms if term.node.op == "constant"]
    return values if len(values) == len(terms) else None


def is_constant(term: Expression, value: float) -> bool:
    """Whether `term` is this number whatever the symbols are."""
    return term.node.op == "constant" and term.node.value == value


def grow(op: str, *terms: Expression) -> Expression:
    """Record an operation."""
    return terms[0].graph.add(Node(op, tuple(term.number for term in terms)))


def add(a: Expression, b: Expression) -> Expression:
    """Return a + b."""
    if values := _constants(a, b):
        return a.graph.constant(values[0] + values[1])
    if is_constant(a, 0.0):
        return b
    if is_constant(b, 0.0):
        return a
    if b.node.op == "negative":
        return subtract(a, a.graph[b.node.args[0]])
    return grow("add", *sorted((a, b), key=lambda term: term.number))


def subtract(a: Expression, b: Expression) -> Expression:
    """Return a - b."""
    if values := _constants(a, b):
        return a.graph.constant(values[0] - values[1])
    if is_constant(b, 0.0):
        return a
    if is_constant(a, 0.0):
        return negative(b)
    if a.number == b.number:
        return a.graph.constant(0.0)
    if b.node.op == "negative":
        return add(a, a.graph[b.node.args[0]])
    return grow("subtract", a, b)


def negative(a: Expression) -> Expression:
    """Return -a."""
    if values := _constants(a):
        return a.graph.constant(-values[0])
    if a.node.op == "negative":
        return a.graph[a.node.args[0]]
    return grow("negative", a)


def multiply(a: Expression, b: Expression) -> Expression:
    """Return a b; the sign of a factor moves out."""
    if values := _constants(a, b):
        return a.graph.constant(values[0] * values[1])
    if is_constant(a, 0.0) or is_constant(b, 0.0):
        return a.graph.constant(0.0)
    for one, other in ((a, b), (b, a)):
        if is_constant(one, 1.0):
            return other
        if is_constant(one, -1.0):
            return negative(other)
        if one.node.op == "negative":
            return negative(multiply(a.graph[one.node.args[0]], other))
    return grow("multiply", *sorted((a, b), key=lambda term: term.number))


def divide(a: Expression, b: Expression) -> Expression:
    """Return a / b."""
    if is_constant(b, 0.0):
        raise NotTraceable("it divides by zero")
    if values := _constants(a, b):
        return a.graph.constant(values[0] / values[1])
    if is_constant(b, 1.0):
        return a
    if is_constant(a, 0.0):
        return a
    if not a.varies and b.varies:  # one recurrence for the reciprocal serves the derivatives too
        return multiply(a, grow("reciprocal", b))
    return grow("divide", a, b)


def power(a: Expression, b: Expression) -> Expression:
    """Return a^b: products if b is a small integer, a power if constant, else exp(b log a)."""
    if values := _constants(a, b):
        return a.graph.constant(math.pow(values[0], values[1]))
    if b.varies:
        return elementary("exp", multiply(b, elementary("log", a)))
    exponent = _constants(b)
    if exponent is None:
        return grow("power", a, b)
    if exponent[0] == 0.5:
        return elementary("sqrt", a)
    if exponent[0] == round(exponent[0]) and abs(exponent[0]) <= LARGEST_PRODUCT_POWER:
        return _integer_power(a, round(exponent[0]))
    return grow("power", a, b)


def _integer_power(a: Expression, exponent: int) -> Expression:
    if exponent < 0:
        return divide(a.graph.constant(1.0), _integer_power(a, -exponent))
    if exponent == 0:
        return a.graph.constant(1.0)
    half = _integer_power(a, exponent // 2)
    square = multiply(half, half)
    return multiply(square, a) if exponent % 2 else square


def gathered(term: Expression) -> Expression:
    """Return a sum with what does not vary of each product multiplied out: one factor is left."""
    if term.varies and term.node.op in ("add", "subtract"):
        return grow(term.node.op, *(gathered(term.graph[arg]) for arg in term.node.args))
    factor, rest = term.graph.constant(1.0), term
    while rest.varies and rest.node.op in ("negative", "multiply"):
        args = [rest.graph[arg] for arg in rest.node.args]
        fixed = [arg for arg in args if not arg.varies]
        if rest.node.op == "multiply" and not fixed:
            break
        factor = negative(factor) if rest.node.op == "negative" else multiply(factor, *fixed)
        (rest,) = (arg for arg in args if arg.varies)
    if rest.number == term.number:
        return term
    return grow("multiply", *sorted((factor, rest), key=lambda each: each.number))


def where(condition: Expression, a: Expression, b: Expression) -> Expression:
    """Return a where the condition is not 0, else b."""
    return a if a.number == b.number else grow("where", condition, a, b)


def elementary(name: str, a: Expression) -> Expression:
    """Return a function of `ELEMENTARY`, of a."""
    if values := _constants(a):
        return a.graph.constant(ELEMENTARY[name].scalar(values[0]))
    return grow(name, a)


ELEMENTARY = {
    "exp": Elementary(math.exp, np.exp, factor=lambda x, u: u),
    "expm1": Elementary(math.expm1, np.expm1, factor=lambda x, u: elementary("exp", x)),
    "log": Elementary(math.log, np.log, divisor=lambda x, u: x),
    "log1p": Elementary(math.log1p, np.log1p, divisor=lambda x, u: 1.0 + x),
    "sqrt": Elementary(math.sqrt, np.sqrt, divisor=lambda x, u: 2.0 * u),
    "sin": Elementary(math.sin, np.sin, factor=lambda x, u: elementary("cos", x)),
    "cos": Elementary(math.cos, np.cos, factor=lambda x, u: -elementary("sin", x)),
    "tan": Elementary(math.tan, np.tan, factor=lambda x, u: 1.0 + u * u),
    "sinh": Elementary(math.sinh, np.sinh, factor=lambda x, u: elementary("cosh", x)),
    "cosh": Elementary(math.cosh, np.cosh, factor=lambda x, u: elementary("sinh", x)),
    "tanh": Elementary(math.tanh, np.tanh, factor=lambda x, u: 1.0 - u * u),
    "atan": Elementary(math.atan, np.arctan, divisor=lambda x, u: 1.0 + x * x),
    "asinh": Elementary(
        math.asinh, np.arcsinh, divisor=lambda x, u: elementary("sqrt", 1.0 + x * x)
    ),
}

# What `__array_ufunc__` accepts, by the ufunc's own name.
Expression.recorded = {
    "add": add,
    "subtract": subtract,
    "multiply": multiply,
    "divide": divide,
    "true_divide": divide,
    "power": power,
    "float_power": power,
    "negative": negative,
    "positive": lambda a: a,
    "absolute": abs,
    "square": lambda a: a * a,
    "reciprocal": lambda a: 1.0 / a,
    **{entry.ufunc.__name__: partial(elementary, name) for name, entry in ELEMENTARY.items()},
}
Graph.kind = Expression


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
    asked = tuple(outputs)
    if asked not in graph.reached:
        found: set[int] = set()
        waiting = list(asked)
        while waiting:
            number = waiting.pop()
            if number not in found:
                found.add(number)
                waiting.extend(graph.nodes[number].args)
        graph.reached[asked] = sorted(found)
    return graph.reached[asked]


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
        case "less" | "floor":
            return graph.constant(0.0)
        case "where":
            return where(x, known[node.args[1]], dy)
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
