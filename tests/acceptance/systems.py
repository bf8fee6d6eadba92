"""One set of parameters as two things: the product's map, and the oracle that judges it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from tests.reference.coulomb import Coulomb
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter
from tests.reference.motion import System
from tests.reference.values import COULOMB, LAW9

import stickslip as ss
from stickslip.status import OK

# Ranges of the design's "random systems".
RANGES = {
    "coulomb": {"alpha": (0.1, 3), "beta": (0.5, 2), "mu": (0.05, 0.9), "V": (0.005, 0.3)},
    "law9": {
        "alpha": (0.1, 3),
        "beta": (0.5, 2),
        "V": (0.02, 0.3),
        "gamma": (0.3, 4),
        "delta": (0, 0.5),
        "eta": (0, 0.1),
    },
}
PAPER = {"coulomb": COULOMB, "law9": LAW9}
TOLERANCE = {"coulomb": 1e-14, "law9": 1e-13}
ENGINES = {"coulomb": ("exact", "adaptive"), "law9": ("adaptive",)}


@dataclass(frozen=True)
class Case:
    """Parameters of one system, by kind of law."""

    kind: str
    alpha: float
    beta: float
    V: float
    law: tuple[tuple[str, float], ...]

    @property
    def end(self) -> float:
        """Upper end of the domain."""
        return (1 + self.beta) / (1 + 2 * self.alpha)

    @property
    def tolerance(self) -> float:
        """What the design allows, per kappa."""
        return TOLERANCE[self.kind]

    def model(self) -> ss.TwoBlock:
        """The product's model."""
        law = ss.Coulomb if self.kind == "coulomb" else ss.PoppStelter
        friction = law(**dict(self.law))
        return ss.TwoBlock(alpha=self.alpha, beta=self.beta, V=self.V, friction=friction)

    def oracle(self) -> System:
        """The reference for the same system, the same one each time."""
        return _oracle(self)

    def __str__(self) -> str:
        """To paste into a bug report."""
        law = ", ".join(f"{k}={v!r}" for k, v in self.law)
        name = "Coulomb" if self.kind == "coulomb" else "PoppStelter"
        return (
            f"TwoBlock(alpha={self.alpha!r}, beta={self.beta!r}, V={self.V!r}, "
            f"friction={name}({law}))"
        )


@lru_cache(1000)
def _oracle(system: Case) -> System:
    law = dict(system.law)
    if system.kind == "coulomb":
        return Coulomb(system.alpha, system.beta, system.V, law["mu"])
    return Smooth(system.alpha, system.beta, system.V, PoppStelter(**law))


def case(kind: str, **parameters: float) -> Case:
    """A system by its parameters; law (9) has delta = eta = 0 unless given."""
    rest = {k: float(v) for k, v in parameters.items() if k not in ("alpha", "beta", "V")}
    return Case(
        kind,
        float(parameters["alpha"]),
        float(parameters["beta"]),
        float(parameters["V"]),
        tuple(sorted(rest.items())),
    )


def paper_case(kind: str, **changes: float) -> Case:
    """One of the paper's two systems."""
    return case(kind, **(PAPER[kind] | changes))


def random_cases(kind: str, n: int, rng: np.random.Generator) -> Iterator[Case]:
    """Systems drawn uniformly from the design's ranges."""
    for _ in range(n):
        yield case(kind, **{name: rng.uniform(*r) for name, r in RANGES[kind].items()})


def random_points(system: Case, n: int, rng: np.random.Generator) -> np.ndarray:
    """Starting points drawn uniformly from the domain."""
    return rng.uniform(-1, 1, n) * system.end


def breakpoints(system: Case, grid: int = 600) -> list[float]:
    """Doubles after which the product's itinerary changes, found on a grid and bisected.

    On one side at least motions return, within 400 events. They only choose where to look; whether
    the product is right there is the oracle's word.
    """
    f = ss.event_map(system.model(), max_events=400)
    d = np.linspace(-system.end, system.end, grid + 2)[1:-1]
    result = f.evaluate(d)
    label, returns = result.label, result.status == OK
    change = np.flatnonzero((label[1:] != label[:-1]) & (returns[1:] | returns[:-1]))
    low, high, left = d[change], d[change + 1], label[change]
    for _ in range(1100):
        middle = 0.5 * (low + high)
        open_ = (middle > low) & (middle < high)
        if not open_.any():
            break
        same = f.evaluate(middle).label == left
        low, high = np.where(open_ & same, middle, low), np.where(open_ & ~same, middle, high)
    return low.tolist()


def around(d: float, system: Case, step: float = 0.5) -> np.ndarray:
    """``d +- 10^-k`` for k = 1.5, 2, .. 13 inside the domain, ``d`` itself and its neighbours."""
    reach = 10.0 ** -np.arange(1.5, 13.01, step)
    near = [math.nextafter(d, -9), d, math.nextafter(d, 9)]
    points = np.concatenate([d - reach, near, d + reach[::-1]])
    return points[np.abs(points) <= system.end]
