"""Steady sliding, stick-slip cycles and kicks of the brake, once for all claims and figures."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, cast

import numpy as np
from scipy.linalg import expm

from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.following import follow
from stickslip.mechanics.cycle.equilibria import Equilibrium, equilibria
from stickslip.mechanics.cycle.return_map import return_map
from stickslip.mechanics.flow.trajectory import Trajectory, simulate
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.friction.stribeck import Stribeck
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.structure import Structure
from stickslip.numerics.zeros import halved
from stickslip.studies.smoothed import SmoothMotion, smoothed

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
    from stickslip.analysis.orbits.orbits_nd import OrbitListND, PeriodicOrbitND
    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.numerics.arrays import Floats

MODEL: Final = cast("Structure", read_model(Path(__file__).with_name("model.toml")))
LOAD: Final = "load_1_2"
"""Friction coefficient times the contact's stiffness: what a brake is judged by."""
RANGE: Final = (0.1, 1.2)
BOX: Final = ((-1.5, 1.0), (-1.0, 1.0))
"""Displacements and velocities y among which cycles are searched."""
SPEED: Final = MODEL.V
LAWS: Final[dict[str, FrictionLaw]] = {
    "constant": Coulomb(mu=1.0),
    "falls with speed": Stribeck(mu=0.99, speed=10.0 * SPEED),
    "drops at once": Stribeck(mu=0.95, speed=SPEED / 8.0),
}
LONG: Final = 300.0
"""Time after which a motion squeals or slides: some fifty periods."""
LAST: Final = 20.0  # part of it
LARGEST_KICK: Final = 20.0  # units of the disc's speed
HALVINGS: Final = 24


# --- steady sliding, in closed form ---------------------------------------------------------


def threshold(damping: float) -> float:
    """Load at which steady sliding begins to flutter; the same damping of both coordinates."""
    (a, b), (_, d) = MODEL.stiffness.tolist()
    return float(b + ((a - d) ** 2 / 4.0 + damping**2 * (a + d) / 2.0) / b)


def flutter_frequency() -> float:
    """Angular frequency at the threshold, for any damping."""
    return float(np.sqrt(np.trace(MODEL.stiffness) / 2.0))


def touching_point() -> tuple[float, float]:
    """Displacement and velocity of y where the neutral motion at the threshold touches stick."""
    (_, b), (_, d) = MODEL.stiffness.tolist()
    c, w = float(MODEL.damping[0, 0]), flutter_frequency()
    x = SPEED / (1j * w)  # x' = V cos(w t), which is the disc's speed at t = 0
    y = -b * x / (d - w * w + 1j * w * c)
    (sliding,) = equilibria(MODEL.replace(**{LOAD: threshold(c)}))
    return float(sliding.x[1] + y.real), float((1j * w * y).real)


def touching_kick(load: float) -> float:
    """Smallest kick of y, over the disc's speed, after which a slip just reaches stick."""
    plant = MODEL.replace(**{LOAD: load}).plant
    stiffness = plant.stiffness - np.outer(plant.into[:, 0], plant.load[0, :2])
    flow = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -plant.damping]])
    step, state, largest = expm(flow * 0.01), np.array([0.0, 0.0, 0.0, 1.0]), 0.0
    for _ in range(int(LONG / 0.01)):
        state = step @ state
        largest = max(largest, float(state[2]))
    return 1.0 / largest


# --- computed -------------------------------------------------------------------------------


def sliding(model: Structure) -> Equilibrium:
    """Return the only motion of steady sliding."""
    (found,) = equilibria(model)
    return found


@cache
def flutter(law: str, damped: bool = True) -> CurveEvent:
    """Find where steady sliding loses its stability along the load."""
    changes: dict[str, Any] = {} if damped else {"damping_1_1": 0.0, "damping_2_2": 0.0}
    model = MODEL.replace(friction=LAWS[law], **changes)
    (found,) = follow(sliding(model), LOAD, RANGE).bifurcations
    return found


