"""Event maps as plain values, which files of results hold, and back."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from stickslip.mechanics.friction import LAWS, FrictionLaw
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.mechanics.model.units import Units

if TYPE_CHECKING:
    from stickslip.mechanics.eventmap.event_map import EventMap

__all__ = ["event_map_settings", "event_map_values", "model_of_values"]

NOT_KEPT: Final = ("device", "threads")  # of the machine, not of the result


def event_map_values(f: EventMap) -> dict[str, Any]:
    """Describe an event map by its model and settings.

    Raises
    ------
    ValueError
        A friction law is a Python function.
    """
    model = f.model
    units = model.units
    laws = [_law_values(law) for law in model.laws]
    return {
        "alpha": model.alpha,
        "beta": model.beta,
        "V": model.V,
        "friction": laws if isinstance(model.friction, tuple) else laws[0],
        "units": None if units is None else {"m": units.m, "k": units.k, "fs1": units.fs1},
        "settings": {name: v for name, v in f.settings.items() if name not in NOT_KEPT},
    }


def _law_values(law: FrictionLaw) -> dict[str, Any]:
    if LAWS.get(law.name) is not type(law):
        raise ValueError(
            f"the friction law {law.title} is a Python function, which a file cannot hold."
        )
    return {"law": law.name, **law.parameters, **law.options}


def model_of_values(values: dict[str, Any]) -> TwoBlock:
    """Make the model that `event_map_values` has described.

    Raises
    ------
    ValueError
        A value is not allowed.
    """
    friction, units = values["friction"], values["units"]
    laws = tuple(_law(each) for each in (friction if isinstance(friction, list) else [friction]))
    return TwoBlock(
        alpha=values["alpha"],
        beta=values["beta"],
        V=values["V"],
        friction=(laws[0], laws[1]) if len(laws) == 2 else laws[0],
        units=None if units is None else Units(**units),
    )


def event_map_settings(values: dict[str, Any]) -> dict[str, Any]:
    """Keyword arguments for an event map, from what `event_map_values` has described."""
    return dict(values["settings"])


def _law(values: dict[str, Any]) -> FrictionLaw:
    numbers = {name: value for name, value in values.items() if name != "law"}
    return LAWS[values["law"]].from_values(numbers)
