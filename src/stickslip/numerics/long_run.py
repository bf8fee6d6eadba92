"""What an orbit of a map of the line does in the long run, read off a stretch of it.

What each verdict, of an orbit of finite length, rests on: docs/sweeps.md.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.targets import kernel

Floats = NDArray[np.float64]

# Kinds of orbits.
UNDECIDED, LEFT, PERIODIC, CHAOTIC = -1, 0, 1, 2

RECURRENCE = 1e-9  # of the domain: points of a settled orbit come back this closely
PERIODS = 10  # over so many periods, and at least over
STEPS = 256  # so many steps, if the stretch is that long
BATCHES = 16  # means whose scatter gives the error of an exponent
SIGMAS = 5.0  # errors by which the exponent of chaos exceeds zero
CELLS = 256  # of the domain; those that an orbit visits are kept as bits
WORDS = CELLS // 64


class Path(NamedTuple):
    """A stretch of one orbit: ``point`` (n + 1,); ``label``, ``log_slope`` (n,), of each step."""

    point: Floats
    label: NDArray[np.uint64]
    log_slope: Floats


class LongRun(NamedTuple):
    """Verdicts, an entry for each orbit."""

    kind: NDArray[np.int8]
    period: NDArray[np.int32]  # 0 unless the kind is PERIODIC
    exponent: Floats  # mean of log |f'|
    error: Floats  # standard error of the exponent
    cells: NDArray[np.uint64]  # shape (m, 4): bits of the cells visited


def new_path(n: int) -> Path:
    """Arrays for a stretch of n steps."""
    return Path(np.zeros(n + 1), np.zeros(n, dtype=np.uint64), np.zeros(n))


def new_long_run(m: int) -> LongRun:
    """Arrays for the verdicts on m orbits; each has left until it is read off."""
    return LongRun(
        np.full(m, LEFT, dtype=np.int8),
        np.zeros(m, dtype=np.int32),
        np.full(m, np.nan),
        np.full(m, np.nan),
        np.zeros((m, WORDS), dtype=np.uint64),
    )


@kernel
def recurs(path: Path, period: int, tolerance: float) -> bool:
    """Whether the end of a stretch repeats itself after so many steps, points and labels."""
    n = path.log_slope.shape[0]
    span = min(n - period, max(PERIODS * period, STEPS))
    for k in range(n, n - span, -1):
        if not abs(path.point[k] - path.point[k - period]) <= tolerance:
            return False
        if path.label[k - 1] != path.label[k - 1 - period]:
            return False
    return True


@kernel
def mean_log_slope(path: Path, steps: int) -> float:
    """Mean of log |f'| over the last steps."""
    n = path.log_slope.shape[0]
    total = 0.0
    for k in range(n - steps, n):
        total += path.log_slope[k]
    return total / steps


@kernel
def batch_error(path: Path) -> float:
    """Estimate the error of the mean of log |f'| from the scatter of means over equal batches."""
    size = path.log_slope.shape[0] // BATCHES
    if size == 0:
        return math.inf
    mean = square = 0.0
    for batch in range(BATCHES):
        part = 0.0
        for k in range(batch * size, (batch + 1) * size):
            part += path.log_slope[k]
        part /= size
        change = part - mean
        mean += change / (batch + 1)
        square += change * (part - mean)
    return math.sqrt(square / (BATCHES - 1) / BATCHES)


@kernel
def read_off(
    path: Path, low: float, high: float, max_period: int, verdicts: LongRun, i: int
) -> None:
    """Fill in entry `i` of the verdicts from a stretch inside the domain (low, high)."""
    n = path.log_slope.shape[0]
    width = high - low
    for k in range(n + 1 if width < math.inf else 0):  # the whole line has no cells
        cell = min(max(int((path.point[k] - low) / width * CELLS), 0), CELLS - 1)
        verdicts.cells[i, cell // 64] |= np.uint64(1) << np.uint64(cell % 64)
    verdicts.period[i] = 0
    verdicts.kind[i] = UNDECIDED
    # A repetition is one if it is seen twice.
    for period in range(1, min(max_period, n // 2) + 1):
        if recurs(path, period, RECURRENCE * width):
            exponent = mean_log_slope(path, period)
            verdicts.exponent[i] = exponent
            verdicts.error[i] = 0.0
            if exponent < 0.0:  # else rounding holds the orbit on a cycle that repels
                verdicts.kind[i] = PERIODIC
                verdicts.period[i] = period
            return
    verdicts.exponent[i] = mean_log_slope(path, n)
    verdicts.error[i] = batch_error(path) if verdicts.exponent[i] > -math.inf else math.inf
    if verdicts.exponent[i] > SIGMAS * verdicts.error[i]:
        verdicts.kind[i] = CHAOTIC
