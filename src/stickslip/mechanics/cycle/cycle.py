"""Limit cycles of any model: followed to where a motion repeats, then solved by shooting."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State
from stickslip.mechanics.flow.settings import positive_integer, tolerance
from stickslip.mechanics.flow.trajectory import EVENT_KINDS, Event, Trajectory, simulate

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.cycle.sliding import Model

    Floats = NDArray[np.float64]

__all__ = ["Cycle", "find_cycle"]

CLOSE: Final = 1e-3  # of the state's size: a return this close is worth an attempt
SETTLED: Final = 1e-9  # ... and this close is a cycle that attracts
REACH: Final = 30.0  # distances of the return that Newton's method may move the state
MAX_NEWTON: Final = 30
CONVERGED: Final = 1e-13  # of the state's size
ROUNDING: Final = 1e-9  # of the largest multiplier: one that belongs to the section
NEUTRAL: Final = 1e-7  # multipliers this close to the unit circle neither attract nor repel
MAX_ATTEMPTS: Final = 8


@dataclass(frozen=True, eq=False)
class Cycle:
    """A periodic motion in continuous time.

    Attributes
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
    period : float
        Units of sqrt(m / k).
    multipliers : ndarray of complex
        Floquet multipliers by descending size: 2 N - 1 of them, the trivial one left out; 2 N of
        a forced model. Directions that a stick phase forgets have exact zeros.
    stable : bool
        All multipliers are inside the unit circle.
    x, v : ndarray of float, shape (N,)
        A state of the cycle, just after an event (of a forced model: at the forcing's phase at
        time 0).
    events : tuple of Event
        Changes of mode in one period, times from that state on.
    d : ndarray
        Differences ``X_{i+1} - X_i`` of its global stick phases, shape (k, N - 1): an orbit of
        the event map; empty if it has none.
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
    _trajectory: list[Trajectory] = field(default_factory=list, repr=False)

    @property
    def trajectory(self) -> Trajectory:
        """The motion over one period."""
        if not self._trajectory:
            self._trajectory.append(simulate(self.model, self.x, self.v, t_end=self.period))
        return self._trajectory[0]

    @property
    def d(self) -> Floats:
        """Differences of the displacements in its global stick phases."""
        return self.trajectory.d

    def plot(self, ax: Any = None) -> Any:
        """Draw displacements over one period; returns the Axes."""
        return self.trajectory.plot(ax)

    def __repr__(self) -> str:
        """Period, multipliers and events."""
        word = "stable" if self.stable else "not stable"
        sizes = ", ".join(_text(value) for value in self.multipliers)
        lines = [f"Cycle: period {self.period:.12g}, {word}, {len(self.events)} events"]
        lines.append(f"  multipliers {sizes or 'none'}")
        lines += [f"  t = {e.time:<14.10g} block {e.block}  {e.kind}" for e in self.events[:8]]
        if len(self.events) > 8:
            lines.append(f"  ... {len(self.events) - 8} more")
        return "\n".join(lines)


def _text(value: complex) -> str:
    return f"{value.real:.8g}" if value.imag == 0.0 else f"{value.real:.6g}{value.imag:+.6g}i"


def find_cycle(
    model: Model,
    x: ArrayLike,
    v: ArrayLike,
    *,
    max_events: int = 20_000,
    rtol: float = 1e-15,
) -> Cycle:
    """Follow a motion until it nearly repeats, then converge onto the cycle.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain or Oscillator
    x, v : array_like of float, shape (N,)
        Displacements and velocities to start from. From a near guess an unstable cycle is found
        as well.
    max_events : int
        Changes of mode (of a forced model: periods of the forcing) after which the search ends.
    rtol : float
        Local truncation error of the flow.

    Returns
    -------
    Cycle

    Raises
    ------
    ValueError
        A state of the wrong shape; no cycle was found, with the reason: the motion slides for
        ever, or never came back.

    Notes
    -----
    Newton's method on the map from an event of one kind to its recurrence, with the exact
    derivative of the flow through all events (saltation). The multipliers are the eigenvalues
    of that derivative.
    """
    max_events = positive_integer("max_events", max_events, "changes of mode that are followed")
    position, velocity = _vector("x", x, model), _vector("v", v, model)
    search = _Search(model, tolerance(rtol))
    if model.structure.is_forced:
        return search.forced(position, velocity, max_events)
    return search.free(position, velocity, max_events)


