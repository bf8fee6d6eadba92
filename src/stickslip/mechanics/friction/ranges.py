"""Values that the parameters of a friction law may have."""

from __future__ import annotations

import dataclasses
import math
from typing import Annotated


@dataclasses.dataclass(frozen=True)
class Range:
    """Values that a parameter may have; stands in the annotation of its field."""

    low: float
    high: float = math.inf
    above: bool = False


@dataclasses.dataclass(frozen=True)
class Choice:
    """A field that selects between formulas and takes one of a few values."""

    values: tuple[int, ...]


NonNegative = Annotated[float, Range(0.0)]
Positive = Annotated[float, Range(0.0, above=True)]
Share = Annotated[float, Range(0.0, 1.0)]
