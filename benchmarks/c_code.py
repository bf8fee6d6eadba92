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
COULOMB = ("alpha", "beta", "mu", "V")
LAW_9 = ("alpha", "beta", "V", "gamma", "delta", "eta")

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


def coulomb_map(d: Floats, *parameters: float) -> Floats:
    """Event map by ``coulomb.c``; parameters as in `COULOMB`."""
    d = np.ascontiguousarray(d, dtype=np.float64)
    out, events = np.empty_like(d), np.empty(d.size, dtype=np.int32)
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (d, out, events))
    library("coulomb").coulomb_map(
        ctypes.c_long(d.size), *pointers, *map(ctypes.c_double, parameters)
    )
    return out


def law9_map(d: Floats, *parameters: float) -> Floats:
    """Event map by ``law9.c``; parameters as in `LAW_9`."""
    d = np.ascontiguousarray(d, dtype=np.float64)
    out = np.empty_like(d)
    pointers = (ctypes.c_void_p(array.ctypes.data) for array in (d, out))
    library("law9").law9(ctypes.c_long(d.size), *pointers, *map(ctypes.c_double, parameters))
    return out


def map_in_c(model: ss.TwoBlock) -> Callable[[Floats], Floats]:
    """Event map of a model with Coulomb friction or law (9)."""
    p = model.parameters
    by, names = (coulomb_map, COULOMB) if "mu" in p else (law9_map, LAW_9)
    numbers = [float(p[name]) for name in names]
    return lambda d: by(d, *numbers)
