"""Figure 10: orbits that start on both sides of the jump reach S4 in different ways."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.numerics.arrays import Floats
from stickslip.plot.maps import Curve, draw_curve, draw_steps, mark_orbit, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.galvanetto2001.orbits import coulomb_orbits, from_point_1, jump_of_s4, u4

TITLE: Final = "Transients from both sides of the jump of the fourth iterated map"
COLUMNS: Final = "two"
HEIGHT: Final = 3.5

WINDOWS: Final = ((-0.34, 0.34), (0.2765, 0.2805))
STEPS: Final = 40


@dataclass(frozen=True)
class Data:
    """Graphs of f^4 in two windows; S4, U4 from the jump on; f^4-orbits (STEPS + 1,) from there."""

    curves: tuple[Curve, Curve]
    s4: Floats
    u4: Floats
    from_left: Floats
    from_right: Floats


def compute() -> Data:
    """Trace f^4 and iterate it from the floats on both sides of the jump next to S4."""
    f = event_map(examples.coulomb())
    f4 = f.power(4)
    jump = jump_of_s4(f)
    left, right = jump.interval
    s4, unstable = (from_point_1(orbit, jump.d) for orbit in (coulomb_orbits(f)["S4"], u4(f)))
    curves = (trace(f4, WINDOWS[0], points=2001), trace(f4, WINDOWS[1]))
    return Data(curves, s4, unstable, f4.iterate(left, STEPS), f4.iterate(right, STEPS))


def draw(data: Data, figure: Figure) -> None:
    """Draw both windows with the two transients, S4 and the points of U4."""
    axes = figure.subplots(1, 2)
    for ax, letter, curve, window in zip(axes, "ab", data.curves, WINDOWS, strict=True):
        draw_curve(curve, ax, window=window, power=4, jumps=letter == "b")
        draw_steps(ax, data.from_left, color=PALETTE["blue"])
        draw_steps(ax, data.from_right, color=PALETTE["orange"])
        _mark(ax, data, window)
        panel_letter(ax, letter)


def _mark(ax: Axes, data: Data, window: tuple[float, float]) -> None:
    s4, unstable = (d[(d > window[0]) & (d < window[1])] for d in (data.s4, data.u4))
    mark_orbit(ax, unstable, power=unstable.size, stable=False)
    mark_orbit(ax, s4, power=s4.size, ms=3.0)
    for d in unstable:
        ax.annotate("$U_4$", (d, d), (-6, 4), textcoords="offset points", ha="right")
    for d in s4:
        ax.annotate("$S_4$", (d, d), (-1, -16), textcoords="offset points")


def caption(data: Data) -> str:
    """Describe the two transients."""
    points = ", ".join(f"{d:.6f}" for d in data.u4)
    return (
        f"Fourth iterated map for V = 0.0366 (a) over {WINDOWS[0][0]:g} < d < {WINDOWS[0][1]:g} "
        f"and (b) enlarged (our choice). From the left side of the jump d = {data.u4[0]:.10f} the "
        "orbit climbs down to the nearest point of S4; from the right side it leaves for "
        f"d = {data.from_right[1]:.4f} and settles at d = {data.from_right[-1]:.4f}, another "
        f"point of S4. Squares: the infinitely unstable U4, d = {points}; the first is on the jump."
    )
