"""Two blocks that nobody tuned: random masses, springs, dampers and laws, each with its oracle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter, Viscous

import stickslip as ss

LAWS = ("coulomb", "law9")


def law_of(kind: str, rng: np.random.Generator) -> ss.FrictionLaw:
    """A law with numbers of the physics contract's random systems."""
    if kind == "coulomb":
        return ss.Coulomb(mu=rng.uniform(0.05, 0.9))
    return ss.PoppStelter(rng.uniform(0.3, 4), rng.uniform(0, 0.5), rng.uniform(0, 0.1))


def reference_law(law: ss.FrictionLaw) -> PoppStelter | Viscous:
    """The same law for the oracle."""
    return (Viscous if isinstance(law, ss.Coulomb) else PoppStelter)(**law.parameters)


def oracle(model: ss.Blocks) -> Smooth:
    """The model in arithmetic of 96 digits."""
    return Smooth.of(model.plant, tuple(map(reference_law, model.laws)))


def random_models(kind: str, n: int, rng: np.random.Generator) -> Iterator[ss.Blocks]:
    """Half of them damped; with a coupling that pulls, and now and then one that pushes."""
    for k in range(n):
        support = rng.uniform(0.3, 3.0, 2)
        coupling = rng.uniform(0.1, 3.0) if k % 5 else rng.uniform(-0.25, 0.0) * support.min()
        dampers = rng.uniform(0.0, 0.3, 3) * (k % 2)
        yield ss.Blocks(
            mass=rng.uniform(0.3, 3.0, 2),
            stiffness=sprung(support, coupling),
            damping=sprung(dampers[:2], dampers[2]),
            static=rng.uniform(0.5, 2.0, 2),
            friction=[law_of(kind, rng), law_of(kind, rng)] if k % 3 else law_of(kind, rng),
            V=rng.uniform(0.005 if kind == "coulomb" else 0.02, 0.3),
        )


def sprung(support: np.ndarray, coupling: float) -> np.ndarray:
    """Matrix of a spring at each block and one between them."""
    return np.diag(support) + coupling * np.array([[1.0, -1.0], [-1.0, 1.0]])


def pair(law: ss.FrictionLaw, V: float, *, damped: bool = False) -> ss.Blocks:
    """Masses 1 and 2, springs 1 and 1.5, coupling 1.2."""
    return ss.Blocks(
        mass=[1, 2],
        stiffness=sprung(np.array([1.0, 1.5]), 1.2),
        damping=sprung(np.array([0.04, 0.03]), 0.02) if damped else None,
        static=[1, 1.3],
        friction=law,
        V=V,
    )
