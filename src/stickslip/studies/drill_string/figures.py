"""Cycles of the drill string over the drive, two motions at one drive, and smooth friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.drill_string.claims import BETWEEN
from stickslip.studies.drill_string.string import (
    BELOW,
    DRIVE,
    DRIVES,
    ELEMENTS,
    LONG,
    RANGE,
    Smooth,
    drive_at,
    hopf,
    long_cycles,
    long_end,
    long_hopf,
    lower_speed,
    period_of,
    rotation,
    smooth_motions,
    stick_end,
    stick_slip,
    turning,
)
from stickslip.studies.figures import PaperFigure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats

SPEED: Final = "speed of the lower disc"


# Figure 1: speeds of the lower disc over the drive.
@dataclass(frozen=True)
class Branches:
    """Largest speeds of both kinds of cycles over their drives, and steady rotation."""

    drive: Floats
    rotation: Floats
    stick: tuple[Floats, Floats]  # drives, largest speeds
    turning: tuple[Floats, Floats, Floats]  # drives, least and largest speeds


def compute_branches() -> Branches:
    """Follow each cycle for a period."""
    drive = np.linspace(*RANGE, 60)
    curve, never = stick_slip(), turning()
    speeds = [lower_speed(each.trajectory) for each in never]
    points = curve.points[:, 0]
    rows = slice(1, -1)  # at the very end the map has no value
    inner = zip(curve.values[rows].tolist(), points[rows].tolist(), strict=True)
    stick = [lower_speed(period_of(*row)).max() for row in inner]
    return Branches(
        drive,
        np.array([rotation(u).w[0] for u in drive.tolist()]),
        (curve.values[rows], np.array(stick)),
        (
            np.array([drive_at(each) for each in never]),
            np.array([w.min() for w in speeds]),
            np.array([w.max() for w in speeds]),
        ),
    )


def draw_branches(data: Branches, figure: Figure) -> None:
    """Draw largest and least speeds; solid lines attract."""
    ax = figure.add_subplot()
    low, end = hopf()[0], stick_end().value
    ax.axvspan(low, end, color=PALETTE["light"], lw=0)
    for chosen, dashes in ((data.drive >= low, "-"), (data.drive <= low, DASHED)):
        u = np.append(data.drive[chosen], low)
        w = np.append(data.rotation[chosen], hopf()[1])
        order = np.argsort(u)
        ax.plot(u[order], w[order], color=PALETTE["black"], ls=dashes)
    u, w = data.stick
    ax.plot(np.append(u, end), np.append(w, data.turning[2][-1]), color=PALETTE["blue"])
    ax.plot([RANGE[0], end], [0.0, 0.0], color=PALETTE["blue"], clip_on=False)
    for w in data.turning[1:]:
        ax.plot(data.turning[0], w, color=PALETTE["blue"], ls=DASHED)
    ax.plot(low, hopf()[1], "o", color=PALETTE["black"])
    ax.set_xlim(*RANGE)
    ax.set_ylim(0.0, 18.0)
    ax.text(0.5 * (low + end), 16.3, "both attract", ha="center")
    ax.set_xlabel("drive")
    ax.set_ylabel(SPEED)


def describe_branches(data: Branches) -> str:
    """Describe the picture."""
    return (
        "Largest and least speeds of the lower disc over the drive: cycles (blue) and steady "
        f"rotation (black); solid: attracts, dashed: repels. Rotation is stable from "
        f"{hopf()[0]:.6f} on, stick-slip ends at {stick_end().value:.6f}."
    )


# Figure 2: both cycles at one drive.
@dataclass(frozen=True)
class Pair:
    """A cycle that sticks and one that never does, at nearly the same drive."""

    sticks: Trajectory
    turns: Cycle


def compute_pair() -> Pair:
    """Take the cycle that never sticks next to the drive, and the other one there."""
    never = min(turning(), key=lambda each: abs(drive_at(each) - BETWEEN))
    point = float(stick_slip().at(**{DRIVE: drive_at(never)}).points[0])
    return Pair(period_of(drive_at(never), point), never)


def draw_pair(data: Pair, figure: Figure) -> None:
    """Draw both in the plane of twist and speed."""
    ax = figure.add_subplot()
    for motion, name, dashes, label in (
        (data.sticks, "blue", "-", "sticks"),
        (data.turns.trajectory, "vermillion", DASHED, "never sticks"),
    ):
        states = motion.x(np.linspace(0.0, motion.t[-1], 513))
        ax.plot(states[:, 0], states[:, 2], color=PALETTE[name], ls=dashes, label=label)
    steady = rotation(drive_at(data.turns)).x
    ax.plot(steady[0], steady[2], "x", color=PALETTE["black"], label="rotation")
    ax.set_ylim(-0.3, 18.0)
    ax.set_xlabel("twist")
    ax.set_ylabel(SPEED)
    ax.legend(loc="upper right", ncols=1)


def describe_pair(data: Pair) -> str:
    """Describe the picture."""
    return (
        f"Drive {drive_at(data.turns):.4f}: the cycle that sticks attracts, steady rotation as "
        "well; the dashed cycle between them repels."
    )


# Figure 3: friction made smooth.
def draw_smooth(data: tuple[float, tuple[Smooth, ...]], figure: Figure) -> None:
    """Draw speeds of the lower disc with three smooth laws."""
    _, runs = data
    axes = figure.subplots(1, 3, sharey=True)
    for ax, run, letter in zip(axes, runs[1:], "abc", strict=True):
        ax.plot(run.motion.t, run.motion.v[:, 2], color=PALETTE["blue"], lw=0.4)
        ax.set_xlim(0.0, LONG)
        ax.set_xlabel("time")
        panel_letter(ax, letter)
        place = {"ha": "right", "va": "top", "transform": ax.transAxes}
        ax.text(0.97, 0.96, rf"$\varepsilon={run.width:g}$", **place)
    axes[0].set_ylim(-0.5, 19.0)
    axes[0].set_ylabel(SPEED)


def describe_smooth(data: tuple[float, tuple[Smooth, ...]]) -> str:
    """Describe the panels."""
    widths = ", ".join(f"{run.width:g}" for run in data[1][1:])
    return (
        f"Friction -L F tanh(w / eps), eps = {widths}, from a state of the exact stick-slip cycle "
        f"at {BELOW:g} of the drive at which it ends."
    )


# Figure 4: many elements.
@dataclass(frozen=True)
class LongString:
    """A string of some elements: largest speeds of its cycles, and a period of the last one."""

    elements: int
    largest: Floats
    t: Floats
    speed: Floats


def compute_long() -> tuple[LongString, ...]:
    """Follow cycles of many elements, and of one, for a period."""
    found = []
    for n in (ELEMENTS, 1):
        motions = [each.trajectory for each in long_cycles(n)]
        speeds = [motion.x(np.linspace(0.0, motion.t[-1], 1001))[:, -1] for motion in motions]
        speed, t = speeds[-1], np.linspace(0.0, motions[-1].t[-1], 1001)
        turn = int(np.argmax(speed))
        largest = np.array([each.max() for each in speeds])
        found.append(LongString(n, largest, t, np.roll(speed, len(speed) // 2 - turn)))
    return tuple(found)


def draw_long(data: tuple[LongString, ...], figure: Figure) -> None:
    """Draw largest speeds over the drive, and a period."""
    over, within = figure.subplots(1, 2, width_ratios=(1.0, 1.3))
    for string, name, dashes in zip(data, ("blue", "vermillion"), ("-", DASHED), strict=True):
        told = "two discs" if string.elements == 1 else f"{string.elements} elements"
        line = {"color": PALETTE[name], "ls": dashes}
        over.plot(DRIVES, string.largest, marker="o", ms=2.5, **line)
        over.plot([long_hopf(string.elements)[0]] * 2, [0.0, 2.0], **line)
        over.plot([long_end(string.elements)] * 2, [0.0, 2.0], **line)
        within.plot(string.t, string.speed, label=told, **line)
    over.set_xlim(15.0, 34.0)
    over.set_xlabel("drive")
    over.set_ylabel("largest " + SPEED)
    within.set_xlim(0.0, data[0].t[-1])
    within.set_xlabel("time")
    within.set_ylabel(SPEED)
    within.legend(loc="upper left")
    for ax, letter in zip((over, within), "ab", strict=True):
        ax.set_ylim(0.0, 14.0)
        panel_letter(ax, letter)


def describe_long(data: tuple[LongString, ...]) -> str:
    """Describe the panels."""
    return (
        f"A string of {data[0].elements} elements and its reduction to two discs: (a) largest "
        "speeds in stick-slip; bars: where rotation becomes stable and where stick-slip ends; "
        f"(b) a period at a drive of {DRIVES[-1]:g}."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.0, compute_branches, draw_branches, describe_branches),
    2: PaperFigure("one", 2.7, compute_pair, draw_pair, describe_pair),
    3: PaperFigure("two", 2.3, smooth_motions, draw_smooth, describe_smooth),
    4: PaperFigure("two", 2.5, compute_long, draw_long, describe_long),
}
