"""Solution curves: what `stickslip.follow` returns, whatever was followed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.scales import LISTED
from stickslip.checks import finite_number
from stickslip.results.parts import part
from stickslip.results.result import Result
from stickslip.results.table import free_name, listed, numbered

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.maps.protocol import Bools, Floats


POINTS_SHOWN: Final = 4  # of a solution, in a line of it


class _Place:
    """What ends and events of a curve have in common."""

    parameters: dict[str, float]
    multipliers: Any

    @property
    def value(self) -> float:
        """Of the parameter that the curve is followed along."""
        return next(iter(self.parameters.values()))

    @property
    def multiplier(self) -> Any:
        """The multiplier closest to the unit circle."""
        values = np.asarray(self.multipliers)
        if values.ndim == 0:
            return self.multipliers
        return values[np.argmin(np.abs(np.abs(values) - 1.0))]


@part
@dataclass(frozen=True, eq=False)
class CurveEnd(_Place):
    """Why a curve ends, and where.

    Attributes
    ----------
    reason : str
        ``end of range``; ``closed``: the curve has come back to its start; ``point limit`` and
        ``step limit``: given up after too many steps, or where steps became too small;
        ``interrupted``: by Ctrl-C, where a partial answer was wanted; ``period halves``: the orbit
        or cycle merges with one of half its period, which flips there.
        Of orbits also ``breakpoint``: a point of the orbit meets a jump or a corner of the map;
        ``gap``: it meets the edge of one; ``end of domain``; ``crossing``: it meets another orbit,
        which goes on. Of cycles ``grazing``, ``limit``, ``landing`` or ``tie``: modes change and
        no cycle with other modes was found beside it; ``vanishes``: it shrinks onto steady
        sliding. Of bifurcations and breakpoints a sentence.
    parameters : dict
        Parameter values there, by name.
    points : ndarray of float
        The solution there, as in a row of `Curve.points`; a one-sided limit at a breakpoint.
    multipliers : float or ndarray of complex
        Likewise one-sided.
    error : float
        How far beyond the parameter value the end may be.
    index : int or None
        Which of an orbit's points lies on the break or the end of the domain.
    side : int
        -1 if the orbit comes from the left of the break, 1 from the right; 0 if there is none.
    kind : str
        Of a breakpoint of a map of R^n: ``jump`` or ``corner``.
    border : object
        The break that was met, of a map of a line; in R^n its mechanism and the block that it
        concerns, if the map tells.
    """

    reason: str
    parameters: dict[str, float]
    points: Floats
    multipliers: Any = ()
    error: float = 0.0
    index: int | None = None
    side: int = 0
    kind: str = ""
    border: Any = None


@part
@dataclass(frozen=True, eq=False, repr=False)
class CurveEvent(_Place):
    """A bifurcation on the way along a curve.

    Attributes
    ----------
    kind : str
        Of orbits and cycles ``fold``, ``flip``, ``neimark_sacker``, ``transcritical``,
        ``pitchfork`` or ``branch_point`` (a multiplier 1 without a fold); ``hopf``. Of orbits in
        R^n also ``border``: a point goes over to another piece of the map (a slip begins to graze,
        two events change their order), and no multiplier changes. Of cycles also
        what changes the sequence of modes: ``grazing`` (a slip touches the belt), ``limit`` (the
        needed force of a rider touches its static limit), ``landing`` (a block lands exactly at
        its limit), ``tie`` (events of two blocks at once). Of bifurcations, points of codimension
        two: ``cusp``, ``breakpoint``, ``generalised flip``, ``multiplier 1``, ``multiplier -1``,
        ``multiplier 0``, ``kind of border``, ``second border`` or ``end of border``; in R^n also
        ``fold-flip``, ``resonance 1:1`` to ``resonance 1:4``, ``multiplier 1``, ``multiplier -1``.
    parameters : dict
        Parameter values there, by name.
    points : ndarray of float
        The solution there, as in a row of `Curve.points`.
    multipliers : float or ndarray of complex
    error : float
        Bound of the error of `value`; NaN where none is known.
    row : int
        The curve's row that is this point; at a Hopf point, and at a crossing of two curves that
        is only bracketed, the one just before.
    what : str
        What else is to be said.
    block : int or None
        That touches or lands, from 1.
    outcome : {"persists", "fold", None}
        Where modes change: whether the solution goes on with other modes on the far side, or meets
        another one that exists on the same side (a discontinuous fold: both end there).
    solution : object
        A cycle there; where modes change, the last one with the modes before. None for others.
    """

    kind: str
    parameters: dict[str, float]
    points: Floats
    multipliers: Any
    error: float
    row: int
    what: str = ""
    block: int | None = None
    outcome: str | None = None
    solution: Any = None

    @property
    def rotation(self) -> float:
        """Turn of the critical pair per period of an orbit, 0 to 1/2 of a full one."""
        return float(abs(np.angle(self.multiplier)) / (2 * np.pi))

    def __repr__(self) -> str:
        """One line."""
        where = ", ".join(f"{name} = {value:.13g}" for name, value in self.parameters.items())
        error = "" if np.isnan(self.error) else f" (error {self.error:.1g})"
        return f"{self.kind} at {where}{error}{': ' if self.what else ''}{self.what}"


class Problem:
    """What is solved along a curve, and how it is solved anew: one class for each kind."""

    system: Any  # map or model, with values of all parameters; None if loaded without it
    picture: ClassVar[str]  # module and function of `stickslip.plot`

    def row(self, curve: Curve, row: int) -> Any:
        """Return the solution of a row, solved for anew where it was not kept."""
        return self.solve(curve, row, 0.0, curve.parameter, float(curve.values[row]))

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Any:
        """Solve for it at a parameter value, met after a share of the way from a row to the next.

        None if there is none, of which nothing is to be said.
        """
        raise NotImplementedError

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return numbers by which solutions at one value are told apart: points, on a line."""
        return between(curve.points, row, share).ravel()

    def same(self, one: Any, other: Any) -> bool:
        """Tell whether two solutions at one parameter value are one."""
        return False


