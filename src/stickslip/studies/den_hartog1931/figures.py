"""Forced motion against dry friction: amplitudes, the boundary of stops, motions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.den_hartog1931.claims import (
    FREQUENCIES,
    NO_STOP,
    ONE_STOP,
    RATIOS,
    TWO_STOPS,
    boundaries,
    largest,
    steady,
    stops,
)
from stickslip.studies.den_hartog1931.closed_forms import amplitude, stop_boundary
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS: Final = ("blue", "vermillion", "green")
SHOWN: Final = (NO_STOP, ONE_STOP, TWO_STOPS)
POINTS: Final = 1201


def draw_amplitudes(figure: Figure) -> str:
    """Draw amplitudes without stops: closed forms as lines, computed motions as circles."""
    ax = figure.add_subplot()
    frequency = np.concatenate((np.linspace(0.42, 0.995, 300), np.linspace(1.005, 2.4, 300)))
    for ratio, name in zip(RATIOS, COLOURS, strict=True):
        closed = [ratio * amplitude(w, 1.0 / ratio) for w in frequency.tolist()]
        motions = [steady(w, 1.0 / ratio) for w in FREQUENCIES]
        dots = [ratio * largest(cycle) if stops(cycle) == 0 else np.nan for cycle in motions]
        ax.plot(frequency, closed, color=PALETTE[name], label=f"$f/a={ratio:g}$")
        ax.plot(FREQUENCIES, dots, "o", color=PALETTE[name], mfc="white")
    ax.set(ylim=(0.0, 6.0), xlabel="frequency", ylabel="amplitude / $a$")
    ax.legend()
    return (
        "Amplitude over the forcing a without stops, friction f: closed form (lines, which end "
        "where the block begins to stop) and motions followed event by event (circles)."
    )


def draw_boundary(figure: Figure) -> str:
    """Draw where motions begin to stop; circles are found by continuation."""
    ax = figure.add_subplot()
    frequency = np.linspace(0.36, 2.4, 250)
    ratio = np.array([1.0 / stop_boundary(w) for w in frequency.tolist()])
    ax.fill_between(frequency, ratio, color=PALETTE["light"], lw=0)
    ax.plot(frequency, ratio, color=PALETTE["black"])
    for at, change in boundaries().items():
        ax.plot(at, 1.0 / change.value, "o", color=PALETTE["vermillion"], mfc="white")
    ax.text(1.25, 0.3, "no stops", ha="center")
    ax.text(1.6, 0.8, "stops", ha="center")
    ax.set(xlim=(frequency[0], frequency[-1]), ylim=(0.0, 1.0), xlabel="frequency", ylabel="$f/a$")
    return (
        "Friction over forcing below which the block never stops: closed form (line) and the first "
        "stop met by motions continued in the forcing (circles)."
    )


def draw_motions(figure: Figure) -> str:
    """Draw displacements over one period, without stops, with one, with two; stops are bold."""
    axes = figure.subplots(1, len(SHOWN))
    panels = []
    for ax, (frequency, forcing), letter in zip(axes, SHOWN, "abc", strict=True):
        cycle = steady(frequency, forcing)
        t = np.linspace(0.0, cycle.period, POINTS)
        x, v = cycle.trajectory.x(t)[:, 0], cycle.trajectory.v(t)[:, 0]
        ax.plot(t / cycle.period, x, color=PALETTE["blue"])
        rest = np.where(v == 0.0, x, np.nan)
        ax.plot(t / cycle.period, rest, color=PALETTE["vermillion"], lw=2.2)
        ax.set(xlim=(0.0, 1.0), xlabel="time / period")
        panel_letter(ax, letter)
        told = f"frequency {frequency:g}, a/f = {forcing:g}: {stops(cycle)} stops"
        panels.append(f"({letter}) {told}")
    axes[0].set_ylabel("$X$")
    return f"Displacement in one period of the forcing, stops bold. {'; '.join(panels)}."


FIGURES: Final = {
    1: PaperFigure("one", 2.9, draw_amplitudes),
    2: PaperFigure("one", 2.7, draw_boundary),
    3: PaperFigure("two", 2.3, draw_motions),
}
