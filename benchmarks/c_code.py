"""C programs of the project's own, compiled when they are timed."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import stickslip as ss

FOLDER = Path(__file__).parent / "c"
COMPILER = shutil.which("gcc") or shutil.which("cc")
# What one would give by hand for speed; NaN must stay NaN.
FLAGS = ("-O3", "-march=native", "-ffast-math", "-fno-finite-math-only", "-shared", "-fPIC")
Floats = NDArray[np.float64]


@cache
def library(name: str) -> ctypes.CDLL:
    """Compile ``c/<name>.c`` and load it."""
    assert COMPILER is not None
    folder = Path(tempfile.mkdtemp(prefix="stickslip-benchmarks-"))
    target = folder / f"{name}.so"
    command = [COMPILER, *FLAGS, "-o", str(target), str(FOLDER / f"{name}.c"), "-lm"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(target))


def map_in_c(model: ss.TwoBlock | ss.Blocks) -> Callable[[Floats], Floats]:
    """Event map of two undamped blocks with Coulomb friction or law (9), the same for both."""
    plant, (law, _) = model.plant, model.laws
    numbers = np.append(plant.stiffness / plant.mass[:, None], plant.static / plant.mass)
    name = "coulomb" if isinstance(law, ss.Coulomb) else "law9"
    parameters = np.array([one.mu for one in model.laws] if name == "coulomb"
                          else [law.gamma, law.delta, law.eta])  # fmt: skip

    def by(d: Floats) -> Floats:
        d = np.ascontiguousarray(d, dtype=np.float64)
        out, events = np.empty_like(d), np.empty(d.size, dtype=np.int32)
        arrays = (d, out, events) if name == "coulomb" else (d, out)
        pointers = [ctypes.c_void_p(array.ctypes.data) for array in (*arrays, numbers, parameters)]
        last = pointers.pop()
        function = getattr(library(name), name)
        function(ctypes.c_long(d.size), *pointers, ctypes.c_double(model.V), last)
        return out

    return by
