"""Lanes give the numbers of NumPy's arrays; vectors are as long as the processor has them."""

import os
import subprocess
import sys
from math import atan, exp, tanh

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from llvmlite.binding import get_host_cpu_features

import stickslip as ss
from stickslip.mechanics.eventmap import _lane_kernels as passes
from stickslip.mechanics.flow._lane_kernels import constants_at
from stickslip.numerics.targets import config, kernel, kernel_uncached
from stickslip.numerics.vector import (
    LANES,
    bits,
    from_bits,
    load,
    of_lanes,
    polynomial,
    select,
    store,
    wide_vectors,
    written,
)

# --- lanes --------------------------------------------------------------------------------------

ROWS = arrays(np.float64, (3, LANES), elements=st.floats(-1e100, 1e100))


@written
def write_operators(x, out, number):
    """Every operator on three rows of `x`, with a number on either side too."""
    a, b, c = load(x, 0), load(x, LANES), load(x, 2 * LANES)
    store(out, 0 * LANES, a + b)
    store(out, 1 * LANES, a - b)
    store(out, 2 * LANES, a * b)
    store(out, 3 * LANES, a / b)
    store(out, 4 * LANES, -a)
    store(out, 5 * LANES, abs(a))
    store(out, 6 * LANES, number + a)
    store(out, 7 * LANES, a - number)
    store(out, 8 * LANES, number / a)
    store(out, 9 * LANES, select(a < b, a, b))
    store(out, 10 * LANES, select(a <= number, 1.0, c))
    store(out, 11 * LANES, select((a > b) & (b >= c), b, 0.0))
    store(out, 12 * LANES, select(~(a > b) | (number == c), a, 3.0))
    store(out, 13 * LANES, from_bits(bits(a)))
    store(out, 14 * LANES, from_bits((bits(a) >> 52 | 2) + 1 << 3 & 255))
    store(out, 15 * LANES, number)
    store(out, 16 * LANES, of_lanes.exp(of_lanes.atan(b)) + of_lanes.pow(2.0, of_lanes.tanh(a)))


@kernel
def operators(x, out, number):
    write_operators(x, out, number)


def with_numpy(x, number):
    a, b, c = x
    whole = ((a.view(np.int64) >> 52 | 2) + 1 << 3) & 255
    rows = [a + b, a - b, a * b, a / b, -a, abs(a), number + a, a - number, number / a]
    rows += [np.where(a < b, a, b), np.where(a <= number, 1.0, c)]
    rows += [np.where((a > b) & (b >= c), b, 0.0), np.where(~(a > b) | (number == c), a, 3.0)]
    calls = [exp(atan(one)) + pow(2.0, tanh(other)) for one, other in zip(b, a, strict=True)]
    return np.array([*rows, a, whole.view(np.float64), np.full(LANES, number), calls])


@pytest.mark.kernel
@given(x=ROWS, number=st.floats(-1e3, 1e3))
def test_operators_give_the_bits_of_numpy(x, number):
    out = np.zeros((17, LANES))
    with np.errstate(all="ignore"):
        operators(x.ravel(), out.ravel(), number)
        expected = with_numpy(x, number)
    np.testing.assert_array_equal(out, expected)


@written
def write_recurrence(x, out, p):
    """Loops, lists and branches over what is known are written out: a reciprocal's series."""
    u = [1.0 / load(x, 0)]
    for k in range(1, 3):
        total = 0.0
        for j in range(k, 0, -1):
            total += load(x, j * LANES) * u[k - j]
        u.append(-total * u[0] * (p[1] if k == 2 else 1.0))
    store(out, 0, polynomial(p[0], *u[::-1]))


@kernel
def recurrence(x, out, p):
    write_recurrence(x, out, p)


@pytest.mark.kernel
@given(x=arrays(np.float64, (3, LANES), elements=st.floats(0.5, 4.0)))
def test_loops_are_written_out(x):
    out = np.zeros(LANES)
    recurrence(x.ravel(), out, np.array([0.5, 1.0]))
    series = np.array([np.ones(LANES), *np.zeros((2, LANES))])
    for k in range(3):
        series[k] = (series[k] - sum(x[j] * series[k - j] for j in range(1, k + 1))) / x[0]
    np.testing.assert_allclose(out, series[0] + 0.5 * series[1] + 0.25 * series[2], rtol=1e-12)


