"""Steps, events and changes of mode of `dormand.py`, compiled."""

import math

import numpy as np
from scipy.integrate._ivp import dop853_coefficients as dop853

from stickslip.numerics.targets import kernel

ENDED, LOST, ARRIVED, UNSURE, NO_MODES, MANY = range(6)

STAGES = dop853.N_STAGES
A, B, C = (np.ascontiguousarray(x[:STAGES]) for x in (dop853.A, dop853.B, dop853.C))
E3, E5 = dop853.E3[:STAGES].copy(), dop853.E5[:STAGES].copy()
LONGEST = 0.05
FIRST = 0.01  # step after an event
SHORTEST = 1e-9
ACCURACY = 1e-14  # of the estimate of order five, far above the error itself
CLOSE = 1e-6  # a bound on a minimum that is no reason to look closer
AT_REST = 1e-14  # relative velocity after the search for zero, force beside a limit
BEGUN = 1e-12  # a signal that an event has left at zero, unless it falls
FROM_ROUNDING = 1e-14  # a spring whose body rests stays at its limit
SAME_TIME = 1e-7
SHARE = 1e-13  # of a limit
UNABLE = 1e-9  # accelerations, relative, that sticking contacts cannot have
GROWTH = 1e-11  # of a slip that begins: its acceleration
COULOMB, POPP_STELTER, STRIBECK = range(3)
MOST_EVENTS = 400
NO_MODE = 2


@kernel
def law(kind, c, s):
    """F(s) and its slope; below zero, where trial steps go, its tangent."""
    over = min(s, 0.0)
    s = max(s, 0.0)
    if kind == COULOMB:
        value, slope = c[0] + c[1] * s, c[1]
    elif kind == POPP_STELTER:
        below = 1.0 + c[0] * s
        value = (1.0 - c[1]) / below + c[1] + c[2] * s * s
        slope = -(1.0 - c[1]) * c[0] / (below * below) + 2.0 * c[2] * s
    else:
        z = s / c[1]
        if c[3] == 1.0:
            part = (1.0 - c[0]) * math.exp(-z)
            value, slope = c[0] + part + c[2] * s, -part / c[1] + c[2]
        else:
            part = (1.0 - c[0]) * math.exp(-z * z)
            value, slope = c[0] + part + c[2] * s, -2.0 * z * part / c[1] + c[2]
    return value + slope * over, slope


@kernel
def belt(waves, k, t):
    """Velocity of what contact k rubs on, and its first two rates."""
    angle = waves.frequency[k] * t + waves.phase[k]
    size, turn = waves.size[k], waves.frequency[k]
    c, s = size * math.cos(angle), size * math.sin(angle)
    return waves.mean[k] + c, -turn * s, -turn * turn * c


@kernel
def dot(a, b):
    """Of two vectors, the second perhaps longer."""
    total = 0.0
    for i in range(len(a)):
        total += a[i] * b[i]
    return total


@kernel
def assign(modes, others):
    """Put modes in the place of others."""
    for k in range(len(others)):
        modes[k] = others[k]


@kernel
def stuck_set(mode):
    """Number of the set of contacts that stick."""
    mask = 0
    for k in range(len(mode)):
        if mode[k] == 0:
            mask |= 1 << k
    return mask


@kernel
def foot_rate(p, j, t, v, mode):
    """Rate of a spring's length."""
    if mode == 0:
        return dot(p.reach[j], v) - belt(p.foot_belt, j, t)[0]
    return mode * p.kinetic[j] * dot(p.foot_load[j], v) / p.spring[j]


@kernel
def hold(p, t, order, mode, mask, pull, o):
    """Forces that keep stuck contacts with derivative `order` of their belt, or their rates."""
    for k in range(len(p.b)):
        o.own[k] = 0.0
        if mode[k] == 0:
            right = belt(p.belt, k, t)[order]
            for i in range(len(p.inverse)):
                right -= p.b[k, i] * dot(p.inverse[i], pull)
            o.own[k] = right - dot(p.response[k], o.force)
    for k in range(len(p.b)):
        if mode[k] == 0:
            o.force[k] = dot(p.sticking[mask, k], o.own)


