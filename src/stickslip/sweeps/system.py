"""What a sweep needs of the system whose parameters it varies: starting points, orbits, verdicts.

Starting points are a function of seed and place in the grid alone: a point starts alike whatever
chunk it lies in and whoever computes it.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from itertools import islice
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import clip_to_domain, mix_labels, sample, widths
from stickslip.mechanics.eventmap.records import Followed, new_followed
from stickslip.numerics.long_run import (
    PERIODIC,
    RECURRENCE,
    UNDECIDED,
    LongRun,
    Path,
    new_long_run,
    read_off,
    recurs,
)
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import MapValues
    from stickslip.numerics.arrays import Floats
    from stickslip.sweeps.job import Points

    Columns: TypeAlias = Mapping[str, Floats]

BITS = 53  # of a random number
NUMBERS_AT_ONCE = 1 << 22  # points of orbits that are kept while they are followed


def spread_starts(
    seed: int, index: NDArray[np.uint64], count: int, low: Floats, high: Floats
) -> Floats:
    """Draw starting points, shape (n, count): one in each of `count` equal cells of the domain."""
    # `index` is the place of each grid point in the whole grid: chunks do not change what is drawn.
    cell = np.arange(count, dtype=np.float64)
    share = _share(_numbers(seed, index, count))
    width = (high - low)[:, None]
    drawn: Floats = low[:, None] + width * ((cell + share) / count)
    return drawn


def spread_shares(seed: int, index: NDArray[np.uint64], count: int, dimension: int) -> Floats:
    """Draw points of the unit cube at random, shape (n, count, dimension); as `spread_starts`."""
    axis = np.arange(dimension, dtype=np.uint64)
    return _share(mix_labels(_numbers(seed, index, count)[:, :, None], axis))


def _numbers(seed: int, index: NDArray[np.uint64], count: int) -> NDArray[np.uint64]:
    """Mix seed and place into `count` random numbers of 64 bits for each place."""
    start = np.full(index.shape, seed, dtype=np.uint64)
    cell = np.arange(count, dtype=np.uint64)
    return mix_labels(mix_labels(start, index)[:, None], cell[None, :])


def _share(numbers: NDArray[np.uint64]) -> Floats:
    shares: Floats = (numbers >> np.uint64(64 - BITS)).astype(np.float64) * 2.0**-BITS
    return shares


class Run(NamedTuple):
    """How orbits are followed; equal runs of several observables are done once."""

    n_starts: int  # orbits for each grid point
    transient: int  # maps before the stretch that is looked at
    n: int  # maps in that stretch
    max_period: int  # the longest recognised


def follow_maps(
    maps: Iterable[Any], starts: Floats, run: Run, tail: int
) -> tuple[LongRun, Followed]:
    """Follow the orbits of several maps of one kind from ``starts`` (maps, n_starts, ...).

    Results as `mechanics.eventmap.follow.follow` gives them, in C order. NaN is passed over.
    """
    if not len(starts):
        return new_long_run(0), new_followed(0, tail)
    at_once = max(1, NUMBERS_AT_ONCE // (starts[0].size * (run.transient + run.n + 1)))
    all_maps, parts = iter(maps), []
    for k in range(0, len(starts), at_once):
        some = starts[k : k + at_once]
        group = list(islice(all_maps, len(some)))
        found = _orbits(group, list(some), run.transient + run.n)
        parts += [_read(f, *each, run, tail) for f, each in zip(group, found, strict=True)]
    return joined(parts)


def _orbits(
    maps: list[Any], starts: list[Floats], steps: int
) -> Iterator[tuple[Floats, NDArray[np.int64] | None]]:
    """Orbits of maps from points, NaN allowed, and why they end, if that is known."""
    admitted = [np.asarray(np.isfinite(x).reshape(len(x), -1).all(axis=1)) for x in starts]
    points = [x[rows] for x, rows in zip(starts, admitted, strict=True)]
    native = getattr(maps[0], "follow_each", None)
    if native is not None:
        found = native(maps, points, steps)
    else:
        found = [(f.iterate(x, steps), None) for f, x in zip(maps, points, strict=True)]
    for rows, (orbits, status) in zip(admitted, found, strict=True):
        whole = np.full((len(rows), *orbits.shape[1:]), np.nan)
        whole[rows] = orbits
        if status is not None:
            known, status = status, np.full(len(rows), OK)
            status[rows] = known
        yield whole, status


def _read(
    f: Any, orbits: Floats, status: NDArray[np.int64] | None, run: Run, tail: int
) -> tuple[LongRun, Followed]:
    """Read off what orbits of a map do; of points of more numbers ``tail`` holds their first."""
    m, steps = len(orbits), run.transient + run.n
    verdicts, followed = new_long_run(m), new_followed(m, tail)
    defined = np.asarray(np.isfinite(orbits).reshape(m, steps + 1, -1).all(axis=2))
    on_line = orbits.ndim == 2
    for i in np.flatnonzero(defined[:, 0]).tolist():
        if not defined[i].all():
            last = int(np.argmin(defined[i])) - 1
            why = sample(f, orbits[i, last]).status if status is None else status[i]
            followed.steps[i], followed.status[i] = last, why
            continue
        points = orbits[i, run.transient :]
        motions = f.evaluate(points[:-1])
        followed.steps[i] = steps
        followed.tail[i] = points[run.n + 1 - tail :].reshape(tail, -1)[:, 0]
        if hasattr(motions, "duration"):
            followed.mean_events[i] = motions.n_events.mean()
            followed.most_events[i] = motions.n_events.max()
            followed.mean_duration[i] = motions.duration.mean()
        if on_line:
            with np.errstate(divide="ignore"):
                logs = np.log(np.abs(motions.derivative))
            path = Path(np.ascontiguousarray(points), motions.label, logs)
            low, high = f.domain
            read_off(path, low, high, run.max_period, verdicts, i)
        else:
            read_off_nd(f, points, motions, run.max_period, verdicts, i)
    return verdicts, followed


def read_off_nd(
    f: Any, points: Floats, motions: MapValues, max_period: int, verdicts: LongRun, i: int
) -> None:
    """Fill in entry `i` of the verdicts, as `numerics.long_run.read_off` does on the line."""
    # The exponent is the largest one: growth of one tangent vector, or of a cycle log of the
    # spectral radius of its monodromy matrix per step.
    labels, jacobians = motions.label, motions.derivative
    paths = [Path(np.ascontiguousarray(x), labels, _growth(jacobians)) for x in points.T]
    tolerances = RECURRENCE * widths(f)
    # Without periods: exponent, error, and whether that is chaos.
    read_off(paths[0], -np.inf, np.inf, 0, verdicts, i)
    for period in range(1, min(max_period, len(labels) // 2) + 1):
        if not all(map(recurs, paths, [period] * len(paths), tolerances)):
            continue
        monodromy = np.eye(len(paths))
        for jacobian in jacobians[len(labels) - period :]:
            monodromy = jacobian @ monodromy
        radius = float(np.abs(np.linalg.eigvals(monodromy)).max())
        verdicts.exponent[i] = np.log(radius) / period if radius > 0 else -np.inf
        verdicts.error[i] = 0.0
        verdicts.kind[i] = PERIODIC if radius < 1 else UNDECIDED
        verdicts.period[i] = period if radius < 1 else 0
        return


def _growth(jacobians: Floats) -> Floats:
    """Logarithm of the growth of a tangent vector in each step."""
    tangent = np.ones(jacobians.shape[-1])
    logs = np.empty(len(jacobians))
    with np.errstate(divide="ignore"):
        for k, jacobian in enumerate(jacobians):
            tangent = jacobian @ (tangent / np.linalg.norm(tangent))
            size = float(np.linalg.norm(tangent))
            logs[k] = np.log(size)
            if size == 0.0:
                tangent = np.ones(len(tangent))  # superstable: the mean is -inf whatever follows
    return logs


def joined(parts: list[tuple[LongRun, Followed]]) -> tuple[LongRun, Followed]:
    """Put the results of several calls into one, in their order."""
    verdicts, followed = zip(*parts, strict=True)
    return (
        type(verdicts[0])(*map(np.concatenate, zip(*verdicts, strict=True))),
        type(followed[0])(*map(np.concatenate, zip(*followed, strict=True))),
    )


class System:
    """A system with named parameters; columns hold a value of each varied one for a grid point."""

    # `lacks` maps what observables may ask for in vain to the reason: "orbits" of a map, "events"
    # in its steps, "line" (points are numbers), "model" (a motion in time), "d" (a number to start
    # from). What only some systems have is not defined here.

    lacks: Mapping[str, str] = MappingProxyType({})

    @property
    def names(self) -> Collection[str]:
        """Names of the numbers that may vary."""
        raise NotImplementedError

    def identity(self) -> dict[str, Any]:
        """Describe the system in values that JSON can hold."""
        raise NotImplementedError

    def check(self, values: Mapping[str, float]) -> None:
        """Raise ValueError if some parameter values are not allowed."""
        self.map_at(values)

    def on(self, device: str) -> System:
        """Return the same system with its orbits followed on a device, or refuse."""
        if device == "cuda":
            raise ValueError(
                "device = 'cuda' follows orbits of two undamped blocks (TwoBlock) alone. Take "
                "device='cpu'."
            )
        return self

    def map_at(self, values: Mapping[str, float]) -> Any:
        """Make the map at some parameter values; of a system without a map, the model."""
        raise NotImplementedError

    def model_at(self, values: Mapping[str, float]) -> Any:
        """Make the model at some parameter values."""
        raise NotImplementedError

    def domains(self, columns: Columns, size: int) -> tuple[Floats, Floats]:
        """Return the ends of the domain at each of `size` grid points, of a map of the line."""
        raise NotImplementedError

    def starts(self, points: Points, n_starts: int) -> Floats:
        """Return starting points (grid points, n_starts, ...), NaN where the map has none there."""
        # Of maps of the line. A single one is ``d``, where that is given; the others are drawn.
        low, high = self.domains(points.columns, points.size)
        if n_starts == 1 and points.d is not None:
            starts = points.d[:, None]
        else:
            starts = spread_starts(points.seed, points.index, n_starts, low, high)
        admitted = np.full(starts.shape, np.nan)
        for i, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
            clipped, inside = clip_to_domain(ends, starts[i])
            admitted[i, inside] = clipped[inside]
        return admitted

    def follow(
        self, columns: Columns, starts: Floats, run: Run, tail: int
    ) -> tuple[LongRun, Followed]:
        """Follow orbits from ``starts``, NaN passed over, in C order."""
        return follow_maps(map(self.map_at, rows(columns, len(starts))), starts, run, tail)


def rows(columns: Columns, size: int) -> Iterator[dict[str, float]]:
    """Give the values of the varied parameters at each of `size` grid points in turn."""
    for i in range(size):
        yield {name: float(column[i]) for name, column in columns.items()}
