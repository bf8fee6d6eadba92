"""Fits: measurements and what the model gives for them."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import symbol

ABSCISSAE = {"Record": "t", "MapPoints": "d", "ForcePoints": "speed", "CyclePeriods": "V"}
ORDINATES = {
    "EventTimes": "times",
    "MapPoints": "value",
    "ForcePoints": "force",
    "CyclePeriods": "period",
}


def plot_fit(fit: Any, ax: Axes | None = None, *, data: int = 1, **style: Any) -> Axes:
    """Draw a set of data, counted from 1, as black points and the model's values as lines."""
    ax = axes_or_new(ax)
    measured, fitted = fit.data[data - 1], fit.fitted[data - 1]
    kind = type(measured).__name__
    if kind == "Record":
        name, values, _ = measured.rows[0]
        rows = fitted[: values.size].reshape(values.shape)
        labels = [symbol(name, block) for block in measured.blocks]
        labelled = (symbol("t"), "" if len(labels) > 1 else labels[0])
    else:
        values = np.asarray(getattr(measured, ORDINATES[kind]))[:, None]
        rows, labels = fitted[:, None], [ORDINATES[kind]]
        labelled = (ABSCISSAE.get(kind, "event"), ORDINATES[kind])
    at = np.asarray(getattr(measured, ABSCISSAE[kind])) if kind in ABSCISSAE else None
    at = np.arange(1, len(values) + 1) if at is None else at
    colors = list(PALETTE.values())[1:]  # black are the data
    order = np.argsort(at, kind="stable")
    for k, label in enumerate(labels):
        color = colors[k % len(colors)]
        ax.plot(
            at, values[:, k], ".", ms=4, color="black", alpha=0.4, label="" if k else "measured"
        )
        ax.plot(at[order], rows[order, k], **{"color": color, "label": label, **style})
    ax.set(xlabel=labelled[0], ylabel=labelled[1])
    ax.legend()
    return ax
