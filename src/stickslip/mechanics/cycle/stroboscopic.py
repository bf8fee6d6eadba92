"""The stroboscopic map of a forced model: its state, once per period of the forcing."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.checks import MOST_KEPT, MOST_STEPS, real_numbers, shown, whole_number
from stickslip.checks import grid as grid_values
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.cycle.shooting import Leg, Shooter
from stickslip.mechanics.flow.engine import tolerance
from stickslip.mechanics.model.arguments import checked_model, checked_parameter
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats


FORGOTTEN: Final = 64 * np.finfo(np.float64).eps
"""Of a Jacobian: growth this small is the rounding of zero."""


class StroboscopicMap:
    """State after one period of the forcing, as a function of the state.

    A state is ``(x_1, ..., x_N, v_1, ..., v_N)`` at the forcing's phase at time 0:
    displacements, then velocities. A block rides where its velocity is the belt's and its
    needed force within the static limits. `stroboscopic_map` makes it; immutable.

    Attributes
    ----------
    model : Blocks, Chain, Oscillator or Structure
    period : float
        Of the forcing, units of sqrt(m / k).
    """

    def __init__(self, model: Model, *, rtol: float = 1e-15, max_events: int = 10_000) -> None:
        if not checked_model(model).plant.is_forced:
            raise ValueError(
                f"model = {shown(model)} is unforced: it has no period to look at "
                "it by. Take stickslip.event_map(model) from "
                "one global stick phase to the next, or give the model forcing=Harmonic(...)."
            )
        self.model = model
        self.period = model.plant.period
        self.rtol = tolerance(rtol)
        self.max_events = whole_number("max_events", max_events, what="events in one period")

    @property
    def n_states(self) -> int:
        """Entries of a state: two per block; of a model in state-space form its states."""
        plant = self.model.plant
        return len(plant.mass) + plant.n_positions

    def replace(self, **changes: Any) -> StroboscopicMap:
        """Make the map of a changed model, with the same settings."""
        changed = self.model.replace(**changes)
        return type(self)(changed, rtol=self.rtol, max_events=self.max_events)

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
            the map is applied until it comes back. Errors as for `stickslip.find_cycle`.
        """
        x, v = self._parts(self._one(state))
        periods = whole_number("max_periods", max_periods)
        return find_cycle(self.model, x, v, max_events=periods, rtol=self.rtol)

    def lyapunov_exponents(self, state: ArrayLike, n: int, *, transient: int = 100) -> Floats:
        """Lyapunov exponents of the motion from a state, descending, shape (2 N,).

        Mean over ``n`` periods after ``transient``, per unit of time; -inf for directions that
        sticking forgets. Benettin et al., Meccanica 15, 9 (1980).
        """
        count = whole_number("n", n, at_most=MOST_STEPS, what="periods")
        settle = whole_number("transient", transient, 0, at_most=MOST_STEPS, what="periods")
        here = self._one(state)
        if settle:
            here = self.iterate(here, settle)[-1]
        shooter = Shooter(self.model, rtol=self.rtol)
        frame, sums = np.eye(self.n_states), np.zeros(self.n_states)
        for _ in range(count):
            leg = self._leg(shooter, here)
            here = self._value(leg)
            tangent = self._tangent(leg)
            frame, growth = np.linalg.qr(tangent @ frame)
            sizes = np.abs(np.diag(growth))
            sizes[sizes <= FORGOTTEN * np.abs(tangent).max()] = 0.0
            with np.errstate(divide="ignore"):
                sums += np.log(sizes)
        return np.sort(sums / (count * self.period))[::-1]

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

    def _parts(self, state: Floats) -> tuple[Floats, Floats]:
        """Displacements and velocities of a state."""
        n = len(self.model.plant.mass)
        return state[:n], state[n:]

    def _arrived(self, leg: Leg) -> bool:
        return leg.status == status_codes.OK and leg.duration >= self.period * (1 - 1e-12)


@suggests
def stroboscopic_map(
    model: Model, *, rtol: float = 1e-15, max_events: int = 10_000
) -> StroboscopicMap:
    """Map the state of a forced model to its state one period of the forcing later.

    Parameters
    ----------
    model : Blocks, Chain, Oscillator or Structure
        With forcing.
    rtol : float
        Local truncation error of the flow.
    max_events : int
        Changes of mode in one period after which a motion is given up.

    Returns
    -------
    StroboscopicMap

    Raises
    ------
    ValueError
        The model is not forced.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2,
    ...     forcing=ss.Harmonic(amplitude=2.0, frequency=0.7))
    >>> f = ss.stroboscopic_map(block)
    >>> f.iterate([0.0, 0.0], 3).shape
    (4, 2)
    """
    return StroboscopicMap(model, rtol=rtol, max_events=max_events)
