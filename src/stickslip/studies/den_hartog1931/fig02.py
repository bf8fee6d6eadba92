"""Figure 2: where motions begin to stop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE
from stickslip.studies.den_hartog1931.claims import Boundary, boundaries
from stickslip.studies.den_hartog1931.closed_forms import stop_boundary

TITLE: Final = "Where motions begin to stop"
COLUMNS: Final = "one"
HEIGHT: Final = 2.7


@dataclass(frozen=True)
class Data:
    """Closed form f/a over the frequency, and boundaries found by continuation."""

    frequency: Floats
    ratio: Floats
    found: tuple[Boundary, ...]


def compute() -> Data:
    """Evaluate the closed form, and continue motions to their first stop."""
    frequency = np.linspace(0.36, 2.4, 250)
    ratio = np.array([1.0 / stop_boundary(w) for w in frequency.tolist()])
    return Data(frequency, ratio, boundaries())


def draw(data: Data, figure: Figure) -> None:
    """Draw the boundary; circles are found by continuation."""
    ax = figure.add_subplot()
    ax.fill_between(data.frequency, data.ratio, color=PALETTE["light"], lw=0)
    ax.plot(data.frequency, data.ratio, color=PALETTE["black"])
    for item in data.found:
        ax.plot(item.frequency, 1.0 / item.forcing, "o", color=PALETTE["vermillion"], mfc="white")
    ax.text(1.25, 0.3, "no stops", ha="center")
    ax.text(1.6, 0.8, "stops", ha="center")
    ax.set_xlim(data.frequency[0], data.frequency[-1])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel("frequency")
    ax.set_ylabel("$f/a$")


def caption(data: Data) -> str:
    """Describe the picture."""
    return (
        "Friction over forcing below which the block never stops: closed form (line) and the first "
        "stop met by motions continued in the forcing (circles)."
    )
