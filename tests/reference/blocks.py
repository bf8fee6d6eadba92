"""The event map of n blocks in 30 digits: Taylor integration by mpmath, events by sampling.

Written from the equations alone: M X'' + C X' + K X = friction, block i riding while
``|e_i| <= limit_i``, ``e = K X + C X'``. Slow, and blind to events that come and go between two
samples: for motions that are no near-grazing ones.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import mpmath
from mpmath import mp

SAMPLE = 0.02
MAX_EVENTS = 60

Law = Callable[[Any], Any]


def event_map(
    mass: Sequence[float],
    stiffness: Sequence[Sequence[float]],
    damping: Sequence[Sequence[float]],
    static: Sequence[float],
    V: float,
    law: Law,
    d: Sequence[float],
    digits: int = 30,
) -> list[float]:
    """Differences of the next global stick phase after that with differences `d`."""
    with mp.workdps(digits):
        motion = _Motion(mass, stiffness, damping, static, V, law)
        motion.leave_belt([mpmath.mpf(value) for value in d])
        for _ in range(MAX_EVENTS):
            motion.next_event()
            if not any(motion.mode):
                x = motion.x
                return [float(b - a) for a, b in itertools.pairwise(x)]
    raise ArithmeticError("no return")


class _Motion:
    def __init__(
        self, mass: Any, stiffness: Any, damping: Any, static: Any, V: float, law: Law
    ) -> None:
        self.mass = [mpmath.mpf(m) for m in mass]
        self.K = [[mpmath.mpf(k) for k in row] for row in stiffness]
        self.C = [[mpmath.mpf(c) for c in row] for row in damping]
        self.static = [mpmath.mpf(s) for s in static]
        self.V, self.law, self.n = mpmath.mpf(V), law, len(mass)
        self.x = [mpmath.mpf(0)] * self.n
        self.v = [self.V] * self.n
        self.mode = [0] * self.n

    def needed(self, x: Any, v: Any) -> list[Any]:
        return [
            sum(self.K[i][j] * x[j] + self.C[i][j] * v[j] for j in range(self.n))
            for i in range(self.n)
        ]

    def leave_belt(self, d: Any) -> None:
        x = [mpmath.mpf(0)]
        for step in d:
            x.append(x[-1] + step)
        e = self.needed(x, self.v)
        shifts = [(self.static[i] - e[i]) / sum(self.K[i]) for i in range(self.n)]
        first = min(range(self.n), key=lambda i: shifts[i])
        self.x = [value + shifts[first] for value in x]
        self.mode[first] = -1

    def rates(self, _: Any, y: Any) -> list[Any]:
        x, v = y[: self.n], y[self.n :]
        e = self.needed(x, v)
        out = []
        for i, mode in enumerate(self.mode):
            if mode == 0:
                out.append(mpmath.mpf(0))
            else:
                friction = -mode * self.static[i] * self.law(mode * (v[i] - self.V))
                out.append((friction - e[i]) / self.mass[i])
        return list(v) + out

    def signals(self, y: Any) -> list[Any]:
        """Positive before the event of each block, a rider's two limits in one."""
        x, v = y[: self.n], y[self.n :]
        e = self.needed(x, v)
        return [
            mode * (v[i] - self.V) if mode else self.static[i] - abs(e[i])
            for i, mode in enumerate(self.mode)
        ]

    def next_event(self) -> None:
        flow = mpmath.odefun(self.rates, 0, list(self.x) + list(self.v))
        t = mpmath.mpf(0)
        started = [False] * self.n
        while True:
            t += SAMPLE
            values = self.signals(flow(t))
            hit = [i for i in range(self.n) if values[i] < 0 and started[i]]
            started = [started[i] or values[i] > 0 for i in range(self.n)]
            if hit:
                break
        times = {i: self.root(flow, i, t - SAMPLE, t) for i in hit}
        block = min(times, key=lambda i: times[i])
        y = flow(times[block])
        self.x, self.v = list(y[: self.n]), list(y[self.n :])
        self.v[block] = self.V
        e = self.needed(self.x, self.v)
        if self.mode[block] == 0:
            self.mode[block] = -1 if e[block] > 0 else 1
        elif abs(e[block]) <= self.static[block]:
            self.mode[block] = 0
        else:
            self.mode[block] = -1 if e[block] > 0 else 1

    def root(self, flow: Any, block: int, low: Any, high: Any) -> Any:
        return mpmath.findroot(
            lambda t: self.signals(flow(t))[block], (low, high), solver="anderson", verify=False
        )
