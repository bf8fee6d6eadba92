"""Branches of periodic orbits along a parameter: what `continue_orbit` returns."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.orbits.newton import itinerary_of, solve_orbit
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.numerics.branch import AlongParameter
from stickslip.results.parts import part
from stickslip.results.result import Result
from stickslip.results.table import numbered

if TYPE_CHECKING:
    from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
    from stickslip.analysis.maps.protocol import Floats, Labels, MapFamily

EndReason: TypeAlias = Literal[
    "end of range",
    "breakpoint",
    "gap",
    "end of domain",
    "period halves",
    "crossing",
    "closed",
    "point limit",
    "step limit",
]


SHOWN: Final = 8  # rows of a branch in its repr, besides ends and bifurcations
POINTS_SHOWN: Final = 4  # of an orbit, in a line of it
APPROACHES: Final = 16  # steps towards an orbit that a straight line does not lead to
SAME: Final = 1e-13  # of the points: orbits that coincide


@part
@dataclass(frozen=True, eq=False)
class BranchEnd:
    """Why a branch of orbits ends, and where.

    Attributes
    ----------
    reason : str
        ``end of range``; ``breakpoint``: a point of the orbit meets a jump or a corner of
        the map; ``gap``: it meets the edge of one; ``end of domain``: it meets the end of the
        map's domain or window; ``period halves``: the orbit merges with one of half its
        period, which flips there; ``crossing``: it meets another orbit, which goes on;
        ``closed``: the branch is a closed curve and has come back
        to its start; ``point limit`` and ``step limit``: given up after too many steps, or
        where the step became too small.
    value : float
        The parameter there.
    points : ndarray of float, shape (period,)
        The orbit there, a one-sided limit at a breakpoint.
    multiplier : float
        Likewise one-sided.
    border : TrackedDiscontinuity or None
        The break that was met; None at the end of the domain.
    index : int or None
        Which of `points` lies on the break or the end of the domain.
    side : int
        -1 if the orbit comes from the left of the break, 1 from the right; 0 if there is none.
    """

    reason: EndReason
    value: float
    points: Floats
    multiplier: float
    border: TrackedDiscontinuity | None = None
    index: int | None = None
    side: int = 0


@part
@dataclass(frozen=True, eq=False)
class PassedBifurcation:
    """A fold or a flip on the way along a branch.

    Attributes
    ----------
    kind : {"fold", "flip", "transcritical", "pitchfork"}
    value : float
        Of the parameter.
    points : ndarray of float, shape (period,)
        The orbit there, ordered as along the branch.
    multiplier : float
        1 or -1 to rounding.
    error : float
        Bound of the error of `value`.
    row : int
        The branch's row that is this point.
    """

    kind: Literal["fold", "flip", "transcritical", "pitchfork"]
    value: float
    points: Floats
    multiplier: float
    error: float
    row: int


@dataclass(frozen=True, eq=False, repr=False)
class OrbitBranch(AlongParameter, Result):
    """A periodic orbit of a map followed along a parameter, through folds.

    Attributes
    ----------
    parameters : dict of str to ndarray of float, shape (n,)
        The varied parameter by its name, along the branch. It turns back at folds.
    points : ndarray of float, shape (n, period)
        In the map's order; the first column is one point of the orbit all along.
    multipliers : ndarray of float, shape (n,)
    period : int
    labels : ndarray of uint64, shape (n, period)
        Branches of the points.
    residual : ndarray of float, shape (n,)
        Largest abs(f(x_i) - x_(i+1)) of each row.
    ends : tuple of BranchEnd
        First and last.
    bifurcations : tuple of PassedBifurcation
        Folds and flips on the way, each of which is a row of the branch.
    f : MapFamily or None
        The map, restricted to the window if one was given, at the parameters it had when
        the continuation began; None for a branch loaded without its system.
    """

    parameters: dict[str, Floats]
    points: Floats
    multipliers: Floats
    period: int
    labels: Labels = field(repr=False)
    residual: Floats = field(repr=False)
    ends: tuple[BranchEnd, BranchEnd]
    bifurcations: tuple[PassedBifurcation, ...] = ()
    f: MapFamily | None = None
    _plot: ClassVar = "bifurcations.draw_branch"

    @property
    def stable(self) -> Any:
        """Where the multiplier is inside (-1, 1), ndarray of bool, shape (n,)."""
        return np.abs(self.multipliers) < 1

    @property
    def end_reasons(self) -> tuple[EndReason, EndReason]:
        """Why the branch ends where it begins, and where it ends (see `BranchEnd`)."""
        return self.ends[0].reason, self.ends[1].reason

    # ------------------------------------------------------------------ orbits on it

    def at(self, **value: float) -> PeriodicOrbit:
        """Solve for the orbit at a parameter value, given by its name.

        Raises
        ------
        ValueError
            The value is outside the branch; or the branch passes it several times
            (`all_at` returns all of them); or the parameter has another name; or the branch
            was loaded without its system.

        Examples
        --------
        >>> import stickslip as ss
        >>> from stickslip.analysis.continuation.continuation import continue_orbit
        >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 2})
        >>> branch = continue_orbit(ss.periodic_orbits(f)[1], f, "r", (1.5, 3.4))
        >>> branch.at(r=2.5).points
        array([0.6])
        """
        found = self.all_at(**value)
        if len(found) > 1:
            ((name, number),) = value.items()
            raise ValueError(
                f"the branch passes {name} = {number:.15g} {len(found)} times. "
                f"Take branch.all_at({name}={number:.15g}), in their order along the branch."
            )
        return found[0]

    def all_at(self, **value: float) -> tuple[PeriodicOrbit, ...]:
        """Solve for all orbits of the branch at a parameter value, in their order along it.

        Raises
        ------
        ValueError
            As for `at`, which is for branches that pass each value once.
        """
        number = self._checked_value(value)
        if self.f is None:
            raise ValueError(
                "the branch was loaded without its system: load(path, system=...) gives it back."
            )
        found: list[PeriodicOrbit] = []
        for row, between in self._places(number):
            orbit = self._orbit_between(row, number) if between else self._orbit_of_row(row)
            # At a fold both neighbours lead to the same orbit.
            if not any(_same(orbit, other) for other in found):
                found.append(orbit)
        return tuple(found)

    def _places(self, number: float) -> list[tuple[int, bool]]:
        """Rows with a parameter value, and rows after which it is passed (True)."""
        off = self.values - number
        passed = np.append(off[:-1] * off[1:] < 0, False)
        rows = np.flatnonzero((off == 0) | passed)
        return [(int(row), bool(passed[row])) for row in rows]

    def _orbit_between(self, row: int, number: float) -> PeriodicOrbit:
        """Solve for the orbit between two rows: from a straight line; beside a fold, in steps."""
        ends = (row, row + 1)
        (q, r), (x, y) = self.values[list(ends)], self.points[list(ends)]
        orbit = self._solved(number, x + (number - q) / (r - q) * (y - x))
        for start, goal in (ends[::-1], ends):
            if orbit.quality == "located":
                break
            orbit = self._approached(start, goal, number)
        return orbit

    def _approached(self, start: int, goal: int, number: float) -> PeriodicOrbit:
        q, r = self.values[start], self.values[goal]
        share = (abs(number - r) / abs(q - r)) ** (np.arange(1, APPROACHES + 1) / APPROACHES)
        now, x = q, self.points[start]
        speed = np.zeros_like(x)
        for value in [*(r + share[:-1] * (q - r)).tolist(), number]:
            orbit = self._solved(value, x + (value - now) * speed)
            if orbit.quality != "located":
                break
            shift = int(np.argmin(np.abs(orbit.points - x[0])))
            points = np.roll(orbit.points, -shift)
            speed, x, now = (points - x) / (value - now), points, value
        return orbit

    def _solved(self, number: float, guess: Floats) -> PeriodicOrbit:
        assert self.f is not None
        return solve_orbit(self.f.replace(**{self.parameter: number}), guess)

    def _orbit_of_row(self, row: int) -> PeriodicOrbit:
        """Return the orbit of a row as it was solved: at an end, a one-sided limit."""
        assert self.f is not None
        f = self.f.replace(**{self.parameter: float(self.values[row])})
        start = int(np.argmin(self.points[row]))
        points, labels = np.roll(self.points[row], -start), np.roll(self.labels[row], -start)
        multiplier = float(self.multipliers[row])
        return PeriodicOrbit(
            points=points,
            period=self.period,
            multiplier=multiplier,
            stable=abs(multiplier) < 1,
            itinerary=itinerary_of(f, points, labels),
            labels=labels,
            quality="located",
            interval=points[:, None] + self.residual[row] * np.array([-1.0, 1.0]),
            residual=float(self.residual[row]),
        )

    # ------------------------------------------------------------------ shown and kept

    def __repr__(self) -> str:
        """Range, ends and bifurcations; a few of the points."""
        name, q = self.parameter, self.values
        lines = [
            f"OrbitBranch: period {self.period}, {len(self)} points, {name} from {q[0]:.12g} to "
            f"{q[-1]:.12g}",
            f"  {name:>18s}      multiplier  points",
        ]
        named = {0: f"{self.ends[0].reason}", len(self) - 1: f"{self.ends[1].reason}"}
        named |= {item.row: item.kind for item in self.bifurcations}
        for row in sorted(named.keys() | set(range(0, len(self), max(1, len(self) // SHOWN)))):
            points = ", ".join(f"{x:.10g}" for x in self.points[row, :POINTS_SHOWN])
            more = ", ..." if self.period > POINTS_SHOWN else ""
            text = f"  {q[row]:18.14g}  {self.multipliers[row]:14.8g}  {points}{more}"
            lines.append(f"{text}  {named.get(row, '')}".rstrip())
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        return {
            self.parameter: self.values,
            "multiplier": self.multipliers,
            "stable": self.stable,
            "residual": self.residual,
            **numbered("d", self.points),
        }


def _same(one: PeriodicOrbit, other: PeriodicOrbit) -> bool:
    """Tell whether two solutions at one parameter value are one orbit, to their errors."""
    errors = np.ptp(one.interval, axis=1) + np.ptp(other.interval, axis=1)
    apart = np.abs(one.points - other.points)
    return bool((apart <= errors + SAME * np.abs(one.points).max()).all())
