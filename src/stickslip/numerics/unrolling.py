"""Loops with known bounds written out: kernel text without inner loops, arrays or branches.

Coefficients of lanes stay in registers. A sum of products, gathered term by term, becomes one call
of `vector.products`: what compiling costs is the number of statements.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Mapping
from typing import TypeGuard

Number = int | float
Place = str | tuple[str, tuple[Number, ...]]

_OPERATIONS: dict[type[ast.operator], Callable[[Number, Number], Number]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.FloorDiv: lambda a, b: a // b,
    ast.Mod: lambda a, b: a % b,
}
_COMPARISONS: dict[type[ast.cmpop], Callable[[Number, Number], bool]] = {
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
    ast.Lt: lambda a, b: a < b,
    ast.GtE: lambda a, b: a >= b,
}


def unrolled(
    text: str, known: Mapping[str, Number], local: Collection[str], fixed: Collection[str] = ()
) -> list[str]:
    """Write out assignments, calls, and ``for`` and ``if`` over known integers, straight-line.

    Elements of `local` arrays become names; of `fixed` ones ``p[3]`` becomes ``p_3``, which whoever
    uses the text defines. Indices must be known.
    """
    writer = _Writer(known, local, fixed)
    writer.block(ast.parse(text).body)
    return [ast.unparse(line) for line in _needed(writer.lines)]


def _needed(lines: list[ast.stmt]) -> list[ast.stmt]:
    """Leave out names that no later line reads."""
    kept: list[ast.stmt] = []
    read: set[str] = set()
    for line in reversed(lines):
        target = line.targets[0] if isinstance(line, ast.Assign) else None
        if not isinstance(target, ast.Name) or target.id in read:
            kept.append(line)
            read.update(node.id for node in ast.walk(line) if isinstance(node, ast.Name))
    return kept[::-1]


class _Writer(ast.NodeTransformer):
    """Executes statements; `values` holds a number or the present name of every place."""

    def __init__(
        self, known: Mapping[str, Number], local: Collection[str], fixed: Collection[str]
    ) -> None:
        self.values: dict[Place, Number | str] = {name: known[name] for name in known}
        self.local, self.fixed = local, fixed
        self.lines: list[ast.stmt] = []
        self._sums: dict[Place, list[ast.expr]] = {}  # factors of sums that nobody has read yet
        self._versions: dict[Place, int] = {}

    # --- statements -----------------------------------------------------------------------

    def block(self, statements: list[ast.stmt]) -> None:
        for statement in statements:
            match statement:
                case ast.For(target=ast.Name(id=name), iter=ast.Call(args=bounds)):
                    for value in range(*(int(self._number(bound)) for bound in bounds)):
                        self.values[name] = value
                        self.block(statement.body)
                case ast.If():
                    self.block(statement.body if self._number(statement.test) else statement.orelse)
                case ast.Assign(targets=[target], value=value):
                    self._assign(target, self.visit(value))
                case ast.AugAssign(target=target, op=operation, value=value):
                    self._change(target, operation, self.visit(value))
                case ast.Expr(value=ast.Call() as call):
                    self.lines.append(ast.fix_missing_locations(ast.Expr(self.visit(call))))
                case _:
                    raise ValueError(f"cannot write out: {ast.unparse(statement)}")

    def _change(self, target: ast.expr, operation: ast.operator, value: ast.expr) -> None:
        place = self._place(target)
        started = place in self._sums or (place is not None and self.values.get(place) == 0)
        if started and isinstance(operation, ast.Add) and _is_product(value):
            assert place is not None
            self._sums.setdefault(place, []).extend((value.left, value.right))
            self.values.pop(place, None)
        else:
            self._assign(target, self.visit(ast.BinOp(target, operation, value)))

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        place = self._place(target)
        if place is None:  # an element of an array that stays one
            self.lines.append(_assignment(self.visit(target), value))
            return
        self._sums.pop(place, None)
        self.values.pop(place, None)
        if (number := _constant(value)) is not None:
            self.values[place] = number
        elif isinstance(value, ast.Name):
            self.values[place] = value.id
        elif _is_product(value):
            self._sums[place] = [value.left, value.right]
        else:
            self._name(place, value)

    def _name(self, place: Place, value: ast.expr) -> None:
        name = self._new_name(place)
        self.lines.append(_assignment(ast.Name(name, ast.Store()), value))
        self.values[place] = name

    def _finish_sum(self, place: Place) -> None:
        factors = self._sums.pop(place)
        if len(factors) == 2:
            self._name(place, ast.BinOp(factors[0], ast.Mult(), factors[1]))
        else:
            self._name(place, ast.Call(ast.Name("products", ast.Load()), factors, []))

    def _new_name(self, place: Place) -> str:
        version = self._versions[place] = self._versions.get(place, -1) + 1
        stem = place if isinstance(place, str) else "_".join(map(str, (place[0], *place[1])))
        return f"{stem}_v{version}"

    # --- expressions ----------------------------------------------------------------------

    def visit_Name(self, node: ast.Name) -> ast.expr:
        return self._held(node.id, node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        place = self._place(node)
        if place is not None:
            if place not in self.values and place not in self._sums:
                raise ValueError(f"used before it is set: {ast.unparse(node)}")
            return self._held(place, node)
        if isinstance(node.value, ast.Name) and node.value.id in self.fixed:
            return ast.Name(f"{node.value.id}_{self._number(node.slice)}", ast.Load())
        return ast.Subscript(node.value, self.visit(node.slice), node.ctx)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        left, right = self.visit(node.left), self.visit(node.right)
        a, b = _constant(left), _constant(right)
        if a is not None and b is not None:
            return ast.Constant(_OPERATIONS[type(node.op)](a, b))
        if a == 0:  # a sum without a term yet
            if isinstance(node.op, ast.Add):
                return right
            if isinstance(node.op, ast.Mult | ast.Div):
                return left
        return ast.BinOp(left, node.op, right)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:
        operand = self.visit(node.operand)
        number = _constant(operand)
        if number is not None and isinstance(node.op, ast.USub):
            return ast.Constant(-number)
        return ast.UnaryOp(node.op, operand)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        left, right = self.visit(node.left), self.visit(node.comparators[0])
        a, b = _constant(left), _constant(right)
        if a is not None and b is not None:
            return ast.Constant(_COMPARISONS[type(node.ops[0])](a, b))
        return ast.Compare(left, node.ops, [right])

    def visit_Call(self, node: ast.Call) -> ast.expr:
        return ast.Call(node.func, [self.visit(argument) for argument in node.args], [])

    # --- places ---------------------------------------------------------------------------

    def _place(self, node: ast.expr) -> Place | None:
        if isinstance(node, ast.Name):
            return node.id
        if isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name):
            if node.value.id in self.local:
                index = node.slice
                parts = index.elts if isinstance(index, ast.Tuple) else [index]
                return node.value.id, tuple(self._number(part) for part in parts)
        return None

    def _held(self, place: Place, node: ast.expr) -> ast.expr:
        if place in self._sums:
            self._finish_sum(place)
        value = self.values.get(place)
        if value is None:
            return node
        return ast.Name(value, ast.Load()) if isinstance(value, str) else ast.Constant(value)

    def _number(self, node: ast.expr) -> Number:
        number = _constant(self.visit(node))
        if number is None:
            raise ValueError(f"not known: {ast.unparse(node)}")
        return number


def _is_product(node: ast.expr) -> TypeGuard[ast.BinOp]:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Mult)


def _constant(node: ast.expr) -> Number | None:
    """Return the number that a node is."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int | float):
        return node.value
    return None


def _assignment(target: ast.expr, value: ast.expr) -> ast.stmt:
    return ast.fix_missing_locations(ast.Assign([target], value))
