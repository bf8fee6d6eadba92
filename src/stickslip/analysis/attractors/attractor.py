"""Attractors of a map of the line: what is known of each, and lists of them."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, overload

import numpy as np

from stickslip.analysis.attractors.bands import inside

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from stickslip.analysis.attractors.lyapunov import LyapunovExponent
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

AttractorKind: TypeAlias = Literal["periodic", "chaotic", "undecided"]


@dataclass(frozen=True, eq=False, repr=False)
class Attractor:
    """A set that orbits of a map settle on.

    Attributes
    ----------
    kind : {"periodic", "chaotic", "undecided"}
        See `attractors` for the evidence behind each.
    period : int
        Points of a cycle; for chaos, the number of sets of bands visited in turn; 0 if unknown.
    orbit : PeriodicOrbit or None
        The cycle, for a periodic attractor (or the neutral one behind an undecided one).
    bands : ndarray (k, 2)
        Intervals that hold the attractor, from left to right. Those of a cycle have no width.
    edges : tuple of str
        For chaos, what each edge of the bands is an image of, in the order ``bands.ravel()``.
    lyapunov : LyapunovExponent
        Mean of log |f'| per step, and its standard error.
    basin_share : float
        Share of the seeds spread over the domain that end here: an estimate with a standard
        error of about ``sqrt(share (1 - share) / n_starts)``. `basins` gives the exact one.
    point : float
        A point on or near the attractor.
    reason : str
        Why the attractor is undecided; empty otherwise.
    sources : tuple of (float, int, int)
        For chaos, where each edge comes from: the break, turning point or end of the domain,
        the side from which the map is taken there (-1 left, 1 right), and how many maps later
        its image is the edge; 0 maps if that is not known.
    """

    kind: AttractorKind
    period: int
    orbit: PeriodicOrbit | None
    bands: Floats
    lyapunov: LyapunovExponent
    basin_share: float
    point: float
    edges: tuple[str, ...] = ()
    reason: str = ""
    sources: tuple[tuple[float, int, int], ...] = ()

    def contains(self, x: ArrayLike, slack: float = 0.0) -> Any:
        """Tell which points lie in the bands, within `slack`."""
        return inside(self.bands, np.asarray(x, dtype=np.float64), slack)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the bands as a strip."""
        axes: Axes = _plot("basins").draw_bands([self], ax)
        return axes

    def __repr__(self) -> str:
        """Short table."""
        return f"Attractor({self._row()})"

    def _row(self) -> str:
        where = ", ".join(f"[{low:.8g}, {high:.8g}]" for low, high in self.bands[:4])
        if self.kind == "periodic" and self.orbit is not None:
            where = ", ".join(f"{x:.10g}" for x in self.orbit.points[:4])
        more = " ..." if len(self.bands) > 4 else ""
        value, error = self.lyapunov
        text = f"{self.kind:9}  period {self.period:<3d}  exponent {value:.6g} ± {error:.1g}"
        text += f"  share {self.basin_share:.3f}  {where}{more}"
        return f"{text}  ({self.reason})" if self.reason else text


@dataclass(frozen=True, eq=False, repr=False)
class AttractorList(Sequence[Attractor]):
    """Attractors of a map, largest basin first, and the seeds that reached none.

    Attributes
    ----------
    attractors : tuple of Attractor
        What was found; also reached by indexing and iteration.
    left : float
        Share of the seeds spread over the domain whose orbits leave it or fall into a gap.
    statuses : dict
        How many seeds left, by the status that the map gave at their last point.
    n_starts : int
        Seeds spread over the domain, which the shares refer to.
    resolution : str
        What the search would miss.
    """

    attractors: tuple[Attractor, ...]
    left: float
    statuses: dict[int, int]
    n_starts: int
    resolution: str

    def __len__(self) -> int:
        """Count."""
        return len(self.attractors)

    @overload
    def __getitem__(self, index: int) -> Attractor: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Attractor, ...]: ...
    def __getitem__(self, index: int | slice) -> Attractor | tuple[Attractor, ...]:
        """One attractor, or several."""
        return self.attractors[index]

    def __repr__(self) -> str:
        """Short table."""
        rows = [f"AttractorList: {len(self)} from {self.n_starts} seeds, {self.left:.3f} left"]
        return "\n".join([*rows, *(f"  {a._row()}" for a in self)])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the bands of all attractors as strips."""
        axes: Axes = _plot("basins").draw_bands(self.attractors, ax)
        return axes


def _plot(name: str) -> Any:
    return importlib.import_module(f"stickslip.plot.{name}")
