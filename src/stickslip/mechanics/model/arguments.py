"""Models and states as arguments of functions, checked alike."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from stickslip.checks import instance, parameter_name, real_numbers, shown
from stickslip.mechanics.model.belt_model import BeltModel
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Floats


Model: TypeAlias = BeltModel


def checked_model(model: object) -> Model:
    """Return a model, of any kind; else ValueError."""
    known = (
        "a model. Take ss.TwoBlock(...), ss.Chain(...), ss.Blocks(...), ss.Oscillator(...) or "
        "ss.Structure(...)"
    )
    checked: Model = instance("model", model, BeltModel, known)
    return checked


def two_blocks(model: object, *, why: str) -> TwoBlock:
    """Return a model of two blocks; else ValueError with `why`, a full sentence."""
    if isinstance(model, TwoBlock):
        return model
    raise ValueError(f"model = {shown(model)} is not an ss.TwoBlock. {why}")


def checked_parameter(role: str, model: Model, name: object) -> str:
    """Return the name of one of a model's parameters; else ValueError suggests the closest one."""
    return parameter_name(role, name, model.parameters, of="this model")


def checked_state(
    model: Model, x: object, v: object, names: tuple[str, str] = ("x", "v")
) -> tuple[Floats, Floats]:
    """Return a state of a model, displacements and velocities; else ValueError."""
    plant = model.plant
    if not plant.n_positions and v is None:
        v = ()
    feet = plant.elastic and real_numbers(names[0], x).shape == (plant.n_bodies,)
    sizes = (plant.n_bodies,) * 2 if feet else (len(plant.mass), plant.n_positions)
    position, velocity = map(state_vector, names, (x, v), sizes)
    return plant.with_relaxed_feet(position, velocity) if feet else (position, velocity)


def state_vector(name: str, values: object, n: int) -> Floats:
    """Return n finite numbers; else ValueError."""
    array = real_numbers(name, values)
    if not n and array.size:
        raise ValueError(
            f"{name} = {shown(values)} is not allowed: the state of a model in state-space form is "
            f"x alone. Leave {name} out."
        )
    if array.shape != (n,) or not np.isfinite(array).all():
        raise ValueError(
            f"{name} = {shown(values)} is not allowed: {name} must be {n} finite numbers, one for "
            "each mass or state."
        )
    return array
