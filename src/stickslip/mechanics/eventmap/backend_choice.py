"""Which backend serves a model, and the one of two damped blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.checks import one_of
from stickslip.mechanics.eventmap.backend import Backend, ScalarBackend
from stickslip.mechanics.eventmap.blocks_map import BlocksEventMap
from stickslip.mechanics.eventmap.lanes import LaneBackend, lanes_serve
from stickslip.mechanics.eventmap.pools import PoolBackend
from stickslip.mechanics.eventmap.records import Controls, Outputs
from stickslip.mechanics.flow.engine import EngineName, engine_for
from stickslip.mechanics.friction.series import law_series

if TYPE_CHECKING:
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats


DEVICES = ("cpu", "cuda")


def backend_for(
    model: TwoBlock, engine: EngineName, controls: Controls, device: str, threads: int
) -> Backend:
    """Choose what carries the motions of a model; ValueError if the device cannot."""
    if one_of("device", device, DEVICES) == "cuda":
        from stickslip.mechanics.eventmap.cuda import CudaBackend  # needs numba-cuda

        return CudaBackend(model, engine, controls)
    if model.damping > 0.0:
        return DampedBackend(model, engine, controls, threads)
    moved = engine_for(model, engine)
    if lanes_serve(moved, controls):
        return LaneBackend(model, moved, controls, threads)
    series = law_series(model.laws) if moved.name == "taylor" else None
    if series is not None:
        return PoolBackend(model, moved, controls, threads, series)
    return ScalarBackend(model, moved, controls, threads)


class DampedBackend:
    """Two damped blocks: the flow of the family."""

    name = "series"

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        engine_for(model.replace(damping=0.0), engine)  # the same errors
        self.inner = BlocksEventMap(model.chain, **controls._asdict(), threads=threads)

    def value(self, d: float) -> float:
        """Value at one d."""
        return float(self.carry(np.array([d])).value[0])

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each d, and slopes."""
        found = self.inner.carry(d[:, None], slope=slope, watch=watch)
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
