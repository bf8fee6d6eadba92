"""The plane of bow place and force, velocities under the bow, and the pitch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.bowed_string.claims import STEPS
from stickslip.studies.bowed_string.string import (
    HEARD,
    KINDS,
    ORDERS,
    PERIOD,
    PERIODS,
    PLACE,
    PLACES,
    SHARES,
    Sound,
    cents,
    cycle,
    largest,
    motion,
    plane,
    smallest,
    stepped,
)
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.numerics.arrays import Floats

MARKS: Final = (("o", "blue"), ("^", "green"), ("x", "vermillion"), (".", "grey"))


# Figure 1: Schelleng's diagram.
def draw_plane(data: tuple[Sound, ...], figure: Figure) -> None:
    """Draw kinds of motion, and both limits."""
    ax = figure.add_subplot()
    for kind, (mark, name) in zip(KINDS, MARKS, strict=True):
        at = [(each.place, each.force) for each in data if each.kind == kind]
        if at:
            ax.plot(*np.array(at).T, mark, color=PALETTE[name], ms=3.5, label=kind)
    fine = np.geomspace(PLACES[0] / 1.1, PLACES[-1] * 1.1, 50)
    ax.loglog(fine, [largest(b) for b in fine.tolist()], color=PALETTE["black"])
    ax.loglog(fine, [smallest(b) for b in fine.tolist()], color=PALETTE["black"], ls=DASHED)
    ax.set_xlim(fine[0], fine[-1])
    ax.set_ylim(0.1, 250.0)
    ax.set_xticks([0.05, 0.1, 0.2], ["0.05", "0.1", "0.2"])
    ax.set_xticks([], minor=True)
    ax.set_xlabel(r"bow place $\beta$")
    ax.set_ylabel(r"bow force $\times\ \mu_s / (Z V)$")
    ax.legend(loc="upper right", ncols=2)


def describe_plane(data: tuple[Sound, ...]) -> str:
    """Describe the picture."""
    return (
        f"What becomes of Helmholtz motion in {PERIODS} periods, over the place and the force of "
        "the bow. Schelleng's limits: maximum (line), minimum (dashed)."
    )


# Figure 2: velocities under the bow.
def compute_motions() -> tuple[tuple[Floats, Floats], ...]:
    """Follow each that can be heard, and keep the last three periods."""
    t = np.linspace(PERIOD * (PERIODS - 3), PERIOD * PERIODS, 2001)
    weights = np.sin(ORDERS * np.pi * PLACE)
    runs = [motion(PLACE, share * largest(PLACE), PERIODS) for share in HEARD.values()]
    return tuple((t - t[0], run.v(t) @ weights) for run in runs)


def draw_motions(data: tuple[tuple[Floats, Floats], ...], figure: Figure) -> None:
    """Draw the velocity of the string at the bow."""
    axes = figure.subplots(1, 3, sharey=True)
    for ax, (t, v), name, letter in zip(axes, data, HEARD, "abc", strict=True):
        ax.plot(t / PERIOD, v, color=PALETTE["blue"], lw=0.7)
        ax.set_xlim(0.0, 3.0)
        ax.set_xlabel("time / period")
        ax.text(0.97, 0.05, name, ha="right", transform=ax.transAxes)
        panel_letter(ax, letter)
    axes[0].set_ylabel("velocity at the bow")


def describe_motions(data: tuple[tuple[Floats, Floats], ...]) -> str:
    """Describe the panels."""
    shares = ", ".join(f"{share:g}" for share in HEARD.values())
    return f"Velocity of the string at the bow (bow speed 1) at {shares} of the largest force."


# Figure 3: pitch.
def compute_pitch() -> tuple[list[float], dict[int, list[Any]]]:
    """Pitch of exact cycles, and of each period with fixed steps."""
    exact = [cents(cycle(share).period) for share in SHARES]
    runs = {n: [[cents(p) for p in stepped(share, n).tolist()] for share in SHARES] for n in STEPS}
    return exact, runs


def draw_pitch(data: tuple[list[float], dict[int, list[Any]]], figure: Figure) -> None:
    """Draw both over the force."""
    ax = figure.add_subplot()
    exact, runs = data
    for (steps, pitches), name, aside in zip(
        runs.items(), ("vermillion", "green"), (-0.008, 0.008), strict=True
    ):
        for k, (share, pitch) in enumerate(zip(SHARES, pitches, strict=True)):
            label = f"{steps} steps a period" if k == 0 else None
            x = np.full(len(pitch), share + aside)
            ax.plot(x, pitch, "_", color=PALETTE[name], ms=6.0, label=label)
    ax.plot(SHARES, exact, "o-", color=PALETTE["blue"], mfc="white", label="exact")
    ax.set_xlim(0.36, 0.74)
    ax.set_xlabel("bow force / its maximum")
    ax.set_ylabel("pitch (cents)")
    ax.legend(loc="upper right")


def describe_pitch(data: tuple[list[float], dict[int, list[Any]]]) -> str:
    """Describe the picture."""
    return (
        "Pitch of Helmholtz motion beside that of the free string: exact cycles, and single "
        "periods with fixed time steps (dashes)."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.3, plane, draw_plane, describe_plane),
    2: PaperFigure("two", 2.3, compute_motions, draw_motions, describe_motions),
    3: PaperFigure("one", 2.7, compute_pitch, draw_pitch, describe_pitch),
}
