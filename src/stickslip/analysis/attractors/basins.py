"""Basins of attraction on a line: intervals with exact edges, cut at preimages of known edges."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, overload

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorList, AttractorListND
from stickslip.analysis.attractors.attractors import MAX_STEPS, attractors, checked_found
from stickslip.analysis.attractors.basin_pieces import (
    LOST,
    RESOLUTION,
    EdgeCause,
    Pieces,
    explain,
    first_causes,
    first_pieces,
    refined,
    spread_over_open,
)
from stickslip.analysis.attractors.in_space.basins_nd import BasinsND, binomial, find_basins
from stickslip.analysis.attractors.in_space.fates import LEFT, MOST_FOLLOWED, UNDECIDED
from stickslip.analysis.attractors.lyapunov import perturbed
from stickslip.analysis.branches.table import NOT_FOLLOWED, branch_table
from stickslip.analysis.interpolation.interpolated import stand_in
from stickslip.analysis.maps.arguments import line_map, map_of, not_for
from stickslip.analysis.maps.protocol import SAME, MapND, advance, checked_points, domain_width
from stickslip.analysis.scales import BLOCK, ORBIT_NOISE
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, finite_number, random_generator, whole_number
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.results.table import more
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from numpy.typing import ArrayLike

    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Floats, Integers, Map1D, Modelled


MANY: Final = 4096  # undecided pieces from which on basins count as interwoven
MAX_CUT: Final = 1 << 15  # undecided pieces of all rounds together: the rest is sampled
WORTH: Final = 0.1  # of what is open: a round on many pieces that decides less is the last


@dataclass(frozen=True, eq=False, repr=False)
class Basins(Result):
    """Who is attracted where: consecutive intervals of a map's domain.

    Attributes
    ----------
    edges : ndarray (n + 1,)
        Ends of the intervals from left to right; the first and last are the domain's.
    index : ndarray (n,)
        For each interval the place of its attractor in `attractors`; -1 not proved, -2 the
        orbits leave: they reach a gap, where motions end, or the outside of the domain.
    causes : tuple of EdgeCause
        For each edge, why it is one.
    attractors : AttractorList
        What the index refers to.
    counts : ndarray (len(attractors) + 2,)
        Points drawn from what is not proved, by where their orbits end, indexed like `index`:
        ``counts[k]`` came to attractor k, ``counts[-2]`` left, ``counts[-1]`` did neither.
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
    Single points are not listed: unstable orbits and their preimages inside a basin. A sampled
    share is an estimate with a binomial standard error; all shares add up to 1.
    """

    edges: Floats
    index: Integers
    causes: tuple[EdgeCause, ...]
    attractors: AttractorList
    counts: Integers
    thin: int
    rounds: int
    resolution: float
    reason: str = ""
    _plot: ClassVar = "basins.draw_basins"

    @property
    def undecided(self) -> float:
        """Share of the domain that neither proof nor samples decide."""
        return self.sampled(UNDECIDED)[0]

    @property
    def left(self) -> float:
        """Share whose orbits leave, proved or sampled."""
        return self.share(LEFT)

    def share(self, attractor: int) -> float:
        """Part of the domain that belongs to an attractor (or to -1, -2), proved or sampled."""
        proved = 0.0 if self._known(attractor) == UNDECIDED else self.proved(attractor)
        return proved + self.sampled(attractor)[0]

    def proved(self, attractor: int) -> float:
        """Part of the domain in the intervals of an attractor (or of -2; of -1: not proved)."""
        lengths = np.diff(self.edges)
        return float(lengths[self.index == self._known(attractor)].sum() / lengths.sum())

    def sampled(self, attractor: int) -> tuple[float, float]:
        """Share found by samples of what is not proved, and its standard error."""
        mine = int(self.counts[self._known(attractor)])
        unproved, (share, error) = self.proved(-1), binomial(mine, int(self.counts.sum()))
        return unproved * share, unproved * error

    def _known(self, attractor: int) -> int:
        last = len(self.attractors) - 1
        return whole_number("attractor", attractor, LEFT, at_most=last, what="place in the list")

    def at(self, x: ArrayLike) -> Any:
        """Tell the index at points of the domain; on an edge, that of the interval right of it."""
        points = checked_points((float(self.edges[0]), float(self.edges[-1])), x)
        k = np.searchsorted(self.edges, points, side="right") - 1
        return self.index[np.clip(k, 0, len(self.index) - 1)]

    def __repr__(self) -> str:
        """Shares and intervals."""
        shares = ", ".join(f"{k}: {self._in_words(k)}" for k in range(len(self.attractors)))
        head = f"Basins: {len(self.index)} intervals; {shares or 'no attractor'}"
        head += f"; left {self._in_words(LEFT)}; undecided {self.undecided:.2e}"
        rows = [
            f"  {low: .12f} .. {high: .12f}  {k: d}   left edge: {cause}"
            for low, high, k, cause in zip(
                self.edges[:20], self.edges[1:21], self.index, self.causes, strict=False
            )
        ]
        rows += more(len(self.index), 20)
        return "\n".join([head, *rows, *filter(None, [self.reason])])

    def _in_words(self, k: int) -> str:
        share, error = self.sampled(k)
        return f"{self.proved(k):.6f}" + (f" + {share:.4g} ± {error:.1g} sampled" if share else "")

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
            return 0, "not proved" if k == UNDECIDED else "leaves", 0, math.nan, math.nan
        found = self.attractors[k]
        kind = found.kind if found.kind != "undecided" else "undecided attractor"
        return k + 1, kind, found.period, float(found.bands[0, 0]), found.lyapunov.value


@overload
def basins(
    f: Map1D | Modelled[Map1D],
    found: AttractorList | None = ...,
    *,
    resolution: float = ...,
    n_samples: int = ...,
    rng: np.random.Generator | int | None = ...,
    progress: Callable[[float], None] | None = ...,
    partial: bool = ...,
) -> Basins: ...
@overload
def basins(
    f: MapND | Modelled[MapND],
    found: AttractorListND | None = ...,
    *,
    n_samples: int = ...,
    grid: Sequence[Any] | None = ...,
    max_steps: int = ...,
    progress: Callable[[float], None] | None = ...,
    partial: bool = ...,
) -> BasinsND: ...
@waits
@suggests
def basins(
    f: Map1D | MapND | Modelled[Map1D] | Modelled[MapND],
    found: AttractorList | AttractorListND | None = None,
    *,
    resolution: float = RESOLUTION,
    n_samples: int = 4096,
    rng: np.random.Generator | int | None = None,
    grid: Sequence[Any] | None = None,
    max_steps: int = MAX_STEPS,
    progress: Callable[[float], None] | None = None,
    partial: bool = False,
) -> Basins | BasinsND:
    """Divide the domain of a map into basins of attraction.

    Parameters
    ----------
    f : map or model
    found : AttractorList or AttractorListND, optional
        The attractors; by default `attractors` searches for them.
    resolution : float
        Share of the domain below which pieces of interwoven basins are not cut. Basins
        with up to 4096 undecided pieces are refined to 1e-12 of the domain whatever this is.
    n_samples : int
        Points whose orbits are followed where the intervals leave something open; in R^n without
        a grid all starts, spread evenly over the domain.
    rng : Generator or int, optional
        For these points; by default a fixed one, so that results repeat.
    grid : sequence, optional
        Of a map of R^n, an entry for each coordinate: ``(lo, hi, n)`` for an axis, or a number
        at which the coordinate is held. Two axes make a picture of a plane.
    max_steps : int
        Steps after which a start of a map of R^n counts as undecided.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.
    partial : bool
        Whether Ctrl-C returns what has been found so far; what was left
        out is undecided, and the result says so.

    Returns
    -------
    Basins, or BasinsND of a map of R^n
        Edges good to 1e-10 of the domain, and most of them to rounding: unstable orbits come
        from Newton's method, breakpoints from the search for branches, and their preimages
        from the roots of f^k.

    Raises
    ------
    ValueError
        `resolution` is not between 0 and 1.

    Notes
    -----
    An attractor missing from `found` makes its basin undecided, not another's. Intervals are
    proved until 32768 pieces have been compared with their images, or a round on more than 4096 has
    decided less than a tenth of what was open; the rest is sampled on the interpolated map, for up
    to 20,000 steps.

    In R^n starts are followed until they stay for ten steps in cells about an attractor's points
    (Datseris and Wagemakers, Chaos 32 (2022) 023104); cells are halved until none holds points of
    two attractors. Some starts are followed ten times longer, and the result says how many came
    elsewhere.

    Examples
    --------
    >>> import stickslip as ss
    >>> found = ss.basins(ss.examples.coulomb())
    >>> [round(found.share(i), 6) for i in range(2)], found.undecided
    ([0.838167, 0.161833], 0.0)
    """
    resolution = finite_number("resolution", resolution)
    if not 0 < resolution < 1:
        raise ValueError(f"resolution = {resolution} must lie between 0 and 1 (of the domain)")
    n_samples = whole_number("n_samples", n_samples, at_most=MOST_KEPT)
    generator = random_generator("rng", 0 if rng is None else rng)
    max_steps = whole_number("max_steps", max_steps, at_most=MOST_FOLLOWED)
    work = Work(progress, partial)
    searched, rest = work.part(0.0, 0.5), work.part(0.0 if found is not None else 0.5, 1.0)
    search: Any = {"progress": searched.tell, "partial": work.partial}
    if isinstance(space := map_of(f), MapND):
        not_for("a line", resolution=resolution != RESOLUTION, rng=rng is not None)
        listed = attractors(space, **search) if found is None else checked_found(space, found)
        return find_basins(space, listed, grid, n_samples, max_steps, rest)
    not_for("R^n", grid=grid is not None, max_steps=max_steps != MAX_STEPS)
    f = line_map(f)
    branches = branch_table(f)
    table = branches.laps
    known = attractors(f, **search) if found is None else checked_found(f, found)
    pieces = first_pieces(f, branches, known)
    causes = first_causes(f, table, pieces.edges)
    pieces, rounds, cut, floor = pieces.joined(), 0, 0, SAME
    counts = np.zeros(len(known) + 2, dtype=np.int64)
    with rest.until_interrupted():
        if found is None and known.unfollowed:  # because of the same interrupt
            raise KeyboardInterrupt
        while cut < MAX_CUT:
            rest.tell(0.5 * cut / MAX_CUT)
            floor = SAME if pieces.count_undecided() <= MANY else resolution
            finer = refined(f, table, pieces, floor * domain_width(f))
            if finer is None or finer.same_as(pieces):
                break
            stalled = finer.open_length() > (1 - WORTH) * pieces.open_length()
            pieces, rounds, cut = finer, rounds + 1, cut + finer.count_undecided()
            if stalled and pieces.count_undecided() > MANY:
                break
    edges, index, named, thin = explain(f, pieces, causes, ORBIT_NOISE)
    index[index == LOST] = UNDECIDED
    if np.any(index == UNDECIDED):
        points = spread_over_open(pieces.edges, pieces.index, generator.random(n_samples))
        counts[UNDECIDED] = len(points)
        with rest.until_interrupted():
            if rest.interrupted:
                raise KeyboardInterrupt
            # A few estimates that all points share would err by more than the error that is told.
            fast = stand_in(f, asks=True)
            _count(fast, pieces, points, counts, generator, rest.part(0.5, 1.0))
    return Basins(
        edges=edges,
        index=index,
        causes=named,
        attractors=known,
        counts=counts,
        thin=thin,
        rounds=rounds,
        resolution=floor * domain_width(f),
        reason=_why(branches, known, counts, rest),
    )


def _count(
    f: Map1D, pieces: Pieces, x: Floats, counts: Integers, rng: np.random.Generator, work: Work
) -> None:
    """Follow points until their orbits come to a decided piece, and count its fate."""
    n, lost = len(x), 0
    for steps in range(0, MAX_STEPS, BLOCK):
        work.tell(max(1 - len(x) / n, steps / MAX_STEPS))
        tails = advance(f, x, BLOCK)
        fates = pieces.fate(tails)
        first = np.argmax(fates != UNDECIDED, axis=1)
        fate = fates[np.arange(len(x)), first]
        np.add.at(counts, fate[(fate >= 0) | (fate == LEFT)], 1)
        lost += int(np.count_nonzero(fate == LOST))
        x = tails[fate == UNDECIDED, -1]
        counts[UNDECIDED] = lost + len(x)
        if not x.size:
            return
        x = perturbed(f, x, rng)


def _why(branches: BranchTable, known: AttractorList, counts: Integers, work: Work) -> str:
    if work.interrupted:
        return "interrupted: what was not followed to its end is undecided"
    if not counts[UNDECIDED]:
        return ""
    if len(branches.given_up):
        return next(str(u) for u in branches.unresolved if u.reason.startswith(NOT_FOLLOWED))
    if reasons := [a.reason for a in known if a.kind == "undecided"]:
        return f"undecided attractor: {reasons[0]}"
    return f"{counts[UNDECIDED]} of {counts.sum()} samples reach no known attractor"
