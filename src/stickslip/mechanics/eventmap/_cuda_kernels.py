"""The event map on a GPU: one orbit a thread, by the kernels that the CPU runs."""

# Template (`numerics.targets.instantiate`): what carries a motion and makes scratch arrays is
# bound. ``systems`` and ``laws`` have one row, for all threads.

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from numba import cuda as _cuda

from stickslip.mechanics.flow.system import System
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._kernels import carry_number
    from stickslip.mechanics.eventmap._pair_kernels import value_tangent

    def thread_arrays() -> Any:
        """Return the scratch of one motion, a row for its laws and an empty itinerary."""


cuda: Any = _cuda  # its stubs know the host's side alone


@cuda.jit(device=True, inline="always")
def load_system(systems, laws, law):  # type: ignore[no-untyped-def]
    """Return the parameters, and copy those of the laws into `law`."""
    for piece in range(law.shape[0]):
        for k in range(law.shape[1]):
            law[piece, k] = laws[0, piece, k]
    return System(systems[0, 0], systems[0, 1], systems[0, 2])


@cuda.jit
def carry_each(  # type: ignore[no-untyped-def]
    systems,
    laws,
    directions,
    controls,
    watch,
    d,
    value,
    derivative,
    duration,
    n_events,
    label,
    margin,
    status,
):
    """Evaluate the map at each ``d``; the arrays after it are fields of `Outputs`."""
    i = cuda.grid(1)
    if i >= d.shape[0]:
        return
    scratch, law, itinerary = thread_arrays()
    system = load_system(systems, laws, law)
    for column in range(directions.shape[0]):
        for k in range(directions.shape[1]):
            scratch.motion.directions[column, k] = directions[column, k]
            scratch.long_motion.directions[column, k] = directions[column, k]
    scratch.work.watch[0] = watch
    start = 0.0 if math.isnan(d[i]) else d[i]
    value[i], duration[i], n_events[i], label[i], margin[i], status[i] = carry_number(
        system, law, start, scratch, controls, itinerary
    )
    if math.isnan(d[i]):
        value[i] = math.nan
    for column in range(directions.shape[0]):
        slope = value_tangent(system, scratch.motion, value[i], column)
        derivative[i, column] = slope if status[i] == OK else math.nan


@cuda.jit
def iterate_each(systems, laws, controls, d, orbits):  # type: ignore[no-untyped-def]
    """Fill rows of `orbits` (starts, n + 1) with the orbits of ``d``; NaN stays NaN."""
    i = cuda.grid(1)
    if i >= d.shape[0]:
        return
    scratch, law, itinerary = thread_arrays()
    system = load_system(systems, laws, law)
    value = d[i]
    orbits[i, 0] = value
    for k in range(orbits.shape[1] - 1):
        if not math.isnan(value):
            value, _, _, _, _, _ = carry_number(system, law, value, scratch, controls, itinerary)
        orbits[i, k + 1] = value
