"""Figure 2: the chaotic attractor once per period."""

from __future__ import annotations

from typing import Final

from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.forced_belt.claims import CHAOTIC, TRANSIENT, shaken

TITLE: Final = "Chaotic attractor"
COLUMNS: Final = "two"
HEIGHT: Final = 3.0
PERIODS: Final = 4000


def compute() -> Floats:
    """Return states (n, 2) once per period."""
    states: Floats = shaken(CHAOTIC).iterate([0.0, 0.0], TRANSIENT + PERIODS)[TRANSIENT:]
    return states


def draw(data: Floats, figure: Figure) -> None:
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


def caption(data: Floats) -> str:
    """Describe the picture."""
    return (
        f"{len(data) - 1} periods of the forcing at frequency {CHAOTIC:g}: (a) states once per "
        "period, (b) each displacement against the one before. Sticking makes the attractor a line."
    )
