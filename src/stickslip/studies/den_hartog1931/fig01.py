"""Figure 1: amplitude of motions without stops over the frequency."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE
from stickslip.studies.den_hartog1931.claims import FREQUENCIES, RATIOS, largest, steady, stops
from stickslip.studies.den_hartog1931.closed_forms import amplitude

TITLE: Final = "Amplitude without stops"
COLUMNS: Final = "one"
HEIGHT: Final = 2.9
COLOURS: Final = ("blue", "vermillion", "green")


@dataclass(frozen=True)
class Data:
    """Amplitude over forcing, (ratios, n): closed form; and event by event at `FREQUENCIES`."""

    frequency: Floats
    closed: Floats
    computed: Floats


def compute() -> Data:
    """Evaluate the closed form, and follow motions that do not stop."""
    frequency = np.concatenate((np.linspace(0.42, 0.995, 300), np.linspace(1.005, 2.4, 300)))
    closed = [[ratio * amplitude(w, 1.0 / ratio) for w in frequency.tolist()] for ratio in RATIOS]
    motions = [[steady(w, 1.0 / ratio) for w in FREQUENCIES] for ratio in RATIOS]
    computed = [
        [ratio * largest(cycle) if stops(cycle) == 0 else np.nan for cycle in row]
        for ratio, row in zip(RATIOS, motions, strict=True)
    ]
    return Data(frequency, np.array(closed), np.array(computed))


def draw(data: Data, figure: Figure) -> None:
    """Draw closed forms as lines and computed motions as circles."""
    ax = figure.add_subplot()
    for row, dots, ratio, name in zip(data.closed, data.computed, RATIOS, COLOURS, strict=True):
        ax.plot(data.frequency, row, color=PALETTE[name], label=f"$f/a={ratio:g}$")
        ax.plot(FREQUENCIES, dots, "o", color=PALETTE[name], mfc="white")
    ax.set_ylim(0.0, 6.0)
    ax.set_xlabel("frequency")
    ax.set_ylabel("amplitude / $a$")
    ax.legend()


def caption(data: Data) -> str:
    """Describe the picture."""
    return (
        "Amplitude over the forcing a without stops, friction f: closed form (lines, which end "
        "where the block begins to stop) and motions followed event by event (circles)."
    )
