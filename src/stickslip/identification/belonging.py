"""Whether data can be those of a model, and are in its units."""

from __future__ import annotations

from itertools import repeat
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from stickslip.identification.data import (
    CyclePeriods,
    Data,
    EventTimes,
    ForcePoints,
    MapPoints,
    Record,
    under_conditions,
)
from stickslip.identification.terms import natural_period
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import simulate

if TYPE_CHECKING:
    from stickslip.mechanics.model.arguments import Model
    from stickslip.numerics.arrays import Floats

# Ratio of sizes, of data and of motions, beyond which their units seem to differ; a thousand of
# milli and kilo is beyond it, what differs among motions of one model is not.
SUSPICIOUS = 100.0
# Fast periods of the model that one oscillation of data takes at least, and at most.
OSCILLATION = (1.0 / 30.0, 300.0)
# Correlation of neighbouring samples above which a record is a motion, not noise.
MOTION = 0.5


def check_belongs(model: Model, data: Data, number: int, *, check_units: bool) -> None:
    """ValueError where data cannot be the model's, or seem to have other units."""
    place = f"data {number} ({type(data).__name__})"
    if data.conditions and not model.parameters.keys() >= data.conditions.keys():
        raise ValueError(f"{place}: V is that of blocks on one belt, and the model has several")
    model = under_conditions(data, model)
    _check_blocks(model, data, place)
    if check_units:
        for told in _sizes(model, data):
            told.check(place)


def _check_blocks(model: Model, data: Data, place: str) -> None:
    plant = model.plant
    if isinstance(data, MapPoints):
        if model.n_blocks != 2 or not plant.rubs_as_one:
            raise ValueError(f"{place}: MapPoints are those of two blocks on one belt")
        return
    if isinstance(data, CyclePeriods):
        if "V" not in model.parameters or plant.is_forced:
            raise ValueError(f"{place}: CyclePeriods are those of blocks on one belt, not forced")
        return
    if isinstance(data, Record) and data.v is not None and not plant.n_positions:
        raise ValueError(f"{place}: states of a state-space form have no velocities: give x alone")
    blocks = data.blocks if isinstance(data, Record) else (data.block,)
    n = len(plant.mass) if isinstance(data, Record) else plant.n_contacts
    if max(blocks) > n:
        raise ValueError(f"{place}: block {max(blocks)} is not one of the model's {n}")
    if isinstance(data, Record) and data.free_start and data.x0 is None and data.d is None:
        if len(blocks) < len(plant.mass) or not plant.n_positions:
            missing = sorted(set(range(1, n + 1)) - set(blocks))
            why = f"blocks {missing} are not measured" if missing else "a state has no velocities"
            raise ValueError(
                f"{place}: {why}, so that the start cannot be guessed: give x0= and v0=, with "
                "free_start=True if they are guesses."
            )


class _Size(NamedTuple):
    """A size of data beside that of the model, which is of the same order."""

    name: str  # "x reaches"
    found: float
    own: float
    what: str  # "motions of the model reach some"
    low: float = 1.0 / SUSPICIOUS
    high: float = SUSPICIOUS
    where: str = ""  # the largest is

    def check(self, place: str) -> None:
        """ValueError where the ratio of both is out of all proportion."""
        if self.own > 0.0 and not self.low < self.found / self.own < self.high:
            raise ValueError(
                f"{place}: {self.name} {self.found:.6g}{self.where}, where {self.what} "
                f"{self.own:.3g}. Are both in the same units? Is no value out of place? Units of a "
                "file are told where it is read (--units), data.to_dimensionless(units) changes "
                "those of data; check_units, if False (--any-units), takes them as they are."
            )


def _about(data: Record, kind: str, values: Floats) -> Floats:
    """Return values of a record, those of sensors that count from anywhere about their means."""
    return values - np.nanmean(values, axis=0) if kind == "x" and data.free_zero else values


