"""The usual tool, to set beside exact motions: friction made smooth, integrated step by step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np
from scipy.integrate import solve_ivp

if TYPE_CHECKING:
    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats

RTOL: Final = 1e-6  # a usual choice
SAMPLES: Final = 40  # per unit of time


@dataclass(frozen=True)
class SmoothMotion:
    """Times (k,), displacements (k, n) and velocities (k, n); and what they cost."""

    width: float  # of the smooth law
    t: Floats
    x: Floats
    v: Floats
    evaluations: int  # of the right-hand side


def smoothed(
    model: Structure, width: float, x: Floats, v: Floats, t_end: float, rtol: float = RTOL
) -> SmoothMotion:
    """Integrate an unforced structure whose friction is -L F(abs w) tanh(w / width), by LSODA."""
    plant = model.plant
    n = plant.stiffness.shape[1]
    inverse = np.linalg.inv(np.diag(plant.mass) if plant.mass.ndim == 1 else plant.mass)

    def rates(_: float, z: Floats) -> Floats:
        q, u = z[:n], z[n:]
        w = plant.out @ u - plant.V
        kinetic = [law.force(abs(s)) for law, s in zip(model.laws, w.tolist(), strict=True)]
        friction = -(plant.static + plant.load @ z) * kinetic * np.tanh(w / width)
        applied = plant.force - plant.damping @ u - plant.stiffness @ q + plant.into @ friction
        return np.concatenate([u[:n], inverse @ applied])

    times = np.linspace(0.0, t_end, int(SAMPLES * t_end) + 1)
    start = np.concatenate([x, v])
    run = solve_ivp(rates, (0.0, t_end), start, "LSODA", times, rtol=rtol, atol=1e-3 * rtol)
    return SmoothMotion(width, run.t, run.y[: len(x)].T, run.y[len(x) :].T, int(run.nfev))