def _vector(name: str, values: ArrayLike, model: Model) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    n = model.n_blocks
    if array.shape != (n,) or not np.isfinite(array).all():
        raise ValueError(f"{name} = {values!r} is not allowed: {n} finite numbers, one per block")
    return array


class _Search:
    """What one search shares: a motion with tangents and one without."""

    def __init__(self, model: Model, rtol: float) -> None:
        self.model = model
        self.plain = Shooter(model, rtol=rtol, tangents=False)
        self.shooter = Shooter(model, rtol=rtol)
        self.size = float(np.max(model.structure.static)) + model.V

    # --- autonomous models: from event to event -----------------------------------------------

    def free(self, x: Floats, v: Floats, max_events: int) -> Cycle:
        attempts = 0
        for n_events, back, distance in self._returns(x, v, max_events):
            if attempts >= MAX_ATTEMPTS and distance > SETTLED * self.size:
                continue
            attempts += 1
            found = self._converged(back, n_events, distance)
            if found is not None:
                return found
            if distance <= SETTLED * self.size:
                break
        raise ValueError(
            f"no cycle was found from this state: the motion came back {attempts} times, but not "
            f"onto a cycle, in {max_events} events. Start closer to one, or raise max_events."
        )

    def _returns(self, x: Floats, v: Floats, max_events: int) -> Iterator[tuple[int, State, float]]:
        """Yield close returns: events since then, the state, the distance."""
        state = self.plain.start(x, v)
        seen: dict[bytes, list[tuple[int, State]]] = {}
        closest = CLOSE * self.size
        for number in range(max_events):
            leg = self.plain.leg(state, 1)
            _check(leg)
            state = leg.state
            word = state.mode.tobytes()
            for earlier, other in reversed(seen.get(word, [])[-256:]):
                distance = float(np.abs(state.vector - other.vector).max())
                if distance < closest:
                    yield number - earlier, state, distance
                    closest = max(0.1 * distance, 0.5 * SETTLED * self.size)
                    break
            seen.setdefault(word, []).append((number, state))

    def _converged(self, state: State, n_events: int, distance: float) -> Cycle | None:
        """Newton's method from a close return, onto the cycle or nowhere."""
        start, allowed = state, REACH * distance + CONVERGED * self.size
        leg = self.shooter.leg(state, n_events)
        for _ in range(MAX_NEWTON):
            if leg.status != status_codes.OK or (leg.state.mode != state.mode).any():
                return None
            off = leg.state.vector - state.vector
            if np.abs(off).max() <= CONVERGED * self.size:
                return self._cycle(*self._fewest_freedoms(state, leg, n_events))
            step = np.linalg.lstsq(np.eye(2 * self.plain.n) - leg.tangent, off, rcond=1e-12)[0]
            n = self.plain.n
            w = np.where(state.w == 0.0, 0.0, state.w + step[n:])
            moved = state._replace(x=state.x + step[:n], w=w)
            if np.abs(moved.vector - start.vector).max() > allowed:
                return None
            last, state = np.abs(off).max(), moved
            leg = self.shooter.leg(state, n_events)
            now = np.abs(leg.state.vector - state.vector).max()
            if now >= 0.5 * last and now <= 1e3 * CONVERGED * self.size:
                return self._cycle(*self._fewest_freedoms(state, leg, n_events))
        return None

    def _fewest_freedoms(self, state: State, leg: Leg, n_events: int) -> tuple[State, Leg]:
        """Start the cycle where most blocks stick: what they forget has exact zeros."""
        best, here = state, state
        for _ in range(n_events - 1):
            here = self.plain.leg(here, 1).state
            if np.count_nonzero(here.w) < np.count_nonzero(best.w):
                best = here
        return (state, leg) if best is state else (best, self.shooter.leg(best, n_events))

    # --- forced models: from period to period --------------------------------------------------

    def forced(self, x: Floats, v: Floats, max_periods: int) -> Cycle:
        forcing = getattr(self.model, "forcing", None)
        assert forcing is not None
        state = self.plain.start(x, v)
        states = [state]
        closest = CLOSE * self.size
        for _ in range(max_periods):
            leg = self.plain.leg(state, max_periods, max_time=forcing.period)
            _check(leg)
            state = leg.state._replace(phase=self.model.structure.phase)
            for back, other in enumerate(reversed(states[-64:]), start=1):
                distance = float(np.abs(state.vector - other.vector).max())
                if (state.mode == other.mode).all() and distance < closest:
                    found = self._converged_in_time(state, back * forcing.period, distance)
                    if found is not None:
                        return found
                    closest = 0.1 * distance
                    break
            states.append(state)
        raise ValueError(
            f"no cycle was found from this state in {max_periods} periods of the forcing. Start "
            "closer to one, or raise max_events."
        )

    def _converged_in_time(self, state: State, period: float, distance: float) -> Cycle | None:
        start, allowed, n = state, REACH * distance + CONVERGED * self.size, self.plain.n
        many = 10**9
        for _ in range(MAX_NEWTON):
            leg = self.shooter.leg(state, many, max_time=period)
            if leg.status != status_codes.OK:
                return None
            off = leg.state.vector - state.vector
            if np.abs(off).max() <= 10 * CONVERGED * self.size:
                return self._cycle(state, leg)
            step = np.linalg.lstsq(np.eye(2 * n) - leg.tangent, off, rcond=1e-12)[0]
            w = np.where(state.mode == 0, 0.0, state.w + step[n:])
            state = state._replace(x=state.x + step[:n], w=w)
            if np.abs(state.vector - start.vector).max() > allowed:
                return None
        return None

    # --- as a result ---------------------------------------------------------------------------

    def _cycle(self, state: State, leg: Leg) -> Cycle:
        multipliers = self._multipliers(state, leg.tangent)
        events = tuple(
            Event(time, block + 1, EVENT_KINDS[mode]) for time, block, mode in leg.events
        )
        return Cycle(
            model=self.model,
            period=leg.duration,
            multipliers=multipliers,
            stable=bool((np.abs(multipliers) < 1.0 - NEUTRAL).all()),
            x=state.x,
            v=state.w + self.model.V,
            events=events,
            residual=float(np.abs(leg.state.vector - state.vector).max()),
        )

    def _multipliers(self, state: State, tangent: Floats) -> NDArray[np.complex128]:
        """Eigenvalues of the return, over the directions that are free at its start."""
        n = self.plain.n
        forced = self.model.structure.is_forced
        free = np.concatenate([np.ones(n, dtype=bool), state.w != 0.0])
        values = np.linalg.eigvals(tangent[np.ix_(free, free)]).astype(np.complex128)
        values = values[np.argsort(-np.abs(values), kind="stable")]
        total = 2 * n if forced else 2 * n - 1
        # The return ends on the section: the direction across it is lost.
        kept = values if forced else values[: free.sum() - 1]
        kept = kept[np.abs(kept) > ROUNDING * max(1.0, float(np.abs(values).max()))]
        return np.concatenate([kept, np.zeros(total - len(kept))])


def _check(leg: Leg) -> None:
    """Raise where a motion cannot become a cycle."""
    if leg.status == status_codes.NEVER_SLIPPING:
        raise ValueError(
            "no cycle was found from this state: all blocks slip and can be shown never to stick "
            "again. Steady sliding is what stickslip.equilibria describes; without damping and "
            "with constant friction the motions about it are a neutral family, not a cycle."
        )
    if leg.status != status_codes.OK:
        raise ValueError(f"no cycle was found from this state: {status_codes.MESSAGES[leg.status]}")
