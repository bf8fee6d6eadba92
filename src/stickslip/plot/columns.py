"""Results of a few numbers: columns of their tables against each other."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from stickslip.plot.bifurcations import name_steps, parameter_label, symbol_of
from stickslip.plot.style import axes_or_new

MANY: Final = 60  # rows that are a line; fewer are points


def draw_columns(result: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the columns that a result names for it, over the first of these."""
    ax = axes_or_new(ax)
    table = result.table()
    abscissa, *ordinates = result._drawn
    for name in ordinates:
        look = {"ls": "-"} if table.n_rows > MANY else {"ls": "none", "marker": "o"}
        ax.plot(table[abscissa], table[name], **{"label": parameter_label(name), **look, **style})
    ax.set_xlabel(parameter_label(abscissa))
    if len(ordinates) == 1:
        ax.set_ylabel(parameter_label(ordinates[0]))
    else:
        ax.legend()
    return ax


def draw_branch(branch: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw a branch of a map as the chord between its ends; as `draw_columns`."""
    ax = axes_or_new(ax)
    ax.plot((branch.left, branch.right), (branch.value_left, branch.value_right), **style)
    name_steps(ax, symbol_of(branch))
    return ax


def draw_enclosure(enclosure: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw lowest and highest values as bars, a row for each quantity; as `draw_columns`."""
    table = enclosure.table()
    return _bars(table["quantity"], table["low"], table["high"], ax, style)


def draw_enclosures(certificate: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the enclosures of a certificate, a row for each; as `draw_columns`."""
    table = certificate.table()
    middle, radius = table["middle"], table["radius"]
    return _bars(table["name"], middle - radius, middle + radius, ax, style)


def _bars(names: Any, low: Any, high: Any, ax: Axes | None, style: dict[str, Any]) -> Axes:
    ax = axes_or_new(ax)
    rows = np.arange(len(names))
    ax.hlines(rows, low, high, **style)
    ax.plot(low, rows, "|", high, rows, "|", color="black")
    ax.set_yticks(rows, names)
    ax.set_xlabel("value")
    return ax
