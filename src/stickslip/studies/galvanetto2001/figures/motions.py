"""Phase portraits of block 2: steady motions and transients."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.motion import draw_portrait, sample_times, stick_interval
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.galvanetto2001.orbits import attracting_orbits, named

# Figure 7: steady motions of block 2 of the Coulomb system before and after the collision.
VELOCITIES: Final = (0.0366, 0.0370)
BLOCK: Final = 2
LOBE: Final = ((0.0, 0.04), (0.012, 0.042))  # enlarged; our choice


@dataclass(frozen=True)
class Steady:
    """Motion of block 2 over one period of the attractor, in global stick phases."""

    model: TwoBlock
    x: Floats
    v: Floats
    period: int


def compute_steady() -> tuple[Steady, ...]:
    """Follow S4, and the attractor after it, over one period."""
    return tuple(_steady(examples.coulomb(V=V)) for V in VELOCITIES)


def _steady(model: TwoBlock) -> Steady:
    orbit, _ = attracting_orbits(event_map(model))  # the other one is S1
    period = orbit.period
    # A global stick phase lasts at most as long as the belt needs to cross the locus.
    longest = 2.0 * (1.0 + model.beta) / model.V
    motion = simulate(model, d=float(orbit.points[0]), t_end=(period + 1) * longest)
    end = motion.slips[period].start
    phases = motion.t[:-1] < end
    riding = np.asarray(~motion.modes[phases].any(axis=1))
    t = sample_times(np.append(motion.t[:-1][phases], end), per_unit=100.0, riding=riding)
    return Steady(model, motion.x(t)[:, BLOCK - 1], motion.v(t)[:, BLOCK - 1], period)


def draw_steady(figure: Figure) -> str:
    """Draw both phase portraits; heavy where the block rides in the stick interval."""
    data = compute_steady()
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, letter, one in zip(axes, "ab", data, strict=True):
        draw_portrait(ax, one.x, one.v, block=BLOCK, V=one.model.V, linewidth=0.6)
        _enlarge(ax, one)
        panel_letter(ax, letter, rf"$V_{{\mathrm{{dr}}}} = {one.model.V:.4f}$")
    axes[1].set_ylabel("")
    first, second = data
    return (
        f"Phase portraits of block 2 in steady motion for {named(first.model, 'V')}: "
        f"(a) V = {first.model.V:.4f}, period "
        f"{first.period} in global stick phases (S4); (b) V = {second.model.V:.4f}, period "
        f"{second.period}. Heavy: where the block rides on the belt; dashed: the belt's velocity. "
        "Insets enlarge the lobe that grazes it."
    )


def _enlarge(ax: Axes, one: Steady) -> None:
    """Show in an inset how the small lobe meets the belt's velocity."""
    inset = ax.inset_axes((0.36, 0.50, 0.30, 0.36))
    draw_portrait(inset, one.x, one.v, block=BLOCK, V=one.model.V, linewidth=0.6)
    inset.set(xlabel="", ylabel="", xlim=LOBE[0], ylim=LOBE[1])
    inset.set(xticks=(0.01, 0.03), yticks=(0.02, 0.03))
    inset.tick_params(labelsize=6.5)
    ax.indicate_inset_zoom(inset, edgecolor=PALETTE["grey"], lw=0.5)


# Figure 17: transient motions on both sides of the cusp of the map, law (9), alpha = 1.208.
STARTS: Final = (0.3812, 0.3818)
LANDED: Final = 1e-12  # as near to the belt's velocity the block is on it


@dataclass(frozen=True)
class Transient:
    """Motion of block 2 from the onset to its first stick."""

    d: float  # of the global stick phase that ends
    x: Floats
    v: Floats
    peak: float  # largest X' - V after the onset; 0 if that is where the block sticks
    # ends of the stick interval at that moment (it moves with block 1)
    interval: tuple[float, float]


@dataclass(frozen=True)
class Transients:
    """The model and its two transients."""

    model: TwoBlock
    transients: tuple[Transient, ...]


def compute_transients() -> Transients:
    """Follow block 2 from each onset until it sticks."""
    model = examples.law9()
    return Transients(model, tuple(_transient(model, d) for d in STARTS))


def _transient(model: TwoBlock, d: float) -> Transient:
    motion = simulate(model, d=d, until="stick")
    t = _times(motion)
    x, v = motion.x(t), motion.v(t)
    own = v[:, BLOCK - 1]
    rising = np.diff(own) > 0.0
    # The first lobe's top: where the velocity, once it rises, falls again, or the end.
    tops = np.flatnonzero(rising[:-1] & ~rising[1:]) + 1
    top = int(tops[0]) if tops.size else t.size - 1
    interval = stick_interval(model, BLOCK, float(x[top, 2 - BLOCK]))
    peak = float(own[top]) - model.V
    peak = 0.0 if abs(peak) < LANDED else peak
    return Transient(d, x[:, BLOCK - 1], own, peak, interval)


def _times(motion: Trajectory) -> Floats:
    """Sample up to the first stick of the block, its velocity there from the slip before."""
    end = next(e.time for e in motion.events if e.block == BLOCK and e.kind == "stick")
    t = sample_times(np.append(motion.t[motion.t < end], end), per_unit=400.0)
    t[-1] = np.nextafter(end, 0.0)
    return t


def draw_transients(figure: Figure) -> str:
    """Draw both phase portraits with the stick interval and the end of the motion."""
    data = compute_transients()
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, letter, one in zip(axes, "ab", data.transients, strict=True):
        draw_portrait(ax, one.x, one.v, block=BLOCK, V=data.model.V, interval=one.interval)
        ax.plot(one.x[-1], one.v[-1], "o", ms=3.5, color=PALETTE["blue"], zorder=4)
        panel_letter(ax, letter, f"$d = {one.d:g}$")
    axes[1].set_ylabel("")
    first, second = data.transients
    return (
        f"Phase portraits of block 2 for {named(data.model)} from the end of a global "
        f"stick phase (a) d = {first.d:g}, (b) d = {second.d:g} to its first stick (dot). Heavy: "
        "the stick interval when the block comes nearest to the belt. In (a) it turns back "
        f"{-first.peak:.2g} below the belt velocity, beside the interval's right end; in (b) it "
        "arrives inside and sticks. At the cusp in between it touches the end itself."
    )


FIGURES: Final = {
    7: PaperFigure("two", 2.9, draw_steady),
    17: PaperFigure("two", 2.9, draw_transients),
}
