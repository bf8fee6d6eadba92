"""Orbits of many event maps, one after the other: each starting point has parameters of its own."""

# Template (`numerics.targets.instantiate`): the map of one motion is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap.records import Controls, Followed, ModelTable, Scratch
from stickslip.mechanics.flow.system import Floats, System
from stickslip.numerics.long_run import LongRun, Path, read_off
from stickslip.numerics.targets import kernel
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._kernels import carry_number
    from stickslip.mechanics.eventmap._pair_kernels import value_tangent


@kernel
def settle_down(
    system: System,
    laws: Floats,
    d: float,
    steps: int,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, int, int]:
    """Apply the map `steps` times: (last point, status, steps done)."""
    for k in range(steps):
        value, _, _, _, _, status = carry_number(system, laws, d, scratch, controls, itinerary)
        if status != OK:
            return d, status, k
        d = value
    return d, OK, steps


@kernel
def follow_range(
    models: ModelTable,
    starts: Floats,
    start: int,
    stop: int,
    transient: int,
    max_period: int,
    scratch: Scratch,
    tangent_scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    path: Path,
    verdicts: LongRun,
    followed: Followed,
) -> None:
    """Follow the orbits of ``starts[start:stop]``; a start that is NaN is left as it is."""
    n = path.log_slope.shape[0]
    tail = followed.tail.shape[1]
    for i in range(start, stop):
        if math.isnan(starts[i]):
            continue
        model = models.of_start[i]
        system = System(models.alpha[model], models.beta[model], models.V[model])
        laws = models.laws[models.law_row[model]]
        d, status, steps = settle_down(
            system, laws, starts[i], transient, scratch, controls, itinerary
        )
        total_time = total_events = 0.0
        most_events = 0
        path.point[0] = d
        for k in range(n):
            if status != OK:
                break
            value, duration, n_events, label, _, status = carry_number(
                system, laws, d, tangent_scratch, controls, itinerary
            )
            if status != OK:
                break
            slope = value_tangent(system, tangent_scratch.motion, value, 0)
            d = value
            path.point[k + 1] = d
            path.label[k] = label
            path.log_slope[k] = math.log(abs(slope)) if slope != 0.0 else -math.inf
            total_time += duration
            total_events += n_events
            most_events = max(most_events, n_events)
            steps += 1
        followed.status[i] = status
        followed.steps[i] = steps
        if status != OK:
            continue
        followed.mean_duration[i] = total_time / n
        followed.mean_events[i] = total_events / n
        followed.most_events[i] = most_events
        for k in range(tail):
            followed.tail[i, k] = path.point[n - tail + 1 + k]
        half_width = (1.0 + system.beta) / (1.0 + 2.0 * system.alpha)
        read_off(path, -half_width, half_width, max_period, verdicts, i)
