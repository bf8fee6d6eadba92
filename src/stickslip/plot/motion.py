"""Motions in time: phase portraits with the stick interval, and time series (figures 7, 17)."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.mechanics.flow.at_contacts import at_contacts
from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import symbol

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.mechanics.model.units import Quantity
    from stickslip.numerics.arrays import Floats

_PHYSICAL: Final[dict[str, tuple[Quantity, str]]] = {  # what is scaled, and the paper's symbol
    "t": ("time", "$t$"),
    "x": ("displacement", "$x_{i}$"),
    "v": ("velocity", r"$\dot{x}_{i}$"),
    "friction": ("force", "$f_{i}$"),
}


def sample_times(
    t: Floats,
    per_unit: float = 60.0,
    riding: NDArray[np.bool_] | None = None,
) -> Floats:
    """Spread times for a smooth line: even steps within each phase, and both its ends."""
    # Friction jumps at events: each has a time just before it, too. Of phases in which both blocks
    # ride, straight lines, the ends are enough.
    counts = np.maximum(8, per_unit * np.diff(t)).astype(int)
    if riding is not None:
        counts[riding] = 1
    pieces = [
        np.append(np.linspace(start, end, count, endpoint=False), np.nextafter(end, start))
        for (start, end), count in zip(pairwise(t), counts, strict=True)
    ]
    return np.concatenate([*pieces, t[-1:]])


def _times(trajectory: Any) -> Floats:
    return sample_times(trajectory.t, riding=~trajectory.modes.any(axis=1))


def stick_interval(model: TwoBlock, block: int, x_other: float) -> tuple[float, float]:
    """Displacements at which a block can ride while the other is at a place (eq. 6a)."""
    limit, shift = model.limits[block - 1], model.alpha * x_other
    return ((shift - limit) / (1.0 + model.alpha), (shift + limit) / (1.0 + model.alpha))


def phase_portrait(trajectory: Any, block: int = 2, ax: Axes | None = None) -> Axes:
    """Draw velocity over displacement of one block; heavy where it rides on the belt.

    Parameters
    ----------
    trajectory : Trajectory
        A simulated motion.
    block : int
        From 1; of a structure the contact.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        With the line X' = V dashed.
    """
    ax = axes_or_new(ax)
    t = _times(trajectory)
    model, V = trajectory.model, float(trajectory.model.plant.V[block - 1])
    phase = np.minimum(np.searchsorted(trajectory.t, t, side="right"), len(trajectory.modes)) - 1
    sticks = trajectory.modes[phase] == 0
    u, w = at_contacts(model, t, trajectory.x(t), trajectory.v(t), sticks)
    # What sticks has the belt's velocity, but for rounding.
    v = np.where(sticks, V, w)[:, block - 1]
    draw_portrait(ax, u[:, block - 1], v, block=block, V=V)
    if not model.plant.rubs_as_one:
        ax.set(xlabel=f"displacement of contact {block}", ylabel=f"velocity of contact {block}")
    return ax


def draw_portrait(
    ax: Axes,
    x: Floats,
    v: Floats,
    *,
    block: int,
    V: float,
    interval: tuple[float, float] | None = None,
    linewidth: float = 0.8,
) -> Axes:
    """Draw sampled displacement and velocity of one block with the stick interval."""
    # Without `interval`, which moves with the other block, the line is drawn where the block rides.
    ax.axhline(V, color=PALETTE["grey"], lw=0.5, ls=(0, (5, 3)), zorder=1)
    riding: dict[str, Any] = {
        "color": PALETTE["vermillion"],
        "lw": 1.5,
        "solid_capstyle": "butt",
        "zorder": 2,
    }
    rides = v == V
    if interval is None:
        ax.plot(np.where(rides, x, np.nan), v, **riding)
    else:
        ax.plot(interval, [V, V], **riding)
        ax.plot(interval, [V, V], ls="none", marker="|", ms=6.0, color=PALETTE["vermillion"])
    # A slip's line includes the rides' first and last points, so that it reaches the belt.
    inner = rides.copy()
    inner[1:-1] &= rides[:-2] & rides[2:]
    inner[[0, -1]] = False
    ax.plot(np.where(inner, np.nan, x), v, color="black", lw=linewidth, zorder=3)
    ax.set_xlabel(symbol("x", block))
    ax.set_ylabel(symbol("v", block))
    return ax


def plot_trajectory(trajectory: Any, ax: Axes | None = None) -> Axes:
    """Draw displacements over time: what ``Trajectory.plot`` shows."""
    return time_series(trajectory, "x", ax)


def time_series(trajectory: Any, name: str = "v", ax: Axes | None = None) -> Axes:
    """Draw displacement, velocity or friction of every block over time.

    Parameters
    ----------
    trajectory : Trajectory or PhysicalTrajectory
        A simulated motion.
    name : {"x", "v", "friction"}
        Which function of time.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        One line per block, named in a legend.

    Raises
    ------
    ValueError
        Another name.
    """
    if name not in ("x", "v", "friction"):
        raise ValueError(f"name = {name!r} must be 'x', 'v' or 'friction'")
    ax = axes_or_new(ax)
    units = getattr(trajectory, "units", None)
    motion = trajectory if units is None else trajectory.trajectory
    t = _times(motion)  # as dense for one cycle whatever the unit of time
    values = getattr(motion, name)(t)
    labels = symbol("t"), symbol(name, "i")
    if units is not None:
        (time, time_symbol), (quantity, value_symbol) = _PHYSICAL["t"], _PHYSICAL[name]
        t, values = units.to_physical(time, t), units.to_physical(quantity, values)
        labels = time_symbol, value_symbol
    for block in range(values.shape[-1]):
        ax.plot(t, values[:, block], label=f"block {block + 1}")
    ax.set(xlabel=labels[0], ylabel=labels[1])
    columns = min(values.shape[-1], 6)
    ax.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=columns, borderaxespad=0.2)
    return ax


def plot_sensitivity(by: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw the derivatives of all displacements over time, a line for each name and block."""
    ax = axes_or_new(ax)
    motion = by.trajectory
    ends = np.append(motion.t[motion.t < by.t_end], by.t_end)
    t = sample_times(ends)
    values = by.x(t)
    for block in range(values.shape[1]):
        for name, line in zip(by.names, values[:, block].T, strict=True):
            ax.plot(t, line, **{"label": f"{symbol('x', block + 1)} by {name}", **style})
    ax.set(xlabel=symbol("t"), ylabel="derivative")
    ax.legend()
    return ax
