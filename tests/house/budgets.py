"""Sizes of the house: lines, files, tuning constants, private functions used once, storeys.

    python -m tests.house.budgets          print the counts beside their budgets; fail above one
    python -m tests.house.budgets --write  make the counts the budgets; the commit says why one rose

Counts are those of `src/stickslip`. A count that has fallen well below its budget fails, too: what
was won is kept by writing the budgets anew.
"""

from __future__ import annotations

import ast
import json
import re
import sys
from collections import Counter
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "stickslip"
BUDGETS = Path(__file__).with_name("budgets.json")
SLACK = 0.01  # of a budget: how far a count may lie below it
ROOMS = PACKAGE / "analysis"


def counts() -> dict[str, int]:
    """Every count by name."""
    files = sorted(PACKAGE.rglob("*.py"))
    lines: Counter[str] = Counter()
    for file in files:
        place = file.relative_to(PACKAGE).parts
        lines[place[0] if len(place) > 1 else "top level"] += len(_text(file).splitlines())
    folders = Counter(file.parent for file in files if file.name != "__init__.py")
    rooms = [n for folder, n in folders.items() if folder.is_relative_to(ROOMS)]
    found = {f"lines of {name}": n for name, n in sorted(lines.items())}
    return found | {
        "lines": sum(lines.values()),
        "files": len(files),
        "most files in a folder": max(folders.values()),
        "most files in a room of analysis": max(rooms),
        "storeys of analysis": storeys(ROOMS),
        "named tuning constants": sum(len(constants(file)) for file in files),
        "private functions used once": sum(len(used_once(file)) for file in files),
    }


@cache
def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8")


@cache
def _tree(file: Path) -> ast.Module:
    return ast.parse(_text(file))


def constants(file: Path) -> list[str]:
    """Names in capitals that a module gives a number."""
    found = []
    for node in _tree(file).body:
        match node:
            case ast.Assign(targets=[ast.Name(id=name)], value=value):
                pass
            case ast.AnnAssign(target=ast.Name(id=name), value=ast.expr() as value):
                pass
            case _:
                continue
        if name.isupper() and _is_number(value):
            found.append(name)
    return found


def _is_number(value: ast.expr) -> bool:
    if isinstance(value, ast.UnaryOp):
        return _is_number(value.operand)
    if isinstance(value, ast.BinOp):
        return _is_number(value.left) and _is_number(value.right)
    return isinstance(value, ast.Constant) and type(value.value) in (int, float)


def used_once(file: Path) -> list[str]:
    """Private functions and methods that their module names once, apart from the definition."""
    defined = {
        node.name
        for node in ast.walk(_tree(file))
        if isinstance(node, ast.FunctionDef) and re.match(r"_[a-z]", node.name)
    }
    used: Counter[str] = Counter()
    for node in ast.walk(_tree(file)):
        if isinstance(node, ast.Name):
            used[node.id] += 1
        elif isinstance(node, ast.Attribute):
            used[node.attr] += 1
    return sorted(name for name in defined if used[name] == 1)


def storeys(top: Path) -> int:
    """Length of the longest chain of rooms (folders in `top`) of which each imports the next."""
    below: dict[str, set[str]] = {}
    for file in top.rglob("*.py"):
        here = _room(file.relative_to(PACKAGE.parent).with_suffix("").parts, top)
        for node in _tree(file).body:  # imports inside functions wait until they are needed
            if isinstance(node, ast.ImportFrom) and node.module:
                there = _room(tuple(node.module.split(".")), top)
                if there and here and there != here:
                    below.setdefault(here, set()).add(there)

    @cache
    def height(room: str) -> int:
        return 1 + max((height(other) for other in below.get(room, ())), default=0)

    return max(map(height, below), default=1)


def _room(module: tuple[str, ...], top: Path) -> str:
    """Room that a module lies in; empty for what lies elsewhere."""
    base = top.relative_to(PACKAGE.parent).parts
    if module[: len(base)] != base or len(module) == len(base):
        return ""
    room = module[len(base)]
    return room if top.joinpath(room).is_dir() else ""


def failures(found: dict[str, int], budgets: dict[str, int]) -> list[str]:
    """What is above its budget, far below it, or has none."""
    told = []
    for name in found.keys() | budgets.keys():
        count, budget = found.get(name), budgets.get(name)
        if count is None or budget is None:
            told.append(f"{name}: budgets and counts name different things")
        elif count > budget:
            told.append(f"{name}: {count} is above the budget of {budget}")
        elif count < budget * (1 - SLACK) - 1:
            told.append(f"{name}: {count} is below the budget of {budget}: write it")
    return sorted(told)


def main(arguments: list[str]) -> int:
    """Print counts and budgets; 1 where they do not fit."""
    found = counts()
    if arguments == ["--write"]:
        BUDGETS.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
    budgets = json.loads(BUDGETS.read_text(encoding="utf-8"))
    for name, count in found.items():
        print(f"{name:34s}{count:8d} of {budgets.get(name, 0):8d}")
    told = failures(found, budgets)
    print("\n".join(told), file=sys.stderr)
    return bool(told)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
