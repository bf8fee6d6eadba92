"""Orders of magnitude of a plant's motions, whatever the units that its numbers are in."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stickslip.mechanics.model.plant import solved

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.mechanics.model.plant import Plant
    from stickslip.numerics.arrays import Floats


class Orders(NamedTuple):
    """Powers of ten, states times limits, so that ordinary dimensionless models share theirs: 1."""

    time: float  # of the slowest contact, over a radian
    state: Floats  # (n,), of (y, w)
    velocity: float
    force: Floats  # (m,), of the limits


@lru_cache(maxsize=64)
def orders(plant: Plant) -> Orders:
    """Orders of magnitude of the states that friction makes, and of the time this takes.

    A static limit L on the inertia m at its contact, with the rate r of the motion there, gives
    velocities L / (m r) and displacements L / (m r^2): the units of the paper.
    """
    inertia, rate, response = _at_contacts(plant)
    velocity = (plant.static * order(1.0 / (inertia * rate))).max()
    n_free = plant.reduced.n_free - plant.n_waves
    state = np.full(n_free + plant.n_contacts, velocity)
    if plant.n_positions:
        state[: plant.n_positions] = (plant.static * order(1.0 / (inertia * rate**2))).max()
    else:  # states of any kind: what the limits do to them in the times of the contacts
        reached = np.abs(response) * plant.static / rate ** np.arange(1, 3)[:, None, None]
        moved = reached.max(axis=(0, 2))[plant.kept]
        state[:n_free] = np.where(moved > 0.0, moved, velocity)
    time, speed = float(order(1.0 / rate.min())), float(order(velocity))
    return Orders(time, state, speed, order(plant.static))


def order(values: ArrayLike) -> Floats:
    """Nearest powers of ten."""
    return np.asarray(10.0 ** np.round(np.log10(values)))


def _at_contacts(plant: Plant) -> tuple[Floats, Floats, Floats]:
    """Inertia and rate of motion at each contact, (m,), and what forces do to states: B, A B."""
    # Of x' = A x + B f, w = C x: C A B / C B is the damping rate, C A^2 B / C B its square less
    # that of the frequency. An elastic contact acts on its bodies as long as its foot sticks.
    n = plant.n_bodies
    into, out = plant.into[:n].copy(), plant.out[:, :n].copy()
    for foot, contact in enumerate(plant.elastic, start=n):
        out[contact] = plant.stiffness[foot, :n] / plant.stiffness[foot, foot]
        into[:, contact] = out[contact]
    mass = plant.mass[:n] if plant.mass.ndim == 1 else plant.mass[:n, :n]
    first = solved(mass, into)
    damped = -solved(mass, plant.damping[:n, :n] @ first)
    second = -solved(mass, plant.damping[:n, :n] @ damped)
    if plant.n_positions:
        second -= solved(mass, plant.stiffness[:n, :n] @ first)
    own, slowed, turned = np.einsum("cn,knc->kc", out, np.array([first, damped, second]))
    decay = slowed / own
    rate = np.maximum(np.sqrt(np.abs(turned / own - decay**2)), np.abs(decay))
    # A mass that nothing holds: in the time in which friction stops it.
    stopped = np.abs(plant.V) / (plant.static * own)
    free = np.where(stopped > 0.0, 1.0 / np.where(stopped > 0.0, stopped, 1.0), 1.0)
    rate = np.where(rate > 0.0, rate, rate.max() or free)
    return 1.0 / own, rate, np.array([first, damped])
