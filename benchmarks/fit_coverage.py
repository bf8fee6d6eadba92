"""How often intervals hold the true parameters: fits of synthetic records, again and again.

``python -m benchmarks.fit_coverage oscillator 'coulomb map' law9 'law9 slips' --n 100``. Each
has noise of its own, 1 per cent of the scatter, and starts up to 30 per cent off. `--linear` counts
what linear theory alone makes of the same noise, of records of displacements.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import stickslip as ss

NOISE = 0.01
OFF = 0.3
FOUND = 5.0  # standard errors within which true parameters count as recovered


@dataclass(frozen=True)
class Case:
    """A true model, how it is measured, and what is fitted."""

    model: Any
    parameters: tuple[str, ...]
    measure: Callable[[Any, np.random.Generator], Any]
    n_starts: int = 1


def noisy(values: Any, rng: np.random.Generator) -> tuple[Any, float]:
    """Values with normal errors, and their standard error."""
    sigma = NOISE * float(np.std(values, axis=0).max())
    return values + rng.normal(scale=sigma, size=values.shape), sigma


def record(
    n: int, t_end: float, begin: float = 0.0, released: bool = False, **start: Any
) -> Callable[[Any, np.random.Generator], Any]:
    """Displacements at equally spaced times; whether it is told that the first is a release."""

    def measure(model: Any, rng: np.random.Generator) -> Any:
        t = np.linspace(begin, t_end, n)
        x, sigma = noisy(ss.simulate(model, **start, t_end=t_end).x(t), rng)
        known = {"d": float(x[0, 1] - x[0, 0]), "free_start": True} if released else {}
        return ss.Record(t, x, sigma=sigma, **known)

    return measure


def speeds(n: int, t_end: float) -> Callable[[Any, np.random.Generator], Any]:
    """Velocities of all bodies at equally spaced times of a motion from rest."""

    def measure(model: Any, rng: np.random.Generator) -> Any:
        t, rest = np.linspace(0.0, t_end, n), np.zeros(len(model.plant.mass))
        v, sigma = noisy(ss.simulate(model, rest, rest, t_end=t_end).v(t), rng)
        return ss.Record(t, v=v, sigma_v=sigma, x0=rest, v0=rest)

    return measure


def points(n: int) -> Callable[[Any, np.random.Generator], Any]:
    """Points spread over the domain of the map, each with a noisy next one."""

    def measure(model: Any, rng: np.random.Generator) -> Any:
        f = ss.event_map(model)
        d = np.linspace(*f.domain, n + 2)[1:-1]
        values, sigma = noisy(f(d), rng)
        return ss.MapPoints(d, values, sigma=sigma)

    return measure


def slips(d: float, n: int) -> Callable[[Any, np.random.Generator], Any]:
    """Global stick phases one after the other, each with a noisy next one: n slips of an orbit."""

    def measure(model: Any, rng: np.random.Generator) -> Any:
        orbit = ss.event_map(model).iterate(d, n)
        values, sigma = noisy(orbit[1:], rng)
        return ss.MapPoints(orbit[:-1], values, sigma=sigma)

    return measure


ROCK = ss.Stribeck(mu=0.5, speed=2.0, viscous=0.02)
DRILL_STRING = ss.Structure(
    mass=np.diag([0.4, 0.04]),
    stiffness=0.08 * np.array([[1.0, -1.0], [-1.0, 1.0]]),
    damping=np.diag([2.0, 0.0]),
    force=[12.0, 0.0],
    contacts=[ss.Contact(at=1, static=0.3, friction=ROCK)],
)

CASES = {
    "oscillator": Case(
        ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1),
        ("mu", "speed", "damping"),
        record(600, 60.0, x=[0.0], v=[0.0]),
    ),
    "coulomb": Case(ss.examples.coulomb(), ("mu", "V"), record(600, 70.0, 10.0, d=0.1)),
    "coulomb release": Case(
        ss.examples.coulomb(), ("mu", "V"), record(600, 60.0, released=True, d=0.1)
    ),
    "coulomb map": Case(ss.examples.coulomb(), ("mu", "alpha"), points(50), 256),
    "drill string": Case(DRILL_STRING, ("mu_1", "speed_1", "static_1"), speeds(300, 30.0)),
    "law9": Case(ss.examples.law9(), ("gamma", "alpha"), record(600, 60.0, d=0.38)),
    "law9 slips": Case(ss.examples.law9(), ("gamma", "alpha"), slips(0.38, 50), 256),
}


def repeat(case: Case, n: int, off: float, seed: int) -> dict[str, Any]:
    """Count intervals that hold the truth, and searches that find it."""
    true = np.array([case.model.parameters[name] for name in case.parameters])
    inside = np.zeros(len(true), dtype=int)
    together = found = refused = 0
    errors = []
    begun = time.process_time()
    for k in range(n):
        rng = np.random.default_rng([seed, k])
        data = case.measure(case.model, rng)
        factors = 1.0 + rng.choice([-off, off], size=len(true)) if off else np.ones(len(true))
        begin = dict(zip(case.parameters, (true * factors).tolist(), strict=True))
        try:
            n_starts = case.n_starts if off else 1
            changed = case.model.replace(**begin)
            fitted = ss.fit(changed, data, case.parameters, n_starts=n_starts)
        except ValueError as error:
            refused += 1
            print(f"  {k}: {error}")
            continue
        within = (fitted.intervals[:, 0] <= true) & (true <= fitted.intervals[:, 1])
        errors.append((fitted.values - true) / fitted.standard_errors)
        found += bool((np.abs(errors[-1]) < FOUND).all()) and fitted.tells
        inside += within
        together += bool(within.all())
    return {
        "inside": dict(zip(case.parameters, inside.tolist(), strict=True)),
        "all inside": together,
        "errors, in standard errors": np.sqrt(np.mean(np.square(errors), axis=0)).round(2).tolist(),
        "recovered": found,
        "refused": refused,
        "of": n,
        "cpu s per fit": round((time.process_time() - begun) / n, 2),
    }


class Silent:
    """Noise of none."""

    @staticmethod
    def normal(scale: float, size: tuple[int, ...]) -> Any:
        """Draw nothing."""
        return np.zeros(size)


def linear(case: Case, n: int, seed: int) -> dict[str, Any]:
    """Count intervals that hold the truth by the derivatives at it, with the noise of `repeat`."""
    exact = case.measure(case.model, Silent())  # type: ignore[arg-type]
    (start,) = ss.fit(case.model, exact, case.parameters).starts
    x, v = np.split(start[: 2 * len(case.model.plant.mass)], 2)
    motion = ss.simulate(case.model, x, v, t_end=float(exact.t[-1]))
    slopes = motion.derivative(*case.parameters, "x0", "v0").x(exact.t)
    inverse = np.linalg.pinv(slopes.reshape(exact.x.size, -1) / exact.sigma)[: len(case.parameters)]
    records = (case.measure(case.model, np.random.default_rng([seed, k])) for k in range(n))
    off = np.array([inverse @ (each.x - exact.x).ravel() / each.sigma for each in records])
    errors = off / np.linalg.norm(inverse, axis=1)
    return {
        "inside": np.sum(np.abs(errors) < 1.96, axis=0).tolist(),
        "errors, in standard errors": np.sqrt(np.mean(errors**2, axis=0)).round(2).tolist(),
        "of": n,
    }


def main() -> None:
    """Print the counts of the cases asked for: from the truth, and from starts that are off."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=list(CASES))
    parser.add_argument("--n", type=int, default=100)
    parser.add_argument("--off", type=float, nargs="*", default=[0.0, OFF])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--linear", action="store_true")
    asked = parser.parse_args()
    for name in asked.cases:
        if asked.linear:
            print(f"{name}, by linear theory: {linear(CASES[name], asked.n, asked.seed)}")
            continue
        for off in asked.off:
            told = repeat(CASES[name], asked.n, off, asked.seed)
            print(f"{name}, starts {off:.0%} off: {told}", flush=True)


if __name__ == "__main__":
    main()
