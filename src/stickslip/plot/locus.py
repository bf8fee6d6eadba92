"""The global stick locus in the plane of displacements (the paper's figure 2)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.patches import Polygon

from stickslip.checks import shown
from stickslip.mechanics.model import locus
from stickslip.plot.motion import sample_times
from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import symbol

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats


def stick_locus(model: Model, ax: Axes | None = None) -> Axes:
    """Draw the locus, the edges on which global stick ends, and the map's domain AC.

    Parameters
    ----------
    model : TwoBlock, Chain or Blocks
        Of two blocks.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        Equal scales; a legend names the edges.

    Raises
    ------
    ValueError
        The model is not of two blocks on one belt without forcing.
    """
    plant = model.plant
    if not plant.rubs_as_one or model.n_blocks != 2 or plant.n_waves:
        raise ValueError(
            f"model = {shown(model)}: the locus is drawn of two blocks on one belt without forcing."
        )
    ax = axes_or_new(ax)
    corners = locus.corners(plant)
    a, b, c, _ = corners
    ax.add_patch(Polygon(corners, facecolor=PALETTE["light"], alpha=0.5, lw=0.0))
    ax.add_patch(Polygon(corners, fill=False, ec="black", lw=0.8))
    ax.plot(*np.array([a, b]).T, color=PALETTE["blue"], lw=2.2, label="block 1 slips")
    ax.plot(*np.array([b, c]).T, color=PALETTE["vermillion"], lw=2.2, label="block 2 slips")
    ax.plot(*np.array([a, c]).T, color="black", lw=1.0, ls=(0, (5, 2)), label="domain $AC$")
    _stick_phases(ax, corners)
    _name_corners(ax, corners)
    ax.axhline(0.0, color=PALETTE["grey"], lw=0.4, zorder=0)
    ax.axvline(0.0, color=PALETTE["grey"], lw=0.4, zorder=0)
    ax.set_aspect("equal")
    ax.margins(0.14)
    ax.set_xlabel(symbol("x", 1))
    ax.set_ylabel(symbol("x", 2))
    return ax


def trajectory_in_plane(trajectory: Any, ax: Axes | None = None) -> Axes:
    """Draw a motion of two blocks in the plane of displacements, over the stick locus.

    Parameters
    ----------
    trajectory : Trajectory
        Of two blocks.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        As `stick_locus`.
    """
    ax = stick_locus(trajectory.model, ax)
    x = trajectory.x(sample_times(trajectory.t))
    ax.plot(x[:, 0], x[:, 1], color=PALETTE["green"], lw=0.8, zorder=1.5, label="motion")
    return ax


def _stick_phases(ax: Axes, corners: Floats) -> None:
    """Show motions at constant d: from the line AC along (1, 1) to the edge where they end."""
    edges = corners[:3] if corners[2, 1] - corners[2, 0] > 0.0 else corners[2::-1]
    arrow = {"arrowstyle": "-|>", "color": "0.35", "lw": 0.7, "mutation_scale": 7.0}
    for share in (0.2, 0.4, 0.6, 0.8):
        start = edges[0] + share * (edges[2] - edges[0])
        d = edges[:, 1] - edges[:, 0]
        x, y = (float(np.interp(start[1] - start[0], d, values)) for values in edges.T)
        ax.annotate("", (x, y), tuple(start), arrowprops={**arrow, "shrinkA": 0.0, "shrinkB": 0.5})


def _name_corners(ax: Axes, corners: Floats) -> None:
    """Letters just outside the corners, and the value of d at the ends of the domain."""
    names = ("$A$, $d_{\\min}$", "$B$", "$C$, $d_{\\max}$", "$D$")
    offsets = ((4, -5), (3, 3), (-4, 5), (-3, -3))
    aligns = (("left", "top"), ("left", "bottom"), ("right", "bottom"), ("right", "top"))
    for corner, name, offset, (ha, va) in zip(corners, names, offsets, aligns, strict=True):
        ax.annotate(name, corner, offset, textcoords="offset points", ha=ha, va=va)
