"""Pictures of how safe attractors are."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from stickslip.plot.bifurcations import parameter_label
from stickslip.plot.style import PALETTE, axes_or_new


def draw_safety(safety: Any, ax: Axes | None = None) -> Axes:
    """Draw the share of a basin that has settled over the steps taken, with two quantiles."""
    ax = axes_or_new(ax)
    steps = safety.settling.steps
    settled = np.arange(1, len(steps) + 1) / max(len(steps), 1)
    ax.step(steps, settled, where="post", color=PALETTE["blue"])
    for share in (0.5, 0.95):
        value, error = safety.settling.quantile(share)
        if np.isfinite([value, error]).all():
            ax.errorbar(value, share, xerr=error, fmt="o", color=PALETTE["vermillion"])
    ax.set_ylim(0.0, 1.02)
    ax.set_xlabel("steps")
    ax.set_ylabel("share of the basin that has settled")
    near = safety.displacement
    ax.set_title(f"basin {safety.share.value:.4g}, displacement {near.size:.4g}", fontsize="small")
    return ax


def draw_safeties(safeties: Any, ax: Axes | None = None) -> Axes:
    """Draw share, displacement and smallest impulse along a parameter, with errors."""
    ax = axes_or_new(ax)
    table = safeties.table()
    drawn = {"share": "blue", "displacement": "vermillion", "impulse": "green", "escaped": "purple"}
    for name, color in drawn.items():
        values, errors = np.abs(table[name]), table[f"{name}_error"]
        if np.isfinite(values).any():
            bars = np.nan_to_num(errors)
            ax.errorbar(table["value"], values, bars, color=PALETTE[color], marker=".", label=name)
    ax.set_ylim(bottom=0.0)
    ax.set_xlabel(parameter_label(safeties.parameter))
    if len(safeties):
        ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, fontsize="small")
    return ax
