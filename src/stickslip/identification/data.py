"""Measurements: records of motions, times of events, points of a map, forces, periods."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, TypeAlias

import numpy as np

from stickslip.checks import (
    LARGEST,
    finite_number,
    flag,
    instance,
    one_of,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.model.units import Units
from stickslip.results.parts import part
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.model.arguments import Model
    from stickslip.mechanics.model.units import Quantity
    from stickslip.numerics.arrays import Floats

KINDS = ("stick", "slip backward", "slip forward")
FEWEST = 5  # points of a record: fewer tell no start and nothing else


class _Measured:
    """Checked values in a frozen dataclass, and what they are in other units."""

    sigma: Any
    _quantities: ClassVar[Mapping[str, Quantity]]
    _axes: ClassVar[tuple[str, str]]  # what was measured over what

    @property
    def abscissa(self) -> tuple[str, Floats]:
        """Name and values of what was measured over: times, speeds, or the numbers of events."""
        name, (_, values, _) = self._axes[0], self.rows[0]
        return name, np.asarray(getattr(self, name, np.arange(1.0, len(values) + 1.0)))

    @property
    def rows(self) -> list[tuple[str, Floats, Floats]]:
        """Name, values (n, k) and standard errors of what was measured, guesses if not given."""
        values = np.asarray(getattr(self, self._axes[1]))[:, None]
        return [(self._axes[1], values, _errors(self.sigma, values))]

    @property
    def known(self) -> NDArray[np.bool_]:
        """Which values were measured, (n,): those of a record may be missing."""
        return np.concatenate([np.isfinite(values).ravel() for _, values, _ in self.rows])

    @property
    def is_weighed(self) -> bool:
        """Whether standard errors are given."""
        return self.sigma is not None

    @property
    def conditions(self) -> dict[str, float]:
        """Parameters of a model that these data have values of their own for."""
        return {}

    def to_dimensionless(self, units: Units) -> Self:
        """Divide measured values by the scales of a model's units.

        Parameters
        ----------
        units : Units
            In the units of the measurement; for `ForcePoints` `fs1` is the static limit of
            their contact.

        Returns
        -------
        Record, EventTimes, MapPoints, ForcePoints or CyclePeriods
            The same in the units of the model.

        Raises
        ------
        ValueError
            Not `Units`.
        """
        instance("units", units, Units, "Units, such as Units(m=2.0, k=8.0, fs1=4.0)")
        known = {name: getattr(self, name) for name in self._quantities}
        changed: dict[str, Any] = {
            name: units.to_dimensionless(self._quantities[name], value)
            for name, value in known.items()
            if value is not None
        }
        return replace(self, **changed)  # type: ignore[type-var]

    def _store(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)


class _Motion(_Measured):
    """Measured of one motion, which starts somewhere, on a belt of some speed."""

    V: Any

    @property
    def conditions(self) -> dict[str, float]:
        """The speed of the belt, if that is the motion's own."""
        return {} if self.V is None else {"V": self.V}


