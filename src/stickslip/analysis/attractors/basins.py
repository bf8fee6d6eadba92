"""Basins of attraction on a line: intervals with exact edges, cut at preimages of known edges."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorList
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.attractors.basin_pieces import (
    LEFT,
    UNDECIDED,
    EdgeCause,
    explain,
    first_causes,
    first_pieces,
    refined,
)
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.arguments import line_map
from stickslip.analysis.maps.protocol import checked_points, domain_width
from stickslip.checks import finite_number, instance, whole_number
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Floats, Map1D, Modelled

    Integers = NDArray[np.int64]

SLIVER: Final = 1e-12  # of the domain's width: undecided pieces are refined down to this
WIDEST_EDGE: Final = 1e-10  # of the domain's width: a thinner undecided piece is an edge
RESOLUTION: Final = 1e-5  # of the domain's width: ... or this, if there are too many pieces
MANY: Final = 4096  # undecided pieces from which on basins count as interwoven
MAX_ROUNDS: Final = 5000


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Result):
    """Who is attracted where: consecutive intervals of a map's domain.

    Attributes
    ----------
    edges : ndarray (n + 1,)
        Ends of the intervals from left to right; the first and last are the domain's.
    index : ndarray (n,)
        For each interval the place of its attractor in `attractors`; -1 undecided, -2 the
        orbits leave: they reach a gap or the outside of the domain.
    causes : tuple of EdgeCause
        For each edge, why it is one.
    attractors : AttractorList
        What the index refers to.
    undecided : float
        Share of the domain with index -1.
    left : float
        Share with index -2.
    thin : int
        Intervals below 1e-10 of the domain, which are not listed: basins accumulate at an edge.
    rounds : int
        Preimages taken.
    resolution : float
        Length below which undecided pieces were not refined.
    reason : str
        Why a share is undecided; empty if none is.

    Notes
    -----
    Single points are not listed: unstable orbits and their preimages inside a basin.
    """

    edges: Floats
    index: Integers
    causes: tuple[EdgeCause, ...]
    attractors: AttractorList
    undecided: float
    left: float
    thin: int
    rounds: int
    resolution: float
    reason: str = ""
    _plot: ClassVar = "basins.draw_basins"

    def share(self, attractor: int) -> float:
        """Part of the domain that belongs to an attractor (or to -1, -2)."""
        lengths = np.diff(self.edges)
        return float(lengths[self.index == attractor].sum() / lengths.sum())

    def at(self, x: ArrayLike) -> Any:
        """Tell the index at points of the domain; on an edge, that of the interval right of it."""
        points = checked_points((float(self.edges[0]), float(self.edges[-1])), x)
        k = np.searchsorted(self.edges, points, side="right") - 1
        return self.index[np.clip(k, 0, len(self.index) - 1)]

    def __repr__(self) -> str:
        """Shares and intervals."""
        shares = ", ".join(f"{k}: {self.share(k):.6f}" for k in range(len(self.attractors)))
        head = f"Basins: {len(self.index)} intervals; {shares or 'no attractor'}"
        head += f"; left {self.left:.6f}; undecided {self.undecided:.2e}"
        rows = [
            f"  {low: .12f} .. {high: .12f}  {k: d}   left edge: {cause}"
            for low, high, k, cause in zip(
                self.edges[:20], self.edges[1:21], self.index, self.causes, strict=False
            )
        ]
        more = [f"  ... {len(self.index) - 20} more"] if len(self.index) > 20 else []
        return "\n".join([head, *rows, *more, *([self.reason] if self.reason else [])])

    def _columns(self) -> dict[str, Any]:
        """Lay out the intervals; attractors are numbered from 1, 0 is none."""
        widths = np.diff(self.edges)
        fates = [self._fate(k) for k in self.index.tolist()]
        names = ("attractor", "kind", "period", "d", "lyapunov")
        causes = [str(cause) for cause in self.causes]
        return {
            "left": self.edges[:-1],
            "right": self.edges[1:],
            "share": widths / widths.sum(),
            **dict(zip(names, map(list, zip(*fates, strict=True)), strict=True)),
            "left_cause": causes[:-1],
            "right_cause": causes[1:],
        }

    def _fate(self, k: int) -> tuple[int, str, int, float, float]:
        if k < 0:
            return 0, "undecided" if k == UNDECIDED else "leaves", 0, math.nan, math.nan
        found = self.attractors[k]
        kind = found.kind if found.kind != "undecided" else "undecided attractor"
        return k + 1, kind, found.period, float(found.bands[0, 0]), found.lyapunov.value


@suggests
def basins(
    f: Map1D | Modelled[Map1D],
    found: AttractorList | None = None,
    *,
    resolution: float = RESOLUTION,
    max_rounds: int = MAX_ROUNDS,
) -> Basins:
    """Divide the domain of a map of the line into basins of attraction.

    Parameters
    ----------
    f : map of the line or model
    found : AttractorList, optional
        The attractors; by default `attractors` searches for them.
    resolution : float
        Share of the domain below which pieces of interwoven basins are left undecided. Basins
        with up to 4096 undecided pieces are refined to 1e-12 of the domain whatever this is.
    max_rounds : int
        Preimages taken at most.

    Returns
    -------
    Basins
        Edges good to 1e-10 of the domain, and most of them to rounding: unstable orbits come
        from Newton's method, breakpoints from the search for branches, and their preimages
        from the roots of f^k.

    Raises
    ------
    ValueError
        `resolution` is not between 0 and 1.

    Notes
    -----
    An attractor missing from `found` makes its basin undecided, not another's.
    """
    resolution = finite_number("resolution", resolution)
    if not 0 < resolution < 1:
        raise ValueError(f"resolution = {resolution} must lie between 0 and 1 (of the domain)")
    max_rounds = whole_number("max_rounds", max_rounds, 0)
    f = line_map(f)
    table = branch_table(f).laps
    known = (
        attractors(f)
        if found is None
        else instance("found", found, AttractorList, "the result of ss.attractors(f)")
    )
    pieces = first_pieces(f, table, known)
    causes = first_causes(f, table, pieces.edges)
    pieces, rounds, floor = pieces.joined(), 0, SLIVER
    while rounds < max_rounds:
        floor = SLIVER if pieces.count_undecided() <= MANY else resolution
        finer = refined(f, table, pieces, floor * domain_width(f))
        if finer is None or finer.same_as(pieces):
            break
        pieces, rounds = finer, rounds + 1
    edges, index, named, thin = explain(f, pieces, causes, WIDEST_EDGE)
    shares = np.diff(edges) / domain_width(f)
    return Basins(
        edges=edges,
        index=index,
        causes=named,
        attractors=known,
        undecided=float(shares[index == UNDECIDED].sum()),
        left=float(shares[index == LEFT].sum()),
        thin=thin,
        rounds=rounds,
        resolution=floor * domain_width(f),
        reason=_why(known, edges, index, floor * domain_width(f)),
    )


def _why(known: AttractorList, edges: Floats, index: Integers, floor: float) -> str:
    open_ = index == UNDECIDED
    if not np.any(open_):
        return ""
    if reasons := [a.reason for a in known if a.kind == "undecided"]:
        return f"undecided attractor: {reasons[0]}"
    widest = float(np.diff(edges)[open_].max())
    if widest <= 2 * floor:
        return f"{open_.sum()} pieces below {floor:.1e}: basins are interwoven at all scales"
    return f"{open_.sum()} pieces, up to {widest:.1e} wide, reach no known attractor"
