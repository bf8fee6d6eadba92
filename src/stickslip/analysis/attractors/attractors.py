"""Attractors of a map of the line: found from many seeds, accepted only on evidence."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, Final, overload

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorList, AttractorListND
from stickslip.analysis.attractors.bands import LONGEST
from stickslip.analysis.attractors.in_space.search_nd import search_attractors, seeds
from stickslip.analysis.attractors.recurrence import attracts, confirmed
from stickslip.analysis.attractors.search import AttractorSearch
from stickslip.analysis.branches.table import BranchTable, branch_table
from stickslip.analysis.interpolation.interpolated import interpolated_map
from stickslip.analysis.maps.arguments import line_map, map_of, not_for
from stickslip.analysis.maps.protocol import Floats, Map1D, MapND, Modelled, checked_points
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.scales import RECOGNISED
from stickslip.analysis.work import Work
from stickslip.checks import (
    MOST_KEPT,
    MOST_STEPS,
    check_callback,
    flag,
    instance,
    random_generator,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.numerics.waiting import waits
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.branches.laps import Laps

N_STARTS: Final = 64
MAX_PERIOD: Final = RECOGNISED  # of cycles that are recognised
MAX_STEPS: Final = 20_000  # after which a motion counts as undecided


@overload
def attractors(
    f: Map1D | Modelled[Map1D],
    *,
    starts: ArrayLike | None = ...,
    rng: np.random.Generator | int | None = ...,
    n_starts: int = ...,
    max_period: int = ...,
    max_steps: int = ...,
    known: Iterable[PeriodicOrbit] = ...,
    interpolate: bool = ...,
    features: None = ...,
    progress: Callable[[float], None] | None = ...,
    partial: bool = ...,
) -> AttractorList: ...
@overload
def attractors(
    f: MapND | Modelled[MapND],
    *,
    starts: ArrayLike | None = ...,
    n_starts: int = ...,
    max_period: int = ...,
    max_steps: int = ...,
    features: Callable[[Floats], Any] | None = ...,
    progress: Callable[[float], None] | None = ...,
    partial: bool = ...,
) -> AttractorListND: ...
@waits
@suggests
def attractors(
    f: Map1D | MapND | Modelled[Map1D] | Modelled[MapND],
    *,
    starts: ArrayLike | None = None,
    rng: np.random.Generator | int | None = None,
    n_starts: int = N_STARTS,
    max_period: int = MAX_PERIOD,
    max_steps: int = MAX_STEPS,
    known: Iterable[PeriodicOrbit] = (),
    interpolate: bool = True,
    features: Callable[[Floats], Any] | None = None,
    progress: Callable[[float], None] | None = None,
    partial: bool = False,
) -> AttractorList | AttractorListND:
    """Find the attractors of a map.

    Parameters
    ----------
    f : map or model
        Of the line: an event map, a `PiecewiseMap`, or anything else that offers `domain` and
        `evaluate`. Of R^n: a `Map`, the event map of a chain, a return or stroboscopic map.
    starts : array_like of float, optional
        Starting points, of R^n (m, n). By default the one-sided values at all breakpoints and
        turning points and `n_starts` points spread over the domain, one at random in each of
        equal cells; of R^n points of a Sobol sequence.
    rng : Generator or int, optional
        For the spread seeds; by default a fixed one, so that results repeat.
    n_starts : int
        Spread seeds.
    max_period : int
        Longest cycle that is recognised.
    max_steps : int
        Steps after which an orbit counts as undecided.
    known : iterable of PeriodicOrbit
        Orbits known from elsewhere, as from `periodic_orbits`. The stable ones are attractors
        even if no seed reaches them.
    interpolate : bool
        Whether orbits may be followed on the interpolated table of the map instead of the map
        itself; see Notes. `rng`, `known` and `interpolate` are for maps of the line.
    features : callable, optional
        Of R^n: ``features(points)`` of an orbit (k, n), a number or several; orbits are then told
        apart by these instead of by where they come back to.
    progress : callable, optional
        Called now and then with the share of the work that is done, 0 to 1.
    partial : bool
        Whether Ctrl-C returns what has been found so far; ``unfollowed`` counts the seeds
        that were left out.

    Returns
    -------
    AttractorList, or AttractorListND of a map of R^n
        Coexisting attractors, largest share of seeds first.

    Raises
    ------
    ValueError
        A seed outside the domain, or a count below 1.

    Notes
    -----
    *Periodic*: values recur and labels repeat over ten periods, Newton's method starts and ends
    in the same word and hardly moves, the period is minimal and the multiplier lies inside the
    unit circle by more than 1e-5. *Chaotic*: the exponent exceeds zero by five error bars, a
    short interval grows into bands that map into themselves to 1e-9 of the domain, and no stable
    cycle up to `max_period` is found behind the orbit's contracting passages. *Neutral*: f^p(x) = x
    all over an interval wider than a thousandth of the domain. Everything else is *undecided*, with
    a reason.

    Orbits are followed on the map's table of branches, interpolated so that values err by less
    than 1e-9 of their range (`interpolated_map`): a hundredfold gain for a slow map. What they
    show is confirmed on the map itself: cycles are solved on it, and the edges of chaotic bands
    are its images and must trap it. The exponent of a chaotic motion is that of the
    interpolation; its error includes the difference of both maps' slopes along the motion. Where
    the table cannot be interpolated so well, or the map does not confirm a finding, the whole
    search is repeated on the map.

    An attractor that no seed reaches stays unseen, unless a stable cycle in `known` points to it.

    In R^n *periodic*: Newton's method ends next to the orbit, and all multipliers lie inside the
    unit circle. Other sets: later points of an orbit come as close to earlier ones as these to
    each other; an orbit that comes as close to a known set is on it. *Chaotic*: the largest
    exponent exceeds zero by five error bars. *Quasiperiodic*: a tangent grows no more than e^20
    all along. Results say how well orbits recur (docs/theory/attractors.md).

    Examples
    --------
    >>> import stickslip as ss
    >>> [(found.kind, found.period) for found in ss.attractors(ss.examples.coulomb())]
    [('periodic', 4), ('periodic', 1)]
    """
    n_starts = whole_number("n_starts", n_starts, at_most=MOST_KEPT)
    max_period = whole_number("max_period", max_period, at_most=MOST_KEPT)
    max_steps = whole_number("max_steps", max_steps, at_most=MOST_STEPS)
    fast, work = flag("interpolate", interpolate), Work(progress, partial)
    orbits = _orbits(known)
    check_callback("features", features, "an orbit's points (k, n)")
    if starts is not None and not real_numbers("starts", starts).size:
        raise ValueError(f"starts = {shown(starts)} is empty: at least one point is needed.")
    if isinstance(space := map_of(f), MapND):
        not_for("a line", known=bool(orbits), rng=rng is not None)
        x, widths = seeds(space, starts, n_starts)
        return search_attractors(space, x, widths, max_period, max_steps, features, work)
    f = line_map(f)
    not_for("R^n", features=features is not None)
    table = branch_table(f)
    if starts is None:
        spread, start = _seeds(f, table.laps, n_starts, rng)
    else:
        spread = start = np.atleast_1d(checked_points(f.domain, starts, "starts")).ravel()
    limits = {"max_period": max_period, "max_steps": max_steps}
    followed = None if fast else f
    return attractors_of(f, table, orbits, (spread, start), work, fast=followed, **limits)


def attractors_of(
    f: Map1D,
    table: BranchTable,
    orbits: Iterable[PeriodicOrbit] = (),
    starts: tuple[Floats, Floats] | None = None,
    work: Work | None = None,
    /,
    *,
    max_period: int = LONGEST,
    max_steps: int = MAX_STEPS,
    fast: Any = None,
) -> AttractorList:
    """Find the attractors of a map whose table is at hand, stable known ``orbits`` included.

    On the interpolated table if it is good enough and proves right, else on the map.
    """
    spread, start = _seeds(f, table.laps, N_STARTS, None) if starts is None else starts
    work = Work() if work is None else work
    fast = interpolated_map(table) if fast is None else fast
    stable = [confirmed(f, orbit.points) for orbit in orbits if orbit.stable]
    for followed in (f,) if fast is f or not np.isfinite(fast.error) else (fast, f):
        search = AttractorSearch(f, table, max_period, max_steps, followed)
        for cycle in stable:
            if cycle is not None and attracts(f, cycle):
                search.add_cycle(cycle)
        search.run(start, work)
        if not search.doubts or work.interrupted:
            break
    return search.result(len(spread))


def _orbits(known: Iterable[PeriodicOrbit]) -> tuple[PeriodicOrbit, ...]:
    what = "as from ss.periodic_orbits(f)"
    try:
        listed = tuple(known)
    except TypeError as reason:
        raise ValueError(f"known = {shown(known)} is not a list of orbits, {what}.") from reason
    return tuple(
        instance(f"known[{i}]", orbit, PeriodicOrbit, f"an orbit, {what}")
        for i, orbit in enumerate(listed)
    )


def checked_found(f: Map1D | MapND, found: Any) -> Any:
    """Return the attractors of a map that a caller was given, or say what was given instead."""
    kind: Any = AttractorListND if isinstance(f, MapND) else AttractorList
    return instance("found", found, kind, "the result of ss.attractors(f) for this map")


def _seeds(
    f: Map1D, laps: Laps, n_starts: int, rng: np.random.Generator | int | None
) -> tuple[Floats, Floats]:
    """Points spread over the domain; the same and the one-sided values at all ends of laps."""
    spread = spread_points(f, n_starts, rng)
    ends = np.concatenate([laps.value_left, laps.value_right])
    low, high = f.domain
    ends = np.unique(ends[np.isfinite(ends) & (ends >= low) & (ends <= high)])
    return spread, np.concatenate([spread, ends])


def spread_points(f: Map1D, n: int, rng: np.random.Generator | int | None) -> Floats:
    """One random point in each of n equal cells: even cover without landing on special points."""
    generator = random_generator("rng", 0 if rng is None else rng)
    low, high = f.domain
    return np.asarray(low + (high - low) * (np.arange(n) + generator.random(n)) / n)
