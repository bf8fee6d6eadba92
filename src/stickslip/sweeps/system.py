"""What a sweep needs of the system whose parameters it varies: starting points, orbits, verdicts.

Starting points are a function of seed and place in the grid alone: a point starts alike whatever
chunk it lies in and whoever computes it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import OUTSIDE, clip_to_domain, mix_labels
from stickslip.mechanics.eventmap.records import Followed, new_followed
from stickslip.numerics.long_run import LongRun, Path, new_long_run, read_off
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Map1D
    from stickslip.numerics.arrays import Floats
    from stickslip.sweeps.job import Points

    Columns: TypeAlias = Mapping[str, Floats]

BITS = 53  # of a random number


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


def follow_map(f: Map1D, starts: Floats, run: Run, tail: int) -> tuple[LongRun, Followed]:
    """Follow orbits under one map; results as `mechanics.eventmap.follow.follow` gives them."""
    m = starts.size
    verdicts, followed = new_long_run(m), new_followed(m, tail)
    x = starts.copy()
    for _ in range(run.transient):
        x = _step(f, x, followed)[0]
    points = np.empty((m, run.n + 1))
    labels = np.zeros((m, run.n), dtype=np.uint64)
    slopes, events, times = (np.full((m, run.n), np.nan) for _ in range(3))
    points[:, 0] = x
    for k in range(run.n):
        x, slopes[:, k], labels[:, k], events[:, k], times[:, k] = _step(f, x, followed)
        points[:, k + 1] = x
    with np.errstate(divide="ignore"):
        logs = np.log(np.abs(slopes))
    for i in np.flatnonzero(np.isfinite(x)).tolist():
        read_off(Path(points[i], labels[i], logs[i]), *f.domain, run.max_period, verdicts, i)
        followed.tail[i] = points[i, run.n + 1 - tail :]
        followed.mean_events[i], followed.mean_duration[i] = events[i].mean(), times[i].mean()
        followed.most_events[i] = 0 if np.isnan(events[i, 0]) else int(events[i].max())
    return verdicts, followed


def _step(f: Map1D, x: Floats, followed: Followed) -> tuple[Any, ...]:
    """Apply the map once: values, slopes, labels, events, durations; NaN stays NaN."""
    clipped, inside = clip_to_domain(f.domain, x)
    inside &= np.isfinite(x)
    followed.status[np.isfinite(x) & ~inside] = OUTSIDE
    value, slope, events, time = (np.full(x.shape, np.nan) for _ in range(4))
    label = np.zeros(x.shape, dtype=np.uint64)
    if inside.any():
        got: Any = f.evaluate(clipped[inside])
        value[inside], slope[inside], label[inside] = got.value, got.derivative, got.label
        followed.status[inside] = got.status
        followed.steps[inside] += np.asarray(got.status) == OK
        if hasattr(got, "n_events"):
            events[inside], time[inside] = got.n_events, got.duration
    return value, slope, label, events, time


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
        points = zip(rows(columns, len(starts)), starts, strict=True)
        return joined([self.follow_one(self.map_at(at), some, run, tail) for at, some in points])

    def follow_one(self, f: Any, starts: Floats, run: Run, tail: int) -> tuple[LongRun, Followed]:
        """Follow the orbits of one grid point, under its map."""
        return follow_map(f, starts, run, tail)


def rows(columns: Columns, size: int) -> Iterator[dict[str, float]]:
    """Give the values of the varied parameters at each of `size` grid points in turn."""
    for i in range(size):
        yield {name: float(column[i]) for name, column in columns.items()}
