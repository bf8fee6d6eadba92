"""Figures of the front page and of the theory, drawn by the package itself at every build.

A function here that returns a figure is a picture; `draw` writes it into a file of its name. As an
extension of Sphinx this module draws all of them before the pages are read.
"""

from __future__ import annotations

import inspect
import itertools
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

import stickslip as ss
from stickslip.plot.style import PALETTE, save, style

FOLDER = Path(__file__).parent / "generated" / "figures"


def _axes(
    width: float, height: float, rows: int = 1, columns: int = 1, **share: bool
) -> list[Axes]:
    figure = Figure(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **share)
    return list(axes.ravel())


def _lettered(axes: list[Axes], *titles: str) -> None:
    for letter, ax, title in zip("abcd", axes, titles, strict=False):
        ax.set_title(f"({letter}) {title}", loc="left")


def _diagonal(ax: Axes, low: float, high: float) -> None:
    ax.plot((low, high), (low, high), color="0.6", lw=0.6, zorder=0)


# ---------------------------------------------------------------- front page


def front() -> Figure:
    """The mechanical system, and the map that holds all its motions."""
    model = ss.examples.coulomb()
    left, right = _axes(7.2, 3.3, columns=2)
    ss.plot.mechanism(model, left, x=(0.7, 0.5))
    f = ss.event_map(model)
    ss.plot.event_map(f, ax=right)
    _diagonal(right, *f.domain)
    ss.periodic_orbits(f).plot(right)
    right.legend(loc="lower left")
    _lettered([left, right], "two blocks on a belt", "the map of their distance")
    return left.figure


# ---------------------------------------------------------------- from blocks to a map


def system() -> Figure:
    """The mechanical system of the paper."""
    (ax,) = _axes(4.2, 2.3)
    ss.plot.mechanism(ss.examples.coulomb(), ax, x=(0.7, 0.5))
    return ax.figure


def locus() -> Figure:
    """A motion in the plane of displacements; global stick is the parallelogram."""
    (ax,) = _axes(3.8, 3.4)
    motion = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=120)
    ss.plot.trajectory_in_plane(motion, ax=ax)
    return ax.figure


def laws() -> Figure:
    """Friction over slip speed."""
    (ax,) = _axes(4.2, 2.8)
    s = np.linspace(0, 2, 400)
    for name, law in {
        "Coulomb": ss.Coulomb(mu=0.4),
        "law (9)": ss.PoppStelter(gamma=3.0, delta=0.1, eta=0.02),
        "Stribeck": ss.Stribeck(mu=0.4, speed=0.3),
        "measured": ss.TabulatedFriction([0, 0.2, 0.6, 1, 2], [1, 0.7, 0.5, 0.45, 0.6]),
    }.items():
        ax.plot(s, law.force(s), label=name)
    ax.set(xlabel="slip speed $s$", ylabel="$F(s)$", xlim=(0, 2), ylim=(0, 1.05))
    ax.legend()
    return ax.figure


def graze() -> Figure:
    """Relative velocity of a block from three starts: it stays off the belt, touches it, sticks."""
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    graze = next(b for b in ss.breakpoints(f) if b.kind == "jump" and "grazes" in b.mechanism)
    block = graze.block - 1
    wide, near = _axes(7.0, 2.7, columns=2)
    for offset, colour in ((-4e-3, "blue"), (0.0, "black"), (4e-3, "vermillion")):
        motion = ss.simulate(model, d=graze.d + offset, t_end=20)
        t = np.linspace(0, 12, 6001)
        w = motion.v(t)[..., block] - model.V
        for ax in (wide, near):
            ax.plot(
                t,
                w,
                color=PALETTE[colour],
                lw=0.9,
                label=f"$d^* {offset:+g}$" if offset else "$d^*$",
            )
        if not offset:
            slipping = np.flatnonzero((t > 0.5) & (w < 0))
            inner = slipping[np.argmax(w[slipping])]
            touch, _height = t[inner], w[inner]
    for ax in (wide, near):
        ax.axhline(0, color="0.6", lw=0.6, zorder=0)
        ax.set(xlabel=r"time $\tau$", ylabel=f"$w_{graze.block}$")
    near.set(xlim=(touch - 0.6, touch + 0.9), ylim=(-0.03, 0.012))
    wide.set_xlim(0, 9)
    wide.figure.legend(*wide.get_legend_handles_labels(), loc="outside lower center", ncols=3)
    _lettered([wide, near], "three starts beside a graze", "the touch")
    return wide.figure


def jump() -> Figure:
    """What the graze does to the map: a jump, where the other motion sets in."""
    f = ss.event_map(ss.examples.coulomb())
    (ax,) = _axes(4.2, 3.2)
    ss.plot.event_map(f, ax=ax)
    _diagonal(ax, *f.domain)
    jumps = [b for b in ss.breakpoints(f) if b.kind == "jump"]
    for b in jumps:
        grazes = "grazes" in b.mechanism
        ax.plot(
            [b.d, b.d],
            [b.left, b.right],
            ls=":",
            lw=0.9,
            color=PALETTE["vermillion" if grazes else "grey"],
        )
    ax.plot([], [], ls=":", color=PALETTE["vermillion"], label="a block grazes the belt")
    ax.plot([], [], ls=":", color=PALETTE["grey"], label="another mechanism")
    ax.figure.legend(loc="outside upper right", ncols=2)
    return ax.figure


