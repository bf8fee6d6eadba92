"""Figure 2: how many slips are larger than a given size."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.plot.style import PALETTE
from stickslip.studies.burridge_knopoff.facts import (
    SOFT,
    SPEEDS,
    STIFF,
    Catalogue,
    catalogue,
    fitted,
)
from stickslip.studies.burridge_knopoff.power_law import PowerLaw

TITLE: Final = "Sizes of slips"
COLUMNS: Final = "one"
HEIGHT: Final = 3.4
MOTIONS: Final = ((STIFF, SPEEDS[0]), (STIFF, SPEEDS[1]), (SOFT, SPEEDS[0]))
COLOURS: Final = ("blue", "vermillion", "green")


@dataclass(frozen=True)
class Data:
    """Slips of three motions and the power laws of their local ones."""

    catalogues: tuple[Catalogue, ...]
    laws: tuple[PowerLaw, ...]


def compute() -> Data:
    """Follow all three."""
    return Data(
        tuple(catalogue(*motion) for motion in MOTIONS),
        tuple(fitted(*motion) for motion in MOTIONS),
    )


def draw(data: Data, figure: Figure) -> None:
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


def caption(data: Data) -> str:
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
