"""A clutch between two rotors, and three of them in a train, with the train's published motions."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, NamedTuple, cast

import numpy as np
from scipy.optimize import brentq

from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.contact import Contact
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.structure import Structure
from stickslip.studies.smoothed import SmoothMotion, smoothed

if TYPE_CHECKING:
    from collections.abc import Callable

    from stickslip.numerics.arrays import Floats

# --- one clutch -----------------------------------------------------------------------------


@dataclass(frozen=True)
class Engaging:
    """A clutch of some capacity closes between two rotors that are driven and loaded."""

    inertia: tuple[float, float] = (2.0, 3.0)
    torque: tuple[float, float] = (0.9, -0.4)  # on the driving and the driven rotor
    capacity: float = 1.0
    speed: tuple[float, float] = (2.0, 0.0)

    @property
    def model(self) -> Structure:
        """As a structure."""
        return Structure(
            mass=self.inertia,
            stiffness=np.zeros(2),
            contacts=[Contact(at=(0, 1), friction=Coulomb(mu=1.0), static=self.capacity)],
            force=self.torque,
        )

    @property
    def lock(self) -> float:
        """Time at which the speeds are equal."""
        (j1, j2), (drive, load) = self.inertia, self.torque
        closing = (self.capacity - drive) / j1 + (self.capacity + load) / j2
        return (self.speed[0] - self.speed[1]) / closing

    @property
    def heat(self) -> float:
        """Energy that the clutch turns into heat until then."""
        return 0.5 * self.capacity * (self.speed[0] - self.speed[1]) * self.lock

    @property
    def carried(self) -> float:
        """Torque through the closed clutch."""
        (j1, j2), (drive, load) = self.inertia, self.torque
        return (j2 * drive - j1 * load) / (j1 + j2)

    def slip(self, width: float) -> float:
        """Slip that smooth friction keeps for ever."""
        return width * math.atanh(self.carried / self.capacity)

    def motion(self, t_end: float) -> Trajectory:
        """Follow the motion exactly."""
        return simulate(self.model, [0.0, 0.0], self.speed, t_end=t_end)


CLUTCH: Final = Engaging()
WIDTHS: Final = (1e-1, 1e-2, 1e-3)
WATCHED: Final = 20.0


@cache
def smooth_clutches() -> tuple[SmoothMotion, ...]:
    """Close the clutch with smooth friction."""
    start = np.array(CLUTCH.speed)
    return tuple(smoothed(CLUTCH.model, w, np.zeros(2), start, WATCHED) for w in WIDTHS)


# --- three clutches -------------------------------------------------------------------------

TRAIN: Final = cast("Structure", read_model(Path(__file__).with_name("clutches.toml")))
END: Final = 1.5
CLOSED: Final = ((0.0, (0,)), (0.4, (0, 1)), (0.9, (0, 1, 2)), (1.25, (1, 2)), (END, ()))
"""Times from which on clutches are pressed; the load of the first one is 0 at 1.25."""
WAVE: Final = TRAIN.parameters["forcing.frequency"]
PHASE: Final = TRAIN.parameters["forcing.phase"]


@dataclass(frozen=True)
class Train:
    """The motion of the train, piece by piece, and its events: times, clutches, kinds."""

    pieces: tuple[tuple[float, Trajectory], ...]  # each with the time at which it starts
    events: tuple[tuple[float, int, str], ...]

    def speeds(self, t: float) -> Floats:
        """Speeds of the four inertias."""
        start, run = next(piece for piece in reversed(self.pieces) if piece[0] <= t)
        return run.v(t - start)[:4]

    def angles(self) -> Floats:
        """Angles of the four inertias at the end."""
        return self.pieces[-1][1].final_state.x[:4]


@cache
def train() -> Train:
    """Follow the train; from one piece to the next other clutches are pressed."""
    x, v = np.zeros(5), np.array([10.0, 0.0, 0.0, 0.0, 0.0])
    pieces, events = [], []
    for (start, pressed), (end, _) in itertools.pairwise(CLOSED):
        model = TRAIN.replace(contacts=[TRAIN.contacts[k] for k in pressed])
        model = model.replace(**{"forcing.phase": PHASE + WAVE * start})
        run = simulate(model, x, v, t_end=end - start)
        x, v = run.final_state.x, run.final_state.v
        pieces.append((start, run))
        events += [(start + e.time, pressed[e.block - 1], e.kind) for e in run.events]
    return Train(tuple(pieces), tuple(events))


class Stretch(NamedTuple):
    """A time of constant modes: bodies that turn together, clutches that slip, and its end."""

    groups: tuple[tuple[int, ...], ...]
    slipping: tuple[int, ...]
    end: float | Callable[[float, Floats], float]  # 0 there


def _torque(t: float) -> float:
    return 10.0 * math.sin(10.0 * math.pi * t)


def _limit(t: float) -> float:
    return 11.0 * math.cos(0.4 * math.pi * t)


FREE: Final = ((0,), (1,), (2,), (3,))
PAIR: Final = ((0,), (1, 2), (3,))
THREE: Final = ((0, 1, 2), (3,))
STRETCHES: Final = (
    Stretch(FREE, (0,), 0.4),
    Stretch(FREE, (0, 1), lambda _, v: v[1] - v[2]),
    Stretch(PAIR, (0,), lambda _, v: v[0] - v[1]),
    Stretch(THREE, (), lambda t, _: _limit(t) - 2.0 / 3.0 * _torque(t)),
    Stretch(PAIR, (0,), 0.9),
    Stretch(PAIR, (0, 2), lambda _, v: v[0] - v[1]),
    Stretch(THREE, (2,), lambda t, _: _limit(t) - (2.0 * _torque(t) + 10.0) / 3.0),
    Stretch(PAIR, (0, 2), lambda _, v: v[2] - v[3]),
    Stretch(((0,), (1, 2, 3)), (0,), 1.25),
    Stretch(((0,), (1, 2, 3)), (), END),
)
"""Modes of the motion, found by following; times and speeds follow from them in closed form."""


def _speeds(stretch: Stretch, start: float, v: Floats, t: float) -> Floats:
    """Speeds within a stretch: integrals of a sine, a cosine and constants."""
    gained = np.zeros(4)
    gained[0] = (math.cos(10.0 * math.pi * start) - math.cos(10.0 * math.pi * t)) / math.pi
    wave = (math.sin(0.4 * math.pi * t) - math.sin(0.4 * math.pi * start)) * 25.0 / math.pi
    for clutch in stretch.slipping:
        given = wave if clutch == 0 else 10.0 * (t - start)
        gained[clutch : clutch + 2] += (-given, given)
    found = v.copy()
    for group in map(list, stretch.groups):
        found[group] = v[group[0]] + gained[group].mean()
    return found


@cache
def closed_form() -> tuple[tuple[float, ...], Floats]:
    """Solve for the ends of the stretches and the speeds at the end."""
    start, v = 0.0, np.array([10.0, 0.0, 0.0, 0.0])
    times = []
    for stretch in STRETCHES:
        end = stretch.end if isinstance(stretch.end, float) else _root(stretch, start, v)
        v = _speeds(stretch, start, v, end)
        times.append(end)
        start = end
    return tuple(times), v


def _root(stretch: Stretch, start: float, v: Floats) -> float:
    """First time after the start at which a stretch ends."""

    def excess(t: float) -> float:
        return float(stretch.end(t, _speeds(stretch, start, v, t)))  # type: ignore[operator]

    times = np.linspace(start, END, 3001)[1:].tolist()
    signs = np.sign([excess(t) for t in times])
    (changes,) = np.nonzero(signs[1:] != signs[:-1])
    return float(brentq(excess, times[changes[0]], times[changes[0] + 1], xtol=1e-16))


DYMOLA: Final = {
    "angle 1": "7.48609218389668",
    "speed 1": "3.24703456524066",
    "speed 2 less speed 1": "-0.783826964342972",
    "angle 2 less angle 1": "-3.37894249870185",
    "angle 3 less angle 2": "-1.39667286826109",
    "angle 4 less angle 3": "-1.53672566460141",
}
"""At 1.5: Modelica/Mechanics/Rotational/Examples/CoupledClutches/CoupledClutches.csv."""
MWORKS: Final = (
    "3.2431637982712185",
    "2.4579111966378830",
    "2.4622088382041034",
    "2.473335939469647",
)
"""Speeds at 1.5: fmus/1.0/cs/win64/MWorks/2016/CoupledClutches/CoupledClutches_ref.csv."""
MWORKS_ROWS: Final = (
    (1.1439999999999848, 2.4432080163437706, 2.4399999999999920),
    (1.1469999999999845, 2.4397469520783415, 2.4508740533438851),
    (1.1499999999999841, 2.4410268805156399, 2.4521539817811835),
    (1.1589999999999832, 2.4446422075768877, 2.4557693088424313),
    (1.1709999999999818, 2.4489382832220801, 2.4600653844876237),
    (1.1829999999999805, 2.4526342021233649, 2.4637613033889085),
    (1.1949999999999792, 2.4557291238606558, 2.4668562251261994),
)
"""Times, speeds 3 and 4, of the same file."""
