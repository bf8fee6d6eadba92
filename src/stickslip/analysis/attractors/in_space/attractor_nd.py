"""Attractors of a map of R^n: what is known of each, and lists of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

from stickslip.results.result import Result, ResultList

if TYPE_CHECKING:
    from stickslip.analysis.attractors.lyapunov import LyapunovExponent
    from stickslip.analysis.maps.protocol import Floats
    from stickslip.analysis.maps.protocol_nd import MapND
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND

KindND: TypeAlias = Literal["periodic", "quasiperiodic", "chaotic", "undecided"]


@dataclass(frozen=True, eq=False, repr=False)
class AttractorND(Result):
    """A set that orbits of a map of R^n settle on.

    Attributes
    ----------
    kind : {"periodic", "quasiperiodic", "chaotic", "undecided"}
        See `stickslip.attractors` for the evidence behind each.
    period : int
        Points of a cycle; 0 otherwise.
    orbit : PeriodicOrbitND or None
        The cycle, for a periodic attractor.
    points : ndarray (k, n)
        Points on the attractor: the cycle, else consecutive ones of a long orbit.
    lyapunov : LyapunovExponent
        The largest exponent per step, and its standard error.
    basin_share : float
        Share of the starts of the search that end here; `stickslip.basins` counts more.
    recurrence : float
        Share of a later stretch of the orbit that comes as close to an earlier one as this to
        itself: near 1 for an orbit that has settled.
    reason : str
        Why the attractor is undecided; empty otherwise.
    """

    kind: KindND
    period: int
    orbit: PeriodicOrbitND | None
    points: Floats
    lyapunov: LyapunovExponent
    basin_share: float
    recurrence: float
    reason: str = ""
    _column_names: ClassVar = (
        *("kind", "period", "lyapunov", "lyapunov_error"),
        *("basin_share", "recurrence", "point", "reason"),
    )
    _plot: ClassVar = "basins.draw_attractor_nd"

    def __repr__(self) -> str:
        """Short table."""
        return f"AttractorND({self._line()})"

    def _line(self) -> str:
        where = ", ".join(f"{x:.8g}" for x in self.points[0])
        value, error = self.lyapunov
        text = f"{self.kind:13}  period {self.period:<3d}  exponent {value:.5g} ± {error:.1g}"
        text += f"  share {self.basin_share:.3f}  recurs {self.recurrence:.3f}  at ({where})"
        return f"{text}  ({self.reason})" if self.reason else text

    def _columns(self) -> dict[str, Any]:
        facts = (
            *(self.kind, self.period, *self.lyapunov, self.basin_share),
            *(self.recurrence, self.points[0].tolist(), self.reason),
        )
        return {name: [fact] for name, fact in zip(self._column_names, facts, strict=True)}


@dataclass(frozen=True, eq=False, repr=False)
class AttractorListND(ResultList[AttractorND]):
    """Attractors of a map of R^n, largest basin first, and the starts that reached none.

    Attributes
    ----------
    attractors : tuple of AttractorND
        What was found; also reached by indexing and iteration.
    left : float
        Share of the starts whose orbits leave the domain, or come where there is no value.
    n_starts : int
        Starts, which the shares refer to.
    resolution : float
        Sets closer than this, of the widths, were not told apart.
    widths : ndarray (n,)
        Of the region of the starts, in each coordinate.
    settled : int
        Steps until the last start was known to have settled.
    system : map or None
        None if loaded without.
    """

    attractors: tuple[AttractorND, ...]
    left: float
    n_starts: int
    resolution: float
    widths: Floats
    settled: int
    system: MapND | None = field(default=None, repr=False, compare=False)
    _number: ClassVar = "attractor"
    _column_names: ClassVar = AttractorND._column_names
    _plot: ClassVar = "basins.draw_attractors_nd"

    @property
    def _items(self) -> tuple[AttractorND, ...]:
        return self.attractors

    def __repr__(self) -> str:
        """Short table."""
        head = f"AttractorListND: {len(self)} from {self.n_starts} starts, {self.left:.3f} left; "
        head += f"evidence: settled within {self.settled} steps, resolution {self.resolution:.2g}"
        return "\n".join([head, *(f"  {a._line()}" for a in self)])
