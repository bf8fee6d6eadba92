"""Text of a kernel: its statements, and what becomes of its names."""

from __future__ import annotations

import ast
import linecache
import textwrap
from collections import Counter
from collections.abc import Callable
from types import CodeType
from typing import Any

from stickslip.numerics.translation.values import NotUnderstood, types

ANNOTATED = {
    "float": types.float64,
    "int": types.int64,
    "bool": types.boolean,
    "None": types.none,
    "np.uint64": types.uint64,
}


class Text:
    """Syntax of a function: its statements, and what becomes of its names."""

    def __init__(self, code: CodeType, lines: list[str]) -> None:
        first = code.co_firstlineno
        last = max((end for _, end, *_ in code.co_positions() if end), default=first)
        try:
            (tree,) = ast.parse(textwrap.dedent("".join(lines[first - 1 : last]))).body
        except (SyntaxError, ValueError):
            raise NotUnderstood("its text is not known") from None
        if not isinstance(tree, ast.FunctionDef) or tree.name != code.co_name:
            raise NotUnderstood("its text is that of something else")
        plain = tree.args
        if plain.vararg or plain.kwarg or plain.kwonlyargs or plain.posonlyargs or plain.defaults:
            raise NotUnderstood("its arguments")
        self.body = tree.body
        self.result = None if tree.returns is None else ANNOTATED.get(ast.unparse(tree.returns))
        self.counts = Counter(each.arg for each in plain.args)  # how often a name is given
        self.used: set[str] = set()
        for statement in tree.body:
            for each in ast.walk(statement):
                if isinstance(each, ast.Name):
                    if isinstance(each.ctx, ast.Store):
                        self.counts[each.id] += 1
                    else:
                        self.used.add(each.id)
                elif isinstance(each, ast.AugAssign) and isinstance(each.target, ast.Name):
                    self.counts[each.target.id] += 1  # twice: what it holds changes
                    self.used.add(each.target.id)


TEXTS: dict[CodeType, Text] = {}  # by code: templates are made more than once


def text_of(function: Callable[..., Any]) -> Text:
    """Text of a function, read once for all that are made of it."""
    code = function.__code__
    if code not in TEXTS:
        TEXTS[code] = Text(code, linecache.getlines(code.co_filename, function.__globals__))
    return TEXTS[code]
