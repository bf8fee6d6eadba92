"""The string under the bow: its start, kinds of motion, exact cycles, and the usual time steps."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from scipy.io import wavfile

from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.model.file import read_model
from stickslip.sweeps.observables import Function
from stickslip.sweeps.sweep import sweep

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.model.structure import Structure
    from stickslip.numerics.arrays import Floats

MODEL: Final = cast("Structure", read_model(Path(__file__).with_name("model.toml")))
ORDERS: Final = np.arange(1, len(MODEL.mass) + 1)
KINETIC: Final = MODEL.parameters["mu_1"]
PERIOD: Final = 2.0
"""Of the string without a bow: twice its length over the speed of waves."""
RESISTANCE: Final = 50.0  # of a bridge that takes as much of the lowest modes, over the impedance
PLACE: Final = 0.11


def bowed(place: float, force: float) -> Structure:
    """Bow at a place, as a share of the length, with a force times static friction."""
    (contact,) = MODEL.contacts
    weights = np.sin(ORDERS * math.pi * place)
    return MODEL.replace(contacts=[replace(contact, at=weights.tolist(), static=force)])


def largest(place: float) -> float:
    """Schelleng's maximum of the bow force, times static friction; bow speed 1."""
    return 2.0 / (place * (1.0 - KINETIC))


def smallest(place: float) -> float:
    """Schelleng's minimum."""
    return 1.0 / (2.0 * RESISTANCE * place**2 * (1.0 - KINETIC))


def helmholtz(place: float, force: float) -> tuple[Floats, Floats]:
    """Displacements and velocities of the modes in Helmholtz motion, amid the stick.

    The velocity at the bow is made that of the bow, of which a finite sum falls short.
    """
    weights = np.sin(ORDERS * math.pi * place)
    q = weights * KINETIC * force / np.diag(MODEL.stiffness)
    v = -2.0 / (math.pi * ORDERS * place) * (-1.0) ** ORDERS
    return q, v + weights * (1.0 - weights @ v) / (weights @ weights)


# --- kinds of motion ------------------------------------------------------------------------

PERIODS: Final = 40
JUDGED: Final = 10  # of them, the last
KINDS: Final = ("Helmholtz", "long slip", "not one slip a period", "slides")


@dataclass(frozen=True)
class Sound:
    """What became of Helmholtz motion: slips a period, and the time of slip as a share."""

    place: float
    force: float
    slips: float
    share: float

    @property
    def kind(self) -> str:
        """One of `KINDS`; Helmholtz: one slip a period, at most twice as long as the ideal one."""
        if self.slips == 0.0:
            return KINDS[3]
        if abs(self.slips - 1.0) > 0.15:
            return KINDS[2]
        return KINDS[0] if self.share < 2.0 * self.place else KINDS[1]


def motion(place: float, force: float, periods: int, *, events: bool = False) -> Trajectory:
    """Follow the string from Helmholtz motion on."""
    q, v = helmholtz(place, force)
    record = "events" if events else "motion"
    return simulate(bowed(place, force), q, v, t_end=PERIOD * periods, record=record)  # type: ignore[arg-type]


def heard(model: Structure, _: float) -> tuple[float, float]:
    """Count slips a period that end within the last periods, and the share of time they take."""
    (contact,) = model.contacts
    place = math.asin(float(np.ravel(contact.at)[0])) / math.pi
    found = motion(place, contact.static, PERIODS, events=True).slips
    since = PERIOD * (PERIODS - JUDGED)
    last = [slip for slip in found if slip.start + slip.duration > since]
    return len(last) / JUDGED, sum(slip.duration for slip in last) / (PERIOD * JUDGED)


PLACES: Final = tuple(np.geomspace(0.05, 0.26, 10).tolist())
FORCES: Final = tuple(np.geomspace(0.02, 1.9, 14).tolist())
"""As shares of Schelleng's maximum."""


