"""Slips of a chain: in space and time, their sizes, and the limit of a slow belt."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.burridge_knopoff.facts import (
    BLOCKS,
    SOFT,
    SPEEDS,
    STIFF,
    TRANSIENT,
    Catalogue,
    catalogue,
    fitted,
    lone_moment,
)
from stickslip.studies.burridge_knopoff.power_law import PowerLaw
from stickslip.studies.figures import PaperFigure

# Figure 1: slips of a chain in space and time, and how they keep up with the belt.
SHOWN: Final = 4.0  # travel of the belt


def compute_slips() -> Catalogue:
    """Follow the stiff chain on the faster belt."""
    return catalogue(STIFF, SPEEDS[0])


def draw_slips(data: Catalogue, figure: Figure) -> None:
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


def describe_slips(data: Catalogue) -> str:
    """Describe the picture."""
    return (
        f"A periodic chain of {BLOCKS} equal blocks, alpha = {data.alpha:g}, V = {data.V:g}. "
        "(a) Blocks that take part in each slip, at its start; slips of the whole chain in red. "
        "(b) Slip summed over all events, a block's mean: steps are the slips of the whole chain."
    )


# Figure 2: how many slips are larger than a given size.
MOTIONS: Final = ((STIFF, SPEEDS[0]), (STIFF, SPEEDS[1]), (SOFT, SPEEDS[0]))
COLOURS: Final = ("blue", "vermillion", "green")


@dataclass(frozen=True)
class Sizes:
    """Slips of three motions and the power laws of their local ones."""

    catalogues: tuple[Catalogue, ...]
    laws: tuple[PowerLaw, ...]


def compute_sizes() -> Sizes:
    """Follow all three."""
    return Sizes(
        tuple(catalogue(*motion) for motion in MOTIONS),
        tuple(fitted(*motion) for motion in MOTIONS),
    )


def draw_sizes(data: Sizes, figure: Figure) -> None:
    """Draw the share of local slips above each moment, and the fitted power laws."""
    ax = figure.add_subplot()
    for found, law, name in zip(data.catalogues, data.laws, COLOURS, strict=True):
        moments = np.sort(found.local)
        share = 1.0 - np.arange(moments.size) / moments.size
        label = rf"$\alpha={found.alpha:g}$, $V={found.V:g}$"
        ax.step(moments, share, where="pre", color=PALETTE[name], lw=0.9, label=label)
        if found.alpha == STIFF:
            line = np.array([law.smallest, moments[-1]])
            height = law.n / moments.size
            ax.plot(line, height * law.share_above(line), "--", color=PALETTE["black"], lw=0.8)
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_ylim(bottom=1e-4)
    ax.set_xlabel("moment")
    ax.set_ylabel("share of larger local slips")
    ax.legend(loc="lower left")


def describe_sizes(data: Sizes) -> str:
    """Give the exponents."""
    told = " and ".join(
        f"{law.exponent:.2f} +- {law.error:.2f} (V = {found.V:g})"
        for found, law in zip(data.catalogues, data.laws, strict=True)
        if found.alpha == STIFF
    )
    return (
        "Share of local slips (more than one block, not all) whose moment is larger. Dashed: power "
        f"laws fitted to the stiff chain; exponents of the density {told}. With springs of equal "
        "stiffness, alpha = 1, the decay is exponential."
    )


# Figure 3: what remains of the belt's speed as it goes to zero.
@dataclass(frozen=True)
class SlowBelt:
    """Excess of a lone slip's moment over its limit, and overlaps of slips, by speed."""

    V: Floats
    excess: Floats
    chain_excess: Floats
    overlap: Floats


def compute_overlap() -> SlowBelt:
    """Integrate lone slips at many speeds, and take those of the chain at two."""
    V, limit = np.geomspace(1e-4, 3e-2, 26), lone_moment(STIFF, 0.0)
    found = [catalogue(STIFF, speed) for speed in SPEEDS]
    return SlowBelt(
        V,
        np.array([lone_moment(STIFF, speed) for speed in V.tolist()]) / limit - 1.0,
        np.array([np.median(item.lone) for item in found]) / limit - 1.0,
        np.array([item.overlap for item in found]),
    )


def draw_overlap(data: SlowBelt, figure: Figure) -> None:
    """Draw both against the speed."""
    ax = figure.add_subplot()
    ax.loglog(data.V, data.excess, color=PALETTE["blue"], label="lone slip: one block")
    ax.loglog(SPEEDS, data.chain_excess, "o", color=PALETTE["blue"], label="lone slip: chain")
    ax.loglog(SPEEDS, data.overlap, "s", color=PALETTE["vermillion"], label="overlap in time")
    ax.set_xlabel("$V$")
    ax.set_ylabel("excess of moment; share of time")
    ax.legend(loc="lower right")


def describe_overlap(data: SlowBelt) -> str:
    """Describe the picture."""
    return (
        f"alpha = {STIFF:g}. Blue: by how much of it the moment of a block that slips alone "
        "exceeds its limit V -> 0; line: integration of one block, dots: slips of the chain. Red: "
        "share of the time of all slips that passes while another one goes on."
    )


FIGURES: Final = {
    1: PaperFigure("two", 4.2, compute_slips, draw_slips, describe_slips),
    2: PaperFigure("one", 3.4, compute_sizes, draw_sizes, describe_sizes),
    3: PaperFigure("one", 2.8, compute_overlap, draw_overlap, describe_overlap),
}
