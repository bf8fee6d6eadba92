"""Figure 17: transient motions on both sides of the cusp of the map, law (9), alpha = 1.208."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.motion import draw_portrait, sample_times, stick_interval
from stickslip.plot.style import PALETTE, panel_letter

TITLE: Final = "Transient motions left and right of the cusp, alpha = 1.208"
COLUMNS: Final = "two"
HEIGHT: Final = 2.9

STARTS: Final = (0.3812, 0.3818)
BLOCK: Final = 2
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
class Data:
    """The model and its two transients."""

    model: TwoBlock
    transients: tuple[Transient, ...]


def compute() -> Data:
    """Follow block 2 from each onset until it sticks."""
    model = examples.law9()
    return Data(model, tuple(_transient(model, d) for d in STARTS))


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


def draw(data: Data, figure: Figure) -> None:
    """Draw both phase portraits with the stick interval and the end of the motion."""
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, letter, one in zip(axes, "ab", data.transients, strict=True):
        draw_portrait(ax, one.x, one.v, block=BLOCK, V=data.model.V, interval=one.interval)
        ax.plot(one.x[-1], one.v[-1], "o", ms=3.5, color=PALETTE["blue"], zorder=4)
        panel_letter(ax, letter)
    axes[1].set_ylabel("")


def caption(data: Data) -> str:
    """Describe the two motions."""
    first, second = data.transients
    return (
        f"Phase portraits of block 2 for alpha = {data.model.alpha:g} from the end of a global "
        f"stick phase (a) d = {first.d:g}, (b) d = {second.d:g} to its first stick (dot). Heavy: "
        "the stick interval when the block comes nearest to the belt. In (a) it turns back "
        f"{-first.peak:.2g} below the belt velocity, beside the interval's right end; in (b) it "
        "arrives inside and sticks. At the cusp in between it touches the end itself."
    )
