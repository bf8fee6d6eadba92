"""Motions in time: exact evaluation at any instant, events, slips, friction and energy."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stickslip import status as status_codes
from stickslip.checks import (
    check_callback,
    finite_number,
    flag,
    one_of,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.flow.engine import EngineName, block_engine, engine_for, tolerance
from stickslip.mechanics.flow.recorder import (
    BlocksRecorder,
    Instant,
    Recorded,
    Recorder,
    TwoBlockRecorder,
    phase_starts,
)
from stickslip.mechanics.flow.sensitivity import Origin, Sensitivity, sensitivity
from stickslip.mechanics.flow.slip import Slip, SlipTracker
from stickslip.mechanics.model.arguments import Model, checked_model, checked_state
from stickslip.mechanics.model.plant import sliding_friction
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.numerics.waiting import waits
from stickslip.results.parts import part
from stickslip.results.result import Result
from stickslip.results.table import Table
from stickslip.vocabulary import suggests

EVENT_KINDS = {-1: "slip backward", 0: "stick", 1: "slip forward"}
# Nodes of the quadrature over one step: far beyond what its smooth integrands need.
QUADRATURE = np.polynomial.legendre.leggauss(20)


@part
class Event(NamedTuple):
    """A block (counted from 1) takes another mode: "stick", "slip backward", "slip forward"."""

    time: float
    block: int
    kind: str


@part
class State(NamedTuple):
    """Time, displacements and velocities, (N,) each: ``simulate(model, x, v)`` goes on there."""

    t: float
    x: Floats
    v: Floats


@dataclass(frozen=True, eq=False, repr=False)
class Energy(Result):
    """Energy of a motion, units of f_s1^2 / k, every field shaped like ``t``, the times asked for.

    ``belt_work``, ``forcing_work`` and ``dissipation`` (by friction and dampers) count from
    the start of the trajectory, so that `balance` stays as it was there.
    """

    kinetic: Floats
    elastic: Floats
    belt_work: Floats
    forcing_work: Floats
    dissipation: Floats
    t: Floats
    _column_names: ClassVar = (
        *("t", "kinetic", "elastic", "belt_work", "forcing_work"),
        *("dissipation", "balance"),
    )
    _drawn: ClassVar = _column_names

    @property
    @np.errstate(invalid="ignore")  # infinite energies have no difference
    def balance(self) -> Floats:
        """Kinetic and elastic energy less the work put in, plus what friction and dampers took."""
        put_in = self.belt_work + self.forcing_work
        return self.kinetic + self.elastic - put_in + self.dissipation

    def _columns(self) -> dict[str, Any]:
        return {name: np.ravel(getattr(self, name)) for name in self._column_names}


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Result):
    """A motion in time; `simulate` makes it.

    Attributes
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    t : ndarray, shape (n + 1,)
        Ends of the phases of constant modes; ``t[0] = 0``.
    modes : ndarray of int, shape (n, N)
        Mode of each block in each phase: -1 backward, 0 stick, +1 forward.
    events : tuple of Event
    slips : tuple of Slip
        Those that both begin and end within the trajectory.
    d : ndarray, shape (k,) for two blocks, else (k, N - 1)
        ``X_{i+1} - X_i`` of its global stick phases: an orbit of the event map.
    final_state : State
    status : int
        `stickslip.status`: OK where the end asked for was reached.
    """

    model: Model
    _record: Recorded
    d: Floats
    status: int
    _origin: Origin | None = None
    _plot: ClassVar = "motion.plot_trajectory"

    @property
    def message(self) -> str:
        """What the status means."""
        if self.status == status_codes.OK:
            return "reached its end"
        return status_codes.MESSAGES[self.status]

    def __repr__(self) -> str:
        """One line, then the first events."""
        return self._told(float(self.t[-1]), self.events)

    def _told(self, end: float, events: tuple[Event, ...]) -> str:
        """Describe the motion with its end and events in any unit of time."""
        lines = [
            f"Trajectory: t = 0 .. {end:.6g}, {len(events)} events, "
            f"{len(self.d)} global stick phases, {self.message}"
        ]
        lines += [f"  t = {e.time:<12.8g} block {e.block}  {e.kind}" for e in events[:8]]
        if len(events) > 8:
            lines.append(f"  ... {len(events) - 8} more")
        return "\n".join(lines)

    # --- phases and events ------------------------------------------------------------------

    @cached_property
    def _changes(self) -> NDArray[np.int64]:
        """Steps at which a phase begins."""
        return phase_starts(self._record.mode)

    @cached_property
    def t(self) -> Floats:
        """Ends of the phases of constant modes, units of sqrt(m / k)."""
        return np.append(self._record.t[self._changes], self._record.t[-1])

    @cached_property
    def modes(self) -> NDArray[np.int64]:
        """Mode of each block in each phase."""
        return np.asarray(self._record.mode[self._changes])

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """Changes of mode in order of time."""
        modes = np.vstack((self.modes, self._record.mode[-1:]))
        return tuple(
            Event(float(time), block + 1, EVENT_KINDS[int(new[block])])
            for time, old, new in zip(self.t[1:], modes, modes[1:], strict=False)
            for block in range(self.model.n_blocks)
            if old[block] != new[block]
        )

    @cached_property
    def slips(self) -> tuple[Slip, ...]:
        """Slips that both begin and end within this trajectory, in the order of their ends."""
        record, plant = self._record, self.model.plant
        tracker = SlipTracker(plant, record.w[0])
        seen = (
            tracker.see(t, plant.travel(record.x[k], t).tolist(), record.mode[k])
            for k in [*self._changes, -1]
            for t in [float(record.t[k])]
        )
        return tuple(itertools.chain.from_iterable(seen))

    # --- state at any time --------------------------------------------------------------------

    def x(self, t: ArrayLike) -> Floats:
        """Displacements of the blocks, units of f_s1 / k.

        Parameters
        ----------
        t : array_like of float, any shape
            Times within the trajectory, units of sqrt(m / k).

        Returns
        -------
        ndarray of float, shape (..., N)

        Raises
        ------
        ValueError
            A time is NaN or outside; the trajectory was made with ``record="events"``.
        """
        return self._state(t)[0]

    def v(self, t: ArrayLike) -> Floats:
        """Velocities of the blocks, shape (..., N), units of f_s1 / sqrt(k m); as `x`."""
        return self._state(t)[1]

    def friction(self, t: ArrayLike) -> Floats:
        """Friction force of the belt on each block, shape (..., N), units of f_s1; as `x`.

        While a block sticks it is the force it needs in order to ride.
        """
        return self._friction(self._state(t), self._mode(t))

    def needed_force(self, t: ArrayLike) -> Floats:
        """Force that each block needs in order to ride, shape (..., N), units of f_s1; as `x`."""
        return self._state(t)[3]

    @np.errstate(over="ignore", invalid="ignore")  # speeds have squares beyond all floats
    def energy(self, t: ArrayLike) -> Energy:
        """Energy at given times, with the work done since the start; times as in `x`."""
        times = self._checked(t)
        x, v, _, _ = self._state(times)
        step = self._step(times)
        before = self._work_done[step]
        partial = self._work(step.ravel(), (times - self._record.t[step]).ravel())
        belt, forcing, dissipation = np.moveaxis(before + partial.reshape(*times.shape, 3), -1, 0)
        plant = self.model.plant
        return Energy(
            kinetic=0.5 * np.sum(v * plant.momenta(v), axis=-1),
            elastic=plant.elastic_energy(x),
            belt_work=belt,
            forcing_work=forcing,
            dissipation=dissipation,
            t=times,
        )

    def derivative(self, *names: str) -> Sensitivity:
        """Differentiate the motion, exactly, through all of its events.

        Parameters
        ----------
        *names : str
            Parameters of the model; ``"x0"``, ``"v0"``, the starting displacements and velocities,
            all of them, or ``"x0_2"``, one; ``"d"`` of a motion that was started with `d`. Where
            the model has a parameter of that name, the parameter is meant.

        Returns
        -------
        Sensitivity
            Derivatives of displacements and velocities at any time, of the times of events, of
            slips and global stick phases, with an entry for each of its ``names``.

        Raises
        ------
        ValueError
            No name, or one that is unknown; a law of the model cannot be traced; the
            trajectory is one of a quasistatic map.

        Notes
        -----
        The motion is followed once more, with tangents. Blocks that ride at the start ride
        whatever changes. Where an event is about to appear or to vanish, `Sensitivity.margin` is
        small; at rounding the status is ONE_SIDED, and a touch ends the derivatives.

        Examples
        --------
        >>> import stickslip as ss
        >>> model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
        >>> by = ss.simulate(model, d=0.1, t_end=60).derivative("mu", "d")
        >>> by.x([10.0, 20.0]).shape, by.event_times.shape[1]
        ((2, 2, 2), 2)
        """
        return sensitivity(self, names)

    def table(self, t: ArrayLike | None = None, *, energy: bool = False) -> Table:
        """Return the events by time, block and kind, or the motion at given times.

        Parameters
        ----------
        t : array_like of float, optional
            Times as in `x`; the columns are ``t``, and ``x_1``, ``v_1``, ``mode_1``,
            ``friction_1`` and so on.
        energy : bool
            Add the columns of `Energy`.
        """
        energy = flag("energy", energy)
        if t is None:
            return super().table()
        times = self._checked(t).ravel()
        quantities = {
            "x": self.x(times),
            "v": self.v(times),
            "mode": self._mode(times),
            "friction": self.friction(times),
        }
        columns = {"t": times}
        for name, values in quantities.items():
            columns |= {f"{name}_{k}": column for k, column in enumerate(values.T, start=1)}
        return Table(columns | dict(self.energy(times).table()) if energy else columns)

    def _columns(self) -> dict[str, Any]:
        return {
            name: [getattr(event, name) for event in self.events]
            for name in ("time", "block", "kind")
        }

    @property
    def final_state(self) -> State:
        """Where the trajectory ends."""
        record = self._record
        return State(float(record.t[-1]), record.x[-1], record.v[-1])

    # --- inside -------------------------------------------------------------------------------

    def _checked(self, t: ArrayLike) -> Floats:
        times = real_numbers("t", t)
        end = float(self._record.t[-1])
        bad = ~((times >= 0.0) & (times <= end))
        if bad.any():
            raise ValueError(
                f"t = {float(times[bad].flat[0])!r} is outside the trajectory; "
                f"allowed: 0 <= t <= {end!r}"
            )
        return times

    def _step(self, times: Floats) -> NDArray[np.int64]:
        """Step that holds each time; at an event the one that begins there."""
        last = max(len(self._record.t) - 2, 0)
        return np.minimum(np.searchsorted(self._record.t, times, side="right") - 1, last)

    def _mode(self, t: ArrayLike) -> NDArray[np.int64]:
        return np.asarray(self._record.mode[self._step(self._checked(t))])

    def _state(self, t: ArrayLike) -> Instant:
        times = self._checked(t)
        step = self._step(times)
        states = self._inside(step.ravel(), (times - self._record.t[step]).ravel())
        x, v, w, e = (values.reshape(*times.shape, values.shape[1]) for values in states)
        return x, v, w, e

    def _inside(self, step: NDArray[np.int64], t: Floats) -> Instant:
        """States and needed forces within given steps."""
        record = self._record
        if len(record.t) == 1:
            return record.x[step], record.v[step], record.w[step], record.e[step]
        if record.inside is None:
            raise ValueError("this trajectory keeps its events only; simulate with record='motion'")
        return record.inside(step, t)

    def _friction(self, state: Instant, mode: NDArray[np.int64]) -> Floats:
        x, v, w, e = state
        limits = self.model.plant.limits(x, v)
        return np.where(mode == 0, e, sliding_friction(self.model.laws, limits, w, mode))

    @cached_property
    def _work_done(self) -> Floats:
        """Work of belt and forcing and dissipation up to the start of each step, (n, 3)."""
        steps = np.arange(len(self._record.t) - 1)
        t, plant = np.diff(self._record.t), self.model.plant
        done = self._work(steps, t)
        if plant.elastic and steps.size:  # feet jump as springs relax to kinetic friction
            ends = self._inside(steps, t)[0]
            done[:, 2] += plant.elastic_energy(ends) - plant.elastic_energy(self._record.x[1:])
        return np.vstack((np.zeros(3), np.cumsum(done, axis=0)))

    def _work(self, step: NDArray[np.int64], t: Floats) -> Floats:
        """Work of belt and forcing and dissipation over the first `t` of given steps, (n, 3)."""
        nodes, weights = QUADRATURE
        times = 0.5 * t[:, None] * (nodes + 1.0)
        index = np.broadcast_to(step[:, None], times.shape)
        state = x, v, w, _ = self._inside(index.ravel(), times.ravel())
        force = self._friction(state, self._record.mode[index.ravel()])
        plant, time = self.model.plant, (self._record.t[index] + times).ravel()
        if not plant.n_positions:
            raise ValueError("a structure in state-space form does not tell its energy")
        turning = 0.5 * (plant.stiffness - plant.stiffness.T)
        damped = np.sum(v * (v @ plant.damping.T + x @ turning.T), axis=-1)
        power = np.stack(
            (
                (plant.belts(time) * force).sum(-1),
                np.sum(plant.forces(time) * v, axis=-1),
                damped - (force * w).sum(-1),
            ),
            axis=-1,
        )
        inside = power.reshape(*times.shape, 3)
        return 0.5 * t[:, None] * np.einsum("ijk,j->ik", inside, weights)


@waits
@suggests
def simulate(
    model: Model,
    x: ArrayLike | None = None,
    v: ArrayLike | None = None,
    *,
    d: ArrayLike | None = None,
    t_end: float | None = None,
    until: Literal["stick"] | None = None,
    record: Literal["motion", "events"] = "motion",
    rtol: float = 1e-15,
    max_events: int = 100_000,
    engine: EngineName = "auto",
    progress: Callable[[float], None] | None = None,
) -> Trajectory:
    """Follow a motion in time.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    x, v : array_like of float, shape (N,), optional
        Displacements (units of f_s1 / k) and velocities (units of f_s1 / sqrt(k m)) at the
        start. A block at belt velocity rides if its force lies within its limits.
    d : float or array_like of float, shape (N - 1,), optional
        Instead of `x` and `v`: start as the global stick phase with ``X_{i+1} - X_i = d_i``
        ends; a number for two blocks.
    t_end : float, optional
        Time to follow, units of sqrt(m / k).
    until : {"stick"}, optional
        End at the next global stick phase, or at `t_end` if that comes first.
    record : {"motion", "events"}
        "events" keeps no polynomials of the adaptive engine: events only.
    rtol : float
        Local truncation error of the adaptive engine.
    max_events : int
        The trajectory ends there with the status EVENT_LIMIT. Without `t_end` it also ends
        where it is proved that no block sticks again (NEVER_SLIPPING).
    engine : {"auto", "exact", "adaptive"}
    progress : callable, optional
        Called with the share of `t_end` that is reached.

    Returns
    -------
    Trajectory

    Raises
    ------
    ValueError
        Neither or both of `d` and (`x`, `v`); no end given; a value that is not allowed.

    Examples
    --------
    >>> import stickslip as ss
    >>> trajectory = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=200)
    >>> trajectory.x([0.0, 100.0]).shape
    (2, 2)
    """
    one_of("record", record, ("motion", "events"))
    if until is not None:
        one_of("until", until, ("stick",), remedy="Or give t_end= alone.")
    if t_end is None and until is None:
        raise ValueError("give an end: t_end= a time, until='stick', or both")
    end = math.inf if t_end is None else end_time(t_end)
    max_events = whole_number("max_events", max_events, what="changes of mode of one trajectory")
    recorder = recorder_for(model, engine, rtol=tolerance(rtol), dense=record == "motion")
    origin = start(recorder, model, x, v, d)
    check_callback("progress", progress, "the share of the time that is reached")
    for _ in recorder.follow(end, max_events, until_stick=until == "stick"):
        if progress is not None and t_end:
            progress(recorder.t / end)
    phases = np.array(recorder.d, dtype=np.float64).reshape(len(recorder.d), *model.d_shape)
    return Trajectory(model, recorder.finish(), phases, recorder.status, origin)


def end_time(t_end: float) -> float:
    """Check the time up to which to follow a motion."""
    return finite_number("t_end", t_end, at_least=0.0, why="A motion is followed forward.")


def recorder_for(
    model: Model, engine: EngineName, *, rtol: float, dense: bool, last: int | None = None
) -> Recorder:
    """Choose what follows the motion of a model; its settings as in `Recorder`."""
    if isinstance(model, TwoBlock) and model.damping == 0.0:
        return TwoBlockRecorder(engine_for(model, engine), rtol=rtol, dense=dense, last=last)
    moved = block_engine(checked_model(model), engine)
    return BlocksRecorder(moved, model, rtol=rtol, dense=dense, last=last)


def start(
    recorder: Recorder,
    model: Model,
    x: ArrayLike | None,
    v: ArrayLike | None,
    d: ArrayLike | None,
) -> Origin:
    """Start a motion from a global stick phase or from a state, which is returned."""
    has_v = v is not None or not model.plant.n_positions
    if (d is None) == (x is None) or (x is None and v is not None) or (d is None and not has_v):
        raise ValueError("give either d=, a global stick phase, or both x and v, a state")
    if d is not None:
        if model.plant.n_waves or not model.plant.rubs_as_one:
            raise ValueError(
                "a model that is forced, or has more than blocks on one belt, starts from a state: "
                "give x= and v= instead of d="
            )
        if model.n_blocks == 2:
            d = finite_number("d", d, why="d is X_2 - X_1 of a global stick phase.")
        phase = np.atleast_1d(model.admit(d))
        if phase.ndim > 1:
            raise ValueError(f"d = {shown(d)}: one global stick phase is needed, not an array.")
        recorder.start_on_belt(phase)
        return Origin(None, None, phase, recorder.rtol)
    state = checked_state(model, x, v)
    recorder.start(*state)
    return Origin(*state, None, recorder.rtol)
