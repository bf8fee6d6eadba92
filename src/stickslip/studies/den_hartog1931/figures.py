"""Forced motion against dry friction: amplitudes, the boundary of stops, motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.den_hartog1931.claims import (
    FREQUENCIES,
    NO_STOP,
    ONE_STOP,
    RATIOS,
    TWO_STOPS,
    Boundary,
    boundaries,
    largest,
    steady,
    stops,
)
from stickslip.studies.den_hartog1931.closed_forms import amplitude, stop_boundary
from stickslip.studies.figures import PaperFigure

# Figure 1: amplitude of motions without stops over the frequency.
COLOURS: Final = ("blue", "vermillion", "green")


@dataclass(frozen=True)
class Amplitudes:
    """Amplitude over forcing, (ratios, n): closed form; and event by event at `FREQUENCIES`."""

    frequency: Floats
    closed: Floats
    computed: Floats


def compute_amplitudes() -> Amplitudes:
    """Evaluate the closed form, and follow motions that do not stop."""
    frequency = np.concatenate((np.linspace(0.42, 0.995, 300), np.linspace(1.005, 2.4, 300)))
    closed = [[ratio * amplitude(w, 1.0 / ratio) for w in frequency.tolist()] for ratio in RATIOS]
    motions = [[steady(w, 1.0 / ratio) for w in FREQUENCIES] for ratio in RATIOS]
    computed = [
        [ratio * largest(cycle) if stops(cycle) == 0 else np.nan for cycle in row]
        for ratio, row in zip(RATIOS, motions, strict=True)
    ]
    return Amplitudes(frequency, np.array(closed), np.array(computed))


def draw_amplitudes(data: Amplitudes, figure: Figure) -> None:
    """Draw closed forms as lines and computed motions as circles."""
    ax = figure.add_subplot()
    for row, dots, ratio, name in zip(data.closed, data.computed, RATIOS, COLOURS, strict=True):
        ax.plot(data.frequency, row, color=PALETTE[name], label=f"$f/a={ratio:g}$")
        ax.plot(FREQUENCIES, dots, "o", color=PALETTE[name], mfc="white")
    ax.set_ylim(0.0, 6.0)
    ax.set_xlabel("frequency")
    ax.set_ylabel("amplitude / $a$")
    ax.legend()


def describe_amplitudes(data: Amplitudes) -> str:
    """Describe the picture."""
    return (
        "Amplitude over the forcing a without stops, friction f: closed form (lines, which end "
        "where the block begins to stop) and motions followed event by event (circles)."
    )


# Figure 2: where motions begin to stop.
@dataclass(frozen=True)
class Stops:
    """Closed form f/a over the frequency, and boundaries found by continuation."""

    frequency: Floats
    ratio: Floats
    found: tuple[Boundary, ...]


def compute_boundary() -> Stops:
    """Evaluate the closed form, and continue motions to their first stop."""
    frequency = np.linspace(0.36, 2.4, 250)
    ratio = np.array([1.0 / stop_boundary(w) for w in frequency.tolist()])
    return Stops(frequency, ratio, boundaries())


def draw_boundary(data: Stops, figure: Figure) -> None:
    """Draw the boundary; circles are found by continuation."""
    ax = figure.add_subplot()
    ax.fill_between(data.frequency, data.ratio, color=PALETTE["light"], lw=0)
    ax.plot(data.frequency, data.ratio, color=PALETTE["black"])
    for item in data.found:
        ax.plot(item.frequency, 1.0 / item.forcing, "o", color=PALETTE["vermillion"], mfc="white")
    ax.text(1.25, 0.3, "no stops", ha="center")
    ax.text(1.6, 0.8, "stops", ha="center")
    ax.set_xlim(data.frequency[0], data.frequency[-1])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel("frequency")
    ax.set_ylabel("$f/a$")


def describe_boundary(data: Stops) -> str:
    """Describe the picture."""
    return (
        "Friction over forcing below which the block never stops: closed form (line) and the first "
        "stop met by motions continued in the forcing (circles)."
    )


# Figure 3: motions without stops, with one and with two in each half period.
SHOWN: Final = (NO_STOP, ONE_STOP, TWO_STOPS)
POINTS: Final = 1201


def compute_motions() -> tuple[Cycle, ...]:
    """Find the three motions."""
    return tuple(steady(*pair) for pair in SHOWN)


def draw_motions(data: tuple[Cycle, ...], figure: Figure) -> None:
    """Draw displacements over one period; stops are bold."""
    axes = figure.subplots(1, len(data))
    for ax, cycle, letter in zip(axes, data, "abc", strict=True):
        t = np.linspace(0.0, cycle.period, POINTS)
        x, v = cycle.trajectory.x(t)[:, 0], cycle.trajectory.v(t)[:, 0]
        ax.plot(t / cycle.period, x, color=PALETTE["blue"])
        rest = np.where(v == 0.0, x, np.nan)
        ax.plot(t / cycle.period, rest, color=PALETTE["vermillion"], lw=2.2)
        ax.set_xlim(0.0, 1.0)
        ax.set_xlabel("time / period")
        panel_letter(ax, letter)
    axes[0].set_ylabel("$X$")


def describe_motions(data: tuple[Cycle, ...]) -> str:
    """Describe the panels with their parameters."""
    panels = "; ".join(
        f"({letter}) frequency {w:g}, a/f = {a:g}: {stops(cycle)} stops"
        for letter, (w, a), cycle in zip("abc", SHOWN, data, strict=True)
    )
    return f"Displacement in one period of the forcing, stops bold. {panels}."


FIGURES: Final = {
    1: PaperFigure("one", 2.9, compute_amplitudes, draw_amplitudes, describe_amplitudes),
    2: PaperFigure("one", 2.7, compute_boundary, draw_boundary, describe_boundary),
    3: PaperFigure("two", 2.3, compute_motions, draw_motions, describe_motions),
}
