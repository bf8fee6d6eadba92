"""The system: the two blocks, their stick locus and their law of friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from stickslip import examples
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.plot.breaks import mechanism
from stickslip.plot.law import friction_characteristic
from stickslip.plot.locus import stick_locus
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The paper prints no values of law (9). The first set is the one of its section 4; the others
# change one constitutive parameter at a time.
LAWS: Final = (
    PoppStelter(gamma=3.0, delta=0.0, eta=0.0),
    PoppStelter(gamma=0.5, delta=0.0, eta=0.0),
    PoppStelter(gamma=3.0, delta=0.4, eta=0.0),
    PoppStelter(gamma=3.0, delta=0.0, eta=0.1),
)
LARGEST_SPEED: Final = 2.5


def draw_blocks(figure: Figure) -> str:
    """Draw the Coulomb system where a global stick phase with level blocks ends."""
    model = examples.coulomb()
    mechanism(model, figure.add_subplot(), x=model.onset(0.0))
    return (
        f"Two blocks on a belt, drawn for alpha = {model.alpha:g} and beta = {model.beta:g} (the "
        "paper's Coulomb system) where a global stick phase with d = 0 ends: spring wires are as "
        "heavy as the springs are stiff, arrows of the static limits as long as these are large. "
        "The paper's drawing has no numbers."
    )


def draw_locus(figure: Figure) -> str:
    """Draw the global stick locus in the displacement space, its onset edges and the domain AC."""
    model = examples.coulomb()
    stick_locus(model, figure.add_subplot()).legend(loc="lower right")
    low, high = model.domain
    return (
        f"Global stick locus for alpha = {model.alpha:g}, beta = {model.beta:g} (the paper's "
        "figure shows a typical shape without numbers). Global stick phases move along the "
        "arrows and end on AB, where block 1 slips, or on BC, where block 2 slips; the event "
        f"map is defined on AC, {low:.6g} <= d <= {high:.6g}."
    )


def draw_laws(figure: Figure) -> str:
    """Draw the laws for both directions of slip, and the static interval."""
    ax = figure.add_subplot()
    for law, dashes in zip(LAWS, ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), ":"), strict=True):
        p = law.parameters
        label = rf"$\gamma={p['gamma']:g}$, $\delta={p['delta']:g}$, $\eta={p['eta']:g}$"
        friction_characteristic(law, ax, limit=LARGEST_SPEED, label=label, ls=dashes)
    ax.set_ylim(-1.25, 1.25)
    ax.legend(loc="lower left")
    shapes = "; ".join(
        ", ".join(f"{name} = {value:g}" for name, value in law.parameters.items()) for law in LAWS
    )
    return (
        f"Friction characteristic (9) for {shapes}. The vertical line is the static interval. "
        "The paper prints no parameters for this figure: the first set is that of its section 4, "
        "the others change one parameter each."
    )


FIGURES: Final = {
    1: PaperFigure("one", 1.3, draw_blocks),
    2: PaperFigure("one", 3.3, draw_locus),
    3: PaperFigure("one", 2.7, draw_laws),
}
