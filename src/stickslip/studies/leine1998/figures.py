"""The stick-slip cycle, and cycles over the damping."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE
from stickslip.studies.figures import PaperFigure
from stickslip.studies.leine1998.claims import DAMPING, MODEL, cycles, undamped

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.mechanics.cycle.cycle import Cycle

POINTS: Final = 1201
SAMPLES: Final = 257


def draw_cycle(figure: Figure) -> str:
    """Draw the cycle in displacement and velocity, the speed of the belt and steady sliding."""
    ax, cycle = figure.add_subplot(), undamped()
    t = np.linspace(0.0, cycle.period, POINTS)
    ax.axhline(MODEL.V, color=PALETTE["grey"], lw=0.6, ls=(0, (5, 3)))
    ax.plot(cycle.trajectory.x(t)[:, 0], cycle.trajectory.v(t)[:, 0], color=PALETTE["blue"])
    ax.plot(cycle.model.laws[0].force(MODEL.V), 0.0, "x", color=PALETTE["black"])
    ax.set(xlabel="$X$", ylabel="$X'$")
    return (
        f"Stick-slip cycle of one block, F = 1/(1 + 3|w|), V = {MODEL.V:g} (dashed), no damping; "
        f"period {cycle.period:.10f}. Cross: steady sliding, which repels."
    )


def _amplitude(cycle: Cycle) -> float:
    t = np.linspace(0.0, cycle.period, SAMPLES)
    return float(np.ptp(cycle.trajectory.x(t))) / 2.0


def draw_branch(figure: Figure) -> str:
    """Draw amplitudes over the damping, down to steady sliding; dashed lines repel."""
    ax, data = figure.add_subplot(), cycles()
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
    ax.set(xlim=DAMPING, xlabel="damping $c$", ylabel="amplitude of $X$")
    return (
        f"Half the range of X over a cycle against the damping c, V = {MODEL.V:g}; the line at 0 "
        "is steady sliding. Solid: attracts; dashed: repels. The unstable cycle is born at Hopf's "
        f"point c = {hopf.value:.6f} and meets the stick-slip one at c = {fold.value:.6f}, where "
        "the stick has no length left: a discontinuous fold."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.7, draw_cycle),
    2: PaperFigure("one", 2.7, draw_branch),
}
