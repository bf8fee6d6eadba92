"""One fit by several ways: exact derivatives, finite differences, and friction made smooth.

``python -m benchmarks.fit_beside``. An oscillator's record, 600 displacements with 1 per cent
noise, start known; each way begins at the same parameters. Smooth friction is integrated and
differentiated by diffrax (``pip install diffrax``); without it those rows are left out.
"""

from __future__ import annotations

import importlib.util
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
# Speeds over which friction is made smooth, and the solver that is faster there. At 1e-4 the steps
# of Tsit5 are at its limit of stability: motions are right, but their tangents overflow.
SMOOTH = ((1e-2, "Tsit5"), (1e-3, "Tsit5"), (1e-4, "Kvaerno5"), (1e-5, "Kvaerno5"))
TOLERANCE = 1e-8
REACHED = 0.1  # standard errors from the least of the sum of squares of exact motions

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


def smooth(width: float, solver: str) -> Way:
    """SciPy's least squares of motions by diffrax, whose friction is F(abs w) tanh(w / width)."""
    import diffrax
    import jax
    import jax.numpy as jnp

    jax.config.update("jax_enable_x64", True)

    def rates(_: Any, state: Any, values: Any) -> Any:
        x, v = state
        mu, speed, damping = values
        w = v - MODEL.V
        friction = (mu + (1.0 - mu) * jnp.exp(-jnp.abs(w) / speed)) * jnp.tanh(w / width)
        return jnp.array([v, -x - damping * v - friction])

    def displacements(values: Any) -> Any:
        return diffrax.diffeqsolve(
            diffrax.ODETerm(rates),
            getattr(diffrax, solver)(),
            0.0,
            T[-1],
            None,
            jnp.zeros(2),
            values,
            saveat=diffrax.SaveAt(ts=jnp.asarray(T)),
            stepsize_controller=diffrax.PIDController(rtol=TOLERANCE, atol=TOLERANCE),
            adjoint=diffrax.ForwardMode(),
            max_steps=10**6,
        ).ys[:, 0]

    followed, differentiated = jax.jit(displacements), jax.jit(jax.jacfwd(displacements))

    def fit(begin: np.ndarray, record: ss.Record) -> np.ndarray:
        x, sigma = np.asarray(record.x)[:, 0], record.sigma
        found = least_squares(
            lambda values: (np.asarray(followed(values)) - x) / sigma,
            begin,
            lambda values: np.asarray(differentiated(values)) / sigma,
            bounds=([0.0, 1e-3, 0.0], [1.0, np.inf, np.inf]),
            x_scale=begin,
            max_nfev=200,
        )
        return np.asarray(found.x)

    return fit


def measured(seed: int) -> ss.Record:
    """Make a noisy record from rest."""
    x = ss.simulate(MODEL, [0.0], [0.0], t_end=T[-1]).x(T)[:, 0]
    sigma = NOISE * float(x.std())
    x = x + np.random.default_rng(seed).normal(scale=sigma, size=x.shape)
    return ss.Record(T, x, sigma=sigma, x0=[0.0], v0=[0.0])


def report(name: str, way: Way, off: float, n: int) -> None:
    """Print errors, of the truth and of the least of the sum of squares, and processor time."""
    way(TRUE, measured(0))  # compiles
    rows, spent = [], 0.0
    for seed in range(n):
        record = measured(seed)
        best = ss.fit(MODEL, record, NAMES)
        rng = np.random.default_rng([1, seed])
        begin = TRUE * (1.0 + rng.choice([-off, off], size=len(TRUE)))
        begun = time.process_time()
        found = way(begin, record)
        spent += (time.process_time() - begun) / n
        errors = best.standard_errors
        pairs = (
            (found - TRUE, TRUE),
            (found - TRUE, errors),
            *((each - best.values, errors) for each in (begin, found)),
        )
        rows.append([np.abs(distance / size).max() for distance, size in pairs])
    relative, in_errors, before, after = np.median(rows, axis=0)
    reached = int(np.sum(np.array(rows)[:, 3] < REACHED))
    print(
        f"{name:42s} from {off:3.0%} off: error {relative:.2%}, {in_errors:.3g} standard errors; "
        f"from the least squares {before:.3g} before, {after:.2g} after (medians); "
        f"reached {reached} of {n}, {spent:.2f} s",
        flush=True,
    )


def main(n: int = 5) -> None:
    """Print a row for each start and way."""
    ways: dict[str, Way] = {
        "exact derivatives": exact,
        "exact derivatives, one piece": exact_in_one_piece,
        "SciPy's differences of exact motions": differences,
    }
    if importlib.util.find_spec("diffrax"):
        ways |= {
            f"friction smooth over {width:g}, diffrax {solver}": smooth(width, solver)
            for width, solver in SMOOTH
        }
    for off in (0.1, 0.3):
        for name, way in ways.items():
            report(name, way, off, n)


if __name__ == "__main__":
    main()