@suggests
@part
@dataclass(frozen=True, eq=False)
class Record(_Motion):
    """Displacements or velocities of blocks, or both, at some times of one motion.

    Parameters
    ----------
    t : array_like of float, shape (n,)
        Times, ascending, n >= 5; the motion starts at the first, but that of a forced model from a
        state that is known (`x0`, `v0`, no guess) at the forcing's time 0.
    x, v : array_like of float, shape (n,) or (n, k), optional
        Displacements and velocities of k blocks, at least one of the two. NaN stands for what is
        missing, as where channels were sampled at different times; of each block 5 values of one
        kind are needed.
    blocks : sequence of int, optional
        Which blocks they are, counted from 1; without it the first k.
    sigma, sigma_v : float or array_like of float, optional
        Standard error of a displacement and of a velocity, > 0, or one for each time, (n,), or for
        each number, (n, k); without it the scatter is estimated from the residuals, one share of
        that of displacements and of velocities: give both where one is noisier.
    x0, v0 : array_like of float, shape (N,), optional
        State that the motion starts from; without it the start is estimated, too.
    d : float or array_like of float, optional
        Instead of `x0` and `v0`: the global stick phase that the motion starts from.
    free_start : bool
        The start that is given is a guess, and estimated.
    free_zero : bool
        The sensors of `x` count from unknown places, not from where springs are slack; these are
        estimated, too, one for each block.
    V : float, optional
        Speed of the belt in this record, where that is not the model's: several records at several
        speeds share all other parameters.

    Raises
    ------
    ValueError
        What is not allowed, by name.

    Examples
    --------
    >>> import numpy as np
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5))
    >>> t = np.linspace(0, 20, 101)
    >>> seen = ss.Record(t, x=ss.simulate(block, [0.9], [0.1], t_end=20.0).x(t))
    >>> ss.fit(block.replace(mu=0.4), seen, ["mu"]).values.round(9)
    array([0.5])
    """

    t: Any
    x: Any = None
    v: Any = None
    blocks: tuple[int, ...] = ()
    sigma: Any = None
    sigma_v: Any = None
    x0: Any = None
    v0: Any = None
    d: Any = None
    free_start: bool = False
    free_zero: bool = False
    V: Any = None
    _axes: ClassVar = ("t", "x")
    _quantities: ClassVar[Mapping[str, Quantity]] = {
        "t": "time",
        **dict.fromkeys(("x", "x0", "d", "sigma"), "displacement"),
        **dict.fromkeys(("v", "v0", "sigma_v", "V"), "velocity"),
    }

    def __post_init__(self) -> None:
        """Check every number."""
        t = _ascending("t", self.t)
        if len(t) < FEWEST:
            raise ValueError(f"t has {len(t)} times: a record needs at least {FEWEST}.")
        if self.x is None and self.v is None:
            raise ValueError("a record needs x, displacements, or v, velocities, or both")
        if flag("free_zero", self.free_zero) and self.x is None:
            raise ValueError("free_zero: there are no displacements x to be counted from anywhere")
        names = [name for name in ("x", "v") if getattr(self, name) is not None]
        found = {name: columns(name, getattr(self, name), len(t), may_miss=True) for name in names}
        widths = {values.shape[1] for values in found.values()}
        if len(widths) > 1:
            raise ValueError("x and v must be of the same blocks: their shapes differ")
        n = widths.pop()
        asked: Any = self.blocks
        given = list(asked) if np.iterable(asked) else [asked]
        blocks = tuple(whole_number("blocks", k) for k in given) or tuple(range(1, n + 1))
        if len(blocks) != n or len(set(blocks)) != n:
            raise ValueError(f"blocks = {shown(self.blocks)}: {n} are needed, each once")
        counts = np.array([np.isfinite(values).sum(axis=0) for values in found.values()])
        if (few := counts.max(axis=0) < FEWEST).any():
            k = int(np.argmax(few))
            told = " and ".join(map(str, counts[:, k]))
            raise ValueError(
                f"{' and '.join(names)} of block {blocks[k]} hold {told} numbers, the others are "
                f"missing: a record needs at least {FEWEST} of each block. Leave the block out."
            )
        if self.free_zero and not counts[0].all():
            k = blocks[int(np.argmin(counts[0]))]
            raise ValueError(f"free_zero: all displacements x of block {k} are missing")
        kept = {
            name: found[name] for name, n_known in zip(names, counts, strict=True) if n_known.any()
        }
        self._store(
            t=t,
            **{"x": None, "v": None, **kept},
            blocks=blocks,
            sigma=_sigma("sigma", self.sigma, len(t), n, found.get("x")),
            sigma_v=_sigma("sigma_v", self.sigma_v, len(t), n, found.get("v")),
            **_start(self),
        )

    @property
    def is_weighed(self) -> bool:
        """Whether all standard errors are given."""
        pairs = ((self.x, self.sigma), (self.v, self.sigma_v))
        return all(values is None or sigma is not None for values, sigma in pairs)

    @property
    def rows(self) -> list[tuple[str, Floats, Floats]]:
        """Displacements, then velocities."""
        each = (("x", self.x, self.sigma), ("v", self.v, self.sigma_v))
        return [
            (name, np.asarray(values), _errors(sigma, np.asarray(values)))
            for name, values, sigma in each
            if values is not None
        ]


