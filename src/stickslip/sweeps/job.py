"""The description of a sweep: axes, what is recorded, cut into tiles; the computation of one tile.

A tile is one task and one chunk of each array of the store. `compute` is a pure function of a job
and a tile, so that it may run in any thread or process, any number of times.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields, replace
from functools import cached_property
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from stickslip.analysis.maps.protocol import OUTSIDE
from stickslip.checks import MOST_VALUES, finite_number, grid, instance, one_of, whole_number
from stickslip.numerics.arrays import Floats
from stickslip.sweeps.identity import digest, target
from stickslip.sweeps.system import rows
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Followed
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.system import Run, System


SCALES: Final = ("linear", "log")
FORMAT: Final = 2  # raised when the same description would give other results
LARGEST_SEED: Final = 2**63
START: Final = "d"  # name of an axis of starting points
POINTS_PER_TILE: Final = {"cpu": 4096, "cuda": 65_536}  # a GPU takes as many orbits at once
TILES: Final = 64  # of a small sweep, so that all cores have work and little is lost

Columns: TypeAlias = "dict[str, NDArray[Any]]"
AxisLike: TypeAlias = "Axis | tuple[float, float, int] | ArrayLike"


@dataclass(frozen=True, eq=False)
class Axis:
    """Values of one parameter; `axis` makes it.

    Attributes
    ----------
    values : ndarray of float64, shape (n,)
        Distinct, in ascending or descending order.
    """

    values: Floats

    def __len__(self) -> int:
        """Count the values."""
        return len(self.values)


@suggests
def axis(lo: float, hi: float, n: int, scale: Literal["linear", "log"] = "linear") -> Axis:
    """Make an axis of equally spaced values, both ends included.

    Parameters
    ----------
    lo, hi : float
        Ends; with ``scale="log"`` both above 0.
    n : int
        Number of values, >= 1; with 1, ``lo`` alone.
    scale : {"linear", "log"}
        Whether differences or ratios of neighbours are equal.

    Returns
    -------
    Axis
        For `stickslip.sweep`.

    Raises
    ------
    ValueError
        An end is not finite or out of range, n is no whole number >= 1, the scale is unknown.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.axis(0.01, 1.0, 3, scale="log").values
    array([0.01, 0.1 , 1.  ])
    """
    one_of("scale", scale, SCALES)
    count = whole_number("n", n, at_most=MOST_VALUES, what="values of an axis")
    least = 0.0 if scale == "log" else -inf
    why = "A logarithmic axis has ends above 0." if scale == "log" else ""
    ends = [
        finite_number(name, end, above=least, why=why) for name, end in (("lo", lo), ("hi", hi))
    ]
    spaced = np.geomspace if scale == "log" else np.linspace
    return Axis(_ordered(spaced(ends[0], ends[1], count)))


def as_axes(given: Mapping[str, AxisLike]) -> dict[str, Axis]:
    """Read the axes of a sweep in the forms that `stickslip.sweep` takes."""
    instance("axes", given, Mapping, 'values by name, {"V": (0.03, 0.05, 12)}')
    if not given:
        raise ValueError("axes = {}: a sweep needs at least one axis, {name: values}.")
    for name in given:
        instance("a name in axes", name, str, 'text, as in {"V": (0.03, 0.05, 12)}')
    return {name: _as_axis(name, values) for name, values in given.items()}


def _as_axis(name: str, given: Any) -> Axis:
    if isinstance(given, Axis):
        return given
    try:
        return Axis(_ordered(grid(name, given)))
    except (TypeError, ValueError) as error:
        raise ValueError(f"axis {name!r}: {error}") from error


def _ordered(values: Sequence[float] | Floats) -> Floats:
    """Return a copy of values that are finite, distinct and in order."""
    array = np.array(values, dtype=np.float64)
    if array.size == 0 or not np.isfinite(array).all():
        raise ValueError("finite numbers are needed, at least one.")
    steps = np.diff(array)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise ValueError("its values must be distinct and in ascending or descending order.")
    array.setflags(write=False)
    return array


@dataclass(frozen=True)
class Output:
    """One variable of a store: ``dims`` and ``sizes`` are those besides the axes."""

    name: str
    dtype: str
    long_name: str
    dims: tuple[str, ...] = ()
    sizes: tuple[int, ...] = ()
    flags: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Observable:
    """Settings of something to record.

    Attributes
    ----------
    name : str
        What plan files call it.
    needs : tuple of str
        What it asks of a system, of that which some lack (`System.lacks`).
    recorded : tuple of Output
        Its variables, where its settings change nothing about them.
    """

    name: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()
    recorded: ClassVar[tuple[Output, ...]] = ()

    def __post_init__(self) -> None:
        """Check that counts are whole numbers in range."""
        for each in fields(self):
            if limits := each.metadata.get("limits"):
                name = f"{each.name} of {self.name}"
                value = whole_number(name, getattr(self, each.name), limits[0], at_most=limits[1])
                object.__setattr__(self, each.name, value)

    def outputs(self) -> tuple[Output, ...]:
        """Return the variables that `compute` returns."""
        return self.recorded

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed, and how many of their last points."""
        return {}

    def compute(self, points: Points) -> Columns:
        """Return each variable by name, shape (grid points, *sizes)."""
        raise NotImplementedError

    def identity(self) -> dict[str, Any]:
        """Describe the observable in values that JSON can hold."""
        return {"name": self.name, **asdict(self)}


