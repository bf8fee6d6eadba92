"""The limit of a slow belt: event maps, exponents over two parameters, and slips."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.eventmap.quasistatic_map import QuasistaticSlips, quasistatic_map
from stickslip.plot.maps import Curve, draw_curve, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.quasistatic.claims import CHAOTIC, MU, Plane, plane

# Figure 1: the event map as the belt slows down.
SPEEDS: Final = (0.2, 0.05)


@dataclass(frozen=True)
class Slowing:
    """Graphs of the limit and of the maps at `SPEEDS`."""

    domain: tuple[float, float]
    limit: Curve
    moving: tuple[Curve, ...]


def compute_limit() -> Slowing:
    """Trace the limit and two maps on the way to it."""
    model = examples.coulomb()
    curves = [trace(event_map(model.replace(V=V)), model.domain) for V in SPEEDS]
    return Slowing(model.domain, trace(quasistatic_map(model), model.domain), tuple(curves))


def draw_limit(data: Slowing, figure: Figure) -> None:
    """Draw the limit over the others."""
    ax = figure.add_subplot()
    draw_curve(data.limit, ax, window=data.domain)
    colours = (PALETTE["sky"], PALETTE["vermillion"])
    for V, curve, colour in zip(SPEEDS, data.moving, colours, strict=True):
        ax.plot(curve.x, curve.y, color=colour, lw=0.7, zorder=1, label=f"$V={V:g}$")
    ax.plot([], [], color=PALETTE["black"], label=r"$V\to0$")
    ax.legend(loc="lower left")


def describe_limit(data: Slowing) -> str:
    """Describe the picture."""
    p = examples.coulomb().parameters
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g} at "
        f"V = {SPEEDS[0]:g} and {SPEEDS[1]:g}, and its limit V -> 0. Where one block slips "
        "alone the limit is d plus or minus a constant: lines of slope 1."
    )


# Figure 2: exponents of quasi-static pairs over coupling and asymmetry.
def draw_plane(data: Plane, figure: Figure) -> None:
    """Colour chaotic systems by their largest exponent; grey: periodic, white: neutral."""
    ax = figure.add_subplot()
    largest = data.exponents.max(axis=0)
    quiet = np.where(largest < -1e-9, 1.0, 0.0)
    greys = ListedColormap(["white", PALETTE["light"]])
    ax.pcolormesh(data.alpha, data.beta, quiet, cmap=greys, vmin=0, vmax=1, rasterized=True)
    chaos = np.ma.masked_where(largest <= CHAOTIC, largest)
    image = ax.pcolormesh(data.alpha, data.beta, chaos, cmap="viridis", vmin=0.0, rasterized=True)
    figure.colorbar(image, ax=ax, label="exponent per event")
    ax.set_xlabel(r"$\alpha$")
    ax.set_ylabel(r"$\beta$")


def describe_plane(data: Plane) -> str:
    """Say what the colours mean."""
    return (
        f"Largest Lyapunov exponent per event of two blocks as V -> 0, mu = {MU:g}, over the "
        f"coupling alpha and the ratio beta of the static limits, {len(data.exponents)} starts "
        "each. Coloured: chaotic for some start. Grey: all motions settle on periodic ones. "
        "White: neutral families, as for the symmetric systems beta = 1 on the lower edge."
    )


# Figure 3: a sequence of slips of a chaotic pair, and their sizes.
SHOWN: Final = 60
SLIPS: Final = 4000
TRANSIENT: Final = 500


@dataclass(frozen=True)
class Chaos:
    """Slips in their order, and the parameters."""

    slips: QuasistaticSlips
    parameters: dict[str, Any]


def compute_slips() -> Chaos:
    """Follow one motion of the paper's Coulomb system in the limit V -> 0."""
    f = quasistatic_map(examples.coulomb())
    orbit = f.iterate(0.1, TRANSIENT + SLIPS)[TRANSIENT:-1]
    return Chaos(f.slips(orbit), f.parameters)


def draw_slips(data: Chaos, figure: Figure) -> None:
    """Draw moments against the travel of the belt, and how often which moment occurs."""
    axes = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
    travel = np.concatenate(([0.0], np.cumsum(data.slips.wait)))[:SHOWN]
    moment = data.slips.moment
    axes[0].vlines(travel, 0.0, moment[:SHOWN], color=PALETTE["blue"], lw=1.0)
    axes[0].set_xlabel("travel of the belt")
    axes[0].set_ylabel("moment")
    axes[0].set_ylim(bottom=0.0)
    axes[1].hist(moment, bins=80, color=PALETTE["blue"], histtype="stepfilled")
    axes[1].set_xlabel("moment")
    axes[1].set_ylabel("slips")
    for ax, letter in zip(axes, "ab", strict=True):
        panel_letter(ax, letter)


def describe_slips(data: Chaos) -> str:
    """Describe the picture with its parameters."""
    p = data.parameters
    single = float(np.mean((data.slips.displacement < 1e-12).any(axis=-1)))
    return (
        f"Slips as V -> 0 for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}. "
        f"(a) Moments of {SHOWN} slips over the travel of the belt. (b) Moments of {SLIPS}; "
        f"in {single:.0%} of the slips one block moves alone, by 2 (1 - mu) L / (1 + alpha)."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.3, compute_limit, draw_limit, describe_limit),
    2: PaperFigure("one", 3.1, plane, draw_plane, describe_plane),
    3: PaperFigure("two", 2.6, compute_slips, draw_slips, describe_slips),
}
