"""Derivatives of maps and cycles to 1e-8 of differences of order eight, next to breaks, too.

Those of motions in time: tests/mechanics/flow/test_sensitivity.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from tests.mechanics.cycle.test_return_map import drawn
from tests.mechanics.flow.systems import random_model
from tests.sizes import sizes

import stickslip as ss
from stickslip.errors import NoCycleError

NODES = np.array([-4, -3, -2, -1, 1, 2, 3, 4])
WEIGHTS = np.array([1 / 280, -4 / 105, 1 / 5, -4 / 5, 4 / 5, -1 / 5, 4 / 105, -1 / 280])
RELATIVE = 1e-8  # of the derivative, or of 1
CONVERGED = 2e-9  # differences of two steps must agree so well before they can judge
ROUNDING = 1e-14  # of values, which a step magnifies
# Distances from a break of a map: slopes grow like one over their root beside a graze.
NEAR = (1e-3, 1e-5, 1e-6)

Move = Callable[[float], Any]  # what is differentiated, some way along; None where it is another


def limit(move: Move, widest: float, halvings: int) -> np.ndarray | None:
    """Derivative by differences of two steps, the pair that agrees best; None if none does."""
    best, error, last = None, CONVERGED, None
    for k in range(halvings):
        h = widest * 0.5**k
        values = [move(h * node) for node in NODES]
        if any(each is None for each in values):
            continue
        here = np.tensordot(WEIGHTS, np.array(values), 1) / h
        if ROUNDING * size(values) > CONVERGED * size(here) * h:
            break
        if last is not None and (off := np.abs(here - last).max() / size(here)) < error:
            best, error = here, off
        last = here
    return best


def size(values: Any) -> float:
    return max(1.0, float(np.abs(values).max(initial=0.0)))


def checked(exact: Any, move: Move, widest: float, where: object, halvings: int = 9) -> bool:
    """Compare; return whether differences could judge."""
    expected = limit(move, widest, halvings)
    if expected is None:
        return False
    off = np.abs(np.ravel(exact) - np.ravel(expected)).max()
    assert off <= RELATIVE * size(expected), (where, exact, expected)
    return True


def check_map(f: Any, point: Any, widest: float) -> int:
    """Compare the slopes of a map in its point and in all parameters; how many were judged."""
    own = f.evaluate(point)
    if own.status != ss.status.OK:
        return 0
    point, n = np.asarray(point, dtype=float), np.size(point)

    def of(g: Any, at: np.ndarray) -> Any:
        found = g.evaluate(at if at.ndim else float(at))
        same = found.status == ss.status.OK and found.label == own.label
        return np.ravel(found.value) if same else None

    jacobian, judged = np.reshape(own.derivative, (n, n)), 0
    for unit, column in zip(np.eye(n), jacobian.T, strict=True):
        along = unit.reshape(point.shape)
        judged += checked(column, lambda h, u=along: of(f, point + h * u), widest, (f, point))
    for name, value in f.parameters.items():
        if name.endswith("frequency") and f.model.plant.n_waves > 2:
            continue  # several waves have one frequency

        def moved(h: float, name: str = name, value: float = value) -> Any:
            try:
                return of(f.replace(**{name: value + h}), point)
            except ValueError:
                return None  # at the end of what is allowed

        judged += checked(f.parameter_derivative(point[()], name), moved, widest, (f, name))
    return judged


@pytest.mark.parametrize(("n", "least"), sizes((2, 15), (6, 60)))
@pytest.mark.parametrize("law", ["coulomb", "law9"])
def test_event_maps(law: str, n: int, least: int) -> None:
    rng, judged = np.random.default_rng(31), 0
    for _ in range(n):
        f: Any = ss.event_map(random_model(rng, law), max_events=300)
        for d in rng.uniform(*f.domain, 3):
            judged += check_map(f, d, 1e-3)
    assert judged > least


@pytest.mark.parametrize(("n", "least", "steep"), sizes((1, 15, 2), (4, 60, 20)))
@pytest.mark.parametrize("law", ["coulomb", "law9"])
def test_event_maps_next_to_their_breaks(law: str, n: int, least: int, steep: int) -> None:
    rng, judged, steepest = np.random.default_rng(32), 0, 0.0
    for _ in range(n):
        f: Any = ss.event_map(random_model(rng, law), max_events=300)
        breaks = [found.d for found in ss.breakpoints(f)]
        inner = [d for d in breaks if f.domain[0] < d < f.domain[1]]
        for d in rng.permutation(inner)[:2]:
            for near in (side * distance for side in (-1, 1) for distance in NEAR):
                judged += check_map(f, d + near, abs(near) / 5)
                steepest = max(steepest, size(f.derivative(d + near)))
    assert judged > least
    assert steepest > steep


# Kernels of maps of chains with law (9) others need too.
@pytest.mark.parametrize(("name", "n", "least"), sizes(("law9", 2, 7), ("stribeck", 4, 15)))
def test_maps_of_chains(name: str, n: int, least: int) -> None:
    rng, judged = np.random.default_rng(33), 0
    for _ in range(n):
        mu, speed = rng.uniform(0.3, 0.6), rng.uniform(0.2, 0.5)
        law = ss.PoppStelter(3.0) if name == "law9" else ss.Stribeck(mu=mu, speed=speed)
        static, alpha, V = rng.uniform(0.8, 1.3, 3), rng.uniform(0.3, 2), rng.uniform(0.03, 0.2)
        f: Any = ss.event_map(ss.Chain(static=static, alpha=alpha, V=V, friction=law))
        judged += check_map(f, rng.uniform(-0.2, 0.2, 2), 1e-3)
    assert judged > least


@pytest.mark.parametrize(("n", "least"), sizes((2, 4), (16, 40)))
def test_return_maps_of_random_structures(n: int, least: int) -> None:
    judged = 0
    for seed in range(200, 200 + n):
        if (case := drawn(seed)) is not None:
            f, start, _, _ = case
            judged += check_map(f, start, min(1e-3, 0.02 * f.evaluate(start).margin))
    assert judged > least


@pytest.mark.parametrize("n", sizes(1, 4))
def test_return_maps_of_shaken_blocks_next_to_their_breaks(n: int) -> None:
    rng, judged = np.random.default_rng(35), 0
    for _ in range(n):
        forcing = ss.Harmonic(amplitude=rng.uniform(0.25, 0.35), frequency=rng.uniform(0.4, 0.5))
        law = ss.Coulomb(mu=rng.uniform(0.3, 0.5))
        model = ss.Oscillator(
            V=0.02, friction=law, damping=rng.uniform(0.01, 0.05), forcing=forcing
        )
        f: Any = ss.return_map(model)
        jumps = [found.d for found in ss.breakpoints(f) if found.kind == "jump"]
        for d in rng.permutation(jumps)[:1]:
            for near in (-1e-3, -1e-5, 1e-5, 1e-3):
                judged += check_map(f, d + near, abs(near) / 5)
    assert judged > 5 * n


def cycles() -> Iterator[Any]:
    """Models with cycles, drawn at random: a block, two blocks, a forced block, a structure."""
    rng = np.random.default_rng(34)
    law = ss.Stribeck(mu=rng.uniform(0.3, 0.6), speed=rng.uniform(0.2, 0.5))
    yield ss.Oscillator(V=rng.uniform(0.1, 0.4), friction=law, damping=rng.uniform(0.02, 0.1))
    alpha, V, mu = rng.uniform(1.1, 1.3), rng.uniform(0.08, 0.12), rng.uniform(0.28, 0.32)
    yield ss.TwoBlock(alpha=alpha, beta=1.3, V=V, friction=ss.Coulomb(mu=mu))
    forcing = ss.Harmonic(rng.uniform(0.8, 2.0), rng.uniform(0.5, 0.9))
    yield ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.3), damping=0.1, forcing=forcing)
    drive = rng.uniform(1.5, 2.5)
    yield ss.Structure(
        mass=np.diag([0.4, 0.04]),
        stiffness=0.08 * np.array([[1.0, -1.0], [-1.0, 1.0]]),
        damping=np.diag([drive, 0.0]),
        force=[6.0 * drive, 0.0],
        contacts=[ss.Contact(at=1, static=0.3, friction=ss.Stribeck(mu=0.5, speed=2.0))],
    )


def numbers(period: Any, x: Any, v: Any, multipliers: Any) -> np.ndarray:
    """All of a cycle; of several bodies distances: what turns freely may be anywhere."""
    apart = np.diff(x, axis=1) if x.shape[1] > 1 else x
    return np.concatenate([[period], apart.ravel(), v.ravel(), multipliers])


def test_cycles_of_random_models() -> None:
    judged = 0
    for model in cycles():
        try:
            rest = np.zeros(len(model.plant.mass)), np.zeros(model.plant.n_positions)
            found = ss.find_cycle(model, *rest)
        except NoCycleError:
            continue
        if not found.events:
            continue
        by = found.derivative(*(names := [n for n, v in model.parameters.items() if v][-2:]))
        if by.status or by.margin < 1e-3:
            continue

        def quantities(h: float, name: str, found: Any = found, model: Any = model) -> Any:
            try:
                changed = model.replace(**{name: model.parameters[name] + h})
                other = ss.find_cycle(changed, found.x, found.v)
            except (NoCycleError, ValueError):
                return None
            kinds = [each[1:] for each in other.events]
            if sorted(kinds) != sorted(each[1:] for each in found.events):
                return None
            t = np.minimum([each.time for each in other.events], other.period)
            x, v = other.trajectory.x(t), other.trajectory.v(t)
            x, v = (np.roll(each, -kinds.index(found.events[0][1:]), axis=0) for each in (x, v))
            return numbers(other.period, x, v, other.multipliers)

        for k, name in enumerate(names):
            exact = numbers(*(each[..., k] for each in (by.period, by.x, by.v, by.multipliers)))
            if np.isfinite(exact).all():
                widest = 2e-3 * model.parameters[name]
                move: Move = lambda h, n=name, of=quantities: of(h, n)  # noqa: E731
                judged += checked(exact, move, widest, (model, name), halvings=3)
    assert judged >= 6
