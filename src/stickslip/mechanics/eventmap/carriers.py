"""Which carrier serves a model."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.checks import one_of
from stickslip.mechanics.eventmap.carrier import Carrier, PlainCarrier
from stickslip.mechanics.eventmap.damped_carrier import DampedCarrier
from stickslip.mechanics.eventmap.lane_carrier import LaneCarrier
from stickslip.mechanics.eventmap.lanes import lanes_serve
from stickslip.mechanics.eventmap.pool_carrier import PoolCarrier
from stickslip.mechanics.flow.engine import EngineName, engine_for
from stickslip.mechanics.friction.series import law_series

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.model.two_block import TwoBlock

DEVICES = ("cpu", "cuda")


def carrier_for(
    model: TwoBlock, engine: EngineName, controls: Controls, device: str, threads: int
) -> Carrier:
    """Choose what carries the motions of a model; ValueError if the device cannot."""
    if one_of("device", device, DEVICES) == "cuda":
        from stickslip.mechanics.eventmap.cuda_carrier import CudaCarrier  # needs numba-cuda

        return CudaCarrier(model, engine, controls)
    if model.damping > 0.0:
        return DampedCarrier(model, engine, controls, threads)
    moved = engine_for(model, engine)
    if lanes_serve(moved, controls):
        return LaneCarrier(model, moved, controls, threads)
    series = law_series(model.laws) if moved.name == "taylor" else None
    if series is not None:
        return PoolCarrier(model, moved, controls, threads, series)
    return PlainCarrier(model, moved, controls, threads)