@kernel
def friction(p, t, y, mode, o):
    """All forces but friction into `pull`, friction into `force`; by how much stuck ones slip."""
    n, m, r = len(p.inverse), len(p.b), len(p.reach)
    q, v = y[:n], y[n : 2 * n]
    for i in range(n):
        o.pull[i] = p.force[i] - dot(p.stiffness[i], q) - dot(p.damping[i], v)
    for h in range(len(p.frequency)):
        c = math.cos(p.frequency[h] * t + p.phase[h])
        for i in range(n):
            o.pull[i] += p.amplitude[h, i] * c
    for j in range(r):
        for i in range(n):
            o.pull[i] -= p.reach[j, i] * p.spring[j] * y[2 * n + j]
    for k in range(m):
        o.force[k] = 0.0
        if mode[k] != 0:
            s = mode[k] * (dot(p.b[k], v) - belt(p.belt, k, t)[0])
            limit = p.static[k] + dot(p.load[k], q)
            o.force[k] = -mode[k] * limit * law(p.law[k], p.numbers[k], s)[0]
    mask = stuck_set(mode)
    if mask == 0:
        return 0.0
    hold(p, t, 1, mode, mask, o.pull, o)
    off = 0.0
    for k in range(m):
        if mode[k] == 0:
            total = o.own[k]
            for i in range(m):
                if mode[i] == 0:
                    total -= p.response[k, i] * o.force[i]
            off = max(off, abs(total) / (1.0 + abs(o.own[k])))
    return off


@kernel
def flow(p, t, y, mode, foot, o, out):
    """Rate of change of (q, v, lengths)."""
    n, m = len(p.inverse), len(p.b)
    friction(p, t, y, mode, o)
    for k in range(m):
        for i in range(n):
            o.pull[i] += p.b[k, i] * o.force[k]
    for i in range(n):
        out[i] = y[n + i]
        out[n + i] = dot(p.inverse[i], o.pull)
    v = y[n : 2 * n]
    for j in range(len(foot)):
        out[2 * n + j] = foot_rate(p, j, t, v, foot[j])


@kernel
def step(p, t, y, h, mode, foot, o, end):
    """Put what a time h adds to y into `end`; return the estimate of the error."""
    size = len(y)
    for s in range(STAGES):
        for i in range(size):
            total = 0.0
            for k in range(s):
                total += A[s, k] * o.stages[k, i]
            end[i] = y[i] + h * total
        flow(p, t + C[s] * h, end, mode, foot, o, o.stages[s])
    error = 0.0
    for i in range(size):
        five = three = total = 0.0
        for s in range(STAGES):
            five += E5[s] * o.stages[s, i]
            three += E3[s] * o.stages[s, i]
            total += B[s] * o.stages[s, i]
        both = five * five + 0.01 * three * three
        if both > 0.0:
            error = max(error, h * five * five / math.sqrt(both) / (1.0 + abs(y[i])))
        end[i] = h * total
    return error


@kernel
def state_after(p, t, y, h, mode, foot, o, end):
    """Put the state a time h after y into `end`."""
    step(p, t, y, h, mode, foot, o, end)
    for i in range(len(y)):
        end[i] += y[i]


