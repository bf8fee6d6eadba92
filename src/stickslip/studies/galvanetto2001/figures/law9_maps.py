"""First and second iterates of the event map of law (9)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.attractors.attractor import Attractor
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.maps import Curve, draw_curve, mark_orbit, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.galvanetto2001.orbits import (
    WINDOW,
    cusp_of,
    fixed_points,
    in_window,
    named,
)


# Figure 12: first and second iterated map of law (9) for alpha = 1.208.
def draw_p1(figure: Figure) -> str:
    """Draw both maps over the paper's window with the stable fixed point P1, right of the cusp."""
    model = examples.law9()
    f, window = event_map(model), in_window(model.alpha)
    (p1,) = fixed_points(window)
    d = float(p1.points[0])
    for power, (ax, letter) in enumerate(zip(figure.subplots(1, 2), "ab", strict=True), start=1):
        draw_curve(trace(f.power(power), WINDOW), ax, window=WINDOW, power=power)
        mark_orbit(ax, d, power=power, stable=p1.stable)
        panel_letter(ax, letter)
    return (
        f"(a) First and (b) second iterated map for {named(model)}. The map has its cusp at "
        f"d = {cusp_of(window).d:.6f}; the bold point is the stable fixed point P1, d = {d:.6f}, "
        f"multiplier {p1.multiplier:.5f}."
    )


# Figure 13: second iterated map of law (9) just after its cusps have met the diagonal.
RANGE: Final = (0.3806, 0.3858)  # from left of the first cusp to right of the second; our choice
MAGNIFICATION: Final = 20.0  # of the distance to the diagonal in the first panel; our choice
ROOM: Final = 0.6  # around a cusp, A and B in the enlarged panels, of the distance between them


@dataclass(frozen=True)
class Birth:
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


def compute_birth() -> Birth:
    """Trace f^2 over both cusps and beside each; A and B are the 2-cycles closest to the cusp."""
    model = examples.law9(alpha=1.20915)
    f = event_map(model)
    window = WindowMap(f, WINDOW)
    cusp = cusp_of(window).d
    found = periodic_orbits(window, 2)
    near = sorted(found.of_period(2), key=lambda orbit: abs(float(orbit.points[0]) - cusp))
    b, a = near[:2]
    (before,) = (x for x in window.preimages(cusp) if x > cusp)
    first, last = _around(
        *(np.array([corner, a.points[k], b.points[k]]) for k, corner in enumerate((cusp, before)))
    )
    second = f.power(2)
    return Birth(
        model,
        trace(second, RANGE, points=401),
        (trace(second, first, points=201), trace(second, last, points=201)),
        (first, last),
        (cusp, float(before)),
        found.of_period(1)[0],
        a,
        b,
    )


def _around(*groups: Floats) -> tuple[tuple[float, float], ...]:
    """Windows about groups of points, all of one width."""
    half = (0.5 + ROOM) * max(float(np.ptp(points)) for points in groups)
    middles = [0.5 * float(points.min() + points.max()) for points in groups]
    return tuple((middle - half, middle + half) for middle in middles)


def draw_birth(figure: Figure) -> str:
    """Draw f^2 magnified towards the diagonal, then true to scale beside both cusps."""
    data = compute_birth()
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
    _mark_born(axes[0], data, RANGE, "P")
    for ax, window, corner in zip(axes[1:], data.windows, "12", strict=True):
        _mark_born(ax, data, window, "AB")
        centre, text = 0.5 * sum(window), f"$A_{corner}, B_{corner}$"
        offset = (6, -7) if corner == "1" else (-29, -2)
        axes[0].annotate(text, (centre, centre), offset, textcoords="offset points")
    (a1, a2), (b1, b2) = data.a.points, data.b.points
    return (
        f"Second iterated map g for {named(data.model)}: (a) drawn at the height d + "
        f"{MAGNIFICATION:g} (g(d) - d), so that the distance to the diagonal, at most "
        f"{data.distance:.1e} between the cusps, is magnified {MAGNIFICATION:g} times (our choice; "
        "points on the diagonal stay where they are); (b) and (c) true to scale beside its two "
        f"cusps, at d = {data.cusps[0]:.8f} and {data.cusps[1]:.8f}. Squares: the unstable orbits "
        f"A, d = {a1:.8f}, {a2:.8f} (multiplier {data.a.multiplier:.4f}), and B, d = {b1:.8f}, "
        f"{b2:.8f} (multiplier {data.b.multiplier:.4f}); bold point: the fixed point P1, still "
        "stable."
    )


