"""Kernels are typed once, and linked, optimised and emitted once for each that Python calls."""

from typing import Any

import llvmlite.binding as llvm
import numba
import numpy as np
import pytest

from stickslip.numerics.linking import Kernel
from stickslip.numerics.targets import config, kernel, kernel_uncached

pytestmark = pytest.mark.skipif(bool(config.DISABLE_JIT), reason="nothing is compiled")


def tower() -> list[Kernel]:
    """Kernels, each but the first of which calls the one before it and the first."""

    @kernel_uncached
    def first(x):
        return 0.1 * x + min(x, 3.0)

    @kernel_uncached
    def second(x):
        return first(x) - 0.3 * x

    @kernel_uncached
    def third(x):
        return second(x) * first(x)

    return [first, second, third]


def test_what_python_calls_is_emitted_and_nothing_else():
    first, second, third = tower()
    assert third(2.0) == pytest.approx(1.6 * 2.2, rel=1e-15)
    assert len(third.overloads) == 1
    assert not second.overloads
    assert not first.overloads
    assert [len(each.part.overloads) for each in (first, second, third)] == [1, 1, 1]
    part = first.part.overloads[(numba.float64,)]
    assert second(2.0) == pytest.approx(1.6, rel=1e-15)
    assert first.part.overloads[(numba.float64,)] is part
    assert first(2.0) == 2.2
    assert first(2) == 2.2  # another signature
    assert len(first.part.overloads) == 2


def test_what_is_kept_of_machine_code_is_itself_and_its_names():
    *_, third = tower()
    third(2.0)
    (made,) = third.overloads.values()
    _, kind, (code, names) = made.library.serialize_using_object_code()
    assert kind == "object"
    module = llvm.parse_bitcode(names)
    assert made.fndesc.llvm_cpython_wrapper_name in {each.name for each in module.functions}
    assert all(
        len(list(each.blocks)) == 1 for each in module.functions
    )  # none of the kernels' code
    assert len(names) < len(code)


def test_machine_code_shares_nothing_but_its_name():
    *_, third = tower()
    third(2.0)
    (made,) = third.overloads.values()
    shared = [
        function.name
        for function in made.library.get_defined_functions()
        if function.linkage.name != "internal"
    ]
    assert shared == [made.fndesc.llvm_cpython_wrapper_name]


def test_an_error_of_typing_is_told_as_numba_tells_it():
    @kernel
    def wrong(x):
        return x.no_such_thing

    for _ in range(2):
        with pytest.raises(numba.TypingError, match="no_such_thing"):
            wrong(1.0)


def test_short_loops_are_no_vectors_and_do_the_same():
    def scaled(x):
        for i in range(x.shape[0]):
            x[i] = 0.1 * x[i]

    codes = []
    for short_loops in (False, True):
        made: Any = kernel(short_loops=short_loops)(scaled)
        x = np.arange(37.0)
        made(x)
        assert (x == 0.1 * np.arange(37.0)).all()
        (code,) = made.overloads.values()
        codes.append(code.library.get_llvm_str())
    assert "x double>" in codes[0]
    assert "x double>" not in codes[1]