def _sizes(model: Model, data: Data) -> list[_Size]:
    period = natural_period(model)
    fast = "a fast period of the model takes"
    if isinstance(data, MapPoints):
        values = np.concatenate([np.asarray(data.d), np.asarray(data.value)])
        f: Any = event_map(model)
        low, high = f.domain
        return [_Size("d reaches", _largest(values), max(-low, high), "that of the model reaches")]
    if isinstance(data, EventTimes):
        times = np.asarray(data.times)
        each = times[-1] / len(times)
        return [_Size("from one event to the next it takes some", each, period, fast, *OSCILLATION)]
    speeds, reach = _scales(model, period)
    if isinstance(data, CyclePeriods):
        longest = _Size("periods reach", _largest(np.asarray(data.period)), period, fast)
        belt = _Size("V reaches", _largest(np.asarray(data.V)), speeds, "the model's are some")
        return [longest._replace(low=OSCILLATION[0], high=OSCILLATION[1]), belt]
    if isinstance(data, ForcePoints):
        force, speed = _largest(np.asarray(data.force)), _largest(np.asarray(data.speed))
        limit = "the static limit of the contact is taken for"
        return [
            _Size("forces reach", force, 1.0, limit, high=0.3 * SUSPICIOUS),
            _Size("speeds reach", speed, speeds, "the model's are some"),
        ]
    own = {"x": reach, "v": speeds}
    sizes = [
        _reached(data, kind, _about(data, kind, values), own[kind]) for kind, values, _ in data.rows
    ]
    return [*sizes, *_paces(data, period, fast)]


def _reached(data: Record, kind: str, values: Floats, own: float) -> _Size:
    """Find what displacements or velocities reach, and where."""
    row, column = np.unravel_index(int(np.nanargmax(np.abs(values))), values.shape)
    where = f" (block {data.blocks[column]}, t = {data.t[row]:.6g})"
    what = "motions of the model reach some"
    return _Size(f"{kind} reaches", abs(float(values[row, column])), own, what, where=where)


def _largest(values: Floats) -> float:
    return float(np.nanmax(np.abs(values), initial=0.0))  # states have no velocities


def _scales(model: Model, period: float) -> tuple[float, float]:
    """Speeds, of motions from rest and of belts, and displacements that static friction holds."""
    plant = model.plant
    rest = np.zeros(len(plant.mass)), np.zeros(plant.n_positions)
    motion = simulate(model, *rest, t_end=4.0 * period)
    times = np.linspace(0.0, motion.t[-1], 200)
    x, v = _largest(motion.x(times)), _largest(motion.v(times))
    if plant.n_positions:
        spring = float(np.abs(np.diag(plant.stiffness)).max(initial=1e-300))
        x = max(x, float(np.abs(plant.static).max()) / spring)
    return max(v, _largest(np.asarray(plant.V))), x


def _paces(data: Record, period: float, fast: str) -> list[_Size]:
    """How long a record and its oscillations last; displacements beside integrated velocities."""
    t = np.asarray(data.t)
    span = float(t[-1] - t[0])
    low, high = OSCILLATION
    told = [_Size("it lasts", span, period, fast, low, 10.0 * high)]
    columns = [column[np.isfinite(column)] for column in data.rows[0][1].T]
    swings = [column - column.mean() for column in columns if len(column)]
    both, squares = np.sum([[each[1:] @ each[:-1], each @ each] for each in swings], axis=0)
    turns = max(_turns(each) for each in swings)
    if both > MOTION * squares and turns > 2:
        told.append(_Size("an oscillation takes some", span / turns, period, fast, low, high))
    if data.x is not None and data.v is not None:
        moved, travelled = zip(*map(_ways, repeat(t), data.x.T, data.v.T), strict=True)
        told.append(_Size("x changes by some", max(moved), max(travelled), "v times dt sums up to"))
    return told


def _ways(t: Floats, x: Floats, v: Floats) -> tuple[float, float]:
    """Scatter of displacements, and of the integral of velocities, where both are known."""
    known = np.isfinite(x) & np.isfinite(v)
    t, x, v = t[known], x[known], v[known]
    travelled = np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(t))
    return (float(x[1:].std()), float(travelled.std())) if len(t) > 1 else (0.0, 0.0)


def _turns(values: Floats) -> int:
    """Count oscillations: from above half the scatter to below, and back."""
    far = np.sign(values) * (np.abs(values) > 0.5 * values.std())
    signs = far[far != 0.0]
    return int(np.sum(signs[1:] * signs[:-1] < 0.0)) // 2
