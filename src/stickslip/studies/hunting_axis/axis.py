"""The axis: its cycle in closed form, its return map, and friction of the kind called LuGre."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq

from stickslip.mechanics.cycle.return_map import LineReturnMap, return_map
from stickslip.mechanics.model.file import read_model

if TYPE_CHECKING:
    from stickslip.mechanics.model.structure import StateSpace
    from stickslip.numerics.arrays import Floats

MODEL: Final = cast("StateSpace", read_model(Path(__file__).with_name("model.toml")))
GAIN: Final = "A_3_1"  # minus the integral gain
KINETIC: Final = MODEL.parameters["mu_1"]
DROP: Final = 1.0 - KINETIC
"""Static limit less kinetic friction."""
PROPORTIONAL: Final = -float(MODEL.A[2, 1])
DERIVATIVE: Final = -float(MODEL.A[2, 2])
REACH: Final = (1e-6, 0.06)
"""Distances from the target at a release among which cycles are searched."""


def axis_map(gain: float, mu: float = KINETIC) -> LineReturnMap:
    """From one release to the next of the same direction: the distance from the target."""
    model = MODEL.replace(**{GAIN: -gain, "mu_1": mu})
    return cast("LineReturnMap", return_map(model, coordinates=["x_2"], domain=REACH))


# --- closed form: slips are linear in the distance and in the drop ---------------------------


@dataclass(frozen=True)
class Hunting:
    """The symmetric cycle: distance at rest, time of a slip, multiplier, period."""

    distance: float
    slip: float
    multiplier: float
    period: float


def slip_of(gain: float, t: float) -> tuple[Floats, Floats]:
    """States (x, x', x'') at t of a slip that begins with (1, 0, 0), and with (0, 0, 1)."""
    flow = np.array([[0, 1, 0], [0, 0, 1], [-gain, -PROPORTIONAL, -DERIVATIVE]])
    state = expm(flow * t)
    return state[:, 0], state[:, 2]


@cache
def hunting(gain: float, kinetic: float = KINETIC) -> Hunting:
    """Solve for the slip that begins at rest at u and comes to rest at -u."""

    def excess(t: float) -> float:
        p, q = slip_of(gain, t)
        return float((p[0] + 1.0) * q[1] - q[0] * p[1])

    drop = 1.0 - kinetic
    half = math.pi / math.sqrt(PROPORTIONAL)
    t = float(brentq(excess, 0.8 * half, 1.2 * half, xtol=1e-15))
    p, q = slip_of(gain, t)
    u = drop * float(q[1] / p[1])
    last = u * p[2] - drop * q[2]
    return Hunting(u, t, float(p[0] ** 2), 2.0 * (t + (1.0 + kinetic - float(last)) / (gain * u)))


def half_map(gain: float, x: float, drop: float = DROP) -> float:
    """Where the first slip from rest at x > 0 ends, in closed form."""

    def rate(t: float) -> float:
        p, q = slip_of(gain, t)
        return float(x * p[1] - drop * q[1])

    half = math.pi / math.sqrt(PROPORTIONAL)
    times = np.linspace(0.1 * half, 4.0 * half, 400)
    (changes,) = np.nonzero(np.diff(np.sign([rate(t) for t in times.tolist()])) > 0)
    t = float(brentq(rate, times[changes[0]], times[changes[0] + 1], xtol=1e-15))
    p, q = slip_of(gain, t)
    return float(x * p[0] - drop * q[0])


# --- the usual tool -------------------------------------------------------------------------


@dataclass(frozen=True)
class Bristles:
    """A motion with LuGre's friction: times, positions, evaluations of the equations."""

    stiffness: float
    t: Floats
    x: Floats
    evaluations: int

    @property
    def amplitude(self) -> float:
        """Largest distance in the last third of the time."""
        return float(np.abs(self.x[self.t > self.t[-1] * 2.0 / 3.0]).max())


STRIBECK: Final = 1e-3  # speed over which friction falls to its kinetic value
WATCHED: Final = 200.0


@cache
def bristles(
    stiffness: float,
    *,
    controlled: bool = True,
    push: tuple[float, float] = (0.0, 0.0),
    t_end: float = WATCHED,
) -> Bristles:
    """Integrate the axis with LuGre's friction by LSODA, from x = 0.05 or pushed from rest."""
    ki, kp, kd = -MODEL.A[2] if controlled else np.zeros(3)
    damping = math.sqrt(stiffness)

    def rates(t: float, y: Floats) -> list[float]:
        i, x, v, z = y
        limit = KINETIC + DROP * math.exp(-((v / STRIBECK) ** 2))
        bent = v - stiffness * abs(v) / limit * z
        force = push[0] + push[1] * math.cos(t) - stiffness * z - damping * bent
        return [x, v, -ki * i - kp * x - kd * v + force, bent]

    start = [0.0, 0.05 if controlled else 0.0, 0.0, 0.0]
    times = np.linspace(0.0, t_end, 8001)
    run = solve_ivp(rates, (0.0, t_end), start, "LSODA", times, rtol=1e-6, atol=1e-9)
    return Bristles(stiffness, run.t, run.y[1], int(run.nfev))
