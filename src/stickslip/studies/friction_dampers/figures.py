"""Responses of one mass and of a blade, the best friction force, two motions at one frequency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.friction_dampers.claims import (
    BLADE_FORCE,
    FORCES,
    HELD,
    LIGHT_FORCE,
    LOWER,
    SLOW,
    SWEPT,
    blade_responses,
    slipping,
)
from stickslip.studies.friction_dampers.dampers import (
    BEST,
    LEAST,
    LOADS,
    MODEL,
    best,
    blade_peak,
    breaks_loose,
    one_harmonic,
    peak,
    peak_of_one_harmonic,
    response,
    symmetric,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.numerics.arrays import Floats

COLOURS: Final = ("blue", "vermillion", "green", "purple")
RATIO: Final = "frequency / free resonance"


# Figure 1: one mass.
def compute_one() -> tuple[Any, ...]:
    """Exact cycles where the contact slips, and one harmonic."""
    rows = []
    for load in FORCES:
        w = slipping(load, 12)
        fine = np.linspace(0.6, 1.8, 240)
        balanced = [one_harmonic(MODEL, load, f) for f in fine.tolist()]
        rows.append((np.array(w), response(MODEL, load, w)[0], fine, np.array(balanced)))
    return tuple(rows)


def draw_one(data: tuple[Any, ...], figure: Figure) -> None:
    """Draw amplitudes over frequency."""
    ax = figure.add_subplot()
    for (w, exact, fine, balanced), load, name in zip(data, FORCES, COLOURS, strict=True):
        ax.plot(fine, balanced, color=PALETTE[name], lw=0.8, label=rf"$N={load:.3g}$")
        ax.plot(w, exact, "o", color=PALETTE[name], mfc="white", ms=3.0)
    ax.set_xlim(0.6, 1.8)
    ax.set_ylim(0.0, 9.0)
    ax.set_xlabel(RATIO)
    ax.set_ylabel(r"amplitude $\times k / F$")
    ax.legend(loc="upper right")


def describe_one(data: tuple[Any, ...]) -> str:
    """Describe the picture."""
    return (
        "One mass with an elastic friction damper: exact cycles where the contact slips (circles), "
        "and balance of one harmonic (lines), for four friction forces N in units of the force."
    )


# Figure 2: the best friction force.
def compute_best() -> tuple[Floats, Floats]:
    """Evaluate the peak over the friction force."""
    loads = np.linspace(1.0, 4.0, 25)
    return loads, np.array([peak(load)[1] for load in loads.tolist()])


def draw_best(data: tuple[Floats, Floats], figure: Figure) -> None:
    """Draw the peak of one mass, and that of the blade."""
    left, right = figure.subplots(1, 2)
    loads, peaks = data
    fine = np.linspace(0.95, 4.0, 200)
    left.plot(fine, [peak_of_one_harmonic(n) for n in fine.tolist()], color=PALETTE["vermillion"])
    left.plot(loads, peaks, "o", color=PALETTE["blue"], mfc="white", ms=3.0)
    left.plot(BEST, LEAST, "x", color=PALETTE["black"])
    left.set_xlim(0.9, 4.0)
    left.set_ylim(2.5, 8.0)
    left.set_ylabel("largest amplitude")
    rows = np.array([blade_peak(load) for load in LOADS])
    right.semilogy(LOADS, rows[:, 1], "x-", color=PALETTE["vermillion"], label="one harmonic")
    right.semilogy(LOADS, rows[:, 0], "o-", color=PALETTE["blue"], mfc="white", label="exact")
    right.set_xlim(0.8, 6.2)
    right.legend(loc="upper right")
    for ax, letter in ((left, "a"), (right, "b")):
        ax.set_xlabel("friction force / driving force")
        panel_letter(ax, letter)


def describe_best(data: tuple[Floats, Floats]) -> str:
    """Describe the panels."""
    return (
        "Largest amplitude over the friction force, exact (circles) and by one harmonic (red): "
        f"(a) one mass, best at {best()[0]:.4f}; (b) tip of the blade near its first resonance."
    )


# Figure 3: the blade.
def compute_blade() -> tuple[Any, ...]:
    """Sweep the frequency near the first resonance, and far below with little friction."""
    pairs = ((BLADE_FORCE, SWEPT), (LIGHT_FORCE, SLOW))
    return tuple((np.array(swept), *blade_responses(load, swept)) for load, swept in pairs)


def draw_blade(data: tuple[Any, ...], figure: Figure) -> None:
    """Draw amplitudes of the tip."""
    for ax, (w, exact, one, many), letter in zip(figure.subplots(1, 2), data, "ab", strict=True):
        ax.plot(w, one, color=PALETTE["vermillion"], lw=0.9, label="one harmonic")
        ax.plot(w, many, color=PALETTE["black"], lw=0.9, label="odd harmonics up to 15")
        ax.plot(w, exact, "o", color=PALETTE["blue"], mfc="white", ms=2.5, label="exact")
        ax.set_xlim(w[0], w[-1])
        ax.set_ylim(0.0, None)
        ax.set_xlabel("frequency")
        panel_letter(ax, letter)
    figure.axes[0].set_ylabel("amplitude of the tip")
    figure.axes[0].legend(loc="upper right")


def describe_blade(data: tuple[Any, ...]) -> str:
    """Describe the panels."""
    return (
        f"Tip of the blade over the frequency: (a) friction force {BLADE_FORCE:g}, first "
        f"resonance; (b) {LIGHT_FORCE:g}, a third of the first resonance and below."
    )


# Figure 4: two motions at one frequency.
def compute_two() -> list[tuple[float, tuple[float, ...]]]:
    """Solve for all cycles with two slips."""
    frequencies = np.linspace(1.081, 1.5, 120).tolist()
    return [(w, tuple(each.amplitude for each in symmetric(HELD, w, LOWER))) for w in frequencies]


def draw_two(data: list[tuple[float, tuple[float, ...]]], figure: Figure) -> None:
    """Draw amplitudes of the stuck motion and of both cycles."""
    ax = figure.add_subplot()
    large = np.array([(w, a[0]) for w, a in data if a])
    small = np.array([(w, a[1]) for w, a in data if len(a) > 1])
    end = breaks_loose(HELD)
    below = np.linspace(0.9, end, 200)
    ax.axvspan(large[0, 0], end, color=PALETTE["light"], lw=0)
    ax.plot(*large.T, color=PALETTE["blue"], label="slips")
    ax.plot(*small.T, color=PALETTE["blue"], ls=DASHED, label="slips, repels")
    ax.plot(below, 1.0 / (2.0 - below**2), color=PALETTE["black"], label="holds")
    ax.set_xlim(0.9, 1.5)
    ax.set_ylim(0.0, 4.0)
    ax.set_xlabel(RATIO)
    ax.set_ylabel(r"amplitude $\times k / F$")
    ax.legend(loc="upper right")


def describe_two(data: list[tuple[float, tuple[float, ...]]]) -> str:
    """Describe the picture."""
    return (
        f"Friction in motion {LOWER:g} of the static limit {HELD:g}: the contact holds up to "
        f"{math.sqrt(2.0 - 1.0 / HELD):.4f}; in the grey range a jolt makes it slip for good."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.9, compute_one, draw_one, describe_one),
    2: PaperFigure("two", 2.6, compute_best, draw_best, describe_best),
    3: PaperFigure("two", 2.7, compute_blade, draw_blade, describe_blade),
    4: PaperFigure("one", 2.7, compute_two, draw_two, describe_two),
}