@kernel
def signals(p, t, y, mode, foot, o, value, rate):
    """Put what stays positive while modes last, and its rates; return how many there are."""
    n, m, r = len(p.inverse), len(p.b), len(p.reach)
    q, v = y[:n], y[n : 2 * n]
    last = o.stages[STAGES - 1]
    flow(p, t, y, mode, foot, o, last)
    a = last[n : 2 * n]
    found = 0
    mask = stuck_set(mode)
    for k in range(m):
        speed, turn, _ = belt(p.belt, k, t)
        value[found] = p.static[k] + dot(p.load[k], q)
        rate[found] = dot(p.load[k], v)
        found += 1
        if mode[k] != 0:
            value[found] = mode[k] * (dot(p.b[k], v) - speed)
            rate[found] = mode[k] * (dot(p.b[k], a) - turn)
            found += 1
    for j in range(r):
        most, grows = p.foot_static[j] + dot(p.foot_load[j], q), dot(p.foot_load[j], v)
        value[found], rate[found] = most, grows
        found += 1
        if foot[j] == 0:
            for side in (-1, 1):
                value[found] = most + FROM_ROUNDING - side * p.spring[j] * y[2 * n + j]
                rate[found] = grows - side * p.spring[j] * last[2 * n + j]
                found += 1
        else:
            value[found] = foot[j] * (foot_rate(p, j, t, v, 0) - foot_rate(p, j, t, v, foot[j]))
            turn = belt(p.foot_belt, j, t)[1]
            pushed = p.kinetic[j] * dot(p.foot_load[j], a) / p.spring[j]
            rate[found] = foot[j] * (dot(p.reach[j], a) - turn) - pushed
            found += 1
    if mask == 0:
        return found
    for i in range(n):
        o.pulled[i] = -dot(p.stiffness[i], v) - dot(p.damping[i], a)
    for h in range(len(p.frequency)):
        s = -p.frequency[h] * math.sin(p.frequency[h] * t + p.phase[h])
        for i in range(n):
            o.pulled[i] += p.amplitude[h, i] * s
    for j in range(r):
        for i in range(n):
            o.pulled[i] -= p.reach[j, i] * p.spring[j] * last[2 * n + j]
    first, stop = p.first[mask], p.first[mask + 1]
    for g in range(first, stop):
        u = p.mechanism[g]
        most = grows = power = 0.0
        for k in range(m):
            if u[k] != 0.0:
                most += abs(u[k]) * (p.static[k] + dot(p.load[k], q))
                grows += abs(u[k]) * dot(p.load[k], v)
                power += u[k] * o.force[k]
        for side in (-1, 1):
            place = found + (g - first) * 2 + (side + 1) // 2
            value[place], rate[place] = most - side * power, grows
    # Rates of friction in the place of friction.
    for k in range(m):
        o.force[k] = 0.0
        if mode[k] != 0:
            speed, turn, _ = belt(p.belt, k, t)
            s, pace = mode[k] * (dot(p.b[k], v) - speed), mode[k] * (dot(p.b[k], a) - turn)
            F, slope = law(p.law[k], p.numbers[k], s)
            limit, grows = p.static[k] + dot(p.load[k], q), dot(p.load[k], v)
            o.force[k] = -mode[k] * (grows * F + limit * slope * pace)
    hold(p, t, 2, mode, mask, o.pulled, o)
    for g in range(first, stop):
        power = 0.0
        for k in range(m):
            if mode[k] == 0:
                power += p.mechanism[g, k] * o.force[k]
        for side in (-1, 1):
            rate[found + (g - first) * 2 + (side + 1) // 2] -= side * power
    return found + 2 * (stop - first)


@kernel
def overload(p, t, y, mode, o):
    """Largest share of a limit that sticking contacts need; infinite if they cannot all stick."""
    m, n = len(p.b), len(p.inverse)
    off = friction(p, t, y, mode, o)
    mask = stuck_set(mode)
    share = 0.0
    for g in range(p.first[mask], p.first[mask + 1]):
        power = most = 0.0
        for k in range(m):
            u = p.mechanism[g, k]
            power += u * o.force[k]
            most += abs(u) * (p.static[k] + dot(p.load[k], y[:n]))
        share = max(share, abs(power) / most)
    return np.inf if off > UNABLE else share


@kernel
def overloaded(p, t, y, mode, o, least):
    """Set of contacts in mechanisms that need this share of their limits."""
    m, n = len(p.b), len(p.inverse)
    friction(p, t, y, mode, o)
    mask, found = stuck_set(mode), 0
    for g in range(p.first[mask], p.first[mask + 1]):
        power = most = 0.0
        which = 0
        for k in range(m):
            u = p.mechanism[g, k]
            power += u * o.force[k]
            most += abs(u) * (p.static[k] + dot(p.load[k], y[:n]))
            which |= (u != 0.0) << k
        if abs(power) / most > least:
            found |= which
    return found


@kernel
def settle(p, t, y, resting, o):
    """Choose modes of contacts at rest into `chosen`: (how many ways, margin); `wanted` if able."""
    m, n = len(p.b), len(p.inverse)
    leaving = 0
    share = overload(p, t, y, o.mode, o)
    if share > 1.0 - SHARE and share < np.inf:
        leaving = overloaded(p, t, y, o.mode, o, share - SHARE)
    ways, fewest, margin, taken = 0, m + 1, np.inf, False
    for way in range(3**m):
        rest, able, slips = way, True, 0
        for k in range(m):
            trit = rest % 3
            rest //= 3
            if resting >> k & 1:
                o.tried[k] = 0 if trit == 0 else (-1 if trit == 1 else 1)
                slips += trit != 0
                able &= not (o.tried[k] == 0 and leaving >> k & 1)
            else:
                o.tried[k] = o.mode[k]
                able &= trit == 0
        if not able:
            continue
        share = overload(p, t, y, o.tried, o)
        spare = 1.0 - share
        out = o.stages[0]
        for k in range(m):
            for i in range(n):
                o.pull[i] += p.b[k, i] * o.force[k]
        for i in range(n):
            out[i] = dot(p.inverse[i], o.pull)
        able = spare > SHARE
        for k in range(m):
            if resting >> k & 1 and o.tried[k] != 0:
                grows = o.tried[k] * (dot(p.b[k], out) - belt(p.belt, k, t)[1])
                if leaving >> k & 1:
                    able &= grows > -GROWTH
                else:
                    able &= grows > GROWTH
                    spare = min(spare, abs(grows))
        if share > 0.0 or slips > 0:
            margin = min(margin, abs(spare))
        if not able:
            continue
        ways += 1
        same = True
        for k in range(m):
            same &= o.tried[k] == o.wanted[k]
        if same or (slips < fewest and not taken):
            taken = same
            fewest = slips
            assign(o.chosen, o.tried)
    return ways, margin


@kernel
def lowest(p, t, y, h, mode, foot, which, o):
    """Time in (0, h) at which a signal that falls, then rises, is least."""
    low, high = 0.0, h
    for _ in range(40):
        if high - low < 1e-7 * h:
            break
        s = 0.5 * (low + high)
        state_after(p, t, y, s, mode, foot, o, o.trial)
        signals(p, t + s, o.trial, mode, foot, o, o.value_end, o.rate_end)
        if o.rate_end[which] < 0.0:
            low = s
        else:
            high = s
    return high


@kernel
def root(p, t, y, h, mode, foot, which, o):
    """Time in (0, h] at which a signal that ends below zero crosses."""
    low, high, s = 0.0, h, 0.5 * h
    for _ in range(100):
        state_after(p, t, y, s, mode, foot, o, o.trial)
        signals(p, t + s, o.trial, mode, foot, o, o.value_end, o.rate_end)
        value, rate = o.value_end[which], o.rate_end[which]
        if value > 0.0:
            low = s
        else:
            high = s
        move = -value / rate if rate < 0.0 else np.inf
        if abs(move) < 1e-16:
            break
        new = s + move
        if not low < new < high:
            new = 0.5 * (low + high)
        if new in (s, low, high):
            break
        s = new
    return s


@kernel
def has_begun(o, g):
    """Whether a signal begins at zero: a slip that an event finds nearly at rest falls on."""
    return o.value[g] < BEGUN and not (o.value[g] > 0.0 and o.value_rate[g] < -FROM_ROUNDING)


@kernel
def advance(p, t, h, fresh, o):
    """One step into `end`: (length, what to try next, pace of the event or 0, margin, sure)."""
    y, mode, foot = o.y, o.mode, o.foot
    count = signals(p, t, y, mode, foot, o, o.value, o.value_rate)
    while True:
        error = step(p, t, y, h, mode, foot, o, o.end)
        good = error <= ACCURACY
        if good:
            for i in range(len(y)):
                o.trial[i] = y[i] + o.end[i]
            signals(p, t + h, o.trial, mode, foot, o, o.value_end, o.rate_end)
            if fresh:  # what begins at zero must have grown
                for g in range(count):
                    if has_begun(o, g):
                        good &= o.value_end[g] > 0.0 and o.rate_end[g] > -FROM_ROUNDING
        if good or h < SHORTEST:
            break
        h *= 0.5
    grow = 0.9 * (ACCURACY / max(error, 1e-30)) ** 0.125
    longer = min(LONGEST, h * min(max(grow, 0.3), 2.0))
    first, pace, margin, sure = np.inf, 0.0, np.inf, good
    # Candidates first: the search for roots uses the same arrays.
    candidates = 0
    for g in range(count):
        if o.value_end[g] <= 0.0:
            candidates |= 1 << g
        elif o.value_rate[g] < 0.0 < o.rate_end[g] and not (fresh and has_begun(o, g)):
            at = (o.value[g] - o.value_end[g] + o.rate_end[g] * h) / (
                o.rate_end[g] - o.value_rate[g]
            )
            if o.value[g] + o.value_rate[g] * at < CLOSE:
                candidates |= 1 << g
    for g in range(count):
        if not candidates >> g & 1:
            continue
        within = h
        signals(p, t + h, o.trial, mode, foot, o, o.value_end, o.rate_end)
        for i in range(len(y)):
            o.trial[i] = y[i] + o.end[i]
        signals(p, t + h, o.trial, mode, foot, o, o.value_end, o.rate_end)
        if o.value_end[g] > 0.0:
            within = lowest(p, t, y, h, mode, foot, g, o)
            state_after(p, t, y, within, mode, foot, o, o.trial)
            signals(p, t + within, o.trial, mode, foot, o, o.value_end, o.rate_end)
            margin = min(margin, abs(o.value_end[g]))
            if o.value_end[g] > 0.0:
                continue
        s = root(p, t, y, within, mode, foot, g, o)
        if first < np.inf:
            margin = min(margin, abs(s - first))
        if s < first:
            first, pace = s, abs(o.rate_end[g])
    if first < np.inf:
        step(p, t, y, first, mode, foot, o, o.end)
        return first, FIRST, max(pace, 1e-300), margin, sure
    return h, longer, 0.0, margin, sure


@kernel
def change_feet(p, t, o):
    """New modes of elastic contacts at an event; a foot that breaks away jumps. Whether one did."""
    n = len(p.inverse)
    q, v = o.y[:n], o.y[n : 2 * n]
    changed = False
    for j in range(len(o.foot)):
        force, most = p.spring[j] * o.y[2 * n + j], p.foot_static[j] + dot(p.foot_load[j], q)
        pace = foot_rate(p, j, t, v, 0)
        side = 1 if force > 0.0 else -1
        if o.foot[j] == 0:
            grows = side * p.spring[j] * pace - dot(p.foot_load[j], v)
            if abs(force) > most - AT_REST and grows > AT_REST:
                o.foot[j] = side
                o.y[2 * n + j] = side * p.kinetic[j] * most / p.spring[j]
                o.lost[2 * n + j] = 0.0
                changed = True
        elif o.foot[j] * (pace - foot_rate(p, j, t, v, o.foot[j])) < AT_REST:
            o.foot[j] = 0
            changed = True
    return changed


@kernel
def follow(p, t, t_end, until, choices, chosen_modes, noise, o):
    """From `y` and `mode` until `t_end`, or all contacts stick, or a contact is in new modes.

    `until`: (0, ...) to the end; (1, ...) all stick; (2, contact, before, after) a change of mode,
    `after` 2 for any. `noise` is added to positions at each event, to see what becomes of it.
    Returns (ending, t, number of changes, margin).
    """
    n, m, r = len(p.inverse), len(p.b), len(p.reach)
    events, margin, h, fresh, closest = 0, np.inf, FIRST, t < t_end, np.inf
    drawn, missing = 1, 0.0  # `missing`: what rounding took from t
    while t < t_end:
        last = t_end - t <= h
        if last:
            h = t_end - t
        took, h, pace, least, sure = advance(p, t, h, fresh, o)
        hit = pace > 0.0
        margin = min(margin, least)
        if not sure:
            return UNSURE, t, events, margin
        fresh = hit
        for i in range(len(o.y)):
            add = o.end[i] - o.lost[i]
            new = o.y[i] + add
            o.lost[i] = (new - o.y[i]) - add
            o.y[i] = new
        missing = took - missing
        later = t + missing
        t, missing = later, (later - t) - missing
        closest += took
        if not hit:
            continue
        margin = min(margin, closest)
        closest = 0.0
        if events + m + r > MOST_EVENTS:
            return MANY, t, events, margin
        for k in range(m):
            if p.static[k] + dot(p.load[k], o.y[:n]) < AT_REST:
                return LOST, t, events, margin
        for j in range(r):
            if p.foot_static[j] + dot(p.foot_load[j], o.y[:n]) < AT_REST:
                return LOST, t, events, margin
        resting = 0 * m
        for k in range(m):
            o.before[k] = o.mode[k]
            slip = dot(p.b[k], o.y[n : 2 * n]) - belt(p.belt, k, t)[0]
            if o.mode[k] == 0 or abs(slip) < AT_REST:
                resting |= 1 << k
        feet = stuck_set(o.foot)
        pushed = 0
        for j in range(r):
            pushed |= (o.foot[j] == 1) << j
        change_feet(p, t, o)
        if m > 0:
            for k in range(m):
                o.chosen[k] = o.mode[k]
            nearest = t + SAME_TIME
            for e in range(len(choices)):
                if abs(choices[e] - t) < abs(nearest - t):
                    nearest = choices[e]
            for e in range(len(choices)):
                if choices[e] == nearest and chosen_modes[e, 0] < m:
                    o.chosen[chosen_modes[e, 0]] = chosen_modes[e, 1]
            assign(o.wanted, o.chosen)
            ways, least = settle(p, t, o.y, resting, o)
            margin = min(margin, least)
            if ways == 0:
                return NO_MODES, t, events, margin
            assign(o.mode, o.chosen)
        for i in range(m + r):
            o.paces[events + i] = pace
        for k in range(m):
            if o.mode[k] != o.before[k]:
                o.times[events], o.changes[events, 0], o.changes[events, 1] = t, k, o.mode[k]
                events += 1
        for j in range(r):
            was = 0 if feet >> j & 1 else (1 if pushed >> j & 1 else -1)
            if o.foot[j] != was:
                o.times[events], o.changes[events, 0] = t, m + j
                o.changes[events, 1] = o.foot[j]
                events += 1
        for i in range(n):
            drawn = 16807 * drawn % 2147483647
            o.y[i] += noise if drawn & 4096 else -noise
        if until[0] == 1 and stuck_set(o.mode) == (1 << m) - 1:
            return ARRIVED, t, events, margin
        if until[0] == 2:
            k = until[1]
            if o.before[k] == until[2] and o.mode[k] != until[2]:
                if until[3] == 2 or o.mode[k] == until[3]:
                    return ARRIVED, t, events, margin
    return ENDED, t, events, margin


@kernel
def begin(p, t, o):
    """Modes of a state: signs of slip, and of what rests what is consistent. How many ways."""
    n, m = len(p.inverse), len(p.b)
    resting = 0 * m  # no literal, for which a function is compiled of its own
    for k in range(m):
        slip = dot(p.b[k], o.y[n : 2 * n]) - belt(p.belt, k, t)[0]
        o.mode[k] = 0 if abs(slip) < 1e-14 else (1 if slip > 0.0 else -1)
        if o.mode[k] == 0:
            resting |= 1 << k
        if p.static[k] + dot(p.load[k], o.y[:n]) <= 0.0:
            return -1
    for j in range(len(o.foot)):
        if p.foot_static[j] + dot(p.foot_load[j], o.y[:n]) <= 0.0:
            return -1
        o.foot[j] = 0
    if m == 0:
        return 1
    for k in range(m):
        o.wanted[k] = NO_MODE
    ways, _ = settle(p, t, o.y, resting, o)
    if ways > 0:
        assign(o.mode, o.chosen)
    return ways
