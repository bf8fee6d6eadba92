"""Bifurcation diagrams: periodic orbits, attractors and breakpoints over a parameter."""

from __future__ import annotations

import importlib
import itertools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.checks import whole_number
from stickslip.extras import require_extra
from stickslip.results.parts import part
from stickslip.results.result import Result
from stickslip.results.table import SHOWN, Table, free_name, more, numbered

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.bifurcation import Coverage
    from stickslip.analysis.continuation.curve import CurveEnd
    from stickslip.analysis.maps.protocol import Bools, Floats, Indices

LAST: Final = ("multiplier", "lyapunov")  # columns behind those of the points
LABELS: Final = (
    *("orbit", "multiplier", "period", "attractor", "attractor_at", "attractor_kind"),
    *("attractor_period", "lyapunov", "breakpoint", "breakpoint_kind"),
    *("branch", "point", "row", "iterate", "line", "coordinate"),
)
"""Variables and dimensions of the labelled arrays."""


@part
@dataclass(frozen=True, eq=False)
class OrbitCurve:
    """One periodic orbit over the values at which it exists.

    Attributes
    ----------
    period : int
        Minimal.
    points : ndarray of float, shape (n, p), in R^m (n, p, m)
        In the map's order, each column following one point; NaN at values without the orbit.
    multipliers : ndarray of float, shape (n,)
        In R^m the complex one of largest modulus; NaN at values without the orbit.
    ends : tuple of CurveEnd
        Where the orbit begins and ends, located between the values, and why: "end of range",
        the kind of a bifurcation, "outside" (it leaves the window), or how an orbit ends that no
        bifurcation explains.
    """

    period: int
    points: Floats
    multipliers: Floats | NDArray[np.complex128]
    ends: tuple[CurveEnd, CurveEnd]

    @property
    def stable(self) -> Bools:
        """Where the multiplier is inside (-1, 1), shape (n,); False without the orbit."""
        return np.asarray(np.abs(self.multipliers) < 1)

    @property
    def exists(self) -> Bools:
        """Where there is the orbit, shape (n,)."""
        return np.asarray(np.isfinite(self.multipliers))


@part
@dataclass(frozen=True, eq=False)
class AttractorTable:
    """Attractors, one row for each at each value; arrays of shape (m,) unless said otherwise.

    Attributes
    ----------
    where : ndarray of int
        Place of the parameter in the diagram's ``values``; ascending.
    kind : ndarray of str
        "periodic", "chaotic" (the mean of ``log |f'|`` is positive; not proved) or "undecided"; in
        R^m also "quasiperiodic".
    period : ndarray of int
        Of a periodic attractor, else 0.
    lyapunov : ndarray of float
        Mean of ``log |f'|`` per step: exact for a cycle, else over the points kept.
    points : ndarray of float, shape (m, k), in R^n (m, k, n)
        The cycle, or successive iterates; NaN fills the rest of a row.
    """

    where: Indices
    kind: NDArray[np.str_]
    period: Indices
    lyapunov: Floats
    points: Floats

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.where)


