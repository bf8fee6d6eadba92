"""The mechanism: blocks on a moving belt, drawn from a model's numbers (the paper's figure 1)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import to_rgba
from matplotlib.patches import Circle, FancyArrowPatch, FancyBboxPatch, Rectangle

from stickslip.plot.style import PALETTE, axes_or_new

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from stickslip.mechanics.model.belt_model import BeltModel
    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats

# Lengths of the drawing, in its own units.
_BLOCK: Final = (1.4, 1.15)  # width, height
_FIRST: Final = 2.2  # centre of the first block with all springs slack; a wall is at 0
_PITCH: Final = 3.55  # from block to block
_LAST: Final = 2.65  # from the last block to a wall
_BELT: Final = (0.55, -0.62)  # from the walls, bottom; its top is y = 0
_CEILING: Final = 2.4
_SPRING_HEIGHT: Final = 0.62
_PER_UNIT: Final = 0.55  # drawing length of one unit of displacement
_FORCE_PER_UNIT: Final = 0.55  # drawing length of one unit of force
_MOST_NAMED: Final = 6  # blocks with names on them
_COLORS: Final = ("blue", "green", "purple", "orange", "sky", "grey")


def block_color(block: int) -> str:
    """Colour of a block, counted from 1, where these are told apart."""
    return PALETTE[_COLORS[(block - 1) % len(_COLORS)]]


def mechanism(
    model: TwoBlock | BeltModel,
    ax: Axes | None = None,
    *,
    x: ArrayLike | None = None,
    friction: ArrayLike | None = None,
    sticks: ArrayLike | None = None,
) -> Axes:
    """Draw blocks, springs and belt; dampers and forces are left out.

    Parameters
    ----------
    model : TwoBlock, Chain, Blocks or Oscillator
        Its numbers set the drawing: springs are drawn as heavy as they are stiff
        (none of stiffness 0), the arrows of the static limits as long as these are. One or
        two blocks are held by walls, more by a support above them.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    x : array_like of float, shape (n,), optional
        Displacements to show, in units of f_s1 / k; by default 0, or those at which a
        global stick phase of two blocks that are level (d = 0) ends.
    friction : array_like of float, shape (n,), optional
        Forces of the belt on the blocks, in units of f_s1: arrows in place of the static limits.
    sticks : array_like of bool, shape (n,), optional
        Blocks that ride on the belt, drawn in full; others are outlined, dashed.

    Returns
    -------
    matplotlib.axes.Axes
        Equal scales, no frame.

    Raises
    ------
    ValueError
        Not all that moves rides on one belt.
    """
    plant = model.plant
    if not plant.rubs_as_one:
        raise ValueError(
            "the mechanism is drawn of blocks on one belt, not of other structures. Draw the "
            "motion: trajectory.plot(), stickslip.plot.phase_portrait."
        )
    ax = axes_or_new(ax)
    n = plant.n_contacts
    rest: Floats = _FIRST + _PITCH * np.arange(n, dtype=np.float64)
    centres = rest + _PER_UNIT * _displacements(model, x)
    right = rest[-1] + _LAST
    _belt(ax, right)
    for block, centre in enumerate(centres, start=1):
        force, subscript = plant.static[block - 1], rf"f_{{\mathrm{{s}}{block}}}"
        if friction is not None:
            force, subscript = float(np.asarray(friction)[block - 1]), f"f_{block}"
        rides = None if sticks is None else bool(np.asarray(sticks)[block - 1])
        told = {None: "$m$" if n <= 2 else f"${block}$", True: f"{block} sticks"}
        names = (told.get(rides, f"{block} slips"), f"${subscript}$")
        _block(ax, block, centre, force, names if n <= _MOST_NAMED else None, rides)
    draw_supports = _walls if n <= 2 else _ceiling
    draw_supports(ax, rest, centres, plant.stiffness.sum(axis=1), right)
    _couplings(ax, centres, -plant.stiffness)
    ax.set_xlim(-0.35, right + 0.35)
    ax.set_ylim(_BELT[1] - 0.1, _BLOCK[1] + 1.05 if n <= 2 else _CEILING + 0.3)
    ax.set_aspect("equal")
    ax.set_axis_off()
    return ax


def _displacements(model: TwoBlock | BeltModel, x: ArrayLike | None) -> Floats:
    if x is not None:
        return np.asarray(x, dtype=float)
    onset = getattr(model, "onset", None)  # of two blocks only
    return np.zeros(model.n_blocks) if onset is None else np.asarray(onset(0.0))


def _walls(ax: Axes, rest: Floats, centres: Floats, stiffness: Floats, right: float) -> None:
    """One or two blocks between walls, and how far each is from where its spring is slack."""
    half = _BLOCK[0] / 2
    for block, (slack, centre) in enumerate(zip(rest, centres, strict=True), start=1):
        _displacement_arrow(ax, block, slack, centre)
    for k, (wall, side) in enumerate([(0.0, -1.0), (right, 1.0)][: len(centres)]):
        ax.plot([wall, wall], [0.0, 1.1], color="black", lw=1.2)
        left = wall if side > 0 else wall - 0.22
        ax.add_patch(Rectangle((left, 0.0), 0.22, 1.1, fill=False, hatch="/////", lw=0.0))
        ends = sorted([wall, centres[k] + side * half])
        _spring(ax, (ends[0], _SPRING_HEIGHT), (ends[1], _SPRING_HEIGHT), stiffness[k], "$k$")


def _ceiling(ax: Axes, rest: Floats, centres: Floats, stiffness: Floats, right: float) -> None:
    """Three blocks or more below their support: a spring that leans is not slack."""
    ax.plot([0.0, right], [_CEILING, _CEILING], color="black", lw=1.2)
    ax.add_patch(Rectangle((0.0, _CEILING), right, 0.22, fill=False, hatch="/////", lw=0.0))
    for slack, centre, k in zip(rest, centres, stiffness, strict=True):
        _spring(ax, (slack, _CEILING), (centre, _BLOCK[1]), k)


def _couplings(ax: Axes, centres: Floats, stiffness: Floats) -> None:
    """Springs between neighbours, arcs between others."""
    half, n = _BLOCK[0] / 2, len(centres)
    for i in range(n - 1):
        name = r"$k_{12}=\alpha k$" if n == 2 else ""
        start, end = centres[i] + half, centres[i + 1] - half
        k = stiffness[i, i + 1]
        _spring(ax, (start, _SPRING_HEIGHT), (end, _SPRING_HEIGHT), k, name)
    for i, j in zip(*np.nonzero(np.triu(stiffness, 2)), strict=True):
        ends = [(float(centres[k]), _BLOCK[1]) for k in (i, j)]
        arc = FancyArrowPatch(*ends, connectionstyle="arc3,rad=-0.12", arrowstyle="-", lw=0.6)
        ax.add_patch(arc)


def _belt(ax: Axes, wall: float) -> None:
    margin, bottom = _BELT
    left, right = margin, wall - margin
    radius = -bottom / 2
    shape = f"round,pad=0,rounding_size={radius}"
    corner, width = (left, bottom), right - left
    ax.add_patch(FancyBboxPatch(corner, width, -bottom, boxstyle=shape, fill=False, lw=1.2))
    for centre in (left + radius, right - radius):
        roller = (centre, bottom / 2)
        ax.add_patch(Circle(roller, 0.8 * radius, facecolor=PALETTE["light"], lw=0.6))
        ax.add_patch(Circle(roller, 0.06, color="black", lw=0.0))
    middle = 0.5 * (left + right)
    _arrow(ax, (middle - 0.55, bottom / 2), (middle + 0.55, bottom / 2), PALETTE["blue"])
    ax.text(middle + 0.7, bottom / 2, r"$v_{\mathrm{dr}}$", va="center", color=PALETTE["blue"])


def _block(
    ax: Axes,
    block: int,
    centre: float,
    force: float,
    names: tuple[str, str] | None,
    rides: bool | None,
) -> None:
    """Draw a block and, all to one scale, a force of the belt on it, the largest by default."""
    width, height = _BLOCK
    left, gid = centre - width / 2, f"block-{block}"
    look: dict[str, Any] = {"facecolor": PALETTE["light"], "ec": "black", "lw": 0.9}
    if rides is not None:
        color = block_color(block)
        shade = to_rgba(color, 0.45) if rides else "white"
        look = {"facecolor": shade, "ec": color, "lw": 1.4, "ls": "-" if rides else "--"}
    ax.add_patch(Rectangle((left, 0.0), width, height, gid=gid, **look))
    red = PALETTE["vermillion"]
    start = left + 0.1 if rides is None else centre
    end = start + _FORCE_PER_UNIT * force
    _arrow(ax, (start, 0.2), (end, 0.2), red)
    if names:
        ax.text(centre, 0.72 * height, names[0], ha="center", va="center")
        aside: dict[str, Any] = {"ha": "right" if force < 0.0 else "left", "va": "center"}
        ax.text(end + np.copysign(0.07, force), 0.2, names[1], color=red, **aside)


def _displacement_arrow(ax: Axes, block: int, rest: float, centre: float) -> None:
    """From where the block rests with slack springs to where it is now."""
    top = _BLOCK[1]
    ax.plot([rest, rest], [top, top + 0.75], color="black", lw=0.5, ls=(0, (4, 3)), zorder=3)
    ax.plot([centre, centre], [top, top + 0.75], color="black", lw=0.5)
    _arrow(ax, (rest, top + 0.5), (centre, top + 0.5), "black")
    ax.text(max(rest, centre) + 0.08, top + 0.5, f"$x_{block}$", va="center")


def _arrow(ax: Axes, start: tuple[float, float], end: tuple[float, float], color: str) -> None:
    style = {"arrowstyle": "-|>", "color": color, "lw": 0.9, "shrinkA": 0.0, "shrinkB": 0.0}
    ax.annotate("", end, start, arrowprops={**style, "mutation_scale": 7.0})


def _spring(
    ax: Axes,
    start: tuple[float, float],
    end: tuple[float, float],
    stiffness: float,
    name: str = "",
) -> None:
    """Zigzag between two points; a stiffer spring has a heavier wire, one of stiffness 0 none."""
    if not stiffness > 0.0:
        return
    a, b = np.asarray(start), np.asarray(end)
    length = float(np.hypot(*(b - a)))
    along, aside = (b - a) / length, np.array([a[1] - b[1], b[0] - a[0]]) / length
    places = np.linspace(0.12, 0.88, 2 * 7 + 2)
    swings = 0.13 * np.tile([1.0, -1.0], places.size // 2)
    swings[[0, -1]] = 0.0
    turns = a + length * np.outer(places, along) + np.outer(swings, aside)
    x, y = np.vstack([a, turns, b]).T
    ax.plot(x, y, color="black", lw=min(0.7 * np.sqrt(stiffness), 2.0), solid_joinstyle="round")
    middle_x, middle_y = (0.5 * (a + b)).tolist()
    ax.text(middle_x, middle_y + 0.22, name, ha="center", va="bottom")
