"""Event maps and their orbits on a GPU: batches, and the instances of the kernels."""

from __future__ import annotations

from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from stickslip.mechanics.eventmap.backend import NO_ITINERARY, ScalarBackend, scratch_of
from stickslip.mechanics.eventmap.records import Outputs, new_outputs
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.model.arguments import two_blocks
from stickslip.numerics.gpu import device_array, launch_on_gpu, local_arrays, require_gpu
from stickslip.numerics.targets import instantiate

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap.records import Controls, Followed, ModelTable, Section
    from stickslip.mechanics.flow.engine import Engine, EngineName
    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats
    from stickslip.numerics.long_run import LongRun


# Numbers that one launch brings back: bounds the memory of the device.
LARGEST_BATCH = 1 << 26


class CudaBackend(ScalarBackend):
    """Two undamped blocks on a GPU, one orbit a thread; itineraries come from the CPU."""

    def __init__(self, model: Model, engine: EngineName, controls: Controls) -> None:
        model = check_model(model)
        require_gpu()
        super().__init__(model, engine_for(model, engine), controls, threads=1)
        check_traced(self.engine)

    def _carried(
        self, d: Floats, directions: Floats, watch: bool = False, section: Section | None = None
    ) -> Outputs:
        kernels = _map_kernels(self.engine, self.kernels, len(directions))
        outputs = new_outputs(d.shape, len(directions))
        for part in batches(d.size, len(outputs)):
            inputs = (*self._parameters, directions, self.controls, float(watch), d[part])
            batch = [array[part] for array in outputs]
            launch_on_gpu(kernels.carry_each, d[part].size, inputs, batch)
        return outputs

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1) from their first entries on; orbits stay on the device."""
        kernels = _map_kernels(self.engine, self.kernels, 0)
        for part in batches(*orbits.shape):
            inputs = (*self._parameters, self.controls, orbits[part, 0].copy())
            launch_on_gpu(kernels.iterate_each, len(orbits[part]), inputs, [orbits[part]])

    @property
    def _parameters(self) -> tuple[Floats, Floats]:
        """The system and its laws, one row for all threads."""
        return np.array([self.engine.system]), self.engine.laws[None].copy()


def check_model(model: Model) -> TwoBlock:
    """Return a model that a GPU carries, undamped equal blocks; else ValueError."""
    model = two_blocks(model, why="device = 'cuda' carries two equal blocks. Take device='cpu'.")
    if model.damping > 0.0:
        raise ValueError(
            "device = 'cuda' carries blocks without damping, and this model has damping = "
            f"{model.damping!r}. Take device='cpu'."
        )
    return model


def check_traced(engine: Engine) -> None:
    """Raise ValueError if the law of an engine is one that a GPU cannot run."""
    if not engine.code.traceable:
        raise ValueError(
            "device = 'cuda' needs a friction law that can be traced: write it with "
            "arithmetic and numpy functions, without branches; or take device='cpu'."
        )


def batches(n: int, numbers: int) -> list[slice]:
    """Cut `n` items, each of so many numbers, into launches."""
    size = max(1, LARGEST_BATCH // max(1, numbers))
    return [slice(first, first + size) for first in range(0, n, size)]


def _map_kernels(engine: Engine, carrying: ModuleType, n_columns: int) -> ModuleType:
    """Kernels that carry motions of an engine with so many tangents."""
    key = f"{engine.key}-{len(engine.laws)}-{n_columns}"
    arrays = (scratch_of(engine, n_columns), engine.laws, NO_ITINERARY)
    return instantiate(
        "stickslip.mechanics.eventmap._cuda_kernels",
        key,
        carry_number=carrying.carry_number,
        value_tangent=carrying.value_tangent,
        thread_arrays=local_arrays("cuda", thread_arrays=arrays).thread_arrays,
    )


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
    kernel = _follow_kernels(engine, following).follow_each
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


def _follow_kernels(engine: Engine, following: ModuleType) -> ModuleType:
    arrays = (scratch_of(engine, 0), scratch_of(engine, 1), NO_ITINERARY)
    return instantiate(
        "stickslip.mechanics.eventmap._cuda_follow_kernels",
        engine.key,
        follow_range=following.follow_range,
        thread_arrays=local_arrays("cuda", thread_arrays=arrays).thread_arrays,
    )
