"""What each kind of data says of a model: residuals and their exact derivatives."""

# Rows are (model - data) / sigma; columns those of the parameters, then a term's own unknowns: the
# states that its motions start from.

from __future__ import annotations

import contextlib
import re
from abc import ABC, abstractmethod
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from stickslip import status as status_codes
from stickslip.errors import NoCycleError
from stickslip.identification.data import (
    FEWEST,
    CyclePeriods,
    EventTimes,
    ForcePoints,
    MapPoints,
    Record,
    under_conditions,
)
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.dense import piece_row
from stickslip.mechanics.flow.system import BACKWARD, FORWARD
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.friction.code import law_code
from stickslip.mechanics.model.arguments import checked_state

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.flow.trajectory import Trajectory
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

# Least residual, in standard errors, of what a trial does not reach or does not have.
MISSED = 100.0
# Events of a motion between two global stick phases in a first look; most have about ten.
FEW = 100
# Standard errors of a velocity within which a block counts as riding.
SURE = 4.0
# Evaluations in which the start of a piece is sought, to tell whether blocks ride there, and the
# mean square of residuals that tell no more than rounding.
TRIES, EXACT = 12, 1e-6
# Of the belt's speed: a block that starts with so slow a slip rides; its landing, at once, would
# have no derivatives.
RIDES = 1e-9


class Answer(NamedTuple):
    """Residuals, their derivatives, what the model gives for the data, and links of pieces."""

    residuals: Floats  # (n,)
    jacobian: Floats  # (n, parameters + own), not finite where there are no derivatives
    fitted: Floats
    links: Floats  # (k,): how far the end of a piece of a motion is from the next
    link_jacobian: Floats
    matched: str
    states: Floats | None = None  # of a record at its times


