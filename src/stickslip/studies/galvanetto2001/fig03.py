"""Figure 3: shapes of the friction characteristic (9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.numerics.arrays import Floats
from stickslip.plot.law import friction_characteristic

TITLE: Final = "Shapes of the friction characteristic (9)"
COLUMNS: Final = "one"
HEIGHT: Final = 2.7

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
class Data:
    """Laws, slip speeds (n,) and kinetic forces (laws, n)."""

    laws: tuple[PoppStelter, ...]
    speed: Floats
    force: Floats


def compute() -> Data:
    """Evaluate each law over slip speed."""
    laws = tuple(PoppStelter(**parameters) for parameters in LAWS)
    speed = np.linspace(0.0, LARGEST_SPEED, 251)
    return Data(laws, speed, np.array([law.force(speed) for law in laws]))


def draw(data: Data, figure: Figure) -> None:
    """Draw the laws for both directions of slip, and the static interval."""
    ax = figure.add_subplot()
    for law, dashes in zip(data.laws, ("-", (0, (5, 1.5)), (0, (3, 1, 1, 1)), ":"), strict=True):
        p = law.parameters
        label = rf"$\gamma={p['gamma']:g}$, $\delta={p['delta']:g}$, $\eta={p['eta']:g}$"
        friction_characteristic(law, ax, limit=LARGEST_SPEED, label=label, ls=dashes)
    ax.set_ylim(-1.25, 1.25)
    ax.legend(loc="lower left")


def caption(data: Data) -> str:
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
