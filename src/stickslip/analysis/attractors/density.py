"""Invariant density of a chaotic attractor, by Ulam's method on its bands.

Ulam 1960; convergence: Li, J. Approx. Theory 17, 177, 1976.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.bands import APART, inside
from stickslip.analysis.attractors.lyapunov import LyapunovExponent
from stickslip.analysis.branches.pieces import runs
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.arguments import line_map
from stickslip.analysis.maps.protocol import Floats, Map1D, Modelled, advance, domain_width
from stickslip.checks import instance, whole_number
from stickslip.numerics.arrays import interval_of
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from stickslip.analysis.branches.laps import Laps

MOST_CELLS: Final = 10**7
PIECES: Final = 8  # of a cell, on which the map is taken as linear
IMAGES: Final = 24  # images of lap ends that become cell edges


@dataclass(frozen=True, eq=False, repr=False)
class InvariantDensity(Result):
    """How often a chaotic orbit visits each place, and averages over that.

    Attributes
    ----------
    left, right : ndarray (n,)
        Ends of the cells, which fill the attractor's bands.
    density : ndarray (n,)
        Probability per unit length in each cell; zero outside the cells.
    lyapunov : LyapunovExponent
        Mean of ``log |f'|``: a check on the time average. `n` is the number of cells.
    error : float
        Estimated error of the density in the L1 norm: its distance from that on cells twice as
        wide. The error of the exponent is estimated in the same way.
    system : map or None
        Whose density it is.
    """

    left: Floats
    right: Floats
    density: Floats
    lyapunov: LyapunovExponent
    error: float
    system: Map1D | None = field(default=None, repr=False, compare=False)
    _column_names: ClassVar = ("left", "right", "density", "mass")
    _plot: ClassVar = "basins.draw_density"

    @property
    def mass(self) -> Floats:
        """Probability of each cell; they sum to 1."""
        return self.density * (self.right - self.left)

    def __call__(self, x: ArrayLike) -> Any:
        """Return the density at points of any shape."""
        points = np.asarray(x, dtype=np.float64)
        cell = interval_of(points, self.left, self.right)
        return np.where(cell >= 0, self.density[cell], 0.0)

    def cumulative(self, x: ArrayLike) -> Any:
        """Return the probability left of points of any shape."""
        points = np.asarray(x, dtype=np.float64)
        return np.interp(points, *_cumulated(self.left, self.right, self.mass))

    def mean(self, func: Callable[[Floats], Floats]) -> float:
        """Average a function over the attractor, by Simpson's rule in each cell."""
        middle = 0.5 * (self.left + self.right)
        value = (func(self.left) + 4 * func(middle) + func(self.right)) / 6
        return float(np.sum(value * self.mass))

    def __repr__(self) -> str:
        """Short table."""
        return (
            f"InvariantDensity({len(self.left)} cells on [{self.left[0]:.10g}, "
            f"{self.right[-1]:.10g}], error {self.error:.1e}, exponent "
            f"{self.lyapunov.value:.8g} ± {self.lyapunov.error:.1g})"
        )


