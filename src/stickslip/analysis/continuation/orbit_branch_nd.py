"""Branches of periodic orbits of maps of R^n along a parameter."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.orbits.newton_nd import solve_orbits
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND, make_orbit, multipliers_text
from stickslip.numerics.branch import AlongParameter
from stickslip.results.parts import part
from stickslip.results.result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels
    from stickslip.analysis.maps.protocol_nd import FamilyND

EndReasonND: TypeAlias = Literal[
    "end of range",
    "breakpoint",
    "gap",
    "end of domain",
    "period halves",
    "point limit",
    "step limit",
]
KindND: TypeAlias = Literal["fold", "flip", "neimark_sacker"]

SHOWN: Final = 8  # rows of a branch in its repr, besides ends and bifurcations


@part
@dataclass(frozen=True, eq=False)
class OrbitEndND:
    """Why a branch of orbits ends, and where.

    Attributes
    ----------
    reason : str
        ``end of range``; ``breakpoint``: a border collision, a point of the orbit meets the end
        of its piece of the map; ``gap``: beyond that end the map has no value; ``end of
        domain``; ``period halves``: the orbit merges with one of half its period, which flips
        there; ``point limit`` and ``step limit``: given up.
    value : float
        The parameter there.
    error : float
        How far beyond `value` the end may be.
    points : ndarray of float, shape (period, n)
        The orbit there.
    multipliers : ndarray of complex, shape (n,)
        One-sided.
    index : int or None
        Which of `points` meets the end of its piece.
    kind : {"jump", "corner", ""}
        Of a breakpoint: whether the value jumps there, or the Jacobian only.
    """

    reason: EndReasonND
    value: float
    error: float
    points: Floats
    multipliers: NDArray[np.complex128]
    index: int | None = None
    kind: Literal["jump", "corner", ""] = ""


@part
@dataclass(frozen=True, eq=False)
class PassedBifurcationND:
    """A bifurcation on the way along a branch.

    Attributes
    ----------
    kind : {"fold", "flip", "neimark_sacker"}
    value : float
        Of the parameter.
    points : ndarray of float, shape (period, n)
        The orbit there, ordered as along the branch.
    multipliers : ndarray of complex, shape (n,)
        One is 1 (fold) or -1 (flip), or two are a pair on the unit circle, to rounding.
    row : int
        The branch's row that is this point.
    """

    kind: KindND
    value: float
    points: Floats
    multipliers: NDArray[np.complex128]
    row: int

    @property
    def rotation(self) -> float:
        """Turn of the critical pair per period of the orbit, 0 to 1/2 of a full one."""
        off = np.abs(np.abs(self.multipliers) - 1.0)
        return float(abs(np.angle(self.multipliers[np.argmin(off)])) / (2 * np.pi))


@dataclass(frozen=True, eq=False, repr=False)
class OrbitBranchND(AlongParameter, Result):
    """A periodic orbit of a map of R^n followed along a parameter, through folds.

    Attributes
    ----------
    parameters : dict of str to ndarray of float, shape (m,)
        The varied parameter by its name, along the branch. It turns back at folds.
    points : ndarray of float, shape (m, period, n)
        In the map's order; the first one is the same point of the orbit all along.
    multipliers : ndarray of complex, shape (m, n)
    period : int
    labels : ndarray of uint64, shape (m, period)
    residual : ndarray of float, shape (m,)
    ends : tuple of OrbitEndND
        First and last.
    bifurcations : tuple of PassedBifurcationND
        On the way, each of which is a row of the branch.
    f : FamilyND or None
        The map, at the parameters it had when the continuation began.
    """

    parameters: dict[str, Floats]
    points: Floats
    multipliers: NDArray[np.complex128]
    period: int
    labels: Labels = field(repr=False)
    residual: Floats = field(repr=False)
    ends: tuple[OrbitEndND, OrbitEndND]
    bifurcations: tuple[PassedBifurcationND, ...] = ()
    f: FamilyND | None = None
    _plot: ClassVar = "bifurcations.draw_branch_nd"

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where all multipliers are inside the unit circle, shape (m,)."""
        return np.asarray(np.abs(self.multipliers).max(axis=1) < 1.0)

    def at(self, **value: float) -> tuple[PeriodicOrbitND, ...]:
        """Solve anew for the orbits of the branch at a value of its parameter.

        Parameters
        ----------
        **value
            The parameter by its name, such as ``V=0.037``.

        Returns
        -------
        tuple of PeriodicOrbitND
            One for each time the branch passes that value, in the order of the branch.

        Raises
        ------
        ValueError
            Another parameter, a value that the branch does not reach, or no map (a branch
            loaded without its system).
        """
        if self.f is None:
            raise ValueError("the branch has no map: load it with system=.")
        q = self._checked_value(value)
        f = self.f.replace(**{self.parameter: q})
        sides = np.sign(self.values - q)
        rows = [k for k in range(len(sides) - 1) if sides[k] * sides[k + 1] < 0 or sides[k] == 0]
        if len(sides) and sides[-1] == 0:
            rows.append(len(sides) - 1)
        guesses = np.stack([self._between(k, q) for k in rows])
        got = solve_orbits(f, guesses)
        return tuple(
            make_orbit(f, got.points[k], got.jacobians[k], got.labels[k], got.residual[k])
            for k in np.flatnonzero(got.found)
        )

    def _between(self, row: int, q: float) -> Floats:
        """Points at a parameter value between a row and the next, along a straight line."""
        if self.values[row] == q:
            return np.asarray(self.points[row])
        share = (q - self.values[row]) / (self.values[row + 1] - self.values[row])
        return np.asarray(self.points[row] + share * (self.points[row + 1] - self.points[row]))

    def __repr__(self) -> str:
        """Range, ends and bifurcations; a few of the points."""
        name, q = self.parameter, self.values
        lines = [
            f"OrbitBranchND: period {self.period}, {len(self)} points, {name} from {q[0]:.12g} to "
            f"{q[-1]:.12g}",
            f"  {name:>18s}  multipliers; first point",
        ]
        named: dict[int, str] = {0: self.ends[0].reason, len(self) - 1: self.ends[1].reason}
        named |= {item.row: item.kind.replace("_", "-") for item in self.bifurcations}
        for row in sorted(named.keys() | set(range(0, len(self), max(1, len(self) // SHOWN)))):
            point = ", ".join(f"{x:.10g}" for x in self.points[row, 0])
            text = f"  {q[row]:18.14g}  {multipliers_text(self.multipliers[row])}; {point}"
            lines.append(f"{text}  {named.get(row, '')}".rstrip())
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        return {
            self.parameter: self.values,
            "multiplier": np.abs(self.multipliers).max(axis=1),
            "stable": self.stable,
            "residual": self.residual,
            "points": list(self.points),
        }
