"""What results are made of: classes that files may hold, known by name, and equality by value."""

from __future__ import annotations

import dataclasses
import importlib
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

ARRAYS = (np.ndarray, np.generic)

_classes: dict[str, type] = {}

Class = TypeVar("Class", bound=type)


def register(cls: Class) -> Class:
    """Let files hold instances of a class, under its name: a decorator."""
    known = _classes.setdefault(cls.__name__, cls)
    if (known.__module__, known.__qualname__) != (cls.__module__, cls.__qualname__):
        raise TypeError(f"two classes are named {cls.__name__}: {known!r}, {cls!r}")
    return cls


def part(cls: Class) -> Class:
    """Register a dataclass or named tuple that results hold; a dataclass is equal by value."""
    # The `__eq__` that a dataclass comes with takes a NaN that was loaded for another one.
    if dataclasses.is_dataclass(cls):
        cls.__eq__ = equal_results  # type: ignore[method-assign]
        cls.__hash__ = hash_of_result  # type: ignore[method-assign, assignment]
    return register(cls)


def registered() -> Mapping[str, type]:
    """Classes by name: of all modules that were imported so far."""
    return _classes


def is_registered(value: Any) -> bool:
    """Whether files may hold instances of the class of a value."""
    return _classes.get(type(value).__name__) is type(value)


def class_named(name: str) -> type:
    """Class that a file names.

    Raises
    ------
    KeyError
        No class of that name is registered.
    """
    if name not in _classes:
        import_public()
    return _classes[name]


def import_public() -> None:
    """Import every public name, so that all classes and kinds of maps are registered."""
    package = importlib.import_module("stickslip")
    for name in package.__all__:
        try:
            getattr(package, name)
        except ModuleNotFoundError:
            continue  # of an extra that is not installed: no result of that extra can be made


def field_names(value: Any) -> tuple[str, ...]:
    """Names of what a dataclass or a named tuple is made of."""
    if isinstance(value, tuple):
        return tuple(getattr(value, "_fields", ()))
    return tuple(item.name for item in dataclasses.fields(value) if item.init)


# ------------------------------------------------------------------ equality


def equal(a: Any, b: Any) -> bool:
    """Whether two values are the same, arrays by their elements; NaN equals NaN."""
    if a is b:
        return True
    if isinstance(a, ARRAYS) and isinstance(b, ARRAYS):
        a, b = np.asarray(a), np.asarray(b)
        inexact = a.dtype.kind in "fc" and b.dtype.kind in "fc"
        return a.shape == b.shape and bool(np.array_equal(a, b, equal_nan=inexact))
    if isinstance(a, list | tuple) and isinstance(b, type(a)):
        return len(a) == len(b) and all(map(equal, a, b))
    if isinstance(a, dict) and isinstance(b, dict):
        return a.keys() == b.keys() and all(equal(a[key], b[key]) for key in a)
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return False
    return bool(a == b or (a != a and b != b))


def equal_results(a: Any, b: Any) -> Any:
    """``__eq__`` of results and parts: the fields, one by one."""
    if type(a) is not type(b):
        return NotImplemented
    return a is b or all(
        equal(getattr(a, item.name), getattr(b, item.name))
        for item in dataclasses.fields(a)
        if item.compare
    )


def hash_of_result(a: Any) -> int:
    """``__hash__`` that goes with it: of the numbers, texts and arrays of numbers in the fields."""
    values = (getattr(a, item.name) for item in dataclasses.fields(a) if item.compare)
    return hash((type(a), *map(_plain, values)))


def _plain(value: Any) -> Any:
    """Tell a hash numbers and texts, NaN as 0; None of what it leaves out."""
    if isinstance(value, bool | int | float | str):
        return 0 if value != value else value
    if not isinstance(value, ARRAYS) or value.dtype.kind not in "biufc":
        return None
    numbers = np.where(value == value, value, 0)
    return tuple(numbers.ravel().tolist()) if numbers.ndim else numbers.item()
