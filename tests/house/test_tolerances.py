"""Tests allow what they say: numpy adds a relative tolerance of 1e-7 that nobody asked for."""

import ast
from pathlib import Path

TESTS = Path(__file__).resolve().parents[1]
COMPARISONS = {"assert_allclose", "allclose", "isclose"}


def called(call):
    """Name of the function, without the module it is looked up in."""
    return getattr(call.func, "attr", None) or getattr(call.func, "id", None)


def silent(path):
    """Comparisons of a file whose relative tolerance is left to numpy."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Call) and called(node) in COMPARISONS:
            named = {keyword.arg for keyword in node.keywords}
            if "rtol" not in named and len(node.args) < 3:
                yield f"{path.relative_to(TESTS)}:{node.lineno}"


def test_every_comparison_names_its_relative_tolerance():
    found = [place for path in sorted(TESTS.rglob("*.py")) for place in silent(path)]
    assert found == []
