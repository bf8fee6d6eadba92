"""Branches of limit cycles along a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["plot_cycle_branch"]

MARKERS = {"fold": "o", "flip": "s", "neimark_sacker": "^", "branch_point": "x", "hopf": "*"}


def plot_cycle_branch(branch: Any, ax: Axes | None = None) -> Axes:
    """Draw periods along the parameter: solid where the cycle attracts, dashed where not.

    Parameters
    ----------
    branch : CycleBranch
    ax : matplotlib.axes.Axes, optional
        By default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        Bifurcations are marked; a diamond stands where the sequence of modes changes.
    """
    ax = axes_or_new(ax)
    values, periods, stable = branch.values, branch.periods, branch.stable
    for wanted, look in ((True, "-"), (False, "--")):
        # A piece ends with the first cycle of the next, so that the line has no holes.
        shown = stable == wanted
        shown[1:] |= (stable == wanted)[:-1]
        ax.plot(values, np.where(shown, periods, np.nan), look, color=PALETTE["blue"])
    for item in branch.bifurcations:
        marker = MARKERS.get(item.kind, "D")
        ax.plot(item.value, item.cycle.period, marker, color=PALETTE["orange"], ms=5)
    ax.set_xlabel(branch.parameter)
    ax.set_ylabel("period")
    return ax
