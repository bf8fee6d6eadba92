"""Figure 13: second iterated map of law (9) just after its cusps have met the diagonal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import panel_letter
from stickslip.studies.galvanetto2001.orbits import WINDOW, cusp_of

TITLE: Final = "Second iterated map, alpha = 1.20915"
COLUMNS: Final = "two"
HEIGHT: Final = 2.35

RANGE: Final = (0.3806, 0.3858)  # from left of the first cusp to right of the second; our choice
MAGNIFICATION: Final = 20.0  # of the distance to the diagonal in the first panel; our choice
ROOM: Final = 0.6  # around a cusp, A and B in the enlarged panels, of the distance between them


@dataclass(frozen=True)
class Data:
    """The graph of f^2 with its two cusps, P1, and the 2-cycles A and B."""

    model: TwoBlock
    whole: Curve
    enlarged: tuple[Curve, Curve]
    windows: tuple[tuple[float, float], tuple[float, float]]
    cusps: tuple[float, float]  # of f, and its preimage
    p1: PeriodicOrbit
    a: PeriodicOrbit  # A1 and B1 lie beside the first cusp
    b: PeriodicOrbit

    @property
    def distance(self) -> float:
        """Largest distance of f^2 to the diagonal between the two cusps."""
        between = (self.whole.x > self.cusps[0]) & (self.whole.x < self.cusps[1])
        return float(np.abs(self.whole.y - self.whole.x)[between].max())


def compute() -> Data:
    """Trace f^2 over both cusps and beside each; A and B are the 2-cycles closest to the cusp."""
    model = examples.law9(alpha=1.20915)
    f = event_map(model)
    window = WindowMap(f, WINDOW)
    cusp = cusp_of(window).d
    found = periodic_orbits(window, 2)
    near = sorted(found.of_period(2), key=lambda orbit: abs(float(orbit.points[0]) - cusp))
    b, a = near[:2]
    (before,) = (x for x in window.preimages(cusp) if x > cusp)
    first, last = (
        _around(np.array([corner, a.points[k], b.points[k]]))
        for k, corner in enumerate((cusp, float(before)))
    )
    second = f.power(2)
    return Data(
        model,
        trace(second, RANGE, points=401),
        (trace(second, first, points=201), trace(second, last, points=201)),
        (first, last),
        (cusp, float(before)),
        found.of_period(1)[0],
        a,
        b,
    )


def _around(points: Floats) -> tuple[float, float]:
    low, high = float(points.min()), float(points.max())
    return low - ROOM * (high - low), high + ROOM * (high - low)


def draw(data: Data, figure: Figure) -> None:
    """Draw f^2 magnified towards the diagonal, then true to scale beside both cusps."""
    axes = figure.subplots(1, 3)
    whole = data.whole
    higher = whole.x + MAGNIFICATION * (whole.y - whole.x)
    draw_curve(Curve(whole.x, higher, whole.jumps), axes[0], window=RANGE, power=2, ticks=4)
    axes[0].set_ylabel(rf"$d_n + {MAGNIFICATION:g}\,(d_{{n+2}} - d_n)$")
    panel_letter(axes[0], "a")
    panels = zip(axes[1:], "bc", data.enlarged, data.windows, strict=True)
    for ax, letter, curve, window in panels:
        draw_curve(curve, ax, window=window, power=2, ticks=3)
        panel_letter(ax, letter)
    _mark(axes[0], data, RANGE, "P")
    for ax, window, corner in zip(axes[1:], data.windows, "12", strict=True):
        _mark(ax, data, window, "AB")
        centre, text = 0.5 * sum(window), f"$A_{corner}, B_{corner}$"
        offset = (6, -7) if corner == "1" else (-29, -2)
        axes[0].annotate(text, (centre, centre), offset, textcoords="offset points")


def _mark(ax: Axes, data: Data, window: tuple[float, float], named: str) -> None:
    """Mark every orbit in the window; orbits of period 2 stand on the diagonal of f^2."""
    orbits = {"P": data.p1, "A": data.a, "B": data.b}
    offsets = {"P": (5, -9), "A": (5, -8), "B1": (-15, -5), "B2": (6, -5)}
    for letter, orbit in orbits.items():
        for number, d in enumerate(orbit.points, start=1):
            if not window[0] < d < window[1]:
                continue
            mark_orbit(ax, d, power=1, stable=orbit.stable, ms=4.0)
            if letter in named:
                name = f"${letter}_{number}$"
                offset = offsets.get(f"{letter}{number}") or offsets[letter]
                ax.annotate(name, (d, d), offset, textcoords="offset points")


def caption(data: Data) -> str:
    """Describe the panels, how the first is magnified, and the two orbits in numbers."""
    (a1, a2), (b1, b2) = data.a.points, data.b.points
    return (
        f"Second iterated map g for alpha = {data.model.alpha:g}: (a) drawn at the height d + "
        f"{MAGNIFICATION:g} (g(d) - d), so that the distance to the diagonal, at most "
        f"{data.distance:.1e} between the cusps, is magnified {MAGNIFICATION:g} times (our choice; "
        "points on the diagonal stay where they are); (b) and (c) true to scale beside its two "
        f"cusps, at d = {data.cusps[0]:.8f} and {data.cusps[1]:.8f}. Squares: the unstable orbits "
        f"A, d = {a1:.8f}, {a2:.8f} (multiplier {data.a.multiplier:.4f}), and B, d = {b1:.8f}, "
        f"{b2:.8f} (multiplier {data.b.multiplier:.4f}); bold point: the fixed point P1, still "
        "stable."
    )
