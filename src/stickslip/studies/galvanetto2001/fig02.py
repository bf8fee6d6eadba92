"""Figure 2: the global stick locus in the displacement space (eq. 6a)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.locus import stick_locus

TITLE: Final = "Global stick locus"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3


@dataclass(frozen=True)
class Data:
    """The model, the corners A, B, C, D (4, 2) and the map's domain."""

    model: TwoBlock
    corners: Floats
    domain: tuple[float, float]


def compute() -> Data:
    """Find the corners of the locus of the Coulomb system."""
    model = examples.coulomb()
    return Data(model, locus.corners(model.structure), model.domain)


def draw(data: Data, figure: Figure) -> None:
    """Draw the locus, its onset edges and the domain AC."""
    stick_locus(data.model, figure.add_subplot()).legend(loc="lower right")


def caption(data: Data) -> str:
    """Describe the picture, the domain in numbers."""
    model = data.model
    return (
        f"Global stick locus for alpha = {model.alpha:g}, beta = {model.beta:g} (the paper's "
        "figure shows a typical shape without numbers). Global stick phases move along the "
        "arrows and end on AB, where block 1 slips, or on BC, where block 2 slips; the event "
        f"map is defined on AC, {data.domain[0]:.6g} <= d <= {data.domain[1]:.6g}."
    )
