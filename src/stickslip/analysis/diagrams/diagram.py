"""Bifurcation diagrams: periodic orbits, attractors and breakpoints over a parameter."""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine
from stickslip.checks import whole_number
from stickslip.extras import require_extra

if TYPE_CHECKING:
    import os

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from stickslip.analysis.diagrams.assemble import OrbitCurveEnd
    from stickslip.analysis.maps.protocol import Floats

SHOWN: Final = 40  # orbits in a diagram's table


@dataclass(frozen=True, eq=False)
class OrbitCurve:
    """One periodic orbit over the values at which it exists.

    Attributes
    ----------
    period : int
        Minimal.
    points : ndarray of float, shape (n, p)
        In the map's order, each column following one point; NaN at values without the orbit.
    multipliers : ndarray of float, shape (n,)
        NaN at values without the orbit.
    ends : tuple of OrbitCurveEnd
        Where the orbit begins and ends, located between the values, and why.
    """

    period: int
    points: Floats
    multipliers: Floats
    ends: tuple[OrbitCurveEnd, OrbitCurveEnd]

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Where the multiplier is inside (-1, 1), shape (n,); False without the orbit."""
        return np.asarray(np.abs(self.multipliers) < 1)

    @property
    def exists(self) -> NDArray[np.bool_]:
        """Where there is the orbit, shape (n,)."""
        return np.asarray(np.isfinite(self.multipliers))


@dataclass(frozen=True, eq=False)
class AttractorTable:
    """Attractors, one row for each at each value; arrays of shape (m,) unless said otherwise.

    Attributes
    ----------
    where : ndarray of int
        Place of the parameter in the diagram's ``values``; ascending.
    kind : ndarray of str
        "periodic", "chaotic" (the mean of log |f'| is positive; not proved) or "undecided".
    period : ndarray of int
        Of a periodic attractor, else 0.
    lyapunov : ndarray of float
        Mean of log |f'| per step: exact for a cycle, else over the points kept.
    points : ndarray of float, shape (m, k)
        The cycle, or successive iterates; NaN fills the rest of a row.
    """

    where: NDArray[np.intp]
    kind: NDArray[np.str_]
    period: NDArray[np.intp]
    lyapunov: Floats
    points: Floats

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.where)


@dataclass(frozen=True, eq=False, repr=False)
class Diagram:
    """What a map of the line does over a range of one parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray of float, shape (n,)
        Ascending.
    max_period : int
        All orbits up to this period are in `orbits`.
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
    columns: ClassVar = (
        *("period", "from", "begins", "to", "ends"),
        *("first_points", "last_points", "stable_share"),
    )
    """Of the table in a CSV file."""

    def of_period(self, p: int) -> tuple[OrbitCurve, ...]:
        """Return the orbits of minimal period p."""
        p = whole_number("p", p)
        return tuple(orbit for orbit in self.orbits if orbit.period == p)

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draw the diagram; see `stickslip.plot.diagram.draw_diagram`."""
        module = importlib.import_module("stickslip.plot.diagram")
        axes: Axes = module.draw_diagram(self, ax, **style)
        return axes

    def table(self) -> list[dict[str, Any]]:
        """Return a row of plain values per orbit: where it exists, how it begins and ends."""
        rows = []
        for orbit in self.orbits:
            low, high = orbit.ends
            stable = self.values[orbit.stable]
            rows.append(
                {
                    "period": orbit.period,
                    "from": low.value,
                    "begins": low.reason,
                    "to": high.value,
                    "ends": high.reason,
                    "first_points": low.points.tolist(),
                    "last_points": high.points.tolist(),
                    "stable_share": float(orbit.stable.sum() / max(1, orbit.exists.sum())),
                    "stable_from": float(stable[0]) if stable.size else None,
                    "stable_to": float(stable[-1]) if stable.size else None,
                }
            )
        return rows

    def __repr__(self) -> str:
        """Table of the orbits, and how many attractors of which kind there are."""
        n, low, high = len(self.values), self.values[0], self.values[-1]
        lines = [
            f"Diagram: {self.parameter} = {low:.10g} ... {high:.10g}, {n} values; "
            f"{len(self.orbits)} orbits up to period {self.max_period}",
            f"  period  {'from':15s}  {'begins':16s}  {'to':15s}  {'ends':16s}  stable",
        ]
        for row in self.table()[:SHOWN]:
            lines.append(
                f"  {row['period']:6d}  {row['from']:<15.11g}  {row['begins']:16s}  "
                f"{row['to']:<15.11g}  {row['ends']:16s}  {row['stable_share']:.0%}"
            )
        if len(self.orbits) > SHOWN:
            lines.append(f"  ... {len(self.orbits) - SHOWN} more")
        for kind in np.unique(self.attractors.kind):
            rows = self.attractors.kind == kind
            lines.append(
                f"  {kind} attractors at {len(np.unique(self.attractors.where[rows]))} values"
            )
        return "\n".join([*lines, *(f"  unresolved: {text}" for text in self.unresolved)])

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
        name, n = self.parameter, len(self.values)
        points = np.full((len(self.orbits), n, self.max_period), np.nan)
        for row, orbit in zip(points, self.orbits, strict=True):
            row[:, : orbit.period] = orbit.points
        multipliers = [orbit.multipliers for orbit in self.orbits]
        breaks = [line.d for line in self.breakpoints]
        variables = {
            "orbit": (("branch", name, "point"), points),
            "multiplier": (("branch", name), np.array(multipliers).reshape(-1, n)),
            "period": (("branch",), np.array([orbit.period for orbit in self.orbits])),
            "attractor": (("row", "iterate"), self.attractors.points),
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

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write to a .json file that `stickslip.load` reads, or the table as .csv."""
        importlib.import_module("stickslip.analysis.storage").save(self, path)
