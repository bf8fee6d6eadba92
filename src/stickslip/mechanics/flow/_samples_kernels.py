"""A motion of two undamped equal blocks at even times and at its events, in one call."""

# Template (`numerics.targets.instantiate`): the stepper is bound.

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.system import MAX_INSTANT, STICK, Floats, Ints, Motion, System, limit
from stickslip.mechanics.flow.transitions import onset, settle
from stickslip.numerics.targets import kernel
from stickslip.status import EVENT_LIMIT, OK, UNDECIDED

if TYPE_CHECKING:
    from stickslip.mechanics.flow._exact_kernels import advance


@kernel
def write_state(motion: Motion, t: float, row: Floats, modes: NDArray[np.int8]) -> None:
    """Keep t, w and e, and the modes of the phase that begins."""
    row[0] = t
    for i in range(2):
        row[1 + i] = motion.w[i]
        row[3 + i] = motion.e[i]
        modes[i] = motion.mode[i]


@kernel
def ride(system: System, motion: Motion, cap: float) -> tuple[float, bool]:
    """Global stick, for at most `cap`: how long, and whether a slip began."""
    room = min(limit(system, 0) - motion.e[0], limit(system, 1) - motion.e[1])
    t = max(room, 0.0) / system.V
    if t <= cap:
        onset(system, motion, (motion.e[1] - motion.e[0]) / (1.0 + 2.0 * system.alpha))
        return t, True
    for i in range(2):
        motion.e[i] += system.V * cap
    return cap, False


@kernel
def sample(
    system: System,
    laws: Floats,
    d: float,
    t_end: float,
    every: float,
    motion: Motion,
    work: Any,
    rtol: float,
    rows: Floats,
    modes: NDArray[np.int8],
    count: Ints,
) -> None:
    """Fill `rows` (n, 5) and `modes` (n, 2) from a global stick on; `count`: rows, status."""
    onset(system, motion, d)
    t, k, instant, status = 0.0, 1, 0, OK
    write_state(motion, t, rows[0], modes[0])
    while t < t_end and k < rows.shape[0] and instant <= 2 * MAX_INSTANT:
        due = min(t_end, every * (math.floor(t / every + 1e-9) + 1.0))
        if motion.mode[0] == STICK and motion.mode[1] == STICK:
            step, event = ride(system, motion, due - t)
        else:
            step, status = advance(system, laws, motion, work, rtol, due - t)
            if status != OK:
                break
            event = motion.event[0] != 0 or motion.event[1] != 0
            settle(system, motion)
        instant = instant + 1 if event and step == 0.0 else 0
        t = due if step == due - t else t + step
        if event or t == due:
            write_state(motion, t, rows[k], modes[k])
            k += 1
    if status == OK and t < t_end:
        status = EVENT_LIMIT if k == rows.shape[0] else UNDECIDED
    count[0], count[1] = k, status