@pytest.mark.skipif(config.DISABLE_JIT, reason="arrays have no truth value either, but in NumPy")
def test_a_branch_on_lanes_is_refused():
    @written
    def branch(x):
        store(x, 0, 1.0 if load(x, 0) > 0.0 else 2.0)

    @kernel_uncached
    def branching(x):
        branch(x)

    with pytest.raises(TypeError, match="select"):
        branching(np.zeros(LANES))


@pytest.mark.kernel
def test_lanes_are_read_and_written_where_they_are_said_to_be():
    x = np.arange(3.0 * LANES)
    out = np.zeros_like(x)

    @written
    def write(x, out):
        store(out, 5, load(x, LANES))

    @kernel_uncached
    def moved(x, out):
        write(x, out)

    moved(x, out)
    np.testing.assert_array_equal(out[5 : 5 + LANES], x[LANES : 2 * LANES])
    assert np.count_nonzero(out) == LANES


# --- vectors ------------------------------------------------------------------------------------

reads_code = pytest.mark.skipif(
    config.DISABLE_JIT or not get_host_cpu_features().get("avx512f"),
    reason="reads machine code for AVX-512",
)


@kernel(fused=True)
def scaled(x, factor):
    wide_vectors()
    for k in range(x.size):
        x[k] = factor * x[k] + 1.0


def assembly_of(function, *arguments):
    compiled = kernel_uncached(function.py_func)
    compiled(*arguments)
    (assembly,) = compiled.inspect_asm().values()
    return assembly


@reads_code
def test_a_loop_over_an_array_uses_whole_vectors():
    x = np.arange(100.0)
    assembly = assembly_of(scaled, x, 2.0)
    assert assembly.count("%zmm") > 4
    np.testing.assert_array_equal(x, 2.0 * np.arange(100.0) + 1.0)


@reads_code
def test_a_pass_over_lanes_uses_whole_vectors():
    constants = constants_at(1.2, 1.3, 0.0366, 0.22, 0.22)
    streams = np.zeros((passes.N_STREAMS + len(passes.CONSTANTS)) * passes.STRIDE)
    carried = passes.Carried(constants, None, np.array(constants))
    assembly = assembly_of(passes.landing_pass, carried, streams, np.uint64(passes.LANES))
    assert assembly.count("%zmm") > 10 * assembly.count("%ymm")


@reads_code
def test_lanes_are_whole_vectors():
    @written
    def write(x, out):
        store(out, 0, load(x, 0) * load(x, LANES) + 1.0)

    @kernel(fused=True)
    def fused(x, out):
        wide_vectors()
        write(x, out)

    x, out = np.arange(2.0 * LANES), np.zeros(LANES)
    assembly = assembly_of(fused, x, out)
    assert assembly.count("%zmm") > 4
    assert "vfmadd" in assembly
    np.testing.assert_array_equal(out, x[:LANES] * x[LANES:] + 1.0)


@pytest.mark.parametrize(("name", "lanes"), [("x86-64-v4", 8), ("x86-64-v3", 4), ("generic", 4)])
def test_lanes_fit_the_processor_that_kernels_are_made_for(name, lanes):
    """With vectors twice as wide as the processor's a few motions took twice as long."""
    command = [sys.executable, "-c", "from stickslip.numerics.vector import LANES; print(LANES)"]
    made_for = {**os.environ, "NUMBA_CPU_NAME": name, "NUMBA_CPU_FEATURES": ""}
    told = subprocess.run(command, env=made_for, check=True, stdout=subprocess.PIPE)
    assert int(told.stdout) == lanes


@pytest.mark.kernel
def test_kernels_of_another_width_are_others():
    """A processor of the higher level may find kernels that were prepared for the lower one."""
    backend = ss.event_map(ss.examples.law9())._backend
    for module in (backend._driver, backend._steps):
        assert f"-{LANES}" in module.__name__
