"""What every reference motion must satisfy, whatever made it: used to test the oracles."""

from __future__ import annotations

import numpy as np
from flint import arb
from scipy.integrate import solve_ivp

from .motion import Motion, System, need


def friction(system: System, block: int, x: tuple, v: tuple, mode: int) -> arb:
    """Force of the belt on a block: kinetic when it slips, what it needs when it rides."""
    pull = need(system, block, x, v)
    return system.acceleration(block, x, v, mode) + pull if mode else pull


def worst_violation(system: System, motion: Motion, points: int = 60) -> float:
    """Largest breach of eq. (6a) by a rider, or of its direction by a slipper, inside phases."""
    worst = arb("-inf")
    for phase, length in motion.phases:
        for share in range(1, points):
            x, v = phase.state(length * share / points)
            for block, mode in enumerate(phase.modes):
                breach = (
                    mode * (system.V - v[block])
                    if mode
                    else abs(need(system, block, x, v)) - system.limits[block]
                )
                worst = worst.max(breach)
    return float(worst)


def worst_residual(system: System, motion: Motion) -> float:
    """Largest |X'' + X + alpha (X - X_j) - F| (7a) and |X' - V| (5a), X'' by a central difference.

    With a step of 1e-20 and 96 digits the difference is good to 1e-38.
    """
    worst, step = arb(0), arb("1e-20")
    for phase, length in motion.phases:
        for share in (0.1, 0.37, 0.81):
            t = length * share
            (x, v), (_, ahead), (_, back) = (phase.state(t + k * step) for k in (0, 1, -1))
            for block, mode in enumerate(phase.modes):
                found = (ahead[block] - back[block]) / (2 * step)
                wanted = system.acceleration(block, x, v, mode) if mode else arb(0)
                worst = worst.max(abs(found - wanted))
                if not mode:
                    worst = worst.max(abs(v[block] - system.V))
    return float(worst)


def stored(system: System, x: tuple, v: tuple) -> arb:
    """Kinetic energy and energy of the three springs."""
    return (sum(q * q for q in (*x, *v)) + system.alpha * (x[1] - x[0]) ** 2) / 2


def energy_defect(system: System, motion: Motion) -> float:
    """|change of stored energy - work of friction| over the motion, relative to the energy.

    Work by Gauss-Legendre quadrature of F X' over each phase; phases are smooth.
    """
    nodes, weights = np.polynomial.legendre.leggauss(48)
    work = arb(0)
    for phase, length in motion.phases:
        for node, weight in zip(nodes, weights, strict=True):
            x, v = phase.state(length * (1 + float(node)) / 2)
            power = sum(friction(system, i, x, v, m) * v[i] for i, m in enumerate(phase.modes))
            work += power * float(weight) * length / 2
    first, last = motion.events[0], motion.events[-1]
    before, after = stored(system, first.x, first.v), stored(system, last.x, last.v)
    return float(abs(after - before - work) / before)


def by_solve_ivp(system: System, d: float, kinetic, push: float = 0.0) -> tuple[float, str]:
    """The event map once more, in doubles, by scipy with its sign-change events.

    ``kinetic(block, s)``: force of eq. (8) or (9) times the block's limit, s = |X' - V|. Good
    for ordinary motions only; that is why it is a check and not the oracle.
    """
    alpha, V = float(system.alpha), float(system.V)
    limits = [float(limit) for limit in system.limits]
    x1 = min(1 + alpha * d, limits[1] - (1 + alpha) * d)
    state = np.array([x1, x1 + d, V, V])
    modes = [-1 if 1 + alpha * d <= x1 else 0, -1 if limits[1] - (1 + alpha) * d <= x1 else 0]
    marks = [mark(modes)]
    state[2:] += push * np.array(modes)

    def pull(y, i):
        return y[i] + alpha * (y[i] - y[1 - i])

    def right_side(t, y, modes):
        rates = [y[2], y[3], 0.0, 0.0]
        for i, mode in enumerate(modes):
            if mode:
                rates[2 + i] = -mode * kinetic(i, max(0.0, mode * (y[2 + i] - V))) - pull(y, i)
        return rates

    while modes != [0, 0] and len(marks) < 200:
        found = []
        for i, mode in enumerate(modes):
            signals = (
                [lambda t, y, *_, i=i: y[2 + i] - V]
                if mode
                else [lambda t, y, *_, i=i, s=s: limits[i] - s * pull(y, i) for s in (1, -1)]
            )
            for signal in signals:
                signal.terminal, signal.direction = True, -mode if mode else -1
                found.append((i, signal))
        run = solve_ivp(
            right_side, (0, 1e4), state, "DOP853", rtol=1e-12, atol=1e-13, max_step=0.05,
            events=[signal for _, signal in found], args=(list(modes),),
        )  # fmt: skip
        state = run.y[:, -1]
        for (i, _), times in zip(found, run.t_events, strict=True):
            if len(times):
                at_limit = abs(pull(state, i)) >= limits[i] * (1 - 1e-9)
                modes[i] = -int(np.sign(pull(state, i))) if at_limit else 0
                state[2 + i] = V + modes[i] * push
        marks.append(mark(modes))
    return float(state[1] - state[0]), " ".join(marks)


def mark(modes: list[int]) -> str:
    """Two characters."""
    return "".join(".+-"[mode] for mode in modes)
