"""What a function, a system or a machine is, in values that a store can keep and compare."""

from __future__ import annotations

import hashlib
import importlib
import inspect
import json
import platform
from functools import cache
from typing import TYPE_CHECKING, Any

from llvmlite import binding

from stickslip.analysis.maps.formulas import Formulas
from stickslip.checks import shown
from stickslip.numerics.gpu import gpu_name
from stickslip.numerics.kernel_cache import source_hash
from stickslip.numerics.targets import config

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.mechanics.friction.law import FrictionLaw


def digest(content: Any) -> str:
    """Hash of values that JSON can hold, or of bytes."""
    if not isinstance(content, bytes):
        content = json.dumps(content, sort_keys=True, allow_nan=False).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def function_identity(function: Callable[..., Any]) -> dict[str, Any]:
    """Describe a function by its name, its text and the numbers and words it takes from outside."""
    if isinstance(function, Formulas):
        return {"formulas": function.__name__}
    name = f"{getattr(function, '__module__', '?')}:{getattr(function, '__qualname__', '?')}"
    function = getattr(function, "py_func", function)  # compiled by numba
    try:
        text = inspect.getsource(function)
        outside = inspect.getclosurevars(function)
        given = inspect.signature(function).parameters.values()
    except (OSError, TypeError) as error:
        raise ValueError(
            f"{function!r} cannot be recorded in a store: its source text is not to be had. "
            "Write it as a function in a module."
        ) from error
    defaults = {each.name: each.default for each in given if each.default is not each.empty}
    own = {"self": function.__self__} if inspect.ismethod(function) else {}
    closure = {**outside.nonlocals, **defaults, **own}
    for variable, value in closure.items():
        if not isinstance(value, int | float | str | None):
            raise ValueError(
                f"{name} depends on {variable} = {value!r} of the place where it was made, which "
                "a store cannot record. Write it as a function in a module."
            )
    plain = {key: v for key, v in outside.globals.items() if isinstance(v, int | float | str)}
    taken = {variable: repr(value) for variable, value in (plain | closure).items()}
    return {"function": name, "text": digest(text.encode()), "closure": taken}


def law_identity(law: FrictionLaw) -> dict[str, Any]:
    """Describe a friction law but for its parameters: its formula, the pieces of a table."""
    formula: Any = law.formula
    if law.traceable:
        traced = (formula.nodes, formula.backward, formula.forward, law.pieces[:-1])
        return {"formula": digest(repr(traced).encode())}
    parts = {"backward": formula.backward, "forward": formula.forward, "slope": formula.slope}
    return {
        role: function_identity(user.function) for role, user in parts.items() if user is not None
    }


def import_function(name: str) -> Any:
    """Import what ``module:name`` names."""
    module, _, qualname = name.partition(":")
    try:
        found: Any = importlib.import_module(module)
        for part in qualname.split("."):
            found = getattr(found, part)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(
            f"{shown(name)} cannot be imported: {shown(str(error))}. Write 'module:name', with the "
            "module where Python finds it (PYTHONPATH)."
        ) from error
    return found


@cache
def _cpu() -> dict[str, str]:
    name = config.CPU_NAME or binding.get_host_cpu_name()
    features = config.CPU_FEATURES
    if features is None:
        features = binding.get_host_cpu_features().flatten()
    used = ",".join(part for part in sorted(features.split(",")) if part[:1] == "+")
    return {"cpu": str(name), "features": used}


def target(device: str = "cpu") -> dict[str, str]:
    """Tell what compiled code this process runs, and for which processor or GPU."""
    # ``features`` are those that code may use, so also what NUMBA_CPU_NAME and NUMBA_CPU_FEATURES
    # set; ``kernels`` is a hash over the sources of all kernels and the version of the compiler.
    processor = {"gpu": gpu_name()} if device == "cuda" else _cpu()
    machine = {"device": device, "machine": platform.machine()}
    return machine | processor | {"kernels": source_hash()}


def target_difference(stored: dict[str, Any], here: dict[str, str]) -> str:
    """Tell in words where two targets differ; empty if they do not."""
    if stored.get("device") != here["device"]:
        return f"device {stored.get('device')} there, {here['device']} here"
    told = []
    for key in here:
        if stored.get(key) == here[key]:
            continue
        if key == "features":
            theirs, ours = (set(str(each).split(",")) for each in (stored.get(key), here[key]))
            change = " ".join(sorted(f"-{x[1:]}" for x in theirs - ours) + sorted(ours - theirs))
            told.append(f"processor features {change}")
        else:
            told.append(f"{key} {stored.get(key)} there, {here[key]} here")
    return "; ".join(told)
