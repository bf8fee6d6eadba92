"""Responses of one mass and of a blade, the best friction force, two motions at one frequency."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.friction_dampers import claims, dampers

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS: Final = ("blue", "vermillion", "green", "purple")
RATIO: Final = "frequency / free resonance"


def draw_one(figure: Figure) -> str:
    """Draw amplitudes of one mass over frequency: exact where the contact slips, one harmonic."""
    ax = figure.add_subplot()
    fine = np.linspace(0.6, 1.8, 240)
    for load, name in zip(claims.FORCES, COLOURS, strict=True):
        balanced = [dampers.one_harmonic(dampers.MODEL, load, f) for f in fine.tolist()]
        ax.plot(fine, balanced, color=PALETTE[name], lw=0.8, label=rf"$N={load:.3g}$")
        w = claims.slipping(load, 12)
        exact, _ = dampers.response(dampers.MODEL, load, w)
        ax.plot(w, exact, "o", color=PALETTE[name], mfc="white", ms=3.0)
    ax.set(xlim=(0.6, 1.8), ylim=(0.0, 9.0), xlabel=RATIO, ylabel=r"amplitude $\times k / F$")
    ax.legend(loc="upper right")
    return (
        "One mass with an elastic friction damper: exact cycles where the contact slips (circles), "
        "and balance of one harmonic (lines), for four friction forces N in units of the force."
    )


def draw_best(figure: Figure) -> str:
    """Draw the peak of one mass, and that of the blade, over the friction force."""
    left, right = figure.subplots(1, 2)
    fine, loads = np.linspace(0.95, 4.0, 200), np.linspace(1.0, 4.0, 25)
    left.plot(
        fine, [dampers.peak_of_one_harmonic(n) for n in fine.tolist()], color=PALETTE["vermillion"]
    )
    peaks = [dampers.peak(load)[1] for load in loads.tolist()]
    left.plot(loads, peaks, "o", color=PALETTE["blue"], mfc="white", ms=3.0)
    left.plot(dampers.BEST, dampers.LEAST, "x", color=PALETTE["black"])
    left.set(xlim=(0.9, 4.0), ylim=(2.5, 8.0), ylabel="largest amplitude")
    rows = np.array([dampers.blade_peak(load) for load in dampers.LOADS])
    right.semilogy(
        dampers.LOADS, rows[:, 1], "x-", color=PALETTE["vermillion"], label="one harmonic"
    )
    right.semilogy(
        dampers.LOADS, rows[:, 0], "o-", color=PALETTE["blue"], mfc="white", label="exact"
    )
    right.set_xlim(0.8, 6.2)
    right.legend(loc="upper right")
    for ax, letter in ((left, "a"), (right, "b")):
        ax.set_xlabel("friction force / driving force")
        panel_letter(ax, letter)
    return (
        "Largest amplitude over the friction force, exact (circles) and by one harmonic (red): "
        f"(a) one mass, best at {dampers.best()[0]:.4f}; (b) tip of the blade near its first "
        "resonance."
    )


def draw_blade(figure: Figure) -> str:
    """Draw amplitudes of the blade's tip: first resonance, and far below with little friction."""
    pairs = ((claims.BLADE_FORCE, claims.SWEPT), (claims.LIGHT_FORCE, claims.SLOW))
    for ax, (load, w), letter in zip(figure.subplots(1, 2), pairs, "ab", strict=True):
        exact, one, many = claims.blade_responses(load, w)
        ax.plot(w, one, color=PALETTE["vermillion"], lw=0.9, label="one harmonic")
        ax.plot(w, many, color=PALETTE["black"], lw=0.9, label="odd harmonics up to 15")
        ax.plot(w, exact, "o", color=PALETTE["blue"], mfc="white", ms=2.5, label="exact")
        ax.set(xlim=(w[0], w[-1]), ylim=(0.0, None), xlabel="frequency")
        panel_letter(ax, letter)
    figure.axes[0].set_ylabel("amplitude of the tip")
    figure.axes[0].legend(loc="upper right")
    return (
        f"Tip of the blade over the frequency: (a) friction force {claims.BLADE_FORCE:g}, first "
        f"resonance; (b) {claims.LIGHT_FORCE:g}, a third of the first resonance and below."
    )


def draw_two(figure: Figure) -> str:
    """Draw amplitudes of the stuck motion and of both cycles with two slips."""
    ax = figure.add_subplot()
    cycles = [
        (w, dampers.symmetric(claims.HELD, w, claims.LOWER))
        for w in np.linspace(1.081, 1.5, 120).tolist()
    ]
    large = np.array([(w, found[0].amplitude) for w, found in cycles if found])
    small = np.array([(w, found[1].amplitude) for w, found in cycles if len(found) > 1])
    end = dampers.breaks_loose(claims.HELD)
    below = np.linspace(0.9, end, 200)
    ax.axvspan(large[0, 0], end, color=PALETTE["light"], lw=0)
    ax.plot(*large.T, color=PALETTE["blue"], label="slips")
    ax.plot(*small.T, color=PALETTE["blue"], ls=DASHED, label="slips, repels")
    ax.plot(below, 1.0 / (2.0 - below**2), color=PALETTE["black"], label="holds")
    ax.set(xlim=(0.9, 1.5), ylim=(0.0, 4.0), xlabel=RATIO, ylabel=r"amplitude $\times k / F$")
    ax.legend(loc="upper right")
    return (
        f"Friction in motion {claims.LOWER:g} of the static limit {claims.HELD:g}: the contact "
        f"holds up to {math.sqrt(2.0 - 1.0 / claims.HELD):.4f}; in the grey range a jolt makes it "
        "slip for good."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.9, draw_one),
    2: PaperFigure("two", 2.6, draw_best),
    3: PaperFigure("two", 2.7, draw_blade),
    4: PaperFigure("one", 2.7, draw_two),
}
