"""An elastic friction damper: cycles in closed form, exact ones, harmonic balance beside."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, TypeAlias, cast

import numpy as np
from scipy.optimize import brentq, minimize_scalar, root

from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.model.file import read_model

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.model.contact import Harmonic
    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats

Pair: TypeAlias = tuple[float, float]

MODEL: Final = cast("Structure", read_model(Path(__file__).with_name("model.toml")))
BLADE: Final = cast("Structure", read_model(Path(__file__).with_name("blade.toml")))
SPRING: Final = 1.0  # of the contact
FREQUENCY: Final = "forcing.frequency"


# --- one mass, exactly ----------------------------------------------------------------------


@dataclass(frozen=True)
class Symmetric:
    """A cycle with two slips, from its largest displacement on; kinetic friction is mu load."""

    load: float
    frequency: float
    mu: float
    stick: float  # time of the first stick
    amplitude: float
    phase: float  # of the force there

    @property
    def model(self) -> Structure:
        """With the force of this phase."""
        given = {"static_1": self.load, "mu_1": self.mu, FREQUENCY: self.frequency}
        return MODEL.replace(**given, **{"forcing.phase": self.phase})

    @property
    def start(self) -> tuple[list[float], list[float]]:
        """Displacements and velocities of the mass and the foot at the largest displacement."""
        return [self.amplitude, self.amplitude - self.mu * self.load / SPRING], [0.0, 0.0]

    @property
    def lost(self) -> float:
        """Energy that the contact takes in a period: by sliding, and as its spring snaps back."""
        snap = (1.0 - self.mu**2) * self.load**2 / (2.0 * SPRING)
        return 2.0 * (self.mu * self.load * self.slid + snap)

    @property
    def slid(self) -> float:
        """Way of the foot in half a period, less the jump as it breaks away."""
        return 2.0 * self.amplitude - (1.0 + self.mu) * self.load / SPRING


TIMES: Final = 240  # of a stick, at which the equation is evaluated before it is solved


def symmetric(load: float, frequency: float, mu: float = 1.0) -> tuple[Symmetric, ...]:
    """Solve one equation in the time of a stick; the largest cycle first."""
    half = math.pi / frequency
    times = np.linspace(0.0, half, TIMES + 1)[1:-1].tolist()

    def excess(t: float) -> float:
        _, a, b = _turn(t, load, frequency, mu)
        return math.hypot(a, b) - 1.0

    values = [excess(t) for t in times]
    found = []
    for k, (e, f) in enumerate(itertools.pairwise(values)):
        if e * f < 0.0 and abs(e) + abs(f) < 10.0:  # else a pole of the linear equations
            t = float(brentq(excess, times[k], times[k + 1], xtol=1e-16))
            amplitude, a, b = _turn(t, load, frequency, mu)
            made = Symmetric(load, frequency, mu, t, amplitude, math.atan2(b, a))
            found += [made] if made.slid > 0.0 else []
    return tuple(sorted(found, key=lambda each: -each.amplitude))


def _turn(stick: float, load: float, frequency: float, mu: float) -> tuple[float, float, float]:
    """Amplitude and both parts of the force of a cycle with a given time of stick.

    Half a period leads from one largest displacement to the other; at the end of the stick the
    spring is at its limit. Given the time, these three conditions are linear.
    """
    rows = []  # displacement and velocity, in terms of (amplitude, cosine, sine, load)
    state = np.array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]])
    held, slips = np.array([SPRING, 0.0, 0.0, -mu]), np.array([0.0, 0.0, 0.0, mu])
    half = math.pi / frequency
    for stiff, pull, start, end in (
        (1.0 + SPRING, held, 0.0, stick),
        (1.0, slips, stick, half),
    ):
        gain, w = 1.0 / (stiff - frequency**2), math.sqrt(stiff)
        forced = []
        for angle in (frequency * start, frequency * end):
            c, s = gain * math.cos(angle), gain * math.sin(angle)
            moved = pull / stiff + np.array([0.0, c, -s, 0.0])
            forced.append(np.array([moved, -frequency * np.array([0.0, s, c, 0.0])]))
        (x, v), t = state - forced[0], w * (end - start)
        turned = (math.cos(t) * x + math.sin(t) / w * v, math.cos(t) * v - w * math.sin(t) * x)
        state = np.array(turned) + forced[1]
        rows.append(state)
    shift = np.array([1.0, 0.0, 0.0, 0.0])
    limit = np.array([0.0, 0.0, 0.0, (1.0 + mu) / SPRING])
    equations = np.array([rows[0][0] - shift + limit, rows[1][0] + shift, rows[1][1]])
    amplitude, a, b = np.linalg.solve(equations[:, :3], -load * equations[:, 3]).tolist()
    return amplitude, a, b


def breaks_loose(load: float) -> float:
    """Frequency below the resonance from which on a stuck contact has to slip."""
    return math.sqrt(1.0 + SPRING - SPRING / load)


# --- any structure with one elastic contact, exactly ----------------------------------------


def swing(found: Cycle, body: int) -> float:
    """Half the range of a displacement over a cycle, between times at which it turns."""
    t = np.linspace(0.0, found.period, 1025)
    x = found.trajectory.x(t)[:, body]
    high, low = (_extreme(found, body, float(t[k])) for k in (np.argmax(x), np.argmin(x)))
    return 0.5 * (high - low)


def _extreme(found: Cycle, body: int, near: float) -> float:
    """Displacement where it turns next to a time."""
    run, step = found.trajectory, found.period / 1024.0
    low, high = max(near - step, 0.0), min(near + step, found.period)
    v = [float(run.v(t)[body]) for t in (low, high)]
    if v[0] * v[1] < 0.0:
        near = float(brentq(lambda t: float(run.v(t)[body]), low, high, xtol=1e-15))
    return float(run.x(near)[body])


@cache
def response(
    model: Structure, load: float, frequencies: tuple[float, ...], body: int = 0
) -> tuple[Floats, tuple[Cycle, ...]]:
    """Follow the cycle from frequency to frequency: half its range, and the cycles."""
    given = model.replace(static_1=load)
    x, v = np.zeros(len(model.mass)), np.zeros(len(model.mass))
    found = []
    for frequency in frequencies:
        found.append(find_cycle(given.replace(**{FREQUENCY: frequency}), x, v))
        x, v = found[-1].x, found[-1].v
    return np.array([swing(each, body) for each in found]), tuple(found)


# --- harmonic balance -----------------------------------------------------------------------


def describing(amplitude: float, load: float) -> complex:
    """Complex stiffness of the elastic contact for a sinusoidal displacement (one harmonic)."""
    if amplitude * SPRING <= load:
        return complex(SPRING)
    angle = math.acos(1.0 - 2.0 * load / (SPRING * amplitude))
    storing = SPRING / math.pi * (angle - 0.5 * math.sin(2.0 * angle))
    losing = 4.0 * load / (math.pi * amplitude) * (1.0 - load / (SPRING * amplitude))
    return complex(storing, losing)


def _receptance(model: Structure, frequency: float) -> Any:
    """Displacements per force, without the contact."""
    inertia = np.diag(model.mass)
    dynamic = model.stiffness - frequency**2 * inertia + 1j * frequency * model.damping
    return np.linalg.inv(dynamic)


def _forces(model: Structure) -> Any:
    (wave,) = cast("tuple[Harmonic, ...]", model.forcing)
    return np.array(wave.amplitudes(len(model.mass)), dtype=complex)


def one_harmonic(model: Structure, load: float, frequency: float, body: int = 0) -> float:
    """Amplitude by balance of one harmonic; the contact is at the first body."""
    gain, forces = _receptance(model, frequency), _forces(model)
    free = gain @ forces
    contact = _contact(gain, free, load)
    held = describing(abs(contact), load)
    return float(abs(free[body] - gain[body, 0] * held * contact))


def _contact(gain: Any, free: Any, load: float) -> complex:
    """Displacement at the contact, one harmonic."""

    def excess(a: float) -> float:
        return abs(1.0 + gain[0, 0] * describing(a, load)) * a - abs(free[0])

    a = float(brentq(excess, 0.0, 1e6, xtol=1e-15, rtol=1e-14))
    return complex(free[0] / (1.0 + gain[0, 0] * describing(a, load)))


SAMPLES: Final = 512
HARMONICS: Final = np.arange(1, 16, 2)


def many_harmonics(model: Structure, load: float, frequency: float, body: int = 0) -> float:
    """Half the range by balance of odd harmonics, the contact's force by alternating in time."""
    gains = np.array([_receptance(model, frequency * k) for k in HARMONICS.tolist()])
    free = np.zeros((len(HARMONICS), len(model.mass)), dtype=complex)
    free[0] = gains[0] @ _forces(model)
    turn = np.exp(2j * np.pi * np.outer(np.arange(SAMPLES), HARMONICS) / SAMPLES)

    def displaced(parts: Any, at: int) -> Any:
        force = jenkins((turn @ parts).real, load)
        return free[:, at] - gains[:, at, 0] * (2.0 / SAMPLES * (turn.conj().T @ force))

    def residual(z: Floats) -> Any:
        parts = z.view(complex)
        return (parts - displaced(parts, 0)).view(float)

    start = np.zeros(len(HARMONICS), dtype=complex)
    start[0] = _contact(gains[0], free[0], load)
    parts = root(residual, start.view(float), tol=1e-10).x.view(complex)
    return 0.5 * float(np.ptp((turn @ displaced(parts, body)).real))


