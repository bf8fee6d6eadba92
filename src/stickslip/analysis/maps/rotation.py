"""Rotation numbers of maps with angles: mean turns per step, by weighted averages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.analysis.maps.arguments import map_of, space_points
from stickslip.analysis.maps.derived import plain
from stickslip.checks import MOST_STEPS, real_numbers, shown, whole_number
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Floats


class OrbitMean(Result):
    """A mean along orbits, and how far off it may be: numbers, or arrays for several of them."""

    value: Any
    error: Any
    _drawn: ClassVar = ("start", "value")
    _has_picture: ClassVar = False

    def __float__(self) -> float:
        """Return the value alone."""
        return float(self.value)

    def _columns(self) -> dict[str, Any]:
        value, error = np.ravel(self.value), np.ravel(self.error)
        return {"start": np.arange(value.size) + 1, "value": value, "error": error}


@dataclass(frozen=True, eq=False, repr=False)
class RotationNumber(OrbitMean):
    """Mean turns per step of the angles of orbits.

    Attributes
    ----------
    value : float or ndarray
        A number for one angle and one orbit, else (..., angles); NaN where the orbit left.
    error : float or ndarray
        Largest difference from the values of the two halves of the orbit: evidence, no bound.
    n : int
        Steps that were averaged.
    """

    value: Any
    error: Any
    n: int

    def __repr__(self) -> str:
        """Value ± error, one row for each angle of each orbit."""
        rows = [
            f"{value:.12g} ± {error:.2g}"
            for value, error in zip(np.ravel(self.value), np.ravel(self.error), strict=True)
        ]
        return f"RotationNumber({'; '.join(rows)}, n={self.n})"


@waits
@suggests
def rotation_number(
    f: Any, x0: ArrayLike, n: int = 10_000, *, transient: int = 1000
) -> RotationNumber:
    """Estimate how far the angles of orbits turn per step, in periods.

    Parameters
    ----------
    f : Map with `periodic`, or model or return map whose point is a phase
        Its function returns angles as they grow, not reduced to a period.
    x0 : array_like of float, shape (..., n_coordinates); of one coordinate also a number
        Starting points.
    n : int
        Steps to average, after the transient.
    transient : int
        Steps to drop first.

    Returns
    -------
    RotationNumber

    Raises
    ------
    ValueError
        The map has no angle, or its function reduces its angles, so that turns are lost.

    Notes
    -----
    Averages are weighted by exp(-1 / (t (1 - t))), t from 0 to 1 along the orbit, which converge
    faster than any power of n on quasiperiodic orbits (Das, Saiki, Sander and Yorke, Nonlinearity
    30 (2017) 4111-4140).

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> def circle(x, omega, k):
    ...     return x + omega + k / (2 * np.pi) * np.sin(2 * np.pi * x)
    >>> f = ss.Map(circle, 1, parameters={"omega": 0.5, "k": 0.9}, periodic=[1.0])
    >>> round(float(ss.rotation_number(f, 0.1)), 12)
    0.5
    """
    f = map_of(f)
    turned = getattr(f, "turned", None)
    if turned is None or not np.isfinite(f.periods).any():
        raise ValueError(f"f = {shown(f)} has no angle. Take ss.Map(..., periodic=[...]).")
    n = whole_number("n", n, 2, at_most=MOST_STEPS, what="steps of a mean")
    skip = whole_number("transient", transient, 0, at_most=MOST_STEPS)
    start, line = real_numbers("x0", x0), not hasattr(f, "contains")
    if not (start.size and np.isfinite(start).all()):
        raise ValueError(f"x0 = {shown(x0)}: finite starting points are needed.")
    if not line and (start.ndim or f.dimension > 1):  # a number is a point of one coordinate
        start = space_points(f, "x0", start)
    rows = start.reshape(-1) if line else start.reshape(-1, f.dimension)
    orbits = f.iterate(rows, skip + n)[:, skip:-1]
    turns = np.full((*orbits.shape[:2], int(np.isfinite(f.periods).sum())), np.nan)
    there = np.isfinite(orbits) if line else np.isfinite(orbits).all(axis=-1)
    turns[there] = turned(orbits[there])
    value = _weighted(turns)
    halves = (_weighted(half) for half in np.array_split(turns, 2, axis=1))
    error = np.max([np.abs(half - value) for half in halves], axis=0)
    return RotationNumber(_plain(value, start, line), _plain(error, start, line), n)


def _weighted(turns: Floats) -> Floats:
    t = (np.arange(turns.shape[1]) + 0.5) / turns.shape[1]
    weight = np.exp(-1.0 / (t * (1.0 - t)))
    return np.einsum("k,ikj->ij", weight / weight.sum(), turns)


def _plain(values: Floats, start: Floats, line: bool) -> Any:
    shape = start.shape if line or start.ndim == 0 else start.shape[:-1]
    shaped = values.reshape(*shape, -1)
    return plain(shaped[..., 0] if shaped.shape[-1] == 1 else shaped)
