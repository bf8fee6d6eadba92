"""Limit cycles of any model in continuous time, as results."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.mechanics.cycle.rates import CycleRates, Rates, cycle_rates
from stickslip.mechanics.cycle.section import EVENTS, SAME, Shot
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State
from stickslip.mechanics.flow.trajectory import EVENT_KINDS, Event, Trajectory, simulate
from stickslip.mechanics.model.arguments import checked_parameter
from stickslip.results.result import Result

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats


NEUTRAL: Final = 1e-7  # multipliers this close to the unit circle neither attract nor repel


@dataclass(frozen=True, eq=False, repr=False)
class Cycle(Result):
    """A periodic motion in continuous time.

    Attributes
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    period : float
        Units of sqrt(m / k).
    multipliers : ndarray of complex
        Floquet multipliers by descending size: 2 N - 1 of them, the trivial one left out; 2 N of
        a forced model. Directions that a stick phase forgets have exact zeros.
    stable : bool
        All multipliers are inside the unit circle.
    x, v : ndarray of float, shape (N,)
        A state of the cycle: just after an event, or where a coordinate is extreme; of a forced
        model at the forcing's phase at time 0.
    events : tuple of Event
        Changes of mode in one period, times from that state on.
    d : ndarray
        Differences ``X_{i+1} - X_i`` of its global stick phases, shape (k,) for two blocks, else
        (k, N - 1): an orbit of the event map; empty if it has none.
    residual : float
        Largest difference of the state from itself a period later.
    """

    model: Model
    period: float
    multipliers: NDArray[np.complex128]
    stable: bool
    x: Floats
    v: Floats
    events: tuple[Event, ...]
    residual: float
    _trajectory: list[Trajectory] = field(default_factory=list, init=False, compare=False)
    _column_names: ClassVar = (
        *("period", "multiplier", "multiplier_imag", "stable", "events", "global_sticks"),
    )
    _plot: ClassVar = "cycles.plot_cycle"

    @property
    def trajectory(self) -> Trajectory:
        """The motion over one period."""
        if not self._trajectory:
            self._trajectory.append(simulate(self.model, self.x, self.v, t_end=self.period))
        return self._trajectory[0]

    @property
    def largest_multiplier(self) -> complex:
        """The multiplier of largest modulus, of a pair the one above the axis; 0 without any."""
        return max(map(complex, self.multipliers), key=lambda m: (abs(m), m.imag), default=0j)

    @property
    def d(self) -> Floats:
        """Differences of the displacements in its global stick phases."""
        if not self.events:
            return self.trajectory.d
        # Of a cycle that starts in such a phase the motion may meet it again as the period ends.
        rides = self.trajectory.modes[0] == 0
        count = 0
        for event in self.events:
            rides[event.block - 1] = event.kind == "stick"
            count += rides.all()
        return self.trajectory.d[:count]

    def period_derivative(self, *names: str) -> Floats:
        """Differentiate the period by parameters, exactly.

        Parameters
        ----------
        *names : str
            Among ``model.parameters``.

        Returns
        -------
        ndarray of float, shape (names,)
            Of the cycle with the same sequence of modes; that of a multiplier 1 has none: inf or
            of any size.

        Raises
        ------
        ValueError
            No name, or an unknown one; the cycle cannot be solved for with its own modes.
        """
        return np.array([Rates(self, name).period for name in self._checked(names)])

    def derivative(self, *names: str) -> CycleRates:
        """Differentiate the cycle by parameters: period, states at events, multipliers.

        Parameters
        ----------
        *names : str
            Among ``model.parameters``.

        Returns
        -------
        CycleRates
            `period`, `x`, `v`, `multipliers`, with a column for each name; `margin` and `status`,
            which tell where an event is about to appear or to vanish.

        Raises
        ------
        ValueError
            As `period_derivative`.
        """
        return cycle_rates(self, self._checked(names))

    def _checked(self, names: tuple[str, ...]) -> tuple[str, ...]:
        if not names:
            raise ValueError("names of parameters are needed, at least one")
        return tuple(checked_parameter("names", self.model, name) for name in names)

    def __repr__(self) -> str:
        """Period, multipliers and events."""
        word = "stable" if self.stable else "not stable"
        sizes = ", ".join(multiplier_text(value) for value in self.multipliers)
        lines = [f"Cycle: period {self.period:.12g}, {word}, {len(self.events)} events"]
        lines.append(f"  multipliers {sizes or 'none'}")
        lines += [f"  t = {e.time:<14.10g} block {e.block}  {e.kind}" for e in self.events[:8]]
        if len(self.events) > 8:
            lines.append(f"  ... {len(self.events) - 8} more")
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        largest = self.largest_multiplier
        parts = (float(largest.real), float(largest.imag))
        facts = (self.period, *parts, self.stable, len(self.events), len(self.d))
        return {name: [fact] for name, fact in zip(self._column_names, facts, strict=True)}


def multiplier_text(value: complex) -> str:
    """Write a multiplier, real ones without an imaginary part."""
    return f"{value.real:.8g}" if value.imag == 0.0 else f"{value.real:.6g}{value.imag:+.6g}i"


def cycle_of(shot: Shot) -> Cycle:
    """Cycle that a converged shot from a section is, of a forced model begun at time 0."""
    start, leg = shot.state, shot.leg
    cycle = cycle_along(shot.model, start, leg, shot.multipliers)
    if not start.t:
        return cycle
    # An event at time 0 is told once, which the motion from there on would not.
    period, before = leg.duration, -start.t % leg.duration
    begun = Shooter(shot.model, tangents=False).leg(start, EVENTS, max_time=before).state
    x, v = shot.model.plant.states(begun.z)
    events = [event._replace(time=(event.time - before) % period) for event in cycle.events]
    return replace(cycle, x=x, v=v, events=tuple(sorted(events, key=lambda event: event.time)))


def cycle_along(model: Model, state: State, leg: Leg, multipliers: NDArray[np.complex128]) -> Cycle:
    """Cycle that a leg is, which leads from a state back to the state."""
    x, v = model.plant.states(state.z, state.t)
    return Cycle(
        model=model,
        period=leg.duration,
        multipliers=multipliers,
        stable=bool((np.abs(multipliers) < 1.0 - NEUTRAL).all()),
        x=x,
        v=v,
        events=tuple(Event(t, block + 1, EVENT_KINDS[mode]) for t, block, mode in leg.events),
        residual=float(np.abs(model.plant.felt(leg.state.z - state.z)).max()),
    )


def same_cycle(a: Cycle, b: Cycle) -> bool:
    """Tell whether two cycles of one model are the same motion, up to a shift of time."""
    if abs(a.period - b.period) > SAME * a.period or len(a.events) != len(b.events):
        return False
    if not a.events:
        t = np.linspace(0.0, 1.0, 65)
        ends = [cycle.trajectory.x(t * cycle.period).max(axis=0) for cycle in (a, b)]
        return bool(np.abs(ends[0] - ends[1]).max() <= 1e-2 * np.abs(ends[0]).max())
    words = [[(event.block, event.kind) for event in cycle.events] for cycle in (a, b)]
    gaps = [
        np.diff([event.time for event in cycle.events], append=cycle.events[0].time + cycle.period)
        for cycle in (a, b)
    ]
    shifts = range(len(a.events))
    return any(
        words[0] == words[1][k:] + words[1][:k]
        and np.abs(gaps[0] - np.roll(gaps[1], -k)).max() <= np.sqrt(SAME) * a.period
        for k in shifts
    )
