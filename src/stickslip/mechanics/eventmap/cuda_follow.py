"""Orbits of many event maps on a GPU: batches, and the instances of the kernels."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.carrier import NO_ITINERARY, new_scratch
from stickslip.mechanics.eventmap.cuda_carrier import batches, check_traced
from stickslip.numerics.gpu import device_array, launch_on_gpu, local_arrays
from stickslip.numerics.targets import instantiate

if TYPE_CHECKING:
    from types import ModuleType

    from stickslip.mechanics.eventmap.follow_records import Followed, ModelTable
    from stickslip.mechanics.eventmap.records import Controls
    from stickslip.mechanics.flow.engine import Engine
    from stickslip.mechanics.flow.system import Floats
    from stickslip.numerics.long_run import LongRun

PATH_NUMBERS = 3  # that each step of an orbit leaves on the device


def follow_on_gpu(
    engine: Engine,
    following: ModuleType,
    models: ModelTable,
    starts: Floats,
    *,
    controls: Controls,
    transient: int,
    n: int,
    max_period: int,
    verdicts: LongRun,
    followed: Followed,
) -> None:
    """Follow the orbit of each start by the loop of `following`; results as `follow` has them."""
    check_traced(engine)
    kernel = _kernels(engine, following).follow_each
    for part in batches(starts.size, PATH_NUMBERS * (n + 1)):
        m = starts[part].size
        paths = (
            device_array((m, n + 1), np.float64),
            device_array((m, n), np.uint64),
            device_array((m, n), np.float64),
        )
        here = models._replace(of_start=models.of_start[part])
        inputs = (*here, starts[part], transient, max_period, controls, *paths)
        results = [array[part] for array in (*verdicts, *followed)]
        launch_on_gpu(kernel, m, inputs, results, filled=True)


def _kernels(engine: Engine, following: ModuleType) -> ModuleType:
    arrays = (new_scratch(engine, 0), new_scratch(engine, 1), NO_ITINERARY)
    return instantiate(
        "stickslip.mechanics.eventmap._cuda_follow_kernels",
        engine.key,
        follow_range=following.follow_range,
        thread_arrays=local_arrays("cuda", thread_arrays=arrays).thread_arrays,
    )
