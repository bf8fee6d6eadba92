"""Loops written out: the same numbers as the loops, in straight lines."""

import ast

import numpy as np
import pytest

from stickslip.numerics.unrolling import unrolled

# The reciprocal of a series, as a law's text has it: sums over j inside a loop over k.
RECIPROCAL = """
u[0] = 1.0 / p[0]
for k in range(1, N):
    total = 0.0
    for j in range(k, 0, -1):
        total += x[source + j] * u[k - j]
    if k % 2 == 0:
        even = total
    u[k] = -total * u[0]
    x[target + k] = u[k]
"""
N = 7


def in_plain_python(*factors):
    return sum(a * b for a, b in zip(factors[::2], factors[1::2], strict=True))


def test_written_out_recurrences_give_the_numbers_of_the_loops():
    rng = np.random.default_rng(1)
    p, x = rng.uniform(0.5, 2, 1), rng.normal(size=2 * N)
    names = {"N": N, "source": 0, "target": N}
    looped, straight = x.copy(), x.copy()
    exec(RECIPROCAL, {"p": p, "x": looped, "u": np.zeros(N), **names})
    lines = unrolled(RECIPROCAL, names, local=("u",), fixed=("p",))
    exec("\n".join(lines), {"products": in_plain_python, "x": straight, "p_0": p[0]})
    np.testing.assert_allclose(straight, looped, rtol=1e-14)
    assert looped[N + 1] != x[N + 1]


def test_what_is_left_is_assignments_of_new_names_that_are_read():
    lines = unrolled(RECIPROCAL, {"N": N, "source": 0, "target": N}, ("u",), ("p",))
    statements = [ast.parse(line).body[0] for line in lines]
    assert all(isinstance(statement, ast.Assign) for statement in statements)
    names = [s.targets[0].id for s in statements if isinstance(s.targets[0], ast.Name)]
    assert len(set(names)) == len(names)
    assert not any("even" in name for name in names)  # nobody reads it
    # one statement for a sum of products, however long
    assert max(line.count(",") for line in lines) == 2 * (N - 1) - 1


def test_calls_stand_where_they_are_and_keep_what_they_read():
    text = "a = p[0] * p[0] + 1.0\nb = a + 2.0\nfor k in range(2):\n    put(x, k, a)"
    assert unrolled(text, {}, (), ("p",)) == [
        "a_v0 = p_0 * p_0 + 1.0",
        "put(x, 0, a_v0)",
        "put(x, 1, a_v0)",
    ]


@pytest.mark.parametrize(
    "text", ["while x[0]:\n    x[0] = 1", "if x[0] > 0:\n    y = 1", "a = u[x[0]]", "a = u[3]"]
)
def test_what_cannot_be_written_out_is_refused(text):
    with pytest.raises(ValueError, match=r"cannot write out|not known|used before"):
        unrolled(text, {}, local=("u",))
