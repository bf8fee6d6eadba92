"""What a sweep records at each grid point: small named objects with fixed shapes and types.

Each is a frozen set of settings; `Points` does the work that several of them share. A new one is
a class here with `recorded` and `compute`, listed in `OBSERVABLES`.

>>> import stickslip as ss
>>> ss.observables.OrbitPoints(n=100, transient=1000)
OrbitPoints(transient=1000, n=100, max_period=256, count=16)
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.checks import MOST_STEPS, dimensions, instance, shown, whole_number
from stickslip.numerics.long_run import CHAOTIC, LEFT, PERIODIC, UNDECIDED
from stickslip.status import NEVER_CYCLE, NEVER_SLIPPING
from stickslip.sweeps.identity import function_identity, import_function
from stickslip.sweeps.job import Columns, Observable, Output, whole
from stickslip.sweeps.several_starts import CoexistingAttractors, LimitCycles
from stickslip.sweeps.system import Run
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.sweeps.job import Points
    from stickslip.sweeps.system import System

__all__ = [
    "Attractor",
    "CoexistingAttractors",
    "Events",
    "Function",
    "LimitCycles",
    "LyapunovExponent",
    "NeverReturns",
    "Observable",
    "OrbitPoints",
    "Output",
    "as_observables",
]

LABEL: Final = r"(?!__)\w[\w -]*|"  # zarr keeps names that begin with __
KINDS: Final = {UNDECIDED: "undecided", LEFT: "left", PERIODIC: "periodic", CHAOTIC: "chaotic"}


@dataclass(frozen=True, kw_only=True)
class _OfOrbit(Observable):
    """An observable of one orbit for each grid point."""

    needs: ClassVar[tuple[str, ...]] = ("orbits",)
    transient: int = whole(1000, least=0, most=MOST_STEPS)
    n: int = whole(1000, least=2)
    max_period: int = whole(256)

    @property
    def _run(self) -> Run:
        return Run(1, self.transient, self.n, self.max_period)

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed."""
        return {self._run: 1}


@dataclass(frozen=True, kw_only=True)
class Attractor(_OfOrbit):
    """Kind and period of what the orbit settles on.

    Parameters
    ----------
    transient, n : int
        Maps applied before the stretch that is looked at, and its length.
    max_period : int
        Longest period that is recognised; it must fit into `n` twice.

    Notes
    -----
    *Periodic*: points and itineraries repeat over ten periods and at least 256 steps, to 1e-9 of
    the domain, with a multiplier inside the unit circle. *Chaotic*: no repetition, and an
    exponent above zero by five standard errors. *Left*: some step has no value, for the reason in
    ``status``. Everything else is *undecided*. `stickslip.attractors` proves more, for one map.
    """

    name: ClassVar[str] = "attractor"
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("kind", "int8", "kind of attractor", flags=KINDS),
        Output("period", "int32", "period of the attractor, 0 if not periodic"),
        Output("status", "int8", "why the orbit ended, 0 if it did not"),
    )

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        found = points.orbits(self._run)
        return {
            "kind": found.verdicts.kind,
            "period": found.verdicts.period,
            "status": found.followed.status,
        }


@dataclass(frozen=True, kw_only=True)
class LyapunovExponent(_OfOrbit):
    r"""Mean of log \|f'\| per step along the orbit, and its standard error.

    Parameters as in `Attractor`. Of a cycle the mean is over one period and the error 0; else the
    error is from the scatter of sixteen batches.
    """

    name: ClassVar[str] = "lyapunov_exponent"
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("lyapunov_exponent", "float64", "Lyapunov exponent per step of the map"),
        Output("lyapunov_error", "float64", "standard error of the Lyapunov exponent"),
    )

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        found = points.orbits(self._run).verdicts
        return {"lyapunov_exponent": found.exponent, "lyapunov_error": found.error}