@waits
@suggests
def invariant_density(
    f: Map1D | Modelled[Map1D], attractor: Attractor, *, cells: int = 2000
) -> InvariantDensity:
    """Compute the invariant density of a chaotic attractor.

    Parameters
    ----------
    f : map of the line or model
        The map that `attractor` belongs to.
    attractor : Attractor
        A chaotic one, as from `attractors`.
    cells : int
        Approximate number of cells over all bands, at least 16.

    Returns
    -------
    InvariantDensity
        Normalised on the bands. The L1 error falls about like 1 / cells where the density is
        bounded, and slower at inverse square roots; an estimate comes with it.

    Raises
    ------
    ValueError
        The attractor is not chaotic: a cycle's measure sits on its points and has no density.
        Or there are fewer than 16 cells.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 4.0})
    >>> density = ss.invariant_density(f, ss.attractors(f)[0])
    >>> round(float(density.cumulative(0.25)), 2)  # 2 / pi * asin(sqrt(0.25))
    0.33
    """
    instance("attractor", attractor, Attractor, "an attractor, such as ss.attractors(f)[0]")
    cells = whole_number("cells", cells, 16, at_most=MOST_CELLS)
    if attractor.kind != "chaotic":
        raise ValueError(
            f"the attractor is {attractor.kind}: only a chaotic one has a density; "
            "a cycle spends an equal share of its time on each of its points"
        )
    f = line_map(f)
    table = branch_table(f).laps
    coarse = _ulam(f, table, attractor.bands, cells // 2)
    left, right, mass, exponent = _ulam(f, table, attractor.bands, cells)
    change = _distance(coarse, (left, right, mass))
    return InvariantDensity(
        left=left,
        right=right,
        density=mass / (right - left),
        lyapunov=LyapunovExponent(exponent, abs(exponent - coarse[3]), len(left)),
        error=change,
        system=f,
    )


def _ulam(f: Map1D, table: Laps, bands: Floats, cells: int) -> tuple[Floats, Floats, Floats, float]:
    """Cells, their stationary masses, and the mean of log |f'|."""
    left, right = _cells(f, table, bands, cells)
    low, high, steepness = _piece_images(f, table, left, right)
    shares: Floats = 0.5 * np.diff(-np.cos(np.pi * np.linspace(0, 1, PIECES + 1)))
    weight = np.tile(shares, len(left))
    chain = _transitions(left, right, low, high, weight)
    mass = _stationary(chain)
    logs = np.log(np.maximum(steepness, 1e-300))
    return left, right, mass, float(np.sum(np.repeat(mass, PIECES) * weight * logs))


def _cells(f: Map1D, table: Laps, bands: Floats, cells: int) -> tuple[Floats, Floats]:
    """Cut the bands at lap ends and their early images, and finely towards the bands' edges."""
    width = domain_width(f)
    special = _special_points(f, table, bands)
    lengths = bands[:, 1] - bands[:, 0]
    left, right = [], []
    for (low, high), length in zip(bands, lengths, strict=True):
        count = max(4, round(cells * length / lengths.sum()))
        graded = 0.5 * (1 - np.cos(np.pi * np.arange(1, count) / count))
        inner = np.concatenate([low + length * graded, special[(special > low) & (special < high)]])
        edges = np.unique(np.concatenate([[low], inner, [high]]))
        # Special points count more than graded ones: drop the graded ones beside them.
        keep = _apart(edges, np.concatenate([special, [low, high]]), APART * width)
        edges = edges[keep]
        left.append(edges[:-1])
        right.append(edges[1:])
    return np.concatenate(left), np.concatenate(right)


def _special_points(f: Map1D, table: Laps, bands: Floats) -> Floats:
    ends, values = (
        np.append(table.left, table.right),
        np.append(table.value_left, table.value_right),
    )
    low, high = f.domain
    start = values[inside(bands, ends) & (values >= low) & (values <= high)]
    images = advance(f, np.unique(start), IMAGES - 1) if start.size else np.empty(0)
    points = np.unique(np.concatenate([ends, images.ravel()]))
    return points[np.isfinite(points) & inside(bands, points)]


def _apart(edges: Floats, first: Floats, gap: float) -> Any:
    """Choose edges at least `gap` apart; those among `first` win over their neighbours."""
    rank = np.isin(edges, first)
    keep = np.ones(len(edges), dtype=np.bool_)
    for i in np.flatnonzero(np.diff(edges) <= gap):
        drop = i if rank[i + 1] and i > 0 else i + 1
        keep[drop if drop < len(edges) - 1 else i] = False
    keep[0] = keep[-1] = True
    return keep


def _piece_images(
    f: Map1D, table: Laps, left: Floats, right: Floats
) -> tuple[Floats, Floats, Floats]:
    """Image [low, high] and mean steepness of each piece of each cell."""
    share = 0.5 * (1 - np.cos(np.pi * np.linspace(0, 1, PIECES + 1)))
    nodes = left[:, None] + (right - left)[:, None] * share
    nodes[:, -1] = right
    values = advance(f, nodes.ravel(), 1)[:, 1].reshape(nodes.shape)
    # Ends of cells at ends of laps: the value from inside.
    lap = np.searchsorted(table.left, nodes[:, PIECES // 2], side="right") - 1
    at_left, at_right = left <= table.left[lap], right >= table.right[lap]
    values[at_left, 0] = table.value_left[lap[at_left]]
    values[at_right, -1] = table.value_right[lap[at_right]]
    start, end = values[:, :-1].ravel(), values[:, 1:].ravel()
    steepness = np.abs(end - start) / np.diff(nodes, axis=1).ravel()
    return np.minimum(start, end), np.maximum(start, end), steepness


def _transitions(left: Floats, right: Floats, low: Floats, high: Floats, weight: Floats) -> Any:
    """Share of each cell's mass that goes to each other cell, as a sparse matrix."""
    first = np.clip(np.searchsorted(left, low, side="right") - 1, 0, len(left) - 1)
    last = np.clip(np.searchsorted(left, high, side="left") - 1, first, len(left) - 1)
    count = last - first + 1
    piece, step = runs(count)
    cell = first[piece] + step
    overlap = np.minimum(high[piece], right[cell]) - np.maximum(low[piece], left[cell])
    overlap = np.maximum(overlap, np.where(count[piece] == 1, 1e-300, 0.0))
    total = np.bincount(piece, weights=overlap, minlength=len(low))
    flow = weight[piece] * overlap / total[piece]
    return sparse.csr_array((flow, (piece // PIECES, cell)), shape=(len(left), len(left)))


def _stationary(chain: Any) -> Floats:
    """Solve mass P = mass with unit sum; one equation is replaced by the sum."""
    n = chain.shape[0]
    system = sparse.lil_array(sparse.eye_array(n) - chain.T)
    system[0, :] = 1.0
    mass = spsolve(sparse.csc_array(system), np.eye(1, n)[0])
    mass = np.maximum(np.asarray(mass), 0.0)
    return np.asarray(mass / mass.sum())


def _distance(coarse: tuple[Floats, Floats, Floats, float], fine: tuple[Floats, ...]) -> float:
    """L1 distance of two densities on different cells."""
    edges = np.unique(np.concatenate([*coarse[:2], *fine[:2]]))
    steps = [np.diff(np.interp(edges, *_cumulated(*each))) for each in (coarse[:3], fine)]
    return float(np.abs(steps[0] - steps[1]).sum())


def _cumulated(left: Floats, right: Floats, mass: Floats) -> tuple[Floats, Floats]:
    """Return the ends of cells, and the mass left of each."""
    total = np.cumsum(mass)
    values = np.column_stack([np.concatenate([[0.0], total[:-1]]), total])
    return np.column_stack([left, right]).ravel(), values.ravel()