@dataclass(frozen=True, eq=False, repr=False)
class Curve(Result):
    """A solution followed along a parameter; `stickslip.follow` makes it.

    Short for *solution curve*; the word branch is reserved for the branches of a map. A sequence:
    ``curve[k]`` is the solution of row k.

    Attributes
    ----------
    kind : str
        ``orbit``, ``cycle``, ``equilibrium``, ``breakpoint``, or ``bifurcation: fold`` and so on.
    parameters : dict of str to ndarray of float, shape (n,)
        By name: the varied parameter, in order along the curve (it turns back at folds); of a
        bifurcation then the one that is solved for.
    points : ndarray of float, shape (n, k)
        Points of the orbit (n, period), of an orbit in R^m (n, period, m); displacements of a
        cycle where its period begins, and of an equilibrium; where the breakpoint is, (n, 1).
    multipliers : ndarray, shape (n,) or (n, m)
        Of an orbit of a map of a line, of a bifurcating one (of a border collision on the side it
        comes from); all of an orbit in R^m or of a cycle, complex; the eigenvalues of an
        equilibrium. A breakpoint has none, (n, 0).
    stable : ndarray of bool, shape (n,)
        Where the solution attracts.
    ends : tuple of CurveEnd
        First and last.
    bifurcations : tuple of CurveEvent
        On the way, in the curve's order.
    data : dict
        Further columns: ``labels``, ``residual`` and ``margin`` (the least, see
        `EventMapResult`; NaN where the map tells none) of orbits, ``period`` and ``events`` (their
        number) of cycles, ``left``, ``right``, ``left_slope``, ``right_slope`` and ``kind`` of
        breakpoints, ``multiplier_left`` and ``multiplier_right`` of border collisions; of
        bifurcations in R^n ``angle`` of the critical multiplier (NaN: none) and ``labels``.
    problem : Problem
        What is solved, and how to solve it anew.
    period : int or None
        Of orbits and their bifurcations.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.5)
    >>> ss.follow(ss.equilibria(block)[0], "damping", (1.0, 2.0)).bifurcations
    (hopf at damping = 1.171875 (error 5e-16): frequency 1, calms as damping grows,)
    """

    kind: str
    parameters: dict[str, Floats]
    points: Floats
    multipliers: Any = field(repr=False)
    stable: Bools = field(repr=False)
    ends: tuple[CurveEnd, CurveEnd]
    bifurcations: tuple[CurveEvent, ...]
    data: dict[str, Any]
    problem: Any
    period: int | None = None

    @property
    def parameter(self) -> str:
        """Name of the varied parameter."""
        return next(iter(self.parameters))

    @property
    def values(self) -> Floats:
        """Values of the varied parameter, shape (n,)."""
        return self.parameters[self.parameter]

    @property
    def solve_for(self) -> str | None:
        """Name of the parameter that is solved for along a bifurcation, else None."""
        return [*self.parameters, None][1]

    @property
    def end_reasons(self) -> tuple[str, str]:
        """Why the curve ends where it begins, and where it ends (see `CurveEnd`)."""
        return self.ends[0].reason, self.ends[1].reason

    @property
    def system(self) -> Any:
        """The map or model, with the parameters it had when it was followed; None if not loaded."""
        return self.problem.system

    def __len__(self) -> int:
        """Return the number of solutions computed."""
        return len(self.values)

    def __getitem__(self, row: int | slice) -> Any:
        """Return the solution of a row as it was computed, or several as a tuple."""
        rows = range(len(self))[row]
        if isinstance(rows, int):
            return self._solving().row(self, rows)
        return tuple(self._solving().row(self, each) for each in rows)

    def __iter__(self) -> Iterator[Any]:
        """Go through the solutions of all rows."""
        return iter(self[:])

    # ------------------------------------------------------------------ solutions on it

    def at(self, *, near: float | None = None, **value: float) -> Any:
        """Solve anew at a value of a parameter, given by its name: ``curve.at(V=0.037)``.

        Parameters
        ----------
        near : float, optional
            Which solution is meant where the curve passes the value several times: a point of
            the orbit, the period of the cycle, the other parameter of the bifurcation.
        **value
            One parameter by name.

        Returns
        -------
        PeriodicOrbit, PeriodicOrbitND, Cycle, Equilibrium, Breakpoint or Bifurcation

        Raises
        ------
        ValueError
            Not a parameter of the curve; a value that it does not reach, or passes several times
            if ``near`` is not given; or the curve was loaded without its system.

        Examples
        --------
        >>> import stickslip as ss
        >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 2})
        >>> curve = ss.follow(ss.periodic_orbits(f)[1], "r", (1.5, 3.4))
        >>> curve.at(r=2.5).points
        array([0.6])
        """
        name, number = self._asked(value)
        problem, passes = self._solving(), self._passes(name, number)
        guesses = [problem.guess(self, *way, name) for way in passes]
        if near is not None:
            sought = finite_number("near", near)
            away = [float(np.abs(guess - sought).min()) for guess in guesses]
            passes = [passes[int(np.argmin(away))]]
        found = self._solved(passes, name, number)
        if len(found) > 1:
            places = ", ".join(f"{guess[0]:.8g}" for guess in guesses)
            raise ValueError(
                f"the curve passes {name} = {number:.15g} {len(found)} times, at {places}. "
                f"Say which: near=...; or take all_at({name}={number:.15g})."
            )
        if not found:
            raise ValueError(f"{name} = {number:.12g}: no solution is found there.")
        return found[0]

    def all_at(self, **value: float) -> tuple[Any, ...]:
        """Solve for all solutions at a value of a parameter, in their order along the curve.

        Raises
        ------
        ValueError
            As for `at`, which is for curves that pass a value once.
        """
        name, number = self._asked(value)
        return tuple(self._solved(self._passes(name, number), name, number))

    def _solving(self) -> Problem:
        if self.system is None:
            raise ValueError(
                "the curve was loaded without its system: load(path, system=...) gives it back."
            )
        return self.problem

    def _solved(self, passes: list[tuple[int, float]], name: str, number: float) -> list[Any]:
        problem = self._solving()
        found: list[Any] = []
        for row, share in passes:
            solution = problem.solve(self, row, share, name, number)
            # At a fold both neighbours lead to the same solution.
            if solution is not None and not any(problem.same(solution, old) for old in found):
                found.append(solution)
        return found

    def _asked(self, given: dict[str, Any]) -> tuple[str, float]:
        """Return a parameter and its value, if the curve reaches it."""
        if len(given) != 1 or not set(given) <= set(self.parameters):
            ways = " or ".join(f"at({name}=...)" for name in self.parameters)
            raise ValueError(
                f"at({', '.join(given)}): the curve is one along {' and '.join(self.parameters)}; "
                f"give its value as {ways}."
            )
        ((name, value),) = given.items()
        number, values = finite_number(name, value), self.parameters[name]
        if not values.min() <= number <= values.max():
            raise ValueError(
                f"{name} = {number:.15g} is outside the curve, [{values.min():.15g}, "
                f"{values.max():.15g}]."
            )
        return name, number

    def _passes(self, name: str, number: float) -> list[tuple[int, float]]:
        """Rows at or before a parameter value, and the shares of the way to the next one."""
        values = self.parameters[name]
        off = values - number
        passed = np.append(off[:-1] * off[1:] < 0, False)
        return [
            (row, (number - values[row]) / (values[row + 1] - values[row]) if passed[row] else 0.0)
            for row in np.flatnonzero((off == 0) | passed).tolist()
        ]

    # ------------------------------------------------------------------ shown and kept

    def __repr__(self) -> str:
        """Range, ends and bifurcations; a few of the rows."""
        period = "" if self.period is None else f" of period {self.period}"
        over = "" if self.solve_for is None else f"{self.solve_for} over "
        first, last = (f"{end.value:.13g}" for end in self.ends)
        number = "eigenvalue" if self.kind == "equilibrium" else "multiplier"
        lines = [
            f"Curve: {self.kind}{period}, {len(self)} points, {over}{self.parameter}",
            f"  begins: {self.ends[0].reason} at {first}",
            *(f"  {item!r}" for item in self.bifurcations),
            f"  ends: {self.ends[1].reason} at {last}",
            "".join(f"  {name:>18s}" for name in self.parameters)
            + (f"  {number:>14s}" if self.multipliers.size else "")
            + "  points",
        ]
        for row in sorted({round(k) for k in np.linspace(0, len(self) - 1, LISTED)}):
            text = "".join(f"  {values[row]:18.14g}" for values in self.parameters.values())
            if self.multipliers.size:
                leading = np.atleast_1d(self.multipliers[row])[0]
                text += f"  {leading:14.8g}" if np.isreal(leading) else f"  {leading:.6g}"
            points = (f"{x:.10g}" for x in self.points[row].ravel())
            lines.append(f"{text}  {listed(points, POINTS_SHOWN)}")
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        others = self._other_columns()
        own = {free_name(name, others): item for name, item in self.parameters.items()}
        return {**own, **others}

    def _other_columns(self) -> dict[str, Any]:
        columns: dict[str, Any] = {}
        if self.kind == "equilibrium":
            columns["growth_rate"] = self.multipliers.real.max(axis=1)
        elif self.multipliers.ndim == 1:
            columns["multiplier"] = self.multipliers
        elif self.multipliers.size:
            columns["multiplier"] = np.abs(self.multipliers).max(axis=1)
        columns["stable"] = self.stable
        columns |= {name: item for name, item in self.data.items() if np.ndim(item) == 1}
        if self.points.ndim > 2:
            return {**columns, "points": list(self.points)}
        name = "x" if self.kind in ("cycle", "equilibrium") else "d"
        return {**columns, **numbered(name, self.points)}

    def _coordinates(self) -> tuple[str, ...]:
        return (free_name(self.parameter, self._other_columns()),)

    @property
    def _plot(self) -> str:  # type: ignore[override]
        return self.problem.picture


def between(rows: Floats, row: int, share: float) -> Floats:
    """Go from a row along a straight line to the next."""
    here: Floats = rows[row]
    return here + share * (rows[row + 1] - here) if share else here
