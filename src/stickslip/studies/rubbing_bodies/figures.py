"""Sliders upon each other, break-away at a wall, a clutch, and a train of clutches."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.rubbing_bodies import bodies, clutches
from stickslip.studies.rubbing_bodies.claims import MIDDLES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS: Final = ("blue", "vermillion", "green", "purple")


def draw_stacks(figure: Figure) -> str:
    """Draw speeds of sliders upon each other over time, and the rational times."""
    axes = figure.subplots(1, 2)
    for ax, given, letter in zip(axes, (bodies.THROWN, bodies.PULLED), "ab", strict=True):
        run = given.motion()
        t = np.linspace(0.0, run.t[-1], 600)
        dots = np.array([(float(stage.t), *map(float, stage.v)) for stage in bodies.stages(given)])
        for k, label in enumerate(("lower slider", "upper slider")):
            ax.plot(t, run.v(t)[:, k], color=PALETTE[COLOURS[k]], label=label)
            ax.plot(dots[:, 0], dots[:, k + 1], "o", color=PALETTE["black"], mfc="white", ms=3.0)
        ax.set(xlim=(0.0, t[-1]), ylim=(-0.1, 3.2), xlabel="time")
        panel_letter(ax, letter)
    axes[0].set_ylabel("speed")
    axes[1].legend(loc="upper right")
    return (
        "Speeds of two sliders upon each other: (a) the upper one is thrown, (b) the lower one is "
        "pulled away. Circles: events in rational numbers."
    )


def draw_walled(figure: Figure) -> str:
    """Draw the force of break-away at a wall over friction, and creep of smooth bodies."""
    left, right = figure.subplots(1, 2)
    fine = np.linspace(0.0, 1.0, 201)
    left.plot(fine, [bodies.mechanism(f)[0] for f in fine.tolist()], color=PALETTE["black"])
    found = [bodies.break_away(f)[0] for f in MIDDLES]
    left.plot(MIDDLES, found, "o", color=PALETTE["blue"], mfc="white")
    left.text(0.28, 0.72, "lower one alone", rotation=0)
    left.text(0.55, 1.03, "both")
    left.set_xlim(0.0, 1.0)
    left.set_ylim(0.55, 1.12)
    left.set_xlabel("friction between the sliders")
    left.set_ylabel("force at which something moves")
    for run, name in zip(bodies.creeping(), COLOURS, strict=False):
        label = rf"$\varepsilon={run.width:g}$"
        right.semilogy(run.t[1:], run.x[1:, 0], color=PALETTE[name], label=label)
    right.set(xlim=(0.0, run.t[-1]), ylim=(1e-5, 1e3), xlabel="time", ylabel="displacement")
    right.legend(loc="upper left", ncols=3)
    for ax, letter in ((left, "a"), (right, "b")):
        panel_letter(ax, letter)
    ground, wall, _ = (contact.static for contact in bodies.WALLED.contacts)
    return (
        f"Two sliders and a wall (friction {ground:g} and {wall:g}): (a) force at which something "
        f"moves; (b) creep of smooth friction at {bodies.HELD:g} of that force, where the exact "
        "displacement is 0."
    )


def draw_clutch(figure: Figure) -> str:
    """Draw the slip of a clutch over time: exact, and with smooth friction."""
    ax = figure.add_subplot()
    for run, name in zip(clutches.smooth_clutches(), COLOURS, strict=False):
        label = rf"$\varepsilon={run.width:g}$"
        ax.semilogy(run.t, run.v[:, 0] - run.v[:, 1], color=PALETTE[name], label=label)
        ax.axhline(clutches.CLUTCH.slip(run.width), color=PALETTE["grey"], lw=0.6, ls=DASHED)
    before = clutches.CLUTCH.lock * (1.0 - np.geomspace(1e-6, 1.0, 400)[::-1])
    t = np.append(before, [clutches.CLUTCH.lock, clutches.WATCHED])
    slip = -np.diff(clutches.CLUTCH.motion(clutches.WATCHED).v(t))[:, 0]
    slips = slip > 1e-5
    ax.semilogy(t[slips], slip[slips], color=PALETTE["black"], label="exact")
    ax.set(
        xlim=(0.0, clutches.WATCHED), ylim=(1e-5, 5.0), xlabel="time", ylabel="slip of the clutch"
    )
    ax.legend(loc="lower right")
    return (
        f"A clutch closes: its slip is 0 from {clutches.CLUTCH.lock:g} on, exactly; with smooth "
        "friction it keeps the slip of a formula (dashed) for ever."
    )


def draw_train(figure: Figure) -> str:
    """Draw speeds of the train's inertias over time, and a part of it with published values."""
    t = np.linspace(0.0, clutches.END, 1501)
    v = np.array([clutches.train().speeds(s) for s in t.tolist()])
    left, right = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    for ax in (left, right):
        for k in range(4):
            colour, label = PALETTE[COLOURS[k]], f"inertia {k + 1}"
            ax.plot(t, v[:, k], color=colour, label=label, zorder=3.0 - 0.1 * k)
        ax.set_xlabel("time")
    for time, _, _ in clutches.train().events:
        left.axvline(time, color=PALETTE["light"], lw=0.6, zorder=0)
    left.set(xlim=(0.0, clutches.END), ylim=(-0.2, 10.2), ylabel="speed")
    left.legend(loc="upper right")
    rows = np.array(clutches.MWORKS_ROWS)
    for k, mark in ((1, "s"), (2, "o")):
        colour = PALETTE[COLOURS[k + 1]]
        right.plot(rows[:, 0], rows[:, k], mark, color=colour, mfc="white", ms=3.0)
    right.set(xlim=(1.139, 1.197), ylim=(2.425, 2.475))
    for ax, letter in ((left, "a"), (right, "b")):
        panel_letter(ax, letter)
    return (
        "CoupledClutches: speeds of four inertias, events at the grey lines. (b) as clutch 3 "
        "closes: the exact speeds 3 and 4 become one; as published from MWorks 2016 (squares: "
        "inertia 3, circles: 4) they stay apart."
    )


FIGURES: Final = {
    1: PaperFigure("two", 2.4, draw_stacks),
    2: PaperFigure("two", 2.6, draw_walled),
    3: PaperFigure("one", 2.7, draw_clutch),
    4: PaperFigure("two", 2.8, draw_train),
}
