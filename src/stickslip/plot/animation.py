"""Motions as films: blocks on their belt over a phase portrait that grows."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes

from stickslip.plot.breaks import block_color, mechanism
from stickslip.plot.motion import sample_times
from stickslip.plot.style import PALETTE, new_figure
from stickslip.vocabulary import symbol

RATE: Final = 20  # frames a second
STEP: Final = 0.25  # units of time from frame to frame
MOST_FRAMES: Final = 120
DPI: Final = 100

WRITERS: Final[dict[str, Any]] = {"gif": PillowWriter, "mp4": FFMpegWriter}


def can_write(kind: str) -> bool:
    """Tell whether this machine can write "gif" or "mp4" films; the latter needs ffmpeg."""
    return bool(WRITERS[kind].isAvailable())


def film(trajectory: Any, path: str | Path, *, frames: int = MOST_FRAMES) -> Path:
    """Draw a motion as a film.

    Parameters
    ----------
    trajectory : Trajectory
        From its start on.
    path : str or pathlib.Path
        Ends in .gif or .mp4.
    frames : int
        At most; each is a quarter unit of time later than the one before.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    ValueError
        Another ending.
    RuntimeError
        MP4 without ffmpeg.
    """
    path = Path(path)
    kind = path.suffix.removeprefix(".")
    if kind not in WRITERS:
        raise ValueError(f"path = {str(path)!r} must end in .gif or .mp4")
    if not can_write(kind):
        raise RuntimeError("MP4 needs the program ffmpeg, which is not here. Take GIF.")
    end = min(float(trajectory.t[-1]), STEP * (frames - 1))
    times = np.linspace(0.0, end, max(2, int(end / STEP) + 1))
    figure = new_figure("two", height=4.0)
    top, bottom = figure.subplots(2, 1, height_ratios=(3, 2))
    dots = _portraits(bottom, trajectory, end)
    mechanism(trajectory.model, top, x=trajectory.x(0.0))
    top.set_title("t", loc="left")
    figure.draw_without_rendering()
    figure.set_layout_engine("none")  # laid out once: it takes longer than a frame
    writer = WRITERS[kind](fps=RATE)
    with writer.saving(figure, str(path), DPI):
        for t in times.tolist():
            x, v = trajectory.x(t), trajectory.v(t)
            phase = np.searchsorted(trajectory.t, t, side="right") - 1
            sticks = trajectory.modes[min(int(phase), len(trajectory.modes) - 1)] == 0
            top.clear()
            mechanism(trajectory.model, top, x=x, friction=trajectory.friction(t), sticks=sticks)
            top.set_title(f"t = {t:.2f}", loc="left")
            for dot, x_i, v_i in zip(dots, x, v, strict=True):
                dot.set_data([x_i], [v_i])
            writer.grab_frame()
    return path


def _portraits(ax: Axes, trajectory: Any, end: float) -> list[Any]:
    """Draw all blocks' phase portraits faintly, and return a dot of each to move along it."""
    t = sample_times(np.append(trajectory.t[trajectory.t < end], end))
    x, v = trajectory.x(t), trajectory.v(t)
    ax.axhline(trajectory.model.V, color=PALETTE["grey"], lw=0.5, ls=(0, (5, 3)), label="belt")
    dots = []
    for block in range(x.shape[1]):
        color = block_color(block + 1)
        ax.plot(x[:, block], v[:, block], color=color, lw=0.6, alpha=0.6)
        dots += ax.plot([], [], "o", color=color, ms=6.0, label=f"block {block + 1}")
    ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    ax.locator_params(nbins=4)  # numbers take longer to draw than all the rest
    ax.set_xlabel(symbol("x", "i"))
    ax.set_ylabel(symbol("v", "i"))
    return dots
