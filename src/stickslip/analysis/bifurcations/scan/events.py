"""Events between two values of a parameter: suspected from orbits that end, then solved for."""

from __future__ import annotations

import math
from bisect import bisect, bisect_left
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import (
    Collision,
    Crossing,
    Flip,
    Fold,
    Meeting,
    SteepFlip,
)
from stickslip.analysis.bifurcations.conditions.locate import (
    ABOVE_NOISE,
    NEARBY,
    found_near,
    solve,
    solve_together,
)
from stickslip.analysis.bifurcations.conditions.orbit_paths import path_from
from stickslip.analysis.bifurcations.normal_forms import (
    Criticality,
    CrossingCoefficients,
    crossing_coefficients,
    flip_coefficient,
)
from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd, TrackedDiscontinuity
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.derived import WindowMap
from stickslip.analysis.maps.protocol import domain_width, meet_on_circle, values_and_slopes
from stickslip.analysis.orbits.newton import MANY, turned
from stickslip.numerics.arrays import EPS

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.bifurcations.conditions.conditions import Condition
    from stickslip.analysis.bifurcations.conditions.locate import Located
    from stickslip.analysis.bifurcations.scan.nodes import Family
    from stickslip.analysis.bifurcations.scan.tracking import Piece, Way
    from stickslip.analysis.branches.breakpoints import Breakpoint
    from stickslip.analysis.maps.protocol import Floats, Map1D, MapFamily

TOUCHES: Final = 1e-4  # of the values allowed: how far a crossing is from where a fold seems to be
SAME_VALUE: Final = 1e-11  # of the range, beside the errors: events that coincide
ROUNDING: Final = 4.0  # ulp: a value this close to an event is the event's
SAME_PLACE: Final = 1e-5  # of the domain: points of an event found in two ways, or at a border
REPEATS: Final = 1e-4  # of the domain: an orbit that closes up so far at a fold is at a flip
CLOSING: Final = 0.02  # of the domain: an orbit so close to one of half its period may end there
NEAR_END: Final = 1e-3  # of an orbit's way: how far its end may be from the event there

EventKind: TypeAlias = Literal[
    "fold", "flip", "transcritical", "pitchfork", "border_collision", "enters_gap"
]


@dataclass(frozen=True, eq=False)
class Suspect:
    """A condition that is expected to hold close to a value of the parameter, or between two."""

    condition: Fold | Flip | Crossing | Collision
    guess: float = math.nan
    reach: float = 0.0  # how far off that may be
    bracket: tuple[float, float] | None = None  # where the test function changes its sign


@dataclass(frozen=True, eq=False)
class Event:
    """A condition solved for, and started from the solution."""

    kind: EventKind
    condition: Condition
    located: Located
    criticality: Criticality | None = None  # of a flip or a pitchfork, by its normal form

    @property
    def value(self) -> float:
        """Of the parameter."""
        return float(self.located.value)

    @property
    def period(self) -> int:
        """Of the orbit concerned."""
        return self.condition.period

    @property
    def points(self) -> Floats:
        """The orbit in the map's order, its smallest point first."""
        points = np.array(self.located.reading.points)
        return np.roll(points, -int(np.argmin(points)))

    def is_at(self, value: float) -> bool:
        """Tell whether a value of the parameter is this event's, as far as that is known."""
        return abs(value - self.value) <= self.located.error or in_the_middle(value, [self.value])

    def same_as(self, other: Event, scale: float, width: float) -> bool:
        """Tell whether two events are one, by the scales of the parameter and the domain."""
        slack = 8 * (self.located.error + other.located.error) + SAME_VALUE * scale
        if abs(self.value - other.value) > slack:
            return False
        if {self.kind, other.kind} == {"fold", "flip"}:
            return False
        # Several orbits that meet one border meet it at the same point.
        first, second = self.points, other.points
        gaps = np.abs(first[:, None] - second[None, :])
        return bool(gaps.min() <= SAME_PLACE * width)


def in_the_middle(value: float, listed: list[float]) -> bool:
    """Tell whether a value is that of an event, listed in ascending order, to rounding."""
    slack = ROUNDING * math.ulp(value)
    return bisect_left(listed, value - slack) < bisect(listed, value + slack)


