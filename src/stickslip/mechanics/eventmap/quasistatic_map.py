"""The event map as the belt's speed goes to zero: earthquakes between long waits."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NoReturn, Self

import numpy as np

from stickslip.checks import finite_number, shown, whole_number
from stickslip.mechanics.eventmap.backend import ScalarBackend
from stickslip.mechanics.eventmap.event_map import EventMap
from stickslip.mechanics.eventmap.of_model import register_model_map
from stickslip.mechanics.flow.engine import engine_for
from stickslip.mechanics.flow.recorder import TwoBlockRecorder
from stickslip.mechanics.flow.system import BETA, START
from stickslip.mechanics.flow.trajectory import Trajectory
from stickslip.mechanics.model.arguments import two_blocks
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.results.result import Result
from stickslip.results.table import numbered
from stickslip.status import OK
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.mechanics.eventmap.records import Controls, Outputs, Section
    from stickslip.mechanics.flow.engine import EngineName
    from stickslip.mechanics.flow.recorder import Recorder
    from stickslip.numerics.arrays import Floats


class QuasistaticBackend(ScalarBackend):
    """Carries motions with the belt at rest: the kernels of the moving belt, V = 0 in them."""

    has_traps: ClassVar = False  # the model's belt moves

    # A block leaves its limit L with the acceleration -L (1 - F(0)), which must not be zero.

    def __init__(
        self, model: TwoBlock, engine: EngineName, controls: Controls, threads: int
    ) -> None:
        super().__init__(model, engine_for(model, engine), controls, threads)
        system = self.engine.system._replace(V=0.0)
        self.engine = dataclasses.replace(self.engine, system=system)

    def last_forces(self, d: Floats) -> tuple[Floats, Floats]:
        """Needed forces (n, 2) as the slip from each d begins, and as it has ended (or NaN)."""
        first, last = np.full((d.size, 2), np.nan), np.full((d.size, 2), np.nan)
        scratch, engine = self.scratch(self.no_directions), self.engine
        alpha, beta, _ = engine.system
        for k, start in enumerate(d.tolist()):
            lead = min(1.0 + (1.0 + 2.0 * alpha) * start, beta)
            first[k] = lead - (1.0 + 2.0 * alpha) * start, lead
            outputs = self.room(1)
            self.task(np.array([[start]]), outputs, self.controls.max_events)(0, 1)
            if outputs.status[0] == OK:
                last[k] = scratch.motion.e
        return first, last

    def recorder(self, d: float) -> Recorder:
        """Motion on the resting belt as the slip from `d` begins, to be followed step by step."""
        recorder = TwoBlockRecorder(self.engine, rtol=self.controls.rtol, dense=True)
        recorder.start_on_belt(np.array([d]))
        return recorder

    def _carried(
        self, d: Floats, directions: Floats, watch: bool = False, section: Section | None = None
    ) -> Outputs:
        outputs = super()._carried(d, directions, watch)
        alpha, beta, _ = self.engine.system
        lead = 1.0 + (1.0 + 2.0 * alpha) * d - beta  # of block 2 as block 1 leaves; 0: together
        tied = np.isclose(lead, 0.0, atol=1e-14, rtol=0.0)
        for column, direction in enumerate(directions):
            outputs.derivative[tied, column] = self._slopes_of_tie(
                d[tied], outputs.value[tied], direction
            )
        return outputs

    def _slopes_of_tie(self, d: Floats, value: Floats, direction: Floats) -> Floats:
        """One-sided slopes where both leave together: infinite, from the side of smaller d."""
        # There block 1 frees block 2 after a time that grows as the square root of the distance.
        alpha = self.engine.system.alpha
        if alpha == 0.0 or direction[BETA] != 0.0 or direction[START] == 0.0:
            return np.full(d.size, np.nan)
        step = 1e-6 / (1.0 + 2.0 * alpha)
        beside = super()._carried(d - step, self.no_directions).value
        return np.copysign(np.inf, value - beside)

    def parameter_slope(self, d: Floats, name: str) -> Floats:
        """df/d(name) at each d; the speed of the belt is no parameter of the limit."""
        if name == "V":
            raise ValueError("'V' is no parameter of the quasi-static map: it is the limit V -> 0")
        return super().parameter_slope(d, name)


@dataclass(frozen=True, eq=False, repr=False)
class QuasistaticSlips(Result):
    """Sizes of the slips that follow global stick phases; NaN where a slip never ends.

    Attributes
    ----------
    d : ndarray of float, any shape
        Of the phases before.
    value : ndarray of float, shaped like ``d``
        d of the phases after.
    displacement : ndarray of float, shape (..., 2)
        How far each block slips back, units of f_s1 / k; 0 for one that rides.
    moment : ndarray of float, shaped like ``d``
        Their sum: the size of the event.
    wait : ndarray of float, shaped like ``d``
        Travel of the belt from the slip to the next one: V times the time between.
    """

    d: Floats
    value: Floats
    displacement: Floats
    moment: Floats
    wait: Floats
    _drawn: ClassVar = ("d", "moment")

    def _columns(self) -> dict[str, Any]:
        return {
            "d": self.d.ravel(),
            "value": self.value.ravel(),
            **numbered("displacement", self.displacement.reshape(-1, 2)),
            "moment": self.moment.ravel(),
            "wait": self.wait.ravel(),
        }


class QuasistaticMap(EventMap):
    """The event map of two blocks as V -> 0; `quasistatic_map` makes it.

    Everything of an event map but the parameter ``V``; a slip takes no time of the belt's, and
    ``duration`` is its own.
    """

    _settings = ("rtol", "max_events", "max_time", "engine", "threads")

    def _backend_of(self, controls: Controls) -> QuasistaticBackend:
        return QuasistaticBackend(self.model, self.engine, controls, self.threads)

    @property
    def n_impulses(self) -> int:
        """None: `after_impulse` is not derived for this limit."""
        return 0

    def after_impulse(self, d: ArrayLike, block: int, by: float) -> NoReturn:
        """Refuse: impulses are followed with a moving belt."""
        raise ValueError("after_impulse needs a moving belt: take the map of a model with small V.")

    def slip_from(self, d: float, max_events: int) -> Trajectory:
        """Follow the slip after a global stick phase; velocities are those of a moving belt."""
        assert isinstance(self._backend, QuasistaticBackend)
        recorder = self._backend.recorder(finite_number("d", d))
        max_events = whole_number("max_events", max_events)
        status = recorder.run(math.inf, max_events, until_stick=True)
        return Trajectory(self.model, recorder.finish(), np.array(recorder.d), status)

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name, without ``V``."""
        return {name: value for name, value in super().parameters.items() if name != "V"}

    def replace(self, **changes: Any) -> Self:
        """Make the map of a changed model, with the same settings.

        Raises
        ------
        ValueError
            As `quasistatic_map`; for ``V``, which the limit does not have.
        """
        if "V" in changes:
            raise ValueError(
                f"V = {shown(changes['V'])}: the quasi-static map is the limit V -> 0."
            )
        return type(self)(_checked(self.model.replace(**changes)), **self.settings)

    def slips(self, d: ArrayLike) -> QuasistaticSlips:
        """Sizes of the slips that follow global stick phases.

        Parameters
        ----------
        d : array_like of float, any shape
            ``X_2 - X_1`` of the phases, units of f_s1 / k, inside ``domain``.

        Returns
        -------
        QuasistaticSlips

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the locus of eq. (6a).

        Examples
        --------
        >>> import stickslip as ss
        >>> f = ss.quasistatic_map(ss.examples.coulomb())
        >>> f.slips(0.5).displacement.round(12).tolist()
        [0.0, 0.921818181818]
        """
        points = self.model.admit(d)
        backend = self._backend
        assert isinstance(backend, QuasistaticBackend)
        first, last = backend.last_forces(points.ravel())
        total, spread = (first - last).sum(-1), np.diff(first - last)[:, 0]
        change = spread / (1.0 + 2.0 * self.model.alpha)
        back = np.stack((0.5 * (total - change), 0.5 * (total + change)), axis=-1)
        value = np.diff(last)[:, 0] / (1.0 + 2.0 * self.model.alpha)
        wait = np.minimum(1.0 - last[:, 0], self.model.beta - last[:, 1])
        shape = points.shape
        return QuasistaticSlips(
            d=points,
            value=value.reshape(shape),
            displacement=back.reshape(*shape, 2),
            moment=total.reshape(shape),
            wait=wait.reshape(shape),
        )

    def __repr__(self) -> str:
        """One line."""
        return f"QuasistaticMap({self.model!r}, V -> 0, engine={self._backend.name!r})"


