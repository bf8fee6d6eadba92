"""The event map of the Coulomb system, its fourth iterate and its basins."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.attractors.basins import Basins, basins
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.plot.maps import Curve, draw_curve, draw_steps, mark_orbit, trace
from stickslip.plot.style import PALETTE, panel_letter
from stickslip.studies.figures import PaperFigure
from stickslip.studies.galvanetto2001.orbits import (
    attracting_orbits,
    coulomb_orbits,
    from_point_1,
    jump_of_s4,
    named,
    u4,
)


# Figure 5: event map of the Coulomb system, its attractors and unstable fixed points.
@dataclass(frozen=True)
class Orbits:
    """The map's graph, its orbits up to period 4 by name, and the jump next to S4's point 1."""

    model: TwoBlock
    curve: Curve
    orbits: dict[str, PeriodicOrbit]
    jump: float


def compute_orbits() -> Orbits:
    """Trace the map and find all its orbits up to period 4: the paper marks them all."""
    model = examples.coulomb()
    f = event_map(model)
    return Orbits(model, trace(f, f.domain), coulomb_orbits(f), jump_of_s4(f).d)


def draw_orbits(figure: Figure) -> str:
    """Draw the map; bold points mark attractors, squares unstable orbits, as in the paper."""
    data = compute_orbits()
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    for orbit in data.orbits.values():
        mark_orbit(ax, orbit.points, stable=orbit.stable)
    _names(ax, data)
    slopes = ", ".join(f"{name} {item.multiplier:.4g}" for name, item in data.orbits.items())
    return (
        f"Event map for {named(data.model)} over its whole domain. Bold points: attractors S1 and "
        "S4 (points numbered in their order); squares: unstable fixed points. There are no other "
        f"orbits up to period 4, save infinitely unstable ones. Multipliers: {slopes}."
    )


def _names(ax: Axes, data: Orbits) -> None:
    offsets = {"S1": (-4, -11), "U1": (6, -6), "U2": (7, 2)}
    for name, offset in offsets.items():
        d = data.orbits[name].points[0]
        text = f"${name[0]}_{name[1]}$"
        ax.annotate(text, (d, d), offset, textcoords="offset points")
    s4 = from_point_1(data.orbits["S4"], data.jump)
    for number, d in enumerate(s4, start=1):
        image = s4[number % 4]
        ax.annotate(str(number), (d, image), (-2, 6), textcoords="offset points", ha="right")


# Figure 6: event map of the Coulomb system for V = 0.0370 and its attractor.
@dataclass(frozen=True)
class After:
    """The map's graph and its attractors: the one that follows S4, and S1."""

    model: TwoBlock
    curve: Curve
    attractor: PeriodicOrbit
    s1: PeriodicOrbit


def compute_after() -> After:
    """Trace the map and find its attractors."""
    model = examples.coulomb(V=0.0370)
    f = event_map(model)
    after, s1 = attracting_orbits(f)
    return After(model, trace(f, f.domain), after, s1)


def draw_after(figure: Figure) -> str:
    """Draw the map; bold points mark the attractor, as in the paper."""
    data = compute_after()
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    mark_orbit(ax, data.s1.points)
    mark_orbit(ax, data.attractor.points, ms=2.6)
    p, orbit = data.model.parameters, data.attractor
    return (
        f"Event map for alpha = {p['alpha']:g}, beta = {p['beta']:g}, mu = {p['mu']:g}, "
        f"V = {p['V']:.4f}. Small points: the attractor that follows S4 after its collision with "
        f"the jump, periodic with period {orbit.period} in global stick phases and "
        f"multiplier {orbit.multiplier:.4g}; the paper calls it non-periodic. Large point: S1."
    )


# Figure 8: fourth iterated map of the Coulomb system, before and after the collision.
VELOCITIES: Final = (0.0366, 0.0372)
ENLARGED: Final = (0.2745, 0.2803)  # the paper's enlarged views print no numbers that we have


def draw_fourth(figure: Figure) -> str:
    """Draw f^4 whole, enlarged, and enlarged after the collision; circles: S4, as in the paper."""
    axes = figure.subplots(1, 3)
    f, g = (event_map(examples.coulomb(V=V)) for V in VELOCITIES)
    panels = (f, f.domain, 3001), (f, ENLARGED, 801), (g, ENLARGED, 801)
    for ax, letter, (each, window, points) in zip(axes, "abc", panels, strict=True):
        curve, whole = trace(each.power(4), window, points=points), letter == "a"
        draw_curve(curve, ax, window=window, power=4, linewidth=0.9, ticks=4, jumps=not whole)
        panel_letter(ax, letter, rf"$V_{{\mathrm{{dr}}}} = {each.model.V:g}$")
    s4 = from_point_1(coulomb_orbits(f)["S4"], jump_of_s4(f).d)
    circle: dict[str, Any] = {"mfc": "white", "mew": 1.0, "ms": 4.5}
    mark_orbit(axes[0], s4, power=4, **circle)
    mark_orbit(axes[1], s4[:1], power=4, **circle)
    return (
        f"Fourth iterated map for {named(examples.coulomb(), 'V')}: (a) V = {VELOCITIES[0]:g}, "
        f"circles: S4; (b) enlarged, {ENLARGED[0]:g} < d < {ENLARGED[1]:g} (our choice), dotted: "
        "the jump; (c) the same for "
        f"V = {VELOCITIES[1]:g}, where S4 has met the jump and is gone. The point of S4 in (b) is "
        f"d = {s4[0]:.10f}."
    )