@dataclass(frozen=True, kw_only=True)
class OrbitPoints(_OfOrbit):
    """The last points of the orbit.

    Parameters
    ----------
    count : int
        Number of points, at most ``n + 1``.
    transient, n, max_period : int
        As in `Attractor`.
    """

    name: ClassVar[str] = "orbit_points"
    needs: ClassVar[tuple[str, ...]] = ("orbits", "line")
    count: int = whole(16)

    def __post_init__(self) -> None:
        """Check the numbers, and that the stretch is long enough."""
        super().__post_init__()
        if self.count > self.n + 1:
            raise ValueError(
                f"count = {self.count} of {self.name}: at most n + 1 = {self.n + 1} points."
            )

    def outputs(self) -> tuple[Output, ...]:
        """Return the variables that are recorded."""
        title = "points of the orbit, the last one last"
        return (Output("orbit", "float64", title, ("iterate",), (self.count,)),)

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed."""
        return {self._run: self.count}

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        return {"orbit": points.orbits(self._run).followed.tail[:, -self.count :]}


@dataclass(frozen=True, kw_only=True)
class Events(_OfOrbit):
    """Changes of mode and time between two global stick phases, along the orbit.

    Parameters as in `Attractor`; for models only.
    """

    name: ClassVar[str] = "events"
    needs: ClassVar[tuple[str, ...]] = ("orbits", "events")
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("mean_events", "float64", "mean number of events per step of the map"),
        Output("most_events", "int32", "largest number of events in a step of the map"),
        Output("mean_duration", "float64", "mean time per step of the map, in sqrt(m / k)"),
    )

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        found = points.orbits(self._run).followed
        return {
            "mean_events": found.mean_events,
            "most_events": found.most_events.astype(np.int32),
            "mean_duration": found.mean_duration,
        }


@dataclass(frozen=True, kw_only=True)
class NeverReturns(Observable):
    """Share of starting points whose motion at last never returns to global stick.

    Parameters
    ----------
    n_starts : int
        Starting points, one at random in each of as many equal cells of the domain.
    n : int
        Returns after which a motion counts as one that returns.
    """

    name: ClassVar[str] = "never_returns"
    needs: ClassVar[tuple[str, ...]] = ("orbits", "events")
    recorded: ClassVar[tuple[Output, ...]] = (
        Output("never_share", "float64", "share that never returns to global stick"),
        Output("gave_up_share", "float64", "share that was given up, at a limit or undecided"),
    )
    n_starts: int = whole(64)
    n: int = whole(100, least=2)

    @property
    def _run(self) -> Run:
        return Run(self.n_starts, 0, self.n, 1)

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed."""
        return {self._run: 1}

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        found = points.orbits(self._run)
        status = found.followed.status.reshape(points.size, self.n_starts)
        never = np.isin(status, (NEVER_SLIPPING, NEVER_CYCLE))
        return {
            "never_share": never.mean(axis=1),
            "gave_up_share": ((status != 0) & ~never).mean(axis=1),
        }


