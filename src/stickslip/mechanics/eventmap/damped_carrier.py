"""Carries motions of two damped blocks: the flow of the family."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.records import Controls, Outputs
from stickslip.mechanics.flow.engine import EngineName, engine_for

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock

    Floats = NDArray[np.float64]


class DampedCarrier:
    """Two damped blocks: the flow of the family."""

    name = "series"

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        engine_for(model.replace(damping=0.0), engine)  # the same errors
        self.inner = BlocksEventMap(model.chain, **controls._asdict(), threads=threads)

    def value(self, d: float) -> float:
        """Value at one d."""
        return float(self.values(np.array([d]))[0])

    def values(self, d: Floats) -> Floats:
        """Value at each d."""
        return self.inner.carry(d[:, None]).value[:, 0]

    def slopes(self, d: Floats) -> Floats:
        """Slope at each d."""
        return self.inner.carry(d[:, None], slope=True).derivative[:, 0, 0]

    def values_and_slopes(self, d: Floats) -> tuple[Floats, Floats]:
        """Value and slope at each d."""
        found = self.inner.carry(d[:, None], slope=True)
        return found.value[:, 0], found.derivative[:, 0, 0]

    def evidence(self, d: Floats) -> Outputs:
        """Everything of each d, the slope in column 0 of its derivatives."""
        found = self.inner.carry(d[:, None], slope=True, watch=True)
        return Outputs(found.value[:, 0], found.derivative[:, 0], *found[2:])

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d."""
        name = {"beta": "static_2"}.get(name, name)
        return self.inner.parameter_derivative(d[:, None], name)[:, 0]

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on."""
        self.inner._fill(orbits[..., None])

    def itinerary(self, d: float) -> str:
        """Modes of each phase, as text."""
        return str(self.inner.itinerary([d]))
