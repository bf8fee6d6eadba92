"""Figure 7: steady motions of block 2 of the Coulomb system before and after the collision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.motion import draw_portrait, sample_times
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.galvanetto2001.orbits import attracting_orbits

TITLE: Final = "Steady motions of block 2, before and after the collision"
COLUMNS: Final = "two"
HEIGHT: Final = 2.9

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


def compute() -> tuple[Steady, ...]:
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


def draw(data: tuple[Steady, ...], figure: Figure) -> None:
    """Draw both phase portraits; heavy where the block rides in the stick interval."""
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, letter, one in zip(axes, "ab", data, strict=True):
        draw_portrait(ax, one.x, one.v, block=BLOCK, V=one.model.V, linewidth=0.6)
        _enlarge(ax, one)
        panel_letter(ax, letter)
    axes[1].set_ylabel("")


def _enlarge(ax: Axes, one: Steady) -> None:
    """Show in an inset how the small lobe meets the belt's velocity."""
    inset = ax.inset_axes((0.36, 0.50, 0.30, 0.36))
    draw_portrait(inset, one.x, one.v, block=BLOCK, V=one.model.V, linewidth=0.6)
    inset.set(xlabel="", ylabel="", xlim=LOBE[0], ylim=LOBE[1])
    inset.set(xticks=(0.01, 0.03), yticks=(0.02, 0.03))
    inset.tick_params(labelsize=6.5)
    ax.indicate_inset_zoom(inset, edgecolor=PALETTE["grey"], lw=0.5)


def caption(data: tuple[Steady, ...]) -> str:
    """Describe the two motions."""
    first, second = data
    return (
        f"Phase portraits of block 2 in steady motion: (a) V = {first.model.V:.4f}, period "
        f"{first.period} in global stick phases (S4); (b) V = {second.model.V:.4f}, period "
        f"{second.period}. Heavy: where the block rides on the belt; dashed: the belt's velocity. "
        "Insets enlarge the lobe that grazes it."
    )
