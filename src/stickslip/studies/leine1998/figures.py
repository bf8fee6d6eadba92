"""The stick-slip cycle, and cycles over the damping."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.plot.style import DASHED, PALETTE
from stickslip.studies.figures import PaperFigure
from stickslip.studies.leine1998.claims import DAMPING, MODEL, Cycles, cycles, undamped

# Figure 1: the stick-slip cycle in the plane of displacement and velocity.
POINTS: Final = 1201


def draw_cycle(data: Cycle, figure: Figure) -> None:
    """Draw the cycle, the speed of the belt and steady sliding."""
    ax = figure.add_subplot()
    t = np.linspace(0.0, data.period, POINTS)
    ax.axhline(MODEL.V, color=PALETTE["grey"], lw=0.6, ls=(0, (5, 3)))
    ax.plot(data.trajectory.x(t)[:, 0], data.trajectory.v(t)[:, 0], color=PALETTE["blue"])
    ax.plot(data.model.laws[0].force(MODEL.V), 0.0, "x", color=PALETTE["black"])
    ax.set_xlabel("$X$")
    ax.set_ylabel("$X'$")


def describe_cycle(data: Cycle) -> str:
    """Describe the picture with its parameters."""
    return (
        f"Stick-slip cycle of one block, F = 1/(1 + 3|w|), V = {MODEL.V:g} (dashed), no damping; "
        f"period {data.period:.10f}. Cross: steady sliding, which repels."
    )


# Figure 2: cycles over the damping, from the stick-slip cycle to steady sliding.
SAMPLES: Final = 257


def _amplitude(cycle: Cycle) -> float:
    t = np.linspace(0.0, cycle.period, SAMPLES)
    return float(np.ptp(cycle.trajectory.x(t))) / 2.0


def draw_branch(data: Cycles, figure: Figure) -> None:
    """Draw amplitudes: solid lines attract, dashed ones repel."""
    ax = figure.add_subplot()
    hopf, fold = data.bifurcation("hopf"), data.bifurcation("landing")
    amplitude = np.array([_amplitude(cycle) for cycle in data.branch])
    stable, c = data.branch.stable, data.branch.values
    blue, red = PALETTE["blue"], PALETTE["vermillion"]
    ax.plot(c[stable], amplitude[stable], color=blue)
    ax.plot(c[~stable], amplitude[~stable], color=red, ls=DASHED)
    ax.plot([hopf.value, DAMPING[1]], [0.0, 0.0], color=blue)
    ax.plot([DAMPING[0], hopf.value], [0.0, 0.0], color=red, ls=DASHED)
    ax.plot(hopf.value, 0.0, "o", color=PALETTE["black"])
    ax.plot(fold.value, _amplitude(fold.solution), "s", color=PALETTE["black"])
    ax.annotate("Hopf", (hopf.value, 0.0), (-26, 5), textcoords="offset points")
    ax.annotate("fold", (fold.value, _amplitude(fold.solution)), (6, 3), textcoords="offset points")
    ax.set_xlim(*DAMPING)
    ax.set_xlabel("damping $c$")
    ax.set_ylabel("amplitude of $X$")


def describe_branch(data: Cycles) -> str:
    """Describe the picture."""
    hopf, fold = data.bifurcation("hopf"), data.bifurcation("landing")
    return (
        f"Half the range of X over a cycle against the damping c, V = {MODEL.V:g}; the line at 0 "
        "is steady sliding. Solid: attracts; dashed: repels. The unstable cycle is born at Hopf's "
        f"point c = {hopf.value:.6f} and meets the stick-slip one at c = {fold.value:.6f}, where "
        "the stick has no length left: a discontinuous fold."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.7, undamped, draw_cycle, describe_cycle),
    2: PaperFigure("one", 2.7, cycles, draw_branch, describe_branch),
}
