"""Steady rotation, stick-slip cycles and cycles that never stick, along the drive."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from scipy.optimize import brentq

from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.following import follow
from stickslip.mechanics.cycle.equilibria import Equilibrium, equilibria
from stickslip.mechanics.cycle.return_map import return_map
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.structure import StateSpace, Structure
from stickslip.numerics.zeros import middle_zero
from stickslip.studies.smoothed import SmoothMotion, smoothed

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.numerics.arrays import Floats

MODEL: Final = cast("StateSpace", read_model(Path(__file__).with_name("model.toml")))
DRIVE: Final = "a_2"
RANGE: Final = (2.0, 60.0)
(LAW,) = MODEL.laws
STATIC: Final = MODEL.contacts[0].static
TWIST, DAMPED, LOWER = -float(MODEL.A[1, 0]), -float(MODEL.A[1, 1]), float(MODEL.A[2, 0])
INVERSE: Final = float(MODEL.B[2, 0])  # of the lower disc's inertia
SPREAD: Final = (0.0, 20.0)
"""Speeds of the upper disc at a release among which cycles are searched."""


# --- steady rotation, in closed form --------------------------------------------------------


def drive_of(speed: float) -> float:
    """Drive that turns both discs steadily at a speed."""
    twist = INVERSE * STATIC * LAW.force(speed) / LOWER
    return TWIST * twist + DAMPED * speed


def hopf() -> tuple[float, float, float]:
    """Drive, speed and frequency where steady rotation changes its stability, by Routh's test."""

    def coefficients(speed: float) -> tuple[float, float, float]:
        d = INVERSE * STATIC * LAW.slope(speed)
        return DAMPED + d, TWIST + LOWER + DAMPED * d, TWIST * d + LOWER * DAMPED

    def excess(speed: float) -> float:
        first, second, third = coefficients(speed)
        return first * second - third

    speed = float(brentq(excess, 1.0, 20.0, xtol=1e-15))
    return drive_of(speed), speed, math.sqrt(coefficients(speed)[1])


def rotation(drive: float) -> Equilibrium:
    """Steady rotation at a drive, the fastest if there are several."""
    found = equilibria(MODEL.replace(**{DRIVE: drive}))
    return max(found, key=lambda each: float(each.w[0]))


@cache
def computed_hopf() -> CurveEvent:
    """Find the change of stability by continuation."""
    (found,) = follow(rotation(RANGE[1]), DRIVE, RANGE).bifurcations
    return found


# --- cycles ---------------------------------------------------------------------------------


@cache
def stick_slip() -> Curve:
    """Follow the cycle that sticks, from release to release, along the drive."""
    f = return_map(MODEL, direction="forward", domain=SPREAD)
    (orbit,) = periodic_orbits(f, max_period=1)
    return follow(orbit, DRIVE, RANGE)


def stick_end() -> CurveEnd:
    """Where the branch ends as the stick has no length."""
    (found,) = (end for end in stick_slip().ends if end.reason == "gap")
    return found


def period_of(drive: float, point: float) -> Trajectory:
    """One period of the cycle that sticks, from its release on."""
    f: Any = return_map(MODEL.replace(**{DRIVE: drive}), direction="forward", domain=SPREAD)
    found: Trajectory = f.slip_from(point, 1000)
    return found


@cache
def cycles() -> Curve:
    """Follow the cycle that the string settles on from rest, and what it meets, along the drive."""
    return follow(find_cycle(MODEL, np.zeros(3), []), DRIVE, RANGE)


@cache
def turning() -> tuple[Cycle, ...]:
    """Cycles that never stick, from steady rotation to the touch of stick."""
    return tuple(cycle for cycle in reversed(list(cycles())) if not cycle.events)


def drive_at(cycle: Cycle) -> float:
    """Drive of a cycle."""
    return cycle.model.parameters[DRIVE]


def lower_speed(motion: Trajectory) -> Floats:
    """Speeds of the lower disc over a motion."""
    return motion.x(np.linspace(0.0, motion.t[-1], 513))[:, 2]


# --- friction made smooth -------------------------------------------------------------------

WIDTHS: Final = (0.5, 0.2, 0.05, 0.01)
BELOW: Final = 0.98  # of the drive at which stick-slip ends
LONG: Final = 300.0


def swing_left(run: SmoothMotion) -> float:
    """Range of the lower disc's speed in the last twentieth of the time."""
    return float(np.ptp(run.v[run.t > 0.95 * LONG, 2]))


