"""How safe an attractor is, of one map or along a parameter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final, NamedTuple, TypeAlias

import numpy as np

from stickslip.analysis.attractors.attractor import (
    Attractor,
    AttractorList,
    AttractorListND,
    AttractorND,
)
from stickslip.analysis.attractors.attractors import MAX_STEPS, N_STARTS, attractors, checked_found
from stickslip.analysis.attractors.basins import basins
from stickslip.analysis.attractors.in_space.basins_nd import Estimate
from stickslip.analysis.attractors.in_space.fractions import Known, searched_along
from stickslip.analysis.maps.arguments import checked_parameter, line_family, line_map, map_of
from stickslip.analysis.maps.protocol import FamilyND, Floats, Map1D, MapFamily, MapND, Modelled
from stickslip.analysis.safety.kicks import Distribution, Escape, Impulse, escape, smallest_impulses
from stickslip.analysis.safety.surroundings import Displacement, LineSurroundings, SpaceSurroundings
from stickslip.analysis.work import Work
from stickslip.checks import (
    MOST_KEPT,
    finite_number,
    grid,
    one_of,
    random_generator,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.numerics.waiting import waits
from stickslip.results.parts import part
from stickslip.results.result import ResultList, ResultRow
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.safety.surroundings import Surroundings

LATE: Final = 0.95  # quantile of the times to settle


@part
class Settling(NamedTuple):
    """Steps until orbits that start all over a basin stay close to its attractor.

    Attributes
    ----------
    steps : ndarray of float
        Ascending, one for each start; infinite if it had not settled when it was given up.
    within : float
        How close: distance on a line; in R^n size of the cells about the attractor, of widths.
    """

    steps: np.ndarray[Any, np.dtype[np.float64]]
    within: float

    def quantile(self, share: float) -> Estimate:
        """Return the steps within which that share of the starts has settled, and their error.

        The error is half the distance of the order statistics one binomial deviation away.
        """
        share = finite_number("share", share, at_least=0.0, at_most=1.0)
        n = len(self.steps)
        if not n:
            return Estimate(math.nan, math.nan)
        spread = math.sqrt(n * share * (1.0 - share))
        places = np.array([share * n, share * n - spread, share * n + spread])
        value, low, high = self.steps[np.clip(places.astype(int), 0, n - 1)].tolist()
        return Estimate(value, 0.5 * (high - low) if math.isfinite(high) else math.inf)


@dataclass(frozen=True, eq=False, repr=False)
class Safety(ResultRow):
    """How safe an attractor is.

    Attributes
    ----------
    attractor : Attractor or AttractorND
    value : float
        Of the parameter, along one; else NaN.
    share : Estimate
        Part of the domain that is the basin, with its error: 0 where all of it is proved.
    displacement : Displacement
        The smallest one that leads to another basin.
    impulses : tuple of Impulse
        The smallest change of velocity of each block in both senses, of a model's event map.
    settling : Settling
    escape : Escape or None
        Escapes under random kicks, if these were asked for.
    """

    attractor: Attractor | AttractorND
    value: float
    share: Estimate
    displacement: Displacement
    impulses: tuple[Impulse, ...]
    settling: Settling
    escape: Escape | None
    _column_names: ClassVar = (
        *("value", "kind", "period", "share", "share_error", "displacement", "displacement_error"),
        *("into", "tested", "impulse", "impulse_error", "impulse_block", "time_constant"),
        *("settled_half", "settled_half_error", "settled_95", "settled_95_error", "worst"),
        *("escape_time", "escape_time_error", "escaped", "escaped_error"),
    )
    _plot: ClassVar = "safety.draw_safety"

    @property
    def impulse(self) -> Impulse | None:
        """The smallest of all impulses; None if none led away or none was tried."""
        known = [each for each in self.impulses if math.isfinite(each.by)]
        return min(known, key=lambda each: abs(each.by), default=None)

    @property
    def time_constant(self) -> float:
        """Steps in which a small disturbance falls to 1 / e, by the multiplier of a cycle."""
        exponent = float(self.attractor.lyapunov.value)
        return -1.0 / exponent if exponent < 0.0 else math.inf

    def __repr__(self) -> str:
        """Sentences."""
        near, blow = self.displacement, self.impulse
        where = f"at ({', '.join(f'{x:.8g}' for x in near.point)})"
        lines = [
            f"Safety of {self.attractor._line()}",
            f"  basin {self.share.value:.6f} ± {self.share.error:.1g} of the domain",
            f"  displacement {near.size:.8g} ± {near.error:.1g} {where} into {near.into}"
            + (f"; none of {near.tested} smaller ones tried" if near.tested else ""),
            f"  settled within {self.settling.within:.3g}: half after {_said(self.settling, 0.5)} "
            f"steps, {LATE:.0%} after {_said(self.settling, LATE)}; time constant "
            f"{self.time_constant:.4g}",
        ]
        if self.impulses:
            text = "none tried led away" if blow is None else f"{blow.by:.8g} of block {blow.block}"
            tested = sum(each.tested for each in self.impulses)
            lines.append(f"  change of velocity: {text}; {tested} tried led back")
        if self.escape is not None:
            time, share = self.escape.mean, self.escape.escaped
            lines.append(
                f"  {self.escape.distribution} kicks {self.escape.size}: escape after "
                f"{time.value:.6g} ± {time.error:.2g} steps; {share.value:.4f} ± {share.error:.1g} "
                f"of {self.escape.n_runs} within {self.escape.within}"
            )
        return "\n".join(lines)

    def _facts(self) -> tuple[Any, ...]:
        near, blow, out = self.displacement, self.impulse, self.escape
        nothing = Estimate(math.nan, math.nan)
        return (
            *(self.value, self.attractor.kind, self.attractor.period, *self.share),
            *(near.size, near.error, near.into, near.tested),
            *((blow.by, blow.error, blow.block) if blow else (math.nan, math.nan, 0)),
            *(self.time_constant, *self.settling.quantile(0.5), *self.settling.quantile(LATE)),
            float(self.settling.steps.max(initial=0.0)),
            *(out.mean if out else nothing),
            *(out.escaped if out else nothing),
        )


def _said(settling: Settling, share: float) -> str:
    value, error = settling.quantile(share)
    return f"{value:g} ± {error:.2g}"


@dataclass(frozen=True, eq=False, repr=False)
class SafetyList(ResultList[Safety]):
    """How safe an attractor is at values of a parameter, as far as it exists.

    Attributes
    ----------
    items : tuple of Safety
        Also reached by indexing and iteration.
    parameter : str
    lost : str
        Where the attractor was not found again, so that the list ends; empty if it was.
    """

    items: tuple[Safety, ...]
    parameter: str
    lost: str = ""
    _column_names: ClassVar = Safety._column_names
    _plot: ClassVar = "safety.draw_safeties"

    def __repr__(self) -> str:
        """Table."""
        head = f"SafetyList: {len(self)} values of {self.parameter}{'; ' * bool(self.lost)}"
        return f"{head}{self.lost}\n{self.table()}"


@waits
@suggests
def safety(
    system: Map1D | MapND | Modelled[Map1D] | Modelled[MapND],
    parameter: str | None = None,
    values: ArrayLike | None = None,
    *,
    attractor: int = 0,
    found: AttractorList | AttractorListND | None = None,
    kicks: ArrayLike = 0.0,
    distribution: Distribution = "normal",
    within: int = 1000,
    n_runs: int = 1000,
    n_samples: int = 4096,
    n_impulses: int = 32,
    tolerance: float = 1e-3,
    rng: np.random.Generator | int | None = None,
) -> Safety | SafetyList:
    """Tell how safe an attractor is: what carries a motion into another basin.

    Parameters
    ----------
    system : map or model
    parameter : str, optional
        A parameter to vary; `values` then is ``(lo, hi, n)`` or a list of numbers, along which
        the attractor is followed from the first on.
    values : array_like of float, optional
    attractor : int
        Its place in the list of `attractors`, at the first value.
    found : AttractorList or AttractorListND, optional
        That list; by default `attractors` searches for it. Not along a parameter.
    kicks : float or sequence of float
        Size of the random kicks that are added to the point after each step, of each coordinate:
        standard deviation, or half the width. None at 0.
    distribution : {"normal", "uniform"}
    within : int
        Steps after which a kicked run is given up.
    n_runs : int
        Runs with kicks, from points of the attractor.
    n_samples : int
        Starts all over the domain, for times to settle and shares in R^n; also displacements that
        are tried there at a time.
    n_impulses : int
        Sizes of impulses, 0.001 to 2 in units of f_s1 / sqrt(k m), that are tried on each block of
        a model; 0 for none.
    tolerance : float
        Share of the domain of a line within which an orbit counts as settled.
    rng : Generator or int, optional
        For kicks and displacements that are tried; by default fixed, so that results repeat.

    Returns
    -------
    Safety, or SafetyList along a parameter

    Raises
    ------
    ValueError
        No such attractor, parameter or distribution, or a number outside its range.

    Notes
    -----
    On a line shares and displacements are exact, from the intervals of `basins`. In R^n they are
    estimates: a share has a binomial error, a displacement is the smallest found, and the result
    says how many smaller ones were tried in vain. Impulses are tried on a ladder of sizes, and
    bisected: what lies between two rungs stays unseen. docs/theory/safety.md.

    Examples
    --------
    >>> import stickslip as ss
    >>> cubic = ss.PiecewiseMap(lambda x, r: r * x - x**3, (-1.6, 1.6), parameters={"r": 1.5})
    >>> safe = ss.safety(cubic)
    >>> round(safe.displacement.size, 6), safe.displacement.into
    (0.517638, 1)
    """
    sizes = real_numbers("kicks", kicks)
    if not (np.isfinite(sizes) & (sizes >= 0.0)).all():
        raise ValueError(f"kicks = {shown(kicks)} is not allowed: sizes are finite, 0 or more.")
    one_of("distribution", distribution, ("normal", "uniform"))
    within = whole_number("within", within, at_most=MOST_KEPT)
    n_runs = whole_number("n_runs", n_runs, at_most=MOST_KEPT)
    n_samples = whole_number("n_samples", n_samples, at_most=MOST_KEPT)
    n_impulses = whole_number("n_impulses", n_impulses, 0, at_most=MOST_KEPT)
    tolerance = finite_number("tolerance", tolerance, above=0.0, at_most=1.0)
    generator = random_generator("rng", 0 if rng is None else rng)
    number = whole_number("attractor", attractor, 0, at_most=MOST_KEPT)
    found_map = map_of(system)
    f = found_map if isinstance(found_map, MapND) else line_map(system, "system")
    if (parameter is None) != (values is None):
        raise ValueError("give both a parameter and its values, or neither of them")
    dimension = f.dimension if isinstance(f, MapND) else 1
    if sizes.shape not in ((), (dimension,)):
        raise ValueError(f"kicks = {shown(kicks)}: give one size, or {dimension}.")

    def measured(near: Surroundings, value: float = math.nan) -> Safety:
        share, (steps, close) = near.share(n_samples), near.settling(n_samples, tolerance)
        size = np.broadcast_to(sizes, near.points.shape[1:])
        kicked = size, distribution, within, n_runs, generator
        return Safety(
            attractor=near.attractor,
            value=value,
            share=share,
            displacement=near.displacement(n_samples, generator),
            impulses=smallest_impulses(near, n_impulses),
            settling=Settling(np.sort(steps), close),
            escape=escape(near, *kicked) if size.any() else None,
        )

    if parameter is None:
        listed: Any = attractors(f) if found is None else checked_found(f, found)
        _check_number(number, len(listed))
        if isinstance(f, MapND):
            return measured(SpaceSurroundings(f, listed, number))
        return measured(LineSurroundings(f, basins(f, listed), number))
    if found is not None:
        raise ValueError("found is of one map: along a parameter attractors are searched for.")
    wanted_values = grid("values", values)
    along = _along_space if isinstance(f, MapND) else _along_line
    items, lost = list[Safety](), ""
    for value, numbers, near in along(f, parameter, wanted_values):
        if not items:
            _check_number(number, len(numbers))
        if number not in numbers:
            lost = f"the attractor is not found again at {parameter} = {value:.12g}"
            break
        items.append(measured(near(numbers.index(number)), value))
    return SafetyList(tuple(items), parameter, lost)


def _check_number(number: int, n: int) -> None:
    if number >= n:
        raise ValueError(f"attractor = {number}: {n} attractors were found, numbered from 0.")


# A value, the numbers of the attractors there, and the surroundings of each.
Found: TypeAlias = "tuple[float, tuple[int, ...], Callable[[int], Surroundings]]"


def _along_line(f: Any, parameter: str, values: Floats) -> Iterator[Found]:
    """Find attractors again at each value, by the rule of R^n."""
    family: MapFamily = line_family(f)
    checked_parameter(family, parameter)
    known = Known()
    for value in values.tolist():
        at = family.replace(**{parameter: value})
        listed = attractors(at)
        found = basins(at, listed)
        near = [LineSurroundings(at, found, k) for k in range(len(listed))]
        numbers = known.again(at, 1.0, [each.points for each in near], partial(_places, near))
        yield value, numbers, near.__getitem__


def _places(near: list[LineSurroundings], x: Floats) -> NDArray[np.integer[Any]]:
    return near[0].fate(x)  # all of them know all basins


def _along_space(f: Any, parameter: str, values: Floats) -> Iterator[Found]:
    """Find attractors again at each value: points of each come to the one that it is."""
    if not isinstance(f, FamilyND):
        raise ValueError(f"system = {shown(f)} has no parameters to vary.")
    checked_parameter(f, parameter)
    along = searched_along(f, parameter, values, N_STARTS, MAX_STEPS, Work())
    for value, (at, listed, numbers, _) in zip(values.tolist(), along, strict=True):
        yield value, numbers, partial(SpaceSurroundings, at, listed)
