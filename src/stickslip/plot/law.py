"""Friction characteristics: force over relative velocity, stick included (the paper's figure 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.arguments import Model


def friction_characteristic(
    law: FrictionLaw,
    ax: Axes | None = None,
    *,
    limit: float = 2.0,
    label: str | None = None,
    **line: Any,
) -> Axes:
    """Draw a law for backward and forward slip, with the static interval at zero.

    Parameters
    ----------
    law : FrictionLaw
        Kinetic force over the static limit as a function of slip speed.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    limit : float
        Largest slip speed shown, in units of f_s1 / sqrt(k m).
    label : str, optional
        For the legend.
    **line
        Passed on to ``Axes.plot``.

    Returns
    -------
    matplotlib.axes.Axes
        Force on the block (positive: with the belt) over X' - V.
    """
    ax = axes_or_new(ax)
    speed = np.linspace(0.0, limit, 801)
    (drawn,) = ax.plot(-speed, law.force(speed), label=label, **line)
    ax.plot(
        speed,
        -law.force(speed, forward=True),
        **{"color": drawn.get_color(), "ls": drawn.get_linestyle(), **line},
    )
    ax.plot([0.0, 0.0], [-1.0, 1.0], color="black", lw=1.2, solid_capstyle="projecting")
    ax.axhline(0.0, color=PALETTE["grey"], lw=0.4, zorder=0)
    ax.set_xlim(-limit, limit)
    ax.set_xlabel(r"$\dot{X}-V_{\mathrm{dr}}$")
    ax.set_ylabel(r"$F_{\mathrm{k}}$")
    return ax


def friction_characteristics(model: Model, ax: Axes | None = None, *, limit: float = 2.0) -> Axes:
    """Draw the law of a model, or the laws of its blocks if they differ."""
    ax = axes_or_new(ax)
    one_for_all = len(set(model.laws)) == 1
    for block, law in enumerate(model.laws[:1] if one_for_all else model.laws, start=1):
        label = None if one_for_all else f"block {block}"
        friction_characteristic(law, ax, limit=limit, label=label)
    return ax
