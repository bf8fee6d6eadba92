"""What a sweep needs of the system whose parameters it varies."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from stickslip.analysis.maps.protocol import clip_to_domain
from stickslip.sweeps.seeds import spread_starts

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.eventmap.records import Followed
    from stickslip.numerics.long_run import LongRun
    from stickslip.sweeps.orbits import Run

    Floats: TypeAlias = NDArray[np.float64]
    Columns: TypeAlias = Mapping[str, Floats]


class System:
    """A system with named parameters; columns hold a value of each varied one for a grid point.

    What only some systems have is not defined here; observables that ask for it are refused.

    Attributes
    ----------
    lacks : mapping of str to str
        What observables may ask for and it does not have, with the reason: "orbits" of a map,
        "events" in its steps, "line" (points are numbers), "model" (a motion in time), "d0" (a
        number to start from).
    """

    lacks: Mapping[str, str] = MappingProxyType({})

    def identity(self) -> dict[str, Any]:
        """Describe it in values that JSON can hold."""
        raise NotImplementedError

    def check(self, values: Mapping[str, float]) -> None:
        """Raise ValueError if some parameter values are not allowed."""
        self.map_at(values)

    def on(self, device: str) -> System:
        """Return the same system with its orbits followed on a device.

        Raises
        ------
        ValueError
            The device cannot do that.
        """
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

    def starts(
        self,
        columns: Columns,
        d0: Floats | None,
        seed: int,
        index: NDArray[np.uint64],
        n_starts: int,
    ) -> Floats:
        """Return starting points (grid points, n_starts, ...), NaN where the map has none there.

        A single one is ``d0``, where that is given; the others are drawn from `seed` and the
        places ``index`` of the points in the grid. This is for maps of the line.
        """
        low, high = self.domains(columns, len(index))
        if n_starts == 1 and d0 is not None:
            starts = d0[:, None]
        else:
            starts = spread_starts(seed, index, n_starts, low, high)
        admitted = np.full(starts.shape, np.nan)
        for i, ends in enumerate(zip(low.tolist(), high.tolist(), strict=True)):
            clipped, inside = clip_to_domain(ends, starts[i])
            admitted[i, inside] = clipped[inside]
        return admitted

    def follow(
        self, columns: Columns, starts: Floats, run: Run, tail: int
    ) -> tuple[LongRun, Followed]:
        """Follow orbits from ``starts``, NaN passed over, in C order."""
        raise NotImplementedError


def rows(columns: Columns, size: int) -> Iterator[dict[str, float]]:
    """Give the values of the varied parameters at each of `size` grid points in turn."""
    for i in range(size):
        yield {name: float(column[i]) for name, column in columns.items()}
