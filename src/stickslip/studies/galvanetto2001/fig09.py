"""Figure 9: basins of attraction of the event map of the Coulomb system."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.attractors.basins import Basins, basins
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import PALETTE

TITLE: Final = "Basins of attraction of the event map"
COLUMNS: Final = "one"
HEIGHT: Final = 3.3


@dataclass(frozen=True)
class Data:
    """The map's graph and its basins; ``s1`` is the place of S1 among the attractors."""

    model: TwoBlock
    curve: Curve
    basins: Basins
    s1: int

    @property
    def hatched(self) -> list[tuple[float, float]]:
        """Intervals of the basin of S1."""
        edges, index = self.basins.edges, self.basins.index
        ends = zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
        return [interval for interval, k in zip(ends, index, strict=True) if k == self.s1]


def compute() -> Data:
    """Find the attractors and divide the domain among them."""
    model = examples.coulomb()
    f = event_map(model)
    found = basins(f)
    s1 = next(k for k, attractor in enumerate(found.attractors) if attractor.period == 1)
    return Data(model, trace(f, f.domain), found, s1)


def draw(data: Data, figure: Figure) -> None:
    """Draw the map over its basins; the basin of S1 is hatched, as in the paper."""
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    for low, high in data.hatched:
        ax.axvspan(low, high, fill=False, hatch="\\\\\\\\\\", ec=PALETTE["grey"], lw=0.0, zorder=0)
        ax.axvline(low, color=PALETTE["grey"], lw=0.5, zorder=0)
        ax.axvline(high, color=PALETTE["grey"], lw=0.5, zorder=0)
    for attractor in data.basins.attractors:
        if attractor.orbit is not None:
            mark_orbit(ax, attractor.orbit.points)


def caption(data: Data) -> str:
    """Describe the basins with their edges."""
    intervals = " and ".join(f"{low:.10f} < d < {high:.10f}" for low, high in data.hatched)
    share = data.basins.share(data.s1)
    return (
        f"Event map for V = {data.model.V:g}; hatched: the basin of S1, {intervals} ({share:.2%} "
        "of the domain); the rest is the basin of S4. Bold points: S1 and S4."
    )
