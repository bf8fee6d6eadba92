"""Motions over the force, the answers to a touch, and what smooth friction makes of them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.canards import block
from stickslip.studies.canards.claims import PHASES, WIDTHS
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stickslip.numerics.arrays import Floats

DOTTED: Final = (0, (1, 1.5))
FORCE: Final = "amplitude of the force"
AT_REST: Final = "displacement at rest"
WAITS: Final = (0.3, 0.6, 0.9, 1.2)
SHOWN: Final = (-0.15, -0.1, -0.05, 0.05, *PHASES)


def draw_branches(figure: Figure) -> str:
    """Draw all motions over the force, rest, and harmonic balance."""
    ax = figure.add_subplot()
    ax.fill_between([0.0, 1.0], [1.0, 0.0], color=PALETTE["light"], lw=0)
    ax.text(0.17, 0.35, "rests for ever")
    _draw_exact(ax)
    force = np.linspace(4.0 * block.MU / math.pi, 1.2, 200)
    balance = [block.harmonic_balance(a) for a in force.tolist()]
    ax.plot(force, balance, color=PALETTE["green"], ls=DOTTED, label="harmonic balance")
    ax.set(xlim=(0.0, 1.2), ylim=(0.0, 1.9), xlabel=FORCE, ylabel=AT_REST)
    ax.legend(loc="upper left")
    return (
        f"Displacement between slips of the shaken block over the force, mu = {block.MU:g}, "
        f"frequency {block.FREQUENCY:g}; grey: it rests. The branch of motions that repel begins "
        f"at {block.onset().force:.6f} and ends at {block.touching().force:.6f} (dot); canards "
        "lead from there to rest at force 1."
    )


def _draw_exact(ax: Axes) -> None:
    """Draw the closed forms along the time of a slip."""
    least, end = block.onset().slip, block.touching().slip
    blue, red = PALETTE["blue"], PALETTE["vermillion"]
    ax.plot(*_curve(block.regular, least, 4.4, 200), color=blue, label="attracts")
    ax.plot(*_curve(block.regular, end, least, 100), color=blue, ls=DASHED, label="repels")
    ax.plot(*_curve(block.canard, 0.05, end, 100), color=red, label="canards")
    ax.plot(
        block.touching().force, block.touching().x, "o", color=PALETTE["black"], ms=4.0, zorder=3
    )


def _curve(family: Callable[[float], block.Motion], low: float, high: float, n: int) -> Floats:
    """Return forces and displacements of a family of motions, by the time of their slips."""
    motions = [family(slip) for slip in np.linspace(low, high, n).tolist()]
    return np.array([(motion.force, motion.x) for motion in motions]).T


def draw_answers(figure: Figure) -> str:
    """Draw the needed force at rest that touches its limit, and what may follow."""
    force, moves = figure.subplots(1, 2)
    phase = np.linspace(-0.5 * math.pi, 0.7 * math.pi, 1201)
    force.plot(phase, block.GIVEN * np.cos(phase) + 1.0 - block.GIVEN, color=PALETTE["black"])
    for level, label in ((1.0, "limit at rest"), (block.MU, "friction in motion")):
        force.axhline(level, color=PALETTE["grey"], ls=DASHED)
        force.text(-0.7, level + 0.03, label, color=PALETTE["grey"])
    force.plot(0.0, 1.0, "o", color=PALETTE["blue"])
    for wait in WAITS:
        force.plot(
            wait, block.GIVEN * math.cos(wait) + 1.0 - block.GIVEN, "o", color=PALETTE["vermillion"]
        )
    force.set(ylim=(-0.3, 1.2), ylabel="force needed for rest")
    for wait in WAITS:
        moves.plot(phase, _waiting(wait, phase), color=PALETTE["vermillion"])
    moves.axhline(block.GIVEN - 1.0, color=PALETTE["black"], ls=DASHED)
    engine = block.from_rest(0.0).x((phase + 0.5 * math.pi) / block.FREQUENCY)[:, 0]
    moves.plot(phase, engine, color=PALETTE["blue"])
    moves.set_ylabel("displacement")
    for ax, letter in zip((force, moves), "ab", strict=True):
        ax.set(xlim=(-0.5 * math.pi, 0.7 * math.pi), xlabel="phase of the force")
        panel_letter(ax, letter)
    return (
        f"From rest at {block.GIVEN - 1.0:g} with force {block.GIVEN:g}: (a) the needed force "
        "touches the limit; (b) the exact motion as it is followed (blue), rest (dashed), and "
        f"slips after waits of {', '.join(map(str, WAITS))} (red), which obey the law of friction "
        "except that they begin below the limit."
    )


def _waiting(wait: float, phase: Floats) -> Floats:
    """Displacements of a block that slips at a phase, up to where it comes to rest."""
    motion = block.Motion(0.0, block.GIVEN, 1.0 - block.GIVEN, wait)
    time = np.maximum(phase - wait, 0.0) / block.FREQUENCY
    x = np.where(time > 0.0, motion.at(time), -motion.x)
    return np.asarray(np.maximum.accumulate(x))


def draw_smooth(figure: Figure) -> str:
    """Draw exact branches, and points of those that smooth friction has instead."""
    ax = figure.add_subplot()
    _draw_exact(ax)
    for width, mark, name in zip(WIDTHS, ("v", "s", "+"), ("grey", "green", "black"), strict=True):
        row = [block.smooth_canard(phase, width) for phase in SHOWN]
        at = np.array([(each.force, each.x) for each in row]).T
        ax.plot(*at, mark, color=PALETTE[name], ms=3.5, label=f"smooth, width {width:g}")
    ax.set(xlim=(0.4, 1.02), ylim=(0.0, 0.75), xlabel=FORCE, ylabel=AT_REST)
    ax.legend(loc="upper right")
    return (
        "With smooth friction one family of motions (points) leads from the branch that repels, "
        "past its end (dot), along the canards to rest. "
        f"Widths of the smooth law: {', '.join(map(str, WIDTHS))}."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.0, draw_branches),
    2: PaperFigure("two", 2.6, draw_answers),
    3: PaperFigure("one", 3.0, draw_smooth),
}
