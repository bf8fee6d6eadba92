"""Cascades of flips, followed from flip to flip to where they accumulate."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import Bifurcation, Cascade, bifurcation_of
from stickslip.analysis.bifurcations.conditions.conditions import Flip
from stickslip.analysis.bifurcations.conditions.locate import Located, found_near, solve_near
from stickslip.analysis.bifurcations.normal_forms import CubicCoefficient, flip_coefficient
from stickslip.analysis.branches.along.tracked import ConditionLost
from stickslip.analysis.maps.protocol import Floats, values_and_slopes
from stickslip.analysis.orbits.newton import Polished, polish_on, solve_orbit
from stickslip.numerics.processes import in_processes

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from stickslip.analysis.bifurcations.scan.nodes import Family
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

LONGEST: Final = 256  # period of the last flip that is solved for
SHARP: Final = 1e-3  # of a gap: flips known less well than that end a cascade
WAY: Final = 0.45  # a doubled orbit flips where its parent's multiplier has moved on by about so
STARTS: Final = (0.15, 0.05, 0.3, 0.015)  # of that way: where the doubled orbit is solved for
STRIDES: Final = (2, 6)  # from there to where its own flip is expected; more if these fail
BESIDE: Final = 0.05  # of the way on: where orbits on both sides of a flip are shown
ENOUGH: Final = 5e-11  # of the value: an accumulation known so well needs no more flips
STEADY: Final = 2.0  # factor between two ratios up to which a sequence counts as geometric
APART: Final = 0.1  # of its expected size: a doubled orbit is further from its parent


def cascades(
    found: Sequence[Bifurcation],
    curves: Sequence[Curve],
    family: Family,
    range: tuple[float, float],
    max_period: int,
    tell: Callable[[float], None] = lambda share: None,
) -> list[Cascade]:
    """Follow the cascade from each supercritical flip of no doubled orbit, to the range's ends."""
    flips = [b for b in found if b.kind == "flip" and b.criticality == "super"]
    after = {id(flip): _successor(flip, flips, curves) for flip in flips}
    followers = {id(flip) for flip in after.values()}
    chains = [[flip] for flip in flips if id(flip) not in followers]
    for chain in chains:
        while (successor := after[id(chain[-1])]) is not None:
            chain.append(successor)
    open_ones = [chain for chain in chains if 2 * chain[-1].period > max_period]
    beyond = in_processes(partial(_beyond, family, range), open_ones, tell)
    for chain, more in zip(open_ones, beyond, strict=True):
        chain += more
    return [_cascade(chain) for chain in chains if len(chain) > 1]


def _successor(
    flip: Bifurcation, flips: list[Bifurcation], curves: Sequence[Curve]
) -> Bifurcation | None:
    """Return the flip of the orbit that is born at a flip."""
    for curve in curves:
        if curve.period != 2 * flip.period:
            continue
        for end, rows in ((curve.ends[0], 1), (curve.ends[1], -1)):
            if end.reason != "period halves" or end.value != flip.value:
                continue
            if not np.isin(flip.points, end.points).all():
                continue
            passed = [item for item in curve.bifurcations[::rows] if item.kind == "flip"]
            if passed:
                # Twins flip at one value.
                same = (b for b in flips if b.value == passed[0].value)
                return next((b for b in same if np.isin(b.points, passed[0].points).all()), None)
    return None


# ------------------------------------------------------------------ beyond the lists


@dataclass(frozen=True)
class _Level:
    """A flip, the derivative of the multiplier there, and the normal form's coefficient."""

    flip: Bifurcation
    slope: float
    coefficient: CubicCoefficient


def _beyond(
    family: Family, range: tuple[float, float], chain: list[Bifurcation]
) -> list[Bifurcation]:
    """Follow a cascade from its last flip on, as far as it takes and as flips are sharp."""
    level = _level_of(chain[-1], family)
    found: list[Bifurcation] = []
    while 2 * level.flip.period <= LONGEST and level.slope != 0:
        located = _next_flip(level, family)
        if located is None or not range[0] <= located.value <= range[1]:
            break
        if not located.error < SHARP * abs(located.value - level.flip.value):
            break
        level = _next_level(located, family)
        if level.flip.criticality != "super":
            break
        found.append(level.flip)
        where, error = _accumulation([*chain, *found])
        if error < ENOUGH * abs(where):
            break
    return found


