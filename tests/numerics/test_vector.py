"""What kernels say to the compiler: how long vectors are."""

import numpy as np
import pytest
from llvmlite.binding import get_host_cpu_features

from stickslip.mechanics.eventmap import _lane_passes_kernels as passes
from stickslip.mechanics.flow._lane_kernels import plant_at
from stickslip.numerics.targets import config, kernel, kernel_uncached
from stickslip.numerics.vector import wide_vectors

pytestmark = [
    pytest.mark.skipif(config.DISABLE_JIT, reason="reads machine code"),
    pytest.mark.skipif(
        not get_host_cpu_features().get("avx512f"), reason="the processor has no AVX-512"
    ),
]


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


def test_a_loop_over_an_array_uses_whole_vectors():
    x = np.arange(100.0)
    assembly = assembly_of(scaled, x, 2.0)
    assert assembly.count("%zmm") > 4
    np.testing.assert_array_equal(x, 2.0 * np.arange(100.0) + 1.0)


def test_a_pass_over_lanes_uses_whole_vectors():
    plant = plant_at(1.2, 1.3, 0.0366, 0.22, 0.22)
    streams = np.zeros((passes.N_STREAMS + len(passes.PLANT)) * passes.STRIDE)
    assembly = assembly_of(
        passes.landing_pass, plant, np.array(plant), streams, np.uint64(passes.LANES)
    )
    assert assembly.count("%zmm") > 10 * assembly.count("%ymm")
