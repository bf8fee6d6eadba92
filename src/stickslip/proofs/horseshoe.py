"""Horseshoes proven: intervals that the map takes over one another, and the entropy they force.

Docs: proofs, horseshoes.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import floor, log
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from stickslip.analysis.branches.mesh import finest
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.protocol import domain_width
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.proofs.jet import box_of
from stickslip.proofs.power import MapSetting, step
from stickslip.proofs.system import decimal, middle_of, number
from stickslip.proofs.verify.words import HEAVIEST, MOST_INTERVALS
from stickslip.proofs.wave import Undecided

if TYPE_CHECKING:
    from stickslip.analysis.branches.laps import Laps
    from stickslip.analysis.maps.protocol import Floats, Map1D

Interval: TypeAlias = tuple[Fraction, Fraction]
Graph: TypeAlias = NDArray[np.bool_]
Indices: TypeAlias = NDArray[np.intp]

GAP: Final = 1e-6  # of the domain, between intervals at an end of a lap
BESIDE: Final = (1e-4, 1e-3, 1e-2)  # of the domain: where to cut beside a value at an end
NEAREST: Final = 1 / 64  # of that: no cut is closer
NARROWEST: Final = 1e-9  # of the domain: interval
SPARE: Final = 1.05  # the image of a gap is so much narrower than the gap that it falls into
LONGEST: Final = 200  # way to an end of a lap
TINY: Final = 1e-12  # of the domain: distance from a fixed point at which a return to it begins
LEAST_REPELLING: Final = 1.5  # slope of such a fixed point: with less the return is long
DEEPEST: Final = 6  # steps of a return, besides those on the fixed point's lap
ROUNDING: Final = 1e-15  # of the domain: error of a point
SLACK: Final = 1.5  # an image is so much wider than it must be
PLACES: Final = 20  # of the ends of intervals
HALVINGS: Final = 40  # of an interval on which the map is to be continuous
MOST_PARTS: Final = 2000
ROUNDS: Final = 5000  # of the power method
ENTROPY_PLACES: Final = 6


def proven_horseshoe(setting: MapSetting, intervals: Sequence[Interval]) -> dict[str, Any]:
    """Prove which intervals are taken over which others, and the entropy that this forces."""
    values = [_images(setting, ends) for ends in intervals]
    left, proven = np.flatnonzero([bool(each) for each in values]), set[int]()
    while True:
        entropy, chosen, weights = _richest(_covers(intervals, values, left))
        broken = [
            k for k in left[chosen] if k not in proven and not _continuous(setting, intervals[k])
        ]
        if not broken:
            return {
                "entropy": f"{entropy:.{ENTROPY_PLACES}f}",
                "intervals": [
                    [*map(decimal, intervals[k]), weight]
                    for k, weight in zip(left[chosen], weights, strict=True)
                ],
            }
        proven.update(set(left[chosen]) - set(broken))
        left = np.setdiff1d(left, broken)


def _images(setting: MapSetting, ends: Interval) -> list[Fraction]:
    """Return what lies between the values at the ends of an interval, rounded inward."""
    try:
        low, high = sorted(
            (step(setting, box_of(number(end))[0])[0].value.range for end in ends), key=arb.mid
        )
    except Undecided:
        return []  # there may be no value
    return [middle_of(low.upper()), middle_of(high.lower())]


def _covers(
    intervals: Sequence[Interval], values: Sequence[Sequence[Fraction]], left: Indices
) -> Graph:
    """Tell which of the intervals that are left cover which."""
    lows, highs = (np.array([intervals[k][side] for k in left], dtype=object) for side in (0, 1))
    covers = np.zeros((len(left), len(left)), dtype=np.bool_)
    for row, k in zip(covers, left, strict=True):
        low, high = values[k]
        row[np.searchsorted(lows, low) : np.searchsorted(highs, high, side="right")] = True
    return covers


def _continuous(setting: MapSetting, ends: Interval) -> bool:
    """Whether the map is proven to be continuous on an interval."""
    waiting, parts = [(*ends, HALVINGS)], 0
    while waiting:
        low, high, left = waiting.pop()
        try:
            (piece,) = step(setting, box_of(number(low).union(number(high)))[0])
            proven = piece.value.gradient[0].is_finite()
        except Undecided:
            proven = False
        if not proven:
            parts += 1
            if not left or parts > MOST_PARTS:
                return False
            middle = (low + high) / 2
            waiting += [(low, middle, left - 1), (middle, high, left - 1)]
    return True


def _richest(covers: Graph) -> tuple[float, Indices, list[int]]:
    """Return the entropy of the strong component that has most, its nodes and their weights."""
    best: tuple[float, Indices, list[int]] = 0.0, np.empty(0, np.intp), []
    count, component = connected_components(covers, connection="strong")
    for k in range(count):
        chosen = np.flatnonzero(component == k)
        rows = covers[np.ix_(chosen, chosen)]
        if rows.sum() <= len(chosen):  # a circle
            continue
        weights = [max(int(w), 1) for w in np.rint(HEAVIEST * _eigenvector(rows.astype(float)))]
        sums = rows.astype(object) @ np.array(weights, dtype=object)
        growth = min(Fraction(int(a), b) for a, b in zip(sums, weights, strict=True))
        unit = 10**ENTROPY_PLACES
        entropy = floor(unit * log(max(float(growth), 1.0))) / unit
        if entropy > best[0] and len(chosen) <= MOST_INTERVALS:
            best = entropy, chosen, weights
    if not best[0]:
        raise Undecided("no intervals are shown to be taken over one another in several ways")
    return best


def _eigenvector(matrix: Floats) -> Floats:
    """Perron's, the largest entry 1."""
    x = np.ones(len(matrix))
    for _ in range(ROUNDS):
        x = matrix @ x + x  # with the identity, a component of several phases converges, too
        x /= x.max()
    return x


