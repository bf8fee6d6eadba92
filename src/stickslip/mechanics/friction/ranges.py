"""Values that the parameters of a friction law may have."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Iterable
from numbers import Real
from typing import Annotated, Any

import numpy as np


@dataclasses.dataclass(frozen=True)
class Range:
    """Values that a parameter may have; stands in the annotation of its field."""

    low: float
    high: float = math.inf
    above: bool = False

    def __contains__(self, value: float) -> bool:
        """Whether `value` is allowed; NaN never is."""
        if not math.isfinite(value):
            return False
        return (self.low < value if self.above else self.low <= value) and value <= self.high

    def text(self, name: str) -> str:
        """As a condition on `name`."""
        if self.high == math.inf:
            return f"{name} {'>' if self.above else '>='} {self.low:g}"
        return f"{self.low:g} {'<' if self.above else '<='} {name} <= {self.high:g}"


@dataclasses.dataclass(frozen=True)
class Choice:
    """A field that selects between formulas and takes one of a few values."""

    values: tuple[int, ...]


NonNegative = Annotated[float, Range(0.0)]
Positive = Annotated[float, Range(0.0, above=True)]
Share = Annotated[float, Range(0.0, 1.0)]


def real(name: str, value: Any, allowed: str) -> float:
    """`value` as a float; ValueError if it is no finite real number."""
    is_number = isinstance(value, Real) and not isinstance(value, (bool, np.bool_))
    if not is_number:
        raise ValueError(f"{name} is {value!r}, not a real number; allowed: {allowed}")
    if not math.isfinite(value):
        raise ValueError(f"{name} is {value}, not finite; allowed: {allowed}")
    return float(value)


def unknown_name(name: str, known: Iterable[str], owner: str) -> ValueError:
    """Make the error for a parameter that does not exist; it names the nearest that does."""
    names = list(known)
    close = difflib.get_close_matches(name, names, n=1)
    hint = f"; did you mean {close[0]!r}?" if close else ""
    listing = ", ".join(names) if names else "none"
    return ValueError(f"{owner} has no parameter {name!r}{hint} (parameters: {listing})")
