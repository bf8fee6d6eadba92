"""Law (9) in doubles by a stepper of another kind than the package's, for samples of a million.

Positions and velocities, the midpoint rule extrapolated to order 10 (Gragg, Bulirsch and Stoer),
and events by looking at both ends of a step and at minima between them; the time of an event by
taking the step anew. Nothing is expanded in a series, no polynomial is made, no bound is used. It
proves nothing: two contacts within one step of a quarter could be missed. Where it is not sure of a
decision it says so, and where it and the package differ the oracle of `law9.py` decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

RETURNED, ENDLESS, UNSURE = 0, 1, 2

ROWS = 5  # the midpoint rule with 2, 4, .. 10 substeps
LONGEST = 0.25
SHORTEST = 1e-6
ACCURACY = 1e-14  # of the extrapolation before the last one: two orders less
CLOSE = 1e-9  # decisions closer than this are left to others
ENDLESS_AFTER = 400.0  # without an event

# Not the package's `kernel`, of which nothing is used here. Numba's cache knows of changes in the
# file of a function, and there is no other.
kernel = numba.njit(cache=True, error_model="numpy")  # noqa: TID251


class Plant(NamedTuple):
    """Parameters of a system."""

    alpha: float
    beta: float
    V: float
    gamma: float
    delta: float = 0.0
    eta: float = 0.0


@kernel
def law(p, s):
    """Eq. (9) in s = |X' - V|; steps beyond an event take it at s < 0."""
    return (1.0 - p.delta) / (1.0 + p.gamma * s) + p.delta + p.eta * s * s


@kernel
def need(p, y, block):
    """R of eq. (6a)."""
    return y[block] + p.alpha * (y[block] - y[1 - block])


@kernel
def acceleration(p, modes, y, block):
    """X'' (5a, 7a); zero of a rider."""
    mode = modes[block]
    if mode == 0:
        return 0.0
    limit = 1.0 if block == 0 else p.beta
    return -mode * limit * law(p, mode * (y[2 + block] - p.V)) - need(p, y, block)


@kernel
def slope(p, modes, y, dy):
    """Derivatives of (X_1, X_2, X_1', X_2')."""
    for block in range(2):
        dy[block] = y[2 + block]
        dy[2 + block] = acceleration(p, modes, y, block)


@kernel
def step(p, modes, y, h, table, end):
    """Put the state a time h after `y` into `end`; return the distance of the last two results."""
    old, now, rate = np.empty(4), np.empty(4), np.empty(4)
    distance = 0.0
    for row in range(ROWS):
        n = 2 * (row + 1)
        slope(p, modes, y, rate)
        for i in range(4):
            old[i], now[i] = 0.0, rate[i] * h / n  # increments, for the sake of rounding
            end[i] = y[i] + now[i]
        for _ in range(1, n):
            slope(p, modes, end, rate)
            for i in range(4):
                old[i], now[i] = now[i], old[i] + 2.0 * rate[i] * h / n
                end[i] = y[i] + now[i]
        slope(p, modes, end, rate)
        for i in range(4):
            table[row, i] = 0.5 * (old[i] + now[i] + rate[i] * h / n)
        distance = 0.0
        for k in range(row - 1, -1, -1):
            ratio = (row + 1) / (k + 1)
            for i in range(4):
                change = (table[k + 1, i] - table[k, i]) / (ratio * ratio - 1.0)
                table[k, i] = table[k + 1, i] + change
                if k == 0:
                    distance = max(distance, abs(change))
    for i in range(4):
        end[i] = y[i] + table[0, i]
    return distance


@kernel
def signal(p, modes, y, which):
    """What stays positive while the modes last, and its rate: 0, 1 of block 1, 2, 3 of block 2.

    Of a slipping block |w| (and nothing), of a rider the distances from both limits.
    """
    block, second = which // 2, which % 2
    mode = modes[block]
    if mode != 0:
        if second:
            return 1.0, 1.0
        return mode * (y[2 + block] - p.V), mode * acceleration(p, modes, y, block)
    side = -1.0 if second else 1.0
    limit = 1.0 if block == 0 else p.beta
    rate = y[2 + block] + p.alpha * (y[2 + block] - y[3 - block])
    return limit - side * need(p, y, block), -side * rate


@kernel
def minimum(p, modes, y, h, which, table, end):
    """Time in (0, h) at which a signal that falls, then rises, is least; leaves its state."""
    low, high = 0.0, h
    for _ in range(60):
        t = 0.5 * (low + high)
        step(p, modes, y, t, table, end)
        if signal(p, modes, end, which)[1] < 0.0:
            low = t
        else:
            high = t
        if high - low < 1e-9 * h:
            break
    return high