# Figure 9: basins of attraction of the event map of the Coulomb system.
@dataclass(frozen=True)
class Divided:
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


def compute_basins() -> Divided:
    """Find the attractors and divide the domain among them."""
    model = examples.coulomb()
    f = event_map(model)
    found = basins(f)
    s1 = next(k for k, attractor in enumerate(found.attractors) if attractor.period == 1)
    return Divided(model, trace(f, f.domain), found, s1)


def draw_basins(figure: Figure) -> str:
    """Draw the map over its basins; the basin of S1 is hatched, as in the paper."""
    data = compute_basins()
    ax = figure.add_subplot()
    draw_curve(data.curve, ax, window=data.model.domain)
    for low, high in data.hatched:
        ax.axvspan(low, high, fill=False, hatch="\\\\\\\\\\", ec=PALETTE["grey"], lw=0.0, zorder=0)
        ax.axvline(low, color=PALETTE["grey"], lw=0.5, zorder=0)
        ax.axvline(high, color=PALETTE["grey"], lw=0.5, zorder=0)
    for attractor in data.basins.attractors:
        if attractor.orbit is not None:
            mark_orbit(ax, attractor.orbit.points)
    intervals = " and ".join(f"{low:.10f} < d < {high:.10f}" for low, high in data.hatched)
    share = data.basins.share(data.s1)
    return (
        f"Event map for {named(data.model)}; hatched: the basin of S1, {intervals} ({share:.2%} "
        "of the domain); the rest is the basin of S4. Bold points: S1 and S4."
    )


# Figure 10: orbits that start on both sides of the jump reach S4 in different ways.
WINDOWS: Final = ((-0.34, 0.34), (0.2765, 0.2805))
STEPS: Final = 40


@dataclass(frozen=True)
class Transients:
    """Graphs of f^4 in two windows; S4, U4 from the jump on; f^4-orbits (STEPS + 1,) from there."""

    curves: tuple[Curve, Curve]
    s4: Floats
    u4: Floats
    from_left: Floats
    from_right: Floats


def compute_transients() -> Transients:
    """Trace f^4 and iterate it from the floats on both sides of the jump next to S4."""
    f = event_map(examples.coulomb())
    f4 = f.power(4)
    jump = jump_of_s4(f)
    left, right = jump.interval
    s4, unstable = (from_point_1(orbit, jump.d) for orbit in (coulomb_orbits(f)["S4"], u4(f)))
    curves = (trace(f4, WINDOWS[0], points=2001), trace(f4, WINDOWS[1]))
    return Transients(curves, s4, unstable, f4.iterate(left, STEPS), f4.iterate(right, STEPS))


def draw_transients(figure: Figure) -> str:
    """Draw both windows with the two transients, S4 and the points of U4."""
    data = compute_transients()
    axes = figure.subplots(1, 2)
    for ax, letter, curve, window in zip(axes, "ab", data.curves, WINDOWS, strict=True):
        draw_curve(curve, ax, window=window, power=4, jumps=letter == "b")
        draw_steps(ax, data.from_left, color=PALETTE["blue"], label="from the left of the jump")
        draw_steps(ax, data.from_right, color=PALETTE["orange"], label="from its right")
        _mark(ax, data, window)
        panel_letter(ax, letter)
    axes[1].legend(loc="upper left")
    points = ", ".join(f"{d:.6f}" for d in data.u4)
    return (
        f"Fourth iterated map for {named(examples.coulomb())}: (a) over "
        f"{WINDOWS[0][0]:g} < d < {WINDOWS[0][1]:g} "
        f"and (b) enlarged (our choice). From the left side of the jump d = {data.u4[0]:.10f} the "
        "orbit climbs down to the nearest point of S4; from the right side it leaves for "
        f"d = {data.from_right[1]:.4f} and settles at d = {data.from_right[-1]:.4f}, another "
        f"point of S4. Squares: the infinitely unstable U4, d = {points}; the first is on the jump."
    )


def _mark(ax: Axes, data: Transients, window: tuple[float, float]) -> None:
    s4, unstable = (d[(d > window[0]) & (d < window[1])] for d in (data.s4, data.u4))
    mark_orbit(ax, unstable, power=unstable.size, stable=False)
    mark_orbit(ax, s4, power=s4.size, ms=3.0)
    for d in unstable:
        ax.annotate("$U_4$", (d, d), (-6, 4), textcoords="offset points", ha="right")
    for d in s4:
        ax.annotate("$S_4$", (d, d), (-1, -16), textcoords="offset points")


FIGURES: Final = {
    5: PaperFigure("one", 3.3, draw_orbits),
    6: PaperFigure("one", 3.3, draw_after),
    8: PaperFigure("two", 2.5, draw_fourth),
    9: PaperFigure("one", 3.3, draw_basins),
    10: PaperFigure("two", 3.5, draw_transients),
}
