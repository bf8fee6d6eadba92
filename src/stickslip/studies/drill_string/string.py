"""Steady rotation, stick-slip cycles and cycles that never stick, along the drive."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from scipy.optimize import brentq

from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.following import follow
from stickslip.mechanics.cycle.equilibria import Equilibrium, equilibria
from stickslip.mechanics.cycle.return_map import return_map
from stickslip.mechanics.cycle.stroboscopic import stroboscopic_map
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.file import read_model
from stickslip.studies.smoothed import SmoothMotion, smoothed

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
    from stickslip.mechanics.model.structure import StateSpace
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


@dataclass(frozen=True)
class Turning:
    """A cycle that never sticks: drive, slowest state, period, moduli of its multipliers."""

    drive: float
    state: Floats
    period: float
    multipliers: Floats

    @property
    def motion(self) -> Trajectory:
        """One period, from the lower disc's slowest speed on."""
        return simulate(MODEL.replace(**{DRIVE: self.drive}), self.state, [], t_end=self.period)


SHARES: Final = (*np.linspace(0.995, 0.05, 22).tolist(), 0.03, 0.02, 0.01, 5e-3, 1e-3, 1e-5, 1e-7)
"""Of steady rotation's speed at the Hopf point: the slowest of the lower disc."""
CONVERGED: Final = 1e-12
MOST: Final = 12  # steps of Newton's method


@cache
def turning() -> tuple[Turning, ...]:
    """Follow cycles that never stick from steady rotation to the touch of stick.

    Where the lower disc is slowest its acceleration is 0, so that the twist is known: the speed
    of the upper disc, the period and the drive are solved for.
    """
    drive, speed, frequency = hopf()
    unknown = np.array([speed, 2.0 * math.pi / frequency, drive])  # of the linear equations
    before, there = (1.0, unknown), (1.0, unknown)
    found: list[Turning] = []
    for share in SHARES:
        far = (share - there[0]) / (there[0] - before[0]) if found[1:] else 0.0
        unknown, multipliers = _turn(there[1] + far * (there[1] - before[1]), share * speed)
        before, there = there, (share, unknown)
        upper, period, needed = unknown.tolist()
        found.append(Turning(needed, _slowest(upper, share * speed), period, multipliers))
    return tuple(found)


def _slowest(upper: float, s: float) -> Floats:
    return np.array([INVERSE * STATIC * LAW.force(s) / LOWER, upper, s])


def _turn(unknown: Floats, s: float) -> tuple[Floats, Floats]:
    """Solve for the upper disc's speed, the period and the drive, by Newton's method."""
    for _ in range(MOST):
        upper, period, drive = unknown.tolist()
        f = stroboscopic_map(MODEL.replace(**{DRIVE: drive}), period=period)
        start = _slowest(upper, s)
        end, flow = f(start), f.derivative(start)
        force = STATIC * LAW.force(float(end[2]))
        rate = MODEL.A @ end + [0.0, drive, 0.0] - MODEL.B[:, 0] * force
        matrix = np.column_stack(
            [(flow - np.eye(3))[:, 1], rate, f.parameter_derivative(start, DRIVE)]
        )
        step = np.linalg.solve(matrix, start - end)
        unknown = unknown + step
        if np.abs(step).max() <= CONVERGED * np.abs(unknown).max():
            break
    return unknown, np.sort(np.abs(np.linalg.eigvals(flow)))[::-1]


# --- friction made smooth -------------------------------------------------------------------

WIDTHS: Final = (0.5, 0.2, 0.05, 0.01)
BELOW: Final = 0.98  # of the drive at which stick-slip ends
LONG: Final = 300.0


@dataclass(frozen=True)
class Smooth:
    """A smooth law beside the exact cycle: range of the lower disc's speed at the end."""

    width: float
    motion: SmoothMotion

    @property
    def swing(self) -> float:
        """Range of the lower disc's speed in the last twentieth of the time."""
        return float(np.ptp(self.motion.v[self.motion.t > 0.95 * LONG, 2]))


@cache
def smooth_motions() -> tuple[float, tuple[Smooth, ...]]:
    """Return the exact range of speed, and motions with smooth laws from the exact cycle."""
    drive = BELOW * stick_end().value
    exact = period_of(drive, float(stick_slip().at(**{DRIVE: drive}).points[0]))
    swing = float(np.ptp(exact.x(np.linspace(0.0, exact.t[-1], 513))[:, 2]))
    start, model = exact.x(0.0), MODEL.replace(**{DRIVE: drive})
    runs = [Smooth(w, smoothed(model, w, np.zeros(0), start, LONG)) for w in WIDTHS]
    return swing, tuple(runs)
