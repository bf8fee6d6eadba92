"""Figure 1: the stick-slip model, drawn from the numbers of the Coulomb system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.breaks import mechanism

TITLE: Final = "Stick-slip model"
COLUMNS: Final = "one"
HEIGHT: Final = 1.3


@dataclass(frozen=True)
class Data:
    """The model and the displacements (2,) at which it is shown."""

    model: TwoBlock
    x: Floats


def compute() -> Data:
    """Take the Coulomb system where a global stick phase with level blocks ends."""
    model = examples.coulomb()
    return Data(model, model.onset(0.0))


def draw(data: Data, figure: Figure) -> None:
    """Draw the mechanism."""
    mechanism(data.model, figure.add_subplot(), x=data.x)


def caption(data: Data) -> str:
    """Describe the drawing and its numbers."""
    model = data.model
    return (
        f"Two blocks on a belt, drawn for alpha = {model.alpha:g} and beta = {model.beta:g} (the "
        "paper's Coulomb system) where a global stick phase with d = 0 ends: spring wires are as "
        "heavy as the springs are stiff, arrows of the static limits as long as these are large. "
        "The paper's drawing has no numbers."
    )
