"""Return maps: from one release or landing of a contact to the next."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal, Self

import numpy as np

from stickslip import status as status_codes
from stickslip.analysis.maps.derived import LineMap
from stickslip.analysis.maps.protocol import (
    Mechanism,
    box_points,
    checked_points,
    clip_to_domain,
    meet_on_circle,
    reduced,
)
from stickslip.checks import (
    checked_interval,
    finite_number,
    instance,
    one_of,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.cycle.chart import PHASE, Chart, chart
from stickslip.mechanics.cycle.shooting import sizes_of
from stickslip.mechanics.eventmap.backend import ScalarBackend
from stickslip.mechanics.eventmap.event_map import ModelMap
from stickslip.mechanics.eventmap.mechanism import mechanism_between
from stickslip.mechanics.eventmap.of_model import register_model_map
from stickslip.mechanics.eventmap.records import Controls
from stickslip.mechanics.flow.engine import block_engine
from stickslip.mechanics.flow.system import BACKWARD, FORWARD
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model.arguments import checked_model, checked_state
from stickslip.mechanics.model.belt_model import MOST_POINTS
from stickslip.numerics.roots import EPSILON
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.eventmap.backend import Backend
    from stickslip.mechanics.eventmap.records import Section
    from stickslip.mechanics.flow.blocks.system import BlockDirections
    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

Event = Literal["release", "landing"]

EVENTS: Final = ("release", "landing")
DIRECTIONS: Final = {"backward": BACKWARD, "forward": FORWARD}
TURN: Final = 2.0 * math.pi
ON_SECTION: Final = 1e-9  # of the terms that cancel on the section
SAMPLES: Final = 65  # of an interval that is tried as the domain
DOUBLINGS: Final = range(-4, 7)  # of the scale of the states, tried as its length


class ReturnBackend(ScalarBackend):
    """Carries motions from a section to itself."""

    def __init__(self, f: SectionMap, controls: Controls) -> None:
        super().__init__(f.model, block_engine(f.model), controls, f.threads)
        self._chart = f.chart

    @property
    def _dimension(self) -> int:
        return len(self._chart.names)

    @cached_property
    def _section(self) -> Section:
        return self._chart.section

    def _section_along(self, name: str) -> Section:
        return self._chart.along(self.engine.change(self.model, name)[0])

    @cached_property
    def _start_directions(self) -> BlockDirections:
        return self.engine.directions(np.zeros((self._dimension, self.model.n_blocks - 1)))


class SectionMap(ModelMap):
    """From one event of a contact to the next: what return maps of any dimension share."""

    _settings: ClassVar = (
        *("contact", "event", "direction", "coordinates", "domain"),
        *("rtol", "max_events", "max_time", "threads"),
    )
    whole_duration: ClassVar = True  # of an application: from an event to the next like it

    def __init__(
        self,
        model: Model,
        *,
        contact: int = 0,
        event: Event = "release",
        direction: Literal["backward", "forward"] | None = None,
        coordinates: Sequence[str] | None = None,
        domain: Any = None,
        rtol: float = 1e-15,
        max_events: int = 1000,
        max_time: float = math.inf,
        threads: int | None = None,
    ) -> None:
        plant = checked_model(model).plant
        if plant.is_coupled:
            raise ValueError(
                f"model = {shown(model)} has contacts that share inertia: it has no return map as "
                "yet. Follow it in time, or take stickslip.stroboscopic_map where it is forced."
            )
        if plant.elastic:
            raise ValueError(
                f"model = {shown(model)} has elastic contacts: feet that slide have no state of "
                "their own, so that numbers of a section would not tell each other apart. Follow "
                "it in time, or take stickslip.stroboscopic_map where it is forced."
            )
        what = f"contacts of the model are 0 to {plant.n_contacts - 1}"
        self.contact = whole_number("contact", contact, 0, at_most=plant.n_contacts - 1, what=what)
        one_of("event", event, EVENTS)
        self.event: Event = event
        usual = "forward" if plant.V[self.contact] < 0.0 else "backward"
        self.direction = usual if direction is None else one_of("direction", direction, DIRECTIONS)
        mode = DIRECTIONS[self.direction]
        if coordinates is not None:
            for name in instance("coordinates", coordinates, Sequence, "names"):
                instance("coordinates", name, str, "names of coordinates")
        self.chart: Chart = chart(plant, self.contact, mode, event == "release", coordinates)
        if not self.chart.names:
            raise ValueError(
                f"the {event} of contact {self.contact + 1} is one state: there is nothing to "
                "map. Take its limit cycles (on the command line: stickslip cycles), or "
                "stickslip.return_map with the other event."
            )
        _ = self.chart.section  # which refuses forces without a common period
        self._window = checked_window(domain, self.chart.names)
        super().__init__(
            model, rtol=rtol, max_events=max_events, max_time=max_time, threads=threads
        )

    def _backend_of(self, controls: Controls) -> Backend:
        return ReturnBackend(self, controls)

    # --- what it is -----------------------------------------------------------------------

    @property
    def settings(self) -> dict[str, Any]:
        """Keyword arguments that make this map from its model."""
        return super().settings | {"domain": self._window}

    @property
    def dimension(self) -> int:
        """Numbers in a point."""
        return len(self.chart.names)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """What the numbers of a point are: ``phase``, ``x_1``, ``v_2``, ..."""
        return self.chart.names

    # --- states ---------------------------------------------------------------------------

    def state(self, d: ArrayLike) -> tuple[Floats, Floats, float]:
        """Return displacements x, velocities v and the time at a point.

        The time is that within the forcing's period; 0 without forcing. ValueError as for calling
        the map.
        """
        row = np.ravel(self._admit(d))
        if row.size != self.dimension:
            raise ValueError(f"d = {shown(d)}: one point is needed, {self.dimension} numbers.")
        section, plant = self.chart.section, self.model.plant
        t = float(row[0]) * section.period / TURN
        z = section.into @ np.concatenate([plant.waves(t), row, [1.0]])
        return (*plant.states(z, t), t)

    def point(self, x: ArrayLike, v: ArrayLike, t: float = 0.0) -> float | Floats:
        """Return the point at which a state is on the section, at a time of the forcing.

        ValueError if the state is not on it.
        """
        plant, section = self.model.plant, self.chart.section
        t = finite_number("t", t)
        position, velocity = checked_state(self.model, x, v)
        z = np.concatenate([plant.waves(t), plant.coordinates(position, velocity, t), [1.0]])
        off = self.chart.conditions(plant.reduced) @ z
        terms = np.abs(z) + np.pad(sizes_of(plant), (plant.n_waves, 1))
        size = np.abs(self.chart.conditions(plant.reduced)) @ terms
        if (np.abs(off) > ON_SECTION * size).any():
            raise ValueError(
                f"x = {shown(x)}, v = {shown(v)} is no {self.event} of contact {self.contact + 1}: "
                f"it is off by {off.tolist()} in its relative velocity and force."
            )
        row = self.chart.out(plant.reduced) @ z
        if section.period:
            row[0] = TURN * (t / section.period % 1.0)
        return float(row[0]) if self.dimension == 1 else np.asarray(row)

    @property
    def periods(self) -> Floats:
        """Period of each number of a point, shape (n,): 2 pi of a phase, infinite of others."""
        return np.where(np.array(self.coordinates) == PHASE, TURN, np.inf)

    def turned(self, d: ArrayLike) -> Floats:
        """Return how many periods of the forcing pass until the next event, shape (..., 1)."""
        duration = self.evaluate(d).duration
        return np.asarray(duration / self.chart.section.period)[..., None]

    def begun(self, d: ArrayLike) -> tuple[Model, Floats, Floats]:
        """Return a model with the phases of its forces at a point, and displacements, velocities.

        What `simulate` takes to follow the motion from there on.
        """
        x, v, t = self.state(d)
        moved = {
            f"{name}.phase": wave.phase + wave.frequency * t
            for name, (wave, _) in self.model._waves.items()
        }
        return self.model.replace(**moved), x, v

    def slip_from(self, d: ArrayLike, max_events: int) -> Trajectory:
        """Follow the motion from a point to the next one."""
        model, x, v = self.begun(d)
        end = float(np.ravel(self.evaluate(d).duration)[0])
        return simulate(model, x, v, t_end=end, max_events=max_events, rtol=self.rtol)


class SpaceMap(ModelMap):
    """A map of R^n whose points have named numbers, within ranges or without bounds."""

    _window: tuple[tuple[float, float], ...] | None
    coordinates: tuple[str, ...]

    @property
    def domain(self) -> Any:
        """Ranges of the numbers, as given, beyond which an orbit has left; None: no bounds."""
        return self._window

    def spread(self, n: int) -> Floats:
        """Return n points spread evenly over the domain, always the same, shape (n, dimension).

        ValueError without a domain.
        """
        if self._window is None:
            raise ValueError(
                f"the map has no bounded domain to draw points {self.coordinates} from: give "
                "domain=[(low, high), ...], a pair for each."
            )
        count = whole_number("n", n, at_most=MOST_POINTS)
        return box_points(np.array(self._window), count)

    def _admit(self, d: ArrayLike, name: str = "d") -> Floats:
        points = np.require(real_numbers(name, d), np.float64, ["C", "W"])
        if points.shape[-1:] != (self.dimension,) or not np.isfinite(points).all():
            raise ValueError(
                f"{name} = {shown(d)} is no point of the map: its last axis must hold "
                f"{self.dimension} finite numbers, {', '.join(self.coordinates)}."
            )
        return points

    def contains(self, d: ArrayLike) -> NDArray[np.bool_]:
        """Whether points are finite and within the ranges of `domain`, shape (...).

        A phase has no ends where its range is a period.
        """
        points = real_numbers("d", d)
        if points.shape[-1:] != (self.dimension,):
            raise ValueError(
                f"d = {shown(d)}: the last axis of points must hold {self.dimension} numbers."
            )
        points = reduced(self, points)
        inside = np.isfinite(points)
        if self._window is not None:
            low, high = np.array(self._window).T
            inside &= (points >= low) & (points <= high)
        return np.asarray(inside.all(axis=-1))

    def iterate(self, d: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; NaN once an orbit has left the domain."""
        orbits = super().iterate(d, n)
        left = ~self.contains(orbits[..., :-1, :])
        orbits[..., 1:, :][np.logical_or.accumulate(left, axis=-1)] = np.nan
        return orbits


