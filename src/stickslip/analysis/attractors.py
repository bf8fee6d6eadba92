"""Attractors of a map of the line: found from many seeds, accepted only on evidence.

Seeds are the one-sided values at breakpoints and turning points, which in a map of the line find
every attractor that folds or jumps make, and dozens of others. What becomes of their orbits is
decided in `attractor_search`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.attractor import Attractor, AttractorList
from stickslip.analysis.attractor_search import AttractorSearch
from stickslip.analysis.one_d.interpolated import interpolated_map
from stickslip.analysis.one_d.table import branch_table
from stickslip.analysis.protocol import checked_points
from stickslip.analysis.recurrence import confirmed

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.one_d.laps import Laps
    from stickslip.analysis.one_d.table import BranchTable
    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import Floats, Map1D

__all__ = ["Attractor", "AttractorList", "attractors", "attractors_of"]

N_SEEDS: Final = 64
MAX_PERIOD: Final = 64
LONGEST: Final = 128  # period that `attractors_of` recognises: there it costs next to nothing
MAX_STEPS: Final = 20_000


def attractors(
    f: Map1D,
    *,
    seeds: ArrayLike | None = None,
    rng: np.random.Generator | int | None = None,
    n_seeds: int = N_SEEDS,
    max_period: int = MAX_PERIOD,
    max_steps: int = MAX_STEPS,
    known: Iterable[PeriodicOrbit] = (),
) -> AttractorList:
    """Find the attractors of a map of the line.

    Parameters
    ----------
    f : map of the line
        An event map, a `PiecewiseMap`, or anything else that offers `domain` and `evaluate`.
    seeds : array_like of float, optional
        Starting points. By default the one-sided values at all breakpoints and turning points
        and `n_seeds` points spread over the domain, one at random in each of equal cells.
    rng : Generator or int, optional
        For the spread seeds; by default a fixed one, so that results repeat.
    n_seeds : int
        Spread seeds.
    max_period : int
        Longest cycle that is recognised.
    max_steps : int
        Steps after which an orbit counts as undecided.
    known : iterable of PeriodicOrbit
        Orbits known from elsewhere, as from `periodic_orbits`. The stable ones are attractors
        even if no seed reaches them.

    Returns
    -------
    AttractorList
        Coexisting attractors, largest share of seeds first.

    Raises
    ------
    ValueError
        A seed outside the domain, or a count below 1.

    Notes
    -----
    *Periodic*: values recur and labels repeat over ten periods, Newton's method starts and ends
    in the same word and hardly moves, the period is minimal and the multiplier lies inside the
    unit circle by more than 1e-6. *Chaotic*: the exponent exceeds zero by five error bars, a
    short interval grows into bands that map into themselves to 1e-9 of the domain, and no stable
    cycle up to `max_period` is found behind the orbit's contracting passages. Everything else is
    *undecided*, with a reason.

    An attractor that no seed reaches stays unseen, unless a stable cycle in `known` points to it.
    """
    _check_counts(n_seeds, max_period, max_steps)
    laps = branch_table(f).laps
    if seeds is None:
        spread, start = _seeds(f, laps, n_seeds, rng)
    else:
        spread = start = np.atleast_1d(checked_points(f.domain, seeds)).ravel()
    search = AttractorSearch(f, laps, max_period, max_steps)
    return _found(search, start, len(spread), known)


def attractors_of(
    f: Map1D,
    table: BranchTable | None = None,
    orbits: Iterable[PeriodicOrbit] = (),
    *,
    n_seeds: int = N_SEEDS,
    max_period: int = LONGEST,
    max_steps: int = MAX_STEPS,
) -> AttractorList:
    """Find the attractors of a map whose table is made, with few evaluations of the map.

    Parameters
    ----------
    f : Map1D
    table : BranchTable, optional
        Of `f`; made if it is not given.
    orbits : iterable of PeriodicOrbit
        Orbits known from elsewhere. The stable ones are attractors even if no seed reaches
        them.
    n_seeds, max_period, max_steps
        As in `attractors`.

    Returns
    -------
    AttractorList
        As from `attractors`, on the same evidence.

    Notes
    -----
    Orbits are followed on the interpolated table (`interpolated_map`). What they show is
    confirmed on the map itself: cycles are solved on it, the edges of chaotic bands are its
    images and the bands trap it; the exponent of a chaotic motion is that of the
    interpolation, and its error includes the difference of both maps' slopes along it. Where
    the interpolation cannot be made or its findings are not confirmed, orbits are followed on
    the map.
    """
    table = branch_table(f) if table is None else table
    _check_counts(n_seeds, max_period, max_steps)
    spread, start = _seeds(f, table.laps, n_seeds, None)
    fast = interpolated_map(table)
    if np.isfinite(fast.error):
        search = AttractorSearch(f, table.laps, max_period, max_steps, fast)
        found = _found(search, start, len(spread), orbits)
        if not search.doubts:
            return found
    return attractors(f, n_seeds=n_seeds, max_period=max_period, max_steps=max_steps, known=orbits)


def _check_counts(n_seeds: int, max_period: int, max_steps: int) -> None:
    for name, count in (("n_seeds", n_seeds), ("max_period", max_period), ("max_steps", max_steps)):
        if count < 1:
            raise ValueError(f"{name} = {count} must be at least 1")


def _found(
    search: AttractorSearch, start: Floats, n_spread: int, known: Iterable[PeriodicOrbit]
) -> AttractorList:
    for orbit in known:
        if orbit.stable and (cycle := confirmed(search.f, np.asarray(orbit.points))):
            search.add_cycle(cycle)
    search.run(start)
    return search.result(n_spread)


def _seeds(
    f: Map1D, laps: Laps, n_seeds: int, rng: np.random.Generator | int | None
) -> tuple[Floats, Floats]:
    """Points spread over the domain; the same and the one-sided values at all ends of laps."""
    spread = _spread(f, n_seeds, rng)
    ends = np.concatenate([laps.value_left, laps.value_right])
    return spread, np.concatenate([spread, _inside_domain(f, np.unique(ends))])


def _spread(f: Map1D, n: int, rng: np.random.Generator | int | None) -> Floats:
    """One random point in each of n equal cells: even cover without landing on special points."""
    generator = np.random.default_rng(0 if rng is None else rng)
    low, high = f.domain
    return np.asarray(low + (high - low) * (np.arange(n) + generator.random(n)) / n)


def _inside_domain(f: Map1D, x: Floats) -> Floats:
    low, high = f.domain
    return x[np.isfinite(x) & (x >= low) & (x <= high)]
