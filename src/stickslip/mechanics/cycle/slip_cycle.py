"""Cycles on which no block ever reaches the belt: no event marks their returns."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.cycle.section import Section, Shooting, Shot
from stickslip.mechanics.cycle.shooting import Shooter, State
from stickslip.mechanics.cycle.sliding import modes, steady_displacements
from stickslip.numerics.continuation import ArclengthCurve, LeavesRegion, StepTooLong

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.sliding import Model


PATIENCE: Final = 2.5  # periods of the slowest mode in which two extremes of a kind must come
STEP: Final = 1 / 64  # of the fastest mode's period: where extremes are looked for
CLOSE: Final = 0.05  # of the motion's size: a return this close is worth an attempt
REACH: Final = 10.0  # distances of the return that Newton's method may move the state
NEUTRAL: Final = 1e-9  # multipliers this close to the unit circle: one of a family of motions
SMALLEST: Final = 1e-6  # of the static limits: smaller motions are steady sliding


def slip_cycle(
    model: Model, state: State, *, rtol: float = 1e-15, close: float = CLOSE
) -> Shot | None:
    """Cycle without events near a motion in which all blocks slip, if there is one.

    Newton's method starts from two successive extremes of a displacement.
    """
    if model.structure.is_forced or (state.mode == 0).any():
        return None
    found = _two_extremes(model, state, rtol)
    if found is None:
        return None
    block, first, second, period = found
    distance = float(np.abs(second.vector - first.vector).max())
    size = _size(model, second)
    if not SMALLEST < size or distance > close * size:
        return None
    shooting = Shooting(model, "V", Section(block, second.mode), word=(), rtol=rtol)
    guess = shooting.unknowns(second, period, model.V)
    try:
        point = ArclengthCurve(shooting, shooting.scale(model.V, period)).point(guess)
    except (LeavesRegion, StepTooLong):
        return None
    shot: Shot = point.note
    moved = float(np.abs(shot.state.vector - second.vector).max())
    if (np.abs(np.abs(shot.multipliers) - 1.0) < NEUTRAL).all():
        return None
    near = moved <= REACH * distance + SMALLEST and abs(point.parameter - model.V) < 1e-14
    return shot if near and _size(model, shot.state) > 0.1 * size else None


def _size(model: Model, state: State) -> float:
    """Amplitude of a motion at rest in space: how far the blocks are from steady sliding."""
    return float(np.abs(state.x - steady_displacements(model, model.V)).max())


def _two_extremes(
    model: Model, state: State, rtol: float
) -> tuple[int, State, State, float] | None:
    """Block, states at two maxima of its displacement, and the time between; None if it lands."""
    shooter = Shooter(model, rtol=rtol, tangents=False)
    frequencies = np.abs(modes(model, model.V).values)
    step = 2.0 * np.pi * STEP / frequencies.max()
    n_steps = int(PATIENCE * 2.0 * np.pi / frequencies.min() / step)
    block = int(np.argmax(np.abs(state.w + model.V)))
    extremes: list[State] = []
    times: list[float] = []
    here, t = state, 0.0
    for _ in range(n_steps):
        leg = shooter.leg(here, 1, max_time=step)
        if leg.events or leg.status:
            return None
        before, after = here.w[block] + model.V, leg.state.w[block] + model.V
        if before > 0.0 >= after:
            part = _turning(shooter, here, block, step)
            extremes.append(shooter.leg(here, 1, max_time=part).state)
            times.append(t + part)
            if len(times) == 2:
                return block, extremes[0], extremes[1], times[1] - times[0]
        here, t = leg.state, t + step
    return None


def _turning(shooter: Shooter, state: State, block: int, step: float) -> float:
    """Time within a step at which a block comes to rest in space."""
    low, high = 0.0, step
    for _ in range(30):
        middle = 0.5 * (low + high)
        v = shooter.leg(state, 1, max_time=middle).state.w[block] + shooter.system.V
        low, high = (middle, high) if v > 0.0 else (low, middle)
    return 0.5 * (low + high)
