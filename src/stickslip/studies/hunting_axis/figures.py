"""The map of the axis, its cycle over the integral gain, and motions with bristles."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.hunting_axis.axis import KINETIC, MODEL, axis_map, bristles, hunting
from stickslip.studies.hunting_axis.claims import LIMIT, diagram

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SHOWN: Final = ((2.0, KINETIC, "blue"), (8.0, KINETIC, "green"), (8.0, 1.0, "vermillion"))
UNTIL: Final = 60.0


def draw_maps(figure: Figure) -> str:
    """Draw the map at two gains, and without an excess of friction at rest."""
    ax = figure.add_subplot()
    x = np.linspace(1e-4, 0.06, 301)
    ax.plot(x, x, color=PALETTE["grey"], lw=0.6)
    for gain, mu, name in SHOWN:
        label = f"$k_i={gain:g}$" + (", $F_c=F_s$" if mu == 1.0 else "")
        ax.plot(x, axis_map(gain, mu)(x), color=PALETTE[name], label=label)
        if mu < 1.0:
            ax.plot(*[hunting(gain).distance] * 2, "o", color=PALETTE[name])
    ax.set_xlim(0.0, x[-1])
    ax.set_ylim(0.0, x[-1])
    ax.set_xlabel("distance at a release")
    ax.set_ylabel("distance at the next")
    ax.legend(loc="upper left")
    return (
        f"From one release to the next of the same direction, kinetic friction {KINETIC:g} of the "
        "static limit, and (red) equal to it. Dots: hunting in closed form."
    )


def draw_gains(figure: Figure) -> str:
    """Draw the distance with the orbits found on it, and the period, over the integral gain."""
    left, right = figure.subplots(1, 2)
    gain, found = np.linspace(0.2, 11.0, 200), diagram()
    exact = [hunting(value) for value in gain.tolist()]
    left.plot(gain, [each.distance for each in exact], color=PALETTE["black"])
    for orbit in found.orbits:
        left.plot(-found.values, orbit.points[:, 0], "o", color=PALETTE["blue"], mfc="white")
    left.set(ylim=(0.0, 0.07), ylabel="distance at rest")
    right.semilogy(gain, [each.period for each in exact], color=PALETTE["black"])
    right.set_ylabel("period")
    for ax, letter in zip((left, right), "ab", strict=True):
        ax.axvline(LIMIT, color=PALETTE["grey"], lw=0.6, ls=DASHED)
        ax.set(xlim=(0.0, gain[-1]), xlabel="integral gain $k_i$")
        panel_letter(ax, letter)
    return (
        "Hunting over the integral gain: (a) distance from the target at rest, closed form (line) "
        "and the only orbit of the map (circles); (b) period. Dashed: where the axis would lose "
        "its stability without friction."
    )


def draw_motions(figure: Figure) -> str:
    """Draw positions over time: exact, and with bristles of two stiffnesses."""
    ax = figure.add_subplot()
    exact = simulate(MODEL, [0.0, 0.05, 0.0], [], t_end=UNTIL)
    t = np.linspace(0.0, UNTIL, 3001)
    ax.plot(t, exact.x(t)[:, 1], color=PALETTE["black"], lw=1.6, label="exact")
    for stiffness, name, text in ((1e5, "vermillion", "$10^5$"), (1e2, "blue", "$10^2$")):
        run = bristles(stiffness)
        ax.plot(run.t, run.x, color=PALETTE[name], lw=0.9, label=f"LuGre, stiffness {text}")
    ax.set(xlim=(0.0, UNTIL), ylim=(-0.06, 0.085), xlabel="time", ylabel="position")
    ax.legend(loc="upper right", ncols=3)
    return (
        "Position of the axis from 0.05: exact, and with LuGre's friction of two stiffnesses of "
        "the bristles. Soft ones end the hunting."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.1, draw_maps),
    2: PaperFigure("two", 2.6, draw_gains),
    3: PaperFigure("two", 2.4, draw_motions),
}
