"""Least squares with all columns of derivatives beside a search that is given the gradient alone.

``python -m benchmarks.gradient_alone``. What an adjoint would have to make up for: it tells the
gradient of the sum of squares at the price of one column, whatever their number, but no Jacobian.
A record of ten blocks, 1 per cent noise; searches begin 2 per cent off.
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from benchmarks.bench_sensitivity import chain, numbers
from scipy.optimize import least_squares, minimize

import stickslip as ss

T = np.linspace(0.0, 20.0, 200)
NEAR = 1e-3  # of the least sum of squares
REFUSED = 1e3  # residual of what is no model


class Residuals:
    """Residuals and derivatives of the chain's record, and the sums of squares seen so far."""

    def __init__(self, n: int) -> None:
        self.model, self.names = chain(), numbers(chain(), n)
        self.true = np.array([self.model.parameters[name] for name in self.names])
        self.start = np.random.default_rng(2).uniform(-0.3, 0.3, 10), np.zeros(10)
        x = ss.simulate(self.model, *self.start, t_end=T[-1]).x(T)
        self.sigma = 0.01 * float(x.std())
        self.data = x + np.random.default_rng(3).normal(scale=self.sigma, size=x.shape)
        self.last: tuple[bytes, Any] = (b"", None)
        self.sums: list[float] = []

    def at(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Follow one motion with its columns."""
        if self.last[0] != values.tobytes():
            changes = dict(zip(self.names, values.tolist(), strict=True))
            try:
                motion = ss.simulate(self.model.replace(**changes), *self.start, t_end=T[-1])
                off = (motion.x(T) - self.data).ravel() / self.sigma
                slopes = motion.derivative(*self.names).x(T).reshape(off.size, -1) / self.sigma
            except ValueError:  # there is no such model
                off = np.full(self.data.size, REFUSED)
                slopes = np.zeros((off.size, len(values)))
            self.last = values.tobytes(), (off, slopes)
            self.sums.append(float(off @ off))
        found: tuple[np.ndarray, np.ndarray] = self.last[1]
        return found

    def gradient(self, scaled: np.ndarray) -> tuple[float, np.ndarray]:
        """Sum of squares and its gradient, in parameters over their size."""
        off, slopes = self.at(scaled * np.abs(self.true))
        return float(off @ off), 2.0 * (slopes.T @ off) * np.abs(self.true)


def main() -> None:
    """Print how many motions each search follows."""
    for n in (5, 20, 50):
        with_columns, alone = Residuals(n), Residuals(n)
        begin = with_columns.true * (1.0 + np.random.default_rng(4).choice([-0.02, 0.02], size=n))
        begun = time.process_time()
        found = least_squares(
            lambda p, each=with_columns: each.at(p)[0],
            begin,
            lambda p, each=with_columns: each.at(p)[1],
            x_scale="jac",
        )
        spent = time.process_time() - begun
        settings = {"maxiter": 500, "maxfun": 500, "maxcor": 20, "ftol": 1e-12}
        minimize(
            alone.gradient,
            begin / np.abs(alone.true),
            jac=True,
            method="L-BFGS-B",
            options=settings,
        )
        least = 2.0 * found.cost
        needed = [
            int(np.argmax(np.minimum.accumulate(each.sums) < (1.0 + NEAR) * least)) + 1
            if min(each.sums) < (1.0 + NEAR) * least
            else f"not in {len(each.sums)}"
            for each in (with_columns, alone)
        ]
        print(
            f"{n} parameters: within {NEAR:g} of the least after {needed[0]} motions with all "
            f"columns, {needed[1]} with the gradient alone; least squares took {spent:.2f} s",
            flush=True,
        )


if __name__ == "__main__":
    main()
