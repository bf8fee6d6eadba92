"""Cycles of the brake over the load, kicks, three laws, and friction made smooth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.mode_coupling.squeal import (
    ABOVE,
    LAWS,
    LONG,
    MODEL,
    SPEED,
    Cycles,
    Smooth,
    amplitudes,
    cycles,
    flutter,
    kicked,
    motion,
    smooth_motions,
    squeal_kick,
    threshold,
    touching_kick,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats

LABEL: Final = r"$\mu k_n / k$"
AMPLITUDE: Final = r"amplitude of $y$ / $V$"
SHOWN: Final = (0.3, 0.9)
CRITICAL: Final = threshold(float(MODEL.damping[0, 0]))


# Figures 1 and 3: cycles over the load, with one law and with three.
@dataclass(frozen=True)
class Amplitudes:
    """Amplitude over the load of all cycles of a law."""

    cycles: Cycles
    amplitude: Floats


def compute_amplitudes(law: str = "constant") -> Amplitudes:
    """Follow each cycle of the curve for a period."""
    found = cycles(law)
    return Amplitudes(found, amplitudes(found.curve))


def _draw_branch(ax: Axes, data: Amplitudes, colour: str, label: str | None = None) -> None:
    curve = data.cycles.curve
    for chosen, dashes in ((curve.stable, "-"), (~curve.stable, DASHED)):
        # A row of the other kind on either side, so that lines meet.
        wide = chosen | np.roll(chosen, 1) | np.roll(chosen, -1)
        y = np.where(wide, data.amplitude, np.nan)
        ax.plot(curve.values, y, color=PALETTE[colour], ls=dashes, label=label)
        label = None


def _set_axes(ax: Axes) -> None:
    ax.set_xlim(*SHOWN)
    ax.set_ylim(0.0, 11.0)
    ax.set_xlabel(LABEL)
    ax.set_ylabel(AMPLITUDE)


def draw_branch(data: Amplitudes, figure: Figure) -> None:
    """Draw cycles and steady sliding; solid lines attract."""
    ax = figure.add_subplot()
    onset = data.cycles.onset.value
    ax.axvspan(onset, CRITICAL, color=PALETTE["light"], lw=0)
    ax.plot([SHOWN[0], CRITICAL], [0.0, 0.0], color=PALETTE["black"], clip_on=False)
    ax.plot([CRITICAL, SHOWN[1]], [0.0, 0.0], color=PALETTE["black"], ls=DASHED)
    ax.plot(CRITICAL, 0.0, "o", color=PALETTE["black"], clip_on=False, zorder=3)
    _draw_branch(ax, data, "blue")
    _set_axes(ax)
    row = data.cycles.onset.row
    ax.plot(onset, data.amplitude[row], "s", color=PALETTE["blue"])
    ax.annotate("onset", (onset, data.amplitude[row]), (-32, -3), textcoords="offset points")
    ax.annotate("flutter", (CRITICAL, 0.0), (6, 5), textcoords="offset points")
    ax.text(0.5 * (onset + CRITICAL), 9.5, "both attract", ha="center")


def describe_branch(data: Amplitudes) -> str:
    """Describe the picture with its parameters."""
    found = data.cycles
    return (
        f"Stick-slip cycles (blue) and steady sliding (black) of the brake, constant friction, "
        f"V = {SPEED:g}; solid: attracts, dashed: repels. The cycle that attracts begins at "
        f"{found.onset.value:.6f}, steady sliding loses its stability at {CRITICAL:.6f}."
    )


@dataclass(frozen=True)
class ThreeLaws:
    """Cycles of the three laws, and the thresholds of steady sliding."""

    branches: tuple[Amplitudes, ...]
    thresholds: tuple[float, ...]


def compute_laws() -> ThreeLaws:
    """Follow the cycles of each law."""
    return ThreeLaws(
        tuple(compute_amplitudes(law) for law in LAWS), tuple(flutter(law).value for law in LAWS)
    )


def draw_laws(data: ThreeLaws, figure: Figure) -> None:
    """Draw cycles of each law, and where steady sliding loses its stability."""
    ax = figure.add_subplot()
    colours = ("blue", "green", "vermillion")
    for branch, critical, name in zip(data.branches, data.thresholds, colours, strict=True):
        ax.plot(critical, 0.0, "o", color=PALETTE[name], clip_on=False, zorder=3)
        _draw_branch(ax, branch, name, branch.cycles.law)
    _set_axes(ax)
    ax.legend(loc="center right", bbox_to_anchor=(1.0, 0.33))


def describe_laws(data: ThreeLaws) -> str:
    """Describe the picture."""
    told = "; ".join(
        f"{branch.cycles.law}: flutter at {critical:.4f}"
        for branch, critical in zip(data.branches, data.thresholds, strict=True)
    )
    return (
        "Cycles with three laws of friction; dots: where steady sliding loses its stability "
        f"({told}). Solid: attracts, dashed: repels."
    )


# Figure 2: how large a kick makes the brake squeal.
KICKED: Final = 0.6
TIMES: Final = np.linspace(0.0, 120.0, 4001)


@dataclass(frozen=True)
class Kicks:
    """Smallest kick that squeals and linear theory's floor, by load; two motions at one load."""

    load: Floats
    edge: Floats
    floor: Floats
    dies: Trajectory
    stays: Trajectory


