"""The mechanism: blocks on a moving belt, drawn from a model's numbers (the paper's figure 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from stickslip.mechanics.model.two_block import TwoBlock

__all__ = ["mechanism"]

# Lengths of the drawing, in its own units.
_BLOCK: Final = (1.4, 1.15)  # width, height
_REST: Final = (2.2, 5.75)  # centres of the blocks with all springs slack
_WALLS: Final = (0.0, 8.4)
_BELT: Final = (0.55, 7.85, -0.62)  # left, right, bottom; its top is y = 0
_SPRING_HEIGHT: Final = 0.62
_PER_UNIT: Final = 0.55  # drawing length of one unit of displacement
_FORCE_PER_UNIT: Final = 0.55  # drawing length of one unit of force


def mechanism(model: TwoBlock, ax: Axes | None = None, *, x: ArrayLike | None = None) -> Axes:
    """Draw blocks, springs and belt.

    Parameters
    ----------
    model : TwoBlock
        Its numbers set the drawing: springs are drawn as heavy as they are stiff
        (none where alpha = 0), the arrows of the static limits as long as these are.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    x : array_like of float, shape (2,), optional
        Displacements to show, in units of f_s1 / k; by default those at which a
        global stick phase with the blocks level (d = 0) ends.

    Returns
    -------
    matplotlib.axes.Axes
        Equal scales, no frame.
    """
    ax = axes_or_new(ax)
    shift = _PER_UNIT * (model.onset(0.0) if x is None else np.asarray(x, dtype=float))
    centres = np.asarray(_REST) + shift
    _walls(ax)
    _belt(ax)
    for block, centre in enumerate(centres, start=1):
        _block(ax, block, centre)
        _displacement_arrow(ax, block, centre)
        _limit_arrow(ax, block, centre, model.limits[block - 1])
    half = _BLOCK[0] / 2
    _spring(ax, _WALLS[0], centres[0] - half, 1.0, "$k$")
    if model.alpha > 0.0:
        name = r"$k_{12}=\alpha k$"
        _spring(ax, centres[0] + half, centres[1] - half, model.alpha, name)
    _spring(ax, centres[1] + half, _WALLS[1], 1.0, "$k$")
    ax.set_xlim(_WALLS[0] - 0.35, _WALLS[1] + 0.35)
    ax.set_ylim(_BELT[2] - 0.1, _BLOCK[1] + 1.05)
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


def _walls(ax: Axes) -> None:
    for wall, side in zip(_WALLS, (-1.0, 1.0), strict=True):
        ax.plot([wall, wall], [0.0, 1.1], color="black", lw=1.2)
        left = wall if side > 0 else wall - 0.22
        ax.add_patch(Rectangle((left, 0.0), 0.22, 1.1, fill=False, hatch="/////", lw=0.0))


def _belt(ax: Axes) -> None:
    left, right, bottom = _BELT
    radius = -bottom / 2
    belt = FancyBboxPatch(
        (left + radius, bottom),
        right - left - 2 * radius,
        -bottom,
        boxstyle=f"round,pad=0,rounding_size={radius}",
        fill=False,
        lw=1.2,
    )
    belt.set_bounds(left, bottom, right - left, -bottom)
    ax.add_patch(belt)
    for centre in (left + radius, right - radius):
        roller = (centre, bottom / 2)
        ax.add_patch(Circle(roller, 0.8 * radius, facecolor=PALETTE["light"], lw=0.6))
        ax.add_patch(Circle(roller, 0.06, color="black", lw=0.0))
    middle = 0.5 * (left + right)
    _arrow(ax, (middle - 0.55, bottom / 2), (middle + 0.55, bottom / 2), PALETTE["blue"])
    ax.text(middle + 0.7, bottom / 2, r"$v_{\mathrm{dr}}$", va="center", color=PALETTE["blue"])


def _block(ax: Axes, block: int, centre: float) -> None:
    width, height = _BLOCK
    corner, gid = (centre - width / 2, 0.0), f"block-{block}"
    ax.add_patch(
        Rectangle(corner, width, height, facecolor=PALETTE["light"], ec="black", lw=0.9, gid=gid)
    )
    ax.text(centre, 0.72 * height, "$m$", ha="center", va="center")


def _displacement_arrow(ax: Axes, block: int, centre: float) -> None:
    """From where the block rests with slack springs to where it is now."""
    rest, top = _REST[block - 1], _BLOCK[1]
    ax.plot([rest, rest], [top, top + 0.75], color="black", lw=0.5, ls=(0, (4, 3)), zorder=3)
    ax.plot([centre, centre], [top, top + 0.75], color="black", lw=0.5)
    _arrow(ax, (rest, top + 0.5), (centre, top + 0.5), "black")
    ax.text(0.5 * (rest + centre), top + 0.6, f"$x_{block}$", ha="center", va="bottom")


def _limit_arrow(ax: Axes, block: int, centre: float, limit: float) -> None:
    """Show the largest force with which the belt can hold a block, all to one scale."""
    start = centre - _BLOCK[0] / 2 + 0.1
    end = start + _FORCE_PER_UNIT * limit
    _arrow(ax, (start, 0.2), (end, 0.2), PALETTE["vermillion"])
    ax.text(
        end + 0.07, 0.2, rf"$f_{{\mathrm{{s}}{block}}}$", color=PALETTE["vermillion"], va="center"
    )


def _arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    style = {"arrowstyle": "-|>", "color": color, "lw": 0.9, "shrinkA": 0.0, "shrinkB": 0.0}
    ax.annotate("", end, start, arrowprops={**style, "mutation_scale": 7.0})


def _spring(ax: Axes, start: float, end: float, stiffness: float, name: str) -> None:
    """Zigzag between two points; a stiffer spring has a heavier wire."""
    straight = 0.12 * (end - start)
    along = np.linspace(start + straight, end - straight, 2 * 7 + 2)
    across = 0.13 * np.tile([1.0, -1.0], along.size // 2)
    across[[0, -1]] = 0.0
    ax.plot(
        np.concatenate([[start], along, [end]]),
        _SPRING_HEIGHT + np.concatenate([[0.0], across, [0.0]]),
        color="black",
        lw=min(0.7 * np.sqrt(stiffness), 2.0),
        solid_joinstyle="round",
    )
    ax.text(0.5 * (start + end), _SPRING_HEIGHT + 0.22, name, ha="center", va="bottom")
