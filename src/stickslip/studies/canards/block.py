"""The shaken block: its motions in closed form, followed, and with friction made smooth."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import brentq, newton

from stickslip.following import follow
from stickslip.mechanics.cycle.return_map import LineReturnMap, return_map
from stickslip.mechanics.cycle.stroboscopic import stroboscopic_map
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.contact import Contact, Harmonic
from stickslip.mechanics.model.file import read_model
from stickslip.mechanics.model.structure import Structure

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.mechanics.model.blocks import Oscillator
    from stickslip.numerics.arrays import Floats

MODEL: Final = cast("Oscillator", read_model(Path(__file__).with_name("model.toml")))
FORCE: Final = "forcing.amplitude"
MU: Final = MODEL.parameters["mu"]
GIVEN: Final = MODEL.parameters[FORCE]
FREQUENCY: Final = MODEL.parameters["forcing.frequency"]
STATIC: Final = 1.0 - FREQUENCY**2
"""Force over displacement of a motion at the frequency without friction."""
PERIOD: Final = 2.0 * math.pi / FREQUENCY


# --- closed forms: the duration of a slip tells all the rest ----------------------------------


@dataclass(frozen=True)
class Motion:
    """A motion of one slip each way a period: from rest at -x at a phase of the force, to x."""

    slip: float  # its duration
    force: float  # its amplitude
    x: float
    phase: float  # at which the slip begins; of a canard > 0, where the needed force falls

    @property
    def needed(self) -> float:
        """Friction that would hold the block at rest as the slip begins."""
        return self.force * math.cos(self.phase) + self.x

    @property
    def multiplier(self) -> float:
        """Of the motion over a period, as the slip begins where the needed force is the limit."""
        phi, end = self.phase, self.phase + FREQUENCY * self.slip
        share = self.force / STATIC
        moved = math.cos(self.slip) * (share - self.force) * math.sin(phi)
        moved += share * FREQUENCY * math.sin(self.slip) * math.cos(phi) - share * math.sin(end)
        return (moved / (self.force * math.sin(phi))) ** 2

    def at(self, time: Floats) -> Floats:
        """Displacement within the slip."""
        share, phase = self.force / STATIC, self.phase + FREQUENCY * time
        even = MU - self.x - share * math.cos(self.phase)
        odd = share * FREQUENCY * math.sin(self.phase)
        moved: Floats = even * np.cos(time) + odd * np.sin(time) + share * np.cos(phase) - MU
        return moved


def _parts(slip: float) -> tuple[float, float, float, float]:
    """Return p and q of the force (p, q x) STATIC at mid-slip; cosine, sine of half its phase."""
    c, s = math.cos(slip / 2.0), math.sin(slip / 2.0)
    cw, sw = math.cos(FREQUENCY * slip / 2.0), math.sin(FREQUENCY * slip / 2.0)
    p, q = MU * s / (cw * s - FREQUENCY * sw * c), c / (FREQUENCY * cw * s - sw * c)
    return p, q, cw, sw


def _motion(slip: float, x: float) -> Motion:
    p, q, _, _ = _parts(slip)
    phase = math.atan2(q * x, p) - FREQUENCY * slip / 2.0
    return Motion(slip, STATIC * math.hypot(p, q * x), x, phase)


def regular(slip: float) -> Motion:
    """Motion whose slips begin where the needed force reaches the limit."""
    p, q, cw, sw = _parts(slip)
    return _motion(slip, (1.0 - STATIC * p * cw) / (1.0 + STATIC * q * sw))


def canard(slip: float) -> Motion:
    """Motion whose needed force touches the limit, and which slips later, at some phase > 0."""
    p, q, _, _ = _parts(slip)
    p, q = (STATIC * p) ** 2, (STATIC * q) ** 2
    # (1 - x)^2 = p + q x^2, the root that is 0 where p = 1
    return _motion(slip, (1.0 - p) / (1.0 + math.sqrt(1.0 - (1.0 - q) * (1.0 - p))))


def onset() -> Motion:
    """Motion of the least force: the slip takes half a period of the free block."""
    return regular(math.pi)


@cache
def touching() -> Motion:
    """Regular motion whose needed force only just touches the limit: the first canard."""
    return regular(float(brentq(lambda slip: regular(slip).phase, 2.0, math.pi, xtol=1e-15)))


def canard_with(phase: float) -> Motion:
    """Canard that slips at a phase between 0 and arccos(MU), where it has no length."""
    ends = 1e-2, touching().slip + 1e-9
    slip = brentq(lambda slip: canard(slip).phase - phase, *ends, xtol=1e-15)
    return canard(float(slip))


def harmonic_balance(force: float) -> float:
    """Amplitude by the balance of one harmonic, which knows friction in motion only; NaN: none."""
    square = force**2 - (4.0 * MU / math.pi) ** 2
    return math.sqrt(square) / STATIC if square >= 0.0 else math.nan


# --- followed event by event ------------------------------------------------------------------


def release_map(force: float) -> LineReturnMap:
    """From one forward release to the next: the phase of the force."""
    model = MODEL.replace(**{FORCE: force})
    return cast("LineReturnMap", return_map(model, direction="forward"))


@cache
def cycles() -> Curve:
    """Follow the cycle of the file's force along the force."""
    found = stroboscopic_map(MODEL).periodic_point([-regular(4.0).x, 0.0])
    return follow(found, FORCE, (0.3, 1.2))


