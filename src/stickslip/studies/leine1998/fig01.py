"""Figure 1: the stick-slip cycle in the plane of displacement and velocity."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.plot.style import PALETTE
from stickslip.studies.leine1998.claims import MODEL, undamped

TITLE: Final = "Stick-slip cycle"
COLUMNS: Final = "one"
HEIGHT: Final = 2.7
POINTS: Final = 1201

compute = undamped


def draw(data: Cycle, figure: Figure) -> None:
    """Draw the cycle, the speed of the belt and steady sliding."""
    ax = figure.add_subplot()
    t = np.linspace(0.0, data.period, POINTS)
    ax.axhline(MODEL.V, color=PALETTE["grey"], lw=0.6, ls=(0, (5, 3)))
    ax.plot(data.trajectory.x(t)[:, 0], data.trajectory.v(t)[:, 0], color=PALETTE["blue"])
    ax.plot(data.model.laws[0].force(MODEL.V), 0.0, "x", color=PALETTE["black"])
    ax.set_xlabel("$X$")
    ax.set_ylabel("$X'$")


def caption(data: Cycle) -> str:
    """Describe the picture with its parameters."""
    return (
        f"Stick-slip cycle of one block, F = 1/(1 + 3|w|), V = {MODEL.V:g} (dashed), no damping; "
        f"period {data.period:.10f}. Cross: steady sliding, which repels."
    )
