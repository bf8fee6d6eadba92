"""Basins of attraction in R^n: on a grid in a plane or any section, or by starts spread out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorListND
from stickslip.analysis.attractors.in_space.fates import (
    LEFT,
    UNDECIDED,
    UNFOLLOWED,
    Grid,
    cells_of,
    fates,
)
from stickslip.analysis.attractors.lyapunov import GROWTH
from stickslip.analysis.maps.protocol import Floats, MapND, orbits
from stickslip.analysis.scales import IN_A_ROW, SAMPLE
from stickslip.checks import MOST_VALUES, finite_number, one_each, shown, whole_number
from stickslip.checks import grid as checked_values
from stickslip.results.parts import part
from stickslip.results.result import Result

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.attractors.in_space.fates import Labels
    from stickslip.analysis.work import Work

LONGER: Final = 10  # median times of settling by which some starts are followed further
BLOCKS: Final = 4  # parts of a picture in each direction, whose dimensions are compared


@part
class Estimate(NamedTuple):
    """A number and its standard error."""

    value: float
    error: float


def binomial(count: int, n: int) -> Estimate:
    """Return the share of so many of n independent trials; its error is 0 of none only."""
    p = (count + 0.5) / (n + 1)
    return Estimate(count / n, math.sqrt(p * (1.0 - p) / n)) if n else Estimate(0.0, 0.0)


@dataclass(frozen=True, eq=False, repr=False)
class BasinsND(Result):
    """Who is attracted where: fates of the points of a grid, or of starts spread over a domain.

    Attributes
    ----------
    index : ndarray of int, shape of the grid, or (n_samples,)
        For each start the place of its attractor in `attractors`; -1 undecided, -2 the orbit
        leaves the domain or comes where there is no value.
    axes : tuple of ndarray
        Values along each axis of the grid; none for starts spread over the domain.
    coordinates : tuple of int
        The coordinate, from 0, of each axis.
    point : ndarray (n,)
        Values of the others: the section; NaN for those on an axis.
    attractors : AttractorListND
        What the index refers to.
    settling : tuple of int
        Median (of the checked starts) and largest number of steps until a start was decided.
    cell : float
        Size of the cells about attractors, of the widths of the region of their starts.
    mistaken, checked : int
        Of so many decided starts, followed ten times longer, so many came elsewhere.
    hits : int
        Steps in a row in cells about an attractor after which a start counted as attracted.
    max_steps : int
    unfollowed : int
        Starts that an interrupt kept from being followed; they count as undecided.

    Notes
    -----
    All of this is evidence, not proof: an orbit counts as attracted once it has stayed `hits` steps
    in cells about the points of an attractor: ten, or four times as many, and so on, until none of
    the checked starts comes elsewhere. An attractor that no start has shown makes its basin
    undecided.
    """

    index: Labels
    axes: tuple[Floats, ...]
    coordinates: tuple[int, ...]
    point: Floats
    attractors: AttractorListND
    settling: tuple[int, int]
    cell: float
    mistaken: int
    checked: int
    hits: int
    max_steps: int
    unfollowed: int = 0
    _plot: ClassVar = "basins.draw_basins_nd"

    def share(self, attractor: int) -> Estimate:
        """Share of an attractor (or of -1, -2), with the binomial error of as many starts."""
        last = len(self.attractors) - 1
        k = whole_number("attractor", attractor, LEFT, at_most=last, what="place in the list")
        return binomial(int((self.index == k).sum()), self.index.size)

    @property
    def left(self) -> float:
        """Share of the starts whose orbits leave."""
        return self.share(LEFT).value

    @property
    def undecided(self) -> float:
        """Share of the starts that neither settled nor left."""
        return self.share(UNDECIDED).value

    def boundary_dimension(self) -> Estimate:
        """Estimate the dimension of the basins' boundary from the grid; NaN where there is none.

        The share of pairs of points, r apart, with different fates falls as r^(n - D) (Grebogi,
        McDonald, Ott and Yorke, Phys. Lett. A 99 (1983) 415-418), here between 1 and 1/16 of the
        parts of the grid's edge; the error is from 4 parts in each direction.
        """
        n = len(self.axes)
        if not n:
            raise ValueError("starts spread over a domain have no boundary: give grid=.")
        parts = [self.index]
        for axis in range(n):
            parts = [half for part in parts for half in np.array_split(part, BLOCKS, axis)]
        slopes = [slope for part in parts if np.isfinite(slope := _uncertainty(part))]
        whole = _uncertainty(self.index)
        error = np.std(slopes, ddof=1) / math.sqrt(len(slopes)) if len(slopes) > 1 else math.nan
        return Estimate(n - whole, float(error))

    def wada_distance(self) -> float:
        """Return how far the basins' boundaries are from each other, in steps of the grid.

        Each basin's boundary with all others is taken; the distance is the largest of a point
        of one to the nearest of another: about 1 for basins with the Wada property, whose
        boundaries are one set (Daza, Wagemakers and Sanjuan, Sci. Rep. 8 (2018) 9954). Infinite
        with fewer than three basins.
        """
        from scipy.ndimage import binary_dilation, distance_transform_edt

        edges = []
        for k in np.unique(self.index[self.index != UNDECIDED]):
            mine = self.index == k
            edges.append(binary_dilation(mine) & ~mine | binary_dilation(~mine) & mine)
        if len(edges) < 3:
            return math.inf
        distances = [distance_transform_edt(~edge) for edge in edges]
        return float(max(far[edge].max() for far in distances for edge in edges))

    def __repr__(self) -> str:
        """Shares, and how far to trust them."""
        shape = " x ".join(map(str, self.index.shape))
        rows = [f"BasinsND: {shape} starts; settled within {self.settling[1]} steps, half of them "]
        rows[0] += f"within {self.settling[0]}; {self.mistaken} of {self.checked} checked went on"
        if self.unfollowed:
            rows.append(f"  interrupted: {self.unfollowed} starts were not followed")
        names = [a._line() for a in self.attractors]
        for k, name in ((LEFT, "leave"), (UNDECIDED, "undecided"), *enumerate(names)):
            value, error = self.share(k)
            rows.append(f"  {k:3d}  {value:.5f} ± {error:.1g}  {name}")
        return "\n".join(rows)

    def _columns(self) -> dict[str, Any]:
        numbers = [LEFT, UNDECIDED, *range(len(self.attractors))]
        kinds = ["leaves", "undecided", *(a.kind for a in self.attractors)]
        shares = np.array([self.share(k) for k in numbers])
        return {
            "attractor": np.array(numbers),
            "kind": np.array(kinds),
            "share": shares[:, 0],
            "error": shares[:, 1],
        }


def _uncertainty(index: Labels) -> float:
    """Slope of log(share of pairs with different fates) against log(distance)."""
    reach = [2**k for k in range(5) if 2 ** (k + 2) <= min(index.shape)]
    shares = []
    for r in reach:  # of the same first points, whatever the distance
        pairs = [
            index.take(range(r, r + m - reach[-1]), axis) != index.take(range(m - reach[-1]), axis)
            for axis, m in enumerate(index.shape)
        ]
        shares.append(np.mean([pair.mean() for pair in pairs]))
    if len(reach) < 2 or min(shares) == 0.0:
        return math.nan
    return float(np.polyfit(np.log(reach), np.log(shares), 1)[0])


def checked_grid(f: MapND, grid: Sequence[Any]) -> Grid:
    """Return a grid in a section of R^n, its point NaN along the axes."""
    axes, coordinates, point = [], [], np.full(f.dimension, math.nan)
    for k, given in enumerate(one_each("grid", grid, f.dimension)):
        if np.iterable(given):
            axes.append(checked_values(f"grid[{k}]", given))
            coordinates.append(k)
        else:
            point[k] = finite_number(f"grid[{k}]", given)
    if not axes:
        raise ValueError(
            f"grid = {shown(grid)} is a point: a number holds a coordinate. Give a range "
            "(lo, hi, n), or values, for one coordinate at least."
        )
    made = Grid(tuple(axes), tuple(coordinates), point)
    whole_number("points of the grid", len(made), at_most=MOST_VALUES)
    return made


def find_basins(
    f: MapND,
    found: AttractorListND,
    grid: Sequence[Any] | None,
    n_samples: int,
    max_steps: int,
    work: Work,
) -> BasinsND:
    """Follow the points of a grid, or starts spread over the domain; see `stickslip.basins`."""
    made = Grid((), (), np.full(f.dimension, math.nan)) if grid is None else checked_grid(f, grid)
    x = f.spread(n_samples) if grid is None else made
    cells = cells_of(f, found)
    fate, steps = fates(f, x, cells, max_steps, work)
    hits = IN_A_ROW
    while True:
        decided = np.flatnonzero(fate >= 0)
        checked = decided[:: max(1, len(decided) // SAMPLE)][: 0 if work.interrupted else SAMPLE]
        median = int(np.median(steps[checked])) if checked.size else 0
        later = orbits(f, x[checked], median + LONGER * max(IN_A_ROW, median))[:, -1]
        again = fates(f, later, cells, max_steps, hits=hits)[0]
        mistaken = int((again != fate[checked]).sum())
        if not mistaken or GROWTH * hits > max_steps:
            break
        hits *= GROWTH
        fate[decided], steps[decided] = fates(f, x[decided], cells, max_steps, work, hits)
    unfollowed = np.flatnonzero(fate == UNFOLLOWED) if work.interrupted else decided[:0]
    fate[unfollowed] = UNDECIDED
    return BasinsND(
        index=fate.reshape(tuple(map(len, made.axes)) or (len(x),)),
        axes=made.axes,
        coordinates=made.coordinates,
        point=made.point,
        attractors=found,
        settling=(median, int(steps[decided].max(initial=0))),
        cell=math.nan if cells is None else cells.size,
        mistaken=mistaken,
        checked=len(checked),
        hits=hits,
        max_steps=max_steps,
        unfollowed=len(unfollowed),
    )
