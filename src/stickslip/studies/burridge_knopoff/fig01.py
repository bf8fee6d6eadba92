"""Figure 1: slips of a chain in space and time, and how they keep up with the belt."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.burridge_knopoff.facts import (
    BLOCKS,
    SPEEDS,
    STIFF,
    TRANSIENT,
    Catalogue,
    catalogue,
)

TITLE: Final = "Slips of a chain of 200 blocks"
COLUMNS: Final = "two"
HEIGHT: Final = 4.2
SHOWN: Final = 4.0  # travel of the belt


def compute() -> Catalogue:
    """Follow the stiff chain on the faster belt."""
    return catalogue(STIFF, SPEEDS[0])


def draw(data: Catalogue, figure: Figure) -> None:
    """Dot every block of every slip, large ones in colour; below, the sum of the moments."""
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
    shown = [s for s in data.slips if s.start * data.V < TRANSIENT + SHOWN]
    for whole, colour, size in ((True, "vermillion", 2.0), (False, "black", 1.3)):
        chosen = [s for s in shown if (len(s.blocks) == BLOCKS) == whole]
        travel = np.concatenate([np.full(len(s.blocks), s.start * data.V) for s in chosen])
        block = np.concatenate([np.array(s.blocks) for s in chosen])
        above.plot(travel, block, ".", color=PALETTE[colour], ms=size, mew=0, rasterized=True)
    above.set_ylabel("block")
    above.set_ylim(0, BLOCKS + 1)
    ends = np.array([s.start + s.duration for s in shown]) * data.V
    lag = np.cumsum([s.moment for s in shown]) / BLOCKS
    below.step(ends, lag, where="post", color=PALETTE["blue"])
    below.set_ylabel("mean slip")
    below.set_xlabel(r"travel of the belt $Vt$")
    below.set_xlim(TRANSIENT, TRANSIENT + SHOWN)
    for ax, letter in zip((above, below), "ab", strict=True):
        panel_letter(ax, letter)


def caption(data: Catalogue) -> str:
    """Describe the picture."""
    return (
        f"A periodic chain of {BLOCKS} equal blocks, alpha = {data.alpha:g}, V = {data.V:g}. "
        "(a) Blocks that take part in each slip, at its start; slips of the whole chain in red. "
        "(b) Slip summed over all events, a block's mean: steps are the slips of the whole chain."
    )
