"""The stroboscopic map of a model: its state, once per period of the forcing or of a clock."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip import status as status_codes
from stickslip.analysis.maps.protocol import mix_labels
from stickslip.checks import MOST_KEPT, MOST_STEPS, finite_number, shown, whole_number
from stickslip.checks import grid as grid_values
from stickslip.mechanics.cycle.chart import names_of
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.return_map import SpaceMap, checked_window
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.cycle.shooting import Leg, Shooter
from stickslip.mechanics.eventmap.itinerary import itinerary_text
from stickslip.mechanics.eventmap.records import new_outputs
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model.arguments import checked_model, checked_parameter
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike

    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.mechanics.eventmap.records import Controls, Outputs
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.numerics.arrays import Floats, Ints


AT_ONCE: Final = 1e-9
"""Of the period: who lands so soon counts as riding, which changes values by its square only."""


class PeriodBackend:
    """Carries motions over a period, one after the other."""

    def __init__(self, model: Model, period: float, controls: Controls) -> None:
        self.model, self.period, self.controls = model, period, controls
        self.name: str = self._shooter(tangents=False).engine.name

    def value(self, d: float) -> float:
        """None: a point is no number."""
        raise NotImplementedError

    def carry(self, d: Floats, *, slope: bool = False, watch: bool = False) -> Outputs:
        """Values at each state, Jacobians, and a label of the modes; margins are not known."""
        shooter = self._shooter(tangents=slope)
        outputs = new_outputs(d.shape, d.shape[1] if slope else 0)
        outputs.margin.fill(np.nan)
        out, into = self.model.plant.jacobians
        for k, state in enumerate(d):
            leg = self.leg(shooter, state)
            outputs.duration[k], outputs.n_events[k] = leg.duration, len(leg.events)
            outputs.label[k] = self._label(leg)
            outputs.status[k] = leg.status or status_codes.EVENT_LIMIT
            if self._arrived(leg):
                outputs.status[k] = status_codes.OK
                outputs.value[k] = np.concatenate(self.model.plant.states(leg.state.z))
                if slope:
                    outputs.derivative[k] = out @ leg.tangent @ into
        return outputs

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each state."""
        shooter = self._shooter(parameter=name)
        return np.array([self._rate(shooter, state) for state in d]).reshape(d.shape)

    def iterate(self, orbits: Floats) -> None:
        """Fill rows (n, steps + 1, entries) from their first entries on."""
        shooter = self._shooter(tangents=False)
        orbits[:, 1:] = np.nan
        for orbit in orbits:
            for k in range(len(orbit) - 1):
                leg = self.leg(shooter, orbit[k])
                if not self._arrived(leg):
                    break
                orbit[k + 1] = np.concatenate(self.model.plant.states(leg.state.z))

    def itinerary(self, d: Any) -> str:
        """Modes of each phase, as text."""
        mode, events = self._modes(self.leg(self._shooter(tangents=False), np.array(d)))
        rows = [mode]
        for contact, new in events:
            rows.append(rows[-1].copy())
            rows[-1][contact] = new
        return itinerary_text(np.array(rows))

    def leg(self, shooter: Shooter, state: Floats) -> Leg:
        """Follow the motion from a state over a period."""
        start = shooter.start(*np.split(state, [len(self.model.plant.mass)]))
        return shooter.leg(start, self.controls.max_events, max_time=self.period)

    def _shooter(self, **wanted: Any) -> Shooter:
        return Shooter(self.model, rtol=self.controls.rtol, **wanted)

    def _arrived(self, leg: Leg) -> bool:
        return leg.status == status_codes.OK and leg.duration >= self.period * (1 - 1e-12)

    def _rate(self, shooter: Shooter, state: Floats) -> Floats:
        """Differentiate the value at a state by the shooter's parameter."""
        plant, leg = self.model.plant, self.leg(shooter, state)
        if not self._arrived(leg):
            return np.full(len(state), np.nan)
        out, into = plant.jacobians
        moved = leg.parameter + shooter.velocity(leg.state) * shooter.period_change
        if shooter.change is None:
            return np.asarray(out @ moved)
        # Coordinates depend on the parameter: where the motion starts, and what is read at its end.
        ends = (leg.start.z, leg.state.z)
        first, last = (plant.states_change(z, 0.0, shooter.change) for z in ends)
        return np.asarray(last + out @ (moved - leg.tangent @ into @ first))

    def _modes(self, leg: Leg) -> tuple[Ints, list[tuple[int, int]]]:
        """Modes at the start, and all changes of them: contact and new mode."""
        mode, later = leg.start.mode.copy(), []
        for t, contact, new in leg.events:
            if new == 0 and t <= AT_ONCE * self.period:
                mode[contact] = 0
            else:
                later.append((contact, new))
        return mode, later

    def _label(self, leg: Leg) -> np.uint64:
        mode, later = self._modes(leg)
        codes = [*(mode + 1), *(3 * (contact + 1) + new for contact, new in later)]
        label = np.zeros(1, dtype=np.uint64)
        for code in np.array(codes, dtype=np.uint64):
            label = mix_labels(label, code)
        return label[0]


