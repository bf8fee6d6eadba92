"""Orbits of one event map or of many side by side: each step by lanes."""

# Template (`numerics.targets.instantiate`): the exact engine's map, asked where lanes pass, is
# bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.eventmap._lane_kernels import (
    BLOCK,
    COUNT,
    ELAPSED,
    LABEL,
    Carried,
    Indices,
)
from stickslip.mechanics.eventmap._lane_list_kernels import carry_block, carry_lanes
from stickslip.mechanics.eventmap.records import Batch, Controls, Followed, ModelTable, Scratch
from stickslip.mechanics.flow._lane_kernels import constants_at
from stickslip.mechanics.flow.system import Floats, System
from stickslip.mechanics.friction.interface import STATIC_COLUMN
from stickslip.numerics.long_run import LongRun, Path, read_off
from stickslip.numerics.targets import kernel
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._kernels import carry_number
    from stickslip.mechanics.eventmap._pair_kernels import value_tangent


@kernel
def line_up(models: ModelTable, starts: NDArray[np.float64], at: int, batch: Batch) -> int:
    """Put starts from ``starts[at]`` on into slots with their constants; NaN are passed over."""
    m = 0
    for i in range(at, min(at + batch.orbit.shape[0], starts.shape[0])):
        if math.isnan(starts[i]):
            continue
        model = models.of_start[i]
        laws = models.laws[models.law_row[model]]
        mu_1, mu_2 = laws[0, STATIC_COLUMN], laws[1, STATIC_COLUMN]
        constants = constants_at(
            models.alpha[model], models.beta[model], models.V[model], mu_1, mu_2
        )
        for field in range(len(constants)):
            batch.rows[field, m] = constants[field]
        batch.x[m] = starts[i]
        batch.orbit[m] = i
        m += 1
    return m


@kernel
def move_up(batch: Batch, source: int, target: int) -> None:
    """Move an orbit to another slot."""
    batch.x[target] = batch.x[source]
    batch.orbit[target] = batch.orbit[source]
    for field in range(batch.rows.shape[0]):
        batch.rows[field, target] = batch.rows[field, source]


@kernel
def ask(
    models: ModelTable,
    i: int,
    d: float,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> tuple[float, float, np.uint64, int, float, int]:
    """Carry orbit i one step by the exact engine: (value, slope, label, events, time, status)."""
    model = models.of_start[i]
    system = System(models.alpha[model], models.beta[model], models.V[model])
    laws = models.laws[models.law_row[model]]
    value, duration, n_events, label, _, status = carry_number(
        system, laws, d, scratch, controls, itinerary
    )
    slope = math.nan
    if scratch.motion.directions.shape[0] > 0:
        slope = value_tangent(system, scratch.motion, value, 0)
    return value, slope, label, n_events, duration, status


@kernel(inline=True)
def each_its_own(batch: Batch) -> Carried:
    """Models of the motions in slots: the common constants are none of them."""
    return Carried(constants_at(1.0, 1.0, 1.0, 0.0, 0.0), None, batch.rows)


@kernel
def follow_slots(
    models: ModelTable,
    m: int,
    at: int,
    steps: int,
    recorded: bool,
    batch: Batch,
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    followed: Followed,
) -> int:
    """Apply the maps to the first m slots, with or without a record; return how many are left."""
    x, orbit, value, b, index = batch.x, batch.orbit, batch.value, batch.streams, batch.lists
    few, carried, zero = x.shape[0], each_its_own(batch), np.uint64(0)
    slopes = batch.slope if recorded else x[:0]
    for s in range(m):
        i = orbit[s]
        batch.point[i - at, 0] = x[s]
        followed.mean_duration[i] = followed.mean_events[i] = 0.0
    for k in range(steps):
        for s in range(m):
            value[s] = x[s]
        carry_block(
            carried,
            b,
            index,
            np.uint64(m),
            value,
            slopes,
            zero,
            controls.max_events,
            few,
            recorded,
            None,
            None,
        )
        left = 0
        for s in range(m):
            i, slot, status = orbit[s], np.uint64(s), OK
            d, slope, duration = value[s], batch.slope[s], b[ELAPSED + slot]
            label, n_events = index[LABEL + slot], int(index[COUNT + slot])
            if not math.isfinite(d):
                d, slope, label, n_events, duration, status = ask(
                    models, i, x[s], scratch, controls, itinerary
                )
            followed.status[i] = status
            if status != OK:
                followed.mean_duration[i] = followed.mean_events[i] = math.nan
                followed.most_events[i] = 0
                continue
            if recorded:
                batch.point[i - at, k + 1] = d
                batch.label[i - at, k] = label
                batch.log_slope[i - at, k] = math.log(abs(slope)) if slope != 0.0 else -math.inf
                followed.mean_duration[i] += duration
                followed.mean_events[i] += n_events
                followed.most_events[i] = max(followed.most_events[i], n_events)
            followed.steps[i] += 1
            x[s] = d
            if left != s:
                move_up(batch, s, left)
            left += 1
        m = left
    return m


@kernel
def follow_batch(
    models: ModelTable,
    starts: NDArray[np.float64],
    transient: int,
    max_period: int,
    batch: Batch,
    scratch: Scratch,
    tangent_scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
    verdicts: LongRun,
    followed: Followed,
) -> None:
    """Follow the orbits of `starts`; a start that is NaN is left as it is."""
    n = batch.log_slope.shape[1]
    tail = followed.tail.shape[1]
    for at in range(0, starts.shape[0], batch.orbit.shape[0]):
        m = line_up(models, starts, at, batch)
        own = batch, scratch, controls, itinerary, followed
        m = follow_slots(models, m, at, transient, False, *own)
        own = batch, tangent_scratch, controls, itinerary, followed
        m = follow_slots(models, m, at, n, True, *own)
        for s in range(m):
            i = batch.orbit[s]
            model = models.of_start[i]
            followed.mean_duration[i] /= n
            followed.mean_events[i] /= n
            for k in range(tail):
                followed.tail[i, k] = batch.point[i - at, n - tail + 1 + k]
            end = (1.0 + models.beta[model]) / (1.0 + 2.0 * models.alpha[model])
            path = Path(batch.point[i - at], batch.label[i - at], batch.log_slope[i - at])
            read_off(path, -end, end, max_period, verdicts, i)


@kernel
def iterate_lanes(
    row: Floats,
    streams: Floats,
    index: Indices,
    column: Floats,
    no_slope: Floats,
    orbits: NDArray[np.float64],
    start: int,
    stop: int,
    system: System,
    laws: NDArray[np.float64],
    scratch: Scratch,
    controls: Controls,
    itinerary: NDArray[np.int8],
) -> None:
    """Fill rows ``start..stop`` of `orbits` (starts, n + 1) from their first entries on."""
    for at in range(start, stop, BLOCK):
        n = min(BLOCK, stop - at)
        for k in range(orbits.shape[1] - 1):
            for i in range(n):
                column[i] = orbits[at + i, k]
            carry_lanes(
                row, None, streams, index, column, no_slope, 0, n, controls.max_events, None, None
            )
            for i in range(n):
                d, value = orbits[at + i, k], column[i]
                if math.isnan(d) or math.isinf(value):
                    value = math.nan
                elif math.isnan(value):
                    value, _, _, _, _, _ = carry_number(
                        system, laws, d, scratch, controls, itinerary
                    )
                orbits[at + i, k + 1] = value
