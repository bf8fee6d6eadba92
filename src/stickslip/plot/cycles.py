"""Limit cycles and steady sliding along a parameter."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from stickslip.plot.bifurcations import parameter_label
from stickslip.plot.motion import plot_trajectory
from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import symbol

SAMPLES: Final = 600  # of a cycle
COLORS: Final = tuple(PALETTE[name] for name in ("blue", "orange", "green", "vermillion", "purple"))
MARKERS = {"fold": "o", "flip": "s", "neimark_sacker": "^", "branch_point": "x", "hopf": "*"}


def draw_cycle_curve(curve: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw periods along the parameter: solid where the cycle attracts, dashed where not."""
    ax = axes_or_new(ax)
    _solid_where_stable(ax, curve, curve.data["period"], style)
    for item in curve.bifurcations:
        marker = MARKERS.get(item.kind, "D")
        ax.plot(item.value, item.solution.period, marker, color=PALETTE["orange"], ms=5)
    ax.set_xlabel(parameter_label(curve.parameter))
    ax.set_ylabel("period")
    return ax


def draw_equilibrium_curve(curve: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the largest growth rate along the parameter, with a mark at each Hopf point."""
    ax = axes_or_new(ax)
    _solid_where_stable(ax, curve, curve.multipliers.real.max(axis=1), style)
    for item in curve.bifurcations:
        ax.plot(item.value, 0.0, MARKERS["hopf"], color=PALETTE["orange"], ms=7)
    ax.axhline(0.0, color=PALETTE["grey"], lw=0.7, zorder=1)
    ax.set_xlabel(parameter_label(curve.parameter))
    ax.set_ylabel("largest growth rate")
    return ax


def _solid_where_stable(
    ax: Axes, curve: Any, y: NDArray[np.float64], style: dict[str, Any]
) -> None:
    for wanted, look in ((True, "-"), (False, "--")):
        # A piece ends with the first solution of the next, so that the line has no holes.
        shown = curve.stable == wanted
        shown[1:] |= (curve.stable == wanted)[:-1]
        looks = {"ls": look, "color": PALETTE["blue"], **style}
        ax.plot(curve.values, np.where(shown, y, np.nan), **looks)


def plot_cycle(cycle: Any, ax: Axes | None = None) -> Axes:
    """Draw displacements over one period of a cycle; as `plot_trajectory`."""
    return plot_trajectory(cycle.trajectory, ax)


def plot_cycles(cycles: Iterable[Any], ax: Axes | None = None) -> Axes:
    """Draw limit cycles in the phase plane, a colour each: solid if they attract, else dashed."""
    ax = axes_or_new(ax)
    for color, cycle in zip(itertools.cycle(COLORS), cycles, strict=False):
        t = np.linspace(0.0, cycle.period, SAMPLES)
        x, v = cycle.trajectory.x(t), cycle.trajectory.v(t)
        name = f"period {cycle.period:.6g}"
        for block, label in zip(range(x.shape[1]), (name, *[None] * x.shape[1]), strict=False):
            look = "-" if cycle.stable else "--"
            ax.plot(x[:, block], v[:, block], look, color=color, label=label)
    ax.set(xlabel=symbol("x"), ylabel=symbol("v"))
    return ax


def plot_trapping_ball(ball: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw by how much each return shrinks balls of smaller radius; as `plot_cycles`."""
    ax = axes_or_new(ax)
    radii = np.linspace(0.0, 1.2 * ball.radius, 2)
    ax.plot(radii, ball.rate + ball.curvature * radii, **{"color": PALETTE["blue"], **style})
    ax.plot(ball.radius, ball.contraction, "o", color=PALETTE["blue"])
    ax.axhline(1.0, color=PALETTE["grey"], lw=0.5)
    ax.set(xlabel="radius", ylabel="contraction")
    return ax


def plot_gap(gap: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw a gap of the event map as an interval of d; as `plot_return_region`."""
    ax = axes_or_new(ax)
    ax.plot(gap.d, (gap.value, gap.value), **{"color": PALETTE["vermillion"], "lw": 3.0, **style})
    ax.set(xlabel="$d$", ylabel="parameter")
    return ax


def plot_return_region(region: Any, ax: Axes | None = None) -> Axes:
    """Draw the gaps of the event map over the parameter, the domain of d as a frame."""
    # Bars are differences without a return, lighter where undecided; dotted lines stand where a
    # cycle without global stick begins or ceases to attract.
    ax = axes_or_new(ax)
    domains = np.array(
        [region.model.replace(**{region.parameter: float(p)}).domain for p in region.values]
    )
    for end in domains.T:
        ax.plot(region.values, end, color=PALETTE["black"], lw=0.8)
    step = float(np.ptp(region.values)) / max(len(region.values) - 1, 1)
    for gaps in region.gaps:
        for gap in gaps:
            alpha = 0.8 if gap.shown else 0.3
            ax.bar(
                gap.value,
                gap.d[1] - gap.d[0],
                width=0.8 * step,
                bottom=gap.d[0],
                color=PALETTE["vermillion"],
                alpha=alpha,
            )
    for number in range(len(region.curves)):
        for low, high in region.attracting(number):
            for end in (low, high):
                if region.values[0] < end < region.values[-1]:
                    ax.axvline(end, color=PALETTE["blue"], ls=":", lw=0.8)
    ax.set_xlabel(parameter_label(region.parameter))
    ax.set_ylabel("$d$")
    return ax
