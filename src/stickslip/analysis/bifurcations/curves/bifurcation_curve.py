"""Curves of a bifurcation in the plane of two parameters, and of a breakpoint along one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.checks import finite_number
from stickslip.results.parts import part
from stickslip.results.result import Result

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.branches.along.tracked import CriticalReading, TrackedDiscontinuity
    from stickslip.analysis.maps.protocol import Floats

SHOWN: Final = 24  # points of a curve in its repr
AT_STEP: Final = 1e-4  # of a parameter: how far an interpolated guess may be off at least


@part
@dataclass(frozen=True)
class CodimensionTwo:
    """A point of a bifurcation curve where the type of the bifurcation changes.

    Attributes
    ----------
    kind : str
        ``cusp``, ``breakpoint``, ``generalised flip``, ``multiplier 1``, ``multiplier -1``,
        ``multiplier 0``, ``kind of border``, ``second border`` or ``end of border``.
    what : str
        A sentence.
    parameters : dict
        Both parameter values by name.
    points : tuple of float
        The orbit there.
    position : float
        Place on the curve: number of the point before, plus the share of the way to the next.
    """

    kind: str
    what: str
    parameters: dict[str, float]
    points: tuple[float, ...]
    position: float

    def __str__(self) -> str:
        """One line."""
        where = ", ".join(f"{name} = {value:.13g}" for name, value in self.parameters.items())
        return f"{self.kind} at {where}: {self.what}"


@dataclass(frozen=True, eq=False, repr=False)
class CurvePoint(Result):
    """A point of a bifurcation curve, solved for anew.

    Attributes
    ----------
    parameters : dict
        Both parameter values by name.
    value, error : float
        Of the parameter that was solved for.
    residual : float
        Test function there.
    points : tuple of float
        The orbit.
    multipliers : tuple of float
        Of the orbit; of a border collision the one-sided ones.
    reading : Reading
    """

    parameters: dict[str, float]
    value: float
    error: float
    residual: float
    points: tuple[float, ...]
    multipliers: tuple[float, ...]
    reading: Reading = field(repr=False)
    _plot: ClassVar = "bifurcations.draw_curve_point"
    _has_picture: ClassVar = False

    def _columns(self) -> dict[str, Any]:
        facts: dict[str, Any] = {**self.parameters, "error": self.error, "residual": self.residual}
        facts |= {"points": self.points, "multipliers": self.multipliers}
        return {name: [value] for name, value in facts.items()}


@dataclass(frozen=True, eq=False, repr=False)
class BifurcationCurve(Result):
    """A bifurcation followed in the plane of two parameters; `continue_bifurcation` makes it.

    Attributes
    ----------
    kind : str
        Of the bifurcation: ``fold``, ``border_collision``, ...
    period : int
    along, solve_for : str
        Names of the two parameters.
    parameters : dict
        Both by name, shapes (n,), in the curve's order; ends of the range exactly.
    points : ndarray of float, shape (n, period)
        The orbit at each.
    multipliers : ndarray of float, shape (n,)
        Of the orbit; of a border collision that on the side it comes from.
    one_sided : ndarray of float, shape (n, 2)
        Left and right multiplier at the border; both `multipliers` for other kinds.
    end_reasons : tuple of str
        Why the curve ends at its first and at its last point.
    bifurcations : tuple of CodimensionTwo
        In the curve's order.
    conditions : tuple
        The condition at each point, to solve again from there.
    system : map family
        With values of all parameters; None after loading, if it cannot be stored.
    """

    kind: str
    period: int
    along: str
    solve_for: str
    parameters: dict[str, Floats]
    points: Floats
    multipliers: Floats
    one_sided: Floats
    end_reasons: tuple[str, str]
    bifurcations: tuple[CodimensionTwo, ...]
    conditions: tuple[Condition, ...]
    system: Any = None
    _plot: ClassVar = "bifurcations.draw_curve"

    def at(self, *, near: float | None = None, **where: float) -> CurvePoint:
        """Solve for the bifurcation at one value of either parameter: ``curve.at(alpha=1.2)``.

        Parameters
        ----------
        near : float, optional
            Of the other parameter: which solution is meant where the curve has several.
        **where
            One parameter by name.

        Raises
        ------
        ValueError
            Not one of the two parameters; a value that the curve does not reach, or
            reaches several times and ``near`` is not given.
        """
        name, value = self._one_of(where)
        near = None if near is None else finite_number("near", near)
        if self.system is None:
            raise ValueError("the curve was loaded without its system: load it with one.")
        other = self.solve_for if name == self.along else self.along
        index, guess = self._nearest(name, value, other, near)
        widths = np.abs(np.diff(self.parameters[other]))
        step = max(float(widths.max(initial=0.0)), AT_STEP * abs(guess))
        try:
            found = solve_near(
                self.conditions[index],
                lambda t: self.system.replace(**{name: value, other: t}),
                guess,
                step=step,
            )
        except ConditionLost as lost:
            raise ValueError(
                f"{name} = {value:.12g}: the bifurcation is not found there: {lost}."
            ) from lost
        return CurvePoint(
            parameters={name: value, other: found.value},
            value=found.value,
            error=found.error,
            residual=found.residual,
            points=found.reading.points,
            multipliers=found.reading.multipliers,
            reading=found.reading,
        )

    def _one_of(self, where: dict[str, float]) -> tuple[str, float]:
        if len(where) != 1 or not set(where) <= {self.along, self.solve_for}:
            raise ValueError(
                f"curve.at({', '.join(where)}): exactly one of {self.along}=... and "
                f"{self.solve_for}=... is needed."
            )
        ((name, value),) = where.items()
        return name, finite_number(name, value)

    def _nearest(
        self, name: str, value: float, other: str, near: float | None
    ) -> tuple[int, float]:
        """Find the closest point of the curve, by number, and a guess of ``other``."""
        x, y = self.parameters[name], self.parameters[other]
        if not x.min() <= value <= x.max():
            raise ValueError(
                f"{name} = {value:.12g} is not on the curve, whose {name} runs from "
                f"{x.min():.12g} to {x.max():.12g}."
            )
        crossed = np.flatnonzero((x[:-1] - value) * (x[1:] - value) <= 0)
        with np.errstate(all="ignore"):
            share = np.nan_to_num((value - x[crossed]) / (x[crossed + 1] - x[crossed]))
        guesses = y[crossed] + share * (y[crossed + 1] - y[crossed])
        places = crossed + np.round(share).astype(np.intp)
        if near is None and len(set(places.tolist())) > 1:
            raise ValueError(
                f"the curve passes {name} = {value:.12g} several times, at {other} = "
                f"{', '.join(f'{guess:.8g}' for guess in guesses)}. Say which: near=..."
            )
        pick = 0 if near is None else int(np.argmin(np.abs(guesses - near)))
        return int(places[pick]), float(guesses[pick])

    def __repr__(self) -> str:
        """Say what is followed, its points, its ends, and where its type changes."""
        x, y = self.parameters[self.along], self.parameters[self.solve_for]
        lines = [
            f"BifurcationCurve: {self.kind.replace('_', ' ')} of period {self.period}, "
            f"{self.solve_for} over {self.along}, {len(x)} points",
            f"  {self.along:<20s} {self.solve_for:<20s} multiplier",
        ]
        for i in _spread(len(x), SHOWN):
            lines.append(f"  {x[i]:<20.13g} {y[i]:<20.13g} {self.multipliers[i]:.8g}")
        lines.append(f"  ends: {self.end_reasons[0]}; {self.end_reasons[1]}")
        lines += [f"  {mark}" for mark in self.bifurcations]
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        return {
            **self.parameters,
            "multiplier": self.multipliers,
            "multiplier_left": self.one_sided[:, 0],
            "multiplier_right": self.one_sided[:, 1],
            "points": list(self.points),
        }


@dataclass(frozen=True, eq=False, repr=False)
class BreakpointCurve(Result):
    """A breakpoint followed along one parameter; `continue_breakpoint` makes it.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
        Ascending values of the parameter.
    d : ndarray of float, shape (n,)
        Where the breakpoint is.
    left, right, left_slope, right_slope : ndarray of float, shape (n,)
        One-sided values and slopes of the map.
    kinds : tuple of str, length n
        ``jump``, ``corner``, ``smooth`` or ``edge``.
    end_reasons : tuple of str
        Why the curve ends at its lowest and highest value.
    borders : tuple of TrackedDiscontinuity, length n
    system : map family
    """

    parameter: str
    values: Floats
    d: Floats
    left: Floats
    right: Floats
    left_slope: Floats
    right_slope: Floats
    kinds: tuple[str, ...]
    end_reasons: tuple[str, str]
    borders: tuple[TrackedDiscontinuity, ...]
    system: Any = None
    _plot: ClassVar = "bifurcations.draw_breakpoint_curve"

    def at(self, **where: float) -> CriticalReading:
        """Find the breakpoint at one value of the parameter: ``curve.at(V=0.037)``.

        Raises
        ------
        ValueError
            Not the curve's parameter, or a value outside the curve.
        """
        if set(where) != {self.parameter}:
            raise ValueError(
                f"curve.at({', '.join(where)}): {self.parameter}=... is needed, nothing else."
            )
        value = float(where[self.parameter])
        low, high = float(self.values[0]), float(self.values[-1])
        if not low <= value <= high:
            raise ValueError(
                f"{self.parameter} = {value:.12g} is outside the curve, [{low:.12g}, {high:.12g}]."
            )
        if self.system is None:
            raise ValueError("the curve was loaded without its system: load it with one.")
        nearest = self.borders[int(np.argmin(np.abs(self.values - value)))]
        try:
            return nearest.at(self.system.replace(**{self.parameter: value}))
        except ConditionLost as lost:
            raise ValueError(f"{self.parameter} = {value:.12g}: {lost}.") from lost

    def __repr__(self) -> str:
        """Position, values and slopes over the parameter, and the ends."""
        lines = [
            f"BreakpointCurve: {len(self.values)} points",
            f"  {self.parameter:<20s} d                    f(d-)         f(d+)         kind",
        ]
        for i in _spread(len(self.values), SHOWN):
            lines.append(
                f"  {self.values[i]:<20.13g} {self.d[i]:<20.13g} {self.left[i]:<13.8g} "
                f"{self.right[i]:<13.8g} {self.kinds[i]}"
            )
        lines.append(f"  ends: {self.end_reasons[0]}; {self.end_reasons[1]}")
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        names = ("d", "left", "right", "left_slope", "right_slope")
        columns = {name: getattr(self, name) for name in names}
        return {self.parameter: self.values, **columns, "kind": self.kinds}


def _spread(n: int, shown: int) -> list[int]:
    """At most ``shown`` of n numbers, evenly, the first and the last among them."""
    return sorted({round(k) for k in np.linspace(0, n - 1, min(n, shown)).tolist()})