@dataclass(frozen=True)
class Cycles:
    """Cycles of the brake with one law: that of the file's load which attracts, all along it."""

    law: str
    here: PeriodicOrbitND
    curve: Curve

    @property
    def onset(self) -> CurveEvent:
        """The fold at the smallest load: from there on there is a cycle that attracts."""
        folds = [event for event in self.curve.bifurcations if event.kind == "fold"]
        return min(folds, key=lambda event: event.value)

    @property
    def small_end(self) -> CurveEnd:
        """Where the branch of small cycles ends."""
        (found,) = (end for end in self.curve.ends if end.reason == "gap")
        return found


@cache
def cycles(law: str = "constant", speed: float = SPEED) -> Cycles:
    """Search for stick-slip cycles from release to release, and follow the one that attracts."""
    model = MODEL.replace(friction=LAWS[law], V_1=speed)
    box = tuple((low * speed / SPEED, high * speed / SPEED) for low, high in BOX)
    found = periodic_orbits(return_map(model, domain=box), max_period=1)
    loudest = max(cast("OrbitListND", found), key=amplitude)
    return Cycles(law, loudest, follow(loudest, LOAD, RANGE))


def motion(orbit: PeriodicOrbitND) -> Trajectory:
    """One period of a cycle, from its release on."""
    return _period(orbit.system, orbit.points[0])


def amplitude(orbit: PeriodicOrbitND) -> float:
    """Half the range of y over a period, in units of V over the unit of frequency."""
    return _half_range(motion(orbit))


def amplitudes(curve: Curve) -> Floats:
    """Amplitude of each row; NaN at an end where a stick has no length."""
    maps = [curve.system.replace(**{LOAD: value}) for value in curve.values.tolist()]
    found = [
        _half_range(_period(f, points[0])) if np.isfinite(f(points[0])).all() else np.nan
        for f, points in zip(maps, curve.points, strict=True)
    ]
    return np.array(found)


def _period(f: Any, point: Floats) -> Trajectory:
    found: Trajectory = f.slip_from(point, 1000)
    return found


def _half_range(found: Trajectory) -> float:
    times = np.linspace(0.0, found.t[-1], 257)
    return float(np.ptp(found.x(times)[:, 1])) / (2.0 * SPEED)


def kicked(load: float, kick: float) -> Trajectory:
    """Return what steady sliding does after y is kicked, in units of the disc's speed."""
    model = MODEL.replace(**{LOAD: load})
    return simulate(model, sliding(model).x, [0.0, kick * SPEED], t_end=LONG)


def squeals(found: Trajectory) -> bool:
    """Whether a motion still sticks and slips at its end."""
    return bool(found.events) and found.events[-1].time > LONG - LAST


@cache
def squeal_kick(load: float) -> tuple[float, float]:
    """Bracket the kick from which on the brake squeals, by bisection."""
    return halved(lambda kick: not squeals(kicked(load, kick)), 0.0, LARGEST_KICK, HALVINGS)


ABOVE: Final = 1.01  # times the load of the onset
RATIOS: Final = (5.0, 20.0, 80.0, 320.0)  # of the disc's speed over the width of a smooth law


@cache
def smooth_motions() -> tuple[PeriodicOrbitND, tuple[SmoothMotion, ...]]:
    """Start on the exact cycle just above its onset, and integrate with smooth laws."""
    found = cycles()
    low = ABOVE * found.onset.value
    orbit = max(found.curve.all_at(**{LOAD: low}), key=amplitude)
    f = orbit.system
    x, v, _ = f.state(orbit.points[0])
    return orbit, tuple(smoothed(f.model, SPEED / ratio, x, v, LONG) for ratio in RATIOS)


def amplitude_left(run: SmoothMotion) -> float:
    """Amplitude that is left of a motion, as of an exact cycle."""
    return float(np.ptp(run.x[run.t > LONG - LAST, 1])) / (2.0 * SPEED)