def sounds(place: float, forces: Sequence[float]) -> tuple[Sound, ...]:
    """Sweep the force of the bow at a place."""
    with TemporaryDirectory() as folder:
        found = sweep(
            bowed(place, 1.0),
            {"static_1": forces},
            [Function(function=heard, shape=(2,))],
            store=folder + "/sounds",
        )
        rows = found.heard.values.tolist()
    return tuple(Sound(place, force, *row) for force, row in zip(forces, rows, strict=True))


@cache
def plane() -> tuple[Sound, ...]:
    """Sweep places and forces of the bow."""
    rows = (sounds(place, [share * largest(place) for share in FORCES]) for place in PLACES)
    return tuple(sound for row in rows for sound in row)


# --- pitch ----------------------------------------------------------------------------------

SHARES: Final = (0.4, 0.5, 0.6, 0.7)
SETTLED: Final = 60


@cache
def cycle(share: float, place: float = PLACE) -> Cycle:
    """Exact cycle that Helmholtz motion comes to, at a share of the maximum of the force."""
    force = share * largest(place)
    end = motion(place, force, SETTLED, events=True).final_state
    return find_cycle(bowed(place, force), end.x, end.v)


def cents(period: float) -> float:
    """Pitch beside that of the free string; 100 are a semitone."""
    return 1200.0 * math.log2(PERIOD / period)


@cache
def stepped(share: float, steps: int, periods: int = SETTLED) -> Floats:
    """Periods between releases with a fixed step: modes exact, friction constant in each step."""
    force = share * largest(PLACE)
    q, v = helmholtz(PLACE, force)
    weights, h = np.sin(ORDERS * math.pi * PLACE), PERIOD / steps
    stiffness = np.diag(MODEL.stiffness)
    w, s = math.pi * ORDERS, 0.5 * np.diag(MODEL.damping) / MODEL.mass
    damped, faded = np.sqrt(w**2 - s**2), np.exp(-s * h)
    c, d = np.cos(damped * h) * faded, np.sin(damped * h) * faded / damped
    qq, qv, vq, vv = c + s * d, d, -(w**2) * d, c - s * d
    moved, pushed = (1.0 - qq) / stiffness * weights, -vq / stiffness * weights
    releases, slipping = [], False
    for k in range(steps * periods):
        q, v = qq * q + qv * v, vq * q + vv * v
        needed = (1.0 - weights @ v) / (weights @ pushed)
        slips = abs(needed) > force
        given = math.copysign(KINETIC * force, needed) if slips else needed
        q, v = q + moved * given, v + pushed * given
        if slips and not slipping:
            releases.append(k * h)
        slipping = slips
    return np.diff(np.array(releases)[2 * len(releases) // 3 :])


# --- sounds ---------------------------------------------------------------------------------

PITCH: Final = 196.0  # hertz: a violin's open G
RATE: Final = 22050
HEARD: Final = {"helmholtz": 0.6, "surface": 0.2, "pressed": 1.4}
"""Shares of the maximum of the bow force."""


def bridge_force(run: Trajectory, t: Floats) -> Floats:
    """Force of the string on the bridge: the sum of the slopes of all modes there."""
    return run.x(t) @ (math.pi * ORDERS)


def write_sounds(folder: str | Path, seconds: float = 1.0) -> tuple[Path, ...]:
    """Write the force at the bridge of three exact motions as WAV files."""
    times = PITCH * PERIOD * np.arange(int(RATE * seconds)) / RATE
    written = []
    for name, share in HEARD.items():
        periods = math.ceil(PITCH * seconds)
        force = bridge_force(motion(PLACE, share * largest(PLACE), periods), times)
        force = force - force.mean()
        path = Path(folder) / f"{name}.wav"
        wavfile.write(path, RATE, (0.8 * 32767.0 * force / np.abs(force).max()).astype(np.int16))
        written.append(path)
    return tuple(written)