def whole(default: int, least: int = 1, most: int = MOST_VALUES) -> Any:
    """Make a setting that is a whole number in a range."""
    return field(default=default, metadata={"limits": (least, most)})


class Orbits(NamedTuple):
    """Results of orbits, in the order of grid points, the starts of each point together."""

    verdicts: LongRun
    followed: Followed


@dataclass
class Points:
    """Grid points: values of each varied parameter, and the place of each in the whole grid."""

    system: System
    columns: Mapping[str, Floats]
    d: Floats | None  # starting points, where they are given
    # place in the whole grid in C order; with ``seed`` it decides the other starting points
    index: NDArray[np.uint64]
    seed: int
    # last points to keep of each run's orbits, the most that any observable asks for
    tails: Mapping[Run, int]

    def __post_init__(self) -> None:
        """Remember no orbits yet."""
        self._known: dict[Run, Orbits] = {}

    @property
    def widths(self) -> Floats:
        """Width of the domain at each grid point, of a map of the line."""
        low, high = self.system.domains(self.columns, self.size)
        return high - low

    @property
    def size(self) -> int:
        """Number of grid points."""
        return len(self.index)

    def starts(self, n_starts: int) -> Floats:
        """Return starting points (size, n_starts, ...): `System.starts`."""
        return self.system.starts(self, n_starts)

    def orbits(self, run: Run) -> Orbits:
        """Follow orbits, or return those of an equal run that are known already."""
        if run not in self._known:
            starts = self.starts(run.n_starts)
            found = Orbits(*self.system.follow(self.columns, starts, run, self.tails[run]))
            outside = np.isnan(starts).reshape(self.size * run.n_starts, -1).any(axis=1)
            found.followed.status[outside] = OUTSIDE
            self._known[run] = found
        return self._known[run]

    def maps(self) -> Iterator[tuple[Any, Any]]:
        """Give the map (`System.map_at`) and the starting point of each grid point in turn."""
        for values, start in zip(self.values(), self.starts(1)[:, 0], strict=True):
            yield self.system.map_at(values), start.tolist() if start.ndim == 0 else start

    def values(self) -> Iterator[dict[str, float]]:
        """Give the values of the varied parameters at each grid point in turn."""
        yield from rows(self.columns, self.size)

    def refused(self) -> dict[int, str]:
        """Tell why the system does not allow the values of a grid point, for each of these."""
        found = {}
        for i, values in enumerate(self.values()):
            try:
                self.system.check(values)
                self.system.map_at(values)
            except ValueError as error:
                found[i] = f"{', '.join(f'{n} = {x!r}' for n, x in values.items())}: {error}"
        return found

    def without(self, places: Iterable[int]) -> Points:
        """Return the other grid points."""
        rest = np.delete(np.arange(self.size), list(places))
        columns = {name: column[rest] for name, column in self.columns.items()}
        d = None if self.d is None else self.d[rest]
        return replace(self, columns=columns, d=d, index=self.index[rest])


