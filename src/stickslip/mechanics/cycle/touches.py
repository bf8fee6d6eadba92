"""How close a motion comes to changing its modes otherwise: lobes, riders, landings, ties."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

import numpy as np

from stickslip.mechanics.flow.blocks.mode import settle
from stickslip.mechanics.flow.system import AT_LOWER_LIMIT, AT_UPPER_LIMIT, LANDING
from stickslip.numerics.polynomial import NO_ROOT, jet, lowest_minimum, value

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.shooting import Shooter, State

    Floats = NDArray[np.float64]

TouchKind: TypeAlias = Literal["grazing", "limit", "landing", "tie"]

SIDES: Final = ((AT_UPPER_LIMIT, -1.0), (AT_LOWER_LIMIT, 1.0))


class Touch(NamedTuple):
    """A place of a motion that is about to change its modes."""

    # grazing: a slip turns back `room` (of velocity) before the belt, or beyond it (negative).
    # limit: a rider's needed force turns back. landing: static limit to spare; negative: no stick.
    # tie: two blocks have events `room` apart in time.
    kind: TouchKind
    time: float
    block: int  # from 0
    room: float


def touches(shooter: Shooter, state: State, duration: float) -> list[Touch]:
    """Collect them along a motion, by ascending size of the room."""
    motion, system = shooter.motion, shooter.system
    shooter.place(state)
    found: list[Touch] = []
    t, last = 0.0, (-np.inf, -1)
    while t < duration:
        mode, needed = motion.mode.copy(), motion.e.copy()
        h, status = shooter.advance(duration - t)
        if status or h <= 0.0:
            break
        for block in range(shooter.n):
            found += _inside(shooter, block, int(mode[block]), needed, t, h)
        t += h
        if motion.event.any():
            for i in map(int, np.flatnonzero(motion.event == LANDING)):
                spare = float(system.static[i] - abs(motion.e[i]))
                found.append(Touch("landing", t, i, spare))
                found += _barely_landed(mode[i] * shooter.work.w[i], t, i, h)
            settle(system, motion, shooter.work.rates)
            changed = np.flatnonzero(motion.mode != mode)
            for i in changed[:1]:
                if i != last[1] and last[1] >= 0:
                    found.append(Touch("tie", t, int(i), t - last[0]))
                last = (t, int(i))
    return sorted(found, key=lambda touch: abs(touch.room))


def _barely_landed(signal: Floats, time: float, block: int, h: float) -> list[Touch]:
    """How far beyond the belt a landing slip would have turned back, its series cut at t^2."""
    _, slope, curvature = jet(signal, h)
    if curvature <= 0.0:
        return []
    return [Touch("grazing", time, block, -(slope**2) / (2.0 * curvature))]


def _inside(
    shooter: Shooter, block: int, mode: int, needed: Floats, start: float, h: float
) -> list[Touch]:
    """List turning points of one block's signals inside a step."""
    work, kernels, system = shooter.work, shooter.engine.kernels, shooter.system
    signals: list[tuple[TouchKind, Floats]]
    if mode != 0:
        signals = [("grazing", mode * work.w[block])]
    else:
        growth = np.array(
            [
                0.0 if k == 0 else kernels.needed_coefficient(system, work, block, k)
                for k in range(kernels.ORDER + 1)
            ]
        )
        signals = []
        for _, sign in SIDES:
            signal = sign * growth
            signal[0] = system.static[block] + sign * needed[block]
            signals.append(("limit", signal))
    found = []
    for kind, signal in signals:
        at = lowest_minimum(signal, h)
        if at != NO_ROOT:
            found.append(Touch(kind, start + at, block, float(value(signal, at))))
    return found