def located(suspect: Suspect, family: Family, within: tuple[float, float]) -> Event | None:
    """Solve for a suspect; None if nothing of that kind is there."""
    found = _solved(suspect, family, within)
    if found is None or found.quality == "failed" or not within[0] <= found.value <= within[1]:
        return None
    if not math.isfinite(found.error):
        return None  # the test function is zero all along: an orbit that stays on a corner
    condition, border = found.reading.condition, found.reading.critical
    if (
        isinstance(condition, Collision)
        and border is not None
        and border.scatter[condition.side > 0]
    ):
        return None  # beside a logarithm an orbit comes ever closer; where floats end it is lost
    if isinstance(condition, Fold | Crossing) and _repeats(
        family.at(found.value), np.array(condition.points)
    ):
        return None  # f^2p has slope 1 at a flip, too
    if isinstance(condition, Fold):
        # Where curves of orbits cross, the test function of a fold touches zero.
        start = Crossing(condition.period, condition.points, family.name)
        reach = TOUCHES * (within[1] - within[0])
        crossing = found_near(start, family.whole, found.value, step=reach, within=within)
        if crossing is not None and _meets(crossing):
            found = crossing
    elif isinstance(condition, Crossing) and not _meets(found):
        return None
    kind, criticality = _sort(found, family)
    return Event(kind, found.reading.condition, found, criticality)


def _solved(suspect: Suspect, family: Family, within: tuple[float, float]) -> Located | None:
    """Solve for what is suspected; None if it is lost."""
    condition, at = suspect.condition, family.whole
    guess, reach = suspect.guess, suspect.reach
    try:
        if suspect.bracket is not None:
            found = solve(condition, at, *suspect.bracket)
        else:
            found = solve_together(condition, at, guess, step=reach, within=within)
    except (ConditionLost, ValueError):
        found = None
    if type(condition) is Flip:
        # Beside a fold the multiplier is noise, or that of the other orbit: points tell the place.
        points = None
        if found is not None and found.reading.noise > 1 / ABOVE_NOISE:
            points, guess, reach = found.reading.points, found.value, found.error
        elif suspect.bracket is not None and (found is None or found.quality == "failed"):
            points = condition.points
        if points is not None:
            steep = SteepFlip(condition.period, points)
            found = found_near(steep, at, guess, step=reach, within=within) or found
    if found is not None and isinstance(found.reading.condition, SteepFlip):
        reading = found.reading  # a flip as any other from here on
        flip = Flip(reading.condition.period, reading.points)
        found = replace(found, reading=replace(reading, condition=flip))
    return found


def _meets(found: Located) -> bool:
    """Tell whether the point of a crossing is periodic: f^p(x) - x is stationary there."""
    path = found.reading.path
    return abs(path[-1] - path[0]) <= MANY * EPS * max(1.0, *map(abs, path))


def _repeats(f: Map1D, points: Floats) -> bool:
    """Tell whether an orbit closes after a divisor of its period, with a multiplier of 1 or -1."""
    p, slack = len(points), REPEATS * domain_width(f)
    turns = [d for d in range(1, p) if p % d == 0 and _apart(points, d) <= slack]
    if not turns:
        return False
    # On a domain much wider than the orbit all of it is as close.
    _, slopes = values_and_slopes(f, points)
    sizes = (np.abs(slopes.reshape(-1, d).prod(axis=1)) for d in turns)
    return any((np.abs(size - 1) < 0.5).all() for size in sizes)


def _apart(points: Floats, turn: int) -> float:
    return float(np.abs(np.roll(points, turn) - points).max())


def _sort(found: Located, family: Family) -> tuple[EventKind, Criticality | None]:
    """Kind and criticality."""
    condition = found.reading.condition
    if isinstance(condition, Crossing):
        coefficients = coefficients_at(found, family)
        return coefficients.kind, coefficients.criticality
    if isinstance(condition, Fold):
        return "fold", None
    if isinstance(condition, Flip):
        f = family.whole(found.value)
        return "flip", flip_coefficient(f, found.reading.points).criticality
    critical = found.reading.critical
    at_gap = critical is not None and critical.kind == "edge"
    return "enters_gap" if at_gap else "border_collision", None


def passes_cut(event: Event, f: Map1D) -> bool:
    """Tell whether an orbit only passes where a phase begins anew, as anywhere on a circle."""
    critical = event.located.reading.critical
    if critical is None:
        return False
    if isinstance(critical.critical, DomainEnd):
        return meet_on_circle(f, *f.domain)
    return meet_on_circle(f, critical.left, critical.right)


def coefficients_at(found: Located, family: Family) -> CrossingCoefficients:
    """Return the normal form of crossing curves: the test's slope is discriminant / g_xq."""
    reading = found.reading
    f = family.whole(found.value)
    return crossing_coefficients(f, reading.points, reading.mixed, found.slope * reading.mixed)