@kernel
def root(p, modes, y, h, which, table, end):
    """Time in (0, h] at which a signal that ends below zero crosses; leaves the state there."""
    low, high, t = 0.0, h, h
    for _ in range(80):
        step(p, modes, y, t, table, end)
        value, rate = signal(p, modes, end, which)
        if value > 0.0:
            low = t
        else:
            high = t
        move = -value / rate if rate < 0.0 else math.inf
        if abs(move) <= 2e-16 * (1.0 + t):
            break
        t = t + move if low < t + move < high else 0.5 * (low + high)
    return t


@kernel
def next_state(p, modes, y, fresh, h, table, end, trial):
    """One step: (its time, the length to try next, the signal that reached zero or -1, sure)."""
    while True:
        distance = step(p, modes, y, h, table, end)
        short = fresh >= 0 and signal(p, modes, end, 2 * fresh)[0] <= 0.0
        if distance <= ACCURACY and not short:
            break
        h *= 0.5
        if h < SHORTEST:
            return h, h, -1, False
    first, found, unsure = h, -1, False
    for which in range(4):
        block = which // 2
        if block == fresh:
            continue
        value_0, rate_0 = signal(p, modes, y, which)
        value, rate = signal(p, modes, end, which)
        within = h
        if value_0 < CLOSE:
            unsure = True
        if value > 0.0:
            if rate_0 >= 0.0 or rate <= 0.0:
                continue
            within = minimum(p, modes, y, h, which, table, trial)
            value = signal(p, modes, trial, which)[0]
            if abs(value) < CLOSE:
                unsure = True
            if value > 0.0:
                continue
        t = root(p, modes, y, within, which, table, trial)
        if found >= 0 and abs(t - first) < CLOSE:
            unsure = True
        if found < 0 or t < first:
            first, found = t, which
    if found >= 0:
        step(p, modes, y, first, table, end)
    longer = min(LONGEST, 1.5 * h if distance < 0.01 * ACCURACY else h)
    return first, longer, found, not unsure


@kernel
def carry(p, d, max_events, table, y, end, trial, modes):
    """(value, duration, events, how it ended) of the motion from the global stick phase `d`."""
    onset = min(1.0 + p.alpha * d, p.beta - (1.0 + p.alpha) * d)
    y[0], y[1], y[2], y[3] = onset, onset + d, p.V, p.V
    fresh = 0 if 1.0 + p.alpha * d < p.beta - (1.0 + p.alpha) * d else 1
    modes[0], modes[1] = 0, 0
    modes[fresh] = -1
    time = waited = 0.0
    events, h = 0, LONGEST
    while events < max_events and waited < ENDLESS_AFTER:
        t, h, which, sure = next_state(p, modes, y, fresh, h, table, end, trial)
        if not sure:
            return math.nan, time, events, UNSURE
        fresh = -1
        time += t
        waited += t
        for i in range(4):
            y[i] = end[i]
        if which < 0:
            continue
        waited = 0.0
        events += 1
        block = which // 2
        limit = 1.0 if block == 0 else p.beta
        force = need(p, y, block)
        y[2 + block] = p.V
        if modes[block] == 0:
            modes[block] = 1 if which % 2 else -1
            fresh = block
        elif abs(abs(force) - limit) < CLOSE:
            return math.nan, time, events, UNSURE
        elif abs(force) < limit:
            modes[block] = 0
            if modes[1 - block] == 0:
                return y[1] - y[0], time, events, RETURNED
        else:
            modes[block] = -1 if force > 0.0 else 1
            fresh = block
    return math.nan, time, events, ENDLESS


@kernel
def carry_all(p, d, max_events, value, ending):
    """Carry every start."""
    table, y, end, trial = np.empty((ROWS, 4)), np.empty(4), np.empty(4), np.empty(4)
    modes = np.zeros(2, dtype=np.int64)
    for i in range(d.size):
        value[i], _, _, ending[i] = carry(p, d[i], max_events, table, y, end, trial, modes)


def values(plant: Plant, d: np.ndarray, max_events: int) -> tuple[np.ndarray, np.ndarray]:
    """Value of each start, NaN where there is none, and how its motion ended."""
    value, ending = np.empty(d.size), np.empty(d.size, dtype=np.int64)
    carry_all(plant, d, max_events, value, ending)
    return value, ending
