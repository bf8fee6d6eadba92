"""What a function or a system is, in values that a store can keep and compare."""

from __future__ import annotations

import hashlib
import importlib
import inspect
import json
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.mechanics.friction.law import FrictionLaw


def digest(content: Any) -> str:
    """Hash of values that JSON can hold, or of bytes."""
    if not isinstance(content, bytes):
        content = json.dumps(content, sort_keys=True, allow_nan=False).encode()
    return hashlib.sha256(content).hexdigest()[:16]


def function_identity(function: Callable[..., Any]) -> dict[str, Any]:
    """Describe a function by its name, its text and the numbers it has closed over."""
    name = f"{getattr(function, '__module__', '?')}:{getattr(function, '__qualname__', '?')}"
    function = getattr(function, "py_func", function)  # compiled by numba
    try:
        text = inspect.getsource(function)
        closure = dict(inspect.getclosurevars(function).nonlocals)
    except (OSError, TypeError) as error:
        raise ValueError(
            f"{function!r} cannot be recorded in a store: its source text is not to be had. "
            "Write it as a function in a module."
        ) from error
    for variable, value in closure.items():
        if not isinstance(value, int | float | str):
            raise ValueError(
                f"{name} depends on {variable} = {value!r} of the place where it was made, which "
                "a store cannot record. Write it as a function in a module."
            )
    return {"function": name, "text": digest(text.encode()), "closure": closure}


def law_identity(law: FrictionLaw) -> dict[str, Any]:
    """Describe a friction law without its parameters' values: its formula."""
    formula: Any = law.formula
    if law.traceable:
        return {
            "formula": digest(repr((formula.nodes, formula.backward, formula.forward)).encode())
        }
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
            f"{name!r} cannot be imported: {error}. Write 'module:name', with the module where "
            "Python finds it (PYTHONPATH)."
        ) from error
    return found
