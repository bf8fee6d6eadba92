"""Kernels call functions that they were not compiled with."""

import gc

import numpy as np
import pytest

from stickslip.numerics.by_address import address_of, call_at
from stickslip.numerics.targets import kernel


@kernel
def applied(where, x):
    return call_at(where[0], x, 2.0) + call_at(where[1], x, 3.0)


def place(function):
    return address_of(function, 2)


@pytest.mark.kernel
def test_one_kernel_calls_one_function_and_another():
    power, product = place(lambda x, a: x**a), place(lambda x, a: x * a)
    gc.collect()
    assert applied(np.array([power, product]), 5.0) == 25.0 + 15.0
    assert applied(np.array([product, power]), 5.0) == 10.0 + 125.0
    assert applied(np.array([power, power]), 5.0) == 25.0 + 125.0


@pytest.mark.kernel
def test_a_function_has_one_address():
    def function(x, a):
        return x - a

    assert place(function) == place(function)


def careful(x, a):
    if x > 4.0:
        raise ValueError("too large")
    return x + a


@pytest.mark.kernel
def test_what_it_raises_arrives():
    where = np.full(2, place(careful))
    assert applied(where, 1.0) == 7.0
    for _ in range(3):
        with pytest.raises(ValueError, match="too large"):
            applied(where, 5.0)
    assert applied(where, 2.0) == 9.0
