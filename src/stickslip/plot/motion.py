"""Motions in time: phase portraits with the stick interval, and time series (figures 7, 17)."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.checks import whole_number
from stickslip.mechanics.flow.at_contacts import at_contacts
from stickslip.plot.style import PALETTE, axes_or_new, legend_columns
from stickslip.vocabulary import QUANTITIES, TERMS, symbol

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from numpy.typing import NDArray

    from stickslip.mechanics.model.two_block import TwoBlock
    from stickslip.numerics.arrays import Floats


def sample_times(
    t: Floats,
    per_unit: float = 60.0,
    riding: NDArray[np.bool_] | None = None,
    fewest: int = 48,  # in a phase: what rubs may be fast for its unit of time
) -> Floats:
    """Spread times for a smooth line: even steps within each phase, and both its ends."""
    # Friction jumps at events: each has a time just before it, too. Of phases in which both blocks
    # ride, straight lines, the ends are enough.
    counts = np.maximum(fewest, per_unit * np.diff(t)).astype(int)
    if riding is not None:
        counts[riding] = 1
    pieces = [
        np.append(np.linspace(start, end, count, endpoint=False), np.nextafter(end, start))
        for (start, end), count in zip(pairwise(t), counts, strict=True)
    ]
    return np.concatenate([*pieces, t[-1:]])


def _times(trajectory: Any) -> Floats:
    return sample_times(trajectory.t, riding=~trajectory.modes.any(axis=1))


def _as_told(trajectory: Any) -> tuple[Any, Callable[..., Any], Callable[..., str]]:
    """Take the dimensionless motion, how its values are told, and their names, in any units."""
    units = getattr(trajectory, "units", None)
    if units is None:
        return trajectory, lambda _, values: values, symbol

    def physical(name: str, values: Any) -> Any:
        return units.to_physical(QUANTITIES[TERMS[name].scale], values)

    return trajectory.trajectory, physical, partial(symbol, physical=True)


def stick_interval(model: TwoBlock, block: int, x_other: float) -> tuple[float, float]:
    """Displacements at which a block can ride while the other is at a place (eq. 6a)."""
    limit, shift = model.limits[block - 1], model.alpha * x_other
    return ((shift - limit) / (1.0 + model.alpha), (shift + limit) / (1.0 + model.alpha))


def phase_portrait(trajectory: Any, block: int = 2, ax: Axes | None = None) -> Axes:
    """Draw velocity over displacement of one block; heavy where it rides on the belt.

    Parameters
    ----------
    trajectory : Trajectory or PhysicalTrajectory
        A simulated motion.
    block : int
        From 1; of a structure the contact.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.

    Returns
    -------
    matplotlib.axes.Axes
        With the line X' = V dashed.

    Raises
    ------
    ValueError
        There is no such block.
    """
    ax = axes_or_new(ax)
    motion, told, named = _as_told(trajectory)
    plant = motion.model.plant
    block = whole_number("block", block, 1, at_most=plant.n_contacts)
    t, V = _times(motion), plant.V[block - 1]
    phase = np.minimum(np.searchsorted(motion.t, t, side="right"), len(motion.modes)) - 1
    sticks = motion.modes[phase] == 0
    u, w = at_contacts(motion.model, t, motion.x(t), motion.v(t), sticks)
    # What sticks has the belt's velocity, but for rounding.
    x, v = told("x", u[:, block - 1]), told("v", np.where(sticks, V, w)[:, block - 1])
    draw_portrait(ax, x, v, block=block, V=float(told("v", V)))
    contact = f"of contact {block}"
    of_blocks = named("x", block), named("v", block)
    names = of_blocks if plant.rubs_as_one else (f"displacement {contact}", f"velocity {contact}")
    ax.set(xlabel=names[0], ylabel=names[1])
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
        One line per block, or coordinate of the state, named in a legend.

    Raises
    ------
    ValueError
        Another name.
    """
    if name not in ("x", "v", "friction"):
        raise ValueError(f"name = {name!r} must be 'x', 'v' or 'friction'")
    ax = axes_or_new(ax)
    motion, told, named = _as_told(trajectory)
    t = _times(motion)  # as dense for one cycle whatever the unit of time
    times, values = told("t", t), told(name, getattr(motion, name)(t))
    for k, line in enumerate(values.T, start=1):
        whose = f"block {k}"
        if not motion.model.plant.rubs_as_one:  # its state has feet of contacts, or modes, too
            whose = f"contact {k}" if name == "friction" else named(name, k)
        ax.plot(times, line, label=whose)
    ax.set(xlabel=named("t"), ylabel=named(name, "i"))
    columns = legend_columns(ax)
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
