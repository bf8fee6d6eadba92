"""What a distribution of parameters means for a quantity, draw by draw."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.checks import instance, one_of, parameter_name, real_numbers, shown, whole_number
from stickslip.identification.data import series
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.results.table import free_name
from stickslip.sweeps.job import LARGEST_SEED, POINTS_PER_TILE, Points
from stickslip.sweeps.observables import as_observable, check_needs
from stickslip.sweeps.system import rows
from stickslip.sweeps.systems import as_system
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.numerics.arrays import Floats
    from stickslip.sweeps.job import Observable
    from stickslip.sweeps.system import System

LEVELS = (0.025, 0.975)
# What quantities raise that a model does not have: no cycle, no such member of an empty tuple.
ABSENT = (ValueError, IndexError, ArithmeticError)


@dataclass(frozen=True, eq=False, repr=False)
class Propagated(Result):
    """A quantity for draws of parameters; `propagate` makes it.

    Attributes
    ----------
    draws : dict of str to ndarray, shape (n,)
        Values of each parameter.
    values : ndarray, shape (n, ...)
        The quantity, NaN for draws that have none.
    absent : dict of str to int
        Why draws have none, an example of each kind of error, and how many they are.
    """

    draws: dict[str, Floats]
    values: Floats
    absent: dict[str, int]
    _plot: ClassVar = "identification.plot_propagated"

    @property
    def value(self) -> Any:
        """Median of the draws that have the quantity, a float or an array."""
        found = np.median(self._known, axis=0)
        return float(found) if found.ndim == 0 else found

    @property
    def interval(self) -> Floats:
        """Where 95 per cent of the draws that have the quantity lie, shape (2, ...)."""
        return np.asarray(np.quantile(self._known, LEVELS, axis=0))

    @property
    def absent_share(self) -> float:
        """Share of draws that have no such quantity."""
        return sum(self.absent.values()) / len(self.values)

    @property
    def _known(self) -> Floats:
        return self.values[_is_known(self.values)]

    def __repr__(self) -> str:
        """Headline: median and interval; what is absent."""
        median, low, high = (_in_short(each) for each in (self.value, *self.interval))
        lines = [f"Propagated: median {median}, 95 per cent in ({low}, {high})"]
        of = f"of {len(self.values)} draws have none"
        lines += [f"  {count} {of}: {why}" for why, count in self.absent.items()]
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        draws = {free_name(name, {"quantity"}): drawn for name, drawn in self.draws.items()}
        return {**draws, "quantity": list(self.values)}


def _in_short(value: Any) -> str:
    return np.array2string(np.asarray(value), precision=6, threshold=8, separator=", ")


@waits
@suggests
def propagate(
    system: Any,
    draws: Mapping[str, ArrayLike],
    quantity: Callable[[Any], Any] | Observable | str,
    *,
    variable: str | None = None,
    rng: int = 0,
) -> Propagated:
    """Carry a distribution of parameters to a quantity of a model.

    Where linear theory (`Fit.predict`) does not hold: thresholds at folds, shares of basins, cycles
    that vanish.

    Parameters
    ----------
    system : TwoBlock, Blocks, Chain, Oscillator, Structure, an event map or PiecewiseMap
        Its parameters hold where none are drawn.
    draws : mapping of str to array_like, shape (n,)
        Values of parameters: ``fitted.sample(1000)`` of a `Fit`, or drawn by NumPy from any
        distribution.
    quantity : callable, or one of `stickslip.observables`, or the name of one
        A function that takes `system` with other parameters and returns a float or an array of one
        shape. An observable follows the orbits of all draws at once.
    variable : str, optional
        Of an observable; without it the first that it records.
    rng : int
        Of an observable: what starting points of orbits are drawn from.

    Returns
    -------
    Propagated

    Raises
    ------
    ValueError
        An unknown parameter or observable; draws that are not equally many; values of different
        shapes; no draw that has the quantity.

    Notes
    -----
    A draw has no such quantity where its parameters are not allowed, where `quantity` raises
    ValueError (as `find_cycle` does), IndexError or ArithmeticError, or returns NaN.

    Examples
    --------
    >>> import numpy as np, stickslip as ss
    >>> block = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=1.4)
    >>> damping = np.random.default_rng(1).normal(1.4, 0.2, size=50)
    >>> found = ss.propagate(
    ...     block, {"damping": damping}, lambda model: ss.equilibria(model)[0].hopf_points[0].V
    ... )
    >>> round(found.value, 2), found.absent_share
    (0.05, 0.04)
    """
    checked = as_system(system)
    columns = _columns(system, draws)
    if callable(quantity) and not isinstance(quantity, type):
        if variable is not None:
            what = f"quantity = {shown(quantity)} is a function"
            raise ValueError(f"{what}, and has no variable {shown(variable)}")
        found, why = _one_by_one(system, columns, quantity)
    else:
        seed = whole_number("rng", rng, 0, at_most=LARGEST_SEED - 1)
        found, why = _at_once(system, checked, columns, quantity, variable, seed)
    size = len(next(iter(columns.values())))
    if len(shapes := {value.shape for value in found.values()}) > 1:
        raise ValueError(f"quantity = {shown(quantity)} has several shapes: {sorted(shapes)}")
    values = np.full((size, *(shapes.pop() if shapes else ())), np.nan)
    for place, value in found.items():
        values[place] = value
    known = _is_known(values)
    why += [("NaN", "NaN")] * (size - len(why) - int(known.sum()))
    if not known.any():
        raise ValueError(f"quantity = {shown(quantity)}: no draw has it. {why[0][1]}")
    examples = {kind: told for kind, told in reversed(why)}
    return Propagated(columns, values, dict(Counter(examples[kind] for kind, _ in why)))


def _columns(system: Any, draws: Any) -> dict[str, Floats]:
    given = instance("draws", draws, Mapping, "values by name of a parameter")
    found = {
        parameter_name("draws", name, system.parameters): series(f"draws[{name!r}]", values)
        for name, values in given.items()
    }
    sizes = {len(column) for column in found.values()}
    if len(sizes) != 1 or 0 in sizes:
        raise ValueError("draws: parameters are needed, with equally many values, at least one")
    return found


def _one_by_one(
    system: Any, columns: Mapping[str, Floats], function: Callable[[Any], Any]
) -> tuple[dict[int, Floats], list[tuple[str, str]]]:
    """Values by place of the draw, and the kind of error and its message where there is none."""
    found, why = {}, []
    for place, row in enumerate(rows(columns, len(next(iter(columns.values()))))):
        try:
            value = function(system.replace(**row))
        except ABSENT as error:
            kind = type(error).__name__
            why.append((kind, f"{kind}: {error}"))
            continue
        found[place] = real_numbers("quantity(model)", value)
    return found, why


def _at_once(
    system: Any, checked: System, columns: Mapping[str, Floats], given: Any, name: Any, seed: int
) -> tuple[dict[int, Floats], list[tuple[str, str]]]:
    """As `_one_by_one`, of an observable for all draws that are allowed."""
    observable = as_observable("quantity", given)
    check_needs(checked, [observable])
    names = [output.name for output in observable.outputs()]
    name = names[0] if name is None else one_of("variable", name, names)
    legal, why = _one_by_one(system, columns, lambda _: 0.0)
    places = np.array(list(legal), dtype=np.uint64)
    found: dict[int, Floats] = {}
    for begin in range(0, len(places), POINTS_PER_TILE["cpu"]):
        some = places[begin : begin + POINTS_PER_TILE["cpu"]]
        drawn = {each: column[some] for each, column in columns.items()}
        points = Points(checked, drawn, None, some, seed, observable.runs())
        values = observable.compute(points)[name].astype(np.float64)
        found |= dict(zip(some.tolist(), values, strict=True))
    return found, why


def _is_known(values: Floats) -> NDArray[np.bool_]:
    """Whether a draw has the quantity."""
    return np.asarray(~np.isnan(values).reshape(len(values), -1).any(axis=1))
