"""A cycle as the zero of a function: shooting from a section through it, over one period."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State, sizes_of
from stickslip.numerics.continuation import LeavesRegion

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.mechanics.model.plant import Plant, Reduced
    from stickslip.numerics.arrays import Floats, Ints


Word: TypeAlias = tuple[tuple[int, int], ...]
"""Changes of mode in one period: block (from 0) and its new mode."""

EVENTS: Final = 100_000  # in one period, after which a shot is given up
SAME: Final = 1e-9  # relative: periods that rounding tells apart
ROUNDING: Final = 1e-14  # of the return's norm: multipliers this small are zero


class Section(NamedTuple):
    """Where a period begins: where a coordinate is extreme, or at a time of the forcing."""

    # Friction does not act on y: y' is linear in the state, a plane in which each cycle without
    # forcing begins twice a period or more. A block that rests in space is an example; no contact
    # with a moving belt has an event there. Steady sliding lies in all of these planes.

    mode: Ints  # of all contacts there
    ways: Floats  # orthonormal columns: changes of a state with these modes that something feels
    along: Floats | None = None  # row: along @ y is extreme; None: at a time
    time: float = 0.0  # of the forcing

    @classmethod
    def through(cls, plant: Plant, state: State, along: Floats | None = None) -> Section:
        """Section through a state."""
        return cls(state.mode, plant.ways(state.free), along, state.t if along is None else 0.0)


def coordinates(plant: Plant) -> Floats:
    """Rows: directions of y that something feels, one for each coordinate."""
    n = plant.reduced.n_free - plant.n_waves
    turns = plant.turns[:n]
    rows = np.eye(n) - turns @ turns.T
    sizes = np.linalg.norm(rows, axis=1)
    return np.asarray(rows[sizes > 0.5 / n] / sizes[sizes > 0.5 / n, None])


def _rates(reduced: Reduced) -> tuple[Floats, Floats]:
    """Matrix and constant of y' in the state, where nothing is forced."""
    own = slice(reduced.n_waves, reduced.n_free)
    return reduced.matrix[own, reduced.n_waves :], reduced.constant[own]


@dataclass(frozen=True, eq=False)
class Shot:
    """One period from a section: its start, where it led, the rate of change there."""

    model: Model
    section: Section
    state: State
    leg: Leg
    velocity: Floats
    change: Reduced | None  # derivative of the plant in the parameter; None: there is none
    period_change: float  # ... and of the forcing's period

    @property
    def word(self) -> Word:
        """Changes of mode."""
        return word_of(self.leg)

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Floquet multipliers by descending size, as in `Cycle`; the trivial one is left out."""
        # More than the directions that are free in the phase with most riders are exact zeros.
        ways, plant = self.section.ways, self.model.plant
        matrix = ways.T @ self.leg.tangent @ ways
        total = len(ways) - plant.turns.shape[1]
        rank = fewest_freedoms(plant, self.leg)
        if self.normal is not None:
            lost = self.normal @ ways @ matrix / self.bend
            matrix = matrix - np.outer(ways.T @ self.velocity, lost)
            rank, total = rank - 1, total - 1
        values = np.linalg.eigvals(matrix).astype(np.complex128)
        values = values[np.argsort(-np.abs(values), kind="stable")][:rank]
        values[np.abs(values) <= ROUNDING * np.linalg.norm(matrix)] = 0.0
        return np.concatenate([values, np.zeros(total - len(values))])

    @cached_property
    def normal(self) -> Floats | None:
        """Normal of the section's plane, not of length 1."""
        along = self.section.along
        return None if along is None else along @ _rates(self.model.plant.reduced)[0]

    @property
    def bend(self) -> float:
        """Second derivative of what is extreme at the section; 1 at a time of the forcing."""
        return 1.0 if self.normal is None else float(self.normal @ self.velocity)

    @property
    def crossing(self) -> float:
        """Cosine between the motion and the normal of the section."""
        if self.normal is None:
            return 1.0
        ways = self.section.ways
        sizes = [np.linalg.norm(ways.T @ each) for each in (self.normal, self.velocity)]
        return self.bend / float(np.prod(sizes))


def word_of(leg: Leg) -> Word:
    """Return the changes of mode along a leg."""
    return tuple((block, mode) for _, block, mode in leg.events)


