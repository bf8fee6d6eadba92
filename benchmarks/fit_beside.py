"""One fit by two ways: exact derivatives, and finite differences of exact motions.

``python -m benchmarks.fit_beside``. An oscillator's record, 600 displacements with 1 per cent
noise, start known; each way begins at the same parameters.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import least_squares

import stickslip as ss

MODEL = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)
NAMES = ("mu", "speed", "damping")
TRUE = np.array([MODEL.parameters[name] for name in NAMES])
T = np.linspace(0.0, 60.0, 600)
NOISE = 0.01

Way = Callable[[np.ndarray, ss.Record], np.ndarray]


def changed(values: np.ndarray) -> Any:
    """Model with other parameters."""
    return MODEL.replace(**dict(zip(NAMES, values.tolist(), strict=True)))


def exact(begin: np.ndarray, record: ss.Record) -> np.ndarray:
    """`stickslip.fit`."""
    return ss.fit(changed(begin), record, NAMES).values


def exact_in_one_piece(begin: np.ndarray, record: ss.Record) -> np.ndarray:
    """`stickslip.fit`, the record as one motion from the beginning."""
    return ss.fit(changed(begin), record, NAMES, pieces=1).values


def differences(begin: np.ndarray, record: ss.Record) -> np.ndarray:
    """SciPy's least squares with its own differences of exact motions."""
    measured, sigma = np.asarray(record.x)[:, 0], record.sigma

    def residuals(values: np.ndarray) -> np.ndarray:
        try:
            motion = ss.simulate(changed(values), [0.0], [0.0], t_end=T[-1])
        except ValueError:
            return np.full(len(T), np.inf)
        return np.asarray((motion.x(T)[:, 0] - measured) / sigma)

    return np.asarray(least_squares(residuals, begin, x_scale=begin, max_nfev=200).x)


def measured(seed: int) -> ss.Record:
    """Make a noisy record from rest."""
    x = ss.simulate(MODEL, [0.0], [0.0], t_end=T[-1]).x(T)[:, 0]
    sigma = NOISE * float(x.std())
    x = x + np.random.default_rng(seed).normal(scale=sigma, size=x.shape)
    return ss.Record(T, x, sigma=sigma, x0=[0.0], v0=[0.0])


def report(name: str, way: Way, off: float, n: int) -> None:
    """Print errors in standard errors of the best estimate, and processor time."""
    record = measured(0)
    errors = ss.fit(MODEL, record, NAMES).standard_errors
    way(TRUE, record)  # compiles
    worst, begun = [], time.process_time()
    for seed in range(n):
        rng = np.random.default_rng([1, seed])
        begin = TRUE * (1.0 + rng.choice([-off, off], size=len(TRUE)))
        found = way(begin, measured(seed))
        worst.append(np.abs((found - TRUE) / errors).max())
    spent = (time.process_time() - begun) / n
    found = int(np.sum(np.array(worst) < 5.0))
    print(
        f"{name:42s} from {off:3.0%} off: found {found} of {n}, largest error "
        f"{np.median(worst):.3g} standard errors (median), {spent:.2f} s",
        flush=True,
    )


def main(n: int = 8) -> None:
    """Print a row for each way and start."""
    ways: dict[str, Way] = {
        "exact derivatives": exact,
        "exact derivatives, one piece": exact_in_one_piece,
        "SciPy's differences of exact motions": differences,
    }
    for off in (0.02, 0.3):
        for name, way in ways.items():
            report(name, way, off, n)


if __name__ == "__main__":
    main()
