"""The plane of bow place and force, velocities under the bow, and the pitch."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.bowed_string import string
from stickslip.studies.bowed_string.claims import STEPS
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKS: Final = (("o", "blue"), ("^", "green"), ("x", "vermillion"), (".", "grey"))


def draw_plane(figure: Figure) -> str:
    """Draw Schelleng's diagram: kinds of motion, and both limits."""
    ax = figure.add_subplot()
    for kind, (mark, name) in zip(string.KINDS, MARKS, strict=True):
        at = [(each.place, each.force) for each in string.plane() if each.kind == kind]
        if at:
            ax.plot(*np.array(at).T, mark, color=PALETTE[name], ms=3.5, label=kind)
    fine = np.geomspace(string.PLACES[0] / 1.1, string.PLACES[-1] * 1.1, 50)
    ax.loglog(fine, [string.largest(b) for b in fine.tolist()], color=PALETTE["black"])
    ax.loglog(fine, [string.smallest(b) for b in fine.tolist()], color=PALETTE["black"], ls=DASHED)
    ax.set(xlim=(fine[0], fine[-1]), ylim=(0.1, 250.0))
    ax.set_xticks([0.05, 0.1, 0.2], ["0.05", "0.1", "0.2"])
    ax.set_xticks([], minor=True)
    ax.set(xlabel=r"bow place $\beta$", ylabel=r"bow force $\times\ \mu_s / (Z V)$")
    ax.legend(loc="upper right", ncols=2)
    return (
        f"What becomes of Helmholtz motion in {string.PERIODS} periods, over the place and the "
        "force of the bow. Schelleng's limits: maximum (line), minimum (dashed)."
    )


def draw_motions(figure: Figure) -> str:
    """Draw the velocity under the bow of all that can be heard, over the last three periods."""
    axes = figure.subplots(1, 3, sharey=True)
    t = np.linspace(string.PERIOD * (string.PERIODS - 3), string.PERIOD * string.PERIODS, 2001)
    weights = np.sin(string.ORDERS * np.pi * string.PLACE)
    for ax, (name, share), letter in zip(axes, string.HEARD.items(), "abc", strict=True):
        v = (
            string.motion(string.PLACE, share * string.largest(string.PLACE), string.PERIODS).v(t)
            @ weights
        )
        ax.plot((t - t[0]) / string.PERIOD, v, color=PALETTE["blue"], lw=0.7)
        ax.set(xlim=(0.0, 3.0), xlabel="time / period")
        ax.text(0.97, 0.05, name, ha="right", transform=ax.transAxes)
        panel_letter(ax, letter)
    axes[0].set_ylabel("velocity at the bow")
    shares = ", ".join(f"{share:g}" for share in string.HEARD.values())
    return f"Velocity of the string at the bow (bow speed 1) at {shares} of the largest force."


def draw_pitch(figure: Figure) -> str:
    """Draw the pitch of exact cycles, and of each period with fixed steps, over the force."""
    ax = figure.add_subplot()
    for steps, name, aside in zip(STEPS, ("vermillion", "green"), (-0.008, 0.008), strict=True):
        for k, share in enumerate(string.SHARES):
            pitch = [string.cents(period) for period in string.stepped(share, steps).tolist()]
            label = f"{steps} steps a period" if k == 0 else None
            x = np.full(len(pitch), share + aside)
            ax.plot(x, pitch, "_", color=PALETTE[name], ms=6.0, label=label)
    exact = [string.cents(string.cycle(share).period) for share in string.SHARES]
    ax.plot(string.SHARES, exact, "o-", color=PALETTE["blue"], mfc="white", label="exact")
    ax.set(xlim=(0.36, 0.74), xlabel="bow force / its maximum", ylabel="pitch (cents)")
    ax.legend(loc="upper right")
    return (
        "Pitch of Helmholtz motion beside that of the free string: exact cycles, and single "
        "periods with fixed time steps (dashes)."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.3, draw_plane),
    2: PaperFigure("two", 2.3, draw_motions),
    3: PaperFigure("one", 2.7, draw_pitch),
}