def compute_kicks() -> Kicks:
    """Bisect at each load."""
    load = np.linspace(0.48, 0.71, 16)
    edge = np.array([squeal_kick(value)[1] for value in load.tolist()])
    floor = np.array([touching_kick(value) for value in load.tolist()])
    middle = squeal_kick(KICKED)[1]
    return Kicks(load, edge, floor, kicked(KICKED, 0.98 * middle), kicked(KICKED, 1.02 * middle))


def draw_kicks(data: Kicks, figure: Figure) -> None:
    """Draw the edge over the load; beside it a motion on either side of it."""
    left, right = figure.subplots(1, 2)
    left.fill_between(data.load, data.edge, 8.0, color=PALETTE["light"], lw=0)
    left.plot(data.load, data.edge, color=PALETTE["blue"])
    left.plot(data.load, data.floor, color=PALETTE["black"], ls=DASHED)
    left.axvline(CRITICAL, color=PALETTE["grey"], lw=0.6)
    left.text(0.61, 5.2, "squeals", ha="center")
    left.text(0.485, 0.7, "slides", ha="left")
    left.set_ylim(0.0, 8.0)
    left.set_xlim(data.load[0], 0.72)
    left.set_xlabel(LABEL)
    left.set_ylabel("kick / $V$")
    y0 = float(data.dies.x(0.0)[1])
    for found, name, text in (
        (data.stays, "vermillion", "1.02 of the edge"),
        (data.dies, "blue", "0.98"),
    ):
        y = (found.x(TIMES)[:, 1] - y0) / SPEED
        right.plot(TIMES, y, color=PALETTE[name], lw=0.7, label=text)
    right.set_ylim(-11.0, 14.5)
    right.set_xlim(0.0, TIMES[-1])
    right.set_xlabel("time")
    right.set_ylabel("$(y - y_0) / V$")
    right.legend(loc="upper left", ncols=2)
    for ax, letter in zip((left, right), "ab", strict=True):
        panel_letter(ax, letter)


def describe_kicks(data: Kicks) -> str:
    """Describe the panels."""
    return (
        "(a) Smallest change of y' that turns steady sliding into squeal (blue), by bisection of "
        f"motions over {LONG:g} time units; dashed: the smallest after which the pad sticks at "
        f"all, by linear theory. Grey: flutter. (b) Two kicks at {KICKED:g}."
    )


# Figure 4: friction made smooth, just above the onset.
def draw_smooth(data: tuple[PeriodicOrbitND, tuple[Smooth, ...]], figure: Figure) -> None:
    """Draw normal displacements of smooth laws over time, and the range of the exact cycle."""
    orbit, runs = data
    axes = figure.subplots(1, 3, sharey=True)
    exact = motion(orbit)
    y = exact.x(np.linspace(0.0, exact.t[-1], 257))[:, 1] / SPEED
    middle = 0.5 * (y.min() + y.max())
    for ax, run, letter in zip(axes, runs[:3], "abc", strict=True):
        ax.axhspan(y.min() - middle, y.max() - middle, color=PALETTE["light"], lw=0)
        ax.plot(run.motion.t, run.motion.x[:, 1] / SPEED - middle, color=PALETTE["blue"], lw=0.4)
        ax.set_xlim(0.0, LONG)
        ax.set_xlabel("time")
        panel_letter(ax, letter)
        ax.text(
            0.97,
            0.95,
            f"$V/\\varepsilon={run.ratio:g}$",
            ha="right",
            va="top",
            transform=ax.transAxes,
        )
    axes[0].set_ylim(-12.0, 13.5)
    axes[0].set_ylabel("$y / V$, from its middle")


def describe_smooth(data: Any) -> str:
    """Describe the panels."""
    load = ABOVE * cycles().onset.value
    _, runs = data
    told = ", ".join(f"{run.ratio:g}" for run in runs[:3])
    return (
        f"Friction -L tanh(w / eps) with V / eps = {told}, from a state of the exact cycle, whose "
        f"range is grey; load {load:.6f}, 1 % above the onset. The widest law lets it die out."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.7, compute_amplitudes, draw_branch, describe_branch),
    2: PaperFigure("two", 2.7, compute_kicks, draw_kicks, describe_kicks),
    3: PaperFigure("one", 2.9, compute_laws, draw_laws, describe_laws),
    4: PaperFigure("two", 2.3, smooth_motions, draw_smooth, describe_smooth),
}
