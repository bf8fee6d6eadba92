"""Cycles of the brake over the load, kicks, three laws, and friction made smooth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.mode_coupling import squeal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stickslip.analysis.continuation.curve import Curve
    from stickslip.numerics.arrays import Floats

LABEL: Final = r"$\mu k_n / k$"
AMPLITUDE: Final = r"amplitude of $y$ / $V$"
SHOWN: Final = (0.3, 0.9)
CRITICAL: Final = squeal.threshold(float(squeal.MODEL.damping[0, 0]))
KICKED: Final = 0.6
TIMES: Final = np.linspace(0.0, 120.0, 4001)


def _draw_branch(
    ax: Axes, curve: Curve, amplitude: Floats, colour: str, label: str | None = None
) -> None:
    """Draw amplitudes of cycles over the load; dashed lines repel."""
    for chosen, dashes in ((curve.stable, "-"), (~curve.stable, DASHED)):
        # A row of the other kind on either side, so that lines meet.
        wide = chosen | np.roll(chosen, 1) | np.roll(chosen, -1)
        y = np.where(wide, amplitude, np.nan)
        ax.plot(curve.values, y, color=PALETTE[colour], ls=dashes, label=label)
        label = None
    ax.set(xlim=SHOWN, ylim=(0.0, 11.0), xlabel=LABEL, ylabel=AMPLITUDE)


def draw_branch(figure: Figure) -> str:
    """Draw cycles and steady sliding over the load; solid lines attract."""
    ax, found = figure.add_subplot(), squeal.cycles()
    onset, amplitude = found.onset.value, squeal.amplitudes(found.curve)
    ax.axvspan(onset, CRITICAL, color=PALETTE["light"], lw=0)
    ax.plot([SHOWN[0], CRITICAL], [0.0, 0.0], color=PALETTE["black"], clip_on=False)
    ax.plot([CRITICAL, SHOWN[1]], [0.0, 0.0], color=PALETTE["black"], ls=DASHED)
    ax.plot(CRITICAL, 0.0, "o", color=PALETTE["black"], clip_on=False, zorder=3)
    _draw_branch(ax, found.curve, amplitude, "blue")
    least = (onset, amplitude[found.onset.row])
    ax.plot(*least, "s", color=PALETTE["blue"])
    ax.annotate("onset", least, (-32, -3), textcoords="offset points")
    ax.annotate("flutter", (CRITICAL, 0.0), (6, 5), textcoords="offset points")
    ax.text(0.5 * (onset + CRITICAL), 9.5, "both attract", ha="center")
    return (
        f"Stick-slip cycles (blue) and steady sliding (black) of the brake, constant friction, "
        f"V = {squeal.SPEED:g}; solid: attracts, dashed: repels. The cycle that attracts begins at "
        f"{onset:.6f}, steady sliding loses its stability at {CRITICAL:.6f}."
    )


def draw_kicks(figure: Figure) -> str:
    """Draw the least kick that squeals over the load; beside it a motion on either side of it."""
    left, right = figure.subplots(1, 2)
    load = np.linspace(0.48, 0.71, 16)
    edge = [squeal.squeal_kick(value)[1] for value in load.tolist()]
    floor = [squeal.touching_kick(value) for value in load.tolist()]
    left.fill_between(load, edge, 8.0, color=PALETTE["light"], lw=0)
    left.plot(load, edge, color=PALETTE["blue"])
    left.plot(load, floor, color=PALETTE["black"], ls=DASHED)
    left.axvline(CRITICAL, color=PALETTE["grey"], lw=0.6)
    left.text(0.61, 5.2, "squeals", ha="center")
    left.text(0.485, 0.7, "slides", ha="left")
    left.set(ylim=(0.0, 8.0), xlim=(load[0], 0.72), xlabel=LABEL, ylabel="kick / $V$")
    for share, name, text in ((1.02, "vermillion", "1.02 of the edge"), (0.98, "blue", "0.98")):
        found = squeal.kicked(KICKED, share * squeal.squeal_kick(KICKED)[1])
        y = (found.x(TIMES)[:, 1] - float(found.x(0.0)[1])) / squeal.SPEED
        right.plot(TIMES, y, color=PALETTE[name], lw=0.7, label=text)
    right.set(ylim=(-11.0, 14.5), xlim=(0.0, TIMES[-1]), xlabel="time", ylabel="$(y - y_0) / V$")
    right.legend(loc="upper left", ncols=2)
    for ax, letter in zip((left, right), "ab", strict=True):
        panel_letter(ax, letter)
    return (
        "(a) Smallest change of y' that turns steady sliding into squeal (blue), by bisection of "
        f"motions over {squeal.LONG:g} time units; dashed: the smallest after which the pad sticks "
        f"at all, by linear theory. Grey: flutter. (b) Two kicks at {KICKED:g}."
    )


def draw_laws(figure: Figure) -> str:
    """Draw cycles of each law, and where steady sliding loses its stability."""
    ax = figure.add_subplot()
    told = []
    for law, name in zip(squeal.LAWS, ("blue", "green", "vermillion"), strict=True):
        curve, critical = squeal.cycles(law).curve, squeal.flutter(law).value
        ax.plot(critical, 0.0, "o", color=PALETTE[name], clip_on=False, zorder=3)
        _draw_branch(ax, curve, squeal.amplitudes(curve), name, law)
        told.append(f"{law}: flutter at {critical:.4f}")
    ax.legend(loc="center right", bbox_to_anchor=(1.0, 0.33))
    return (
        "Cycles with three laws of friction; dots: where steady sliding loses its stability "
        f"({'; '.join(told)}). Solid: attracts, dashed: repels."
    )


def draw_smooth(figure: Figure) -> str:
    """Draw normal displacements of smooth laws over time, and the range of the exact cycle."""
    orbit, runs = squeal.smooth_motions()
    axes = figure.subplots(1, 3, sharey=True)
    exact = squeal.motion(orbit)
    y = exact.x(np.linspace(0.0, exact.t[-1], 257))[:, 1] / squeal.SPEED
    middle = 0.5 * (y.min() + y.max())
    for ax, run, ratio, letter in zip(axes, runs[:3], squeal.RATIOS[:3], "abc", strict=True):
        ax.axhspan(y.min() - middle, y.max() - middle, color=PALETTE["light"], lw=0)
        ax.plot(run.t, run.x[:, 1] / squeal.SPEED - middle, color=PALETTE["blue"], lw=0.4)
        ax.set(xlim=(0.0, squeal.LONG), xlabel="time")
        panel_letter(ax, letter)
        place = {"ha": "right", "va": "top", "transform": ax.transAxes}
        ax.text(0.97, 0.95, rf"$V/\varepsilon={ratio:g}$", **place)
    axes[0].set(ylim=(-12.0, 13.5), ylabel="$y / V$, from its middle")
    load, told = (
        squeal.ABOVE * squeal.cycles().onset.value,
        ", ".join(f"{ratio:g}" for ratio in squeal.RATIOS[:3]),
    )
    return (
        f"Friction -L tanh(w / eps) with V / eps = {told}, from a state of the exact cycle, whose "
        f"range is grey; load {load:.6f}, 1 % above the onset. The widest law lets it die out."
    )


FIGURES: Final = {
    1: PaperFigure("one", 2.7, draw_branch),
    2: PaperFigure("two", 2.7, draw_kicks),
    3: PaperFigure("one", 2.9, draw_laws),
    4: PaperFigure("two", 2.3, draw_smooth),
}
