"""Cycles of the drill string over the drive, two motions at one drive, and smooth friction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.drill_string.claims import BETWEEN
from stickslip.studies.drill_string.string import (
    BELOW,
    DRIVE,
    LONG,
    RANGE,
    Smooth,
    Turning,
    hopf,
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

    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats

DASHED: Final = (0, (4, 2))
SPEED: Final = "speed of the lower disc"


def _lower(motion: Trajectory, n: int = 513) -> Floats:
    """Speeds of the lower disc over a motion."""
    return motion.x(np.linspace(0.0, motion.t[-1], n))[:, 2]


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
    curve, cycles = stick_slip(), turning()
    points = curve.points[:, 0]
    rows = slice(1, -1)  # at the very end the map has no value
    inner = zip(curve.values[rows].tolist(), points[rows].tolist(), strict=True)
    stick = [_lower(period_of(*row)).max() for row in inner]
    return Branches(
        drive,
        np.array([rotation(u).w[0] for u in drive.tolist()]),
        (curve.values[rows], np.array(stick)),
        (
            np.array([each.drive for each in cycles]),
            np.array([each.state[2] for each in cycles]),
            np.array([_lower(each.motion).max() for each in cycles]),
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
    turns: Turning


def compute_pair() -> Pair:
    """Take the cycle that never sticks next to the drive, and the other one there."""
    turns = min(turning(), key=lambda each: abs(each.drive - BETWEEN))
    point = float(stick_slip().at(**{DRIVE: turns.drive}).points[0])
    return Pair(period_of(turns.drive, point), turns)


def draw_pair(data: Pair, figure: Figure) -> None:
    """Draw both in the plane of twist and speed."""
    ax = figure.add_subplot()
    for motion, name, dashes, label in (
        (data.sticks, "blue", "-", "sticks"),
        (data.turns.motion, "vermillion", DASHED, "never sticks"),
    ):
        states = motion.x(np.linspace(0.0, motion.t[-1], 513))
        ax.plot(states[:, 0], states[:, 2], color=PALETTE[name], ls=dashes, label=label)
    steady = rotation(data.turns.drive).x
    ax.plot(steady[0], steady[2], "x", color=PALETTE["black"], label="rotation")
    ax.set_ylim(-0.3, 18.0)
    ax.set_xlabel("twist")
    ax.set_ylabel(SPEED)
    ax.legend(loc="upper right", ncols=1)


def describe_pair(data: Pair) -> str:
    """Describe the picture."""
    return (
        f"Drive {data.turns.drive:.4f}: the cycle that sticks attracts, steady rotation as well; "
        "the dashed cycle between them repels."
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


FIGURES: Final = {
    1: PaperFigure("one", 3.0, compute_branches, draw_branches, describe_branches),
    2: PaperFigure("one", 2.7, compute_pair, draw_pair, describe_pair),
    3: PaperFigure("two", 2.3, smooth_motions, draw_smooth, describe_smooth),
}