def _level_of(flip: Bifurcation, family: Family) -> _Level:
    """Take up a flip of the lists; its slope is 0 where the multiplier has none."""
    step, slope = max(1e3 * flip.error, 1e-9 * abs(flip.value)), 0.0
    with suppress(ConditionLost, ValueError):
        slope = solve_near(flip.condition, family.whole, flip.value, step=step).slope
    return _Level(flip, slope, flip_coefficient(family.whole(flip.value), flip.points))


def _next_flip(level: _Level, family: Family) -> Located | None:
    """Solve for the flip of the orbit that a flip gives birth to."""
    last, way = level.flip, -WAY / level.slope  # it lives where the multiplier is below -1
    start = _doubled(level, way, family)
    if start is None:
        return None
    grown = next(filter(None, (_grown(start, last, way, n, family) for n in STRIDES)), None)
    if grown is None:
        return None
    value, points = grown
    low, high = sorted((last.value, last.value + 2 * way))
    flip = Flip(2 * last.period, tuple(points.tolist()))
    return found_near(flip, family.whole, value, step=0.05 * abs(way), within=(low, high))


def _grown(
    start: tuple[Polished, float], last: Bifurcation, way: float, strides: int, family: Family
) -> tuple[float, Floats] | None:
    """Carry a doubled orbit from where it was solved for to where its own flip is expected."""
    # Its halves part like the root of the distance from its birth; their middle moves in
    # proportion.
    orbit, q = start
    points = orbit.points[0]
    for value in np.linspace(q, last.value + way, strides + 1)[1:].tolist():
        ratio = (value - last.value) / (q - last.value)
        halves = points.reshape(2, -1)
        apart = math.sqrt(ratio) * 0.5 * (halves[0] - halves[1])
        middle = last.points + ratio * (halves.mean(axis=0) - last.points)
        found = _polished(family, value, np.concatenate([middle + apart, middle - apart]))
        if found is None or not _apart(found, np.abs(apart).max()):
            return None
        q, points = value, found.points[0]
        if found.multipliers[0] < -1:
            break
    return q, points


def _doubled(level: _Level, way: float, family: Family) -> tuple[Polished, float] | None:
    """Solve for the orbit born at a flip, from the size that the normal form foretells."""
    # On the unstable side u -> -(1 + e) u + c u^3 has the cycle u = ±sqrt(e / c).
    last, coefficient = level.flip, level.coefficient.value
    if not coefficient > 0:
        return None
    _, slopes = values_and_slopes(family.whole(last.value), last.points)
    shape = np.cumprod(np.concatenate([[1.0], slopes[:-1]]))
    for share in STARTS:
        q = last.value + share * way
        if q == last.value:  # as steep as that, floats tell no way on
            return None
        u = math.sqrt(abs(level.slope * share * way) / coefficient) * shape
        found = _polished(family, q, np.concatenate([last.points + u, last.points - u]))
        if found is not None and _apart(found, np.abs(u).max()):
            return found, q
    return None


def _polished(family: Family, q: float, guess: Floats) -> Polished | None:
    """Solve for an orbit at a value of the parameter; None beyond the family's end."""
    try:
        f = family.whole(q)
    except ValueError:
        return None
    return polish_on(f, guess[None])


def _apart(found: Polished, size: float) -> bool:
    """Tell whether an orbit is its own, and not its parent twice."""
    points = found.points[0]
    half = len(points) // 2
    return bool(found.converged[0] and np.abs(points[:half] - points[half:]).max() > APART * size)


def _next_level(found: Located, family: Family) -> _Level:
    """Make a bifurcation of a flip beyond the lists, with the orbits on both sides."""
    flip = bifurcation_of("flip", found, family.name, family.f, in_cascade=True)
    coefficient = flip_coefficient(family.whole(flip.value), flip.points)
    flip = replace(flip, criticality=coefficient.criticality)
    level = _Level(flip, float(found.slope), coefficient)
    return replace(level, flip=_with_orbits(level, family))


