"""The system: the two blocks, their stick locus and their law of friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.breaks import mechanism
from stickslip.plot.law import friction_characteristic
from stickslip.plot.locus import stick_locus
from stickslip.studies.figures import PaperFigure


# Figure 1: the stick-slip model, drawn from the numbers of the Coulomb system.
@dataclass(frozen=True)
class Blocks:
    """The model and the displacements (2,) at which it is shown."""

    model: TwoBlock
    x: Floats


def compute_blocks() -> Blocks:
    """Take the Coulomb system where a global stick phase with level blocks ends."""
    model = examples.coulomb()
    return Blocks(model, model.onset(0.0))


def draw_blocks(data: Blocks, figure: Figure) -> None:
    """Draw the mechanism."""
    mechanism(data.model, figure.add_subplot(), x=data.x)


def describe_blocks(data: Blocks) -> str:
    """Describe the drawing and its numbers."""
    model = data.model
    return (
        f"Two blocks on a belt, drawn for alpha = {model.alpha:g} and beta = {model.beta:g} (the "
        "paper's Coulomb system) where a global stick phase with d = 0 ends: spring wires are as "
        "heavy as the springs are stiff, arrows of the static limits as long as these are large. "
        "The paper's drawing has no numbers."
    )


# Figure 2: the global stick locus in the displacement space (eq. 6a).
@dataclass(frozen=True)
class StickLocus:
    """The model, the corners A, B, C, D (4, 2) and the map's domain."""

    model: TwoBlock
    corners: Floats
    domain: tuple[float, float]


def compute_locus() -> StickLocus:
    """Find the corners of the locus of the Coulomb system."""
    model = examples.coulomb()
    return StickLocus(model, locus.corners(model.plant), model.domain)


def draw_locus(data: StickLocus, figure: Figure) -> None:
    """Draw the locus, its onset edges and the domain AC."""
    stick_locus(data.model, figure.add_subplot()).legend(loc="lower right")


def describe_locus(data: StickLocus) -> str:
    """Describe the picture, the domain in numbers."""
    model = data.model
    return (
        f"Global stick locus for alpha = {model.alpha:g}, beta = {model.beta:g} (the paper's "
        "figure shows a typical shape without numbers). Global stick phases move along the "
        "arrows and end on AB, where block 1 slips, or on BC, where block 2 slips; the event "
        f"map is defined on AC, {data.domain[0]:.6g} <= d <= {data.domain[1]:.6g}."
    )


# Figure 3: shapes of the friction characteristic (9).
# The paper prints no values. The first law is the one of its section 4; the others
# change one constitutive parameter at a time.
LAWS: Final = (
    {"gamma": 3.0, "delta": 0.0, "eta": 0.0},
    {"gamma": 0.5, "delta": 0.0, "eta": 0.0},
    {"gamma": 3.0, "delta": 0.4, "eta": 0.0},
    {"gamma": 3.0, "delta": 0.0, "eta": 0.1},
)
LARGEST_SPEED: Final = 2.5


@dataclass(frozen=True)
class Laws:
    """Laws, slip speeds (n,) and kinetic forces (laws, n)."""

    laws: tuple[PoppStelter, ...]
    speed: Floats
    force: Floats


def compute_laws() -> Laws:
    """Evaluate each law over slip speed."""
    laws = tuple(PoppStelter(**parameters) for parameters in LAWS)
    speed = np.linspace(0.0, LARGEST_SPEED, 251)
    return Laws(laws, speed, np.array([law.force(speed) for law in laws]))


def draw_laws(data: Laws, figure: Figure) -> None:
    """Draw the laws for both directions of slip, and the static interval."""
    ax = figure.add_subplot()
    for law, dashes in zip(data.laws, ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), ":"), strict=True):
        p = law.parameters
        label = rf"$\gamma={p['gamma']:g}$, $\delta={p['delta']:g}$, $\eta={p['eta']:g}$"
        friction_characteristic(law, ax, limit=LARGEST_SPEED, label=label, ls=dashes)
    ax.set_ylim(-1.25, 1.25)
    ax.legend(loc="lower left")


def describe_laws(data: Laws) -> str:
    """List the parameters, none of which the paper prints."""
    shapes = "; ".join(
        ", ".join(f"{name} = {value:g}" for name, value in law.parameters.items())
        for law in data.laws
    )
    return (
        f"Friction characteristic (9) for {shapes}. The vertical line is the static interval. "
        "The paper prints no parameters for this figure: the first set is that of its section 4, "
        "the others change one parameter each."
    )


FIGURES: Final = {
    1: PaperFigure("one", 1.3, compute_blocks, draw_blocks, describe_blocks),
    2: PaperFigure("one", 3.3, compute_locus, draw_locus, describe_locus),
    3: PaperFigure("one", 2.7, compute_laws, draw_laws, describe_laws),
}
