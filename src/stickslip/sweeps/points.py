"""The grid points of one chunk, and the work that observables share there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.analysis.protocol import OUTSIDE, clip_to_domain
from stickslip.sweeps.seeds import spread_starts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.protocol import Map1D
    from stickslip.mechanics.eventmap.follow_records import Followed
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.orbits import Run
    from stickslip.sweeps.systems import System

    Floats = NDArray[np.float64]

__all__ = ["Orbits", "Points"]


class Orbits(NamedTuple):
    """What is known of orbits, in the order of grid points, the seeds of one together."""

    verdicts: LongRun
    followed: Followed


@dataclass
class Points:
    """Grid points: values of each varied parameter, and the place of each in the whole grid.

    Attributes
    ----------
    system : System
    columns : mapping of str to ndarray, shape (size,)
    d0 : ndarray of float, shape (size,), or None
        Starting points, where they are given.
    index : ndarray of uint64, shape (size,)
        Place in the whole grid in C order; with ``seed`` it decides the other starting points.
    seed : int
    tails : mapping of Run to int
        Last points to keep of the orbits of each run, the most that any observable asks for.
    """

    system: System
    columns: Mapping[str, Floats]
    d0: Floats | None
    index: NDArray[np.uint64]
    seed: int
    tails: Mapping[Run, int]

    def __post_init__(self) -> None:
        """Find the ends of the domains, and remember no orbits yet."""
        self.low, self.high = self.system.domains(self.columns, self.size)
        self._known: dict[Run, Orbits] = {}

    @property
    def size(self) -> int:
        """Number of grid points."""
        return len(self.index)

    def starts(self, n_seeds: int) -> Floats:
        """Return starting points (size, n_seeds); a single one is `d0`, where that is given."""
        if n_seeds == 1 and self.d0 is not None:
            return self.d0[:, None]
        return spread_starts(self.seed, self.index, n_seeds, self.low, self.high)

    def orbits(self, run: Run) -> Orbits:
        """Follow orbits, or return those of an equal run that are known already."""
        if run not in self._known:
            starts = self._admitted(self.starts(run.n_seeds))
            found = Orbits(*self.system.follow(self.columns, starts, run, self.tails[run]))
            found.followed.status[np.isnan(starts.ravel())] = OUTSIDE
            self._known[run] = found
        return self._known[run]

    def maps(self) -> Iterator[tuple[Map1D, float]]:
        """Give the map and the starting point of each grid point in turn."""
        starts = self.starts(1)[:, 0].tolist()
        for i, d0 in enumerate(starts):
            values = {name: float(column[i]) for name, column in self.columns.items()}
            yield self.system.map_at(values), d0

    def _admitted(self, starts: Floats) -> Floats:
        """Put NaN for starting points outside the domains."""
        admitted = np.full(starts.shape, np.nan)
        for i, (low, high) in enumerate(zip(self.low.tolist(), self.high.tolist(), strict=True)):
            clipped, inside = clip_to_domain((low, high), starts[i])
            admitted[i, inside] = clipped[inside]
        return admitted
