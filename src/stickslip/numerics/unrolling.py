"""Loops with known bounds written out: kernel text without inner loops, arrays or branches.

A compiler turns a loop over lanes into vector instructions only if nothing in its body loops,
branches or needs memory of its own. Recurrences are written as loops; here they are executed as
far as their integers are known, and what is left is a list of assignments of new names.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Mapping

Number = int | float
Place = str | tuple[str, tuple[Number, ...]]

_OPERATIONS = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.FloorDiv: lambda a, b: a // b,
    ast.Mod: lambda a, b: a % b,
}
_COMPARISONS = {
    ast.Eq: lambda a, b: a == b,
    ast.NotEq: lambda a, b: a != b,
    ast.Lt: lambda a, b: a < b,
    ast.GtE: lambda a, b: a >= b,
}


def unrolled(
    text: str, known: Mapping[str, Number], local: Collection[str], fixed: Collection[str] = ()
) -> list[str]:
    """Write out straight-line assignments.

    Parameters
    ----------
    text : str
        Statements: assignments, ``for`` over ranges of known integers, ``if`` with a known
        condition.
    known : mapping of str to number
        Values of names.
    local : collection of str
        Arrays whose elements become names; their indices must be known.
    fixed : collection of str
        Arrays that do not change, indexed by known numbers: ``p[3]`` becomes ``p_3``, which
        whoever uses the text defines.

    Raises
    ------
    ValueError
        A bound, a condition or an index is not known, or a statement is of another kind.
    """
    writer = _Writer(known, local, fixed)
    writer.block(ast.parse(text).body)
    return [ast.unparse(line) for line in writer.lines]


class _Writer(ast.NodeTransformer):
    """Executes statements; `values` holds a number or the present name of every place."""

    def __init__(
        self, known: Mapping[str, Number], local: Collection[str], fixed: Collection[str]
    ) -> None:
        self.values: dict[Place, Number | str] = dict(known)
        self.local, self.fixed = local, fixed
        self.lines: list[ast.stmt] = []
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
                    self._assign(target, self._binary(self.visit(target), operation, value))
                case _:
                    raise ValueError(f"cannot write out: {ast.unparse(statement)}")

    def _binary(self, left: ast.expr, operation: ast.operator, right: ast.expr) -> ast.expr:
        return self.visit(ast.BinOp(left, operation, right))

    def _assign(self, target: ast.expr, value: ast.expr) -> None:
        place = self._place(target)
        if place is None:  # an element of an array that stays one
            self.lines.append(_assignment(self.visit(target), value))
        elif isinstance(value, ast.Constant):
            self.values[place] = value.value
        elif isinstance(value, ast.Name):
            self.values[place] = value.id
        else:
            name = self._new_name(place)
            self.lines.append(_assignment(ast.Name(name, ast.Store()), value))
            self.values[place] = name

    def _new_name(self, place: Place) -> str:
        version = self._versions[place] = self._versions.get(place, -1) + 1
        stem = place if isinstance(place, str) else "_".join(map(str, (place[0], *place[1])))
        return f"{stem}_v{version}"

    # --- expressions ----------------------------------------------------------------------

    def visit_Name(self, node: ast.Name) -> ast.expr:  # noqa: N802
        return self._held(node.id, node)

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:  # noqa: N802
        place = self._place(node)
        if place is not None:
            if place not in self.values:
                raise ValueError(f"used before it is set: {ast.unparse(node)}")
            return self._held(place, node)
        if isinstance(node.value, ast.Name) and node.value.id in self.fixed:
            return ast.Name(f"{node.value.id}_{self._number(node.slice)}", ast.Load())
        return ast.Subscript(node.value, self.visit(node.slice), node.ctx)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:  # noqa: N802
        left, right = self.visit(node.left), self.visit(node.right)
        if isinstance(left, ast.Constant) and isinstance(right, ast.Constant):
            return ast.Constant(_OPERATIONS[type(node.op)](left.value, right.value))
        if isinstance(left, ast.Constant) and left.value == 0:  # a sum without a term yet
            if isinstance(node.op, ast.Add):
                return right
            if isinstance(node.op, ast.Mult | ast.Div):
                return left
        return ast.BinOp(left, node.op, right)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.expr:  # noqa: N802
        operand = self.visit(node.operand)
        if isinstance(operand, ast.Constant) and isinstance(node.op, ast.USub):
            return ast.Constant(-operand.value)
        return ast.UnaryOp(node.op, operand)

    def visit_Compare(self, node: ast.Compare) -> ast.expr:  # noqa: N802
        left, right = self.visit(node.left), self.visit(node.comparators[0])
        if isinstance(left, ast.Constant) and isinstance(right, ast.Constant):
            return ast.Constant(_COMPARISONS[type(node.ops[0])](left.value, right.value))
        return ast.Compare(left, node.ops, [right])

    def visit_Call(self, node: ast.Call) -> ast.expr:  # noqa: N802
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
        value = self.values.get(place)
        if value is None:
            return node
        return ast.Name(value, ast.Load()) if isinstance(value, str) else ast.Constant(value)

    def _number(self, node: ast.expr) -> Number:
        value = self.visit(node)
        if not isinstance(value, ast.Constant):
            raise ValueError(f"not known: {ast.unparse(node)}")
        return value.value  # type: ignore[return-value]


def _assignment(target: ast.expr, value: ast.expr) -> ast.stmt:
    return ast.fix_missing_locations(ast.Assign([target], value))
