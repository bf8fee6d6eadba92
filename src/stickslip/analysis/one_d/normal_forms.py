"""Normal forms of folds and flips: what is born, on which side, and whether it is stable.

Both need derivatives of f^p beyond the first. Those of f come from differences of the exact
first derivative at each point of the orbit, extrapolated with an error estimate, and are put
together along the orbit by the chain rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from stickslip.analysis.differences import (
    extrapolated_difference,
    extrapolated_second_difference,
)
from stickslip.analysis.protocol import domain_width, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.protocol import Floats, Map1D, MapFamily, PointValues

__all__ = ["FlipCoefficient", "FoldCoefficient", "flip_coefficient", "fold_coefficient"]

ROUNDING: Final = 16 * float(np.finfo(np.float64).eps)  # differences may agree by chance


@dataclass(frozen=True)
class FlipCoefficient:
    """Cubic coefficient c of a flip: in a suitable coordinate f^p is u -> -u + c u^3 + ...

    Attributes
    ----------
    value : float
        c = (g'')^2 / 4 + g''' / 6 of g = f^p; its sign does not depend on the coordinate.
    error : float
        Estimated.
    """

    value: float
    error: float

    @property
    def criticality(self) -> Literal["super", "sub"] | None:
        """``super`` if c > 0: a stable orbit of twice the period where this one is unstable.

        ``sub`` if c < 0: an unstable one where this one is stable. None if the error leaves
        the sign open.
        """
        if not abs(self.value) > self.error:
            return None
        return "super" if self.value > 0 else "sub"


@dataclass(frozen=True)
class FoldCoefficient:
    """A fold: f^p(x) - x is half ``curvature`` u^2 + ``speed`` (q - q0) + ...

    Attributes
    ----------
    curvature : float
        Second derivative of f^p.
    error : float
        Its error, estimated.
    speed : float
        Derivative of f^p with respect to the parameter q.
    """

    curvature: float
    error: float
    speed: float

    @property
    def side(self) -> int:
        """Sign of q - q0 where the two orbits exist; 0 if the error leaves it open."""
        if self.speed == 0 or not abs(self.curvature) > self.error:
            return 0
        return -1 if (self.speed > 0) == (self.curvature > 0) else 1

    @property
    def opening(self) -> float:
        """The orbits are at ± opening * sqrt(abs(q - q0)) from the fold, to first order."""
        return float(np.sqrt(2 * abs(self.speed / self.curvature)))


def flip_coefficient(f: Map1D, points: ArrayLike) -> FlipCoefficient:
    """Find the cubic coefficient of a flip, whose sign tells super- from subcritical.

    Parameters
    ----------
    f : Map1D
        The map at the flip.
    points : array_like of float, shape (p,)
        The orbit with multiplier -1, in the map's order.

    Returns
    -------
    FlipCoefficient
        NaN with infinite error where a point has no neighbours on its branch.

    Notes
    -----
    At multiplier -1 the coefficient is -S / 6 with the Schwarzian derivative
    S = g''' / g' - 3/2 (g'' / g')^2 of g = f^p, and Schwarzians compose:
    S(f^p) is the sum of S f(x_k) ((f^(k-1))'(x_1))^2 over the orbit
    (Kuznetsov, Elements of Applied Bifurcation Theory, section 4.5; de Melo and van Strien,
    One-Dimensional Dynamics, section II.6).
    """
    x = np.asarray(points, dtype=np.float64)
    slope, (second, error_2), (third, error_3) = _derivatives(f, x)
    with np.errstate(all="ignore"):
        schwarzian = third / slope - 1.5 * (second / slope) ** 2
        error = error_3 / np.abs(slope) + 3 * np.abs(second) * error_2 / slope**2
        error += ROUNDING * (np.abs(third / slope) + 1.5 * (second / slope) ** 2)
        weight = _before(slope) ** 2
        value, doubt = float(weight @ schwarzian) / -6, float(weight @ error) / 6
    return FlipCoefficient(value, doubt if np.isfinite(doubt) else np.inf)


def fold_coefficient(f: MapFamily, points: ArrayLike, name: str) -> FoldCoefficient:
    """Find curvature and speed of a fold, whose signs tell where its two orbits exist.

    Parameters
    ----------
    f : MapFamily
        The map at the fold.
    points : array_like of float, shape (p,)
        The orbit with multiplier 1, in the map's order.
    name : str
        The parameter.

    Returns
    -------
    FoldCoefficient

    Raises
    ------
    ValueError
        ``name`` is not a parameter of the map.
    """
    x = np.asarray(points, dtype=np.float64)
    moved = np.asarray(f.parameter_derivative(x, name), dtype=np.float64)
    slope, (second, error_2), _ = _derivatives(f, x)
    weight = _before(slope) ** 2 * _after(slope)
    with np.errstate(all="ignore"):
        value = float(weight @ second)
        doubt = float(np.abs(weight) @ (error_2 + ROUNDING * np.abs(second)))
    return FoldCoefficient(
        value, doubt if np.isfinite(doubt) else np.inf, float(_after(slope) @ moved)
    )


def _before(slope: Floats) -> Floats:
    """Products of the slopes before each point: derivatives of f^0, f^1, ... at the first."""
    product: Floats = np.concatenate([[1.0], np.cumprod(slope[:-1])])
    return product


def _after(slope: Floats) -> Floats:
    """Products of the slopes after each point."""
    product: Floats = _before(slope[::-1])[::-1]
    return product


def _derivatives(
    f: Map1D, x: Floats
) -> tuple[Floats, tuple[Floats, Floats], tuple[Floats, Floats]]:
    """Return f', and f'' and f''' with errors, from values of f' on the branch of each point."""
    at_x = sample(f, x)
    seen: dict[bytes, PointValues] = {}

    def values(points: Floats) -> PointValues:
        # First and second differences ask for the same points, once for slopes, once for labels.
        key = points.tobytes()
        if key not in seen:
            seen[key] = at_x if key == x.tobytes() else sample(f, points)
        return seen[key]

    def slopes(points: Floats) -> Floats:
        return values(points).derivative

    def same_branch(here: Floats, points: Floats) -> NDArray[np.bool_]:
        there = values(points)
        labels = np.resize(at_x.label, here.shape)  # here is x again and again
        same: NDArray[np.bool_] = (there.status == OK) & (labels == there.label)
        return same

    width = domain_width(f)
    second = extrapolated_difference(slopes, x, width, same_branch)
    third = extrapolated_second_difference(slopes, x, width, same_branch)
    return at_x.derivative, second, third
