"""What rubs: displacements and velocities of contacts, also where states are no places."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

KNOWN_PLACE: Final = 1e-9  # of its velocity: as which a contact's displacement is recognised


def at_contacts(
    model: Model, t: Floats, x: Floats, v: Floats, sticks: NDArray[np.bool_]
) -> tuple[Floats, Floats]:
    """Displacements and velocities of the contacts, shape (n, m)."""
    # One whose displacement is no function of the state goes on about its mean velocity.
    plant = model.plant
    if plant.n_positions:
        return x @ plant.out.T, v @ plant.out.T
    w = x @ plant.out.T
    rates = np.concatenate([-plant.damping.T, plant.into.T, plant.force[None]])
    wanted = np.zeros((len(rates), plant.n_contacts))
    wanted[: len(plant.out.T)] = plant.out.T
    places = np.linalg.lstsq(rates, wanted)[0]
    off = np.abs(rates @ places - wanted).max(axis=0)
    steps = np.diff(t)[:, None] * 0.5 * (w[1:] + w[:-1])
    way = np.concatenate([np.zeros((1, w.shape[1])), np.cumsum(steps, axis=0)])
    about = np.stack([_steady(t, *each) for each in zip(way.T, sticks.T, strict=True)], axis=-1)
    return np.where(off <= KNOWN_PLACE * np.abs(plant.out).max(), x @ places, about), w


def _steady(t: Floats, way: Floats, sticks: NDArray[np.bool_]) -> Floats:
    """Take off the mean velocity, between landings late in the motion if there are any."""
    landings = np.flatnonzero(sticks[1:] & ~sticks[:-1]) + 1
    late = landings[t[landings] >= 0.5 * t[-1]]
    first, last = (late[0], late[-1]) if len(late) > 1 else (0, len(t) - 1)
    if t[last] == t[first]:
        return way
    return np.asarray(way - t * (way[last] - way[first]) / (t[last] - t[first]))
