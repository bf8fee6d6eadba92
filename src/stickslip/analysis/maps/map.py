"""A user's own map of R^n by a function of points, smooth in pieces, angles welcome."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.maps.differences import (
    are_near,
    extrapolated_difference,
    parameter_difference,
    unlike,
)
from stickslip.analysis.maps.protocol import (
    UNDEFINED,
    PointValues,
    box_points,
    lengths,
    mix_labels,
    reduced,
)
from stickslip.analysis.maps.user_function import (
    Function,
    UserMap,
    as_labels,
    checked_callable,
    checked_parameters,
)
from stickslip.analysis.scales import FINE, PROBED
from stickslip.checks import (
    MOST_KEPT,
    MOST_STEPS,
    checked_interval,
    finite_number,
    one_each,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.numerics.expression import NotTraceable
from stickslip.numerics.point_function import PointFunction, point_function
from stickslip.status import OK
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Bools, Floats, Labels

Pairs: TypeAlias = Sequence[tuple[float, float] | None]

SECONDS: Final = (2.5e-5, 5e-8)  # of NumPy for a step of any number of points, and for a value
WORTH_COMPILING: Final = 1.0  # seconds of NumPy's, of all calls: compiling takes as long
MOST_OPERATIONS: Final = 2000  # of a formula: compiling takes some milliseconds for each


class NumericFunction:
    """A function of points known by its values: derivatives are extrapolated differences."""

    def __init__(self, func: Function, scale: Floats) -> None:
        self._func, self._scale = func, scale

    def values(self, x: Floats, arguments: Mapping[str, float]) -> Floats:
        """Values at points (..., n)."""
        with np.errstate(all="ignore"):
            return np.array(self._func(x, **arguments), dtype=np.float64)

    def jacobians(self, x: Floats, arguments: Mapping[str, float]) -> Floats:
        """Jacobians (..., n, n), each column by its coordinate."""
        n = x.shape[-1]
        columns = [
            extrapolated_difference(*self._along(x.reshape(-1, n), k, arguments))[0]
            for k in range(n)
        ]
        return np.stack(columns, axis=-1).reshape(*x.shape, n)

    def deny(self, x: Floats, jacobians: Floats, arguments: Mapping[str, float]) -> Bools:
        """Tell which entries of Jacobians at points (..., n) are not those of the values."""
        columns = [
            unlike(*self._along(x, k, arguments), jacobians[..., k].ravel())
            for k in range(x.shape[-1])
        ]
        return np.reshape(np.stack(columns, axis=-1), jacobians.shape)

    def rates(self, x: Floats, name: str, arguments: Mapping[str, float]) -> Floats:
        """Differentiate by a parameter, (..., n)."""
        now = arguments[name]
        flat = x.reshape(-1, x.shape[-1])

        def values(changed: Floats) -> Floats:
            rows = changed.reshape(-1, flat.size)[:, 0].tolist()
            return np.stack([self.values(flat, {**arguments, name: value}) for value in rows])

        slopes = parameter_difference(lambda changed: values(changed).ravel(), now, flat.size)
        return slopes.reshape(x.shape)

    def pieces(self, x: Floats, arguments: Mapping[str, float]) -> Floats:
        """Nothing is known of pieces, (..., 0)."""
        return np.empty((*x.shape[:-1], 0))

    def _along(
        self, x: Floats, k: int, arguments: Mapping[str, float]
    ) -> tuple[Callable[[Floats], Floats], Floats, float]:
        """All components as functions of coordinate k, which each row shares; where; its scale."""

        def values(changed: Floats) -> Floats:
            moved = changed.reshape(-1, *x.shape)[..., 0]
            points = np.repeat(x[None], len(moved), axis=0)
            points[..., k] = moved
            return self.values(points, arguments).ravel()

        return values, np.repeat(x[:, k], x.shape[1]), float(self._scale[k])


@cache
def _kernels(formula: PointFunction, low: tuple[float, ...], periods: tuple[float, ...]) -> Any:
    from stickslip.numerics.targets import instantiate, write_module  # loads numba

    made = write_module("map", formula.text(low, periods))
    names = ("step", "load", "store", "inside", "cell")
    bound = {name: getattr(made, name) for name in names}
    return instantiate(f"{__package__}._map_kernels", made.__name__, **bound)


def kernels_of(f: object, n_steps: float, n_values: float) -> Any:
    """Return a map's compiled functions for so many steps and values; None if that does not pay."""
    if not isinstance(f, Map) or f.formula is None or f.engine != "compiled":
        return None
    f._seconds[0] += SECONDS[0] * n_steps + SECONDS[1] * n_values
    if f._seconds[0] < WORTH_COMPILING:
        return None
    return _kernels(f.formula, tuple(f._domain[:, 0]), tuple(f._periods))


