"""Balls of states that a cycle's return map takes into themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from stickslip import status as status_codes
from stickslip.checks import MOST_STEPS, instance, whole_number
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.section import Word, word_of
from stickslip.mechanics.cycle.shooting import Leg, Shooter, State
from stickslip.mechanics.flow.system import STICK
from stickslip.mechanics.model.arguments import checked_state
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.numerics.arrays import Floats


N_SAMPLES: Final = 48  # states of a ball in which the derivative of the return is computed
SAFETY: Final = 2.0  # times the largest second difference among them
HALVINGS: Final = 24
FIRST: Final = 0.1  # of the static limits: the first radius tried
SEED: Final = 1998


@dataclass(frozen=True, eq=False, repr=False)
class TrappingBall(Result):
    """A ball about a cycle that its return map P takes into itself.

    In the norm ``|z|_Q = sqrt(z' Q z)`` and for all z within `radius`,
    ``|P(z) - P(0)| <= (rate + curvature * radius) |z|``, z counted from the cycle. With the factor
    below 1 every motion that enters the ball goes on round the cycle for ever, with its modes,
    and tends to it: contraction mapping.

    *Computed*: the cycle to rounding, the derivative of P at it (through all events), hence Q
    and `rate`; that the motion enters. *Estimated*: `curvature`, twice the largest change of the
    derivative per distance among `n_samples` states of the ball, and that the modes of all
    these states' motions being the cycle's holds throughout the ball.

    Attributes
    ----------
    cycle : Cycle
    radius, rate, curvature : float
    n_samples : int
    norm : ndarray of float, shape (m, m)
        Q, in the free displacements and relative velocities at the section: the first landing.
    """

    cycle: Cycle
    radius: float
    rate: float
    curvature: float
    n_samples: int
    norm: Floats = field(repr=False)
    _column_names: ClassVar = ("radius", "rate", "curvature", "contraction", "n_samples")
    _plot: ClassVar = "cycles.plot_trapping_ball"
    _has_picture: ClassVar = False

    @cached_property
    def _map(self) -> _Return:
        return _Return(self.cycle)

    @property
    def contraction(self) -> float:
        """Factor by which each return brings states closer to the cycle, at least; below 1."""
        return self.rate + self.curvature * self.radius

    @property
    def section(self) -> tuple[Floats, NDArray[np.bool_]]:
        """State of the cycle at its first landing, (x, w), and which of its entries are free."""
        return self._map.start.z, self._map.free

    def entered(self, x: ArrayLike, v: ArrayLike, *, max_events: int = 10_000) -> int | None:
        """Events after which a motion is inside; None if it is not within `max_events`.

        Raises
        ------
        ValueError
            A count that is not allowed.
        """
        count = whole_number(
            "max_events", max_events, at_most=MOST_STEPS, what="events that are followed"
        )
        shooter = Shooter(self.cycle.model, tangents=False)
        state = shooter.start(*checked_state(self.cycle.model, x, v))
        for number in range(count):
            if (state.mode == self._map.start.mode).all():
                offset = (state.z - self._map.start.z)[self._map.free]
                if math.sqrt(float(offset @ self.norm @ offset)) <= self.radius:
                    return number
            leg = shooter.leg(state, 1)
            if leg.status != status_codes.OK:
                return None
            state = leg.state
        return None

    def _columns(self) -> dict[str, Any]:
        names = self._column_names
        return {"period": [self.cycle.period], **{name: [getattr(self, name)] for name in names}}


class _Return:
    """The return of a cycle to its first landing, as a map of the free directions there."""

    def __init__(self, cycle: Cycle) -> None:
        self.shooter = Shooter(cycle.model)
        state = self.shooter.start(cycle.x, cycle.v)
        if not any(event.kind == "stick" for event in cycle.events):
            raise ValueError(
                "this cycle has no landing after which a block sticks: there is no section of "
                "states on the belt that its return map could be taken on."
            )
        while True:
            before = state
            leg = self.shooter.leg(state, 1)
            state = leg.state
            if (state.mode[before.mode != STICK] == STICK).any():
                break
        self.start = state
        # Events at one time are settled together, or one after the other.
        n, times = len(cycle.events), {event.time for event in cycle.events}
        for self.n_events in range(len(times), n + 1):
            if len(self.shooter.leg(state, self.n_events).events) >= n:
                break
        self.free = state.free
        leg = self.leg(np.zeros(int(self.free.sum())))
        self.word: Word = word_of(leg)

    def leg(self, offset: Floats) -> Leg:
        z = self.start.z.copy()
        z[self.free] += offset
        return self.shooter.leg(State(z, self.start.mode), self.n_events)

    def derivative(self, offset: Floats) -> Floats | None:
        """Of the map, through all events; None where the motion has other modes."""
        leg = self.leg(offset)
        same = leg.status == status_codes.OK and word_of(leg) == self.word
        return leg.tangent[np.ix_(self.free, self.free)] if same else None


@waits
@suggests
def trapping_ball(cycle: Cycle) -> TrappingBall | None:
    """Look for the largest ball about a cycle that its return map takes into itself.

    Parameters
    ----------
    cycle : Cycle
        Of an unforced model, with a landing after which a block sticks.

    Returns
    -------
    TrappingBall or None
        None if the cycle does not attract, or no ball was found.

    Raises
    ------
    ValueError
        The cycle is of another kind.

    Notes
    -----
    The norm solves ``A' Q A - s^2 Q = -1`` for the derivative A at the cycle and s between its
    spectral radius and 1, so that ``|A|_Q < s`` also where A is far from normal.

    Examples
    --------
    >>> import stickslip as ss
    >>> cycle = ss.find_cycle(ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5)), x=[0.9], v=[0.1])
    >>> ss.trapping_ball(cycle).contraction
    0.0
    """
    instance("cycle", cycle, Cycle, "a cycle, such as ss.find_cycle(model, x, v)")
    if cycle.model.plant.is_forced:
        raise ValueError("the cycle of a forced model has no return map from event to event")
    section = _Return(cycle)
    size = int(section.free.sum())
    at_cycle = section.derivative(np.zeros(size))
    if at_cycle is None:
        return None
    spectral = float(np.abs(np.linalg.eigvals(at_cycle)).max())
    if spectral >= 1.0:
        return None
    s = 0.5 * (1.0 + spectral)
    norm = np.asarray(solve_discrete_lyapunov((at_cycle / s).T, np.eye(size)), dtype=float)
    factor = np.linalg.cholesky(norm).T
    rate = _size(factor, at_cycle)
    rng = np.random.default_rng(SEED)
    directions = rng.normal(size=(N_SAMPLES, size))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    depths = rng.uniform(0.0, 1.0, N_SAMPLES) ** (1.0 / size)
    depths[: N_SAMPLES // 2] = 1.0
    radius = FIRST * float(np.max(cycle.model.plant.static))
    for _ in range(HALVINGS):
        curvature = _curvature(section, at_cycle, factor, radius * depths[:, None] * directions)
        if curvature is not None and rate + SAFETY * curvature * radius < 1.0:
            return TrappingBall(cycle, radius, rate, SAFETY * curvature, N_SAMPLES, norm)
        radius *= 0.5
    return None


def _size(factor: Floats, matrix: Floats) -> float:
    """Norm of a matrix with respect to |z| = |factor z|."""
    return float(np.linalg.norm(factor @ matrix @ np.linalg.inv(factor), 2))


def _curvature(section: _Return, at_cycle: Floats, factor: Floats, scaled: Floats) -> float | None:
    """Largest change of the derivative per distance over some states; None: other modes."""
    largest = 0.0
    for point in scaled:
        here = section.derivative(np.linalg.solve(factor, point))
        if here is None:
            return None
        largest = max(largest, _size(factor, here - at_cycle) / float(np.linalg.norm(point)))
    return largest
