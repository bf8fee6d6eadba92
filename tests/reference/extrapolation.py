"""Law (9) in doubles by a stepper of another kind than the package's, for samples of ten million.

Positions and velocities, the midpoint rule extrapolated to order 12 (Gragg, Bulirsch and Stoer),
and events by looking at both ends of a step and at minima between them; the time of an event by
taking the step anew. Nothing is expanded in a series and no bound is used. It proves nothing: two
contacts within one step of a quarter could be missed, and a motion whose state comes back within
1e-10 is taken to be in a cycle. Where it is not sure of a decision it says so, and where it and the
package differ the oracle of `law9.py` decides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

RETURNED, ENDLESS, UNSURE = 0, 1, 2

ROWS = 6  # the midpoint rule with 2, 4, .. 12 substeps
LONGEST = 0.25
SHORTEST = 1e-6
ACCURACY = 3e-15  # of the extrapolation before the last one: two orders less
CLOSE = 1e-9  # decisions closer than this are left to others
NEWTON = 1e-10  # a step of Newton's so short leaves less than rounding
ENDLESS_AFTER = 100.0  # without an event
LAP = 32  # events between the states that a cycle is told by
RECURS = 1e-10  # a state so close to an earlier one is on a cycle

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
def accelerations(p, modes, x_1, x_2, v_1, v_2):
    """X'' of both blocks (5a, 7a); zero of a rider. Products instead of branches are quicker."""
    m_1, m_2 = modes
    stretch = p.alpha * (x_1 - x_2)
    friction_1 = -m_1 * law(p, m_1 * (v_1 - p.V))
    friction_2 = -m_2 * law(p, m_2 * (v_2 - p.V)) * p.beta
    return friction_1 - m_1 * m_1 * (x_1 + stretch), friction_2 - m_2 * m_2 * (x_2 - stretch)


@kernel
def midpoint(p, modes, y, h, n):
    """What a time h adds to `y` by Gragg's rule with n substeps."""
    x_1, x_2, v_1, v_2 = y[0], y[1], y[2], y[3]
    h /= n
    a_1, a_2 = accelerations(p, modes, x_1, x_2, v_1, v_2)
    old = 0.0, 0.0, 0.0, 0.0  # increments, for the sake of rounding
    now = h * v_1, h * v_2, h * a_1, h * a_2
    for k in range(1, n + 1):
        u_1, u_2 = v_1 + now[2], v_2 + now[3]
        a_1, a_2 = accelerations(p, modes, x_1 + now[0], x_2 + now[1], u_1, u_2)
        if k == n:
            break
        new = old[0] + 2 * h * u_1, old[1] + 2 * h * u_2, old[2] + 2 * h * a_1, old[3] + 2 * h * a_2
        old, now = now, new
    return (
        0.5 * (old[0] + now[0] + h * u_1),
        0.5 * (old[1] + now[1] + h * u_2),
        0.5 * (old[2] + now[2] + h * a_1),
        0.5 * (old[3] + now[3] + h * a_2),
    )


@kernel
def step(p, modes, y, h, table, end):
    """Put the state a time h after `y` into `end`; return the distance of the last two results."""
    signs = float(modes[0]), float(modes[1])
    distance = 0.0
    for row in range(ROWS):
        added = midpoint(p, signs, y, h, 2 * (row + 1))
        for i in range(4):
            table[row, i] = added[i]
        distance = 0.0
        for k in range(row - 1, -1, -1):
            ratio = (row + 1) / (k + 1)
            share = 1.0 / (ratio * ratio - 1.0)
            for i in range(4):
                change = (table[k + 1, i] - table[k, i]) * share
                table[k, i] = table[k + 1, i] + change
                if k == 0:
                    distance = max(distance, abs(change))
    for i in range(4):
        end[i] = y[i] + table[0, i]
    return distance


@kernel
def next_length(h, distance):
    """The length for which a step's error would be as allowed, not much longer than the last."""
    grow = 0.9 * (ACCURACY / max(distance, 1e-30)) ** (1.0 / (2 * ROWS - 1))
    return min(LONGEST, h * min(grow, 2.0))


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
        rate = accelerations(p, (float(modes[0]), float(modes[1])), y[0], y[1], y[2], y[3])[block]
        return mode * (y[2 + block] - p.V), mode * rate
    side = -1.0 if second else 1.0
    limit = 1.0 if block == 0 else p.beta
    rate = y[2 + block] + p.alpha * (y[2 + block] - y[3 - block])
    return limit - side * need(p, y, block), -side * rate