@dataclass(frozen=True, eq=False)
class Job:
    """Everything that the results of a sweep depend on, the machine and its kernels apart."""

    system: System
    names: tuple[str, ...]
    shape: tuple[int, ...]
    observables: tuple[Observable, ...]
    seed: int
    d: float | None
    device: str = "cpu"

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Variables, in the order in which they are written."""
        return tuple(output for each in self.observables for output in each.outputs())

    @cached_property
    def tails(self) -> dict[Run, int]:
        """Runs of orbits that observables need, and how many of their last points."""
        found: dict[Run, int] = {}
        for each in self.observables:
            for run, tail in each.runs().items():
                found[run] = max(tail, found.get(run, 0))
        return found

    def identity(self, axes: Mapping[str, Axis]) -> dict[str, Any]:
        """Describe the sweep in values that JSON can hold; equal ones give equal results."""
        return {
            "format": FORMAT,
            "system": self.system.identity(),
            "axes": {name: _axis_identity(axes[name].values) for name in self.names},
            "observables": [each.identity() for each in self.observables],
            "seed": self.seed,
            "d": self.d,
        }


def _axis_identity(values: Floats) -> dict[str, Any]:
    text = digest(values.astype("<f8").tobytes())
    return {"from": float(values[0]), "to": float(values[-1]), "n": len(values), "values": text}


@dataclass(frozen=True, eq=False)
class Tile:
    """A part of the grid."""

    index: tuple[int, ...]  # among the tiles, along each axis
    start: tuple[int, ...]  # place of the first point in the grid
    values: tuple[Floats, ...]  # of each axis

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of points along each axis."""
        return tuple(map(len, self.values))

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @property
    def region(self) -> tuple[slice, ...]:
        """Place of the tile in the grid."""
        return tuple(slice(a, a + n) for a, n in zip(self.start, self.shape, strict=True))

    def points(self, job: Job) -> Points:
        """Return the grid points of the tile, in C order."""
        grids = np.meshgrid(*self.values, indexing="ij", copy=False)
        columns = {name: grid.ravel() for name, grid in zip(job.names, grids, strict=True)}
        d = columns.pop(START, None)
        if d is None and job.d is not None:
            d = np.full(grids[0].size, job.d)
        places = np.ix_(*(np.arange(a, a + n) for a, n in zip(self.start, self.shape, strict=True)))
        index = np.ravel_multi_index(np.broadcast_arrays(*places), job.shape).ravel()
        return Points(job.system, columns, d, index.astype(np.uint64), job.seed, job.tails)


@dataclass(frozen=True, eq=False)
class Computed:
    """The variables of a tile, shapes (*tile, *sizes), and what computed them."""

    arrays: dict[str, NDArray[Any]]
    target: dict[str, str]
    refused: Sequence[str] = ()  # grid points that the system does not allow, and why


def compute(job: Job, tile: Tile) -> Computed:
    """Compute all variables of a tile; values that the system refuses together have none."""
    points = tile.points(job)
    refused: dict[int, str] = {}
    try:
        columns = _columns(job, points)
    except ValueError:
        # Only now: making each model once more takes as long as following some of its orbits.
        refused = points.refused()
        if not refused:
            raise
        columns = _columns(job, points.without(refused))
    arrays = {}
    for output in job.outputs:
        array = np.full((points.size, *output.sizes), missing(output.dtype), dtype=output.dtype)
        array[np.delete(np.arange(points.size), list(refused))] = columns[output.name]
        arrays[output.name] = array.reshape(*tile.shape, *output.sizes)
    return Computed(arrays, target(job.device), tuple(refused.values()))


def _columns(job: Job, points: Points) -> Columns:
    """Compute all variables at some grid points."""
    found: Columns = {}
    if points.size:
        for each in job.observables:
            found |= each.compute(points)
    return found or {each.name: np.empty((0, *each.sizes)) for each in job.outputs}


def missing(dtype: str) -> Any:
    """Return the value that marks a missing one, by its type."""
    kind = np.dtype(dtype).kind
    if kind == "f":
        return math.nan
    return False if kind == "b" else int(np.iinfo(dtype).min) if kind == "i" else 0


def default_chunks(shape: tuple[int, ...], device: str = "cpu") -> tuple[int, ...]:
    """Choose tiles of at most 4096 points (65 536 on a GPU), and 64 tiles or more if possible."""
    tiles = 1 if device == "cuda" else TILES
    wanted = max(1, min(POINTS_PER_TILE[device], math.prod(shape) // tiles))
    chunks: dict[int, int] = {}
    for k in sorted(range(len(shape)), key=lambda k: shape[k]):
        # What is left is shared evenly by the axes that are left, the short ones first.
        side = round((wanted / math.prod(chunks.values())) ** (1 / (len(shape) - len(chunks))))
        chunks[k] = max(1, min(shape[k], side))
    return tuple(chunks[k] for k in range(len(shape)))


def tiles(axes: Mapping[str, Axis], chunks: tuple[int, ...]) -> Iterator[Tile]:
    """Cut the grid of some axes into tiles, in C order."""
    values = [each.values for each in axes.values()]
    counts = [range(-(-len(v) // n)) for v, n in zip(values, chunks, strict=True)]
    for index in itertools.product(*counts):
        start = tuple(i * n for i, n in zip(index, chunks, strict=True))
        parts = (v[a : a + n] for v, a, n in zip(values, start, chunks, strict=True))
        yield Tile(index, start, tuple(parts))
