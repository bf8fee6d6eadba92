"""Figure 8: fourth iterated map of the Coulomb system, before and after the collision."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from matplotlib.figure import Figure

from stickslip import examples
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.numerics.arrays import Floats
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import panel_letter
from stickslip.studies.galvanetto2001.orbits import coulomb_orbits, from_point_1, jump_of_s4

TITLE: Final = "Fourth iterated map of the Coulomb system"
COLUMNS: Final = "two"
HEIGHT: Final = 2.5

VELOCITIES: Final = (0.0366, 0.0372)
ENLARGED: Final = (0.2745, 0.2835)  # the paper's enlarged views print no numbers that we have


@dataclass(frozen=True)
class Data:
    """Graphs of f^4: whole, enlarged, enlarged after the collision; the four points of S4."""

    domain: tuple[float, float]
    whole: Curve
    before: Curve
    after: Curve
    s4: Floats


def compute() -> Data:
    """Trace the fourth iterate for both velocities; S4 exists for the first only."""
    f, g = (event_map(examples.coulomb(V=V)) for V in VELOCITIES)
    f4 = f.power(4)
    s4 = from_point_1(coulomb_orbits(f)["S4"], jump_of_s4(f).d)
    return Data(
        f.domain,
        trace(f4, f.domain, points=3001),
        trace(f4, ENLARGED),
        trace(g.power(4), ENLARGED),
        s4,
    )


def draw(data: Data, figure: Figure) -> None:
    """Draw three panels; circles mark S4, as in the paper."""
    axes = figure.subplots(1, 3)
    curves = (data.whole, data.before, data.after)
    for ax, letter, curve in zip(axes, "abc", curves, strict=True):
        window = data.domain if curve is data.whole else ENLARGED
        enlarged = curve is not data.whole
        draw_curve(curve, ax, window=window, power=4, linewidth=0.9, ticks=4, jumps=enlarged)
        panel_letter(ax, letter)
    circle: dict[str, Any] = {"mfc": "white", "mew": 1.0, "ms": 4.5}
    mark_orbit(axes[0], data.s4, power=4, **circle)
    mark_orbit(axes[1], data.s4[:1], power=4, **circle)


def caption(data: Data) -> str:
    """Describe the panels and the enlarged window."""
    return (
        f"Fourth iterated map: (a) V = {VELOCITIES[0]:g}, circles: S4; (b) enlarged, "
        f"{ENLARGED[0]:g} < d < {ENLARGED[1]:g} (our choice), dotted: the jump; (c) the same for "
        f"V = {VELOCITIES[1]:g}, where S4 has met the jump and is gone. The point of S4 in (b) is "
        f"d = {data.s4[0]:.10f}."
    )
