"""The grid points of one chunk, and the work that observables share there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.analysis.maps.protocol import OUTSIDE
from stickslip.sweeps.system import rows

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Followed
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.orbits import Run
    from stickslip.sweeps.system import System

    Floats = NDArray[np.float64]


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
        return self.system.starts(self.columns, self.d0, self.seed, self.index, n_starts)

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
