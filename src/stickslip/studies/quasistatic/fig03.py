"""Figure 3: a sequence of slips of a chaotic pair, and their sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.quasistatic_map import QuasistaticSlips, quasistatic_map
from stickslip.plot.style import PALETTE, panel_letter

TITLE: Final = "Slips of a chaotic pair"
COLUMNS: Final = "two"
HEIGHT: Final = 2.6
SHOWN: Final = 60
SLIPS: Final = 4000
TRANSIENT: Final = 500


@dataclass(frozen=True)
class Data:
    """Slips in their order, and the parameters."""

    slips: QuasistaticSlips
    parameters: dict[str, Any]


def compute() -> Data:
    """Follow one motion of the paper's Coulomb system in the limit V -> 0."""
    f = quasistatic_map(examples.coulomb())
    orbit = f.iterate(0.1, TRANSIENT + SLIPS)[TRANSIENT:-1]
    return Data(f.slips(orbit), f.parameters)


def draw(data: Data, figure: Figure) -> None:
    """Draw moments against the travel of the belt, and how often which moment occurs."""
    axes = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
    travel = np.concatenate(([0.0], np.cumsum(data.slips.wait)))[:SHOWN]
    moment = data.slips.moment
    axes[0].vlines(travel, 0.0, moment[:SHOWN], color=PALETTE["blue"], lw=1.0)
    axes[0].set_xlabel("travel of the belt")
    axes[0].set_ylabel("moment")
    axes[0].set_ylim(bottom=0.0)
    axes[1].hist(moment, bins=80, color=PALETTE["blue"], histtype="stepfilled")
    axes[1].set_xlabel("moment")
    axes[1].set_ylabel("slips")
    for ax, letter in zip(axes, "ab", strict=True):
        panel_letter(ax, letter)


def caption(data: Data) -> str:
    """Describe the picture with its parameters."""
    p = data.parameters
    single = float(np.mean((data.slips.displacement < 1e-12).any(axis=-1)))
    return (
        f"Slips as V -> 0 for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}. "
        f"(a) Moments of {SHOWN} slips over the travel of the belt. (b) Moments of {SLIPS}; "
        f"in {single:.0%} of the slips one block moves alone, by 2 (1 - mu) L / (1 + alpha)."
    )
