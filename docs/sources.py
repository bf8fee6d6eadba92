"""Where the source defines something: what the role ``{source}`` and its test look up."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[1] / "src" / "stickslip"
DEFINITIONS = (ast.FunctionDef, ast.ClassDef)


def place_of(path: str) -> tuple[Path, int]:
    """Find what ``package.module.function`` or ``package.module.Class.method`` names.

    Returns
    -------
    tuple of pathlib.Path and int
        File, and line of the definition; a module is its first line.

    Raises
    ------
    LookupError
        There is no such file or definition.
    """
    parts = path.split(".")
    for n in range(len(parts), 0, -1):
        base = PACKAGE.joinpath(*parts[:n])
        for file in (base.with_suffix(".py"), base / "__init__.py"):
            if file.is_file():
                return file, _line(file, parts[n:])
    raise LookupError(f"stickslip.{path}: there is no such module")


def _line(file: Path, names: list[str]) -> int:
    body, line = _tree(file).body, 1
    for name in names:
        found = [node for node in body if isinstance(node, DEFINITIONS) and node.name == name]
        if not found:
            raise LookupError(f"{file.relative_to(PACKAGE)} defines no {'.'.join(names)}")
        line = found[-1].lineno  # the last: those before are overloads
        body = found[-1].body
    return line


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(file.read_text(encoding="utf-8"))