def _mark_born(ax: Axes, data: Birth, window: tuple[float, float], named: str) -> None:
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


# Figure 14: first and second iterated map of law (9), alpha = 1.211, and its attractor.
@dataclass(frozen=True)
class Chaos:
    """The attractor of the motion that starts at the cusp, and P1."""

    model: TwoBlock
    attractor: Attractor
    p1: float


def compute_chaos() -> Chaos:
    """Identify the attractor."""
    model = examples.law9(alpha=1.211)
    window = in_window(model.alpha)
    (p1,) = fixed_points(window)
    (attractor,) = attractors(window, starts=[cusp_of(window).d])
    return Chaos(model, attractor, float(p1.points[0]))


def draw_chaos(figure: Figure) -> str:
    """Draw the part of each graph over the attractor heavy, the rest light, as in the paper."""
    data = compute_chaos()
    f = event_map(data.model)
    for power, (ax, letter) in enumerate(zip(figure.subplots(1, 2), "ab", strict=True), start=1):
        curve = trace(f.power(power), WINDOW)
        draw_curve(curve, ax, window=WINDOW, power=power, linewidth=0.6)
        for low, high in data.attractor.bands:
            over = (curve.x >= low) & (curve.x <= high)
            ax.plot(
                np.where(over, curve.x, np.nan), curve.y, color=PALETTE["blue"], lw=2.2, zorder=3
            )
        mark_orbit(ax, data.p1, power=power, stable=False)
        panel_letter(ax, letter)
    bands = " and ".join(f"[{low:.8f}, {high:.8f}]" for low, high in data.attractor.bands)
    exponent, error = data.attractor.lyapunov
    return (
        f"(a) First and (b) second iterated map for {named(data.model)}. Heavy: the "
        f"{data.attractor.kind} attractor, two bands {bands} between images of the cusp, Lyapunov "
        f"exponent {exponent:.3f} ± {error:.3f} per step; square: the unstable fixed point P1, "
        f"d = {data.p1:.6f}."
    )


# Figure 16: first iterated map of law (9) shortly before its cusp meets the diagonal.
LOBE: Final = (0.3782, 0.3824)  # around the lobe; our choice
ENLARGED: Final = (0.38025, 0.38065)


@dataclass(frozen=True)
class Lobe:
    """The map's graph, its cusp, and all fixed points around it, S1 for the first."""

    model: TwoBlock
    curve: Curve
    cusp: float
    s1: float
    u1: float
    p1: float


def compute_lobe() -> Lobe:
    """Trace the map; U1 is on the rising side of the cusp, S1 and P1 on falling ones."""
    model = examples.law9(alpha=1.2182)
    f = event_map(model)
    window = WindowMap(f, LOBE)
    s1, u1, p1 = (float(orbit.points[0]) for orbit in fixed_points(window))
    return Lobe(model, trace(f, LOBE), cusp_of(window).d, s1, u1, p1)


def draw_lobe(figure: Figure) -> str:
    """Draw the map with its unstable fixed points and, enlarged, those beside the cusp."""
    data = compute_lobe()
    for ax, letter, window in zip(figure.subplots(1, 2), "ab", (LOBE, ENLARGED), strict=True):
        draw_curve(data.curve, ax, window=window)
        _mark_fixed_points(ax, data, window)
        panel_letter(ax, letter)
    return (
        f"First iterated map for {named(data.model)}: (a) the lobe, (b) its cusp enlarged "
        f"(ranges are our choice). Squares: the unstable fixed points U1, d = {data.u1:.8f}, and "
        f"P1, d = {data.p1:.8f}, on both sides of the cusp d = {data.cusp:.8f}, and S1, "
        f"d = {data.s1:.8f}, unstable since its period doubling."
    )


def _mark_fixed_points(ax: Axes, data: Lobe, window: tuple[float, float]) -> None:
    points = (
        ("$S_1$", data.s1, (-17, -6)),
        ("$U_1$", data.u1, (-17, 2)),
        ("$P_1$", data.p1, (7, -4)),
    )
    for name, d, offset in points:
        if window[0] < d < window[1]:
            mark_orbit(ax, d, stable=False)
            ax.annotate(name, (d, d), offset, textcoords="offset points")


FIGURES: Final = {
    12: PaperFigure("two", 3.5, draw_p1),
    13: PaperFigure("two", 2.35, draw_birth),
    14: PaperFigure("two", 3.5, draw_chaos),
    16: PaperFigure("two", 3.5, draw_lobe),
}
