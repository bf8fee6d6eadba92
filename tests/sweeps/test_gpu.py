"""Sweeps on a GPU; without one, on numba's simulator, in a process of its own."""

import os
import subprocess
import sys

import numpy as np
import pytest
from tests.mechanics.eventmap.test_cuda import SIMULATED, has_gpu, on_gpu
from tests.sweeps import small

import stickslip as ss
from stickslip.errors import StoreRefused

pytest.importorskip("zarr")

RUN = {"transient": 4, "n": 8, "max_period": 2}
AXES = {"V": (0.03, 0.3, 3), "alpha": [1.1, 1.3], "mu": [0.1, 0.22]}


def run(store, **more):
    kinds = (ss.observables.Attractor, ss.observables.LyapunovExponent, ss.observables.Events)
    wanted = [*(kind(**RUN) for kind in kinds), ss.observables.OrbitPoints(**RUN, count=3)]
    return ss.sweep(ss.examples.coulomb(), AXES, wanted, store=store, threads=1, **more)


@pytest.mark.cuda
@on_gpu
def test_values_are_those_of_the_cpu(tmp_path):
    there, here = run(tmp_path / "gpu", device="cuda"), run(tmp_path / "cpu")
    assert there.attrs["target"]["device"] == "cuda"
    for name in here.data_vars:
        a, b = there[name].values, here[name].values
        np.testing.assert_allclose(a, b, rtol=1e-9, atol=1e-11, err_msg=name)


@pytest.mark.cuda
@on_gpu
def test_a_store_is_of_one_device(tmp_path):
    run(tmp_path / "gpu", device="cuda")
    with pytest.raises(StoreRefused, match="device cuda there, cpu here"):
        run(tmp_path / "gpu")


@pytest.mark.cuda
@on_gpu
def test_a_start_outside_the_domain_is_data(tmp_path):
    wanted = [ss.observables.Attractor(**RUN), ss.observables.LyapunovExponent(**RUN)]
    found = ss.sweep(
        ss.examples.coulomb(),
        {"d": [-5.0, 0.1]},
        wanted,
        store=tmp_path / "x",
        device="cuda",
    )
    assert found.status.values.tolist() == [-2, 0]
    assert found.kind.values[0] == 0
    assert np.isnan(found.lyapunov_exponent.values[0])


@pytest.mark.cuda
@on_gpu
def test_what_a_gpu_does_not_do_is_refused(tmp_path):
    model, store = ss.examples.coulomb(), tmp_path / "x"
    for system, wanted, words in (
        (model, "limit_cycles", "observable 'limit_cycles' is computed on the CPU"),
        (model.replace(damping=0.1), "attractor", "without damping"),
        (ss.PiecewiseMap(small.tent, (0, 1), parameters={"s": 1.0}), "attractor", "two undamped"),
    ):
        parameter = next(iter(system.parameters))
        with pytest.raises(ValueError, match=words):
            ss.sweep(system, {parameter: [0.1]}, [wanted], store=store, device="cuda")
    assert not store.exists()


@pytest.mark.skipif(SIMULATED or has_gpu(), reason="there is a GPU")
def test_without_a_gpu_the_error_says_what_is_missing(tmp_path):
    with pytest.raises(ValueError, match=r"device = 'cuda' needs an NVIDIA GPU.*device='cpu'"):
        run(tmp_path / "x", device="cuda")
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(SIMULATED, reason="this is that process")
def test_on_the_simulator():
    """Numba decides for the simulator as it is imported, hence another process.

    The simulator gives its own arrays to the CPU's loop over orbits, which runs as Python.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-m", "cuda"]
    result = subprocess.run(
        [*command, "-p", "no:xdist", __file__],
        env={**os.environ, "NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert result.returncode == 0, result.stdout + result.stderr
    assert "4 passed" in result.stdout