@suggests
@part
@dataclass(frozen=True, eq=False)
class EventTimes(_Motion):
    """Times at which a block takes a mode, counted from the start of the motion.

    Parameters
    ----------
    times : array_like of float, shape (n,)
        Ascending: those of the first n such events after the start.
    kind : {"stick", "slip backward", "slip forward"}
    block : int
        Counted from 1.
    sigma : float or array_like of float, optional
        As in `Record`.
    x0, v0, d, free_start, V
        Start of the motion and speed of its belt, as in `Record`; the start must be given, at least
        as a guess.

    Raises
    ------
    ValueError
        What is not allowed, by name.
    """

    times: Any
    kind: Literal["stick", "slip backward", "slip forward"] = "stick"
    block: int = 1
    sigma: Any = None
    x0: Any = None
    v0: Any = None
    d: Any = None
    free_start: bool = False
    V: Any = None
    _axes: ClassVar = ("event", "times")
    _quantities: ClassVar[Mapping[str, Quantity]] = {
        **dict.fromkeys(("times", "sigma"), "time"),
        **dict.fromkeys(("x0", "d"), "displacement"),
        **dict.fromkeys(("v0", "V"), "velocity"),
    }

    def __post_init__(self) -> None:
        """Check every number."""
        times = _ascending("times", self.times)
        if not len(times):
            raise ValueError("times is empty: at least one time is needed.")
        _refuse("times", times, times < 0.0, "events come after the start, at times >= 0")
        one_of("kind", self.kind, KINDS)
        start = _start(self)
        if start["x0"] is None and start["d"] is None:
            raise ValueError(
                "times of events do not tell where a motion starts: give x0= and v0=, "
                "or d=, with free_start=True if they are guesses"
            )
        block = whole_number("block", self.block)
        self._store(
            times=times, block=block, sigma=_sigma("sigma", self.sigma, len(times)), **start
        )


@suggests
@part
@dataclass(frozen=True, eq=False)
class MapPoints(_Measured):
    """Points of an event map: differences in global stick phases, each with that in the next.

    Parameters
    ----------
    d : array_like of float, shape (n,)
        ``X_2 - X_1`` in a global stick phase.
    value : array_like of float, shape (n,)
        That of the next one.
    sigma : float or array_like of float, optional
        Standard error of `value`, as in `Record`.

    Raises
    ------
    ValueError
        What is not allowed, by name.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.examples.coulomb()
    >>> d = [-0.3, -0.1, 0.1, 0.3]
    >>> fit = ss.fit(model.replace(mu=0.2), ss.MapPoints(d, ss.event_map(model)(d)), ["mu"])
    >>> fit.values.round(9)
    array([0.22])
    """

    d: Any
    value: Any
    sigma: Any = None
    _axes: ClassVar = ("d", "value")
    _quantities: ClassVar[Mapping[str, Quantity]] = dict.fromkeys(
        ("d", "value", "sigma"), "displacement"
    )

    def __post_init__(self) -> None:
        """Check every number."""
        pairs = _pairs(self, *self._axes)
        self._store(**pairs, sigma=_sigma("sigma", self.sigma, len(pairs["d"])))


