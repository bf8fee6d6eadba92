"""Steps of the Taylor engine against the same series in 45 digits."""

import math

import mpmath
import numpy as np
import pytest

import stickslip as ss
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.flow.system import AT_UPPER_LIMIT, LANDING, new_motion
from stickslip.mechanics.flow.transitions import onset, settle

ORDER = 45
ROUNDING = 2.0**-53


def series(model, w, e, mode):
    """Taylor coefficients of the state under law (9), in mpmath's precision."""
    alpha, V = mpmath.mpf(model.alpha), mpmath.mpf(model.V)
    gamma, delta, eta = (mpmath.mpf(model.friction.arguments[n]) for n in ("gamma", "delta", "eta"))
    limits = mpmath.mpf(1), mpmath.mpf(model.beta)
    w, e, shares = [[x] for x in w], [[x] for x in e], ([], [])
    for k in range(ORDER):
        for b in (0, 1):
            s = [mode[b] * x for x in w[b]]
            share = mpmath.mpf(k == 0) - gamma * sum(
                s[j] * shares[b][k - j] for j in range(1, k + 1)
            )
            shares[b].append(share / (1 + gamma * s[0]))
            force = (1 - delta) * shares[b][k] + delta * (k == 0)
            force += eta * sum(s[j] * s[k - j] for j in range(k + 1))
            pull = -mode[b] * limits[b] * force - e[b][k] if mode[b] else mpmath.mpf(0)
            w[b].append(pull / (k + 1))
        for b in (0, 1):
            loading = w[b][k] + alpha * (w[b][k] - w[1 - b][k]) + V * (k == 0)
            e[b].append(loading / (k + 1))
    return w, e


def full(high, low):
    return [mpmath.mpf(x) + mpmath.mpf(y) for x, y in zip(high, low, strict=True)]


def value(c, t):
    return sum(x * t**k for k, x in enumerate(c))


def at_event(model, motion, w, e, h):
    """Time of the event that ends a step, about ``h``; ``h`` itself if none does."""
    limits = 1.0, model.beta
    for b in (0, 1):
        if event := motion.event[b]:
            level = 0 if event == LANDING else limits[b] * (1 if event == AT_UPPER_LIMIT else -1)
            signal = (w if event == LANDING else e)[b].copy()
            signal[0] -= mpmath.mpf(level)
            return mpmath.findroot(lambda t, c=signal: value(c, t), h)
    return mpmath.mpf(h)


def step_errors(model, d, most_events):
    """Errors of the state after each step of a motion, and how many steps an event ended."""
    engine = engine_for(model)
    motion, work = new_motion(0, engine.n_law_parameters), engine.new_work()
    errors, ends = [], 0
    onset(engine.system, motion, d)
    while ends < most_events and motion.mode.any():
        before = full(motion.w, motion.w_low), full(motion.e, motion.e_low)
        w, e = series(model, *before, motion.mode)
        h, _ = engine.kernels.advance(engine.system, engine.laws, motion, work, 1e-15, math.inf)
        t = at_event(model, motion, w, e, h)
        after = full(motion.w, motion.w_low), full(motion.e, motion.e_low)
        for b, event in enumerate(motion.event):
            if event != LANDING:  # w is put on 0
                errors.append(float(after[0][b] - value(w[b], t)))
            if event in (0, LANDING):  # else e on its limit
                errors.append(float(after[1][b] - value(e[b], t)))
        if motion.event.any():
            ends += 1
            settle(engine.system, motion)
    return errors, ends


@pytest.mark.parametrize("gamma", [0.4, 3.0])
def test_a_step_errs_by_a_small_share_of_a_rounding(gamma):
    """In doubles alone it would by a third of a rounding, the worst by two."""
    law = ss.PoppStelter(gamma, 0.1, 0.05)
    model = ss.TwoBlock(alpha=1.1, beta=1.4, V=0.1, friction=law)
    with mpmath.workdps(45):
        found = [step_errors(model, d, 5) for d in (-0.3, 0.05, 0.2)]
    errors = np.array([x for some, _ in found for x in some]) / ROUNDING
    assert errors.size > 100
    assert sum(ends for _, ends in found) >= 6
    assert np.sqrt(np.mean(errors**2)) < 0.03
    assert np.abs(errors).max() < 0.2
