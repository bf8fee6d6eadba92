"""Systems that the tests of flow and event map share: random, degenerate, one per stepper."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import strategies as st

import stickslip as ss

# Law (9) with delta = eta = 0 in a form that cannot be traced (it branches on a number), so
# that the adaptive engine takes its other stepper; it fails at speeds that only a very fast
# belt leads to. One object: it is compiled once a process.
UNTRACED_LAW_9 = ss.friction_law(
    lambda s, g: 1 / (1 + g * s) if s < 12 else math.nan, parameters={"g": 3.0}
)

# Stepper of a map or trajectory, the law that leads to it, and how to ask for it.
STEPPERS = {
    "exact": (ss.Coulomb(mu=0.22), "auto"),
    "taylor": (ss.PoppStelter(gamma=3.0, delta=0.1, eta=0.05), "adaptive"),
    "collocation": (UNTRACED_LAW_9, "adaptive"),
}

ALPHA = st.floats(0.0, 3.0)
BETA = st.floats(0.3, 2.5)
BELT = st.floats(0.005, 0.5)
COULOMB = st.builds(ss.Coulomb, mu=st.floats(0.0, 1.0))
LAW_9 = st.builds(
    ss.PoppStelter, gamma=st.floats(0.0, 4.0), delta=st.floats(0.0, 1.0), eta=st.floats(0.0, 0.2)
)


def models(*laws: st.SearchStrategy) -> st.SearchStrategy[ss.TwoBlock]:
    """Legal models, degenerate ones included (alpha = 0, mu = 0 and 1, gamma = 0)."""
    return st.builds(ss.TwoBlock, alpha=ALPHA, beta=BETA, V=BELT, friction=st.one_of(*laws))


@st.composite
def states(draw: st.DrawFn, model: ss.TwoBlock) -> tuple[np.ndarray, np.ndarray]:
    """Displacements and velocities inside and outside the locus, blocks often on the belt."""
    share = st.floats(-1.5, 1.5)
    force = np.array([draw(share) * limit for limit in model.limits])
    d = (force[1] - force[0]) / (1 + 2 * model.alpha)
    x = 0.5 * (force.sum() + np.array([-d, d]))
    w = np.array([draw(st.just(0.0) | st.floats(-2.0, 2.0)) for _ in range(2)])
    return x, w + model.V


def random_model(rng: np.random.Generator, law: str) -> ss.TwoBlock:
    """A system from the ranges that "random" means in docs/design.md."""
    frame = {"alpha": rng.uniform(0.1, 3), "beta": rng.uniform(0.5, 2)}
    if law == "coulomb":
        V, friction = rng.uniform(0.005, 0.3), ss.Coulomb(mu=rng.uniform(0.05, 0.9))
    elif law == "law9":
        V = rng.uniform(0.02, 0.3)
        friction = ss.PoppStelter(rng.uniform(0.3, 4), rng.uniform(0, 0.5), rng.uniform(0, 0.1))
    else:
        V, friction = rng.uniform(0.02, 0.3), UNTRACED_LAW_9.replace(g=rng.uniform(0.3, 4))
    return ss.TwoBlock(V=V, friction=friction, **frame)


LAW_OF = {"exact": "coulomb", "taylor": "law9", "collocation": "untraced"}


def needed_force(model: ss.TwoBlock, x: np.ndarray) -> np.ndarray:
    """R = X + alpha (X - X_other), eq. (6a)."""
    return x + model.alpha * (x - x[..., ::-1])


def regular_points(f, n: int, rng: np.random.Generator, margin: float = 3e-3) -> np.ndarray:
    """Points of the map that are not next to a breakpoint."""
    d = rng.uniform(-0.95, 0.95, 40 * n) * f.domain[1]
    result = f.evaluate(d)
    return d[(result.status == ss.status.OK) & (result.margin > margin)][:n]
