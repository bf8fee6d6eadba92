"""Attractors of a map of the line: found from many seeds, accepted only on evidence.

Seeds are the one-sided values at breakpoints and turning points, which in a map of the line find
every attractor that folds or jumps make, and dozens of others. Their orbits are followed in
blocks of growing length. After each block an orbit may have left the map's domain, been captured
by a known attractor, or settled on a cycle that Newton's method confirms. What is still moving
then is examined for chaos:

* its exponent must exceed zero by several error bars;
* a short interval around it must grow into bands that the map does not leave, so that the
  motion is no transient;
* no stable cycle may hide behind its contracting passages.

Whatever meets neither description is reported as undecided, with the reason.
"""

from __future__ import annotations

import importlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final, Literal, overload

import numpy as np

from stickslip.analysis.lyapunov import LyapunovExponent, advance, shaken, trace
from stickslip.analysis.one_d.bands import Bands, grow, inside
from stickslip.analysis.one_d.chaos import ChaoticMotion, mean_of_logs, short_interval
from stickslip.analysis.one_d.table import branch_table
from stickslip.analysis.protocol import checked_points, domain_width, sample
from stickslip.analysis.recurrence import (
    SAME_POINT,
    Cycle,
    as_orbit,
    capture_radius,
    confirmed,
    hidden_cycles,
    recurrences,
    settled,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from stickslip.analysis.one_d.laps import Laps
    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import Floats, Map1D

Kind = Literal["periodic", "chaotic", "undecided"]

N_SEEDS: Final = 64
MAX_PERIOD: Final = 64
MAX_STEPS: Final = 20_000
FIRST_BLOCK: Final = 256
GROWTH: Final = 4  # each block of steps is this many times longer than the one before
SETTLED: Final = 1e-6  # of the domain's width: a recurrence this close proposes a period
SIGMAS: Final = 5  # error bars by which a chaotic exponent must exceed zero
TRAPPED: Final = 1e-9  # of the domain's width: how well bands must reproduce themselves
LOOK: Final = 2048  # steps of one orbit to start an examination from
CREEPING: Final = 0.02  # of the domain's width: recurrence and way left on a slow approach
CELLS: Final = 256  # of the domain: undecided orbits that share half of theirs are one
LAST_PERIODS: Final = 1024  # periods tried on an orbit that nothing else explains


@dataclass(frozen=True, eq=False, repr=False)
class Attractor:
    """A set that orbits of a map settle on.

    Attributes
    ----------
    kind : {"periodic", "chaotic", "undecided"}
        See `attractors` for the evidence behind each.
    period : int
        Points of a cycle; for chaos, the number of sets of bands visited in turn; 0 if unknown.
    orbit : PeriodicOrbit or None
        The cycle, for a periodic attractor (or the neutral one behind an undecided one).
    bands : ndarray (k, 2)
        Intervals that hold the attractor, from left to right. Those of a cycle have no width.
    edges : tuple of str
        For chaos, what each edge of the bands is an image of, in the order ``bands.ravel()``.
    lyapunov : LyapunovExponent
        Mean of log |f'| per step, and its standard error.
    basin_share : float
        Share of the seeds spread over the domain that end here: an estimate with a standard
        error of about ``sqrt(share (1 - share) / n_seeds)``. `basins` gives the exact one.
    point : float
        A point on or near the attractor.
    reason : str
        Why the attractor is undecided; empty otherwise.
    """

    kind: Kind
    period: int
    orbit: PeriodicOrbit | None
    bands: Floats
    lyapunov: LyapunovExponent
    basin_share: float
    point: float
    edges: tuple[str, ...] = ()
    reason: str = ""

    def contains(self, x: ArrayLike, slack: float = 0.0) -> Any:
        """Tell which points lie in the bands, within `slack`."""
        return inside(self.bands, np.asarray(x, dtype=np.float64), slack)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the bands as a strip."""
        axes: Axes = _plot("basins").draw_bands([self], ax)
        return axes

    def __repr__(self) -> str:
        """Short table."""
        return f"Attractor({self._row()})"

    def _row(self) -> str:
        where = ", ".join(f"[{low:.8g}, {high:.8g}]" for low, high in self.bands[:4])
        if self.kind == "periodic" and self.orbit is not None:
            where = ", ".join(f"{x:.10g}" for x in self.orbit.points[:4])
        more = " ..." if len(self.bands) > 4 else ""
        value, error = self.lyapunov
        text = f"{self.kind:9}  period {self.period:<3d}  exponent {value:.6g} ± {error:.1g}"
        text += f"  share {self.basin_share:.3f}  {where}{more}"
        return f"{text}  ({self.reason})" if self.reason else text


@dataclass(frozen=True, eq=False, repr=False)
class AttractorList(Sequence[Attractor]):
    """Attractors of a map, largest basin first, and the seeds that reached none.

    Attributes
    ----------
    attractors : tuple of Attractor
        What was found; also reached by indexing and iteration.
    left : float
        Share of the seeds spread over the domain whose orbits leave it or fall into a gap.
    statuses : dict
        How many seeds left, by the status that the map gave at their last point.
    n_seeds : int
        Seeds spread over the domain, which the shares refer to.
    resolution : str
        What the search would miss.
    """

    attractors: tuple[Attractor, ...]
    left: float
    statuses: dict[int, int]
    n_seeds: int
    resolution: str

    def __len__(self) -> int:
        """Count."""
        return len(self.attractors)

    @overload
    def __getitem__(self, index: int) -> Attractor: ...
    @overload
    def __getitem__(self, index: slice) -> tuple[Attractor, ...]: ...
    def __getitem__(self, index: int | slice) -> Attractor | tuple[Attractor, ...]:
        """One attractor, or several."""
        return self.attractors[index]

    def __repr__(self) -> str:
        """Short table."""
        rows = [f"AttractorList: {len(self)} from {self.n_seeds} seeds, {self.left:.3f} left"]
        return "\n".join([*rows, *(f"  {a._row()}" for a in self)])

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the bands of all attractors as strips."""
        axes: Axes = _plot("basins").draw_bands(self.attractors, ax)
        return axes


def _plot(name: str) -> Any:
    return importlib.import_module(f"stickslip.plot.{name}")


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
    for name, count in (("n_seeds", n_seeds), ("max_period", max_period), ("max_steps", max_steps)):
        if count < 1:
            raise ValueError(f"{name} = {count} must be at least 1")
    table = branch_table(f).laps
    if seeds is None:
        spread = _spread(f, n_seeds, rng)
        ends = np.concatenate([table.value_left, table.value_right])
        start = np.concatenate([spread, _inside_domain(f, np.unique(ends))])
    else:
        spread = start = np.atleast_1d(checked_points(f.domain, seeds)).ravel()
    search = _Search(f, table, max_period, max_steps)
    for orbit in known:
        if orbit.stable and (cycle := confirmed(f, np.asarray(orbit.points))):
            search.add_cycle(cycle)
    search.run(start)
    return search.result(len(spread))


def _spread(f: Map1D, n: int, rng: np.random.Generator | int | None) -> Floats:
    """One random point in each of n equal cells: even cover without landing on special points."""
    generator = np.random.default_rng(0 if rng is None else rng)
    low, high = f.domain
    return np.asarray(low + (high - low) * (np.arange(n) + generator.random(n)) / n)


def _inside_domain(f: Map1D, x: Floats) -> Floats:
    low, high = f.domain
    return x[np.isfinite(x) & (x >= low) & (x <= high)]


@dataclass
class _Known:
    """An attractor found so far, and how to recognise orbits that it has captured."""

    attractor: Attractor
    cycle: Cycle | None = None
    radius: float = 0.0
    recurring: float = 0.0

    def captures(self, tails: Floats) -> Any:
        if self.attractor.kind == "chaotic":
            return self.attractor.contains(tails[:, -1])
        if self.cycle is None:
            return np.zeros(len(tails), dtype=np.bool_)
        near = np.abs(tails[:, -self.cycle.period :] - self.cycle.points[0])
        caught = np.any(near <= self.radius, axis=1)
        if not self.cycle.stable:
            # Neutral cycles come in continua; a multiplier of -1 doubles its neighbours.
            back = tails[:, -1] - tails[:, -1 - 2 * self.cycle.period]
            caught |= np.abs(back) <= self.recurring
        return caught


@dataclass
class _Search:
    """State of a search: seeds still moving, and what has been found."""

    f: Map1D
    table: Laps
    max_period: int
    max_steps: int
    known: list[_Known] = field(default_factory=list)
    fate: Any = None  # index of the attractor, -1 undecided, -2 left; one per seed
    statuses: dict[int, int] = field(default_factory=dict)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))

    def run(self, start: Floats) -> None:
        self.fate = np.full(len(start), -1)
        moving, x = np.arange(len(start)), start
        done, block, reason = 0, FIRST_BLOCK, ""
        while moving.size and done < self.max_steps:
            steps = min(block, self.max_steps - done)
            tails = advance(self.f, x, steps)
            done, block = done + steps, block * GROWTH
            moving, tails = self._drop_left(moving, tails)
            moving, tails = self._drop_captured(moving, tails)
            moving, tails = self._settle(moving, tails)
            if moving.size:
                reason = self._examine(float(shaken(self.f, tails[:1, -1], self.rng)[0]))
                moving, tails = self._drop_captured(moving, tails)
            x = shaken(self.f, tails[:, -1], self.rng) if moving.size else tails[:, -1]
        if moving.size:
            self._give_up(moving, tails, reason)

    def _drop_left(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        gone = ~np.isfinite(tails[:, -1])
        self.fate[moving[gone]] = -2
        for tail in tails[gone]:
            code = int(sample(self.f, tail[np.isfinite(tail)][-1:]).status[0])
            self.statuses[code] = self.statuses.get(code, 0) + 1
        return moving[~gone], tails[~gone]

    def _drop_captured(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        for index, item in enumerate(self.known):
            if not moving.size:
                break
            caught = item.captures(tails)
            self.fate[moving[caught]] = index
            moving, tails = moving[~caught], tails[~caught]
        return moving, tails

    def _settle(self, moving: Any, tails: Floats) -> tuple[Any, Floats]:
        """Confirm cycles that orbits have settled on, one at a time; each captures its likes."""
        if not moving.size:
            return moving, tails
        change = recurrences(tails, self.max_period) <= SETTLED * domain_width(self.f)
        tried = np.zeros(len(moving), dtype=np.bool_)
        while np.any(candidates := change.any(axis=1) & ~tried):
            k = int(np.argmax(candidates))
            tried[k] = True
            cycle = settled(self.f, tails[k], int(np.argmax(change[k])) + 1)
            if cycle is None or not cycle.stable:
                continue
            index = self.add_cycle(cycle)
            caught = self.known[index].captures(tails)
            caught[k] = True
            self.fate[moving[caught]] = index
            keep = ~caught
            moving, tails = moving[keep], tails[keep]
            change, tried = change[keep], tried[keep]
        return moving, tails

    def add_cycle(self, cycle: Cycle, kind: Kind = "periodic", reason: str = "") -> int:
        """Add a cycle unless it is known; return its place in the list."""
        tolerance = SAME_POINT * domain_width(self.f)
        for index, item in enumerate(self.known):
            if item.cycle is not None and cycle.matches(item.cycle, tolerance):
                return index
        points = np.sort(cycle.points)
        attractor = Attractor(
            kind=kind,
            period=cycle.period,
            orbit=as_orbit(self.f, cycle),
            bands=np.column_stack([points, points]),
            lyapunov=_cycle_exponent(cycle),
            basin_share=0.0,
            point=float(cycle.points[0]),
            reason=reason,
        )
        # An orbit that creeps along a neutral cycle may come no closer in any time we have.
        near = CREEPING * domain_width(self.f)
        radius = capture_radius(self.f, cycle) if cycle.stable else near
        recurring = SETTLED * domain_width(self.f)
        self.known.append(_Known(attractor, cycle, radius, recurring))
        return len(self.known) - 1

    def _examine(self, x: float) -> str:
        """Decide whether the orbit of `x` is chaotic; add the attractor, or say why it is not."""
        values, slopes = trace(self.f, np.array([x]), LOOK)
        if not np.all(np.isfinite(values)):
            return "a long transient: a nearby orbit leaves the domain"
        rough = mean_of_logs(slopes)
        if rough.value <= SIGMAS * rough.error and (cycle := _crept_along(self.f, values[0])):
            self.add_cycle(cycle, *_verdict(cycle))
            return ""
        if rough.value <= 0:
            return f"the exponent {rough.value:.3g} ± {rough.error:.1g} is not above zero"
        bands = grow(self.f, self.table, short_interval(self.f, values[0]))
        if reason := self._why_no_trap(bands):
            return reason
        motion = ChaoticMotion(self.f, bands.intervals)
        return motion.reason or self._why_not_chaotic(bands, motion)

    def _why_no_trap(self, bands: Bands) -> str:
        if bands.reason:
            return bands.reason
        if bands.residual > TRAPPED * domain_width(self.f):
            return f"the map misses the bands it should fill by {bands.residual:.1e}"
        return ""

    def _why_not_chaotic(self, bands: Bands, motion: ChaoticMotion) -> str:
        cycles = hidden_cycles(self.f, motion.values, motion.slopes, self.max_period)
        for cycle in cycles:
            self.add_cycle(cycle)
            if np.any(bands.contain(cycle.points)):
                return f"a stable cycle of period {cycle.period} hides in the bands"
        value, error = motion.exponent
        if value <= SIGMAS * error:
            return f"the exponent {value:.3g} ± {error:.1g} is not above zero"
        point = float(motion.values[0, -1])
        self.known.append(_Known(_chaotic(bands, motion.exponent, point)))
        return ""

    def _give_up(self, moving: Any, tails: Floats, reason: str) -> None:
        """Group what is left by the cells it visits, and look behind each group for a cycle."""
        groups: list[tuple[set[int], int]] = []
        for seed, tail in zip(moving, tails, strict=True):
            place = (tail - self.f.domain[0]) / domain_width(self.f)
            cells = {int(cell) for cell in np.floor(CELLS * place)}
            index = next((k for c, k in groups if len(c & cells) > 0.5 * len(cells)), -1)
            if index < 0:
                if cycle := _crept_along(self.f, tail):
                    index = self.add_cycle(cycle, *_verdict(cycle))
                else:
                    self.known.append(_Known(_undecided(self.f, tail, reason)))
                    index = len(self.known) - 1
                groups.append((cells, index))
            self.fate[seed] = index

    def result(self, n_spread: int) -> AttractorList:
        fates = self.fate[:n_spread]
        shares = [float(np.mean(fates == k)) for k in range(len(self.known))]
        found = [
            replace(item.attractor, basin_share=share)
            for item, share in zip(self.known, shares, strict=True)
        ]
        return AttractorList(
            attractors=tuple(sorted(found, key=lambda a: (-a.basin_share, a.point))),
            left=float(np.mean(fates == -2)),
            statuses=dict(sorted(self.statuses.items())),
            n_seeds=n_spread,
            resolution=(
                f"basins that hold none of {len(self.fate)} seeds; "
                f"cycles longer than {self.max_period}"
            ),
        )


def _cycle_exponent(cycle: Cycle) -> LyapunovExponent:
    with np.errstate(divide="ignore"):
        value = float(np.log(np.abs(cycle.multiplier))) / cycle.period
    doubt = 1e-15 / abs(cycle.multiplier) if cycle.multiplier else 0.0
    return LyapunovExponent(value, doubt, cycle.period)


def _chaotic(bands: Bands, exponent: LyapunovExponent, point: float) -> Attractor:
    return Attractor(
        kind="chaotic",
        period=bands.period,
        orbit=None,
        bands=bands.intervals,
        lyapunov=exponent,
        basin_share=0.0,
        point=point,
        edges=bands.causes,
    )


def _undecided(f: Map1D, tail: Floats, reason: str) -> Attractor:
    points = np.sort(tail[len(tail) // 2 :])
    slopes = sample(f, tail[None, len(tail) // 2 : -1]).derivative
    return Attractor(
        kind="undecided",
        period=0,
        orbit=None,
        bands=np.array([[points[0], points[-1]]]),
        lyapunov=mean_of_logs(slopes),
        basin_share=0.0,
        point=float(tail[-1]),
        reason=reason or f"neither settled nor examined within {len(tail)} steps",
    )


def _crept_along(f: Map1D, tail: Floats) -> Cycle | None:
    """Find the cycle that an orbit approaches too slowly to have settled on it."""
    change = recurrences(tail[None, :], LAST_PERIODS)[0]
    # Short periods first: a multiple of the period recurs more closely than the period itself.
    for period in np.flatnonzero(change <= CREEPING * domain_width(f)) + 1:
        cycle = confirmed(f, tail[-period:], moved=CREEPING)
        if cycle is not None and (cycle.stable or cycle.neutral):
            return cycle
    return None


def _verdict(cycle: Cycle) -> tuple[Kind, str]:
    if cycle.stable:
        return "periodic", ""
    return "undecided", (
        f"the multiplier {cycle.multiplier:.9g} of a period-{cycle.period} orbit is too close "
        "to the unit circle"
    )
