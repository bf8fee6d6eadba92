"""Periodic orbits that other orbits settle on: recurrence of values, then Newton, then stability.

Recurring labels or values prove nothing: a slow passage near a fold has both.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.attractors.bands import merged
from stickslip.analysis.attractors.lyapunov import SAMPLES
from stickslip.analysis.maps.protocol import SAME, advance, domain_width, sample
from stickslip.analysis.orbits.newton import padded, polish_on
from stickslip.analysis.orbits.orbit import PeriodicOrbit, orbit_of
from stickslip.analysis.scales import (
    BLOCK,
    CLOSE,
    HALF_DIGITS,
    IN_A_ROW,
    NEARBY,
    ON_THE_WAY,
    PASSING,
)
from stickslip.numerics.arrays import EPS
from stickslip.numerics.zeros import halved

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.branches.table import BranchTable
    from stickslip.analysis.maps.protocol import Bools, Floats, Labels, Map1D

SETTLED: Final = CLOSE  # of the domain's width: a recurrence this close proposes a period ...
RECURRING: Final = ON_THE_WAY  # ... and so close on a slow approach
NEUTRAL: Final = 1e-5  # multipliers this close to the unit circle decide nothing
TRIES: Final = 3  # passages near a hidden cycle that are tried for each period
TRUST_RADIUS: Final = 4.0  # times what a cycle may have moved: steps on the way to it stay within
ROUNDING: Final = 64 * EPS
LOOKED_AT: Final = 1024  # points on the way to an end of the domain


@dataclass(frozen=True, eq=False)
class Cycle:
    """A periodic orbit that Newton's method confirmed, in the order of visits."""

    points: Floats
    multiplier: float  # slope of f^p along the orbit
    labels: Labels
    residual: float  # largest ``|f(x_i) - x_(i+1)|``

    @property
    def period(self) -> int:
        """Number of points."""
        return len(self.points)

    @property
    def exponent(self) -> float:
        """Mean of log |f'| along the orbit."""
        with np.errstate(divide="ignore"):
            return float(np.log(np.abs(self.multiplier))) / self.period

    @property
    def stable(self) -> bool:
        """Whether the multiplier lies inside the unit circle by more than its uncertainty."""
        return abs(self.multiplier) < 1 - NEUTRAL

    @property
    def neutral(self) -> bool:
        """Whether the multiplier is too close to the unit circle to decide."""
        return abs(abs(self.multiplier) - 1) <= NEUTRAL


def same_cycle(one: Floats, other: Floats, tolerance: float) -> bool:
    """Tell whether points are those of one orbit, whatever point they start from."""
    if len(one) != len(other):
        return False
    return bool((np.abs(np.sort(one) - np.sort(other)) <= tolerance).all())


def as_orbit(f: Map1D, cycle: Cycle, table: BranchTable) -> PeriodicOrbit:
    """Turn a confirmed cycle into the public type, the smallest point first."""
    size = np.max(np.abs(cycle.points)) + domain_width(f)
    # A residual moves the points of a stable orbit by its sum over all further rounds.
    error = (cycle.residual + 4 * EPS * size) * cycle.period
    error /= max(abs(1 - cycle.multiplier), NEUTRAL)
    return orbit_of(
        f,
        cycle.points,
        cycle.labels,
        multiplier=cycle.multiplier,
        stable=cycle.stable,
        error=error,
        texts=[table.text(int(label)) for label in cycle.labels],
        residual=cycle.residual,
    )


