"""A user's own map of an interval: jumps, corners, gaps and square roots welcome."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, TypeAlias, overload

import numpy as np

from stickslip.analysis.maps.derived import EvaluatedMap, plain
from stickslip.analysis.maps.differences import (
    are_near,
    complex_step,
    extrapolated_difference,
    parameter_difference,
    share_unknown,
    unlike,
    unlike_parameter,
)
from stickslip.analysis.maps.formulas import VARIABLE, Formulas, Slope, formulas_of
from stickslip.analysis.maps.protocol import UNDEFINED, PointValues, checked_points, shaped
from stickslip.analysis.maps.user_function import (
    Function,
    UserMap,
    apply,
    as_labels,
    checked_callable,
    checked_parameters,
    takes_arrays,
)
from stickslip.analysis.scales import CLOSE, HALF_DIGITS, PROBED
from stickslip.checks import Many, checked_interval, real_numbers, shown
from stickslip.numerics.arrays import GOLDEN
from stickslip.results.files import register_map
from stickslip.status import OK
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Bools, Floats, Labels

Breakpoints: TypeAlias = Sequence[float | str] | Callable[..., Sequence[float]]

SHARES: Final = np.asarray((0.5 + GOLDEN * np.arange(1, PROBED + 1)) % 1.0, dtype=np.float64)


@suggests
class PiecewiseMap(UserMap, EvaluatedMap):
    """A piecewise-smooth map of an interval into the line, with named parameters.

    Parameters
    ----------
    func : str, sequence of str, or callable
        A formula of ``x`` and the parameters, ``"r * x * (1 - x)"``, or one for each branch from
        left to right, with the `breakpoints` between them; at a breakpoint the right one holds.
        Functions: exp, expm1, log, log1p, sqrt, sin, cos, tan, sinh, cosh, tanh, atan, asinh.
        Derivatives are then exact, and `certify_orbits` proves lists of orbits. Or
        ``func(x, **parameters)``, which takes arrays or, if it cannot, single numbers (found out
        by trying). NaN means that the map has no value there: a gap.
    domain : pair of float
        Ends ``lo < hi`` of the closed interval of arguments. Values outside it are legal:
        the orbit leaves.
    parameters : mapping of str to float, optional
        Names and values, passed to every callable by keyword.
    derivative : callable, optional
        ``derivative(x, **parameters)``. Without it the derivative is taken by complex step
        where that agrees with differences (error near rounding), else by extrapolated
        differences (about 1e-10 of the scale).
    parameter_derivative : mapping of str to callable, or callable, optional
        ``{"r": df_dr}`` with ``df_dr(x, **parameters)``, or ``df(x, name, **parameters)``.
        Differences where absent.
    label : callable, optional
        ``label(x, **parameters)``: a whole number per branch.
    breakpoints : sequence of float, or callable, optional
        Where the branches end (``breakpoints(**parameters)`` if they move; between formulas,
        formulas of the parameters too, ``["b"]``); the label is
        then the number of breakpoints at or left of x. Without label and breakpoints the
        whole domain has label 0 and discontinuities are found from the values alone.

    Raises
    ------
    ValueError
        The domain is not an interval, a parameter is not a finite number, breakpoints are
        not increasing, a formula cannot be read, ``func`` fails on points of the domain, or
        `derivative` or `parameter_derivative` is not that of its values.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.5})
    >>> f(0.5)
    0.875
    >>> f.replace(r=4).iterate(0.5, 2)
    array([0.5, 1. , 0. ])

    By formulas, here of two branches:

    >>> f = ss.PiecewiseMap(
    ...     ["a - 1.1*x - 0.35*x**2", "0.55*x - 0.62"],
    ...     (-1.5, 1.5),
    ...     parameters={"a": 0.45},
    ...     breakpoints=[0.2],
    ... )
    >>> f
    PiecewiseMap('a - 1.1*x - 0.35*x**2' for x < 0.2, '0.55*x - 0.62', [-1.5, 1.5], a=0.45)
    """

    def __init__(
        self,
        func: Function | str | Sequence[str],
        domain: tuple[float, float],
        *,
        parameters: Mapping[str, float] | None = None,
        derivative: Function | None = None,
        parameter_derivative: Mapping[str, Function] | Function | None = None,
        label: Function | None = None,
        breakpoints: Breakpoints | None = None,
    ) -> None:
        self._domain = checked_interval("domain", domain)
        self._parameters = checked_parameters({} if parameters is None else parameters)
        function: Any = func
        ends: Any = breakpoints
        if isinstance(func, str | list | tuple):
            own = {"derivative": derivative, "parameter_derivative": parameter_derivative}
            for role, given in (*own.items(), ("label", label)):
                if given is not None:
                    raise ValueError(f"{role} goes with a callable: formulas bring their own.")
            function = formulas_of(func, breakpoints, self._parameters)
            ends, derivative = function.edges, Slope(function, VARIABLE)
            parameter_derivative = {name: Slope(function, name) for name in self._parameters}
        self._func: Function = function
        self._given_derivative = derivative
        self._given_parameter_derivative = parameter_derivative
        self._given_label = label
        self._given_breakpoints: Breakpoints | None = ends
        self._check_parameter_derivative_names()
        self._breakpoints = self._breakpoints_with(self._parameters)
        self._analytic: bool | None = None  # unknown until a slope is asked for
        self._learn_how_to_call()
        self._moved = set()
        self._check_derivatives()

    # ------------------------------------------------------------------ what it is

    @property
    def callables(self) -> dict[str, Function]:
        """Every function that was given, by what it is for."""
        if isinstance(self._func, Formulas):
            return {"func": self._func}
        given: dict[str, Any] = {
            "func": self._func,
            "derivative": self._given_derivative,
            "label": self._given_label,
            "breakpoints": self._given_breakpoints,
        }
        slopes = self._given_parameter_derivative
        if isinstance(slopes, Mapping):
            given |= {f"derivative in {name}": slope for name, slope in slopes.items()}
        else:
            given["parameter_derivative"] = slopes
        return {role: function for role, function in given.items() if callable(function)}

    @property
    def breakpoints(self) -> Floats:
        """Where the user says that the branches end, at the present parameter values."""
        return self._breakpoints.copy()

    @property
    def domain(self) -> tuple[float, float]:
        """Ends of the closed interval of arguments."""
        return self._domain

    def _adapt(self) -> None:
        """Find the breakpoints; try the callables once each, and anew if that fails."""
        # Copies inherit which callables take arrays. Whether complex steps differentiate ``func``
        # may well depend on the values (``a * abs(x)`` at a = 0), so every copy finds that out for
        # itself, when first asked for a slope.
        self._analytic = None
        if callable(self._given_breakpoints):
            self._breakpoints = self._breakpoints_with(self._parameters)
        if not self._still_callable():
            self._learn_how_to_call()

    def __hash__(self) -> int:
        func = self._func if isinstance(self._func, Formulas) else id(self._func)
        return hash((func, self._domain, *self._parameters.values()))

    @property
    def _given(self) -> tuple[Any, ...]:
        return (
            *(self._func, self._domain, self._parameters, self._given_derivative),
            *(self._given_parameter_derivative, self._given_label, self._given_breakpoints),
        )

    def __repr__(self) -> str:
        """Name of the function, domain and parameters."""
        name, values = self._shown()
        return f"PiecewiseMap({name}, [{self._domain[0]:.12g}, {self._domain[1]:.12g}]{values})"

    # ------------------------------------------------------------------ values

    def evaluate(self, x: ArrayLike, /) -> PointValues:
        """Return value, derivative, label and status at points of the domain.

        Parameters
        ----------
        x : array_like of float, any shape

        Returns
        -------
        PointValues
            Shaped like ``x``. In a gap the value and derivative are NaN and the status is
            `stickslip.analysis.maps.protocol.UNDEFINED`.

        Raises
        ------
        ValueError
            An element is NaN or outside the domain.
        """
        points = checked_points(self._domain, x)
        flat = points.ravel()
        value = self._values(flat)
        ok = np.isfinite(value)
        slope = np.full(flat.shape, np.nan)
        if ok.any():
            slope[ok] = self._slopes(flat[ok])
        status = np.where(ok, OK, UNDEFINED).astype(np.int64)
        what = np.where(ok, value, np.nan), slope, self._labels(flat), status, self._margins(flat)
        return shaped(points.shape, *what)

    @overload
    def parameter_derivative(self, x: float, name: str, /) -> float: ...
    @overload
    def parameter_derivative(self, x: Many, name: str, /) -> Floats: ...
    @overload
    def parameter_derivative(self, x: ArrayLike, name: str, /) -> float | Floats: ...
    def parameter_derivative(self, x: ArrayLike, name: str, /) -> float | Floats:
        """Return df/d(name) at fixed x.

        Raises
        ------
        ValueError
            ``name`` is not a parameter, or a point is outside the domain.
        """
        self._check_name(name)
        points = checked_points(self._domain, x)
        return plain(self._parameter_slopes(points.ravel(), name).reshape(points.shape))

    # ------------------------------------------------------------------ inside

    def _value(self, x: ArrayLike) -> Floats:
        points = checked_points(self._domain, x)
        value = self._values(points.ravel()).reshape(points.shape)
        return np.where(np.isfinite(value), value, np.nan)

    def _values(self, x: Floats) -> Floats:
        return apply(self._func, x, self._parameters, self._arrays["func"])

    def _slopes(self, x: Floats) -> Floats:
        if self._given_derivative is not None:
            return apply(self._given_derivative, x, self._parameters, self._arrays["derivative"])
        if self._analytic is None:
            self._analytic = self._complex_step_agrees()
        if self._analytic:
            return complex_step(lambda z: self._func(z, **self._parameters), x)
        return self._differences(x)[0]

    def _differences(self, x: Floats) -> tuple[Floats, Floats]:
        """Return slopes and errors; where differences tell little, by shorter ones."""
        func, same, (lo, hi) = self._values_inside, self._same_branch, self._domain
        slope, error = extrapolated_difference(func, x, hi - lo, same)
        (rough,) = np.nonzero(share_unknown(slope, error) > HALF_DIGITS)
        # Close to a root-like corner slopes are so large that such short steps leave digits.
        if rough.size:
            closer, doubt = extrapolated_difference(func, x[rough], HALF_DIGITS * (hi - lo), same)
            better = share_unknown(closer, doubt) < share_unknown(slope[rough], error[rough])
            at = rough[better]
            slope[at], error[at] = closer[better], doubt[better]
        return slope, error

    def _values_inside(self, x: Floats) -> Floats:
        """Values, NaN outside the domain, where ``func`` is never called."""
        inside = (x >= self._domain[0]) & (x <= self._domain[1])
        values = np.full(x.shape, np.nan)
        values[inside] = self._values(x[inside])
        return values

    def _labels(self, x: Floats) -> Labels:
        return self._labels_with(x, self._parameters, self._breakpoints)

    def _labels_with(self, x: Floats, parameters: Mapping[str, Any], breakpoints: Floats) -> Labels:
        if self._given_label is None:
            return np.searchsorted(breakpoints, x, side="right").astype(np.uint64)
        with np.errstate(all="ignore"):
            if self._arrays["label"]:
                labels = np.broadcast_to(self._given_label(x, **parameters), x.shape)
            else:
                labels = np.array([self._given_label(float(v), **parameters) for v in x])
        return as_labels(labels)

    def _margins(self, x: Floats) -> Floats:
        """Distance to the next breakpoint, where the user has named them and no other label."""
        if self._given_label is not None or not len(self._breakpoints):
            return np.full(x.shape, np.nan)
        return np.abs(x[:, None] - self._breakpoints).min(axis=1)

    def _same_branch(self, x: Floats, y: Floats) -> Bools:
        inside = (y >= self._domain[0]) & (y <= self._domain[1])
        return inside & (self._labels(x) == self._labels(y))

    def _parameter_slopes(self, x: Floats, name: str) -> Floats:
        given, role = self._given_parameter_derivative, "parameter_derivative"

        def named(points: Any, **parameters: float) -> Any:
            return given(points, name, **parameters)  # type: ignore[operator,misc]

        slope: Function | None = named if callable(given) else None
        if isinstance(given, Mapping):
            slope, role = given.get(name), f"{role}[{shown(name)}]"
        if slope is None:
            return self._parameter_differences(x, name)
        return apply(slope, x, self._parameters, self._takes_arrays(role, slope))

    def _parameter_differences(self, x: Floats, name: str) -> Floats:
        return parameter_difference(self._values_along(x, name), self._parameters[name], x.size)

    def _values_along(self, x: Floats, name: str) -> Callable[[Floats], Floats]:
        """Values at points as a function of a parameter, one value of it after another."""

        def values(changed: Floats) -> Floats:
            return np.concatenate(
                [
                    self._values_on_branch(x, {**self._parameters, name: float(row[0])})
                    for row in changed.reshape(-1, x.size)
                ]
            )

        return values

    def _values_on_branch(self, x: Floats, parameters: Mapping[str, float]) -> Floats:
        """Values with other parameters, NaN where these are none of the map or a point's branch."""
        try:
            moved = self._breakpoints_with(parameters)
            stays = self._labels_with(x, parameters, moved) == self._labels(x)
            return np.where(stays, apply(self._func, x, parameters, self._arrays["func"]), np.nan)
        except (ValueError, ArithmeticError):  # a step too long: breaks pass each other, log(-1)
            return np.full(x.shape, np.nan)

    # ------------------------------------------------------------------ checks

    def _probes(self) -> Floats:
        """Points of the domain at no special place, some between any two breakpoints."""
        lo, hi = self._domain
        ends = np.concatenate([[lo], self._breakpoints, [hi]])
        return np.concatenate([a + (b - a) * SHARES for a, b in pairwise(ends)])

    def _few_probes(self) -> Floats:
        """Return the first three of the probes."""
        lo, hi = self._domain
        end = float(self._breakpoints[0]) if len(self._breakpoints) else hi
        return lo + (end - lo) * SHARES[:3]

    def _learn_how_to_call(self) -> None:
        """Try out which callables take arrays; raise if one works in no way."""
        self._arrays = {role: self._takes_arrays(role, func) for role, func in self._of_points()}
        self._analytic = None

    def _of_points(self) -> Iterator[tuple[str, Function]]:
        """Yield the callables that every point is given to, by their roles."""
        yield "func", self._func
        if self._given_label is not None:
            yield "label", self._given_label
        if self._given_derivative is not None:
            yield "derivative", self._given_derivative

    def _still_callable(self) -> bool:
        """Tell whether the callables work, with these parameters, in the ways already known."""
        few, parameters = self._few_probes(), self._parameters
        try:
            for role, func in self._of_points():
                apply(func, few, parameters, self._arrays[role])
        except Exception:  # whatever it is, the first way of trying names it
            return False
        return True

    def _takes_arrays(self, role: str, func: Function) -> bool:
        return takes_arrays(role, func, self._few_probes(), self._parameters)

    def _check_derivatives(self) -> None:
        """Refuse given derivatives that are not those of the values."""
        if isinstance(self._func, Formulas):
            return
        (lo, hi), x = self._domain, self._probes()[::4]
        if self._given_derivative is not None:
            slope = self._slopes(x)
            wrong = unlike(self._values_inside, x, hi - lo, slope, self._same_branch)
            self._refuse("derivative", slope, x, wrong, lambda at: self._differences(at)[0])
        given = self._given_parameter_derivative
        for name in self._parameters if callable(given) else given or ():
            slope, values = self._parameter_slopes(x, name), self._values_along(x, name)
            wrong = unlike_parameter(values, self._parameters[name], slope)
            role = f"parameter_derivative[{name!r}]"
            self._refuse(role, slope, x, wrong, partial(self._parameter_differences, name=name))

    def _refuse(
        self, role: str, slope: Floats, x: Floats, wrong: Bools, known: Callable[[Floats], Floats]
    ) -> None:
        if not wrong.any():
            return
        at, given, told = x[wrong], slope[wrong], known(x[wrong])
        sure = np.isfinite(told) & ~are_near(given, told)  # what would be taken without it
        if sure.any():
            raise ValueError(
                f"{role} is {given[sure][0]:.6g} at x = {at[sure][0]:.6g}, but differences of func "
                f"tell {told[sure][0]:.6g}. Without it slopes are found from func."
            )

    def _complex_step_agrees(self) -> bool:
        """Tell whether ``func`` carries complex arrays and is analytic at every probe."""
        if not self._arrays["func"]:
            return False
        x = self._probes()
        value = self._values(x)
        x = x[np.isfinite(value)]
        try:
            with np.errstate(all="ignore"):
                slope = complex_step(lambda z: self._func(z, **self._parameters), x)
        except Exception:  # no complex arithmetic inside ``func``
            return False
        check, error = self._differences(x)
        allowed = CLOSE * (1 + np.abs(check)) + 10 * error
        return bool(np.all(np.abs(slope - check) <= allowed))

    def _breakpoints_with(self, parameters: Mapping[str, float]) -> Floats:
        """Breakpoints inside the domain for given parameters, checked."""
        given = self._given_breakpoints
        if given is None:
            return np.empty(0)
        listed = given
        if callable(given):
            try:
                listed = given(**parameters)
            except Exception as reason:
                name = getattr(given, "__name__", type(given).__name__)
                values = ", ".join(f"{key}={value:.6g}" for key, value in parameters.items())
                raise ValueError(
                    f"breakpoints = {name}: the call {name}({values}) failed with "
                    f"{type(reason).__name__}: {reason}. It must accept every parameter by its "
                    "name."
                ) from reason
        points = real_numbers("breakpoints", listed)
        lo, hi = self._domain
        if points.ndim != 1 or not (np.isfinite(points).all() and (np.diff(points) > 0).all()):
            raise ValueError(
                f"breakpoints = {shown(listed)}: increasing finite numbers are needed."
            )
        return points[(points > lo) & (points <= hi)]

    def _check_parameter_derivative_names(self) -> None:
        given = self._given_parameter_derivative
        if isinstance(given, Mapping):
            for name, slope in given.items():
                self._check_name(name)
                checked_callable(f"parameter_derivative[{shown(name)}]", slope)
        elif given is not None:
            checked_callable("parameter_derivative", given)


def _values_of(f: PiecewiseMap) -> dict[str, Any]:
    """Describe a map of formulas for files of results."""
    function = f._func
    if not isinstance(function, Formulas):
        raise ValueError("Python functions cannot be saved.")
    return {
        "func": [branch.text for branch in function.branches],
        "domain": list(f.domain),
        "parameters": dict(f.parameters),
        "breakpoints": [edge.text for edge in function.edges.formulas],
    }


register_map("formulas", PiecewiseMap, _values_of, lambda values: PiecewiseMap(**values))