@suggests
def quasistatic_map(
    model: TwoBlock,
    *,
    rtol: float = 1e-15,
    max_events: int = 10_000,
    engine: EngineName = "auto",
    threads: int | None = None,
) -> QuasistaticMap:
    """Make the event map of two blocks in the limit V -> 0, exactly.

    Parameters
    ----------
    model : TwoBlock
        Undamped; its ``V`` does not matter.
    rtol, max_events, engine, threads
        As in `event_map`.

    Returns
    -------
    QuasistaticMap
        A map of d like any event map: all analysis takes it.

    Raises
    ------
    ValueError
        Not two undamped blocks; a law with F(0) = 1, under which no block ever starts to slip
        unless the belt moves; a setting that is not allowed.

    Notes
    -----
    Derivation: docs/theory/quasistatic.md.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.quasistatic_map(ss.examples.coulomb())
    >>> round(f(0.5), 12)
    -0.421818181818
    """
    model = _checked(model)
    return QuasistaticMap(model, rtol=rtol, max_events=max_events, engine=engine, threads=threads)


def _checked(model: object) -> TwoBlock:
    """Return a model that has a quasi-static limit, or refuse it with the reason."""
    model = two_blocks(model, why="The quasi-static map is that of two equal blocks.")
    if model.damping != 0.0:
        raise ValueError(
            f"damping = {model.damping!r} is not allowed: the quasi-static map is that of "
            "undamped blocks. Take model.replace(damping=0)."
        )
    for block, law in enumerate(model.laws, start=1):
        at_rest = float(law.force(0.0))
        if not at_rest < 1.0:
            raise ValueError(
                f"F(0) = {at_rest!r} of block {block}: the quasi-static limit needs F(0) < 1. "
                "With F(0) = 1 a block at its static limit stays in balance with kinetic "
                "friction; its slip begins only as the belt moves on, ever later as V -> 0."
            )
    return model


def _map_of(model: object, **settings: Any) -> QuasistaticMap:
    return QuasistaticMap(_checked(model), **settings)


register_model_map("quasi-static map", QuasistaticMap, _map_of)
