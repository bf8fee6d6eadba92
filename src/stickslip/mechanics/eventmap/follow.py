"""Orbits of many event maps at once: one compiled loop for models that differ in numbers only."""

# Under constant kinetic friction lanes carry orbits side by side; other orbits follow one another.

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.mechanics.eventmap.backend import NO_ITINERARY, driver, scratch_of
from stickslip.mechanics.eventmap.lanes import lanes_serve, new_lane_scratch
from stickslip.mechanics.eventmap.records import ModelTable, new_batch, new_followed
from stickslip.numerics.long_run import new_long_run, new_path
from stickslip.numerics.targets import instantiate

if TYPE_CHECKING:
    from types import ModuleType

    from stickslip.mechanics.eventmap.records import Batch, Controls, Followed
    from stickslip.mechanics.flow.engine import Engine
    from stickslip.mechanics.flow.system import Floats
    from stickslip.numerics.long_run import LongRun

# Points of paths that are kept at once, and the least number of orbits side by side.
PATH_POINTS = 1 << 20
LEAST_SLOTS = 64


def follow(
    engine: Engine,
    models: ModelTable,
    starts: Floats,
    *,
    controls: Controls,
    transient: int,
    n: int,
    max_period: int,
    tail: int,
    device: str = "cpu",
) -> tuple[LongRun, Followed]:
    """Follow the orbit of each starting point under the map of its own model."""
    # `engine` serves all models by its kernels alone. Starts that are NaN are passed over. After
    # `transient` maps, `n` are looked at, for periods up to `max_period`; `tail` <= n + 1 last
    # points are kept. Results have an entry for each start and depend on no other start.
    verdicts, followed = new_long_run(starts.size), new_followed(starts.size, tail)
    if device == "cuda":
        from stickslip.mechanics.eventmap.cuda import follow_on_gpu  # needs numba-cuda

        follow_on_gpu(
            engine,
            _kernels(engine, "_follow_kernels"),
            models,
            starts,
            controls=controls,
            transient=transient,
            n=n,
            max_period=max_period,
            verdicts=verdicts,
            followed=followed,
        )
        return verdicts, followed
    scratch = (scratch_of(engine, 0), scratch_of(engine, 1))
    if engine.name == "exact" and lanes_serve(controls):
        _kernels(engine, "_lane_follow_kernels").follow_batch(
            models,
            starts,
            transient,
            max_period,
            _batch(starts.size, n),
            *scratch,
            controls,
            NO_ITINERARY,
            verdicts,
            followed,
        )
        return verdicts, followed
    _kernels(engine, "_follow_kernels").follow_range(
        models,
        starts,
        0,
        starts.size,
        transient,
        max_period,
        *scratch,
        controls,
        NO_ITINERARY,
        new_path(n),
        verdicts,
        followed,
    )
    return verdicts, followed


def _batch(m: int, n: int) -> Batch:
    """Room for some orbits: as many as lanes carry at once, fewer if their paths are long."""
    streams, lists, column = new_lane_scratch()
    slots = min(m, column.size, max(LEAST_SLOTS, PATH_POINTS // (n + 1)))
    return new_batch(slots, n, streams, lists)


def _kernels(engine: Engine, template: str) -> ModuleType:
    maps = driver(engine)
    return instantiate(
        f"stickslip.mechanics.eventmap.{template}",
        engine.key,
        carry_number=maps.carry_number,
        value_tangent=maps.value_tangent,
    )