@suggests
class Map(UserMap):
    """A map of R^n into itself, smooth in pieces, with named parameters.

    Parameters
    ----------
    func : callable
        ``func(x, **parameters)`` of points of shape (..., n), returns their images, shaped alike;
        NaN means that there is none. Written with NumPy's functions it is recorded as formulas
        of the coordinates, choices by ``np.where`` and comparisons included: then derivatives
        are exact, pieces are known, and long orbits run compiled. `engine` tells.
    dimension : int
        The n.
    parameters : mapping of str to float, optional
        Names and values, passed to every callable by keyword.
    domain : sequence of pairs of float, optional
        Range of each coordinate, None for one without ends: where searches start, and outside
        of which orbits count as having left. All of R^n by default.
    jacobian : callable, optional
        ``jacobian(x, **parameters)``, shape (..., n, n). By default exact where `func` is
        recorded, else by extrapolated differences, good to about 1e-10 of the scale.
    label : callable, optional
        ``label(x, **parameters)``: a whole number per smooth piece, shape (...). By default
        what the comparisons inside `func` decide, where it is recorded.
    periodic : sequence of float or None, optional
        Periods of coordinates that are angles. `func` need not reduce them: values come back
        between the low end of the domain (or 0) and a period more, and distances, Newton's
        method and recurrences go the short way round.

    Raises
    ------
    ValueError
        A parameter is not a finite number, a range is not an interval, a period not positive, or
        `func` fails or returns another shape, or `jacobian` is not that of its values.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> def henon(z, a, b):
    ...     x, y = z[..., 0], z[..., 1]
    ...     return np.stack([1 - a * x**2 + y, b * x], axis=-1)
    >>> f = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-2, 2), (-2, 2)])
    >>> f([0.5, 0.0])
    array([0.65, 0.15])
    >>> f.derivative([0.5, 0.0])
    array([[-1.4,  1. ],
           [ 0.3,  0. ]])
    """

    def __init__(
        self,
        func: Function,
        dimension: int,
        *,
        parameters: Mapping[str, float] | None = None,
        domain: Pairs | None = None,
        jacobian: Function | None = None,
        label: Function | None = None,
        periodic: Sequence[float | None] | None = None,
    ) -> None:
        checked_callable("func", func)
        for role, given in (("jacobian", jacobian), ("label", label)):
            if given is not None:
                checked_callable(role, given)
        self._func, self._jacobian, self._label = func, jacobian, label
        self._dimension = whole_number("dimension", dimension, at_most=MOST_KEPT)
        self._parameters = checked_parameters({} if parameters is None else parameters)
        self._periods = self._checked_periods(periodic)
        self._domain = self._checked_domain(domain)
        self._seconds = [0.0]  # that NumPy has spent on orbits, of all maps that `replace` makes
        self._try()
        self._recorded, self._why_not = self._trace()
        self._moved = set()
        self._check_derivatives()

    def _checked_periods(self, periodic: Sequence[float | None] | None) -> Floats:
        none = [None] * self._dimension
        given = one_each("periodic", none if periodic is None else periodic, self._dimension)
        return np.array(
            [
                np.inf if period is None else finite_number(f"periodic[{k}]", period, above=0.0)
                for k, period in enumerate(given)
            ]
        )

    def _checked_domain(self, domain: Pairs | None) -> Floats:
        none = [None] * self._dimension
        given = one_each("domain", none if domain is None else domain, self._dimension)
        ends = [
            (-np.inf, np.inf) if pair is None else checked_interval(f"domain[{k}]", pair)
            for k, pair in enumerate(given)
        ]
        box = np.array(ends)
        angle = np.isfinite(self._periods)
        low = np.where(np.isfinite(box[:, 0]), box[:, 0], 0.0)[angle]
        box[angle] = np.stack([low, low + self._periods[angle]], axis=-1)
        return box

    # ------------------------------------------------------------------ what it is

    @property
    def dimension(self) -> int:
        """The n."""
        return self._dimension

    @property
    def domain(self) -> Floats:
        """Ends of the range of each coordinate, shape (n, 2); infinite where it has none."""
        return self._domain.copy()

    @property
    def periods(self) -> Floats:
        """Period of each coordinate, shape (n,); infinite for one that is no angle."""
        return self._periods.copy()

    @property
    def engine(self) -> str:
        """How long orbits run: ``compiled``, or ``NumPy`` and why."""
        if self.formula is not None and self.formula.n_operations > MOST_OPERATIONS:
            return f"NumPy: {self.formula.n_operations} operations are too many to compile"
        return f"NumPy: {self._why_not}" if self._why_not else "compiled"

    @property
    def formula(self) -> PointFunction | None:
        """The function as formulas of the coordinates, lifted; None if it was not recorded."""
        return self._recorded if isinstance(self._recorded, PointFunction) else None

    @property
    def _given(self) -> tuple[Any, ...]:
        callables = (self._func, self._jacobian, self._label)
        return (*callables, self._domain, self._periods, self._parameters)

    def __repr__(self) -> str:
        """Name of the function, dimension, parameters and engine."""
        name, values = self._shown()
        return f"Map({name}, {self._dimension}{values}; {self.engine})"

    # ------------------------------------------------------------------ values

    def contains(self, x: ArrayLike, /) -> Bools:
        """Tell which points are finite and in the domain, shape (...); an angle always is."""
        points = reduced(self, self._points(x))
        low, high = self._domain.T
        inside = np.isfinite(points) & (points >= low) & (points <= high)
        return np.asarray(inside.all(axis=-1))

    def spread(self, count: int, /) -> Floats:
        """Return points spread evenly over the domain, always the same, shape (count, n).

        ValueError without a bounded domain.
        """
        if not np.isfinite(self._domain).all():
            raise ValueError(
                f"the domain of {self} has no bounds to draw points from: give "
                "domain=[(low, high), ...], a pair for each coordinate."
            )
        return box_points(self._domain, whole_number("count", count, at_most=MOST_KEPT))

    def evaluate(self, x: ArrayLike, /) -> PointValues:
        """Return value, Jacobian, label and status at points of the domain.

        Parameters
        ----------
        x : array_like of float, shape (..., n)

        Returns
        -------
        PointValues
            Where there is no value, it and the Jacobian are NaN and the status is
            `stickslip.analysis.maps.protocol.UNDEFINED`.

        Raises
        ------
        ValueError
            A point is NaN or outside the domain.
        """
        points = self._checked(x)
        value = reduced(self, self._recorded.values(points, self._parameters))
        ok = np.isfinite(value).all(axis=-1)
        slopes = np.full((*value.shape, self._dimension), np.nan)
        slopes[ok] = self._slopes(points[ok])
        value[~ok] = np.nan
        status = np.where(ok, OK, UNDEFINED).astype(np.int64)
        return PointValues(value, slopes, self._labels(points), status, np.full(ok.shape, np.nan))

    def __call__(self, x: ArrayLike) -> Floats:
        """Return f(x), shaped like the points; NaN where there is no value."""
        value = reduced(self, self._recorded.values(self._checked(x), self._parameters))
        return np.where(np.isfinite(value).all(axis=-1, keepdims=True), value, np.nan)

    def derivative(self, x: ArrayLike) -> Floats:
        """Return the Jacobian, shape (..., n, n)."""
        return self._slopes(self._checked(x))

    def parameter_derivative(self, x: ArrayLike, name: str, /) -> Floats:
        """Return df/d(name) at fixed points, shaped like them.

        Raises
        ------
        ValueError
            ``name`` is not a parameter, or a point is outside the domain.
        """
        self._check_name(name)
        return self._recorded.rates(self._checked(x), name, self._parameters)

    def turned(self, x: ArrayLike) -> Floats:
        """Return how far each angle turns in a step, in periods, shape (..., angles).

        ValueError if `func` reduces angles, or does not turn them once as they turn once.
        """
        angle = np.isfinite(self._periods)
        periods = self._periods[angle]
        start = self._recorded.values(self._probes, self._parameters)
        for k in np.flatnonzero(angle):
            around = self._probes.copy()
            around[:, k] += self._periods[k]
            moved = self._recorded.values(around, self._parameters) - start
            if not np.allclose(moved[:, angle], self._periods[k] * np.eye(len(angle))[k][angle]):
                raise ValueError(
                    f"func does not turn coordinate {k} by {self._periods[k]:.12g} where its "
                    "argument is: it must return angles as they grow, not reduced to a period."
                )
        points = self._checked(x)
        turns = self._recorded.values(points, self._parameters) - points
        return np.asarray(turns[..., angle] / periods)

    def iterate(self, x: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times, shape (..., n + 1, n_coordinates); NaN once it has left."""
        n = whole_number("n", n, 0, at_most=MOST_STEPS, what="applications of a map")
        start = self._checked(x)
        orbit = np.full((*start.shape[:-1], n + 1, self._dimension), np.nan)
        if (made := kernels_of(self, n, orbit.size)) is not None:
            rows, out = np.ascontiguousarray(start.reshape(-1, self._dimension)), orbit
            made.orbits(rows, *self.numbers, out.reshape(-1, self._dimension), n, 0, len(rows))
            return orbit
        orbit[..., 0, :] = start
        for k in range(n):
            inside = self.contains(orbit[..., k, :])
            points = orbit[inside, k]
            orbit[inside, k + 1] = reduced(self, self._recorded.values(points, self._parameters))
        return orbit

    @property
    def numbers(self) -> tuple[Floats, Floats]:
        """What kernels take besides points: values of the parameters, and the domain."""
        return np.array([*self._parameters.values(), 0.0]), self._domain

    # ------------------------------------------------------------------ inside

    def _points(self, x: ArrayLike) -> Floats:
        points = real_numbers("x", x)
        if points.ndim == 0 and self._dimension == 1:
            points = points[None]
        if points.ndim == 0 or points.shape[-1] != self._dimension:
            raise ValueError(
                f"x = {shown(x)} is no point of the map: its last axis must hold "
                f"{self._dimension} numbers."
            )
        return points

    def _checked(self, x: ArrayLike) -> Floats:
        points = self._points(x)
        inside = self.contains(points)
        if not inside.all():
            first = points[tuple(np.argwhere(~inside)[0])]
            raise ValueError(
                f"x = {first.tolist()} is NaN or outside the domain {self._domain.tolist()}."
            )
        return reduced(self, points)

    def _slopes(self, x: Floats) -> Floats:
        if self._jacobian is None:
            return self._recorded.jacobians(x, self._parameters)
        with np.errstate(all="ignore"):
            given = np.asarray(self._jacobian(x, **self._parameters), dtype=np.float64)
        if given.shape != (*x.shape, self._dimension):
            raise ValueError(
                f"jacobian: of points of the shape {x.shape} it returned the shape {given.shape}; "
                f"{(*x.shape, self._dimension)} is needed."
            )
        return given

    def _labels(self, x: Floats) -> Labels:
        if self._label is not None:
            with np.errstate(all="ignore"):
                given = np.asarray(self._label(x, **self._parameters))
            return as_labels(np.broadcast_to(given, x.shape[:-1]))
        label = np.zeros(x.shape[:-1], dtype=np.uint64)
        pieces = self._recorded.pieces(x, self._parameters)
        for k in range(pieces.shape[-1]):
            label = mix_labels(label, as_labels(pieces[..., k]))
        return label

    @cached_property
    def _probes(self) -> Floats:
        low, high = self._domain.T
        unbounded = ~(np.isfinite(low) & np.isfinite(high))
        box = self._domain.copy()
        box[unbounded] = (-1.0, 1.0)
        return box_points(box, PROBED)

    def _try(self) -> None:
        """Refuse a function that fails, or returns other shapes."""
        name, _ = self._shown()
        for points in (self._probes, self._probes[0]):
            try:
                with np.errstate(all="ignore"):
                    value = np.asarray(self._func(points, **self._parameters), dtype=np.float64)
            except Exception as reason:
                raise ValueError(
                    f"func = {name}: the call failed at points of the shape {points.shape} with "
                    f"{type(reason).__name__}: {reason}. It must accept points (..., "
                    f"{self._dimension}) and every parameter by its name."
                ) from reason
            if value.shape != points.shape:
                raise ValueError(
                    f"func = {name}: of points of the shape {points.shape} it returned the shape "
                    f"{value.shape}. Images must be shaped like the points."
                )

    def _check_derivatives(self) -> None:
        """Refuse a given Jacobian that is not that of the values."""
        if self._jacobian is None:
            return
        x, slopes = self._probes, self._slopes(self._probes)
        plain = NumericFunction(self._func, self._scales())
        wrong = plain.deny(x, slopes, self._parameters)
        if not wrong.any():
            return
        known = plain.jacobians(x, self._parameters)
        for p, i, j in np.argwhere(wrong & np.isfinite(known) & ~are_near(slopes, known)):
            raise ValueError(
                f"jacobian[{i}, {j}] is {slopes[p, i, j]:.6g} at x = {x[p].tolist()}, but "
                f"differences of func tell {known[p, i, j]:.6g}. Without it Jacobians are found "
                "from func."
            )

    def _scales(self) -> Floats:
        """How far differences reach at most, by coordinates."""
        scale = np.ptp(self._domain, axis=1)
        scale[~np.isfinite(scale)] = 2.0
        return scale

    def _trace(self) -> tuple[PointFunction | NumericFunction, str]:
        plain = NumericFunction(self._func, self._scales())
        try:
            traced = point_function(self._func, self._dimension, tuple(self._parameters))
        except NotTraceable as reason:
            return plain, str(reason)
        x = self._probes
        values, check = (each.values(x, self._parameters) for each in (traced, plain))
        size = lengths(self) + np.abs(np.nan_to_num(check))
        if not np.allclose(values / size, check / size, 0.0, FINE, equal_nan=True):
            return plain, "what it computes depends on the type of its argument"
        return traced, ""