class ReturnMap(SpaceMap, SectionMap):
    """From one event of a contact to the next, a map of R^n; `stickslip.return_map` makes it.

    Calling it carries points, shape (..., n), to the next ones: entries of the state (x, v) and,
    with forcing, its phase, as `coordinates` says. Immutable; equal settings compare equal.
    """


class LineReturnMap(SectionMap, LineMap):
    """A return map of one dimension, a map of the line; `stickslip.return_map` makes it.

    All that takes an event map of two blocks takes it.
    """

    _doubling: int | None = None

    @property
    def domain(self) -> tuple[float, float]:
        """Ends of the interval of definition.

        As given; [0, 2 pi] of a phase; else from where on the event happens, the first of some
        lengths that the map carries into itself. ValueError where there is none.
        """
        if self._window is not None:
            return self._window[0]
        if self.coordinates == (PHASE,):
            return 0.0, TURN
        if self._low > self._high:
            self._low, self._high = self._trapped()
        return self._low, self._high

    def iterate(self, d: ArrayLike, n: int) -> Floats:
        """Apply the map ``n`` times; NaN once an orbit has left the domain."""
        orbits = super().iterate(d, n)
        left = ~clip_to_domain(self.domain, orbits[..., :-1])[1]
        orbits[..., 1:][np.logical_or.accumulate(left, axis=-1)] = np.nan
        return orbits

    def replace(self, **changes: Any) -> Self:
        """Make the map of a changed model, with the same settings, as long a domain included."""
        made = super().replace(**changes)
        if self._window is None and self.coordinates != (PHASE,):
            _ = self.domain
            made._doubling = self._doubling
        return made

    def _trapped(self) -> tuple[float, float]:
        """Interval of points where the event happens that the map carries into itself."""
        plant, (own,) = self.model.plant, self.chart.kept
        reduced = plant.reduced
        states = plant.jacobians[0]
        row = reduced.matrix[reduced.n_free + self.contact, reduced.n_waves :]
        growth = abs(float((row @ np.linalg.inv(states))[own]))
        scale = float(plant.static[self.contact]) / growth if growth > 0.0 else sizes_of(plant)[own]
        sizes = scale * 2.0 ** np.arange(-20.0, 21.0)
        low, high = self._edges(np.concatenate([-sizes[::-1], [0.0], sizes]))
        for doubling in DOUBLINGS if self._doubling is None else (self._doubling,):
            reach = scale * 2.0**doubling
            ends = max(low, -reach), min(high, reach)
            if math.isfinite(low):
                ends = low, min(high, low + reach)
            elif math.isfinite(high):
                ends = high - reach, high
            image = self._backend.carry(np.linspace(*ends, SAMPLES)).value
            stays = np.isnan(image) | ((image >= ends[0]) & (image <= ends[1]))
            if self._doubling is not None or (stays.all() and np.isfinite(image).any()):
                self._doubling = doubling
                return ends
        raise ValueError(
            f"no interval was found that the map of {self.coordinates[0]} carries into itself: "
            "give domain=(low, high)."
        )

    def _edges(self, grid: Floats) -> tuple[float, float]:
        """Return the ends of the points where the event happens; infinite beyond the grid."""
        happens = np.flatnonzero(self._happens(grid))
        if not happens.size:
            raise ValueError(
                f"contact {self.contact + 1} is nowhere released or lands {self.direction} on this "
                "section: give direction= or domain=."
            )
        first, last = int(happens[0]), int(happens[-1])
        low, high = -math.inf, math.inf
        if first > 0:
            low = self._edge(grid[first], grid[first - 1], grid[-1])
        if last < len(grid) - 1:
            high = self._edge(grid[last], grid[last + 1], grid[-1])
        return low, high

    def _edge(self, inside: float, outside: float, size: float) -> float:
        """Last point where the event happens, towards one where it does not, to rounding."""
        while abs(inside - outside) > EPSILON * max(abs(inside), EPSILON * size):
            middle = 0.5 * (inside + outside)
            if self._happens(np.array([middle]))[0]:
                inside = middle
            else:
                outside = middle
        return float(inside)

    @cached_property
    def _beginning(self) -> ReturnBackend:
        """Carries motions for a step, to tell whether they begin at all."""
        return ReturnBackend(self, Controls(self.rtol, 1, 0.0))

    def _happens(self, points: Floats) -> NDArray[np.bool_]:
        """Whether the event happens at points."""
        return np.asarray(self._beginning.carry(points).status != status_codes.NO_EVENT)

    def _admit(self, d: ArrayLike) -> Floats:
        return np.require(checked_points(self.domain, d, "d"), np.float64, ["C", "W"])

    def explain_break(self, left: float, right: float) -> Mechanism:
        """Return why the map breaks between two starting points, adjacent floats."""
        own = self.contact + 1
        told = self.evaluate([left, right])
        if status_codes.NO_EVENT in told.status:
            force = "its needed force turns back at the limit"
            why = force if self.event == "release" else "it reaches velocity 0 the other way"
            return Mechanism(f"beyond, contact {own} makes no {self.event}: {why}", own)
        if meet_on_circle(self, *told.value.tolist()):
            return Mechanism("the next event comes at the phase 0 of the forcing", None)
        return mechanism_between(self, left, right)