@suggests
@part
@dataclass(frozen=True, eq=False)
class ForcePoints(_Measured):
    """Kinetic friction against slip speed, measured on one contact.

    Parameters
    ----------
    speed : array_like of float, shape (n,)
        Slip speeds >= 0, in the model's units.
    force : array_like of float, shape (n,)
        Friction over the static limit of the contact.
    sigma : float or array_like of float, optional
        Standard error of `force`, as in `Record`.
    block : int
        Contact, counted from 1.
    forward : bool
        The slip is forward.

    Raises
    ------
    ValueError
        What is not allowed, by name.
    """

    speed: Any
    force: Any
    sigma: Any = None
    block: int = 1
    forward: bool = False
    _axes: ClassVar = ("speed", "force")
    _quantities: ClassVar[Mapping[str, Quantity]] = {
        "speed": "velocity",
        **dict.fromkeys(("force", "sigma"), "force"),
    }

    def __post_init__(self) -> None:
        """Check every number."""
        pairs = _pairs(self, *self._axes)
        _refuse("speed", pairs["speed"], pairs["speed"] < 0.0, "slip speeds are >= 0")
        block, forward = whole_number("block", self.block), flag("forward", self.forward)
        sigma = _sigma("sigma", self.sigma, len(pairs["speed"]))
        self._store(**pairs, sigma=sigma, block=block, forward=forward)


@suggests
@part
@dataclass(frozen=True, eq=False)
class CyclePeriods(_Measured):
    """Periods of stick-slip at some speeds of the belt.

    Parameters
    ----------
    V : array_like of float, shape (n,)
        Speeds of the belt.
    period : array_like of float, shape (n,)
        Of the steady motion there, > 0.
    sigma : float or array_like of float, optional
        Standard error of `period`, as in `Record`.

    Raises
    ------
    ValueError
        What is not allowed, by name.

    Notes
    -----
    The cycle of a model is the one that a motion from rest comes to.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.4))
    >>> seen = ss.CyclePeriods(V=[0.1, 0.2], period=[13.536383773, 8.902605408])
    >>> ss.fit(block, seen, ["mu"]).values.round(9)
    array([0.5])
    """

    V: Any
    period: Any
    sigma: Any = None
    _axes: ClassVar = ("V", "period")
    _quantities: ClassVar[Mapping[str, Quantity]] = {
        "V": "velocity",
        **dict.fromkeys(("period", "sigma"), "time"),
    }

    def __post_init__(self) -> None:
        """Check every number."""
        pairs = _pairs(self, *self._axes)
        _refuse("period", pairs["period"], pairs["period"] <= 0.0, "periods are > 0")
        self._store(**pairs, sigma=_sigma("sigma", self.sigma, len(pairs["V"])))


Data: TypeAlias = Record | EventTimes | MapPoints | ForcePoints | CyclePeriods


def compared(
    data: Data, fitted: NDArray[Any]
) -> Iterator[tuple[str, Floats, Floats, NDArray[Any], Floats]]:
    """Yield what was measured, over what, in its order; what a model gives; standard errors."""
    _, at = data.abscissa
    order, end = np.argsort(at, kind="stable"), 0
    for name, values, sigma in data.rows:
        begin, end = end, end + values.size
        model = fitted[begin:end].reshape(values.shape)
        yield name, at[order], values[order], model[order], sigma[order]


def series(name: str, values: object) -> Floats:
    """Return numbers in a row; ValueError names the first that is not finite."""
    array = real_numbers(name, values)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}: numbers in a row are needed.")
    return _finite(name, array)


def _ascending(name: str, values: object) -> Floats:
    times = series(name, values)
    if not (after := np.diff(times) > 0.0).all():
        k = int(np.argmin(after))
        raise ValueError(
            f"{name}[{k + 1}] = {times[k + 1]:.6g} does not come after {name}[{k}] = "
            f"{times[k]:.6g}: times must ascend. Sort them, and leave out repeated times."
        )
    return times


def _refuse(name: str, array: Floats, bad: NDArray[np.bool_], why: str) -> None:
    """ValueError that names the first of the numbers that are not allowed."""
    if bad.any():
        place = np.argwhere(bad)[0].tolist()
        at = place[:1] if array.shape[-1] == 1 else place
        told = ", ".join(map(str, at))
        raise ValueError(f"{name}[{told}] = {array[tuple(place)]:.6g}: {why}")


