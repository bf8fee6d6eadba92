"""Motions of the shaken block over the frequency, and its chaotic attractor."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.forced_belt.claims import (
    AMPLITUDE,
    CHAOTIC,
    LAW,
    SPEED,
    TRANSIENT,
    Sweep,
    shaken,
    sweep,
)


# Figure 1: motions over the frequency of the forcing, and their exponents.
def draw_sweep(data: Sweep, figure: Figure) -> None:
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


def describe_sweep(data: Sweep) -> str:
    """Describe the picture with its parameters."""
    values = ", ".join(f"{name} = {value:g}" for name, value in LAW.parameters.items())
    return (
        f"One block, law (9) with {values}, V = {SPEED:g}, forcing of amplitude {AMPLITUDE:g}: "
        f"displacement at {data.x.shape[1]} periods after a transient, followed upward in the "
        "frequency; and the largest Lyapunov exponent per unit of time."
    )


# Figure 2: the chaotic attractor once per period.
SHOWN: Final = 4000


def compute_attractor() -> Floats:
    """Return states (n, 2) once per period."""
    states: Floats = shaken(CHAOTIC).iterate([0.0, 0.0], TRANSIENT + SHOWN)[TRANSIENT:]
    return states


def draw_attractor(data: Floats, figure: Figure) -> None:
    """Draw the attractor in the plane of states, and each displacement against the one before."""
    left, right = figure.subplots(1, 2)
    left.plot(data[:, 0], data[:, 1], ".", ms=1.2, color=PALETTE["blue"], rasterized=True)
    left.set_xlabel("$X$")
    left.set_ylabel("velocity")
    right.plot(data[:-1, 0], data[1:, 0], ".", ms=1.2, color=PALETTE["blue"], rasterized=True)
    right.set_xlabel("$X_n$")
    right.set_ylabel("$X_{n+1}$")
    for ax, letter in zip((left, right), "ab", strict=True):
        panel_letter(ax, letter)


def describe_attractor(data: Floats) -> str:
    """Describe the picture."""
    return (
        f"{len(data) - 1} periods of the forcing at frequency {CHAOTIC:g}: (a) states once per "
        "period, (b) each displacement against the one before. Sticking makes the attractor a line."
    )


FIGURES: Final = {
    1: PaperFigure("two", 4.0, sweep, draw_sweep, describe_sweep),
    2: PaperFigure("two", 3.0, compute_attractor, draw_attractor, describe_attractor),
}
