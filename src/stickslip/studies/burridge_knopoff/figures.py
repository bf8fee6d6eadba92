"""Slips of a chain: in space and time, their sizes, and the limit of a slow belt."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.burridge_knopoff.facts import (
    BLOCKS,
    SOFT,
    SPEEDS,
    STIFF,
    TRANSIENT,
    catalogue,
    fitted,
    lone_moment,
)
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN: Final = 4.0  # travel of the belt
MOTIONS: Final = ((STIFF, SPEEDS[0]), (STIFF, SPEEDS[1]), (SOFT, SPEEDS[0]))
COLOURS: Final = ("blue", "vermillion", "green")


def draw_slips(figure: Figure) -> str:
    """Dot every block of every slip, large ones in colour; below, the sum of the moments."""
    data = catalogue(STIFF, SPEEDS[0])
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(2.2, 1.0))
    shown = [s for s in data.slips if s.start * data.V < TRANSIENT + SHOWN]
    for whole, colour, size in ((True, "vermillion", 2.0), (False, "black", 1.3)):
        chosen = [s for s in shown if (len(s.blocks) == BLOCKS) == whole]
        travel = np.concatenate([np.full(len(s.blocks), s.start * data.V) for s in chosen])
        block = np.concatenate([np.array(s.blocks) for s in chosen])
        above.plot(travel, block, ".", color=PALETTE[colour], ms=size, mew=0, rasterized=True)
    above.set(ylabel="block", ylim=(0, BLOCKS + 1))
    ends = np.array([s.start + s.duration for s in shown]) * data.V
    lag = np.cumsum([s.moment for s in shown]) / BLOCKS
    below.step(ends, lag, where="post", color=PALETTE["blue"])
    below.set_ylabel("mean slip")
    below.set_xlabel(r"travel of the belt $Vt$")
    below.set_xlim(TRANSIENT, TRANSIENT + SHOWN)
    for ax, letter in zip((above, below), "ab", strict=True):
        panel_letter(ax, letter)
    return (
        f"A periodic chain of {BLOCKS} equal blocks, alpha = {data.alpha:g}, V = {data.V:g}. "
        "(a) Blocks that take part in each slip, at its start; slips of the whole chain in red. "
        "(b) Slip summed over all events, a block's mean: steps are the slips of the whole chain."
    )


def draw_sizes(figure: Figure) -> str:
    """Draw the share of local slips above each moment, and the fitted power laws."""
    ax = figure.add_subplot()
    told = []
    for (alpha, V), name in zip(MOTIONS, COLOURS, strict=True):
        law, moments = fitted(alpha, V), np.sort(catalogue(alpha, V).local)
        share = 1.0 - np.arange(moments.size) / moments.size
        label = rf"$\alpha={alpha:g}$, $V={V:g}$"
        ax.step(moments, share, where="pre", color=PALETTE[name], lw=0.9, label=label)
        if alpha == STIFF:
            line = np.array([law.smallest, moments[-1]])
            height = law.n / moments.size
            ax.plot(line, height * law.share_above(line), "--", color=PALETTE["black"], lw=0.8)
            told.append(f"{law.exponent:.2f} +- {law.error:.2f} (V = {V:g})")
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(bottom=1e-4)
    ax.set_xlabel("moment")
    ax.set_ylabel("share of larger local slips")
    ax.legend(loc="lower left")
    return (
        "Share of local slips (more than one block, not all) whose moment is larger. Dashed: power "
        f"laws fitted to the stiff chain; exponents of the density {' and '.join(told)}. With "
        "springs of equal stiffness, alpha = 1, the decay is exponential."
    )


def draw_overlap(figure: Figure) -> str:
    """Draw what remains of the belt's speed: excess of a lone slip's moment, overlaps of slips."""
    V, limit = np.geomspace(1e-4, 3e-2, 26), lone_moment(STIFF, 0.0)
    found = [catalogue(STIFF, speed) for speed in SPEEDS]
    lone = np.array([lone_moment(STIFF, speed) for speed in V.tolist()])
    chain = np.array([np.median(item.lone) for item in found])
    overlap = [item.overlap for item in found]
    ax = figure.add_subplot()
    ax.loglog(V, lone / limit - 1.0, color=PALETTE["blue"], label="lone slip: one block")
    ax.loglog(SPEEDS, chain / limit - 1.0, "o", color=PALETTE["blue"], label="lone slip: chain")
    ax.loglog(SPEEDS, overlap, "s", color=PALETTE["vermillion"], label="overlap in time")
    ax.set(xlabel="$V$", ylabel="excess of moment; share of time")
    ax.legend(loc="lower right")
    return (
        f"alpha = {STIFF:g}. Blue: by how much of it the moment of a block that slips alone "
        "exceeds its limit V -> 0; line: integration of one block, dots: slips of the chain. Red: "
        "share of the time of all slips that passes while another one goes on."
    )


FIGURES: Final = {
    1: PaperFigure("two", 4.2, draw_slips),
    2: PaperFigure("one", 3.4, draw_sizes),
    3: PaperFigure("one", 2.8, draw_overlap),
}