def orbit_at(event: Event, near: Floats, family: Family) -> Floats | None:
    """Return the points at an event of an orbit that ends there, in the order of `near`."""
    # Ways back to a jump differ: the orbit's period need not be a multiple of the event's own.
    found = [] if len(near) % event.period else [turned(event.points, near)]
    border = event.located.reading.critical
    if isinstance(event.condition, Collision) and border is not None and border.kind == "jump":
        f = family.at(event.value)
        paths = [path_from(family.whole(event.value), border, side, len(near)) for side in (-1, 1)]
        found += [
            turned(np.array(path.points[:-1]), near)
            for path in paths
            if path.complete and abs(path.points[-1] - border.x) <= SAME_PLACE * domain_width(f)
        ]
    return min(found, key=lambda there: float(np.abs(there - near).max()), default=None)


# ------------------------------------------------------------------ what to suspect


def flips_on(piece: Piece) -> list[Suspect]:
    """Suspect a flip wherever the multiplier passes -1 along an orbit."""
    test = piece.multipliers + 1
    test[np.abs(test) <= MANY * EPS] = 0.0  # as where the range ends at the flip
    found = []
    for k in np.flatnonzero(test[:-1] * test[1:] <= 0):
        if test[k] == 0 and k > 0:
            continue  # the zero at a sample belongs to the span before it
        nearest = k if abs(test[k]) < abs(test[k + 1]) else k + 1
        condition = Flip(piece.period, tuple(piece.points[nearest].tolist()))
        low, high = float(piece.values[k]), float(piece.values[k + 1])
        start = float(piece.values[nearest])
        found.append(Suspect(condition, start, high - low, bracket=(low, high)))
    return found


def suspects_at_end(way: Way, family: Family) -> Iterator[Suspect]:
    """Suspect what may have ended an orbit's way, the likeliest first."""
    end, reach = way.end, NEAR_END * abs(way.end.value - way.values[0])
    points, value, f = end.points, end.value, family.whole(end.value)
    reach = max(reach, float(NEARBY * np.spacing(abs(value))))
    if end.reason == "crossing":  # between two orbits of the way
        reach = max(reach, abs(value - float(way.values[-1])))
    if end.reason == "end of domain":
        upper = end.side < 0
        if family.at(value).domain[upper] == f.domain[upper]:  # no end of a window is an event
            border = DomainEnd(upper, f.domain[upper])
            yield Suspect(Collision(len(points), border, end.side), value, reach)
        return
    # A way that goes nowhere says little of where it might have led.
    stuck = end.reason in ("step limit", "point limit")
    period, here = len(points), tuple(points.tolist())
    met = [
        Meeting(k, end.border, end.side)
        if k == end.index and end.border is not None
        else _meeting(f, points, k, int(way.labels[k]))
        for k in way.gone
    ]
    first, beside = met[:1], met[1:]
    if stuck and not met:
        first = [_meeting(f, points, k, None) for k in range(period)]
    collisions = [c for border in first if border for c in _collisions(border, beside, period)]
    half = 0.5 * (points + np.roll(points, period // 2))[: period // 2]
    turns: list[Fold | Flip | Crossing]
    turns = [Fold(period, here), Crossing(period, here, family.name)]
    if period % 2 == 0:
        doubled = _apart(points, period // 2) < CLOSING * domain_width(family.at(value))
        turns.insert(0 if doubled else 2, Flip(period // 2, tuple(half.tolist())))
    for condition in [*collisions, *turns] if met else [*turns, *collisions]:
        yield Suspect(condition, value, reach)


def _collisions(met: Meeting, beside: list[Meeting | None], period: int) -> Iterator[Collision]:
    """Suspect that the orbit meets a border, alone or together with others."""
    places = [one and replace(one, place=(one.place - met.place) % period) for one in beside]
    together = tuple(filter(None, places))
    # Alone at last: what seemed to come together may have missed.
    for company in [together, ()][not together :]:
        yield Collision(period, met.border, met.side, company)


def _meeting(f: MapFamily, points: Floats, place: int, label: int | None) -> Meeting | None:
    """Return the break nearest to a point, and on which side of it the point is."""
    x = float(points[place])
    border = _nearest_border(f, x)
    if border is None:
        return None
    sides = {border.left_label: -1, border.right_label: 1}
    side = sides.get(label, 0) if len(sides) > 1 else 0  # type: ignore[arg-type]
    return Meeting(place, TrackedDiscontinuity.of(border), side or (-1 if x < border.d else 1))


def _nearest_border(f: MapFamily, x: float) -> Breakpoint | None:
    """Return the break that matters nearest to a point, from the table of a small window."""
    half = SAME_PLACE * domain_width(f)
    window = WindowMap(f, (x - half, x + half))
    breaks = [item for item in branch_table(window).breakpoints if item.kind != "smooth"]
    return min(breaks, key=lambda item: abs(item.d - x), default=None)
