"""How a cycle changes with parameters: its period, its states at events, its multipliers."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from functools import cache
from itertools import takewhile
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.cycle.mode_changes import (
    NOT_SOLVED,
    beginning,
    converged,
    on_section,
    touches,
)
from stickslip.mechanics.cycle.shooting import Shooter
from stickslip.mechanics.flow.sensitivity import NO_CLEARANCE
from stickslip.numerics.continuation import LeavesRegion

if TYPE_CHECKING:
    from stickslip.mechanics.cycle.cycle import Cycle
    from stickslip.mechanics.cycle.section import Shooting
    from stickslip.numerics.arrays import Floats

# Multipliers: widest step of differences, of a parameter, and how often it may be halved; errors,
# of the size of the derivative, that are small enough, and above which there is none.
STEP: Final = 4e-3
HALVINGS: Final = 24
ENOUGH, SURE = 1e-11, 1e-6
SAME: Final = 1e-12  # of the largest multiplier: two so close are one
# Of a parameter: how far a cycle may be from one that just touches, whose events rounding decides.
ASIDE: Final = (1e-15, 1e-14, 1e-13, 1e-12)
# Steps to the cycles that differences take: on both sides, ahead, behind; nearest ones first.
STENCILS: Final = ((0, 1, -1, 2, -2, 3, -3, 4, -4), tuple(range(9)), tuple(range(0, -9, -1)))


class CycleRates(NamedTuple):
    """Derivatives of a cycle with its sequence of modes; the last axis has a column per name.

    Attributes
    ----------
    names : tuple of str
    period : ndarray, shape (names,)
    x, v : ndarray, shape (events, N, names)
        Of the states just after each of `Cycle.events`, wherever on the motion these move to.
    multipliers : ndarray of complex, shape (multipliers, names)
        Of each of `Cycle.multipliers`: differences of high order of exact ones, to about ten
        digits; NaN where these cannot be had, as where multipliers meet.
    margin : float
        How near an event is to appear, to vanish or to meet another one.
    status : int
        `stickslip.status`: OK; ONE_SIDED where the margin is none: the cycle has these derivatives
        on one side only.
    """

    names: tuple[str, ...]
    period: Floats
    x: Floats
    v: Floats
    multipliers: Any
    margin: float
    status: int


def cycle_rates(cycle: Cycle, names: tuple[str, ...]) -> CycleRates:
    """Differentiate all of a cycle."""
    n, (time, _) = len(cycle.model.plant.mass), beginning(cycle)
    rates = [Rates(cycle, name) for name in names]
    states = np.stack([each.states for each in rates], axis=-1)
    before = sum(event.time <= time for event in cycle.events)
    states = np.roll(states, before, axis=0)
    shooter = Shooter(cycle.model, tangents=False)
    near = touches(shooter, rates[0].shot.state, cycle.period)
    margin = min((abs(touch.room) for touch in near), default=np.inf)
    return CycleRates(
        names=names,
        period=np.array([each.period for each in rates]),
        x=states[:, :-n],
        v=states[:, -n:],
        multipliers=np.stack([each.multipliers for each in rates], axis=-1),
        margin=float(margin),
        status=status_codes.ONE_SIDED if margin <= NO_CLEARANCE else status_codes.OK,
    )


class Rates:
    """What one parameter changes, by the linearised equations of the cycle on a section."""

    def __init__(self, cycle: Cycle, name: str) -> None:
        self.cycle = cycle
        self.shooting, self.unknowns = _with_its_events(cycle, name)
        try:
            _, jacobian, self.shot = self.shooting(self.unknowns)
        except LeavesRegion as left:
            raise ValueError(f"{NOT_SOLVED}.") from left
        self.rates = np.linalg.lstsq(jacobian[:, :-1], -jacobian[:, -1])[0]

    @property
    def period(self) -> float:
        """Of the period."""
        shooting = self.shooting
        if not shooting.free:
            return shooting.rounds * self.shot.period_change
        return float(self.rates[shooting.n_states])

    @property
    def states(self) -> Floats:
        """Of displacements and velocities just after each event from the section on."""
        plant, start = self.cycle.model.plant, self.shot.state
        moved = self.shooting.section.ways @ self.rates[: self.shooting.n_states]
        shooter = Shooter(self.cycle.model, parameter=self.shooting.name)
        rows, n = [np.zeros((0, len(plant.mass) + plant.n_positions))], 0
        for number in range(1, len(self.shot.word) + 1):
            if n == len(self.shot.word):
                break  # some were settled together
            leg = shooter.leg(start, number)
            row = plant.jacobians[0] @ (leg.tangent @ moved + leg.parameter)
            if shooter.change is not None:
                row += plant.states_change(leg.state.z, leg.state.t, shooter.change)
            rows.append(np.repeat(row[None], len(leg.events) - n, axis=0))
            n = len(leg.events)
        return np.concatenate(rows)

    @property
    def multipliers(self) -> Any:
        """Of the multipliers, by differences of exact ones: of many widths the surest."""
        own, base = float(self.unknowns[-1]), self.shot.multipliers
        best, error = np.full(base.shape, np.nan, dtype=np.complex128), np.full(len(base), np.inf)
        h = STEP * (abs(own) or 1.0)
        known = cache(self._multipliers)  # half as wide differences take half of the cycles again
        for _ in range(HALVINGS):
            before = error.copy()
            for steps in STENCILS:  # beside a grazing there are cycles on one side only
                found = (known(step * h) for step in steps)
                values = list(takewhile(lambda each: each is not None, found))
                if len(values) == len(steps):
                    slope, rough = (_slope(steps[:n], values) / h for n in (9, 7))
                    surer = abs(slope - rough) < error
                    best[surer], error[surer] = slope[surer], abs(slope - rough)[surer]
                    break
            size = abs(best) + abs(base)
            if np.isfinite(error).all() and (
                (error <= ENOUGH * size).all() or (error == before).all()
            ):
                break
            h *= 0.5
        best[~(error <= SURE * (abs(best) + abs(base)))] = np.nan
        return best

    def _multipliers(self, step: float) -> Any | None:
        """Return those of the cycle at another value of the parameter, in the order of here."""
        guess = self.unknowns + step * np.append(self.rates, 1.0)
        y = converged(self.shooting, guess, abs(step))
        if y is None:
            return None
        base = self.shot.multipliers
        left, found = list(self.shooting.shot(y).multipliers), []
        for value in base:
            found.append(left.pop(int(np.argmin(np.abs(np.array(left) - value)))))
        # One that is nearer to another's place than to its own may be the other.
        off = np.abs(np.subtract.outer(found, base))
        mixed = off.diagonal() > off.min(axis=1) + SAME * np.abs(base).max(initial=1.0)
        return None if mixed.any() else np.array(found)


def _with_its_events(cycle: Cycle, name: str) -> tuple[Shooting, Floats]:
    """Equations of a cycle; where rounding decides whether it touches, of the one just beside."""
    shooting, y = on_section(cycle, name)
    free, size = replace(shooting, word=None), abs(float(y[-1])) or 1.0
    for step in (0.0, *(way * share * size for share in ASIDE for way in (1.0, -1.0))):
        near = converged(free, np.append(y[:-1], y[-1] + step), size) if step else y
        if near is not None:
            with suppress(LeavesRegion):
                word = free.shot(near).word
                if len(word) == len(cycle.events):
                    return replace(shooting, word=word), near
    return shooting, y


def _slope(steps: tuple[int, ...], values: list[Any]) -> Any:
    """Differentiate the polynomial through values, at step 0."""
    powers = np.vander(np.array(steps, dtype=float), increasing=True)
    return np.linalg.solve(powers, np.array(values[: len(steps)]))[1]
