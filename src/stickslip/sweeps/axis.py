"""Axes of a sweep: a name and its values, given as numbers or as a range."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import Any, Final, Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip.checks import finite_number, grid, instance, one_of, whole_number
from stickslip.numerics.arrays import Floats
from stickslip.vocabulary import suggests

MOST_VALUES: Final = 10**8
SCALES: Final = ("linear", "log")

AxisLike: TypeAlias = "Axis | tuple[float, float, int] | ArrayLike"


@dataclass(frozen=True, eq=False)
class Axis:
    """Values of one parameter; `axis` makes it.

    Attributes
    ----------
    values : ndarray of float64, shape (n,)
        Distinct, in ascending or descending order.
    """

    values: Floats

    def __len__(self) -> int:
        """Count the values."""
        return len(self.values)


@suggests
def axis(lo: float, hi: float, n: int, scale: Literal["linear", "log"] = "linear") -> Axis:
    """Make an axis of equally spaced values, both ends included.

    Parameters
    ----------
    lo, hi : float
        Ends; with ``scale="log"`` both above 0.
    n : int
        Number of values, >= 1; with 1, ``lo`` alone.
    scale : {"linear", "log"}
        Whether differences or ratios of neighbours are equal.

    Returns
    -------
    Axis
        For `stickslip.sweep`.

    Raises
    ------
    ValueError
        An end is not finite or out of range, n is no whole number >= 1, the scale is unknown.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.axis(0.01, 1.0, 3, scale="log").values
    array([0.01, 0.1 , 1.  ])
    """
    one_of("scale", scale, SCALES)
    count = whole_number("n", n, at_most=MOST_VALUES, what="values of an axis")
    least = 0.0 if scale == "log" else -inf
    why = "A logarithmic axis has ends above 0." if scale == "log" else ""
    ends = [
        finite_number(name, end, above=least, why=why) for name, end in (("lo", lo), ("hi", hi))
    ]
    spaced = np.geomspace if scale == "log" else np.linspace
    return Axis(_ordered(spaced(ends[0], ends[1], count)))


def as_axes(given: Mapping[str, AxisLike]) -> dict[str, Axis]:
    """Read the axes of a sweep in the forms that `stickslip.sweep` takes."""
    instance("axes", given, Mapping, 'values by name, {"V": (0.03, 0.05, 12)}')
    if not given:
        raise ValueError("axes = {}: a sweep needs at least one axis, {name: values}.")
    return {name: _as_axis(name, values) for name, values in given.items()}


def _as_axis(name: str, given: Any) -> Axis:
    if isinstance(given, Axis):
        return given
    try:
        return Axis(_ordered(grid(name, given)))
    except (TypeError, ValueError) as error:
        raise ValueError(f"axis {name!r}: {error}") from error


def _ordered(values: Sequence[float] | Floats) -> Floats:
    """Return a copy of values that are finite, distinct and in order."""
    array = np.array(values, dtype=np.float64)
    if array.size == 0 or not np.isfinite(array).all():
        raise ValueError("finite numbers are needed, at least one.")
    steps = np.diff(array)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise ValueError("its values must be distinct and in ascending or descending order.")
    array.setflags(write=False)
    return array
