"""The limit of a slow belt: event maps, exponents over two parameters, and slips."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from matplotlib.colors import ListedColormap

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.eventmap.quasistatic_map import quasistatic_map
from stickslip.plot.maps import draw_curve, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.quasistatic.claims import CHAOTIC, MU, plane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SPEEDS: Final = (0.2, 0.05)
SHOWN: Final = 60
SLIPS: Final = 4000
TRANSIENT: Final = 500


def draw_limit(figure: Figure) -> str:
    """Draw the event map as the belt slows down: the limit over two maps on the way to it."""
    ax, model = figure.add_subplot(), examples.coulomb()
    draw_curve(trace(quasistatic_map(model), model.domain), ax, window=model.domain)
    for V, name in zip(SPEEDS, ("sky", "vermillion"), strict=True):
        curve = trace(event_map(model.replace(V=V)), model.domain)
        ax.plot(curve.x, curve.y, color=PALETTE[name], lw=0.7, zorder=1, label=f"$V={V:g}$")
    ax.plot([], [], color=PALETTE["black"], label=r"$V\to0$")
    ax.legend(loc="lower left")
    p = model.parameters
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g} at "
        f"V = {SPEEDS[0]:g} and {SPEEDS[1]:g}, and its limit V -> 0. Where one block slips "
        "alone the limit is d plus or minus a constant: lines of slope 1."
    )


def draw_plane(figure: Figure) -> str:
    """Colour chaotic systems by their largest exponent; grey: periodic, white: neutral."""
    ax, data = figure.add_subplot(), plane()
    largest = data.exponents.max(axis=0)
    quiet = np.where(largest < -1e-9, 1.0, 0.0)
    greys = ListedColormap(["white", PALETTE["light"]])
    ax.pcolormesh(data.alpha, data.beta, quiet, cmap=greys, vmin=0, vmax=1, rasterized=True)
    chaos = np.ma.masked_where(largest <= CHAOTIC, largest)
    image = ax.pcolormesh(data.alpha, data.beta, chaos, cmap="viridis", vmin=0.0, rasterized=True)
    figure.colorbar(image, ax=ax, label="exponent per event")
    ax.set(xlabel=r"$\alpha$", ylabel=r"$\beta$")
    return (
        f"Largest Lyapunov exponent per event of two blocks as V -> 0, mu = {MU:g}, over the "
        f"coupling alpha and the ratio beta of the static limits, {len(data.exponents)} starts "
        "each. Coloured: chaotic for some start. Grey: all motions settle on periodic ones. "
        "White: neutral families, as for the symmetric systems beta = 1 on the lower edge."
    )


def draw_slips(figure: Figure) -> str:
    """Draw moments of a chaotic pair's slips, and how often which moment occurs."""
    f = quasistatic_map(examples.coulomb())
    slips = f.slips(f.iterate(0.1, TRANSIENT + SLIPS)[TRANSIENT:-1])
    axes = figure.subplots(1, 2, width_ratios=(1.7, 1.0))
    travel = np.concatenate(([0.0], np.cumsum(slips.wait)))[:SHOWN]
    axes[0].vlines(travel, 0.0, slips.moment[:SHOWN], color=PALETTE["blue"], lw=1.0)
    axes[0].set(xlabel="travel of the belt", ylabel="moment", ylim=(0.0, None))
    axes[1].hist(slips.moment, bins=80, color=PALETTE["blue"], histtype="stepfilled")
    axes[1].set(xlabel="moment", ylabel="slips")
    for ax, letter in zip(axes, "ab", strict=True):
        panel_letter(ax, letter)
    p = f.parameters
    single = float(np.mean((slips.displacement < 1e-12).any(axis=-1)))
    return (
        f"Slips as V -> 0 for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}. "
        f"(a) Moments of {SHOWN} slips over the travel of the belt. (b) Moments of {SLIPS}; "
        f"in {single:.0%} of the slips one block moves alone, by 2 (1 - mu) L / (1 + alpha)."
    )


FIGURES: Final = {
    1: PaperFigure("one", 3.3, draw_limit),
    2: PaperFigure("one", 3.1, draw_plane),
    3: PaperFigure("two", 2.6, draw_slips),
}
