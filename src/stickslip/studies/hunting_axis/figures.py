"""The map of the axis, its cycle over the integral gain, and motions with bristles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.hunting_axis.axis import (
    KINETIC,
    MODEL,
    Bristles,
    axis_map,
    bristles,
    hunting,
)
from stickslip.studies.hunting_axis.claims import LIMIT, diagram

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.analysis.diagrams.diagram import Diagram
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats

# Figure 1: the map at three gains, and without an excess of friction at rest.
SHOWN: Final = ((2.0, KINETIC, "blue"), (8.0, KINETIC, "green"), (8.0, 1.0, "vermillion"))


def compute_maps() -> tuple[Floats, Floats]:
    """Evaluate each on a grid."""
    x = np.linspace(1e-4, 0.06, 301)
    return x, np.array([axis_map(gain, mu)(x) for gain, mu, _ in SHOWN])


def draw_maps(data: tuple[Floats, Floats], figure: Figure) -> None:
    """Draw the maps and the diagonal."""
    ax = figure.add_subplot()
    x, rows = data
    ax.plot(x, x, color=PALETTE["grey"], lw=0.6)
    for row, (gain, mu, name) in zip(rows, SHOWN, strict=True):
        label = f"$k_i={gain:g}$" + (", $F_c=F_s$" if mu == 1.0 else "")
        ax.plot(x, row, color=PALETTE[name], label=label)
        if mu < 1.0:
            ax.plot(*[hunting(gain).distance] * 2, "o", color=PALETTE[name])
    ax.set_xlim(0.0, x[-1])
    ax.set_ylim(0.0, x[-1])
    ax.set_xlabel("distance at a release")
    ax.set_ylabel("distance at the next")
    ax.legend(loc="upper left")


def describe_maps(data: tuple[Floats, Floats]) -> str:
    """Describe the picture."""
    return (
        f"From one release to the next of the same direction, kinetic friction {KINETIC:g} of the "
        "static limit, and (red) equal to it. Dots: hunting in closed form."
    )


# Figure 2: distance and period over the integral gain.
@dataclass(frozen=True)
class Gains:
    """Closed forms over the gain, and the map's orbits."""

    gain: Floats
    distance: Floats
    period: Floats
    found: Diagram


def compute_gains() -> Gains:
    """Solve for the cycle at each gain, and search for all orbits."""
    gain = np.linspace(0.2, 11.0, 200)
    exact = [hunting(value) for value in gain.tolist()]
    return Gains(
        gain,
        np.array([each.distance for each in exact]),
        np.array([each.period for each in exact]),
        diagram(),
    )


def draw_gains(data: Gains, figure: Figure) -> None:
    """Draw the distance with the orbits found on it, and the period."""
    left, right = figure.subplots(1, 2)
    left.plot(data.gain, data.distance, color=PALETTE["black"])
    for orbit in data.found.orbits:
        left.plot(-data.found.values, orbit.points[:, 0], "o", color=PALETTE["blue"], mfc="white")
    left.set_ylim(0.0, 0.07)
    left.set_ylabel("distance at rest")
    right.semilogy(data.gain, data.period, color=PALETTE["black"])
    right.set_ylabel("period")
    for ax, letter in zip((left, right), "ab", strict=True):
        ax.axvline(LIMIT, color=PALETTE["grey"], lw=0.6, ls=DASHED)
        ax.set_xlim(0.0, data.gain[-1])
        ax.set_xlabel("integral gain $k_i$")
        panel_letter(ax, letter)


def describe_gains(data: Gains) -> str:
    """Describe the panels."""
    return (
        "Hunting over the integral gain: (a) distance from the target at rest, closed form (line) "
        "and the only orbit of the map (circles); (b) period. Dashed: where the axis would lose "
        "its stability without friction."
    )


# Figure 3: exact motion and bristles of two stiffnesses.
UNTIL: Final = 60.0


def compute_motions() -> tuple[Trajectory, tuple[Bristles, ...]]:
    """Start all at the same distance."""
    exact = simulate(MODEL, [0.0, 0.05, 0.0], [], t_end=UNTIL)
    return exact, (bristles(1e2), bristles(1e5))


def draw_motions(data: tuple[Trajectory, tuple[Bristles, ...]], figure: Figure) -> None:
    """Draw positions over time."""
    ax = figure.add_subplot()
    exact, (soft, stiff) = data
    t = np.linspace(0.0, UNTIL, 3001)
    ax.plot(t, exact.x(t)[:, 1], color=PALETTE["black"], lw=1.6, label="exact")
    for run, name, text in ((stiff, "vermillion", "$10^5$"), (soft, "blue", "$10^2$")):
        ax.plot(run.t, run.x, color=PALETTE[name], lw=0.9, label=f"LuGre, stiffness {text}")
    ax.set_xlim(0.0, UNTIL)
    ax.set_ylim(-0.06, 0.085)
    ax.set_xlabel("time")
    ax.set_ylabel("position")
    ax.legend(loc="upper right", ncols=3)


def describe_motions(data: tuple[Trajectory, tuple[Bristles, ...]]) -> str:
    """Describe the picture."""
    return (
        "Position of the axis from 0.05: exact, and with LuGre's friction of two stiffnesses of "
        "the bristles. Soft ones end the hunting."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.1, compute_maps, draw_maps, describe_maps),
    2: PaperFigure("two", 2.6, compute_gains, draw_gains, describe_gains),
    3: PaperFigure("two", 2.4, compute_motions, draw_motions, describe_motions),
}
