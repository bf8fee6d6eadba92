"""The event map on a GPU; without one, on numba's simulator, in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import fields

import numpy as np
import pytest

import stickslip as ss
from stickslip.numerics.gpu import require_gpu

SIMULATED = os.environ.get("NUMBA_ENABLE_CUDASIM") == "1"


def has_gpu() -> bool:
    try:
        require_gpu()
    except ValueError:
        return False
    return True


on_gpu = pytest.mark.skipif(not has_gpu(), reason="no GPU here; the simulator runs it below")
# A finite limit of time has the CPU carry motions one at a time, by the kernels that a GPU runs.
ALONE = {"max_time": 1e300}
TABLE = ss.TabulatedFriction([0, 0.05, 0.2, 0.5, 1.5], [1, 0.7, 0.45, 0.4, 0.55])
MODELS = {
    "coulomb": (ss.examples.coulomb(), 60),
    "law9": (ss.examples.law9(), 2),
    "table": (ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=TABLE), 2),
}


@pytest.mark.cuda
@on_gpu
@pytest.mark.parametrize("name", MODELS)
def test_values_are_those_of_the_cpu(name: str) -> None:
    """Bit for bit on the simulator; a GPU fuses products elsewhere, which costs a rounding.

    Taylor steps in pools, which a CPU takes for law (9), have other lengths.
    """
    model, n = MODELS[name]
    here, there = ss.event_map(model, **ALONE), ss.event_map(model, device="cuda")
    d = model.sample_domain(n if SIMULATED else 4 * n, 3)
    expected, found = here.evaluate(d), there.evaluate(d)
    clear = expected.margin > 1e-9
    assert clear.mean() > 0.9
    tolerance = 0.0 if SIMULATED and name == "coulomb" else 1e-12
    for field in fields(expected):
        a, b = getattr(expected, field.name)[clear], getattr(found, field.name)[clear]
        np.testing.assert_allclose(b, a, rtol=tolerance, atol=tolerance, err_msg=field.name)
    np.testing.assert_allclose(there(d[clear]), expected.value[clear], rtol=0, atol=tolerance)
    slope = here.parameter_derivative(d[clear], "V")
    np.testing.assert_allclose(there.parameter_derivative(d[clear], "V"), slope, rtol=tolerance)
    assert there.itinerary(d[0]) == here.itinerary(d[0])


@pytest.mark.cuda
@on_gpu
def test_orbits_and_exponents_are_those_of_the_cpu() -> None:
    model = ss.examples.coulomb()
    here, there = ss.event_map(model, **ALONE), ss.event_map(model, device="cuda")
    d = [0.1, -0.2]
    tolerance = 0.0 if SIMULATED else 1e-12
    np.testing.assert_allclose(there.iterate(d, 20), here.iterate(d, 20), rtol=0, atol=tolerance)
    expected = ss.lyapunov_exponent(here, 0.1, 50, transient=50)
    found = ss.lyapunov_exponent(there, 0.1, 50, transient=50)
    assert found.value == pytest.approx(expected.value, abs=1e-10)


@pytest.mark.cuda
@on_gpu
def test_what_only_the_cpu_carries() -> None:
    with pytest.raises(ValueError, match="without damping"):
        ss.event_map(ss.examples.coulomb().replace(damping=0.1), device="cuda")

    def force(s: float, a: float) -> float:
        return 0.5 if s < a else 0.4

    law = ss.friction_law(force, parameters={"a": 0.1}, slope=lambda s, a: 0.0)
    with pytest.raises(ValueError, match="can be traced"):
        ss.event_map(ss.examples.coulomb().replace(friction=law), device="cuda")


@pytest.mark.skipif(SIMULATED or has_gpu(), reason="there is a GPU")
def test_without_a_gpu_the_error_says_what_is_missing() -> None:
    with pytest.raises(ValueError, match=r"device = 'cuda' needs an NVIDIA GPU.*device='cpu'"):
        ss.event_map(ss.examples.coulomb(), device="cuda")
    chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.22))
    with pytest.raises(ValueError, match="carries two equal blocks"):
        ss.event_map(chain, device="cuda")


@pytest.mark.skipif(SIMULATED, reason="this is that process")
def test_on_the_simulator() -> None:
    """Numba decides for the simulator as it is imported, hence another process."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "cuda"]
    result = subprocess.run(
        [*command, "-p", "no:xdist", __file__],
        env={**os.environ, "NUMBA_ENABLE_CUDASIM": "1"},
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert f"{len(MODELS) + 2} passed" in result.stdout


def test_packages_that_do_not_fit_are_a_named_cause(monkeypatch: pytest.MonkeyPatch) -> None:
    """numba-cuda 0.30 beside NumPy 2.5: the first use raises AttributeError."""

    def missing() -> bool:
        raise AttributeError("module 'numpy' has no attribute 'row_stack'")

    monkeypatch.setattr("numba.cuda.is_available", missing)
    with pytest.raises(ValueError, match=r"numba-cuda gave AttributeError.*row_stack"):
        require_gpu()