@dataclass(frozen=True, kw_only=True)
class Function(Observable):
    """A function of the user's own, ``function(f, d)``, of the map and a starting point.

    Of more than two blocks ``d`` is an array; where there is no event map (one block, forced
    models), ``f`` is the model and ``d`` NaN.

    Parameters
    ----------
    function : callable or str
        A function of a module, or its name, ``"module:function"``. Its name and its source text
        are part of the description of the sweep.
    label : str, optional
        Name of the variable; by default the function's.
    dtype : str
        Type of what it returns, such as ``"float64"`` or ``"int32"``.
    shape : tuple of int
        Shape of what it returns; () for a number.
    """

    name: ClassVar[str] = "function"
    function: Callable[..., Any] | str
    label: str = ""
    dtype: str = "float64"
    shape: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Import the function, and check that another process can import it."""
        if isinstance(self.function, str):
            object.__setattr__(self, "function", import_function(self.function))
        function: Any = self.function
        place = f"{getattr(function, '__module__', '')}:{getattr(function, '__qualname__', '')}"
        is_named = callable(function) and hasattr(function, "__qualname__")
        if not is_named or "<" in place or place.startswith("__main__"):
            raise ValueError(
                f"function = {shown(function)}: a function that other processes can import is "
                "needed, one of a module and neither a lambda nor one made inside another function."
            )
        try:
            is_number = np.dtype(self.dtype).kind in "biuf"
        except (TypeError, ValueError, RecursionError):
            is_number = False
        if not is_number:
            raise ValueError(f"dtype = {shown(self.dtype)}: a type of numbers is needed.")
        if not re.fullmatch(LABEL, instance("label", self.label, str, "text")):
            raise ValueError(
                f"label = {shown(self.label)}: a name of letters, digits, _, - and blanks is "
                "needed, which begins with no blank or -: it names a folder of the store."
            )
        if dimensions(self.shape) != 1:
            raise ValueError(f"shape = {shown(self.shape)} is not a tuple of whole numbers.")
        sizes = self.shape
        shape = tuple(whole_number(f"shape[{i}]", size) for i, size in enumerate(sizes))
        object.__setattr__(self, "shape", shape)
        object.__setattr__(self, "label", self.label or function.__qualname__.split(".")[-1])

    def outputs(self) -> tuple[Output, ...]:
        """Return the variables that are recorded."""
        dims = tuple(f"{self.label}_{k}" for k in range(len(self.shape)))
        return (Output(self.label, self.dtype, self.label, dims, self.shape),)

    def compute(self, points: Points) -> Columns:
        """Return the values of the variables."""
        assert callable(self.function)
        result = np.empty((points.size, *self.shape), dtype=self.dtype)
        for i, (f, d) in enumerate(points.maps()):
            result[i] = self._declared(self.function(f, d))
        return {self.label: result}

    def _declared(self, value: Any) -> NDArray[Any]:
        """Return what the function gave as the type and shape that were declared."""
        given = np.asarray(value)
        if given.shape != self.shape:  # else NumPy would repeat it
            raise ValueError(
                f"{self.label} = {shown(value)} has the shape {given.shape}: shape = {self.shape} "
                "was declared. Declare the shape of what the function returns."
            )
        with np.errstate(invalid="ignore", over="ignore"):
            stored = given.astype(self.dtype)
        if stored.dtype.kind != "f" and (stored != given).any():
            raise ValueError(
                f"{self.label} = {shown(value)} is no {self.dtype}, which was declared: that would "
                f"store {shown(stored.tolist())}. Declare a dtype that holds what the function "
                "returns."
            )
        return stored

    def identity(self) -> dict[str, Any]:
        """Describe the function by its source text."""
        assert callable(self.function)
        rest = {"label": self.label, "dtype": self.dtype, "shape": list(self.shape)}
        return {"name": self.name, **function_identity(self.function), **rest}


OBSERVABLES: Final[dict[str, type[Observable]]] = {
    each.name: each
    for each in (
        Attractor,
        LyapunovExponent,
        OrbitPoints,
        Events,
        CoexistingAttractors,
        NeverReturns,
        LimitCycles,
        Function,
    )
}
"""What plan files and `stickslip.sweep` know by name."""


def as_observables(given: Iterable[Observable | str]) -> tuple[Observable, ...]:
    """Read a list of observables; a name stands for one with its default settings."""
    if isinstance(given, str | Observable):
        given = [given]
    try:
        listed = tuple(given)
    except TypeError as reason:
        raise ValueError(
            f"observables = {shown(given)} is not a list of observables or of their names."
        ) from reason
    found = tuple(as_observable("observables", each) for each in listed)
    if not found:
        raise ValueError(
            f"observables = []: at least one is needed. Known: {', '.join(OBSERVABLES)}."
        )
    names = [output.name for each in found for output in each.outputs()]
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"observables: two of them record a variable {name!r}.")
    return found


def check_needs(system: System, observables: Iterable[Observable]) -> None:
    """ValueError where an observable asks for what a system lacks."""
    for each in observables:
        for need in each.needs:
            if need in system.lacks:
                raise ValueError(f"observable {each.name!r}: {system.lacks[need]}.")


def as_observable(role: str, given: Any) -> Observable:
    """Read an observable, or the name of one with its default settings."""
    if isinstance(given, Observable):
        return given
    if callable(given) and not isinstance(given, type):
        return Function(function=given)
    if not isinstance(given, str) or given not in OBSERVABLES or given == Function.name:
        hint = did_you_mean(given, [name for name in OBSERVABLES if name != Function.name])
        raise ValueError(f"{role}: {shown(given)} is unknown. {hint}")
    return OBSERVABLES[given]()