def jenkins(u: Floats, load: float) -> Floats:
    """Force of the elastic contact over a period of its displacement, once it repeats."""
    f, last, found = 0.0, float(u[-1]), []
    for x in [*u.tolist(), *u.tolist()]:
        f = min(load, max(-load, f + SPRING * (x - last)))
        last = x
        found.append(f)
    return np.array(found[len(u) :])


# --- the best friction force ----------------------------------------------------------------

BEST: Final = 0.5 * math.pi  # by balance of one harmonic, without damping: pi F / 2
LEAST: Final = math.pi / SPRING  # the largest amplitude then


@cache
def peak(load: float) -> Pair:
    """Frequency and amplitude where the exact response of one mass is largest."""

    def lost(frequency: float) -> float:
        found = symmetric(load, frequency)
        return -(found[0].amplitude if found else 0.0)

    frequency, value = _least(lost, 1.02, 1.42, 1e-7)
    return frequency, -value


def _least(func: Callable[[float], float], low: float, high: float, to: float) -> Pair:
    """Place and value of a minimum."""
    found = minimize_scalar(func, bounds=(low, high), method="bounded", options={"xatol": to})
    return float(found.x), float(found.fun)


def peak_of_one_harmonic(load: float) -> float:
    """Amplitude at the resonance by balance of one harmonic, without damping."""
    return 4.0 * load**2 / (SPRING * (4.0 * load - math.pi))


@cache
def best() -> Pair:
    """Load at which the exact peak of one mass is smallest, and the peak."""
    return _least(lambda load: peak(load)[1], 1.4, 1.7, 1e-5)


# --- the blade ------------------------------------------------------------------------------

TIP: Final = 2
LOADS: Final = (1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0)
NEAR: Final = (0.43, 0.53)
"""Frequencies of the first resonance, with the contact free and stuck."""


@cache
def blade_peak(load: float) -> Pair:
    """Largest amplitude of the tip near the first resonance: exact, and of one harmonic."""
    state = [np.zeros(3), np.zeros(3)]

    def lost(frequency: float) -> float:
        found = find_cycle(BLADE.replace(static_1=load, **{FREQUENCY: frequency}), *state)
        state[:] = found.x, found.v
        return -swing(found, TIP)

    balanced = _least(lambda w: -one_harmonic(BLADE, load, w, TIP), *NEAR, 1e-5)
    return -_least(lost, *NEAR, 1e-5)[1], -balanced[1]
