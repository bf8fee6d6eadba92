"""Two sliders upon each other: exact times in rational numbers, break-away, and the usual tools."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias, cast

import numpy as np
from scipy.optimize import brentq

from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.structure import Structure
from stickslip.studies.smoothed import SmoothMotion, smoothed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.numerics.arrays import Floats

Pair: TypeAlias = tuple[Fraction, Fraction]

WALLED: Final = cast("Structure", read_model(Path(__file__).with_name("model.toml")))
STACK: Final = WALLED.replace(contacts=[WALLED.contacts[0], WALLED.contacts[2]])
"""Without the wall: contacts of the lower slider with the ground, of the upper with the lower."""


# --- sliders that were pushed ---------------------------------------------------------------


@dataclass(frozen=True)
class Stack:
    """Masses, friction forces and speeds at the start: of the lower and the upper slider."""

    mass: Pair
    limit: Pair  # on the ground, between them
    v: Pair

    @property
    def model(self) -> Structure:
        """As a structure."""
        (m1, m2), (f1, f2) = (tuple(map(float, pair)) for pair in (self.mass, self.limit))
        return STACK.replace(mass_1=m1, mass_2=m2, static_1=f1, static_2=f2)

    def motion(self) -> Trajectory:
        """Follow the motion beyond the time of rest."""
        rest = float(stages(self)[-1].t)
        return simulate(self.model, [0.0, 0.0], [float(v) for v in self.v], t_end=1.25 * rest)


def stack(*numbers: str | int) -> Stack:
    """Make a stack of two masses, two friction forces and two speeds, rational numbers."""
    a, b, c, d, e, f = map(Fraction, numbers)
    return Stack((a, b), (c, d), (e, f))


THROWN: Final = stack(2, 1, "3/5", 1, 0, 3)  # the upper one
PULLED: Final = stack(2, 1, "6/5", "3/10", 3, 0)  # the lower one, away from under the other


@dataclass(frozen=True)
class Stage:
    """What is at the end of a stretch of constant accelerations."""

    t: Fraction
    x: Pair
    v: Pair
    heat: Pair  # of the contacts, since the start


def stages(given: Stack) -> tuple[Stage, ...]:
    """Follow two sliders from one equality of speeds to the next, in rational numbers."""
    t, x, v, heat = Fraction(0), (Fraction(0),) * 2, given.v, (Fraction(0),) * 2
    found = [Stage(t, x, v, heat)]
    while any(v):
        a1, a2 = _accelerations(given, v)
        speeds = [(v[0], a1), (v[1], a2), (v[1] - v[0], a2 - a1)]
        step = min(-w / a for w, a in speeds if w * a < 0)
        shift = tuple(w * step + a * step**2 / 2 for w, a in speeds)
        heat = (heat[0] + given.limit[0] * abs(shift[0]), heat[1] + given.limit[1] * abs(shift[2]))
        t, x = t + step, (x[0] + shift[0], x[1] + shift[1])
        v = (v[0] + a1 * step, v[1] + a2 * step)
        found.append(Stage(t, x, v, heat))
    return tuple(found)


def _accelerations(given: Stack, v: Pair) -> Pair:
    """Balance forces by case: slip between the sliders or not, the lower one at rest or not."""
    (m1, m2), (ground, between) = given.mass, given.limit
    backward = -ground if v[0] > 0 else ground
    together = backward / (m1 + m2)
    if v[0] == v[1] and m2 * abs(together) <= between:
        return together, together
    ahead = v[1] - v[0] if v[0] != v[1] else -together
    drag = between if ahead > 0 else -between  # on the lower slider
    if v[0] == 0 and between <= ground:
        return Fraction(0), -drag / m2
    if v[0] == 0:
        backward = -ground if drag > 0 else ground
    return (drag + backward) / m1, -drag / m2


def random_stacks(n: int) -> tuple[Stack, ...]:
    """Draw stacks pushed at either slider; n of them."""
    rng = np.random.default_rng(7)
    drawn = []
    for _ in range(n):
        m1, m2, f1, f2, v = (Fraction(int(k), 8) for k in rng.integers(2, 40, size=5))
        push = (v, Fraction(0)) if rng.random() < 0.5 else (Fraction(0), v)
        drawn.append(Stack((m1, m2), (f1, f2), push))
    return tuple(drawn)


def largest_error(given: Stack) -> float:
    """Relative error of event times, displacements and heat of a followed motion."""
    found, exact = given.motion(), stages(given)
    last = exact[-1]
    times = sorted({event.time for event in found.events} | {0.0})
    if len(times) != len(exact):
        return np.inf
    ends = found.final_state.x
    heat = found.energy([0.0, found.t[-1]]).dissipation[-1]
    pairs = [
        *zip(times, [float(each.t) for each in exact], strict=True),
        *zip(ends, map(float, last.x), strict=True),
        (heat, float(sum(last.heat))),
    ]
    return max(abs(a - b) / max(abs(b), 1.0) for a, b in pairs)


# --- break-away where a wall holds the upper slider as well ---------------------------------

PULL: Final = 0.5  # rate at which the force on the lower slider grows


def pulled(between: float) -> Structure:
    """Two sliders and a wall; a third body that nothing slows pulls the lower one by a spring."""
    spring = np.zeros((3, 3))
    spring[0, 0], spring[0, 2] = 1.0, -1.0
    model = WALLED.replace(static_3=between)
    return Structure(mass=[*model.mass, 1.0], stiffness=spring, contacts=list(model.contacts))


def break_away(between: float) -> tuple[float, tuple[int, ...]]:
    """Force at which something moves, and the contacts that slip (from 0)."""
    run = simulate(pulled(between), np.zeros(3), [0.0, 0.0, PULL], t_end=4.0)
    first = run.events[0].time
    return PULL * first, tuple(event.block - 1 for event in run.events if event.time == first)


def mechanism(between: float) -> tuple[float, tuple[int, ...]]:
    """Say the same in closed form: the weaker of two ways to move."""
    ground, wall, _ = (contact.static for contact in WALLED.contacts)
    alone, both = ground + between, ground + wall
    return (alone, (0, 2)) if alone < both else (both, (0, 1))


# --- usual tools ----------------------------------------------------------------------------


def stepped(
    model: Structure, v: Sequence[float], h: float, t_end: float
) -> tuple[Floats, Floats, Floats]:
    """Step by Moreau's scheme, contacts by projected Gauss-Seidel: times, positions, speeds."""
    rows, limits = model.plant.out, model.plant.static
    lead = rows / np.asarray(model.mass)
    own = np.einsum("ij,ij->i", lead, rows)
    free = (model.plant.force / np.asarray(model.mass)) * h
    speeds = [np.array(v, dtype=float)]
    for _ in range(round(t_end / h)):
        u, p = speeds[-1] + free, np.zeros(len(rows))
        for _ in range(200):
            before = p.copy()
            for k, row in enumerate(rows):
                pushed = np.clip(p[k] - row @ u / own[k], -limits[k] * h, limits[k] * h)
                u, p[k] = u + lead[k] * (pushed - p[k]), pushed
            if np.abs(p - before).max() <= 1e-15:
                break
        speeds.append(u)
    velocities: Floats = np.array(speeds)
    positions: Floats = np.vstack([np.zeros(2), np.cumsum(velocities[1:], axis=0) * h])
    times: Floats = np.asarray(h * np.arange(len(speeds)), dtype=np.float64)
    return times, positions, velocities


WIDTHS: Final = (1e-1, 1e-2, 1e-3)
HELD: Final = 0.9  # of the force at which the sliders at the wall break away
CREPT: Final = 50.0


@cache
def creeping() -> tuple[SmoothMotion, ...]:
    """Pull below break-away, with smooth friction, from rest."""
    weight = HELD * mechanism(WALLED.contacts[2].static)[0]
    still = WALLED.replace(force=[weight, 0.0])
    return tuple(smoothed(still, width, np.zeros(2), np.zeros(2), CREPT) for width in WIDTHS)


def creep_speed(width: float) -> float:
    """Speed of the lower slider with smooth friction, by the balance of forces."""
    ground, wall, between = (contact.static for contact in WALLED.contacts)
    weight = HELD * mechanism(between)[0]

    def upper(v: float) -> float:
        def excess(u: float) -> float:
            return between * np.tanh((v - u) / width) - wall * np.tanh(u / width)

        return float(brentq(excess, 0.0, v, xtol=1e-18))

    def excess(v: float) -> float:
        return ground * np.tanh(v / width) + wall * np.tanh(upper(v) / width) - weight

    return float(brentq(excess, 0.0, 50.0 * width, xtol=1e-18))
