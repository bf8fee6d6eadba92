"""Figure 1: motions over the frequency of the forcing, and their exponents."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.plot.style import PALETTE
from stickslip.studies.forced_belt.claims import AMPLITUDE, LAW, SPEED, Sweep, sweep

TITLE: Final = "Motions over the frequency of the forcing"
COLUMNS: Final = "two"
HEIGHT: Final = 4.0

compute = sweep


def draw(data: Sweep, figure: Figure) -> None:
    """Draw displacements once per period above, exponents below."""
    axes = figure.subplots(2, 1, sharex=True, height_ratios=(2.0, 1.0))
    frequency = np.repeat(data.frequency, data.x.shape[1])
    axes[0].plot(
        frequency, data.x.ravel(), ".", ms=0.9, mew=0, color=PALETTE["blue"], rasterized=True
    )
    axes[0].set_ylabel("$X$ once per period")
    axes[1].axhline(0.0, color=PALETTE["grey"], lw=0.5)
    axes[1].plot(data.frequency, data.exponent, color=PALETTE["vermillion"], lw=0.8)
    axes[1].set_ylim(-0.2, 0.06)
    axes[1].set_ylabel("exponent")
    axes[1].set_xlabel("frequency of the forcing")
    axes[1].set_xlim(data.frequency[0], data.frequency[-1])


def caption(data: Sweep) -> str:
    """Describe the picture with its parameters."""
    values = ", ".join(f"{name} = {value:g}" for name, value in LAW.parameters.items())
    return (
        f"One block, law (9) with {values}, V = {SPEED:g}, forcing of amplitude {AMPLITUDE:g}: "
        f"displacement at {data.x.shape[1]} periods after a transient, followed upward in the "
        "frequency; and the largest Lyapunov exponent per unit of time."
    )