def _with_orbits(level: _Level, family: Family) -> Bifurcation:
    """Add the parent on both sides and its double where that lives."""
    flip, slope = level.flip, level.slope
    if slope == 0 or flip.criticality is None:
        return flip
    way = -WAY / slope if flip.criticality == "super" else WAY / slope
    sides: list[list[PeriodicOrbit]] = []
    for share in (-BESIDE, BESIDE):
        try:
            parent = solve_orbit(family.whole(flip.value + share * way), flip.points)
        except ValueError:  # the family ends there
            return flip
        sides.append([parent] if parent.quality == "located" else [])
    before, after = sides if way > 0 else sides[::-1]
    flip = replace(flip, orbits_before=tuple(before), orbits_after=tuple(after))
    return _with_double(replace(level, flip=flip), way, family)


def _with_double(level: _Level, way: float, family: Family) -> Bifurcation:
    """Add the orbit that is born at a flip, on the way to where its own flip is expected."""
    flip, start = level.flip, _doubled(level, BESIDE / STARTS[0] * way, family)
    if start is None:
        return flip
    double = solve_orbit(family.whole(start[1]), start[0].points[0])
    if double.quality != "located":
        return flip
    side = "orbits_after" if way > 0 else "orbits_before"
    more: dict[str, Any] = {side: (*getattr(flip, side), double)}
    return replace(flip, **more)


def with_double(flip: Bifurcation, family: Family) -> Bifurcation:
    """Add the orbit that is born at a flip whose double the lists are too short for."""
    if flip.criticality != "super" or not (level := _level_of(flip, family)).slope:
        return flip
    return _with_double(level, -WAY / level.slope, family)


# ------------------------------------------------------------------ the accumulation


def _cascade(chain: list[Bifurcation]) -> Cascade:
    ratios = _extrapolated(np.array([flip.value for flip in chain]))[1]
    return Cascade(tuple(chain), *_accumulation(chain), ratios)


def _accumulation(chain: list[Bifurcation]) -> tuple[float, float]:
    values, errors = ([getattr(flip, name) for flip in chain] for name in ("value", "error"))
    return accumulation(np.array(values), np.array(errors))


@np.errstate(divide="ignore", invalid="ignore")  # gaps may be equal
def accumulation(values: Floats, errors: Floats) -> tuple[float, float]:
    """Extrapolate successive flips to where they accumulate, with an error, by Aitken's method."""
    # The estimate that differs least from the one before is taken. NaN below three flips.
    if len(values) < 3:
        return math.nan, math.inf
    estimates, ratios = _extrapolated(values)
    # d(estimate) is the error of a flip, amplified by at most ratio / (ratio - 1)^2.
    noise = np.array([errors[k : k + 3].sum() for k in range(len(estimates))])
    noise *= np.abs(ratios) / (ratios - 1) ** 2 + 1
    value, error = _steadiest(estimates, noise)
    if len(estimates) >= 4:
        better, ratios = _extrapolated(estimates)
        if max(ratios[-2:]) < STEADY * min(ratios[-2:]) and min(ratios[-2:]) > 1:
            second = _steadiest(better, 2 * noise[2:])
            if second[1] < error:
                value, error = second
    return value, error


@np.errstate(divide="ignore", invalid="ignore")
def _extrapolated(values: Floats) -> tuple[Floats, Floats]:
    """Return Aitken's estimates from each three successive values, and the ratios of gaps."""
    gaps = np.diff(values)
    ratios = gaps[:-1] / gaps[1:]
    estimates = values[2:] + gaps[1:] / (ratios - 1)
    return estimates, ratios


def _steadiest(estimates: Floats, noise: Floats) -> tuple[float, float]:
    """Return the estimate that differs least from the one before it, and its error."""
    steps = np.abs(np.diff(estimates, prepend=np.inf)) + noise
    best = int(np.nanargmin(steps)) if np.isfinite(steps).any() else 0
    return float(estimates[best]), float(steps[best])
