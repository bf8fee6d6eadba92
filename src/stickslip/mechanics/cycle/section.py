"""A cycle as the zero of a function: shooting from a section through it, over one period."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State, size_of
from stickslip.numerics.continuation import LeavesRegion

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats, Ints


Word: TypeAlias = tuple[tuple[int, int], ...]
"""Changes of mode in one period: block (from 0) and its new mode."""

EVENTS: Final = 100_000  # in one period, after which a shot is given up


class Section(NamedTuple):
    """Where a period begins: where a contact rests in space, or at a time of the forcing."""

    # There a block is at an extreme of its displacement and slips, because the belt does not rest:
    # no event is there.

    block: int | None  # from 0; None: of a forced model
    mode: Ints  # of all contacts there
    n_free: int  # coordinates y
    time: float = 0.0  # of the forcing

    @property
    def compared(self) -> NDArray[np.bool_]:
        """Coordinates that must come back: those that vary."""
        return np.concatenate([np.ones(self.n_free, dtype=bool), self.mode != 0])

    @property
    def unknown(self) -> NDArray[np.bool_]:
        """Coordinates that are unknown: the velocity at the section is not."""
        unknown = self.compared
        if self.block is not None:
            unknown[self.n_free + self.block] = False
        return unknown


@dataclass(frozen=True, eq=False)
class Shot:
    """One period from a section: its start, where it led, the rate of change there."""

    model: Model
    section: Section
    state: State
    leg: Leg
    velocity: Floats
    belt_change: Floats  # derivative of the belts' velocities in the parameter
    period_change: float  # ... and of the forcing's period

    @property
    def word(self) -> Word:
        """Changes of mode."""
        return word_of(self.leg)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers, as in `Cycle`."""
        return multipliers(self.section, self.leg, self.velocity)


def word_of(leg: Leg) -> Word:
    """Return the changes of mode along a leg."""
    return tuple((block, mode) for _, block, mode in leg.events)


def multipliers(section: Section, leg: Leg, velocity: Floats) -> NDArray[np.complex128]:
    """Floquet multipliers of one period by descending size; the trivial one is left out."""
    # More than the directions that are free in the phase with most riders are exact zeros.
    kept = section.compared
    matrix = leg.tangent[np.ix_(kept, kept)]
    rank, total = section.n_free + _fewest_slipping(section, leg), kept.size
    if section.block is not None:
        rate = velocity[kept]
        row = int(np.count_nonzero(kept[: section.n_free + section.block]))
        matrix = matrix - np.outer(rate, matrix[row]) / rate[row]
        matrix = np.delete(np.delete(matrix, row, axis=0), row, axis=1)
        rank, total = rank - 1, total - 1
    values = np.linalg.eigvals(matrix).astype(np.complex128)
    values = values[np.argsort(-np.abs(values), kind="stable")][:rank]
    return np.concatenate([values, np.zeros(total - len(values))])


def _fewest_slipping(section: Section, leg: Leg) -> int:
    mode = section.mode.copy()
    fewest = int(np.count_nonzero(mode))
    for _, block, new in leg.events:
        mode[block] = new
        fewest = min(fewest, int(np.count_nonzero(mode)))
    return fewest


class Shooting:
    """Equations of a cycle along a parameter: ``F(x, slipping w, period, parameter) = 0``."""

    # `word`: changes of mode that every shot must have; `rounds`: periods of the forcing in one.

    def __init__(
        self,
        model: Model,
        name: str,
        section: Section,
        *,
        word: Word | None = None,
        rounds: int = 1,
        rtol: float = 1e-15,
    ) -> None:
        self.model, self.name, self.section = model, name, section
        self.word, self.rounds, self.rtol = word, rounds, rtol

    # --- between unknowns and states ----------------------------------------------------------

    def unknowns(self, state: State, period: float, value: float) -> Floats:
        """Unknowns of a start on the section."""
        own = [] if self.section.block is None else [period]
        return np.array([*state.z[self.section.unknown], *own, value])

    def start(self, y: Floats) -> tuple[Model, State, float]:
        """Model, state on the section and period that the unknowns stand for."""
        model = self.model.replace(**{self.name: float(y[-1])})
        section, unknown = self.section, self.section.unknown
        z = np.zeros(unknown.size)
        z[unknown] = y[: np.count_nonzero(unknown)]
        if section.block is None:
            period = self.rounds * model.plant.period
        else:
            z[section.n_free + section.block] = -model.plant.V[section.block]
            period = float(y[-2])
        return model, State(z, section.mode.copy(), section.time), period

    def scale(self, width: float, period: float) -> Floats:
        """Size of each unknown; of the parameter the width of its range."""
        own = [] if self.section.block is None else [period]
        sizes = np.full(np.count_nonzero(self.section.unknown), size_of(self.model.plant))
        return np.array([*sizes, *own, width])

    # --- the equations --------------------------------------------------------------------------

    def shot(self, y: Floats) -> Shot:
        """Follow one period; LeavesRegion, caused by the shot, where its modes are others."""
        model, state, period = self.start(y)
        slips = self.section.mode != 0
        if period <= 0.0 or (state.w[slips] * self.section.mode[slips] <= 0.0).any():
            raise LeavesRegion
        shooter = Shooter(model, rtol=self.rtol, parameter=self.name)
        leg = shooter.leg(state, EVENTS, max_time=period)
        velocity = shooter.velocity(leg.state)
        moved = shooter.belt_change, shooter.period_change
        shot = Shot(model, self.section, state, leg, velocity, *moved)
        if leg.status != status_codes.OK or (leg.state.mode != state.mode).any():
            raise LeavesRegion(shot)
        if self.word is not None and shot.word != self.word:
            raise LeavesRegion(shot)
        return shot

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Shot]:
        """Residual, its derivative, and the shot."""
        shot = self.shot(y)
        section, leg = self.section, shot.leg
        kept, unknown = section.compared, section.unknown
        residual = (leg.state.z - shot.state.z)[kept]
        by_state = (leg.tangent - np.eye(unknown.size))[kept]
        by_parameter = leg.parameter[kept].copy()
        columns = [by_state[:, unknown]]
        rate = shot.velocity[kept]
        if section.block is not None:
            columns.append(rate[:, None])
            own = section.n_free + section.block  # there w = -V
            by_parameter -= by_state[:, own] * shot.belt_change[section.block]
        else:
            by_parameter += rate * self.rounds * shot.period_change
        columns.append(by_parameter[:, None])
        return residual, np.hstack(columns), shot
