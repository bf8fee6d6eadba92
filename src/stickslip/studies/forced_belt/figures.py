"""Motions of the shaken block over the frequency, and its chaotic attractor."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.forced_belt.claims import (
    AMPLITUDE,
    CHAOTIC,
    LAW,
    SPEED,
    TRANSIENT,
    shaken,
    sweep,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN: Final = 4000


def draw_sweep(figure: Figure) -> str:
    """Draw displacements once per period above, exponents below, over the frequency."""
    data = sweep()
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
    values = ", ".join(f"{name} = {value:g}" for name, value in LAW.parameters.items())
    return (
        f"One block, law (9) with {values}, V = {SPEED:g}, forcing of amplitude {AMPLITUDE:g}: "
        f"displacement at {data.x.shape[1]} periods after a transient, followed upward in the "
        "frequency; and the largest Lyapunov exponent per unit of time."
    )


def draw_attractor(figure: Figure) -> str:
    """Draw the chaotic attractor once per period, and each displacement against the one before."""
    left, right = figure.subplots(1, 2)
    x, v = shaken(CHAOTIC).iterate([0.0, 0.0], TRANSIENT + SHOWN)[TRANSIENT:].T
    left.plot(x, v, ".", ms=1.2, color=PALETTE["blue"], rasterized=True)
    left.set(xlabel="$X$", ylabel="velocity")
    right.plot(x[:-1], x[1:], ".", ms=1.2, color=PALETTE["blue"], rasterized=True)
    right.set(xlabel="$X_n$", ylabel="$X_{n+1}$")
    for ax, letter in zip((left, right), "ab", strict=True):
        panel_letter(ax, letter)
    return (
        f"{SHOWN} periods of the forcing at frequency {CHAOTIC:g}: (a) states once per "
        "period, (b) each displacement against the one before. Sticking makes the attractor a line."
    )


FIGURES: Final = {
    1: PaperFigure("two", 4.0, draw_sweep),
    2: PaperFigure("two", 3.0, draw_attractor),
}
