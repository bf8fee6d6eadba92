"""Figure 3: motions without stops, with one and with two in each half period."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.den_hartog1931.claims import NO_STOP, ONE_STOP, TWO_STOPS, steady, stops

TITLE: Final = "Motions with and without stops"
COLUMNS: Final = "two"
HEIGHT: Final = 2.3
SHOWN: Final = (NO_STOP, ONE_STOP, TWO_STOPS)
POINTS: Final = 1201


def compute() -> tuple[Cycle, ...]:
    """Find the three motions."""
    return tuple(steady(*pair) for pair in SHOWN)


def draw(data: tuple[Cycle, ...], figure: Figure) -> None:
    """Draw displacements over one period; stops are bold."""
    axes = figure.subplots(1, len(data))
    for ax, cycle, letter in zip(axes, data, "abc", strict=True):
        t = np.linspace(0.0, cycle.period, POINTS)
        x, v = cycle.trajectory.x(t)[:, 0], cycle.trajectory.v(t)[:, 0]
        ax.plot(t / cycle.period, x, color=PALETTE["blue"])
        rest = np.where(v == 0.0, x, np.nan)
        ax.plot(t / cycle.period, rest, color=PALETTE["vermillion"], lw=2.2)
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel("time / period")
        panel_letter(ax, letter)
    axes[0].set_ylabel("$X$")


def caption(data: tuple[Cycle, ...]) -> str:
    """Describe the panels with their parameters."""
    panels = "; ".join(
        f"({letter}) frequency {w:g}, a/f = {a:g}: {stops(cycle)} stops"
        for letter, (w, a), cycle in zip("abc", SHOWN, data, strict=True)
    )
    return f"Displacement in one period of the forcing, stops bold. {panels}."
