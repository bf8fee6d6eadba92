"""Fits: measurements and what the model gives for them, and the residuals below."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from stickslip.identification.data import Record, compared
from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import symbol

# Between the least and the largest positive abscissa, above which their axis is logarithmic.
DECADES = 2.0


def plot_fit(fit: Any, ax: Axes | None = None, *, data: int = 1, **style: Any) -> Axes:
    """Draw a set of data, counted from 1, as black points, the model's values as lines.

    Residuals, in standard errors of the data, stand below, in the last axes of the figure.
    """
    ax = axes_or_new(ax)
    measured = fit.data[data - 1]
    ordinate, at, values, model, sigma = next(compared(measured, fit.fitted[data - 1]))
    abscissa, _ = measured.abscissa
    of_blocks = isinstance(measured, Record)
    labels = [symbol(ordinate, block) for block in measured.blocks] if of_blocks else ["fitted"]
    below = _axes_below(ax)
    below.axhline(0.0, lw=0.6, color=PALETTE["grey"])
    colors = list(PALETTE.values())[1:]  # black are the data
    points: dict[str, Any] = {"marker": ".", "ls": "", "ms": 4, "alpha": 0.4}
    off = (values - model) / (sigma * fit.scale)
    for k, label in enumerate(labels):
        color = colors[k % len(colors)]
        ax.plot(at, values[:, k], color="black", label="" if k else "measured", **points)
        ax.plot(at, model[:, k], **{"color": color, "label": label, **style})
        below.plot(at, off[:, k], color=color if len(labels) > 1 else "black", **points)
    if len(labels) == 1:
        ax.set_ylabel(labels[0] if of_blocks else ordinate)
    ax.tick_params(labelbottom=False)
    below.set(xlabel=symbol("t") if of_blocks else abscissa, ylabel="residual")
    if not of_blocks:
        _set_scale(ax, at)
    ax.legend()
    return ax


def plot_comparison(
    comparison: Any, ax: Axes | None = None, *, data: int = 1, **style: Any
) -> Axes:
    """Draw a set of data, counted from 1, as black points, what each fit gives as a line."""
    ax = axes_or_new(ax)
    measured = comparison.fits[0].data[data - 1]
    colors = list(PALETTE.values())[1:]  # black are the data
    pairs = zip(comparison.law, comparison.fits, strict=True)
    for k, (law, fit) in enumerate(pairs):
        ordinate, at, values, model, _ = next(compared(measured, fit.fitted[data - 1]))
        if not k:
            ax.plot(at, values, color="black", marker=".", ls="", ms=4, alpha=0.4)
        lines = ax.plot(at, model, **{"color": colors[k % len(colors)], **style})
        lines[0].set_label(law)
    ax.set(xlabel=measured.abscissa[0], ylabel=ordinate)
    if not isinstance(measured, Record):
        _set_scale(ax, at)
    ax.legend(fontsize="small")
    return ax


def plot_propagated(found: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the histogram of a quantity that is a number, its median and its 95 per cent."""
    if found.values.ndim > 1:
        raise ValueError(f"a histogram shows numbers, not arrays {found.values.shape[1:]}")
    ax = axes_or_new(ax)
    known = found.values[np.isfinite(found.values)]
    color = list(PALETTE.values())[1]
    ax.hist(known, **{"bins": "auto", "color": color, "alpha": 0.5, **style})
    ax.axvline(found.value, color="black")
    for end in found.interval:
        ax.axvline(end, color="black", ls="--")
    ax.set(xlabel="quantity", ylabel="draws")
    return ax


def _set_scale(ax: Axes, at: Any) -> None:
    """Make the axis of an abscissa logarithmic where its values span decades."""
    positive = at[at > 0.0]
    if len(positive) and np.ptp(np.log10(positive)) > DECADES:
        ax.set_xscale("symlog" if len(positive) < len(at) else "log")


def _axes_below(ax: Axes) -> Axes:
    """Give a quarter of the place of axes to others with the same abscissa."""
    place = ax.get_subplotspec()
    if place is None:
        raise ValueError("ax has no place in a grid for residuals below: take axes of subplots()")
    grid = place.subgridspec(2, 1, height_ratios=(3, 1), hspace=0.08)
    ax.set_subplotspec(grid[0])
    figure = ax.get_figure(root=False)
    assert figure is not None
    return figure.add_subplot(grid[1], sharex=ax)