def columns(
    name: str, values: object, n: int, what: str = "times", *, may_miss: bool = False
) -> Floats:
    """Return n rows of numbers, one row per time; NaN where one may be missing."""
    given = real_numbers(name, values)
    array = given[:, None] if given.ndim == 1 else given
    if array.ndim != 2 or array.shape[0] != n or not array.shape[1]:
        raise ValueError(
            f"{name} has the shape {given.shape}, and there are {n} {what}: ({n},) or "
            f"({n}, blocks) is needed."
        )
    return _finite(name, array, may_miss=may_miss)


def _finite(name: str, array: Floats, *, may_miss: bool = False) -> Floats:
    allowed = np.abs(array) <= LARGEST
    bad = np.argwhere(~(allowed | np.isnan(array)) if may_miss else ~allowed)
    if len(bad):
        where = ", ".join(map(str, bad[0]))
        size = f", at most {LARGEST:g} in size" * bool(np.isfinite(array[tuple(bad[0])]))
        raise ValueError(
            f"{name}[{where}] = {array[tuple(bad[0])]} is not a finite number{size} ({len(bad)} of "
            f"{array.size} are not). "
            + ("NaN stands for what is missing." if may_miss else "Leave such rows out.")
        )
    return array


def _pairs(data: Any, first: str, second: str) -> dict[str, Floats]:
    pair = {name: series(name, getattr(data, name)) for name in (first, second)}
    if len(pair[first]) != len(pair[second]) or not len(pair[first]):
        raise ValueError(
            f"{first} and {second} hold {len(pair[first])} and {len(pair[second])} numbers: as "
            "many are needed, and at least one."
        )
    return pair


def _sigma(
    name: str, value: object, n: int, k: int = 1, of: Floats | None = None
) -> float | Floats | None:
    """Check a standard error, or those of n rows of k numbers, missing where these are."""
    if value is None:
        return None
    if not np.iterable(value):
        return finite_number(name, value, above=0.0)
    each = columns(name, value, n, "rows", may_miss=of is not None)
    if each.shape[1] not in (1, k):
        raise ValueError(f"{name} has {each.shape[1]} columns: 1, or as many as the data, {k}.")
    if of is not None:
        missing = np.isnan(of)
        needed = ~(missing if each.shape[1] == k else missing.all(axis=1, keepdims=True))
        _finite(name, np.where(needed, each, 1.0))
    _refuse(name, each, each <= 0.0, "standard errors are > 0")
    return each


def _errors(sigma: float | Floats | None, values: Floats) -> Floats:
    """Return standard errors of values, in their shape."""
    return np.broadcast_to(guessed(values) if sigma is None else sigma, values.shape)


def _start(data: Any) -> dict[str, Any]:
    """Check where a motion starts, a state, a global stick phase or nothing, and its belt."""
    x0, v0, d = data.x0, data.v0, data.d
    if (x0 is None) != (v0 is None) or (d is not None and x0 is not None):
        raise ValueError("give both x0= and v0=, or d= alone, or none of them")
    free = flag("free_start", data.free_start) or (x0 is None and d is None)
    one = {"x0": x0, "v0": v0, "d": d}
    checked = {
        name: None if value is None else series(name, np.atleast_1d(real_numbers(name, value)))
        for name, value in one.items()
    }
    V = None if data.V is None else finite_number("V", data.V)
    return {**checked, "free_start": free, "V": V}


def under_conditions(data: Data, model: Model) -> Model:
    """Return a model with the values that data have of their own."""
    return model.replace(**data.conditions) if data.conditions else model


def weighed(data: Data, factor: float) -> Data:
    """Return data with errors, given or guessed, times a factor."""
    names = {"x": "sigma", "v": "sigma_v"}
    errors: dict[str, Any] = {
        names.get(name, "sigma"): factor * sigma for name, _, sigma in data.rows
    }
    return replace(data, **errors)


def guessed(values: Floats) -> float:
    """Hundredth of the scatter of values: a weight where no standard error is given."""
    known = [column[np.isfinite(column)] for column in values.T]
    spread = max((float(np.std(each)) for each in known if len(each) and np.ptp(each)), default=0.0)
    return 0.01 * (spread or float(np.abs(np.concatenate(known)).max(initial=0.0)) or 1.0)
