"""Orbits of one map that has no compiled loop of its own, step by step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.analysis.maps.protocol import OUTSIDE, clip_to_domain
from stickslip.mechanics.eventmap.records import Followed, new_followed
from stickslip.numerics.long_run import LongRun, Path, new_long_run, read_off
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Map1D

    Floats = NDArray[np.float64]


class Run(NamedTuple):
    """How orbits are followed; equal runs of several observables are done once.

    ``n_starts``: orbits for each grid point; ``transient``, ``n``: maps before and in the stretch
    that is looked at; ``max_period``: longest period recognised.
    """

    n_starts: int
    transient: int
    n: int
    max_period: int


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
