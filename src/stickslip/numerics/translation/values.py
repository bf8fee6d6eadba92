"""What expressions give: types of numba with code of LLVM, tuples in parts, objects."""

from __future__ import annotations

from typing import Any

import numba

types: Any = numba.types  # has none for mypy


class NotUnderstood(Exception):
    """Numba compiles such a kernel."""


class Value:
    """What an expression gives: its type, its code or its parts, and the object if it is known."""

    __slots__ = ("fields", "given", "kind", "known", "made", "natural", "object", "parts")

    def __init__(self, kind: Any, given: Any = None, parts: list[Value] | None = None) -> None:
        self.kind, self.given, self.parts = kind, given, parts
        self.known = False
        self.object: Any = None
        self.natural = False  # an integer that is not negative
        self.fields: Any = None  # of an array: codes, as numba passes them
        self.made: Any = None  # where its parts were joined, and the code


def known(kind: Any, thing: Any) -> Value:
    """Make the value of an object that is known."""
    made = Value(kind)
    made.known, made.object = True, thing
    made.natural = isinstance(thing, int) and thing >= 0
    return made


def natural(code: Any) -> Value:
    """Make an integer that is not negative."""
    made = Value(types.int64, code)
    made.natural = True
    return made


def form_of(kind: Any) -> Any:
    """Which tuples of tuples something is."""
    if not isinstance(kind, types.BaseTuple):
        return None
    return getattr(kind, "instance_class", None), *map(form_of, kind.types)
