"""Numbers of models: where their sliders start and end, and how far beyond the server goes."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final

from stickslip.checks import finite_number

if TYPE_CHECKING:
    from collections.abc import Mapping

FAR: Final = 10.0  # times beyond a slider's end: what is stiffer takes the server minutes
BLOCK: Final = re.compile(r"(_\d+)+$")


def slider(
    default: float, low: float, high: float, *, step: float = 0.001, scale: str = "linear"
) -> dict[str, Any]:
    """Describe a slider; typed values may lie some way beyond its ends."""
    return {"default": default, "min": low, "max": high, "step": step, "scale": scale}


SLIDERS: Final = {
    "alpha": slider(1.2, 0.0, 3.0),
    "beta": slider(1.3, 0.5, 2.5),
    "V": slider(0.0366, 0.001, 1.0, step=0.0001, scale="log"),
    "damping": slider(0.0, 0.0, 1.0),
    "stiffness": slider(1.0, -10.0, 10.0, step=0.01),
    "static": slider(1.0, 0.2, 3.0, step=0.01),
    "support": slider(1.0, 0.1, 10.0, step=0.01, scale="log"),
    "mass": slider(1.0, 0.1, 10.0, step=0.01, scale="log"),
    "amplitude": slider(0.5, 0.0, 3.0, step=0.01),
    "frequency": slider(1.0, 0.05, 10.0, step=0.01, scale="log"),
    "phase": slider(0.0, -3.1416, 3.1416, step=0.01),
    "mu": slider(0.22, 0.0, 1.0),
    "gamma": slider(3.0, 0.0, 10.0, step=0.01),
    "delta": slider(0.0, 0.0, 1.0),
    "eta": slider(0.0, 0.0, 2.0, step=0.01),
    "viscous": slider(0.0, 0.0, 1.0),
    "speed": slider(0.1, 0.01, 10.0, step=0.001, scale="log"),
}
"""Where the sliders start and end: what is worth looking at, not what is allowed."""


def refuse_far(values: Mapping[str, float]) -> None:
    """Refuse numbers that would keep the server busy for long."""
    for name, value in values.items():
        if slider := SLIDERS.get(BLOCK.sub("", name).rpartition(".")[2]):
            low, high = slider["min"], slider["max"]
            finite_number(
                name,
                value,
                at_least=low / FAR if low > 0 else low * FAR,
                at_most=high * FAR,
                why="The explorer computes no models far beyond its sliders.",
                remedy="The library takes them.",
            )
