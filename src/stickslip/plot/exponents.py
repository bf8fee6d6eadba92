"""Lyapunov spectra along a parameter."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from stickslip.plot.bifurcations import parameter_label
from stickslip.plot.style import PALETTE, axes_or_new


def draw_spectra(spectra: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw each exponent over the parameter, with a band of one standard error."""
    ax = axes_or_new(ax)
    ax.axhline(0.0, color=PALETTE["grey"], lw=0.7)
    colors = [color for name, color in PALETTE.items() if name != "grey"]
    for k, (values, errors) in enumerate(zip(spectra.values.T, spectra.errors.T, strict=True)):
        look = {"color": colors[k % len(colors)], "lw": 0.9, "label": rf"$\lambda_{k + 1}$"}
        (line,) = ax.plot(spectra.at, values, **{**look, **style})
        ax.fill_between(
            spectra.at, values - errors, values + errors, color=line.get_color(), alpha=0.3, lw=0
        )
    ax.set_xlabel(parameter_label(spectra.parameter, spectra))
    ax.set_ylabel("exponent per step")
    ax.legend()
    return ax
