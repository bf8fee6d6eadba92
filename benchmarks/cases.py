"""The two systems that are timed, their inputs, and the points next to their breakpoints."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from tests.reference.coulomb import Coulomb
from tests.reference.law9 import Smooth
from tests.reference.laws import PoppStelter
from tests.reference.motion import System

import stickslip as ss

Floats = NDArray[np.float64]

# A branch shorter than this is two events within rounding of each other.
SHORTEST = 1e-13
# Distances from a breakpoint at which a map is asked: from "anyone sees it" down to rounding.
NEAR = 10.0 ** -np.arange(1.5, 13.01, 0.5)


@dataclass(frozen=True)
class Case:
    """A system, where its map is asked, and how exact an answer must be (design, section 3)."""

    name: str
    model: ss.TwoBlock
    oracle: System
    window: tuple[float, float]
    tolerance: float

    def map(self, threads: int = 1, **settings: object) -> ss.EventMap:
        """Make the event map, on one core unless told."""
        return ss.event_map(self.model, threads=threads, **settings)

    def uniform(self, n: int, seed: int = 1) -> Floats:
        """``n`` starting points, uniform over the window."""
        return np.random.default_rng(seed).uniform(*self.window, n)

    def breakpoints(self, grid: int = 20_000) -> list[float]:
        """Last doubles of the branches of the map, from a grid of itineraries bisected.

        They choose where to look; who is right there is for the oracle to say. Branches of a
        few ulp, where two events are one within rounding, count with their left neighbour.
        """
        f = self.map()
        d = np.linspace(*self.window, grid + 2)[1:-1]
        label = f.evaluate(d).label
        cells = np.flatnonzero(label[1:] != label[:-1])
        found = np.array([a for i in cells for a in _changes(f, float(d[i]), float(d[i + 1]))])
        return found[np.diff(found, prepend=-math.inf) > SHORTEST].tolist()

    def near_grazing(self) -> Floats:
        """``d* - 10^-k``, ``d* + 10^-k``, k = 1.5, 2, .. 13, at every breakpoint in the window."""
        points = [d + side * NEAR for d in self.breakpoints() for side in (-1, 1)]
        points = np.concatenate(points)
        return points[(points > self.window[0]) & (points < self.window[1])]


def _changes(f: ss.EventMap, low: float, high: float) -> Iterator[float]:
    """Last doubles of the branches between two points, however short the ones in between are."""
    labels = f.evaluate([low, high]).label
    while labels[0] != labels[1]:
        left, right = low, high
        while left < (middle := 0.5 * (left + right)) < right:
            same = f.evaluate(middle).label == labels[0]
            left, right = (middle, right) if same else (left, middle)
        yield left
        low = right
        labels = f.evaluate([low, high]).label


def coulomb() -> Case:
    """Figure 5's system over its whole domain."""
    model = ss.examples.coulomb()
    oracle = Coulomb(model.alpha, model.beta, model.V, model.parameters["mu"])
    return Case("Coulomb", model, oracle, model.domain, 1e-14)


def law9() -> Case:
    """Law (9) at the flip of the paper's figure 12, in the window of that figure."""
    model = ss.examples.law9(alpha=1.2099)
    law = PoppStelter(model.parameters["gamma"])
    oracle = Smooth(model.alpha, model.beta, model.V, law)
    return Case("law (9)", model, oracle, (0.37, 0.395), 1e-13)


CASES = (coulomb(), law9())