class StroboscopicMap(SpaceMap):
    """State after one period of the forcing, or of a clock, as a function of the state.

    A state is ``(x_1, ..., x_N, v_1, ..., v_N)`` at the forcing's phase at time 0:
    displacements, then velocities; columns of the Jacobian of the velocities of riding blocks are
    zero: a rider that is pushed is back on the belt at once. A block rides where its velocity is
    the belt's and its needed force within the static limits. `stroboscopic_map` makes it;
    immutable; equal settings compare equal.

    Attributes
    ----------
    model : Blocks, Chain, Oscillator or Structure
    period : float
        Of the forcing, or as given; units of sqrt(m / k).
    """

    _settings: ClassVar = ("rtol", "max_events", "domain")
    _backend: PeriodBackend

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
        self._clock = period
        self.period = model.plant.period if forced else finite_number("period", period, above=0.0)
        self.coordinates = names_of(model.plant)
        self._window = checked_window(domain, self.coordinates)
        super().__init__(model, rtol=rtol, max_events=max_events, max_time=math.inf, threads=1)

    def _backend_of(self, controls: Controls) -> PeriodBackend:
        return PeriodBackend(self.model, self.period, controls)

    @property
    def _cell(self) -> tuple[int, ...]:
        return (self.dimension,)

    @property
    def settings(self) -> dict[str, Any]:
        """Keyword arguments that make this map from its model."""
        return super().settings | {"period": self._clock}

    @property
    def dimension(self) -> int:
        """Entries of a state: two per block; of a model in state-space form its states."""
        return len(self.coordinates)

    def slip_from(self, d: ArrayLike, max_events: int) -> Trajectory:
        """Follow the motion from a state over a period."""
        x, v = np.split(self._admit(d), [len(self.model.plant.mass)])
        settings: dict[str, Any] = {"max_events": max_events, "rtol": self.rtol}
        return simulate(self.model, x, v, t_end=self.period, **settings)

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
        x, v = np.split(self._one(state), [len(self.model.plant.mass)])
        periods = whole_number("max_periods", max_periods)
        return find_cycle(self.model, x, v, max_events=periods, rtol=self.rtol)

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
        visited = np.full((len(values), kept, self.dimension), np.nan)
        for row, value in zip(visited, values, strict=True):
            orbit = self.replace(**{parameter: float(value)}).iterate(here, settle + kept - 1)
            row[:] = orbit[settle:]
            here = here if np.isnan(row[-1]).any() else row[-1]
        return visited

    def _one(self, state: ArrayLike) -> Floats:
        """Check a state where an array of them has no meaning."""
        one = self._admit(state, "state")
        if one.ndim != 1:
            raise ValueError(
                f"state has the shape {one.shape}: one state of {self.dimension} numbers is needed."
            )
        return one


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
        Range of each entry of a state, beyond which an orbit has left: searches for attractors and
        orbits start there.

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