def recurrences(tails: Floats, max_period: int) -> Floats:
    """Largest change of the last ``IN_A_ROW`` periods of tails under a shift by p = 1, 2, ..."""
    n = tails.shape[1]
    periods = range(1, min(max_period, (n - 1) // (IN_A_ROW + 1)) + 1)
    columns = [
        np.max(np.abs(tails[:, n - IN_A_ROW * p :] - tails[:, n - IN_A_ROW * p - p : -p]), axis=1)
        for p in periods
    ]
    return np.stack(columns, axis=1) if columns else np.empty((len(tails), 0))


def settled(f: Map1D, tail: Floats, period: int) -> Cycle | None:
    """Confirm that an orbit has settled on a cycle of this period (or a divisor): labels repeat."""
    labels = sample(f, tail[-(IN_A_ROW + 1) * period :]).label  # the last point may be outside
    if not np.array_equal(labels[period:], labels[:-period]):
        return None
    return confirmed(f, tail[-period:])


def confirmed(f: Map1D, points: Floats, moved: float = NEARBY) -> Cycle | None:
    """Polish a cycle by Newton's method on all its points at once, and reduce its period."""
    # None if Newton fails, ends in another word, or moves a point by `moved` of the domain's
    # width.
    width = domain_width(f)
    cycle = _newton(f, points, TRUST_RADIUS * moved * width)
    if cycle is None or np.max(np.abs(cycle.points - points)) > moved * width:
        return None
    for divisor in range(1, cycle.period):
        if cycle.period % divisor:
            continue
        shifted = np.roll(cycle.points, -divisor)
        if np.all(np.abs(shifted - cycle.points) <= HALF_DIGITS * width):
            shorter = _newton(f, cycle.points[:divisor], TRUST_RADIUS * moved * width)
            if shorter is not None:
                return shorter
    return cycle


def promising(f: Map1D, starts: Sequence[Floats], moved: float) -> list[int]:
    """Choose starts from which a few steps of Newton's method lead to no repelling cycle."""
    if len(starts) <= TRIES:  # not worth a look at all of them together
        return list(range(len(starts)))
    points, periods = padded(starts)
    limits = {"trust_radius": TRUST_RADIUS * moved * domain_width(f), "contraction": 1.0}
    found = polish_on(f, points, periods=periods, **limits)
    multipliers = np.abs(found.multipliers)
    repelling = found.converged & ~found.collapsed & (multipliers > 1 + NEUTRAL)
    return np.flatnonzero(~(found.given_up | np.isnan(multipliers) | repelling)).tolist()


def _newton(f: Map1D, start: Floats, trust_radius: float) -> Cycle | None:
    """Solve for a cycle of the same word; None for a point outside the trust radius."""
    scale = float(np.max(np.abs(start))) + domain_width(f)
    found = polish_on(f, start[None], scale, trust_radius=trust_radius)
    labels = found.labels[0]
    if not (found.closed[0] and np.array_equal(labels, sample(f, start).label)):
        return None
    multiplier = float(np.prod(found.slopes[0]))
    return Cycle(found.points[0], multiplier, labels, float(found.residual[0]))


def capture_radius(f: Map1D, cycle: Cycle) -> float:
    """Distance from ``cycle.points[0]`` inside which eight points were seen to come closer."""
    # One turn also brings points closer that end on a twin of the cycle beside it.
    turns = turns_that_tell(cycle)
    shares = np.array([-1.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1.0])
    # Beside another point of the cycle orbits go on to that one.
    apart = np.min(np.abs(cycle.points[1:] - cycle.points[0]), initial=np.inf)
    largest = min(0.02, float(apart) / domain_width(f))
    return _radius_of_approach(f, cycle, largest, shares, turns)


def drawn_in(tails: Floats, cycle: Cycle, centre: float, radius: float) -> Bools:
    """Tell which orbits have come within a capture radius, and closer turn by turn before that."""
    # Another attractor may pass as near, in a window too narrow for points that were tried.
    n, period = tails.shape[1], cycle.period
    turns = max(min(n // period - 1, turns_that_tell(cycle)), 0)
    off = np.abs(tails[:, -period:] - centre)
    nearest = np.arange(len(tails)), off.argmin(axis=1)
    before = np.abs(tails[:, max(n - (turns + 1) * period, 0) :] - centre)[nearest]
    allowed = share_left(cycle) ** turns * before + SETTLED * radius
    return np.asarray(off[nearest] <= np.minimum(allowed, radius))


def attracts(f: Map1D, cycle: Cycle) -> bool:
    """Whether both sides approach a cycle: on a corner, one may be stable alone."""
    sides = np.array([-1.0, 1.0])
    return cycle.stable and _radius_of_approach(f, cycle, CLOSE, sides, turns=2) > 0.0


def turns_that_tell(cycle: Cycle) -> int:
    """Return the turns that bring a captured orbit much closer to a stable cycle than a twin is."""
    return min(int(np.ceil(np.log(CLOSE) / np.log(share_left(cycle)))), BLOCK)


def share_left(cycle: Cycle) -> float:
    """Share of a distance that a turn may leave: between the multiplier and one."""
    return 0.5 * (1 + max(abs(cycle.multiplier), 0.5))


def _radius_of_approach(
    f: Map1D, cycle: Cycle, largest: float, shares: Floats, turns: int
) -> float:
    """Halve a distance from ``cycle.points[0]`` until points at shares of it come closer, or 0."""
    low, high = f.domain
    centre, radius, width = cycle.points[0], largest * (high - low), high - low
    smallest, together = SAME * width, 1
    while radius > smallest:
        radii = radius * 0.5 ** np.arange(together)
        trial = np.clip(centre + radii[:, None] * shares, low, high)
        last = advance(f, trial.ravel(), turns * cycle.period)[:, -1].reshape(trial.shape)
        allowed = share_left(cycle) ** turns * np.abs(trial - centre) + ROUNDING * width
        closer = np.all(np.abs(last - centre) <= allowed, axis=1)
        found = radii[closer & (radii > smallest)]
        if found.size:
            return float(found[0])
        # Many points take hardly longer than a few.
        radius, together = 0.5 * radii[-1], 2 * together
    return 0.0


def neutral_family(f: Map1D, cycle: Cycle) -> tuple[int, Floats] | None:
    """Intervals of periodic orbits of one word around a neutral cycle, and their period."""
    turns = 1 if cycle.multiplier > 0 else 2
    period, word = turns * cycle.period, np.tile(cycle.labels, turns)
    low, high = f.domain
    scale = ROUNDING * period * (high - low)

    def stay(x: Floats) -> Bools:
        orbits = advance(f, x, period)
        same = (sample(f, orbits[:, :-1]).label == word).all(axis=1)
        return np.asarray(same & (np.abs(orbits[:, -1] - x) <= scale))

    # Most neutral cycles are alone: two points tell, where a family would hold one of them. Beside
    # a cycle that is alone rounding hides less than that.
    beside = cycle.points[0] + 0.5 * NEARBY * (high - low) * np.array([-1.0, 1.0])
    if not stay(np.clip(beside, low, high)).any():
        return None
    ends = []
    for end in (low, high):
        way = cycle.points[0] + np.linspace(0.0, 1.0, LOOKED_AT) * (end - cycle.points[0])
        kept = stay(way)
        last = len(way) - 1 if kept.all() else max(int(np.argmin(kept)) - 1, 0)
        beyond = float(way[min(last + 1, len(way) - 1)])
        digits = sys.float_info.mant_dig
        ends.append(halved(lambda d: stay(np.array([d]))[0], float(way[last]), beyond, digits)[0])
    if ends[1] - ends[0] < NEARBY * (high - low):
        return None
    return period, merged(np.sort(advance(f, np.array(ends), period - 1).T, axis=1), 0.0)


def hidden_cycles(
    f: Map1D, values: Floats, slopes: Floats, max_period: int, multiples_of: int
) -> list[Cycle]:
    """Search the contracting passages of seemingly chaotic orbits (m, n) for stable cycles."""
    # Bands visited in turn allow ``multiples_of`` their number only.
    last = max(SAMPLES // len(values), IN_A_ROW)
    values, slopes = values[:, -last:], slopes[:, -last:]
    climb = np.cumsum(np.log(np.maximum(np.abs(slopes), 1e-300)), axis=1)
    climb = np.pad(climb, ((0, 0), (1, 0)))
    width = domain_width(f)
    found: list[Cycle] = []
    longest = min(max_period, values.shape[1] - 1)
    starts: list[Floats] = []
    for period in range(multiples_of, longest + 1, multiples_of):
        # Passages of p steps start after a first column of zeros: climb_(i+p) - climb_i.
        contracts = climb[:, period:-1] < climb[:, : -period - 1]
        distance = np.abs(values[:, period:] - values[:, :-period])[contracts]
        places = np.flatnonzero(contracts)
        if distance.size > TRIES:
            places = places[np.argpartition(distance, TRIES)[:TRIES]]
        for row, column in zip(*np.unravel_index(places, contracts.shape), strict=True):
            starts.append(values[row, column : column + period])
    for k in promising(f, starts, PASSING):
        cycle = confirmed(f, starts[k], moved=PASSING)
        if cycle is None or not cycle.stable:
            continue
        near = HALF_DIGITS * width
        if not any(same_cycle(cycle.points, other.points, near) for other in found):
            found.append(cycle)
    return found