class Term(ABC):
    """One set of data."""

    data: Any
    start: Floats  # guess of the term's own unknowns
    n_pieces = 1

    @property
    def n_unknown(self) -> int:
        """Number of own unknowns that no links determine."""
        return len(self.start)

    def states(self, model: Model, own: Floats) -> Floats:
        """States that motions start from, of the term's own unknowns."""
        return own

    def hurried(self) -> Term:
        """Return the term for a first look, to which what takes long counts as missed."""
        return self

    def answered_under_conditions(
        self, model: Model, names: tuple[str, ...], own: Floats
    ) -> Answer:
        """Compare the data with a model under their conditions, which no parameter changes."""
        moves = [name not in self.data.conditions for name in names]
        moving = tuple(name for name, free in zip(names, moves, strict=True) if free)
        answer = self.answer(under_conditions(self.data, model), moving, own)
        there = [*moves, *[True] * len(own)]

        def widened(slopes: Floats) -> Floats:
            wide = np.zeros((len(slopes), len(there)))
            wide[:, there] = slopes
            return wide

        return answer._replace(
            jacobian=widened(answer.jacobian), link_jacobian=widened(answer.link_jacobian)
        )

    @abstractmethod
    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Compare the data with a model."""


def filled(off: Floats, slope: Floats) -> tuple[Floats, Floats]:
    """Give what is missed a residual as large as any, without a slope; ValueError if all is."""
    known = np.isfinite(off)
    if len(off) and not known.any():
        raise ValueError("nothing of the data is met by the model with the parameters that it has")
    far = float(np.abs(off[known]).max(initial=MISSED))
    return np.where(known, off, far), np.where(known[..., None], slope, 0.0)


START: Final = re.compile(r"(x0|v0|d)(_\d+)?")
"""What a derivative by the start of a motion is called."""


class Start:
    """How a motion starts: what of it is unknown, and the arguments of `simulate`."""

    def __init__(self, data: Record | EventTimes, model: Model) -> None:
        if taken := next(filter(START.fullmatch, model.parameters), None):
            # A derivative by that name is one by the parameter.
            raise ValueError(
                f"the model's parameter {taken} has the name of a motion's start, which a fit "
                "seeks, too. Give the parameter of the friction law another name."
            )
        self.on_belt = data.d is not None
        self.free = data.free_start
        self.given: Floats | None = None
        self.n_parts = 2 if model.plant.n_positions else 1
        self.names: tuple[str, ...] = ("d",)
        if self.on_belt:
            self.given = np.asarray(data.d)
        else:
            self.names = ("x0", "v0")[: self.n_parts]
            if data.x0 is not None:
                full = checked_state(model, data.x0, data.v0, ("x0", "v0"))
                # Feet may be left out; where a start is unknown theirs is too.
                self.given = np.concatenate(full if self.free else (data.x0, data.v0))

    def arguments(self, state: Floats, *, on_belt: bool) -> dict[str, Any]:
        """Arguments of `simulate` for a start."""
        if on_belt:
            return {"d": float(state[0]) if len(state) == 1 else state}
        return dict(zip("xv", np.split(state, self.n_parts), strict=False))


class RecordTerm(Term):
    """A record, in pieces that each start from a state of its own, the first one unless known."""

    # Where blocks rub on one belt unknown starts hold velocities over that of the belt, so that a
    # block that rides goes on riding while the belt's speed is sought. Where static friction holds
    # what kinetic friction does not it would slip with 1e-17 over the belt: none is unknown.

    def __init__(
        self, data: Record, model: Model, n_pieces: int, states: Floats | None = None
    ) -> None:
        self.data, self.model = data, model
        self.origin = Start(data, model)
        self.t = np.asarray(data.t)
        self.over_belt = model.plant.rubs_as_one
        self.n_pieces = n_pieces
        self.zero = self._zero(states) if data.free_zero else np.zeros(0)
        splits = np.array_split(np.arange(len(self.t)), n_pieces)
        self.first = [int(split[0]) for split in splits]
        given = self.origin.given
        guess = self._likely if states is None else states.__getitem__
        self.known = None if self.origin.free else given
        known_at_zero = self.known is not None and model.plant.is_forced
        self.begin = 0.0 if known_at_zero else float(self.t[0])
        self.in_space = [self.known is None and not self.origin.on_belt, *[True] * (n_pieces - 1)]
        starts = [np.zeros(0) if self.known is not None or given is None else given]
        starts += [guess(k) - self._belt(model) for k in self.first[1:]]
        if self.in_space[0]:  # no motion leads there: who rides is asked anew
            known = given if states is None else self._likely(0, states[0])
            starts[0] = (self._likely(0) if known is None else known) - self._belt(model)
        self.moves = [
            self._unknown(each) if in_space else np.full(len(each), True)
            for each, in_space in zip(starts, self.in_space, strict=True)
        ]
        self.start = np.concatenate(
            [*(each[moves] for each, moves in zip(starts, self.moves, strict=True)), self.zero]
        )
        self.size = self._sizes() if n_pieces > 1 else np.ones(0)

    @property
    def n_unknown(self) -> int:
        """Those of the first piece, for links determine all others, and of the sensors."""
        return int(self.moves[0].sum()) + len(self.zero)

    def _unknown(self, state: Floats) -> NDArray[np.bool_]:
        """Whether each number of a start is sought: not the velocity of a block that rides."""
        found = np.full(len(state), True)
        if self.over_belt:
            jumps = np.array([law.force(0.0) < 1.0 for law in self.model.laws])
            found[len(jumps) :] = ~jumps | (state[len(jumps) :] != 0.0)
        return found

    def states(self, model: Model, own: Floats) -> Floats:
        """States, each with the velocity of the belt."""
        return np.concatenate([np.zeros(0), *self._starts(own, self._belt(model))])

    def _starts(self, own: Floats, belt: Floats) -> list[Floats]:
        """Join what is unknown of the starts of pieces and what is known of riding blocks."""
        *ends, end = np.cumsum([moves.sum() for moves in self.moves])
        found = []
        for values, moves, in_space in zip(
            np.split(own[:end], ends), self.moves, self.in_space, strict=True
        ):
            state = np.zeros(len(moves))
            state[moves] = values
            if in_space:
                state[np.abs(state) <= RIDES * np.abs(belt)] = 0.0
            found.append(state + belt if in_space else state)
        return found

    def _belt(self, model: Model) -> Floats:
        plant = model.plant
        speed = plant.V if self.over_belt else np.zeros(plant.n_positions)
        return np.concatenate([np.zeros(len(plant.mass)), speed])

    def _sizes(self) -> Floats:
        """Scatter of displacements, then of velocities: scale of the links."""
        x, v = np.split(np.array([self.state_at(k) for k in self._some]), 2, axis=1)
        return np.repeat([max(float(part.std()), 1e-12) for part in (x, v)], x.shape[1])

    def state_at(self, k: int) -> Floats:
        """Guess of the state at a sample from those near it; who may ride does."""
        state, rides = self._seen(k)
        return self._carried(state, rides)

    def _seen(self, k: int) -> tuple[Floats, NDArray[np.bool_]]:
        """State at a sample, and who may have the belt's velocity, as far as those near it tell."""
        found, _, errors = self._about(k)
        if not self.over_belt:
            return found.ravel(), np.full(len(errors), False)
        off = np.abs(found[1] - self.model.plant.V)
        return found.ravel(), off <= SURE * errors * self._scatter

    def _carried(self, state: Floats, blocks: NDArray[np.bool_]) -> Floats:
        """Give some blocks of a state the velocity of the belt."""
        found = state.copy()
        if blocks.any():
            found[len(blocks) :][blocks] = self.model.plant.V[blocks]
        return found

    def _likely(self, k: int, known: Floats | None = None) -> Floats:
        """Guess of the state at a sample: who may ride does, unless slip tells the next better."""
        seen, rides = self._seen(k)
        n, state = len(rides), seen if known is None else known.copy()
        if known is not None and self.over_belt:  # who rode may not any more
            rode = known[n:] == self.model.plant.V
            state[n:][rode] = seen[n:][rode]
        best = self._carried(state, rides)
        open_ = np.flatnonzero(rides & ~self._unknown(np.zeros(2 * n))[n:])
        if len(open_):
            least, _ = self._misfit_from(k, best)
        for block in n + open_:
            other = best.copy()
            other[block] = seen[block]
            misfit, n_free = self._misfit_from(k, other)
            if least - misfit > SURE**2 * max(misfit / n_free, EXACT):
                best, least = other, misfit
        return best

    def _misfit_from(self, k: int, state: Floats) -> tuple[float, int]:
        """Sum of squares of the samples from one on, over some period, and number of free data."""
        from scipy.optimize import least_squares  # loads linear algebra

        begin = float(self.t[k])
        end = int(np.searchsorted(self.t, self.t[k] + natural_period(self.model)))
        rows = slice(k, min(max(end, k + FEWEST), len(self.t)))
        belt = self._belt(self.model)
        moves = self._unknown(state - belt)

        @lru_cache(maxsize=1)  # asked for residuals, then for slopes
        def compared(*own: float) -> tuple[Floats, Floats]:
            start = state.copy()
            start[moves] = own
            table = _Rows(self.data, len(state) + len(self.zero), self.zero)
            given = self.origin.arguments(start, on_belt=False)
            values, slopes = sampled(self.model, given, ("x0", "v0"), self.t[rows], begin)
            table.add(rows, values, np.pad(slopes, [(0, 0), (0, 0), (0, len(self.zero))]))
            residuals, jacobian, _ = table.joined()
            return residuals, np.nan_to_num(jacobian[:, : len(state)][:, moves], posinf=0, neginf=0)

        def residuals(own: Floats) -> Floats:
            return compared(*own)[0]

        def slopes(own: Floats) -> Floats:
            return compared(*own)[1]

        try:
            found = least_squares(residuals, state[moves], slopes, x_scale="jac", max_nfev=TRIES)
        except ValueError:  # no motion from there meets any of them
            return np.inf, 1
        return 2.0 * float(found.cost), max(len(found.fun) - int(moves.sum()), 1)

    def _about(self, k: int) -> tuple[Floats, Floats, Floats]:
        """State at a sample, (2, n), scatter, error of a velocity for a scatter of 1, each (n,).

        By polynomials near it; the scatter is that of the samples that tell velocities.
        """
        time, found = float(self.t[k]), []
        for block in np.argsort(self.data.blocks):
            x, v = self._channels[block]
            teller, order = (v, 0) if len(v.t) >= len(x.t) else (x, 1)
            at, scatter, errors = teller.near(time, order + 1)
            median = (1.0 - 2.0 / (9.0 * (2 * teller.window - order - 1))) ** 1.5  # of chi
            place = x.near(time, 2)[0][0] - (self.zero[block] if self.data.free_zero else 0.0)
            found.append([place, at[order], scatter / median, errors[order]])
        places, speeds, spread, gain = np.array(found).T
        return np.array([places, speeds]), spread, gain

    @cached_property
    def _channels(self) -> list[tuple[Channel, Channel]]:
        """Displacements and velocities of each block that was measured, as far as they are known.

        Without displacements the integral of velocities, about the place of sliding.
        """
        slow = 0.3 * natural_period(self.model) / (2.0 * np.pi)
        measured = {name: values.T for name, values, _ in self.data.rows}
        none = np.full((len(self.data.blocks), len(self.t)), np.nan)
        found = []
        for middle, *both in zip(
            self._middle, measured.get("x", none), measured.get("v", none), strict=True
        ):
            x, v = (Channel.of(self.t, values, slow) for values in both)
            found.append((x if len(x.t) >= FEWEST else v.integral(middle), v))
        return found

    @cached_property
    def _scatter(self) -> Floats:
        """Scatter of the samples that tell velocities; a few samples alone hardly know theirs."""
        return np.asarray(np.median([self._about(k)[1] for k in self._some], axis=0))

    @property
    def _some(self) -> range:
        """Samples all over the record."""
        return range(0, len(self.t), max(len(self.t) // 200, 1))

    @property
    def _middle(self) -> Floats:
        """Displacements of the measured blocks in sliding."""
        plant, index = self.model.plant, np.array(self.data.blocks) - 1
        if not plant.rubs_as_one:
            return np.zeros(len(index))
        force = [law.force(abs(V)) for law, V in zip(self.model.laws, plant.V, strict=True)]
        pull = np.linalg.solve(plant.stiffness, np.sign(plant.V) * plant.static * force)
        return np.asarray(pull[index])

    def _zero(self, states: Floats | None) -> Floats:
        """Guess where displacements are counted from: by states, a start, or about sliding."""
        x, index = np.asarray(self.data.x), np.array(self.data.blocks) - 1
        if states is not None:
            return np.nanmean(x - states[:, index], axis=0)
        if self.data.x0 is not None:
            first = np.isfinite(x).argmax(axis=0), np.arange(len(index))
            return np.asarray(x[first] - np.asarray(self.data.x0)[index])
        return np.nanmean(x, axis=0) - self._middle

    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Follow the pieces."""
        n, n_bodies = len(names), len(model.plant.mass)
        width = n + len(own)
        belt = self._belt(model)
        place, states = n, []
        zero = own[len(own) - len(self.zero) :]
        table = _Rows(self.data, width, zero)
        links, link_gradients = [np.zeros(0)], [np.zeros((0, width))]
        end: tuple[Floats, Floats] | None = None
        for piece, state in enumerate(self._starts(own, belt)):
            first, moves, in_space = self.first[piece], self.moves[piece], self.in_space[piece]
            last = self.first[piece + 1] if piece + 1 < len(self.first) else len(self.t)
            columns = place + np.arange(moves.sum())
            place += len(columns)
            in_full = ("x0", "v0")[: self.origin.n_parts]
            of_start: tuple[str, ...] = in_full if in_space else self.origin.names
            if not len(moves):
                assert self.known is not None
                state, of_start = self.known, ()
            begin = self.begin if piece == 0 else float(self.t[first])
            on_belt = piece == 0 and self.origin.on_belt
            start = self.origin.arguments(state, on_belt=on_belt)
            t = self.t[first : last + 1]
            values, moved = sampled(model, start, (*names, *of_start), t, begin)
            gradient = np.zeros((*values.shape, width))
            gradient[..., :n] = moved[..., :n]
            gradient[..., columns] = moved[..., n:][..., moves]
            if in_space and self.over_belt and "V" in names:
                gradient[..., names.index("V")] += moved[..., n + n_bodies :].sum(axis=-1)
            if end is not None:
                off, slope = end[0] - state, end[1].copy()
                slope[np.flatnonzero(moves), columns] -= 1.0
                if self.over_belt and "V" in names:
                    slope[n_bodies:, names.index("V")] -= 1.0
                met = np.isfinite(off)
                links.append(np.where(met, off / self.size, MISSED))
                link_gradients.append(np.where(met[:, None], slope / self.size[:, None], 0.0))
            table.add(slice(first, last), values, gradient)
            states.append(values[: last - first].copy())
            if end is not None:  # who rides may have been taken to
                states[-1][0, ~moves] = end[0][~moves]
            end = (values[-1], gradient[-1]) if last < len(self.t) else None
        residuals, jacobian, fitted = table.joined()
        told = f" in {len(self.first)} pieces" * (len(self.first) > 1)
        riding = np.flatnonzero(~self.moves[0]) - n_bodies + 1
        told += "".join(f", block {block} taken to ride at its start" for block in riding)
        told += ", of displacements from" * bool(len(zero)) + "".join(f" {z:.6g}" for z in zero)
        return Answer(
            *(residuals, jacobian, fitted, np.concatenate(links), np.concatenate(link_gradients)),
            f"{len(residuals)} values of a record{told}",
            np.concatenate(states),
        )


class _Rows:
    """Residuals of a record and their derivatives, piece by piece."""

    def __init__(self, data: Record, width: int, zero: Floats) -> None:
        self.data, self.width, self.zero = data, width, zero
        self.parts: dict[str, list[tuple[Floats, Floats, Floats]]] = {}

    def add(self, rows: slice, values: Floats, gradient: Floats) -> None:
        """Compare states (times, 2 N) with a part of the record."""
        n = values.shape[1] // 2
        count = rows.stop - rows.start
        for name, data, sigma in self.data.rows:
            index = np.array(self.data.blocks) - 1 + n * (name == "v")
            here, slope = values[:count, index], gradient[:count, index]
            if name == "x" and len(self.zero):
                here = here + self.zero
                slope[..., self.width - len(self.zero) :] += np.eye(len(self.zero))
            known = np.isfinite(data[rows])
            off = ((here - data[rows]) / sigma[rows])[known]
            part = *filled(off, slope[known] / sigma[rows][known][:, None]), here.ravel()
            self.parts.setdefault(name, []).append(part)

    def joined(self) -> tuple[Floats, Floats, Floats]:
        """Return residuals, derivatives and what the model gives: of displacements first."""
        parts = [part for each in self.parts.values() for part in each]
        residuals, slopes, fitted = zip(*parts, strict=True)
        return np.concatenate(residuals), np.concatenate(slopes), np.concatenate(fitted)


class Channel(NamedTuple):
    """What is known of one quantity of one block, and how many samples on either side tell it."""

    t: Floats
    values: Floats
    window: int

    @classmethod
    def of(cls, t: Floats, values: Floats, slow: float) -> Channel:
        """Leave out what is missing; a quantity changes little over a time `slow`."""
        known = np.isfinite(values)
        most = max((int(known.sum()) - 1) // 2, 0)
        step = float(np.median(np.diff(t[known]))) if most else np.inf
        return cls(t[known], values[known], min(max(int(slow / step), 2), most))

    def near(self, time: float, degree: int) -> tuple[Floats, Floats, Floats]:
        """Fit a polynomial in the time from one on, as `polynomial`."""
        n = 2 * self.window + 1
        low = int(np.clip(np.searchsorted(self.t, time) - self.window, 0, len(self.t) - n))
        near = slice(low, low + n)
        return polynomial(self.t[near] - time, self.values[near], degree)

    def integral(self, middle: float) -> Channel:
        """Integrate over the time, about a mean."""
        steps = 0.5 * (self.values[1:] + self.values[:-1]) * np.diff(self.t)
        way = np.concatenate([[0.0], np.cumsum(steps)])
        return self._replace(values=way - way.mean() + middle)


def polynomial(t: Floats, values: Floats, degree: int) -> tuple[Floats, Floats, Floats]:
    """Fit polynomials: coefficients, scatter of the columns, errors of coefficients per scatter."""
    powers = np.vander(t, degree + 1, increasing=True)
    found = np.asarray(np.linalg.lstsq(powers, values)[0], dtype=np.float64)
    spare = max(len(t) - degree - 1, 1)
    scatter = np.sqrt(np.sum((values - powers @ found) ** 2, axis=0) / spare)
    return found, scatter, np.sqrt(np.diag(np.linalg.pinv(powers.T @ powers)))


def sampled(
    model: Model, start: dict[str, Any], names: tuple[str, ...], t: Floats, begin: float = 0.0
) -> tuple[Floats, Floats]:
    """Return states at times of a motion that begins at one, NaN beyond its end, and derivatives.

    Columns are those of the names; "x0" and "v0", which have several, are the last.
    """
    numbers = model.parameters if begin else {}
    waves = [name.removesuffix("frequency") for name in numbers if name.endswith(".frequency")]
    turned = {
        f"{wave}phase": numbers[f"{wave}phase"] + begin * numbers[f"{wave}frequency"]
        for wave in waves
    }
    t = t - begin
    motion = simulate(model.replace(**turned) if turned else model, **start, t_end=float(t[-1]))
    inside = t <= motion.t[-1]
    values = np.full((len(t), len(model.plant.mass) + model.plant.n_positions), np.nan)
    values[inside] = np.concatenate([motion.x(t[inside]), motion.v(t[inside])], axis=-1)
    if not names:
        return values, np.zeros((*values.shape, 0))
    # What a frequency does until the motion begins, it does through the phase.
    faster = [wave for wave in waves if f"{wave}frequency" in names]
    through = [f"{wave}phase" for wave in faster if f"{wave}phase" not in names]
    asked = [*through, *names]
    slopes = np.concatenate(motion.derivative(*asked).states(t), axis=1)
    for wave in faster:
        one, other = (asked.index(f"{wave}{name}") for name in ("frequency", "phase"))
        slopes[..., one] += begin * slopes[..., other]
    return values, slopes[..., len(through) :]


class SeriesTerm(Term):
    """Data of one quantity, without unknowns of their own."""

    start = np.zeros(0)

    def __init__(self, data: EventTimes | MapPoints | CyclePeriods | ForcePoints) -> None:
        self.data: Any = data
        ((_, self.measured, self.sigma),) = data.rows

    def answered(self, fitted: Floats, gradient: Floats, matched: str) -> Answer:
        """Compare the data with what a model gives for them, NaN where it gives nothing."""
        off = (fitted - self.measured[:, 0]) / self.sigma[:, 0]
        no_links = np.zeros(0), np.zeros((0, gradient.shape[1]))
        return Answer(*filled(off, gradient / self.sigma), fitted, *no_links, matched)


class EventTerm(SeriesTerm):
    """Times of events of one kind, the first with the first."""

    def __init__(self, data: EventTimes, model: Model) -> None:
        super().__init__(data)
        self.origin = Start(data, model)
        assert self.origin.given is not None
        self.given = self.origin.given
        self.start = self.given if self.origin.free else np.zeros(0)

    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Follow the motion until it has had as many events, or far beyond the last."""
        data, n = self.data, len(self.measured)
        asked = (*names, *self.origin.names) if self.origin.free else names
        motion = self._long_enough(model, own if self.origin.free else self.given, n)
        chosen = [
            k
            for k, event in enumerate(motion.events)
            if event.block == data.block and event.kind == data.kind
        ][:n]
        fitted, gradient = np.full(n, np.nan), np.zeros((n, len(names) + len(own)))
        fitted[: len(chosen)] = [motion.events[k].time for k in chosen]
        if asked:
            gradient[: len(chosen)] = motion.derivative(*asked).event_times[chosen]
        matched = f"{len(chosen)} of {n} events: block {data.block}, {data.kind}"
        return self.answered(fitted, gradient, matched)

    def _long_enough(self, model: Model, state: Floats, n: int) -> Trajectory:
        end = float(np.asarray(self.data.times)[-1])
        for more in (1.2, 2.0, 4.0):
            motion = simulate(
                model,
                **self.origin.arguments(state, on_belt=self.origin.on_belt),
                t_end=more * end + 1.0,
            )
            kinds = [(event.block, event.kind) for event in motion.events]
            enough = kinds.count((self.data.block, self.data.kind)) >= n
            if enough or motion.status != status_codes.OK:
                break
        return motion


class MapTerm(SeriesTerm):
    """Points of an event map."""

    def __init__(self, data: MapPoints, max_events: int = 10_000) -> None:
        super().__init__(data)
        self.max_events = max_events

    def hurried(self) -> Term:
        """Return the term that gives up motions after few events."""
        return MapTerm(self.data, FEW)

    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Evaluate the map."""
        f: Any = event_map(model, max_events=self.max_events)
        low, high = f.domain
        d = np.asarray(self.data.d)
        inside = (d >= low) & (d <= high)
        fitted, gradient = np.full(len(d), np.nan), np.zeros((len(d), len(names)))
        fitted[inside] = f(d[inside])
        for column, name in enumerate(names):
            gradient[inside, column] = f.parameter_derivative(d[inside], name)
        matched = f"{np.isfinite(fitted).sum()} of {len(d)} points of the event map"
        return self.answered(fitted, gradient, matched)


class PeriodTerm(SeriesTerm):
    """Periods of cycles over the speed of the belt."""

    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Follow motions from rest to cycles, or to none."""
        V = np.asarray(self.data.V)
        fitted, gradient = np.full(len(V), np.nan), np.zeros((len(V), len(names)))
        moving = [name for name in names if name != "V"]
        columns = [names.index(name) for name in moving]
        rest = np.zeros(len(model.plant.mass)), np.zeros(model.plant.n_positions)
        for k, speed in enumerate(V.tolist()):
            at_speed = model.replace(V=speed)
            with contextlib.suppress(NoCycleError):
                cycle = find_cycle(at_speed, *rest, max_events=FEW)
                fitted[k] = cycle.period
                if moving:
                    gradient[k, columns] = cycle.period_derivative(*moving)
        matched = f"{np.isfinite(fitted).sum()} of {len(V)} periods of cycles"
        return self.answered(fitted, gradient, matched)


class ForceTerm(SeriesTerm):
    """Friction forces over slip speeds."""

    def answer(self, model: Model, names: tuple[str, ...], own: Floats) -> Answer:
        """Evaluate the law."""
        data, block = self.data, self.data.block - 1
        s = np.asarray(data.speed)
        fitted = model.laws[block].force(s, forward=data.forward)
        by_own = law_gradients(model, block, s, data.forward)
        gradient = np.zeros((len(s), len(names)))
        for column, name in enumerate(names):
            for where, own_name in model.law_parameters.get(name, ()):
                if where == block:
                    gradient[:, column] = by_own[own_name]
        return self.answered(fitted, gradient, f"{len(s)} forces of block {data.block}")


def law_gradients(model: Model, block: int, s: Floats, forward: bool) -> dict[str, Floats]:
    """Differentiate the law of a contact at speeds by each of its parameters."""
    code, law = law_code(model.laws), model.laws[block]
    rows, mode = code.parameter_rows(model.laws), FORWARD if forward else BACKWARD
    out = np.zeros((len(s), code.N_PARAMETERS))
    for speed, each in zip(s, out, strict=True):
        code.gradient(rows[piece_row(rows, block, speed)], mode, speed, each)
    return {name: out[:, code.parameter_index(law, name)] for name in law.parameters}


def natural_period(model: Model) -> float:
    """Period of the fastest oscillation of the plant without friction."""
    rates = np.linalg.eigvals(model.plant.reduced.flow)
    return float(2.0 * np.pi / max(np.abs(rates).max(), 1e-12))


def term_of(data: Any, model: Model, n_pieces: int, states: Floats | None = None) -> Term:
    """Make the term of some data; `states` of a record are known from an earlier approach."""
    if isinstance(data, Record):
        return RecordTerm(data, model, n_pieces, states)
    if isinstance(data, EventTimes):
        return EventTerm(data, model)
    others = {MapPoints: MapTerm, ForcePoints: ForceTerm, CyclePeriods: PeriodTerm}
    return others[type(data)](data)