def partition(f: Map1D) -> list[Interval]:
    """Cut the domain at the ends of laps, and at points whose orbits lead to ends of laps."""
    # These points lie close beside the values at the ends, on the inner side: so an interval at an
    # end is taken over whole ones. Beside each point a gap belongs to none; the map takes it into
    # the gap of the point's image, and so an end of an interval beyond the end of another.
    laps = branch_table(f, finest(f)).pieces
    width = domain_width(f)
    ends = np.unique(np.concatenate([laps.left, laps.right]))
    gaps = dict.fromkeys(ends.tolist(), GAP * width)
    values = np.column_stack([laps.value_left, laps.value_right])
    for value, inward in (
        *zip(values[:, 0], values[:, 1] - values[:, 0], strict=True),
        *zip(values[:, 1], values[:, 0] - values[:, 1], strict=True),
    ):
        for beside in BESIDE:
            pair = value + np.sign(inward) * beside * width * np.array([1.0, NEAREST])
            if found := _to_an_end(laps, ends, pair, GAP * width):
                break
        for x, gap in found:
            gaps[x] = min(gap, gaps.get(x, gap))
    points = np.array(sorted(gaps))
    away = np.array([gaps[x] for x in points.tolist()])
    lows, highs = points[:-1] + away[:-1], points[1:] - away[1:]
    wide = highs - lows > NARROWEST * width
    return list(zip(_decimals(lows[wide]), _decimals(highs[wide]), strict=True))


def snap_back(f: Map1D) -> list[Interval]:
    """Find an unstable fixed point to which an orbit that leaves it returns: tiny intervals there.

    Where the map can be enclosed on tiny intervals alone. Empty if there is none.
    """
    # Backward: near the fixed point the orbit converges to it, as a repeller's does. Each interval
    # is as wide as its image must be, the one around the fixed point reaches to the first point.
    laps = branch_table(f, finest(f)).pieces
    width = domain_width(f)
    found: list[tuple[float, float, list[float]]] = []
    for orbit in periodic_orbits(f, 1):
        p, slope = float(orbit.points[0]), abs(float(orbit.multiplier))
        if slope > LEAST_REPELLING and (way := _return(laps, p, TINY * width)):
            found.append((p, slope, way))
    if not found:
        return []
    p, slope, way = min(found, key=lambda each: len(each[2]))
    half = abs(way[0] - p) / slope**0.5
    middles, halves = [p], [half]
    error = ROUNDING * width
    for x in reversed(way):
        rate = abs(float(laps.evaluate(laps.locate(np.array([x])), np.array([x]))[1][0]))
        half = max(SLACK * (half + error) / rate, SLACK * error)
        middles.append(x)
        halves.append(half)
    order = np.argsort(middles)
    at, reach = np.array(middles)[order], np.array(halves)[order]
    return list(zip(_decimals(at - reach), _decimals(at + reach), strict=True))


def _return(laps: Laps, p: float, near: float) -> list[float]:
    """Return an orbit that begins near a fixed point and comes to it in the end."""
    (home,) = laps.locate(np.array([p]))
    ways = [[p]]
    for _ in range(DEEPEST):
        ways = [
            [x, *way]
            for way in ways
            for k in np.flatnonzero((laps.value_min < way[0]) & (way[0] < laps.value_max))
            if k != home or len(way) > 1
            for x in laps.inverse(np.array([k]), np.array([way[0]])).tolist()
        ]
        returns = [way for way in (_from(laps, int(home), p, way, near) for way in ways) if way]
        if returns:
            return min(returns, key=len)[:-1]
    return []


def _from(laps: Laps, home: int, p: float, way: list[float], near: float) -> list[float]:
    """Lead a way back to a fixed point, as long as it stays on the fixed point's lap."""
    while abs(way[0] - p) > near:
        if not laps.value_min[home] < way[0] < laps.value_max[home] or len(way) > LONGEST:
            return []
        (x,) = laps.inverse(np.array([home]), np.array(way[:1])).tolist()
        way = [x, *way]
    return way


def _to_an_end(laps: Laps, ends: Floats, pair: Floats, gap: float) -> list[tuple[float, float]]:
    """Find a point between two whose orbit leads to an end of a lap: that orbit, with gaps."""
    way: list[int] = []
    while not len(inside := ends[(min(pair) < ends) & (ends < max(pair))]):
        lap = int(laps.locate(np.array([pair.mean()]))[0])
        if lap < 0 or len(way) == LONGEST:
            return []
        way.append(lap)
        pair = laps.evaluate(np.array([lap, lap]), pair)[0]
    orbit, x = [], inside[:1]
    for lap in reversed(way):
        x = laps.inverse(np.array([lap]), x)
        slope = laps.evaluate(np.array([lap]), x)[1][0]
        gap /= max(SPARE * abs(float(slope)), 1.0)
        orbit.append((float(x[0]), gap))
    return orbit


def _decimals(x: Floats) -> list[Fraction]:
    unit = 10**PLACES
    return [Fraction(round(Fraction(each) * unit), unit) for each in x.tolist()]