def checked_window(domain: Any, names: tuple[str, ...]) -> tuple[tuple[float, float], ...] | None:
    """Check the ranges of the numbers of a point, one interval or one for each."""
    if domain is None:
        return None
    given = np.asarray(real_numbers("domain", domain))
    pairs = given[None] if given.shape == (2,) else given
    if pairs.shape != (len(names), 2):
        raise ValueError(
            f"domain = {shown(domain)} must hold a pair (low, high) for each of {', '.join(names)}."
        )
    return tuple(
        checked_interval(f"domain of {name}", pair)
        for name, pair in zip(names, pairs.tolist(), strict=True)
    )


@suggests
def return_map(
    model: Model,
    *,
    contact: int = 0,
    event: Event = "release",
    direction: Literal["backward", "forward"] | None = None,
    coordinates: Sequence[str] | None = None,
    domain: Any = None,
    rtol: float = 1e-15,
    max_events: int = 1000,
    max_time: float = math.inf,
    threads: int | None = None,
) -> ReturnMap | LineReturnMap:
    """Map the state at one release (or landing) of a contact to that at the next.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        Of n states (two per mass), a release leaves n - 2 numbers open and a landing n - 1; one
        less for each free rotor, one more, the phase, with forcing. One number makes a map of the
        line.
    contact : int
        Number of the contact, from 0.
    event : {"release", "landing"}
        A release ends a stick, a landing a slip.
    direction : {"backward", "forward"}, optional
        Of the slip that a release begins or a landing ends. Backward by default, forward on a
        belt that runs backward.
    coordinates : sequence of str, optional
        Which entries of the state a point consists of, such as ``("phase", "x_2", "v_2")``;
        chosen by the numbers of the model otherwise: `ReturnMap.coordinates` tells.
    domain : (low, high) or sequence of such pairs, optional
        Range of each number, beyond which an orbit has left. Of a map of the line [0, 2 pi] for a
        phase, else an interval that the map carries into itself; of more dimensions without bounds.
    rtol : float
        Local truncation error of the flow.
    max_events : int
        A motion is given up (status EVENT_LIMIT) after so many changes of mode.
    max_time : float
        A motion is given up (TIME_LIMIT) after so long.
    threads : int, optional
        Processor cores used for large arrays; all by default.

    Returns
    -------
    ReturnMap or LineReturnMap

    Raises
    ------
    ValueError
        A setting is not allowed; the section is one state; forces without a common period;
        contacts that share inertia.

    Notes
    -----
    Other contacts stick where their relative velocity is 0 and their needed force within its
    limits. Derivatives are exact, in parameters too. Derivation: docs/theory/return-map.md.

    Examples
    --------
    A block on springs that is driven and rubs on a slow belt: a map of the phase at which it slips.

    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.4),
    ...     forcing=ss.Harmonic(amplitude=0.1, frequency=0.5))
    >>> f = ss.return_map(block)
    >>> f.coordinates, f.dimension
    (('phase',), 1)
    """
    settings: dict[str, Any] = {
        "contact": contact,
        "event": event,
        "direction": direction,
        "coordinates": coordinates,
        "domain": domain,
        "rtol": rtol,
        "max_events": max_events,
        "max_time": max_time,
        "threads": threads,
    }
    made = ReturnMap(model, **settings)
    return made if made.dimension > 1 else LineReturnMap(model, **settings)


register_model_map("return map", ReturnMap, return_map)
register_model_map("return map of the line", LineReturnMap, return_map)