@kernel
def tangents_meet(value_0, rate_0, value, rate, h):
    """Height at which the tangents in both ends meet, below a convex signal."""
    t = (value_0 - value + rate * h) / (rate - rate_0)
    return value_0 + rate_0 * t


@kernel
def minimum(p, modes, y, h, which, table, end):
    """Time in (0, h) at which a signal that falls, then rises, is least; leaves its state."""
    low, high = 0.0, h
    while high - low > 1e-6 * h:
        t = 0.5 * (low + high)
        step(p, modes, y, t, table, end)
        if signal(p, modes, end, which)[1] < 0.0:
            low = t
        else:
            high = t
    step(p, modes, y, high, table, end)
    return high


@kernel
def cubic_root(value_0, rate_0, value, rate, h):
    """Where the cubic with these ends on [0, h], the last one below zero, crosses, about."""
    low, high = 0.0, 1.0
    for _ in range(20):
        s = 0.5 * (low + high)
        r = 1.0 - s
        left = value_0 * (1.0 + 2.0 * s) + rate_0 * h * s
        right = value * (1.0 + 2.0 * r) - rate * h * r
        if left * r * r + right * s * s > 0.0:
            low = s
        else:
            high = s
    return high * h


@kernel
def root(p, modes, y, h, which, guess, table, end):
    """Time in (0, h] at which a signal that ends below zero crosses."""
    low, high, t = 0.0, h, guess
    for _ in range(80):
        step(p, modes, y, t, table, end)
        value, rate = signal(p, modes, end, which)
        if value > 0.0:
            low = t
        else:
            high = t
        move = -value / rate if rate < 0.0 else math.inf
        if abs(move) < NEWTON:
            return t + move
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
        h = min(0.5 * h, next_length(h, distance))
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
            if tangents_meet(value_0, rate_0, value, rate, h) > CLOSE:
                continue
            within = minimum(p, modes, y, h, which, table, trial)
            value, rate = signal(p, modes, trial, which)
            if abs(value) < CLOSE:
                unsure = True
            if value > 0.0:
                continue
        guess = cubic_root(value_0, rate_0, value, rate, within)
        t = root(p, modes, y, within, which, guess, table, trial)
        if found >= 0 and abs(t - first) < CLOSE:
            unsure = True
        if found < 0 or t < first:
            first, found = t, which
    if found >= 0:
        step(p, modes, y, first, table, end)
    return first, next_length(h, distance), found, not unsure


@kernel
def distance_of(a, b):
    """Of two states."""
    return max(abs(a[0] - b[0]), abs(a[1] - b[1]), abs(a[2] - b[2]), abs(a[3] - b[3]))


@kernel
def carry(p, d, max_events, desk):
    """(value, duration, events, how it ended) of the motion from the global stick phase `d`."""
    table, y, end, trial, mark, modes = desk
    onset = min(1.0 + p.alpha * d, p.beta - (1.0 + p.alpha) * d)
    y[0], y[1], y[2], y[3] = onset, onset + d, p.V, p.V
    fresh = 0 if 1.0 + p.alpha * d < p.beta - (1.0 + p.alpha) * d else 1
    modes[0], modes[1] = 0, 0
    modes[fresh] = -1
    time = waited = 0.0
    events, h, marked = 0, LONGEST, -1
    while events < max_events and waited < ENDLESS_AFTER:
        t, h, which, sure = next_state(p, modes, y, fresh, h, table, end, trial)
        if not sure:
            return math.nan, time, events, UNSURE
        fresh = -1
        time += t
        waited += t
        y[:] = end
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
        if which == marked and distance_of(y, mark) < RECURS:
            return math.nan, time, events, ENDLESS
        if events % LAP == 0:
            mark[:], marked = y, which
    return math.nan, time, events, ENDLESS


class Desk(NamedTuple):
    """Where a motion is worked out."""

    table: np.ndarray
    y: np.ndarray
    end: np.ndarray
    trial: np.ndarray
    mark: np.ndarray
    modes: np.ndarray


def new_desk() -> Desk:
    """An empty one."""
    return Desk(np.empty((ROWS, 4)), *np.empty((4, 4)), np.zeros(2, dtype=np.int64))


@kernel
def carry_all(p, d, max_events, desk, value, ending):
    """Carry every start."""
    for i in range(d.size):
        value[i], _, _, ending[i] = carry(p, d[i], max_events, desk)


def values(plant: Plant, d: np.ndarray, max_events: int) -> tuple[np.ndarray, np.ndarray]:
    """Value of each start, NaN where there is none, and how its motion ended."""
    value, ending = np.empty(d.size), np.empty(d.size, dtype=np.int64)
    carry_all(plant, d, max_events, new_desk(), value, ending)
    return value, ending
