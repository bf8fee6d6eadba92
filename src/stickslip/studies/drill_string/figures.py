"""Cycles of the drill string over the drive, two motions at one drive, and smooth friction."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.drill_string import string
from stickslip.studies.drill_string.claims import BETWEEN
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEED: Final = "speed of the lower disc"


def draw_branches(figure: Figure) -> str:
    """Draw largest and least speeds of the lower disc over the drive; solid lines attract."""
    ax = figure.add_subplot()
    low, end = string.hopf()[0], string.stick_end().value
    ax.axvspan(low, end, color=PALETTE["light"], lw=0)
    drive = np.linspace(*string.RANGE, 60)
    turned = np.array([string.rotation(u).w[0] for u in drive.tolist()])
    for chosen, dashes in ((drive >= low, "-"), (drive <= low, DASHED)):
        u, w = np.append(drive[chosen], low), np.append(turned[chosen], string.hopf()[1])
        order = np.argsort(u)
        ax.plot(u[order], w[order], color=PALETTE["black"], ls=dashes)
    curve, rows = string.stick_slip(), slice(1, -1)  # at the very end the map has no value
    drives = curve.values[rows].tolist()
    starts = zip(drives, curve.points[rows, 0].tolist(), strict=True)
    stick = [string.lower_speed(string.period_of(*start)).max() for start in starts]
    never = [
        (string.drive_at(each), string.lower_speed(each.trajectory)) for each in string.turning()
    ]
    ax.plot([*drives, end], [*stick, never[-1][1].max()], color=PALETTE["blue"])
    ax.plot([string.RANGE[0], end], [0.0, 0.0], color=PALETTE["blue"], clip_on=False)
    for extreme in (np.min, np.max):
        speeds = [extreme(w) for _, w in never]
        ax.plot([u for u, _ in never], speeds, color=PALETTE["blue"], ls=DASHED)
    ax.plot(low, string.hopf()[1], "o", color=PALETTE["black"])
    ax.set(xlim=string.RANGE, ylim=(0.0, 18.0))
    ax.text(0.5 * (low + end), 16.3, "both attract", ha="center")
    ax.set(xlabel="drive", ylabel=SPEED)
    return (
        "Largest and least speeds of the lower disc over the drive: cycles (blue) and steady "
        f"rotation (black); solid: attracts, dashed: repels. Rotation is stable from "
        f"{low:.6f} on, stick-slip ends at {end:.6f}."
    )


def draw_pair(figure: Figure) -> str:
    """Draw a cycle that never sticks, and the one that sticks there, in twist and speed."""
    ax = figure.add_subplot()
    turns = min(string.turning(), key=lambda each: abs(string.drive_at(each) - BETWEEN))
    drive = string.drive_at(turns)
    sticks = string.period_of(
        drive, float(string.stick_slip().at(**{string.DRIVE: drive}).points[0])
    )
    for motion, name, dashes, label in (
        (sticks, "blue", "-", "sticks"),
        (turns.trajectory, "vermillion", DASHED, "never sticks"),
    ):
        states = motion.x(np.linspace(0.0, motion.t[-1], 513))
        ax.plot(states[:, 0], states[:, 2], color=PALETTE[name], ls=dashes, label=label)
    steady = string.rotation(drive).x
    ax.plot(steady[0], steady[2], "x", color=PALETTE["black"], label="rotation")
    ax.set(ylim=(-0.3, 18.0), xlabel="twist", ylabel=SPEED)
    ax.legend(loc="upper right", ncols=1)
    return (
        f"Drive {drive:.4f}: the cycle that sticks attracts, steady rotation as well; the dashed "
        "cycle between them repels."
    )


def draw_smooth(figure: Figure) -> str:
    """Draw speeds of the lower disc with three smooth laws."""
    runs = string.smooth_motions()[1][1:]
    axes = figure.subplots(1, 3, sharey=True)
    for ax, run, letter in zip(axes, runs, "abc", strict=True):
        ax.plot(run.t, run.v[:, 2], color=PALETTE["blue"], lw=0.4)
        ax.set(xlim=(0.0, string.LONG), xlabel="time")
        panel_letter(ax, letter)
        place = {"ha": "right", "va": "top", "transform": ax.transAxes}
        ax.text(0.97, 0.96, rf"$\varepsilon={run.width:g}$", **place)
    axes[0].set(ylim=(-0.5, 19.0), ylabel=SPEED)
    return (
        f"Friction -L F tanh(w / eps), eps = {', '.join(f'{run.width:g}' for run in runs)}, from a "
        f"state of the exact stick-slip cycle at {string.BELOW:g} of the drive at which it ends."
    )


def draw_long(figure: Figure) -> str:
    """Draw a string of many elements, and of one: largest speeds over the drive, and a period."""
    over, within = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    for n, name, dashes in ((string.ELEMENTS, "blue", "-"), (1, "vermillion", DASHED)):
        motions = [each.trajectory for each in string.long_cycles(n)]
        speeds = [motion.x(np.linspace(0.0, motion.t[-1], 1001))[:, -1] for motion in motions]
        line = {"color": PALETTE[name], "ls": dashes}
        over.plot(string.DRIVES, [each.max() for each in speeds], marker="o", ms=2.5, **line)
        over.plot([string.long_hopf(n)[0]] * 2, [0.0, 2.0], **line)
        over.plot([string.long_end(n)] * 2, [0.0, 2.0], **line)
        period, last = motions[-1].t[-1], speeds[-1]
        centred = np.roll(last, len(last) // 2 - int(np.argmax(last)))
        told = "two discs" if n == 1 else f"{n} elements"
        within.plot(np.linspace(0.0, period, 1001), centred, label=told, **line)
        if n == string.ELEMENTS:
            within.set_xlim(0.0, period)
    over.set(xlim=(15.0, 34.0), xlabel="drive", ylabel="largest " + SPEED)
    within.set(xlabel="time", ylabel=SPEED)
    within.legend(loc="upper left")
    for ax, letter in zip((over, within), "ab", strict=True):
        ax.set_ylim(0.0, 14.0)
        panel_letter(ax, letter)
    return (
        f"A string of {string.ELEMENTS} elements and its reduction to two discs: (a) largest "
        "speeds in stick-slip; bars: where rotation becomes stable and where stick-slip ends; "
        f"(b) a period at a drive of {string.DRIVES[-1]:g}."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.0, draw_branches),
    2: PaperFigure("one", 2.7, draw_pair),
    3: PaperFigure("two", 2.3, draw_smooth),
    4: PaperFigure("two", 2.5, draw_long),
}
