"""Which parameters a user's function takes."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Hashable, Sequence
from inspect import Parameter
from typing import Any

from stickslip.checks import shown
from stickslip.mechanics.friction.formula import UserFunction
from stickslip.numerics.tracing import plain_function


def user_function(function: Any, given: Sequence[str], owner: str) -> UserFunction:
    """Check that a function takes a speed, then parameters that have a default or are `given`."""
    if not isinstance(function, Hashable) or not callable(function):
        raise ValueError(f"{owner} is no function but {shown(function)}")
    taken = _signature(function, owner)
    positional = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD)
    if not taken or taken.pop(0).kind not in positional:
        raise ValueError(f"{owner} takes no speed s as its first argument")
    for parameter in taken:
        if parameter.kind not in (Parameter.POSITIONAL_OR_KEYWORD, Parameter.KEYWORD_ONLY):
            raise ValueError(f"{owner}: parameter {parameter} cannot be passed by name")
        if parameter.default is Parameter.empty and parameter.name not in given:
            name = parameter.name
            raise ValueError(
                f"{owner} needs a value for {shown(name)}: parameters={{{shown(name)}: ...}}"
            )
    names = [parameter.name for parameter in taken]
    return UserFunction(function, tuple(name for name in given if name in names))


def _signature(function: Any, owner: str) -> list[Parameter]:
    try:
        return list(inspect.signature(plain_function(function)).parameters.values())
    except (TypeError, ValueError):
        raise ValueError(f"{owner} does not tell its parameters; wrap it in a def") from None


def parameter_names(function: Callable[..., Any]) -> list[str]:
    """Return the names that a function takes after the speed."""
    return [parameter.name for parameter in _signature(function, "force")[1:]]
