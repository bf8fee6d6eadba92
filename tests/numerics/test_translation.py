"""Kernels are translated straight from their text, and do what Python does."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numba.core import types

from stickslip.numerics import linking
from stickslip.numerics.targets import config, kernel_uncached, write_module
from stickslip.numerics.translation.values import NotUnderstood

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")

LIMIT = 3
TABLE = (np.uint64(2), np.uint64(0), np.uint64(1))
WEIGHTS = np.array([0.5, -2.0, 8.0])


class Pair(NamedTuple):
    """Something of two fields."""

    low: float
    rows: Any


@pytest.fixture
def left_to_numba(monkeypatch):
    """Names of kernels that were not understood, as they come."""
    names = []

    def noted(function, state, called):
        try:
            return translate(function, state, called)
        except NotUnderstood:
            names.append(function.__name__)
            raise

    translate = linking.translate
    monkeypatch.setattr(linking, "translate", noted)
    return names


def loops(x, n):
    total = 0
    for i in range(6 * n):
        if i == LIMIT:
            continue
        if i > 1 and x[i] > 0.0:
            break
        total += x[i] * (2 if i < 5 else x[i - 1] / 3)
    k = 0
    while k < n:
        total -= x[-k]
        k += 2
    for k in range(5 * n - 1, -1, -1):
        total *= 1.5 if x[k] > 0 or (x[0] > 0.5 and not x[1] > 0.5) else 0.5
    for sign in (-1.0, 1.0):
        if total * sign > 0.0:
            total += sign
    return total, k


def numbers(x, n):
    whole = n // 3 + n % 5 + (n << 2) + (n >> 1) - (n & 6)
    small = -n if n > 2 else n
    larger = max(x[0], n, -1.0)
    least, most = (larger, x[1]) if x[1] > larger else (x[1], larger)
    truth = (n > 1 and x[n] < x[0]) or n == 0
    return whole, small / 4, abs(least) * math.copysign(1.0, most), truth, 0.0 < x[2] < 1.0


def arrays(x, n):
    table = np.uint64(0)
    rows = x.reshape(3, 4)
    rows[1, 2] += 1.0
    rows[-1] = 0.25
    first, second = rows[0, :2]
    for place in TABLE:
        table = table * np.uint64(5) + place
    return rows[n, 1] - first / second + rows.shape[1] + rows.ndim + x.size, table, WEIGHTS[n]


def forever(x, n):
    while True:
        n += 1
        if x[n] > 0.2:
            return n
        if n > 8:
            return -1


def nothing(x, n):
    _, here = n, x[0]
    _ = x
    if here < 0.0:
        return


SAME = [loops, numbers, arrays, forever, nothing]


@pytest.mark.parametrize("function", SAME, ids=lambda each: each.__name__)
@pytest.mark.parametrize("n", [0, 1, 2])
def test_a_kernel_does_what_python_does(function, n):
    x = np.random.default_rng(n).uniform(-1.0, 1.0, 12)
    expected = function(x.copy(), n)
    assert kernel_uncached(function)(x.copy(), n) == expected


@pytest.mark.parametrize("function", [loops, forever, nothing], ids=lambda each: each.__name__)
def test_simple_kernels_are_understood(function, left_to_numba):
    kernel_uncached(function)(np.ones(12), 2)
    assert not left_to_numba


def test_types_are_those_of_numba(left_to_numba):
    def of_kinds(flag, mode, x):
        first = mode if flag else 2  # of eight bits, or of 64
        second = 1
        if flag:
            second = x
        late = 0
        for _ in range(3):
            late += x
        return -first, second, late, mode * mode, np.uint64(3) + np.uint64(mode)

    arguments = types.boolean, types.int8, types.float64
    translated = kernel_uncached(of_kinds).lowered(arguments).signature
    assert not left_to_numba
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linking, "translate", refused)
        assert kernel_uncached(of_kinds).lowered(arguments).signature == translated


def refused(function, state, called):
    raise NotUnderstood("by intent")


def test_tuples_choices_and_absent_parts(left_to_numba):
    @kernel_uncached
    def made(x, rows):
        return Pair(x, rows)

    @kernel_uncached
    def least(x, y):
        return min(x, y)

    @kernel_uncached
    def read(pair, x):
        if pair.rows is None:
            return pair.low
        low, rows = pair
        total = low if rows.ndim == 1 else math.nan
        for k in range(len(rows)):
            total += rows[k]
        other = pair if x > 0.0 else Pair(x, rows)
        return total + least(*(total, other.low))

    @kernel_uncached
    def both(x, rows):
        return read(made(x, rows), x), read(made(x, None), x)

    assert both(2.0, np.ones(3)) == (7.0, 2.0)
    assert both(-2.0, np.ones(3)) == (-1.0, -2.0)
    assert not left_to_numba


def test_what_is_not_understood_is_left_to_numba(left_to_numba):
    @kernel_uncached
    def powers(x):
        return x**3

    @kernel_uncached
    def factorial(n):
        if n < 2:
            return 1
        return n * factorial(n - 1)

    assert powers(3.0) == 27.0
    assert factorial(5) == 120
    assert left_to_numba == ["powers", "factorial"]


def described(pair, nothing, flags, rest):
    """All that is known of arrays, after they went through a tuple."""
    total = pair.rows[0, 1] + pair.low
    for i in range(pair.rows.shape[0]):
        for k in range(pair.rows.shape[1]):
            total = 2.0 * total + pair.rows[i, k]
    part = pair.rows[1:, 1]
    whole = pair.rows[1]
    return total, pair.rows.size, part[-1], whole[-1], part.size, nothing is None and flags[1], rest


def through_names(pair, other, nothing, flags):
    """Names of several tuples, one after the other and by turns."""
    current, scale = pair, (1.0, 2)
    result = described(current, nothing, flags, ())[0]
    for i in range(3):
        if i == 1:
            current = other
            scale = (3.5, i)
        elif i == 2:
            current = Pair(current.low + scale[0], current.rows)
        chosen = pair if i == 0 else current
        found = described(chosen, nothing, flags, scale)
        result += found[0] * scale[0] + found[1] + found[2] + found[6][1]
    return result, described(current, nothing, flags, ())[0]


@pytest.mark.parametrize("both", [False, True])
@pytest.mark.parametrize(
    "rows",
    [
        np.arange(12.0).reshape(3, 4),
        np.asfortranarray(np.arange(12.0).reshape(3, 4)),
        np.arange(48.0).reshape(6, 8)[::2, 1::2],
        np.arange(6, dtype=np.int8).reshape(2, 3),
    ],
    ids=["C", "F", "A", "bytes"],
)
def test_arrays_and_tuples_arrive_as_they_were_sent(both, rows, left_to_numba, monkeypatch):
    flags = np.array([False, True])
    arguments = Pair(0.5, rows), Pair(-2.0, rows), None, flags
    kernel = kernel_uncached(through_names)
    expected = through_names(*arguments)
    monkeypatch.setitem(through_names.__globals__, "described", kernel_uncached(described))
    if both:  # one of the two by numba
        taken = linking.translate

        def refused(function, *given):
            if function is described:
                raise NotUnderstood("for the test")
            return taken(function, *given)

        monkeypatch.setattr(linking, "translate", refused)
    assert kernel(*arguments) == expected
    assert not left_to_numba


def test_numba_calls_what_is_translated(left_to_numba, monkeypatch):
    @kernel_uncached
    def inside(pair, flag):
        return (pair.rows[1], pair.low) if flag else (0.0, pair.low)

    @kernel_uncached
    def outside(pair, n):
        found = inside(pair, n > 2)
        return found[0] + found[1] ** n

    pair = Pair(3.0, np.array([1.0, 5.0]))
    assert outside(pair, 3) == 32.0
    assert outside(pair, 2) == 9.0
    assert left_to_numba == ["outside"]


def test_squares_and_powers(left_to_numba):
    @kernel_uncached
    def powers(x, y):
        return x**2, x ** (1.0 / 3.0), x**y

    assert powers(1.1, 0.3) == (1.1 * 1.1, 1.1 ** (1.0 / 3.0), 1.1**0.3)
    assert not left_to_numba


def test_generated_kernels_are_understood(left_to_numba):
    text = (
        "from stickslip.numerics.targets import kernel\n"
        "@kernel(inline=True)\n"
        "def doubled(x: float) -> float:\n"
        "    return 2.0 * x + OFFSET\n"
        "OFFSET = 0.5\n"
    )
    module = write_module("tests", text)

    @kernel_uncached
    def caller(x):
        return module_doubled(x)

    module_doubled = module.doubled
    assert caller(2.0) == 4.5
    assert not left_to_numba
