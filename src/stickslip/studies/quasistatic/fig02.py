"""Figure 2: exponents of quasi-static pairs over coupling and asymmetry."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from stickslip.plot.style import PALETTE
from stickslip.studies.quasistatic.claims import CHAOTIC, MU, Plane, plane

TITLE: Final = "Exponents over coupling and asymmetry"
COLUMNS: Final = "one"
HEIGHT: Final = 3.1

compute = plane


def draw(data: Plane, figure: Figure) -> None:
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


def caption(data: Plane) -> str:
    """Say what the colours mean."""
    return (
        f"Largest Lyapunov exponent per event of two blocks as V -> 0, mu = {MU:g}, over the "
        f"coupling alpha and the ratio beta of the static limits, {len(data.exponents)} starts "
        "each. Coloured: chaotic for some start. Grey: all motions settle on periodic ones. "
        "White: neutral families, as for the symmetric systems beta = 1 on the lower edge."
    )