@dataclass(frozen=True, eq=False, repr=False)
class Diagram(Result):
    """What a map does over a range of one parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
        Ascending.
    max_period : int
        All orbits up to this period are in `orbits`; in R^n those found.
    window : tuple of float or None
        Part of the domain that was looked at.
    parameters : dict
        The other parameters by name.
    orbits : tuple of OrbitCurve
        By period, then by lowest value and place.
    attractors : AttractorTable
        Stable orbits among `orbits` included.
    breakpoints : tuple of BreakpointLine
        Jumps, corners and edges of gaps.
    unresolved : tuple of str
        What could not be settled, a sentence each.
    coverage : Coverage or None
        In R^n, where orbits may be missing, how many, as of a `BifurcationList`.
    """

    parameter: str
    values: Floats
    max_period: int
    window: tuple[float, float] | None
    parameters: dict[str, float]
    orbits: tuple[OrbitCurve, ...]
    attractors: AttractorTable
    breakpoints: tuple[BreakpointLine, ...]
    unresolved: tuple[str, ...] = ()
    coverage: Coverage | None = None
    _plot: ClassVar = "diagram.draw_diagram"

    def of_period(self, p: int) -> tuple[OrbitCurve, ...]:
        """Return the orbits of minimal period p."""
        p = whole_number("p", p)
        return tuple(orbit for orbit in self.orbits if orbit.period == p)

    def overview(self) -> Table:
        """Return a row per orbit: where it exists, how it begins and ends."""
        ends = [orbit.ends for orbit in self.orbits]
        stable = [self.values[orbit.stable] for orbit in self.orbits]
        return Table(
            {
                "period": [orbit.period for orbit in self.orbits],
                "from": [low.value for low, _ in ends],
                "begins": [low.reason for low, _ in ends],
                "to": [high.value for _, high in ends],
                "ends": [high.reason for _, high in ends],
                "first_points": [low.points for low, _ in ends],
                "last_points": [high.points for _, high in ends],
                "stable_share": [
                    values.size / max(1, int(orbit.exists.sum()))
                    for values, orbit in zip(stable, self.orbits, strict=True)
                ],
                "stable_from": [values[0] if values.size else math.nan for values in stable],
                "stable_to": [values[-1] if values.size else math.nan for values in stable],
            }
        )

    def _columns(self) -> dict[str, Any]:
        """Lay out orbits, then attractors, then breakpoints, a row for each point."""
        at = self.values[:, np.newaxis]
        parts = [
            _points(
                orbit.points,
                value=at,
                what="orbit",
                number=number,
                kind=np.where(orbit.stable, "stable", "unstable")[:, np.newaxis],
                period=orbit.period,
                multiplier=orbit.multipliers[:, np.newaxis],
            )
            for number, orbit in enumerate(self.orbits, start=1)
        ]
        parts.append(self._attractor_points())
        for number, line in enumerate(self.breakpoints, start=1):
            facts = {"number": number, "kind": line.kind, "period": 0}
            parts.append(_points(line.d[:, np.newaxis], value=at, what="breakpoint", **facts))
        names = [name for name in parts[0] if name != "value"]
        name = free_name(self.parameter, {*names, *LABELS})
        columns = {name: np.concatenate([part["value"] for part in parts])}
        for name in names:
            column = np.concatenate([part[name] for part in parts])
            columns[name] = column.real
            if np.iscomplexobj(column):  # neither CSV nor JSON has complex numbers
                columns[f"{name}_imag"] = column.imag
        return columns

    def _attractor_points(self) -> dict[str, Any]:
        """Points of the attractors, which are numbered at each value."""
        found = self.attractors
        number = np.arange(found.where.size) - np.searchsorted(found.where, found.where) + 1
        facts = {"kind": found.kind, "period": found.period, "lyapunov": found.lyapunov}
        facts |= {"value": self.values[found.where], "number": number}
        columns = {name: fact[:, np.newaxis] for name, fact in facts.items()}
        return _points(found.points, what="attractor", **columns)

    def __repr__(self) -> str:
        """Table of the orbits, and how many attractors of which kind there are."""
        n, low, high = len(self.values), self.values[0], self.values[-1]
        lines = [
            f"Diagram: {self.parameter} = {low:.10g} ... {high:.10g}, {n} values; "
            f"{len(self.orbits)} orbits up to period {self.max_period}",
            f"  period  {'from':15s}  {'begins':16s}  {'to':15s}  {'ends':16s}  stable",
        ]
        for row in itertools.islice(self.overview().rows(), SHOWN):
            lines.append(
                f"  {row['period']:6d}  {row['from']:<15.11g}  {row['begins']:16s}  "
                f"{row['to']:<15.11g}  {row['ends']:16s}  {row['stable_share']:.0%}"
            )
        lines += more(len(self.orbits))
        for kind in np.unique(self.attractors.kind):
            rows = self.attractors.kind == kind
            lines.append(
                f"  {kind} attractors at {len(np.unique(self.attractors.where[rows]))} values"
            )
        lines += [f"  unresolved: {text}" for text in self.unresolved]
        return "\n".join([*lines, *([f"  {self.coverage}"] if self.coverage else [])])

    def to_xarray(self) -> Any:
        """Return the diagram as an ``xarray.Dataset`` (needs the extra ``sweep``).

        Orbits are padded with NaN to ``max_period`` points, and attractors to the longest row.

        Raises
        ------
        MissingExtraError
            A ModuleNotFoundError: xarray is not installed.
        """
        require_extra("sweep", "labelled arrays", "xarray")
        xarray = importlib.import_module("xarray")
        name, n = next(iter(self.table())), len(self.values)
        coordinates = self.attractors.points.shape[2:]
        points = np.full((len(self.orbits), n, self.max_period, *coordinates), np.nan)
        for row, orbit in zip(points, self.orbits, strict=True):
            row[:, : orbit.period] = orbit.points
        axes = ("coordinate",) * len(coordinates)
        multipliers = [orbit.multipliers for orbit in self.orbits]
        breaks = [line.d for line in self.breakpoints]
        variables = {
            "orbit": (("branch", name, "point", *axes), points),
            "multiplier": (("branch", name), np.array(multipliers).reshape(-1, n)),
            "period": (("branch",), np.array([orbit.period for orbit in self.orbits])),
            "attractor": (("row", "iterate", *axes), self.attractors.points),
            "attractor_at": (("row",), self.values[self.attractors.where]),
            "attractor_kind": (("row",), self.attractors.kind),
            "attractor_period": (("row",), self.attractors.period),
            "lyapunov": (("row",), self.attractors.lyapunov),
            "breakpoint": (("line", name), np.array(breaks).reshape(-1, n)),
            "breakpoint_kind": (
                ("line",),
                np.array([line.kind for line in self.breakpoints], dtype=np.str_),
            ),
        }
        attributes: dict[str, Any] = {**self.parameters, "max_period": self.max_period}
        if self.window is not None:
            attributes["window"] = list(self.window)
        return xarray.Dataset(variables, coords={name: self.values}, attrs=attributes)


def _points(d: Floats, **facts: Any) -> dict[str, Any]:
    """Rows for points of shape (n, p, ...); facts for all rows, or of shape (n, 1) or (p,)."""
    shape = d.shape[:2]
    d = d.reshape(*shape, math.prod(d.shape[2:]))
    there = np.isfinite(d).all(axis=2)
    facts["point"] = np.arange(shape[1]) + 1
    facts = {"multiplier": np.nan, "lyapunov": np.nan, **facts}
    names = ("value", "what", "number", "kind", "period", "point")
    spread = {name: np.broadcast_to(facts[name], shape)[there] for name in (*names, *LAST)}
    return {
        **{n: spread[n] for n in names},
        **numbered("d", d[there]),
        **{n: spread[n] for n in LAST},
    }