@cache
def smooth_motions() -> tuple[float, tuple[SmoothMotion, ...]]:
    """Return the exact range of speed, and motions with smooth laws from the exact cycle."""
    drive = BELOW * stick_end().value
    exact = period_of(drive, float(stick_slip().at(**{DRIVE: drive}).points[0]))
    swing = float(np.ptp(lower_speed(exact)))
    start, model = exact.x(0.0), MODEL.replace(**{DRIVE: drive})
    # At the usual tolerance rounding decides whether LSODA leaves a swing of 1e-4 or of 1e-9.
    rest = np.zeros(0)
    return swing, tuple(smoothed(model, w, rest, start, LONG, rtol=1e-8) for w in WIDTHS)


# --- a string of many elements --------------------------------------------------------------

ELEMENTS: Final = 20
LINE: Final = 0.03  # inertia of the string; as much of the lower disc's is its own
FADING: Final = 0.02  # of the string's damping: torque over stiffness and rate of twist
DRIVES: Final = (16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0)
FINEST: Final = 2e-3
SETTLED: Final = 150.0
UPPER: Final = LOWER / (INVERSE * TWIST)
SPRING: Final = LOWER / INVERSE


def inertias(n: int) -> Floats:
    """Inertias from the motor down; one element: a third of the string joins the lower disc."""
    if n == 1:
        return np.array([UPPER, LINE + LINE / 3.0])
    ends = np.r_[UPPER, np.zeros(n - 1), LINE]
    return ends + LINE / n * np.r_[0.5, np.ones(n - 1), 0.5]


def long_string(drive: float, n: int = ELEMENTS) -> StateSpace:
    """Twists of n equal springs and the speeds of n + 1 discs, driven as the two discs are."""
    turn, inverse = np.eye(n, n + 1) - np.eye(n, n + 1, 1), 1.0 / inertias(n)
    matrix = np.zeros((2 * n + 1, 2 * n + 1))
    matrix[:n, n:] = turn
    matrix[n:, :n] = -inverse[:, None] * turn.T * n * SPRING
    matrix[n:, n:] = FADING * matrix[n:, :n] @ turn
    matrix[n, n] -= DAMPED * UPPER * inverse[0]
    into = np.zeros((2 * n + 1, 1))
    into[-1] = inverse[-1]
    given = np.zeros(2 * n + 1)
    given[n] = drive * UPPER * inverse[0]
    rubs = np.eye(1, 2 * n + 1, 2 * n)
    return Structure.from_state_space(matrix, into, rubs, a=given, contacts=MODEL.contacts)


@cache
def long_hopf(n: int = ELEMENTS) -> tuple[float, float]:
    """Drive and frequency where rotation changes its stability, by a continued fraction."""

    def impedance(frequency: float) -> complex:
        top, *others = inertias(n).tolist()
        spring = n * SPRING * (1.0 / (1j * frequency) + FADING)
        found = 1j * frequency * top + DAMPED * UPPER
        for inertia in others:
            found = 1j * frequency * inertia + 1.0 / (1.0 / found + 1.0 / spring)
        return found

    frequency = float(brentq(lambda w: impedance(w).imag, 1.0, 2.0, xtol=1e-15))
    slope = -impedance(frequency).real / STATIC
    speed = float(brentq(lambda w: LAW.slope(w) - slope, 1.0, 20.0, xtol=1e-15))
    return drive_of(speed), frequency


@cache
def computed_long_hopf(n: int = ELEMENTS) -> tuple[float, float]:
    """Drive and frequency where the first eigenvalues of steady rotation cross the axis."""

    def first(drive: float) -> complex:
        found = equilibria(long_string(drive, n))
        values = max(found, key=lambda each: float(each.w[0])).eigenvalues
        return complex(values[np.argmax(values.real)])

    drive = middle_zero(lambda u: first(u).real, 15.0, 30.0)
    return drive, abs(first(drive).imag)


@cache
def long_cycles(n: int = ELEMENTS) -> tuple[Cycle, ...]:
    """Stick-slip at each of the drives: from rest, then each from the one before."""
    found, x = [], np.zeros(2 * n + 1)
    for drive in DRIVES:
        found.append(find_cycle(long_string(drive, n), x, []))
        x = found[-1].x
    return tuple(found)


@cache
def long_end(n: int = ELEMENTS) -> float:
    """Drive up to which stick-slip goes on, walked up from the last cycle in steps that shrink."""
    drive, x, step = DRIVES[-1], long_cycles(n)[-1].x, 1.0
    while step > FINEST:
        run = simulate(long_string(drive + step, n), x, [], t_end=SETTLED)
        if run.events and run.events[-1].time > 0.9 * SETTLED:
            drive, x = drive + step, run.final_state.x
        else:
            step *= 0.5
    return drive