def fewest_freedoms(plant: Plant, leg: Leg) -> int:
    """Directions that are free in the phase of a leg that leaves fewest."""
    # Changes at one instant are one: between them there is no phase.
    state, begun, phases = leg.start, 0.0, {}
    for t, block, new in [*leg.events, (leg.duration, 0, 0)]:
        if t > begun:
            phases[state.mode.tobytes()] = state.free
        mode = state.mode.copy()
        mode[block] = new
        state, begun = state._replace(mode=mode), t
    return min(plant.ways(free).shape[1] for free in phases.values())


@dataclass(frozen=True, eq=False)
class Shooting:
    """Equations of a cycle along a parameter: ``F(state, period, parameter) = 0``."""

    model: Model
    name: str
    section: Section
    word: Word | None = None  # changes of mode that every shot must have
    rounds: int = 1  # periods of the forcing in one
    rtol: float = 1e-15
    mirrored: bool = False  # half a period leads to the mirror image: x(t + T/2) = -x(t)

    # --- between unknowns and states ----------------------------------------------------------

    def unknowns(self, state: State, period: float, value: float) -> Floats:
        """Unknowns of a start on the section."""
        return np.array([*state.z @ self.section.ways, *self._own(period), value])

    def start(self, y: Floats) -> tuple[Model, State, float]:
        """Model, state on the section and period that the unknowns stand for."""
        model = self.model.replace(**{self.name: float(y[-1])})
        z = self.section.ways @ y[: self.n_states]
        period = float(y[-2]) if self.free else self.rounds * model.plant.period
        return model, State(z, self.section.mode.copy(), self.section.time), period

    def scale(self, width: float, y: Floats) -> Floats:
        """Size of each unknown near a solution; of the parameter the width of its range."""
        sizes = np.abs(self.section.ways).T @ sizes_of(self.model.plant)
        far = float((np.abs(y[: self.n_states]) / sizes).max(initial=1.0))
        return np.array([*(far * sizes), *self._own(float(y[-2])), width])

    @property
    def free(self) -> bool:
        """Whether the period is unknown, and not the forcing's."""
        return self.section.along is not None

    @property
    def n_states(self) -> int:
        """Unknowns that tell the state."""
        return self.section.ways.shape[1]

    @property
    def _way(self) -> tuple[int, float]:
        """Sign of a state where a shot leads to, and its share of the period."""
        return (-1, 0.5) if self.mirrored else (1, 1.0)

    def _own(self, period: float) -> list[float]:
        return [period] if self.free else []

    # --- the equations --------------------------------------------------------------------------

    def shot(self, y: Floats) -> Shot:
        """Follow one period; LeavesRegion, caused by the shot, where its modes are others."""
        model, state, period = self.start(y)
        slips = self.section.mode != 0
        if period <= 0.0 or (state.w[slips] * self.section.mode[slips] <= 0.0).any():
            raise LeavesRegion
        shooter = Shooter(model, rtol=self.rtol, parameter=self.name)
        side, share = self._way
        leg = shooter.leg(state, EVENTS, max_time=share * period)
        velocity = shooter.velocity(leg.state)
        moved = shooter.change, shooter.period_change
        shot = Shot(model, self.section, state, leg, velocity, *moved)
        if leg.status != status_codes.OK or (leg.state.mode != side * state.mode).any():
            raise LeavesRegion(shot)
        if self.word is not None and shot.word != self.word:
            raise LeavesRegion(shot)
        return shot

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Shot]:
        """Residual, its derivative, and the shot."""
        shot = self.shot(y)
        leg, ways, along = shot.leg, self.section.ways, self.section.along
        side, share = self._way
        to = side * ways.T
        back = ways.T @ (side * leg.state.z - shot.state.z)
        by_state = to @ leg.tangent @ ways - np.eye(self.n_states)
        by_parameter, rate = to @ leg.parameter, share * to @ shot.velocity
        if along is None or shot.normal is None:
            by_parameter += rate * self.rounds * shot.period_change
            return back, np.column_stack([by_state, by_parameter]), shot
        at, moved = shot.state.z, 0.0
        if shot.change is not None:
            matrix, constant = _rates(shot.change)
            moved = float(along @ (matrix @ at + constant))
        off = along @ shot.model.plant.rows(at)[0]
        plane = [*shot.normal @ ways, 0.0, moved]
        jacobian = np.column_stack([by_state, rate, by_parameter])
        return np.append(back, off), np.vstack([jacobian, plane]), shot
