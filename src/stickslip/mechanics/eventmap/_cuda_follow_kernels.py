"""Orbits of many event maps on a GPU: an orbit a thread, from its start to its verdict."""

# Template (`numerics.targets.instantiate`): the CPU's loop over orbits, one turn a thread, is
# bound. Points of the paths lie on the device and stay there.

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numba import cuda as _cuda

from stickslip.mechanics.eventmap.records import Followed, ModelTable
from stickslip.mechanics.flow.system import START
from stickslip.numerics.long_run import LongRun, Path

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap._follow_kernels import follow_range

    def thread_arrays() -> Any:
        """Return the scratch of a motion, that of one with a tangent, and an empty itinerary."""


cuda: Any = _cuda  # its stubs know the host's side alone


@cuda.jit
def follow_each(  # type: ignore[no-untyped-def]
    alpha,
    beta,
    V,
    laws,
    law_row,
    of_start,
    starts,
    transient,
    max_period,
    controls,
    point,
    label,
    log_slope,
    kind,
    period,
    exponent,
    error,
    cells,
    status,
    steps,
    tail,
    mean_events,
    most_events,
    mean_duration,
):
    """Follow orbits; arguments: fields of `ModelTable`, `Path`, `LongRun`, `Followed`."""
    i = cuda.grid(1)
    if i >= starts.shape[0]:
        return
    scratch, tangent_scratch, itinerary = thread_arrays()
    tangent_scratch.motion.directions[0, START] = 1.0
    tangent_scratch.long_motion.directions[0, START] = 1.0
    follow_range(
        ModelTable(alpha, beta, V, laws, law_row, of_start),
        starts,
        i,
        i + 1,
        transient,
        max_period,
        scratch,
        tangent_scratch,
        controls,
        itinerary,
        Path(point[i], label[i], log_slope[i]),
        LongRun(kind, period, exponent, error, cells),
        Followed(status, steps, tail, mean_events, most_events, mean_duration),
    )
