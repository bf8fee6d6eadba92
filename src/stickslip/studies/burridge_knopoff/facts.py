"""The motions of the chain, once for all figures and claims."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from stickslip.mechanics.flow.slip import Slip
from stickslip.mechanics.flow.slip_stream import slips
from stickslip.mechanics.flow.trajectory import State
from stickslip.mechanics.friction.user_law import friction_law
from stickslip.mechanics.model.blocks import Chain
from stickslip.numerics.arrays import Floats
from stickslip.studies.burridge_knopoff.power_law import PowerLaw, fit_power_law

BLOCKS: Final = 200
STIFF: Final = 100.0  # coupling over support: l^2 of the sources, l = 10
SOFT: Final = 1.0  # equal springs
DROP: Final = 0.01  # sigma: by how much friction falls as a slip begins
WEAKENING: Final = 2.5  # the sources' alpha
SPEEDS: Final = (0.01, 0.001)
TRAVEL: Final = 40.0  # of the belt: some forty times what loads a block to its limit
TRANSIENT: Final = 3.0  # of the travel
SPREAD: Final = 0.05  # of the displacements at first
SEED: Final = 1989


def force(s: float, drop: float, weakening: float) -> float:
    """Kinetic friction that falls from 1 - drop with the speed of slip."""
    return (1.0 - drop) / (1.0 + 2.0 * weakening * s / (1.0 - drop))


def chain(alpha: float, V: float, *, n: int = BLOCKS) -> Chain:
    """Return the chain of the sources, periodic, all blocks alike."""
    law = friction_law(force, parameters={"drop": DROP, "weakening": WEAKENING})
    return Chain(static=(1.0,) * n, alpha=alpha, V=V, friction=law, ends="periodic")


@dataclass(frozen=True)
class Catalogue:
    """Slips of one motion after its transient, in the order of their ends."""

    # `moment` and `lag` count from the first time at which all blocks ride to the last: sum over
    # the slips, and how far the belt leaves all blocks behind, summed over them.

    alpha: float
    V: float
    slips: tuple[Slip, ...]
    moment: float
    lag: float
    travel: float  # of the belt over the whole motion
    end: State  # of the motion

    @property
    def size(self) -> Floats:
        """Moments."""
        return np.array([slip.moment for slip in self.slips])

    @property
    def count(self) -> NDArray[np.int64]:
        """Blocks that take part in each."""
        return np.array([len(slip.blocks) for slip in self.slips])

    @property
    def local(self) -> Floats:
        """Moments of slips of two blocks or more, but not of all."""
        return self.size[(self.count > 1) & (self.count < BLOCKS)]

    @property
    def lone(self) -> Floats:
        """Moments of slips of one block."""
        return self.size[self.count == 1]

    @property
    def whole(self) -> Floats:
        """Moments of slips of all blocks."""
        return self.size[self.count == BLOCKS]

    @property
    def overlap(self) -> float:
        """Share of the time of all slips that passes while another one goes on."""
        start = np.array([slip.start for slip in self.slips])
        end = start + np.array([slip.duration for slip in self.slips])
        order = np.argsort(start)
        start, end = start[order], np.maximum.accumulate(end[order])
        covered = np.maximum(end - np.maximum(start, np.append(-np.inf, end[:-1])), 0.0)
        return float(1.0 - covered.sum() / sum(slip.duration for slip in self.slips))


@cache
def catalogue(alpha: float, V: float) -> Catalogue:
    """Follow one motion from rest on the belt, at displacements drawn at random."""
    model = chain(alpha, V)
    x = np.random.default_rng(SEED).uniform(-SPREAD, SPREAD, BLOCKS)
    stream = slips(model, x, np.full(BLOCKS, V), t_end=TRAVEL / V)
    kept, moment, riding = [], 0.0, []
    for slip in stream:
        moment += slip.moment
        now = stream.state
        if np.all(now.v == V):
            riding.append((moment, float(np.sum(x + V * now.t - now.x))))
        if slip.start * V > TRANSIENT:
            kept.append(slip)
    moment, lag = np.subtract(riding[-1], riding[0]).tolist()
    return Catalogue(alpha, V, tuple(kept), moment, lag, TRAVEL, stream.state)


@cache
def fitted(alpha: float, V: float) -> PowerLaw:
    """Power law of the local slips."""
    return fit_power_law(catalogue(alpha, V).local, np.random.default_rng(SEED))


def lone_moment(alpha: float, V: float) -> float:
    """Moment of a slip of one block between riders, by Runge and Kutta; V = 0: the limit."""
    # ``w' = F(|w|) - e`` and ``e' = (1 + 2 alpha) w + V``, from e = 1 to rest.

    def rates(_: float, y: Floats) -> list[float]:
        w, e, _ = y
        return [force(max(-w, 0.0), DROP, WEAKENING) - e, (1.0 + 2.0 * alpha) * w + V, -w]

    def landing(t: float, y: Floats) -> float:
        return float(y[0]) if t > 0.0 else -1.0

    landing.terminal = True  # type: ignore[attr-defined]
    landing.direction = 1.0  # type: ignore[attr-defined]
    run = solve_ivp(
        rates, (0.0, 50.0), [0.0, 1.0, 0.0], "DOP853", rtol=1e-13, atol=1e-16, events=landing
    )
    assert run.y_events is not None
    return float(run.y_events[0][0][2])
