"""Settings of a computation, checked once: the same for trajectories and event maps."""

from __future__ import annotations

import math

from stickslip.checks import finite_number

# Steps or events in zero time, for each block, after which the modes count as undecidable (rule 5).
MAX_INSTANT = 4


def tolerance(rtol: object) -> float:
    """Return the local truncation error of the adaptive engine, in (0, 1e-3], at least 1e-16."""
    why = "rtol is the local truncation error of the adaptive engine."
    number = finite_number("rtol", rtol, above=0.0, at_most=1e-3, why=why)
    return max(number, 1e-16)


def time_limit(value: object) -> float:
    """Return the longest time of one motion, which may be infinite."""
    if isinstance(value, float) and value == math.inf:
        return value
    return finite_number("max_time", value, above=0.0, why="max_time limits one motion's time.")
