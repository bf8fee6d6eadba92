"""The stroboscopic map of a model: its state, once per period of the forcing or of a clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.analysis.maps.protocol import PointValues, box_points, mix_labels
from stickslip.checks import (
    MOST_KEPT,
    MOST_STEPS,
    checked_interval,
    finite_number,
    one_each,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.checks import grid as grid_values
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.cycle.shooting import Leg, Shooter
from stickslip.mechanics.eventmap.mechanism import difference_of
from stickslip.mechanics.flow.engine import tolerance
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model.arguments import checked_model, checked_parameter
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.maps.protocol import Mechanism
    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats


AT_ONCE: Final = 1e-9
"""Of the period: who lands so soon counts as riding, which changes values by its square only."""


class StroboscopicMap:
    """State after one period of the forcing, or of a clock, as a function of the state.

    A state is ``(x_1, ..., x_N, v_1, ..., v_N)`` at the forcing's phase at time 0:
    displacements, then velocities. A block rides where its velocity is the belt's and its
    needed force within the static limits. `stroboscopic_map` makes it; immutable.

    Attributes
    ----------
    model : Blocks, Chain, Oscillator or Structure
    period : float
        Of the forcing, or as given; units of sqrt(m / k).
    """

    def __init__(
        self,
        model: Model,
        *,
        period: float | None = None,
        rtol: float = 1e-15,
        max_events: int = 10_000,
        domain: Sequence[tuple[float, float]] | None = None,
    ) -> None:
        forced = checked_model(model).plant.is_forced
        if forced == (period is not None):
            told = "forced: its forcing tells the period" if forced else "unforced: give period="
            raise ValueError(
                f"period = {shown(period)}: model = {shown(model)} is {told}. From one event to "
                "the next stickslip.event_map(model) or stickslip.return_map(model) leads."
            )
        self.model, self._clock = model, period
        self.period = model.plant.period if forced else finite_number("period", period, above=0.0)
        self.rtol = tolerance(rtol)
        self.max_events = whole_number("max_events", max_events, what="events in one period")
        self.domain = domain
        if domain is not None:
            pairs = enumerate(one_each("domain", domain, self.n_states))
            self.domain = [checked_interval(f"domain[{k}]", pair) for k, pair in pairs]

    @property
    def n_states(self) -> int:
        """Entries of a state: two per block; of a model in state-space form its states."""
        plant = self.model.plant
        return len(plant.mass) + plant.n_positions

    @property
    def dimension(self) -> int:
        """Entries of a state."""
        return self.n_states

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name."""
        return dict(self.model.parameters)

    def replace(self, **changes: Any) -> StroboscopicMap:
        """Make the map of a changed model, with the same settings."""
        changed = self.model.replace(**changes)
        settings: dict[str, Any] = {"rtol": self.rtol, "max_events": self.max_events}
        return type(self)(changed, period=self._clock, domain=self.domain, **settings)

    def __repr__(self) -> str:
        """One line."""
        return f"StroboscopicMap({self.model!r})"

    # --- values ---------------------------------------------------------------------------

    def __call__(self, state: ArrayLike) -> Floats:
        """State one period later.

        Parameters
        ----------
        state : array_like of float, shape (..., 2 N)

        Returns
        -------
        ndarray of float, shaped like ``state``
            NaN where a motion could not be followed through the period.

        Raises
        ------
        ValueError
            The last axis does not have 2 N finite numbers.
        """
        states = self._checked(state)
        shooter = Shooter(self.model, rtol=self.rtol, tangents=False)
        rows = [self._value(self._leg(shooter, row)) for row in states.reshape(-1, self.n_states)]
        return np.array(rows).reshape(states.shape)

    def contains(self, state: ArrayLike) -> NDArray[np.bool_]:
        """Whether states are finite, shape (...)."""
        return np.asarray(np.isfinite(state).all(axis=-1))

    def spread(self, count: int) -> Floats:
        """Return states spread evenly over the domain, always the same; ValueError without one."""
        if self.domain is None:
            raise ValueError("the map has no bounded domain: give domain=[(low, high), ...].")
        return box_points(np.array(self.domain), count)

    def evaluate(self, state: ArrayLike) -> PointValues:
        """Value, Jacobian, status and label, which tells modes and events, at states (..., 2 N)."""
        states = self._checked(state)
        shooter = Shooter(self.model, rtol=self.rtol)
        legs = [self._leg(shooter, row) for row in states.reshape(-1, self.n_states)]
        shape = states.shape[:-1]
        arrived = np.array([self._arrived(leg) for leg in legs], dtype=bool).reshape(shape)
        return PointValues(
            np.array([self._value(leg) for leg in legs]).reshape(states.shape),
            np.array([self._tangent(leg) for leg in legs]).reshape(*states.shape, self.n_states),
            np.array([self._label(leg) for leg in legs], dtype=np.uint64).reshape(shape),
            np.where(arrived, status_codes.OK, status_codes.EVENT_LIMIT),
            np.full(shape, np.nan),
        )

    def derivative(self, state: ArrayLike) -> Floats:
        """Jacobian of the map, exact, shape (..., 2 N, 2 N); errors as for calling.

        Columns of the velocities of riding blocks are zero: a rider that is pushed is back on
        the belt at once. So are the directions that a later stick forgets.
        """
        states = self._checked(state)
        shooter = Shooter(self.model, rtol=self.rtol)
        rows = [self._tangent(self._leg(shooter, row)) for row in states.reshape(-1, self.n_states)]
        return np.array(rows).reshape(*states.shape, self.n_states)

    def iterate(self, state: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times, keeping every state, shape (..., n + 1, 2 N)."""
        states = self._checked(state)
        count = whole_number("n", n, at_most=MOST_STEPS, what="periods")
        shooter = Shooter(self.model, rtol=self.rtol, tangents=False)
        rows = states.reshape(-1, self.n_states)
        orbits = np.full((len(rows), count + 1, self.n_states), np.nan)
        orbits[:, 0] = rows
        for orbit in orbits:
            for k in range(count):
                orbit[k + 1] = self._value(self._leg(shooter, orbit[k]))
                if np.isnan(orbit[k + 1]).any():
                    break
        return orbits.reshape(*states.shape[:-1], count + 1, self.n_states)

    def periodic_point(self, state: ArrayLike, *, max_periods: int = 2000) -> Cycle:
        """Follow a motion until it nearly repeats, then converge onto a periodic point.

        Returns
        -------
        Cycle
            ``cycle.x, cycle.v`` is a point of the map, ``cycle.period / self.period`` how often
            the map is applied until it comes back. Errors as for `stickslip.find_cycle`; of an
            unforced model, whose cycles have periods of their own.
        """
        if self._clock is not None:
            raise ValueError(
                "an unforced model's cycles have periods of their own: take stickslip.find_cycle."
            )
        x, v = self._parts(self._one(state))
        periods = whole_number("max_periods", max_periods)
        return find_cycle(self.model, x, v, max_events=periods, rtol=self.rtol)

    def parameter_derivative(self, state: ArrayLike, name: str) -> Floats:
        """Return df/d(name), a parameter of the model, at fixed states, exact, shape (..., 2 N).

        The forcing's period moves with its frequency: the next state is that one period later.
        ValueError for an unknown name, or one of several frequencies.
        """
        checked_parameter("name", self.model, name)
        states = self._checked(state)
        shooter = Shooter(self.model, rtol=self.rtol, parameter=name)
        rows = [self._rate(shooter, row) for row in states.reshape(-1, self.n_states)]
        return np.array(rows).reshape(states.shape)

    def diagram(
        self,
        parameter: str,
        grid: ArrayLike,
        state: ArrayLike,
        *,
        transient: int = 200,
        n: int = 64,
    ) -> Floats:
        """States that a motion visits at values of a parameter, shape (values, n, 2 N).

        ``grid`` is ``(lo, hi, n)``, or a list or array of values.

        Each value starts where the one before it ended, ``transient`` periods before the first
        of the ``n`` states kept.
        """
        checked_parameter("parameter", self.model, parameter)
        here = self._one(state)
        kept = whole_number("n", n, at_most=MOST_KEPT, what="states kept")
        settle = whole_number("transient", transient, at_most=MOST_STEPS, what="periods")
        values = grid_values("grid", grid)
        visited = np.full((len(values), kept, self.n_states), np.nan)
        for row, value in zip(visited, values, strict=True):
            orbit = self.replace(**{parameter: float(value)}).iterate(here, settle + kept - 1)
            row[:] = orbit[settle:]
            here = here if np.isnan(row[-1]).any() else row[-1]
        return visited

    def explain_border(
        self, state: ArrayLike, other: StroboscopicMap, beyond: ArrayLike
    ) -> Mechanism:
        """Return why motions from a state and one close by differ, of a map with other numbers."""
        pairs = ((self, state), (other, beyond))
        first, second = (
            simulate(f.model, *f._parts(f._one(s)), t_end=f.period, rtol=f.rtol) for f, s in pairs
        )
        return difference_of(first, second)

    # --- inside ---------------------------------------------------------------------------

    def _checked(self, state: ArrayLike) -> Floats:
        states = real_numbers("state", state)
        if states.ndim == 0 or states.shape[-1] != self.n_states or not np.isfinite(states).all():
            raise ValueError(
                f"state = {shown(state)} is not allowed: its last axis must hold {self.n_states} "
                f"finite numbers, {len(self.model.plant.mass)} displacements and then velocities."
            )
        return states

    def _one(self, state: ArrayLike) -> Floats:
        """Check a state where an array of them has no meaning."""
        one = self._checked(state)
        if one.ndim != 1:
            raise ValueError(
                f"state has the shape {one.shape}: one state of {self.n_states} numbers is needed."
            )
        return one

    def _leg(self, shooter: Shooter, state: Floats) -> Leg:
        return shooter.leg(
            shooter.start(*self._parts(state)), self.max_events, max_time=self.period
        )

    def _value(self, leg: Leg) -> Floats:
        if not self._arrived(leg):
            return np.full(self.n_states, np.nan)
        return np.concatenate(self.model.plant.states(leg.state.z))

    def _tangent(self, leg: Leg) -> Floats:
        if not self._arrived(leg):
            return np.full_like(leg.tangent, np.nan)
        out, into = self.model.plant.jacobians
        return np.asarray(out @ leg.tangent @ into)

    def _rate(self, shooter: Shooter, state: Floats) -> Floats:
        """Differentiate the value at a state by the shooter's parameter."""
        plant, start = self.model.plant, shooter.start(*self._parts(state))
        leg = shooter.leg(start, self.max_events, max_time=self.period)
        if not self._arrived(leg):
            return np.full(self.n_states, np.nan)
        out, into = plant.jacobians
        moved = leg.parameter + shooter.velocity(leg.state) * shooter.period_change
        if shooter.change is None:
            return np.asarray(out @ moved)
        # Coordinates depend on the parameter: where the motion starts, and what is read at its end.
        first, last = (plant.states_change(z, 0.0, shooter.change) for z in (start.z, leg.state.z))
        return np.asarray(last + out @ (moved - leg.tangent @ into @ first))

    def _label(self, leg: Leg) -> int:
        """One number for the modes at the start and all changes of them."""
        mode, codes = leg.start.mode.copy(), []
        for t, contact, new in leg.events:
            if new == 0 and t <= AT_ONCE * self.period:
                mode[contact] = 0
            else:
                codes.append(3 * (contact + 1) + new)
        label = np.zeros(1, dtype=np.uint64)
        for code in np.array([*(mode + 1), *codes], dtype=np.uint64):
            label = mix_labels(label, code)
        return int(label[0])

    def _parts(self, state: Floats) -> tuple[Floats, Floats]:
        """Displacements and velocities of a state."""
        n = len(self.model.plant.mass)
        return state[:n], state[n:]

    def _arrived(self, leg: Leg) -> bool:
        return leg.status == status_codes.OK and leg.duration >= self.period * (1 - 1e-12)


@suggests
def stroboscopic_map(
    model: Model,
    *,
    period: float | None = None,
    rtol: float = 1e-15,
    max_events: int = 10_000,
    domain: Sequence[tuple[float, float]] | None = None,
) -> StroboscopicMap:
    """Map the state of a model to its state one period of the forcing, or of a clock, later.

    `lyapunov_spectrum` of the map is that of the motion in time: ``per_time``, the exponent 0 of
    the flow included where the model is unforced.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    period : float, optional
        Of an unforced model, and only of one: time from a state to the next.
    rtol : float
        Local truncation error of the flow.
    max_events : int
        Changes of mode in one period after which a motion is given up.
    domain : sequence of pairs of float, optional
        Range of each entry of a state, where searches for attractors and orbits start.

    Returns
    -------
    StroboscopicMap

    Raises
    ------
    ValueError
        The model is unforced and no period is given, or forced and one is.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2,
    ...     forcing=ss.Harmonic(amplitude=2.0, frequency=0.7))
    >>> f = ss.stroboscopic_map(block)
    >>> f.iterate([0.0, 0.0], 3).shape
    (4, 2)
    """
    settings: dict[str, Any] = {"rtol": rtol, "max_events": max_events, "domain": domain}
    return StroboscopicMap(model, period=period, **settings)