def lanes() -> Figure:
    """Modes of eight motions over time: each lane has its own events."""
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    (ax,) = _axes(6.2, 2.6)
    colours = {1: PALETTE["sky"], 2: PALETTE["blue"]}
    starts = np.linspace(-0.6, 0.6, 8)
    for lane, d in enumerate(starts):
        duration = float(f.evaluate(d).duration)
        motion = ss.simulate(model, d=float(d), t_end=duration)
        t = np.linspace(0, duration, 1500)
        slipping = np.count_nonzero(np.abs(motion.v(t) - model.V) > 1e-9, axis=-1)
        slipping = np.maximum(slipping, 1)  # at both ends all are at rest on the belt
        changes = np.flatnonzero(np.diff(slipping)) + 1
        ends = [0, *changes, t.size]
        for first, last in itertools.pairwise(ends):
            slip = slipping[(first + last) // 2]
            stop = t[min(last, t.size - 1)]
            ax.broken_barh(
                [(t[first], stop - t[first])], (lane - 0.4, 0.8), color=colours[slip], lw=0
            )
    for text, slip in (("one block slips", 1), ("both slip", 2)):
        ax.barh(0, 0, color=colours[slip], label=text)
    ax.set(xlabel=r"time $\tau$ from one global stick to the next", ylabel="lane", xlim=(0, None))
    ax.set_yticks(range(8), [f"$d = {d:.2f}$" for d in starts])
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    return ax.figure


# ---------------------------------------------------------------- maps


def itineraries() -> Figure:
    """Branches of the event map, one colour an itinerary."""
    f = ss.event_map(ss.examples.coulomb())
    (ax,) = _axes(5.6, 3.4)
    table = ss.branches(f)
    for branch in table:
        d = np.linspace(branch.left, branch.right, 300)
        ax.plot(d, f(d), label=table.text(branch.label))
    _diagonal(ax, *f.domain)
    ss.periodic_orbits(f).plot(ax)
    ax.set(xlabel="$d$", ylabel="$f(d)$")
    ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=7)
    return ax.figure


def basins() -> Figure:
    """Basins of the two attractors of the Coulomb system."""
    (ax,) = _axes(6.4, 1.7)
    ss.basins(ss.examples.coulomb()).plot(ax)
    return ax.figure


def fold_and_cusp() -> Figure:
    """Two fixed points are born: where a smooth map touches the diagonal, and at a cusp."""
    smooth, sharp = _axes(7.0, 3.0, columns=2)
    x = np.linspace(0.2, 0.8, 400)
    for r, colour in ((3.822, "blue"), (1 + np.sqrt(8), "black"), (3.835, "vermillion")):
        y = x.copy()
        for _ in range(3):
            y = r * y * (1 - y)
        smooth.plot(x, y, color=PALETTE[colour], lw=0.9, label=f"$r = {r:.4g}$")
    smooth.set(xlim=(0.47, 0.55), ylim=(0.47, 0.55), xlabel="$x$", ylabel="$f^3(x)$")
    at = 1.21862450383
    for alpha, colour in ((at - 3e-4, "blue"), (at, "black"), (at + 3e-4, "vermillion")):
        f = ss.event_map(ss.examples.law9(alpha=alpha))
        d = np.linspace(0.3798, 0.3812, 801)
        sharp.plot(d, f(d), color=PALETTE[colour], lw=0.9, label=rf"$\alpha = {alpha:.4f}$")
    sharp.set(xlim=(0.3798, 0.3812), ylim=(0.3785, 0.3815), xlabel="$d$", ylabel="$f(d)$")
    sharp.xaxis.set_major_locator(MaxNLocator(4))
    for ax in (smooth, sharp):
        _diagonal(ax, 0, 1)
        ax.legend(loc="lower right")
    _lettered([smooth, sharp], "a fold", "a fold at a cusp")
    return smooth.figure


def diagram() -> Figure:
    """The bifurcation diagram of the Coulomb system about the border collision."""
    (ax,) = _axes(5.4, 3.4)
    ss.bifurcation_diagram(ss.examples.coulomb(), "V", np.linspace(0.0366, 0.0372, 61)).plot(ax)
    return ax.figure


# ---------------------------------------------------------------- cycles, other plants


def cycle() -> Figure:
    """A stick-slip cycle of one block, and its curve along the damping."""
    block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=0.1)
    found = ss.find_cycle(block, [0.0], [0.0])
    left, right = _axes(7.0, 2.9, columns=2)
    ss.plot.phase_portrait(found.trajectory, 1, left)
    ss.follow(found, "damping", (0.0, 1.5)).plot(right)
    _lettered([left, right], "stick and slip of one block", "cycles along the damping")
    return left.figure


def circle() -> Figure:
    """The return map of a shaken block: of the phase at which it slips."""
    forcing = ss.Harmonic(amplitude=0.3, frequency=0.45)
    shaken = ss.Oscillator(V=0.02, friction=ss.Coulomb(mu=0.4), damping=0.02, forcing=forcing)
    f = ss.return_map(shaken)
    (ax,) = _axes(3.6, 3.2)
    ss.plot.event_map(f, ax=ax)
    _diagonal(ax, *f.domain)
    ss.periodic_orbits(f).plot(ax)
    return ax.figure


# ---------------------------------------------------------------- all of them


def pictures() -> dict[str, Callable[[], Figure]]:
    """Every figure by its name."""
    here = sys.modules[__name__]
    return {
        name: function
        for name, function in inspect.getmembers(here, inspect.isfunction)
        if function.__module__ == __name__
        and inspect.signature(function).return_annotation == "Figure"
    }


def draw(name: str, folder: Path = FOLDER) -> Path:
    """Draw one figure into a file."""
    with style():
        (path,) = save(pictures()[name](), folder / name, ["png"])
    return path


def _draw_all(app: Any) -> None:
    for name in pictures():
        draw(name)


def setup(app: Any) -> dict[str, bool]:
    app.connect("builder-inited", _draw_all)
    return {"parallel_read_safe": True}
