"""What may come of a call: a result, or an error that names the parameter and what was given."""

from __future__ import annotations

import time
import traceback
import warnings
from pathlib import Path
from typing import Any, Final

import numpy as np
from tests.fuzz.calls import Call

import stickslip as ss
from stickslip.status import OK

PACKAGE: Final = Path(ss.__file__).parent
LONGEST: Final = 900
"""Characters of a message."""
SECONDS: Final = 60.0
"""Of processor time, for one call: compilation included."""

FILES: Final = ("path", "store")
"""Parameters whose errors are those of the system."""
SAY: Final = {
    # A value that is legal by itself and does not fit the rest of the call is told by the rest.
    "model": ("x = ", "friction", "damping", "kind", "law"),
    "system": ("axis", "parameter", "orbit", "breakpoint", "range"),
    "f": ("attractor",),
    "range": ("V = ", "r = ", "damping = ", "mu_", "alpha"),
    "name": ("parameter",),
    "parameter": ("parameter",),
    "axes": ("axis",),
    "values": ("V = ", "r = ", "mu", "gamma", "parameter"),
    "friction": ("friction", "law"),
    "force": ("friction law",),
    "forward": ("friction law",),
    "slope": ("friction law",),
    "parameters": ("parameter", "func", "spam"),
    "parameter_derivative": ("parameter",),
    "client": ("threads",),
    "k": ("alpha",),
    "fs1": ("beta",),
    "static": ("static", "friction"),
    "mass": ("mass", "stiffness", "friction", "static"),
    "until": ("t_end",),
    "kinds": ("kind",),
    "x": ("d=",),
    "d": ("x",),
    "max_periods": ("periods",),
    "max_events": ("max_events", "events"),
    "breakpoint_": ("breakpoint",),
    "orbit": ("orbit", "coordinates"),
    "found": ("attractor", "certified"),
    "given": ("observables",),
    "function": ("imported",),
}


def complaint(call: Call, name: str, value: Any) -> str | None:
    """Call with one argument replaced; say what is wrong with what comes of it, if anything is."""
    began = time.process_time()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            result = call({name: value})
    except Exception as error:
        # What a function of the caller's own says of its arguments is the caller's.
        own = name == "progress" and callable(value)
        return None if own else _of_error(name, error)
    took = time.process_time() - began
    return f"took {took:.0f} s" if took > SECONDS else _of_result(result)


def _of_error(name: str, error: Exception) -> str | None:
    said = f"{type(error).__name__}: {error}"
    if name in FILES and isinstance(error, OSError | TypeError):
        return None
    if not isinstance(error, ValueError | TypeError):
        return f"{said} [{_where(error)}]"
    if not _ours(error):
        return f"raised by another package: {said} [{_where(error)}]"
    if not any(word in str(error) for word in (name, *SAY.get(name, ()))):
        return f"does not name {name}: {said}"
    return f"too long: {said}" if len(said) > LONGEST else None


def _ours(error: Exception) -> bool:
    return PACKAGE in Path(traceback.extract_tb(error.__traceback__)[-1].filename).parents


def _where(error: Exception) -> str:
    frames = [f for f in traceback.extract_tb(error.__traceback__) if "/stickslip/" in f.filename]
    return f"{frames[-1].filename}:{frames[-1].lineno}" if frames else "outside"


def _of_result(result: Any) -> str | None:
    """NaN goes with a status, and a status with NaN."""
    value, status = getattr(result, "value", None), getattr(result, "status", None)
    if isinstance(value, np.ndarray) and isinstance(status, np.ndarray):
        missing = np.isnan(value) if value.ndim == status.ndim else np.isnan(value).any(axis=-1)
        if not np.array_equal(missing, status != OK):
            return "NaN without a status, or a status without NaN"
    return None
