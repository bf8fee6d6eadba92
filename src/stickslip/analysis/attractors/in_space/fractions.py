"""Shares of basins along a parameter, attractors known again from value to value."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.analysis.attractors.attractors import MAX_PERIOD
from stickslip.analysis.attractors.in_space.basins_nd import BasinsND, find_basins
from stickslip.analysis.attractors.in_space.fates import (
    LEFT,
    MOST_FOLLOWED,
    UNDECIDED,
    cells_of,
    fates,
)
from stickslip.analysis.attractors.in_space.search_nd import search_attractors, seeds
from stickslip.analysis.maps.arguments import checked_parameter, map_of
from stickslip.analysis.maps.protocol import FamilyND, Floats, Modelled, apart
from stickslip.analysis.scales import FEW
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, grid, shown, whole_number
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import ArrayLike, NDArray

    from stickslip.analysis.attractors.attractor import AttractorListND
    from stickslip.analysis.attractors.in_space.fates import Cells, Labels


@dataclass(frozen=True, eq=False, repr=False)
class BasinFractions(Result):
    """Shares of basins at values of a parameter.

    Attributes
    ----------
    parameter : str
    values : ndarray (m,)
    numbers : tuple of tuple of int
        For each value the numbers of its attractors, which keep theirs from value to value.
    basins : tuple of BasinsND
        At each value, by starts spread over the domain.

    Notes
    -----
    An attractor keeps its number if most of its points come to one at the next value, of several
    the one that lies closest to it; one that no known attractor comes to has a new number.
    """

    parameter: str
    values: np.ndarray[Any, np.dtype[np.float64]]
    numbers: tuple[tuple[int, ...], ...]
    basins: tuple[BasinsND, ...]
    _plot: ClassVar = "basins.draw_fractions"

    def share(self, number: int) -> np.ndarray[Any, np.dtype[np.float64]]:
        """Shares of an attractor (or of -1 undecided, -2 leaving) at all values; 0 without it."""
        last = max((n for known in self.numbers for n in known), default=UNDECIDED)
        number = whole_number("number", number, LEFT, at_most=last, what="of an attractor")
        shares = np.zeros(len(self.values))
        for i, (known, basins) in enumerate(zip(self.numbers, self.basins, strict=True)):
            if number in (LEFT, UNDECIDED, *known):
                k = number if number < 0 else known.index(number)
                shares[i] = basins.share(k).value
        return shares

    def __repr__(self) -> str:
        """Table of the shares."""
        low, high = self.values[0], self.values[-1]
        head = f"BasinFractions: {len(self.values)} values of {self.parameter} from {low:.8g} to "
        return f"{head}{high:.8g}\n{self.table()}"

    def _columns(self) -> dict[str, Any]:
        rows = []
        for value, known, basins in zip(self.values, self.numbers, self.basins, strict=True):
            rows += [(value, LEFT, "leaves", 0, *basins.share(LEFT))]
            rows += [(value, UNDECIDED, "undecided", 0, *basins.share(UNDECIDED))]
            for k, (number, one) in enumerate(zip(known, basins.attractors, strict=True)):
                rows.append((value, number, one.kind, one.period, *basins.share(k)))
        names = (self.parameter, "attractor", "kind", "period", "share", "error")
        return {name: [row[k] for row in rows] for k, name in enumerate(names)}


@waits
@suggests
def basin_fractions(
    system: FamilyND | Modelled[FamilyND],
    parameter: str,
    values: ArrayLike,
    *,
    n_samples: int = 1000,
    n_starts: int = 64,
    max_steps: int = 20_000,
    progress: Callable[[float], None] | None = None,
) -> BasinFractions:
    """Follow attractors of a map of R^n, and the shares of their basins, along a parameter.

    Parameters
    ----------
    system : Map, model or map of more than one dimension
    parameter : str
    values : (lo, hi, n) or list of float
    n_samples : int
        Starts spread over the domain, whose fates are counted at each value.
    n_starts : int
        Starts of the search for attractors at each value, beside points of those before.
    max_steps : int
        Steps after which an orbit counts as undecided.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.

    Returns
    -------
    BasinFractions

    Raises
    ------
    ValueError
        An unknown parameter, a map of the line (whose `basins` are exact) or without a domain.

    Examples
    --------
    >>> import stickslip as ss
    >>> plane = ss.Map(lambda z, r: z**3 - r * z, 2, parameters={"r": 0.5}, domain=[(-2, 2)] * 2)
    >>> ss.basin_fractions(plane, "r", [0.2, 0.6], n_samples=500).share(0).round(1)  # (1 + r) / 4
    array([0.3, 0.4])
    """
    f, work = map_of(system), Work(progress)
    if not isinstance(f, FamilyND):
        raise ValueError(
            f"system = {shown(system)} is no map of R^n with parameters. On a line take "
            "ss.basins(f).share(k) at each value, which is exact."
        )
    checked_parameter(f, parameter)
    n_samples = whole_number("n_samples", n_samples, at_most=MOST_KEPT)
    n_starts = whole_number("n_starts", n_starts, at_most=MOST_KEPT)
    max_steps = whole_number("max_steps", max_steps, at_most=MOST_FOLLOWED)
    wanted = grid("values", values)
    numbers, found = [], []
    for at, listed, known, rest in searched_along(f, parameter, wanted, n_starts, max_steps, work):
        found.append(find_basins(at, listed, None, n_samples, max_steps, rest))
        numbers.append(known)
    work.tell(1.0)
    return BasinFractions(parameter, wanted, tuple(numbers), tuple(found))


def searched_along(
    f: FamilyND, parameter: str, values: Floats, n_starts: int, max_steps: int, work: Work
) -> Iterator[tuple[FamilyND, AttractorListND, tuple[int, ...], Work]]:
    """At each value the map, its attractors, their numbers, which they keep, and work left."""
    known = Known()
    for i, value in enumerate(values.tolist()):
        here = work.part(i / len(values), (i + 1) / len(values))
        f = f.replace(**{parameter: value})
        x, widths = seeds(f, None, n_starts)
        handed = [points[-1:] for points in known.points.values()]
        x = np.concatenate([x, *(point for point in handed if f.contains(point).all())])
        listed = search_attractors(f, x, widths, MAX_PERIOD, max_steps, None, here.part(0.0, 0.5))
        points = [attractor.points for attractor in listed]
        comes = partial(_places, f, cells_of(f, listed), max_steps)
        yield f, listed, known.again(f, widths, points, comes), here.part(0.5, 1.0)


def _places(f: FamilyND, cells: Cells | None, max_steps: int, x: Floats) -> Labels:
    return fates(f, x, cells, max_steps)[0]


class Known:
    """Attractors at the last value of a parameter, which keep their numbers at the next."""

    def __init__(self) -> None:
        self.points: dict[int, Floats] = {}  # by number
        self.new = itertools.count()

    def again(
        self,
        f: Any,
        widths: Floats | float,
        now: Sequence[Floats],
        comes: Callable[[Floats], NDArray[np.integer[Any]]],
    ) -> tuple[int, ...]:
        """Return numbers of attractors of given points: each that of the closest that comes to it.

        `comes` tells the place of the attractor that each of some points (m, n) comes to.
        """
        claims = []
        for number, points in self.points.items() if now else ():
            fate = comes(points[-FEW:])
            counts = np.bincount(fate[fate >= 0], minlength=len(now))
            if 2 * counts.max() > len(fate):
                k = int(counts.argmax())
                off = _away(f, widths, points[-FEW:], now[k])
                off += _away(f, widths, now[k][-FEW:], points)
                claims.append((off, number, k))
        known = {k: number for _, number, k in sorted(claims, reverse=True)}
        numbers = tuple(known[k] if k in known else next(self.new) for k in range(len(now)))
        self.points = dict(zip(numbers, now, strict=True))
        return numbers


def _away(f: Any, widths: Floats | float, points: Floats, others: Floats) -> float:
    """How far points are from the nearest others, in the mean, in widths."""
    distances = np.abs(apart(f, points[:, None], others)) / widths
    return float(distances.max(axis=2).min(axis=1).mean())
