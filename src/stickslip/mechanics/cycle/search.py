"""The search for a limit cycle: followed to where a motion repeats, then solved by shooting."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.analysis.work import Work
from stickslip.checks import whole_number
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle.cycle import Cycle, cycle_along, cycle_of
from stickslip.mechanics.cycle.mode_changes import between_events
from stickslip.mechanics.cycle.section import (
    Section,
    Shooting,
    Shot,
    coordinates,
    fewest_freedoms,
)
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State, sizes_of
from stickslip.mechanics.cycle.sliding import linear_modes, modes_about, steady_states
from stickslip.mechanics.flow.engine import tolerance
from stickslip.mechanics.model.arguments import checked_model, checked_state
from stickslip.numerics.continuation import ArclengthCurve, LeavesRegion, StepTooLong
from stickslip.numerics.waiting import doing, waits
from stickslip.numerics.zeros import halved
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats, Ints


CLOSE: Final = 1e-3  # of the states' sizes: a return this close is worth an attempt
SETTLED: Final = 1e-9  # ... and this close is a cycle that attracts
REACH: Final = 30.0 * CLOSE  # of the states' sizes: how far Newton's method may move a state
MAX_NEWTON: Final = 30
CONVERGED: Final = 1e-13  # of the states' sizes
ROUNDING: Final = 1e-9  # of the largest multiplier: one that belongs to the section
WAIT: Final = 40  # periods of the slowest mode without a change of modes
MAX_WAITS: Final = 50
STILL: Final = 1e-9  # of the fastest rate: rates this small are those of free turning
HISTORY: Final = 256  # states of one set of modes that a state is compared with
SLIDES: Final = (
    ": all blocks slip and can be shown never to stick again. From another start there may be a "
    "cycle: with the blocks on the belt, v = V, or followed from another value of a parameter. "
    "Steady sliding is what stickslip.equilibria describes; without damping and with constant "
    "friction the motions about it are a neutral family, not a cycle."
)
SETTLES: Final = ": all blocks slip, and settle on steady sliding; see stickslip.equilibria."
ROUNDS: Final = 1e4  # times CONVERGED: returns this close are returns of one cycle


@waits
@suggests
def find_cycle(
    model: Model,
    x: ArrayLike,
    v: ArrayLike,
    *,
    max_events: int = 20_000,
    rtol: float = 1e-15,
    progress: Callable[[float], None] | None = None,
) -> Cycle:
    """Follow a motion until it nearly repeats, then converge onto the cycle.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    x, v : array_like of float, shape (N,)
        Displacements and velocities to start from. From a near guess an unstable cycle is found
        as well.
    max_events : int
        Changes of mode (of a forced model: periods of the forcing) after which the search ends.
        Cycles with more than 256 of them in the same modes are not looked for.
    rtol : float
        Local truncation error of the flow.
    progress : callable, optional
        Called with the share of `max_events` that has been followed, from 0 to 1.

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

    Examples
    --------
    >>> import stickslip as ss
    >>> cycle = ss.find_cycle(ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5)), x=[0.9], v=[0.1])
    >>> round(cycle.period, 9), cycle.stable
    (13.536383773, True)
    """
    max_events = whole_number("max_events", max_events, what="changes of mode that are followed")
    checked_model(model)
    position, velocity = checked_state(model, x, v)
    search = _Search(model, tolerance(rtol), Work(progress))
    if model.plant.is_forced:
        return search.forced(position, velocity, max_events)
    return search.free(position, velocity, max_events)


class _OnlySlipsError(Exception):
    """A motion has settled on a cycle without events."""

    def __init__(self, shot: Shot) -> None:
        super().__init__()
        self.shot = shot


class _Search:
    """What one search shares: a motion with tangents and one without."""

    def __init__(self, model: Model, rtol: float, work: Work) -> None:
        self.model, self.work = model, work
        self.plain = Shooter(model, rtol=rtol, tangents=False)
        self.shooter = Shooter(model, rtol=rtol)
        rates = np.abs(linear_modes(model).values)
        moving = rates[rates > STILL * rates.max()]
        self.slowest = 2.0 * np.pi / moving.min() if moving.size else np.inf
        self.spread = moving.max() / moving.min() if moving.size else 1.0
        self.sizes = sizes_of(model.plant)

    # --- autonomous models: from event to event -----------------------------------------------

    def free(self, x: Floats, v: Floats, max_events: int) -> Cycle:
        if not np.isfinite(self.slowest):
            raise ValueError(
                "no cycle was found from this state: nothing but friction acts on the masses, "
                "which come to rest or go on together."
            )
        shot = slip_cycle(self.model, self.plain.start(x, v), rtol=self.plain.rtol)
        if shot is not None:
            return cycle_of(shot)
        try:
            return self._from_event_to_event(x, v, max_events)
        except _OnlySlipsError as found:
            return cycle_of(found.shot)

    def _from_event_to_event(self, x: Floats, v: Floats, max_events: int) -> Cycle:
        first = self._next_event(self.plain.start(x, v))
        returns = self._returns(first, self._next_event, max_events)
        return self._first(returns, self._converged, f"{max_events} events")

    def _first(
        self,
        returns: Iterator[tuple[int, State, float]],
        converged: Callable[[State, int], Cycle | None],
        time: str,
    ) -> Cycle:
        """Return the first cycle that Newton's method comes to from close returns."""
        closest = math.inf
        for steps, back, closest in returns:  # each ten times closer: seven at most
            found = converged(back, steps)
            if found is not None:
                return found
            if closest <= SETTLED:
                break
        back_to = f": the motion came back to within {closest:.1g} of its size"
        seen = back_to if closest < CLOSE else ""
        raise NoCycleError(
            f" in {time}{seen}. Start closer to one, or raise max_events; one of more than "
            f"{HISTORY} of them is not looked for."
        )

    def _returns(
        self, state: State, step: Callable[[State], State], most: int
    ) -> Iterator[tuple[int, State, float]]:
        """Yield close returns among so many states: steps since then, the state, the distance."""
        seen: dict[bytes, tuple[Ints, Floats]] = {}  # by modes: when and where, the last ones
        closest = CLOSE
        for number in range(most):
            state = step(state) if number else state
            self.work.tell(number / most)
            here = self._scaled(state.z)
            modes = state.mode.tobytes()
            if modes not in seen:
                seen[modes] = np.full(HISTORY, -1), np.full((here.size, HISTORY), np.inf)
            numbers, states = seen[modes]
            distances = np.abs(states - here[:, None]).max(axis=0)
            near = np.where(distances < closest, numbers, -1)
            latest = int(near.argmax())
            if near[latest] >= 0:
                distance = float(distances[latest])
                yield number - int(near[latest]), state, distance
                closest = max(0.1 * distance, 0.5 * SETTLED)
            oldest = numbers.argmin()
            numbers[oldest], states[:, oldest] = number, here

    def _next_event(self, state: State) -> State:
        """Follow a motion to where its modes change; ValueError if they do not."""
        wait = WAIT * self.slowest
        for k in range(MAX_WAITS):
            doing(
                f"event awaited for {k * WAIT} of {MAX_WAITS * WAIT} periods of the slowest mode, "
                f"{self.spread:.2g} of the fastest each"
            )
            leg = self.plain.leg(state, 1, max_time=wait)
            _check(leg)
            if leg.events:
                return leg.state
            state = leg.state
            if self.plain.slides_for_ever():
                raise NoCycleError(SLIDES, "slides")
            if (state.mode == 0).any():
                if self.model.plant.rubs_as_one and not state.mode.any():
                    wait = math.inf  # all ride on, to an event
                continue
            if self._has_settled(state):
                raise NoCycleError(SETTLES, "slides")
            if (shot := slip_cycle(self.model, state, rtol=self.plain.rtol)) is not None:
                raise _OnlySlipsError(shot)
        raise NoCycleError(
            f": no block began to stick or slip in {MAX_WAITS * WAIT} periods of the slowest mode."
        )

    def _has_settled(self, state: State) -> bool:
        """Whether a motion has come to steady sliding that attracts."""
        plant = self.model.plant
        for steady in steady_states(self.model, near=state.w):
            there = plant.coordinates(steady.x, steady.v)
            near = self._distance(state.z, there) <= SETTLED
            if near and modes_about(plant, self.model.laws, steady).values.real.max() < 0.0:
                return True
        return False

    def _converged(self, state: State, n_events: int) -> Cycle | None:
        """Newton's method from a close return, onto the cycle or nowhere."""

        def legs(state: State, rounds: int) -> Leg:
            return self.shooter.leg(state, n_events // rounds)

        found = self._solved(state, legs, n_events)
        if found is None:
            return None
        state, leg, rounds = found
        return self._cycle(*self._fewest_freedoms(state, leg, n_events // rounds))

    def _solved(
        self, start: State, legs: Callable[[State, int], Leg], times: int
    ) -> tuple[State, Leg, int] | None:
        """Solve for a cycle; its state, one round of it, and how many rounds the return was."""
        # `legs` follows a return, or a share of it by the number of rounds.
        forced, last = self.model.plant.is_forced, math.inf
        enough = (10 if forced else 1) * CONVERGED
        state, before, step = start, None, np.zeros_like(start.z)
        for _ in range(MAX_NEWTON):
            leg = legs(state, 1)
            if leg.status != status_codes.OK:
                return None
            if not forced and (leg.state.mode != state.mode).any():
                return None
            off = self._off(leg, state)
            now = float(np.abs(off).max())
            if now <= enough or self._gains_no_more(last, now):
                if before is not None and self._comes_half_way(before, leg, step):
                    # To a cycle with multiplier 1; or ever slower to rest, without these events.
                    beyond = legs(state._replace(z=state.z + 2.0 * step), 1)
                    if len(beyond.events) < len(leg.events):
                        return None
                # Go round once where the return was found after several rounds.
                for rounds in range(times, 1, -1):
                    if times % rounds == 0 and self._is_back(state, once := legs(state, rounds)):
                        return state, once, rounds
                return state, leg, 1
            varies = state.free if forced else _varies(state)
            last, before, step = now, leg, self._step(leg, off, varies)
            state = state._replace(z=state.z + step)
            # A cycle with multiplier near 1 is 1 / (1 - multiplier) distances away, however close
            # the return: no less far than from the widest one that is worth an attempt.
            if np.abs((state.z - start.z) / self.sizes).max() > REACH:
                return None
        return None

    def _off(self, leg: Leg, state: State) -> Floats:
        """How far a leg ends from a state, in sizes."""
        return self._scaled(leg.state.z - state.z)

    def _scaled(self, z: Floats) -> Floats:
        """Leave out of a state, or of a change of it, what nothing feels; in sizes."""
        return np.asarray(self.model.plant.felt(z) / self.sizes)

    def _distance(self, z: Floats, other: Floats) -> float:
        """Between states, in sizes."""
        return float(np.abs(self._scaled(z - other)).max())

    def _step(self, leg: Leg, off: Floats, varies: NDArray[np.bool_]) -> Floats:
        """Newton's step from the start of a leg."""
        ways = self.model.plant.ways(varies)
        ways = ways * (np.abs(ways).T @ self.sizes)
        matrix = self._scaled((ways - leg.tangent @ ways).T).T
        return np.asarray(ways @ np.linalg.lstsq(matrix, off, rcond=1e-12)[0])

    def _comes_half_way(self, before: Leg, leg: Leg, step: Floats) -> bool:
        """Whether steps shorten the way by a share only, as to a double root."""
        # There 1 - multiplier halves with the way.
        bent = self._scaled((leg.tangent - before.tangent) @ step)
        straight = self._scaled(step - before.tangent @ step)
        return bool(np.abs(bent).max() > 0.25 * np.abs(straight).max())

    def _gains_no_more(self, last: float, now: float) -> bool:
        """Whether Newton's method has come to rounding, which a multiplier near 1 magnifies."""
        return now >= 0.5 * last and now <= 1e3 * CONVERGED

    def _is_back(self, state: State, leg: Leg) -> bool:
        same = leg.status == status_codes.OK and (leg.state.mode == state.mode).all()
        off = np.abs(self._off(leg, state)).max()
        return bool(same and off <= ROUNDS * CONVERGED)

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
        period = self.model.plant.period

        def step(state: State) -> State:
            leg = self.plain.leg(state, max_time=period)
            _check(leg)
            return leg.state._replace(t=0.0)

        returns = self._returns(self.plain.start(x, v), step, max_periods + 1)
        return self._first(
            returns, self._converged_in_time, f"{max_periods} periods of the forcing"
        )

    def _converged_in_time(self, state: State, times: int) -> Cycle | None:
        """Solve for a cycle of some periods of the forcing, or fewer."""
        plant, period = self.model.plant, times * self.model.plant.period

        def legs(state: State, rounds: int) -> Leg:
            return self.shooter.leg(state, max_time=period / rounds)

        # From far away of all events: of one at the start rounding would decide whether it counts.
        times_of = [t for t, _, _ in self.plain.leg(state, max_time=period).events]
        middle = between_events(times_of, period)
        if middle > 0.0:
            state = self.plain.leg(state, max_time=middle).state
        found = self._solved(state, legs, times)
        if found is None:
            return None
        state, leg, _ = found
        velocity = self.shooter.velocity(state)
        return cycle_of(
            Shot(self.model, Section.through(plant, state), state, leg, velocity, None, 0.0)
        )

    # --- as a result ---------------------------------------------------------------------------

    def _cycle(self, state: State, leg: Leg) -> Cycle:
        return cycle_along(self.model, state, leg, self._multipliers(leg))

    def _multipliers(self, leg: Leg) -> NDArray[np.complex128]:
        """Eigenvalues of the return, over the directions that are free at its start."""
        plant = self.model.plant
        ways = plant.ways(_varies(leg.start))
        values = np.linalg.eigvals(ways.T @ leg.tangent @ ways)
        values = values[np.argsort(-np.abs(values), kind="stable")].astype(np.complex128)
        # One direction of each phase is that of the motion. Where a contact turns from slip to
        # slip its velocity is no direction of the section, and no other one is lost.
        total = len(ways) - plant.turns.shape[1] - 1
        kept = values[: fewest_freedoms(plant, leg) - 1]
        kept = kept[np.abs(kept) > ROUNDING * max(1.0, float(np.abs(values).max()))]
        return np.concatenate([kept, np.zeros(total - len(kept))])


def _varies(state: State) -> NDArray[np.bool_]:
    """Coordinates of a state at an event that may vary: those of contacts just released may not."""
    return np.concatenate([np.ones(state.z.size - state.w.size, dtype=bool), state.w != 0.0])


def _check(leg: Leg) -> None:
    """Raise where a motion cannot become a cycle."""
    if leg.status == status_codes.NEVER_SLIPPING:
        raise NoCycleError(SLIDES, "slides")
    if leg.status != status_codes.OK:
        raise NoCycleError(f": {status_codes.MESSAGES[leg.status]}")


PATIENCE: Final = 2.5  # periods of the slowest mode in which two extremes of a kind must come
STEP: Final = 1 / 64  # of the fastest mode's period: where extremes are looked for
MOST_STEPS: Final = 8192  # in that search
HALVINGS: Final = 30  # of the step that holds an extreme
SLIP_CLOSE: Final = 0.05  # of the motion's size: a return this close is worth an attempt
SLIP_REACH: Final = 10.0  # distances of the return that Newton's method may move the state
NEUTRAL: Final = 1e-9  # multipliers this close to the unit circle: one of a family of motions
SMALLEST: Final = 1e-6  # of the states' sizes: smaller motions are steady sliding


def slip_cycle(model: Model, state: State, *, rtol: float) -> Shot | None:
    """Cycle without events near a motion in which all blocks slip, if there is one."""
    # Newton's method starts from two successive maxima of a coordinate.
    if model.plant.is_forced or (state.mode == 0).any() or not len(coordinates(model.plant)):
        return None
    swings = _Swings(model, state, rtol)
    first = swings.next(state)
    low = None if first is None else swings.next(first[0])
    second = None if low is None else swings.next(low[0])
    if first is None or low is None or second is None:
        return None
    sizes = sizes_of(model.plant)
    distance = float(np.abs(model.plant.felt(second[0].z - first[0].z) / sizes).max())
    size = swings.size(low[0], second[0])
    if not SMALLEST < size or distance > SLIP_CLOSE * size:
        return None
    name, value = next(iter(model.parameters.items()))
    section = Section.through(model.plant, second[0], swings.along)
    shooting = Shooting(model, name, section, word=(), rtol=rtol)
    guess = shooting.unknowns(second[0], low[1] + second[1], value)
    try:
        point = ArclengthCurve(shooting, shooting.scale(abs(value) or 1.0, guess)).point(guess)
    except (LeavesRegion, StepTooLong):
        return None
    shot: Shot = point.note
    moved = np.abs(section.ways.T @ (shot.state.z - second[0].z))
    moved /= np.abs(section.ways).T @ sizes
    if (np.abs(np.abs(shot.multipliers) - 1.0) < NEUTRAL).all():
        return None
    there = abs(point.parameter - value) < 1e-14 * (abs(value) or 1.0)
    near = moved.max() <= SLIP_REACH * distance + SMALLEST and there
    half = swings.next(shot.state)
    return shot if near and half and swings.size(shot.state, half[0]) > 0.1 * size else None


class _Swings:
    """A motion without events, from one extreme of a coordinate to the next."""

    def __init__(self, model: Model, state: State, rtol: float) -> None:
        self.shooter = Shooter(model, rtol=rtol, tangents=False)
        self.plant = model.plant
        fast = np.abs(linear_modes(model).values)
        fast = fast[fast > STILL * fast.max()]
        self.step = 2.0 * np.pi * STEP / float(fast.max())
        patience = PATIENCE * 2.0 * np.pi / float(fast.min()) / self.step
        self.n_steps = int(min(patience, MOST_STEPS))
        rows = coordinates(model.plant)
        self.along = rows[np.argmax(np.abs(rows @ self.plant.rows(state.z)[0]))]

    def _speed(self, state: State) -> float:
        return float(self.along @ self.plant.rows(state.z)[0])

    def next(self, state: State) -> tuple[State, float] | None:
        """State at the next extreme, and the time until then; None if an event comes before."""
        here, t, rising = state, 0.0, 0.0
        for _ in range(self.n_steps):
            leg = self.shooter.leg(here, 1, max_time=self.step)
            if leg.events or leg.status:
                return None
            rising = rising or np.sign(self._speed(leg.state))  # at an extreme it begins with 0
            if self._speed(leg.state) * rising < 0.0:
                part = self._turning(here, rising)
                return self.shooter.leg(here, 1, max_time=part).state, t + part
            here, t = leg.state, t + self.step
        return None

    def _turning(self, state: State, rising: float) -> float:
        """Time within a step at which the coordinate is extreme."""

        def rises_on(time: float) -> bool:
            return self._speed(self.shooter.leg(state, 1, max_time=time).state) * rising > 0.0

        return 0.5 * sum(halved(rises_on, 0.0, self.step, HALVINGS))

    def size(self, a: State, b: State) -> float:
        """Amplitude of a motion from its states at two extremes, in sizes."""
        n = len(self.along)
        unit = float(np.abs(self.along) @ sizes_of(self.plant)[:n])
        return 0.5 * abs(float(self.along @ (a.z - b.z)[:n])) / unit
