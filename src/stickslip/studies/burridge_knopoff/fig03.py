"""Figure 3: what remains of the belt's speed as it goes to zero."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE
from stickslip.studies.burridge_knopoff.facts import SPEEDS, STIFF, catalogue, lone_moment

TITLE: Final = "The limit of a slow belt"
COLUMNS: Final = "one"
HEIGHT: Final = 2.8


@dataclass(frozen=True)
class Data:
    """Excess of a lone slip's moment over its limit, and overlaps of slips, by speed."""

    V: Floats
    excess: Floats
    chain_excess: Floats
    overlap: Floats


def compute() -> Data:
    """Integrate lone slips at many speeds, and take those of the chain at two."""
    V, limit = np.geomspace(1e-4, 3e-2, 26), lone_moment(STIFF, 0.0)
    found = [catalogue(STIFF, speed) for speed in SPEEDS]
    return Data(
        V,
        np.array([lone_moment(STIFF, speed) for speed in V.tolist()]) / limit - 1.0,
        np.array([np.median(item.lone) for item in found]) / limit - 1.0,
        np.array([item.overlap for item in found]),
    )


def draw(data: Data, figure: Figure) -> None:
    """Draw both against the speed."""
    ax = figure.add_subplot()
    ax.loglog(data.V, data.excess, color=PALETTE["blue"], label="lone slip: one block")
    ax.loglog(SPEEDS, data.chain_excess, "o", color=PALETTE["blue"], label="lone slip: chain")
    ax.loglog(SPEEDS, data.overlap, "s", color=PALETTE["vermillion"], label="overlap in time")
    ax.set_xlabel("$V$")
    ax.set_ylabel("excess of moment; share of time")
    ax.legend(loc="lower right")


def caption(data: Data) -> str:
    """Describe the picture."""
    return (
        f"alpha = {STIFF:g}. Blue: by how much of it the moment of a block that slips alone "
        "exceeds its limit V -> 0; line: integration of one block, dots: slips of the chain. Red: "
        "share of the time of all slips that passes while another one goes on."
    )