def from_rest(excess: float, periods: float = 1.0) -> Trajectory:
    """Follow the block from rest where its needed force will pass the limit by an excess."""
    model = MODEL.replace(**{"forcing.phase": -0.5 * math.pi})
    return simulate(model, [GIVEN - 1.0 - excess], [0.0], t_end=periods * PERIOD)


def slip_of(motion: Motion) -> tuple[float, float]:
    """Duration and end of a canard's slip, followed on ground that holds a little less."""
    hold = 0.99 * motion.needed
    contact = Contact(at=0, static=hold, friction=Coulomb(mu=MU / hold))
    forcing = Harmonic(motion.force, FREQUENCY, motion.phase)
    block = Structure(mass=[1.0], stiffness=[[1.0]], contacts=[contact], forcing=forcing)
    run = simulate(block, [-motion.x], [0.0], t_end=1.5 * motion.slip)
    end = next(event.time for event in run.events if event.kind == "stick")
    return end, float(run.x(end)[0])


# --- the usual tools --------------------------------------------------------------------------


def unseen(step: float) -> float:
    """Excess over the limit that fixed steps from phase -pi/2 do not see at their ends."""
    phase = np.arange(-0.5 * math.pi, 0.5 * math.pi, FREQUENCY * step)
    return GIVEN * (1.0 - float(np.cos(phase).max()))


LEAVES: Final = 2.5
"""Speed, over the width of the smooth law, at which a slip has begun."""
BEFORE: Final = -0.4  # phase in the stick before the force touches its limit


def smooth_law(u: Floats) -> Floats:
    """Friction over speed / width: rises to 1 at 1, then falls to MU."""
    kinetic = np.where(np.abs(u) < 1.0, 0.5 * u * (3.0 - u * u), np.sign(u))
    return np.asarray(MU * kinetic + (1.0 - MU) * u * np.exp(0.5 - 0.5 * u * u))


@dataclass(frozen=True)
class SmoothCanard:
    """A motion that repeats with smooth friction: its force, and where it waits."""

    width: float
    phase: float  # at which its slip begins
    force: float
    x: float
    start: Floats  # displacement and velocity at the phase BEFORE


@cache
def smooth_canard(phase: float, width: float) -> SmoothCanard:
    """Find the symmetric motion with smooth friction that begins to slip at a phase.

    The wait is a problem of boundary values, since motions leave it in both directions of time;
    the slip and the rest of the half period follow forward in time.
    """
    exact = canard_with(phase) if phase > 0.0 else _regular_with(phase)
    force, start = exact.force, _guess(exact, width)

    def rates(force: float, phase: Floats | float, z: Floats) -> Floats:
        pull = force * np.cos(phase) - z[0] - smooth_law(z[1] / width)
        return np.array([z[1], pull]) / FREQUENCY

    def wait(force: float) -> tuple[Floats, Floats]:
        found = solve_bvp(
            lambda phase, z: rates(force, phase, z),
            lambda a, b: np.array(
                [smooth_law(a[1] / width) + a[0] - force * math.cos(BEFORE), b[1] / width - LEAVES]
            ),
            *start,
            tol=1e-6,
            max_nodes=100_000,
        )
        return found.y[:, 0], found.y[:, -1]

    def missed(force: float) -> float:
        first, last = wait(force)
        span = (phase, BEFORE + math.pi)
        run = solve_ivp(
            lambda phase, z: rates(force, phase, z), span, last, "LSODA", rtol=1e-8, atol=1e-10
        )
        return float(run.y[0, -1] + first[0])

    force = float(newton(missed, force, x1=force + width, tol=1e-8))
    first, _ = wait(force)
    return SmoothCanard(width, phase, force, -float(first[0]), first)


def _regular_with(phase: float) -> Motion:
    """Regular motion on the unstable branch that slips at a phase <= 0."""
    ends = touching().slip - 1e-9, math.pi
    slip = brentq(lambda slip: regular(slip).phase - phase, *ends, xtol=1e-15)
    return regular(float(slip))


def _guess(exact: Motion, width: float) -> tuple[Floats, Floats]:
    """Phases, displacements and velocities of a wait on both branches of the smooth law."""
    phase = np.linspace(BEFORE, exact.phase, 400)
    needed = np.minimum(exact.force * np.cos(phase) + exact.x, 1.0)
    up, down = np.linspace(0.0, 1.0, 400), np.linspace(1.0, LEAVES, 400)
    rising = np.interp(needed, smooth_law(up), up)
    falling = np.interp(-needed, -smooth_law(down), down)
    speed = width * np.where(phase < 0.0, rising, falling)
    return phase, np.vstack([np.full(len(phase), -exact.x), speed])


def smooth_leaving(canard: SmoothCanard, rtol: float) -> float:
    """Phase at which a motion in steps leaves the wait that it starts on; NaN: it stays at rest."""

    def rates(phase: float, z: Floats) -> list[float]:
        pull = canard.force * math.cos(phase) - z[0] - float(smooth_law(z[1] / canard.width))
        return [z[1] / FREQUENCY, pull / FREQUENCY]

    run = solve_ivp(rates, (BEFORE, 1.5), canard.start, "LSODA", rtol=rtol, atol=1e-3 * rtol)
    fast = np.flatnonzero(run.y[1] > LEAVES * canard.width)
    return float(run.t[fast[0]]) if fast.size else math.nan
