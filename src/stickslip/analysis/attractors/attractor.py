"""Attractors of a map: what is known of each, and lists of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

from stickslip.analysis.attractors.bands import inside
from stickslip.checks import finite_number, real_numbers
from stickslip.results.result import ResultList, ResultRow
from stickslip.status import GIVEN_UP, MESSAGES

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.attractors.lyapunov import LyapunovExponent
    from stickslip.analysis.maps.protocol import Floats, Map1D, MapND
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND

AttractorKind: TypeAlias = Literal["periodic", "chaotic", "neutral", "undecided"]


class AnyAttractor(ResultRow):
    """What attractors of maps of any dimension have in common."""

    lowest_period: int = 0  # not known

    def __repr__(self) -> str:
        """Short table."""
        return f"{type(self).__name__}({self._line()})"

    def _line(self) -> str:
        raise NotImplementedError


@dataclass(frozen=True, eq=False, repr=False)
class Attractor(AnyAttractor):
    """A set that orbits of a map settle on.

    Attributes
    ----------
    kind : {"periodic", "chaotic", "neutral", "undecided"}
        See `attractors` for the evidence behind each. Neutral is a family of periodic orbits,
        one through each point of the bands, that attracts nothing inside.
    period : int
        Points of a cycle; for chaos, the number of sets of bands visited in turn; 0 if unknown.
    orbit : PeriodicOrbit or None
        The cycle, for a periodic attractor (or one of a family, or behind an undecided one).
    bands : ndarray (k, 2)
        Intervals that hold the attractor, from left to right. Those of a cycle have no width.
    edges : tuple of str
        For chaos, what each edge of the bands is an image of, in the order ``bands.ravel()``.
    lyapunov : LyapunovExponent
        Mean of ``log |f'|`` per step, and its standard error.
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
    lowest_period : int
        For chaos, the fewest maps from a band back to itself: no orbit in it has a shorter period.
    system : map or None
        What it attracts in.
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
    lowest_period: int = 0
    system: Map1D | None = field(default=None, repr=False, compare=False)
    _column_names: ClassVar = (
        *("kind", "period", "lyapunov", "lyapunov_error", "basin_share"),
        *("bands", "point", "reason"),
    )
    _plot: ClassVar = "basins.draw_attractor"
    _has_picture: ClassVar = False

    def contains(self, x: ArrayLike, slack: float = 0.0) -> Any:
        """Tell which points lie in the bands, within `slack`."""
        return inside(self.bands, real_numbers("x", x), finite_number("slack", slack))

    def _line(self) -> str:
        where = ", ".join(f"[{low:.8g}, {high:.8g}]" for low, high in self.bands[:4])
        if self.kind == "periodic" and self.orbit is not None:
            where = ", ".join(f"{x:.10g}" for x in self.orbit.points[:4])
        more = " ..." if len(self.bands) > 4 else ""
        value, error = self.lyapunov
        text = f"{self.kind:9}  period {self.period:<3d}  exponent {value:.6g} ± {error:.1g}"
        text += f"  share {self.basin_share:.3f}  {where}{more}"
        return f"{text}  ({self.reason})" if self.reason else text

    def _facts(self) -> tuple[Any, ...]:
        known = self.kind, self.period, *self.lyapunov, self.basin_share
        return *known, self.bands.tolist(), self.point, self.reason


@dataclass(frozen=True, eq=False, repr=False)
class AttractorList(ResultList[Attractor]):
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
    unfollowed : int
        Seeds that an interrupt kept from being followed to their end.
    """

    attractors: tuple[Attractor, ...]
    left: float
    statuses: dict[int, int]
    n_starts: int
    resolution: str
    unfollowed: int = 0
    _number: ClassVar = "attractor"
    _column_names: ClassVar = Attractor._column_names
    _plot: ClassVar = "basins.draw_bands"
    _of: ClassVar = "attractors"

    def __repr__(self) -> str:
        """Short table."""
        rows = [f"AttractorList: {len(self)} from {self.n_starts} seeds, {self.left:.3f} left"]
        rows[0] += _unfollowed(self.unfollowed)
        given_up = {why: self.statuses[why] for why in GIVEN_UP if why in self.statuses}
        rows += [f"  {count} seeds lost: {MESSAGES[why]}" for why, count in given_up.items()]
        return "\n".join([*rows, *(f"  {a._line()}" for a in self)])


def _unfollowed(count: int) -> str:
    return f"; interrupted: {count} not followed to their end" if count else ""


# ------------------------------------------------------------------ in R^n


@dataclass(frozen=True, eq=False, repr=False)
class AttractorND(AnyAttractor):
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

    kind: Literal["periodic", "quasiperiodic", "chaotic", "undecided"]
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

    def _line(self) -> str:
        where = ", ".join(f"{x:.8g}" for x in self.points[0])
        value, error = self.lyapunov
        text = f"{self.kind:13}  period {self.period:<3d}  exponent {value:.5g} ± {error:.1g}"
        text += f"  share {self.basin_share:.3f}  recurs {self.recurrence:.3f}  at ({where})"
        return f"{text}  ({self.reason})" if self.reason else text

    def _facts(self) -> tuple[Any, ...]:
        known = self.kind, self.period, *self.lyapunov, self.basin_share
        return *known, self.recurrence, self.points[0].tolist(), self.reason


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
    unfollowed : int
        Starts that an interrupt kept from being followed to their end.
    system : map or None
        None if loaded without.
    """

    attractors: tuple[AttractorND, ...]
    left: float
    n_starts: int
    resolution: float
    widths: Floats
    settled: int
    unfollowed: int = 0
    system: MapND | None = field(default=None, repr=False, compare=False)
    _number: ClassVar = "attractor"
    _column_names: ClassVar = AttractorND._column_names
    _plot: ClassVar = "basins.draw_attractors_nd"
    _of: ClassVar = "attractors"

    def __repr__(self) -> str:
        """Short table."""
        head = f"AttractorListND: {len(self)} from {self.n_starts} starts, {self.left:.3f} left; "
        head += f"evidence: settled within {self.settled} steps, resolution {self.resolution:.2g}"
        head += _unfollowed(self.unfollowed)
        return "\n".join([head, *(f"  {a._line()}" for a in self)])
