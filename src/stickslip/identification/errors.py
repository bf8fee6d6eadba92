"""How sure estimates are, beyond linear theory, and what follows from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from stickslip.checks import real_numbers, shown
from stickslip.results.result import Result

if TYPE_CHECKING:
    from stickslip.identification.fit import Fit
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

# Times the interval of linear theory that a profile goes through, and its points.
REACH, POINTS = 1.5, 9
# Standard error with which a profile holds a parameter, of that of its estimate.
HELD = 1e-5


class Prediction(NamedTuple):
    """A quantity of the fitted model: its value, its error, and how far from linear it is."""

    value: Any  # float or ndarray, as the quantity
    standard_error: Any
    curvature: Any
    """Root of the sum of squares of half the second differences over one standard error: small
    beside the error where linear theory holds, as large where the quantity jumps."""


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Result):
    """Misfit of the best model for each value of one parameter; `Fit.profile` makes it.

    Attributes
    ----------
    parameter : str
    values : ndarray, shape (n,)
    others : ndarray, shape (n, k)
        All parameters of the fit there.
    root : ndarray, shape (n,)
        Root of the rise of chi2 over its minimum, in standard errors of the data, with the sign of
        value - estimate: a straight line where linear theory holds.
    interval : tuple of float
        95 per cent, interpolated; an end is infinite if no value was far enough.
    """

    parameter: str
    values: Floats
    others: Floats
    root: Floats
    interval: tuple[float, float]
    _column_names: ClassVar = ("values", "root")
    _drawn: ClassVar = ("values", "root")

    def __repr__(self) -> str:
        """Headline: the interval."""
        low, high = self.interval
        return f"Profile of {self.parameter}: 95 per cent in ({low:.8g}, {high:.8g})"


def predict(fit: Fit, quantity: Callable[[Model], Any], axes: Floats) -> Prediction:
    """Carry the covariance to a quantity, along the axes of the ellipsoid of errors."""
    at_best = _numbers(fit, quantity, np.zeros(len(fit.values)))
    square, bent = np.zeros(at_best.shape), np.zeros(at_best.shape)
    for axis in axes:
        ahead, behind = (_numbers(fit, quantity, step) for step in (axis, -axis))
        square += (0.5 * (ahead - behind)) ** 2
        bent += (0.5 * (ahead + behind) - at_best) ** 2
    found = at_best, np.sqrt(square), np.sqrt(bent)
    return Prediction(*(float(each) if each.ndim == 0 else each for each in found))


def _numbers(fit: Fit, quantity: Callable[[Model], Any], step: Floats) -> Floats:
    """Evaluate a quantity some way from the estimates."""
    moved = dict(zip(fit.parameters, (fit.values + step).tolist(), strict=True))
    values = ", ".join(f"{name} = {value:.6g}" for name, value in moved.items())
    where = f"at {values}, {'one standard error from ' * bool(step.any())}the estimates"
    try:
        model = fit.model.replace(**moved)
    except ValueError as error:
        raise ValueError(
            f"there is no model {where}: {error}. Fix a parameter, or measure what tells it"
        ) from error
    try:
        return real_numbers("quantity(model)", quantity(model))
    except Exception as error:
        raise ValueError(
            f"quantity = {shown(quantity)} has no value {where}: {type(error).__name__}: {error}. "
            "Look at fit.model.replace(...) with these values; where the model has none the "
            "quantity may return NaN"
        ) from error


def crossings(values: Floats, root: Floats, best: float, reach: float) -> tuple[float, float]:
    """Where the root passes -reach and reach; infinite where it does not."""
    order = np.argsort(values)
    values, root = values[order], root[order]
    ends = []
    for sign in (-1.0, 1.0):
        side = sign * (values - best) > 0.0
        at = np.concatenate([[best], values[side][:: int(sign)]])
        rise = np.concatenate([[0.0], sign * root[side][:: int(sign)]])
        beyond = np.flatnonzero(rise >= reach)
        if not len(beyond):
            ends.append(sign * np.inf)
            continue
        k = int(beyond[0])
        ends.append(float(np.interp(reach, rise[k - 1 : k + 1], at[k - 1 : k + 1])))
    return ends[0], ends[1]
