"""Periodic orbits on their way along a parameter: in R^n, and on a line with all its borders."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import numpy as np

from stickslip.analysis.branches.along.tracked import ConditionLost, DomainEnd
from stickslip.analysis.continuation.borders import (
    REACHES,
    Border,
    encounters,
    meet,
    unlabelled_encounters,
)
from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem, between
from stickslip.analysis.continuation.follower import (
    AHEAD,
    MAX_POINTS,
    MAX_STEP,
    Follower,
    Passed,
    first_point,
    off_multiplier,
)
from stickslip.analysis.continuation.half_period import flip_of_half, shrinks_to_half
from stickslip.analysis.continuation.orbit_equations import Departure, Linearized, OrbitEquations
from stickslip.analysis.maps.differences import LIKE
from stickslip.analysis.maps.protocol import (
    SAME,
    MapND,
    apart,
    domain_width,
    lengths,
    measured,
    sample,
    turned_near,
    widths,
)
from stickslip.analysis.orbits.newton import (
    ROUNDINGS,
    error_bound,
    monodromy,
    solve_orbit,
    solve_orbits,
)
from stickslip.analysis.orbits.orbit import PeriodicOrbit, orbit_of
from stickslip.analysis.orbits.orbits_nd import (
    multipliers_of,
    orbit_nd_of,
    same_points,
    solve_orbit_nd,
)
from stickslip.analysis.scales import CLOSE, FINE, NEARBY, ORBIT_NOISE
from stickslip.numerics.arrays import EPS
from stickslip.numerics.continuation import CurvePoint, LeavesRegion, StepControl, StepTooLong
from stickslip.results.parts import part
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stickslip.analysis.continuation.follower import Half
    from stickslip.analysis.maps.protocol import Floats, PointValues
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
    from stickslip.numerics.continuation import WalkEnd

BENDS: Final = 0.5  # a slope changes at most so much per step, beside 1 + abs(slope) ...
BENDS_UNLABELLED: Final = 0.05  # ... and where no label would tell of a corner
# A border is approached by halving steps that cross it, down to little more than the error of a
# point; then a little further on the way the cause is seen.
SMALLEST: Final = 2 * SAME
PROBES: Final = (2e-11, 2e-10, 2e-9, 2e-8)
BEYOND: Final = (1e-5, 1e-7)  # scaled ways past a border at which the two sides are compared
JUMPS: Final = 0.5  # a jump shrinks less with the way than values do at a root-like corner
REASONS: Final[dict[str, Any]] = {"jump": "breakpoint", "corner": "breakpoint", "edge": "gap"}


class OrbitFollower(Follower):
    """Follows one orbit of a map; ``max_step`` is a share of range and domain."""

    kind = "orbit"
    bends = BENDS
    unit: Any = 1.0  # of each coordinate in R^n

    def __init__(
        self, f: Any, name: str, low: float, high: float, max_step: float, max_points: int
    ) -> None:
        steps = StepControl(first=min(0.01, max_step), largest=max_step)
        super().__init__(name, low, high, steps, max_points)
        self.f = f

    def size(self) -> Any:
        """Width of the domain, in each direction."""
        raise NotImplementedError

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, in the order of a guess; and det(M + 1), NaN if there is none."""
        raise NotImplementedError

    def start(self, points: Floats, value: float) -> CurvePoint:
        """Set out from an orbit, the parameter rising; a ValueError if the map has none there."""
        equations = OrbitEquations(self.f, self.name, [], self.unit)
        values = sample(equations.at(value), points)
        equations.pieces = [{label} for label in values.label.tolist()]
        self.equations = equations
        scale = np.append(np.tile(self.size() / self.unit, len(points)), self.high - self.low)
        self.curve = self.line(equations, scale)
        wrong = f"the map has no such orbit at {self.name} = {value:.15g}: "
        if (values.status != OK).any():
            raise ValueError(f"{wrong}no value at one of its points, or outside the window.")
        y = equations.unknowns(points, value)
        return first_point(self.curve, y, wrong, CLOSE, equations.points)

    def points(self, point: CurvePoint) -> Floats:
        """Return the points of the orbit."""
        return self.equations.points(point.y)

    def images(self, point: CurvePoint) -> Iterator[CurvePoint]:
        """Start an orbit at each of its points; the parameter stays last."""
        for turn in range(len(self.points(point))):
            y, tangent = (
                self.equations.unknowns(np.roll(self.equations.points(z), turn, axis=0), z[-1])
                for z in (point.y, point.tangent)
            )
            yield replace(point, y=y, tangent=tangent, note=point.note.turned(turn))

    def near(self, point: CurvePoint, here: CurvePoint) -> CurvePoint:
        """Turn the angles of a point by whole periods."""
        turned = turned_near(self.f, self.points(point), self.points(here))
        return replace(point, y=self.equations.unknowns(turned, point.parameter))

    def accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Let no slope change by much."""
        before, after = here.note.slopes, new.note.slopes
        if (np.abs(after - before) > self.bends * (1 + np.minimum(abs(before), abs(after)))).any():
            raise StepTooLong("a slope changes")

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """Solve for bifurcations, and for the orbit of half the period that ends the curve."""
        if shrinks_to_half(self.f, self.points(here), self.points(new)):
            yield self._merged(here)
        else:
            yield from super().passed(here, new)

    def _merged(self, last: CurvePoint) -> Passed:
        """Solve for the flip at which the orbit merges with one of half its period."""
        before = self.points(last)
        one, other = np.split(before, 2)
        middle = 0.5 * (one + turned_near(self.f, other, one))
        found = flip_of_half(self.solved, middle, last.parameter, self.low, self.high)
        if found is None:
            raise StepTooLong("no flip of half the orbit")
        value, half = found
        points = turned_near(self.f, np.concatenate([half, half]), before)
        values = sample(self.equations.at(value), points)
        point = self.at(last, points, value, *self.equations.described(points, values))
        return Passed(point, end=self.end(point, "period halves"))

    def at(
        self, last: CurvePoint, points: Floats, value: float, residual: Floats, note: Linearized
    ) -> CurvePoint:
        """Describe an orbit where the curve ends, beyond the last point of a walk."""
        y, size = self.equations.unknowns(points, value), float(np.abs(residual).max())
        return replace(last, y=y, residual=size, note=note)

    def described(self, rows: list[CurvePoint]) -> tuple[dict[str, Any], Problem]:
        """Return labels and errors, and the equations."""
        data = {
            "labels": np.array([row.note.labels for row in rows]),
            "residual": np.array([row.residual for row in rows]) * np.max(self.unit),
            "margin": np.array([row.note.margin for row in rows]),
        }
        return data, OrbitProblem(self.f)


class LineOrbitFollower(OrbitFollower):
    """Follows an orbit of a map of a line to borders, which are solved for as conditions."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        # Borders are not approached, so that steps may be as long as they can.
        self.control = replace(self.control, enough=1e-14, foretell=True)

    def size(self) -> float:
        """Width of the domain."""
        return domain_width(self.f)

    def start(self, points: Floats, value: float) -> CurvePoint:
        """Set out from an orbit; without labels more carefully."""
        found = super().start(points, value)
        self.bends = BENDS if any(map(any, self.equations.pieces)) else BENDS_UNLABELLED
        return found

    def tests(self, here: CurvePoint, new: CurvePoint) -> Iterator[Any]:
        """One multiplier may fold or flip."""
        yield from list(super().tests(here, new))[:2]

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, points in the order of the guess."""
        orbit = solve_orbit(self.equations.at(value), guess)
        if orbit.quality != "located":
            return guess, np.nan
        shift = int(np.argmin(np.abs(orbit.points - guess[0])))
        return np.roll(orbit.points, -shift), orbit.multiplier + 1.0

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Find out what ended a walk."""
        last = stop.last
        points, value = self.points(last), last.parameter
        if stop.reason == "step limit":
            for met in unlabelled_encounters(self.equations.at(value), points):
                if (end := self._end_at(last, met, NEARBY, half)) is not None:
                    return end
            return self.end(last, "step limit")
        for met in encounters(self.equations, points, value, stop.cause):
            if met.harmless is None:
                end = self._end_at(last, met, REACHES * last.step, half)
                if end is not None:
                    return end
            if met.harmless is not None:  # some are only there where the orbit meets them
                self.equations.pieces[met.index].add(met.harmless)
                return replace(last, step=self.control.first)
        return last  # a false alarm: Newton's method went astray

    def _end_at(
        self, last: CurvePoint, border: Border, reach: float, half: Half
    ) -> CurveEnd | None:
        """Solve for the orbit on a border; None if that is not where the curve leads."""
        eq, index = self.equations, border.index
        start = self.points(last), border, last.parameter
        try:
            met = meet(eq.at, self.name, *start, self.low, self.high)
        except ConditionLost:
            return None
        if border.harmless is not None:
            return None
        # Points on the border itself, of which there may be several, are seen from their pieces.
        on_border = np.abs(met.points - met.points[index]) <= ORBIT_NOISE * self.curve.scale[:-1]
        labels = np.where(on_border, last.note.labels, met.labels)
        if not eq.stays(labels, np.ones(len(labels), dtype=bool)).all():
            return None
        way = (np.append(met.points, met.value) - last.y) / self.curve.scale
        length = float(np.linalg.norm(way))
        # An end that is met at once has no direction.
        ahead = float(way @ last.tangent) >= AHEAD * length or length <= CLOSE
        if length > reach or not ahead:
            return None
        note = Linearized(met.slopes, met.points, labels)
        point = self.at(last, met.points, met.value, met.residual, note)
        half.rows.append(point)
        found = border.critical
        if isinstance(found, DomainEnd):
            return self.end(point, "end of domain", index=index, side=border.side)
        return self.end(point, REASONS[found.kind], index=index, side=border.side, border=found)


class SpaceOrbitFollower(OrbitFollower):
    """Follows an orbit of a map of R^n to borders, which are approached by halving steps.

    Where a point gets to another piece of the map the two sides are compared: a map that is smooth
    there is followed on, else the curve ends in a border collision, located to its `error`.
    """

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.control = replace(self.control, smallest=SMALLEST, patience=self.max_points)
        self.unit = lengths(self.f)

    def size(self) -> Floats:
        """Width of the domain in each direction."""
        return widths(self.f)

    def solved(self, value: float, guess: Floats) -> tuple[Floats, float]:
        """Solve for an orbit, points in the order of the guess."""
        got = solve_orbits(self.equations.at(value), guess[None])
        if not got.found[0]:
            return guess, np.nan
        return got.points[0], off_multiplier(multipliers_of(got.jacobians[0]), -1.0)

    def stopped(self, stop: WalkEnd, half: Half) -> CurvePoint | CurveEnd:
        """Find out what ended a walk; pass the ends of pieces where the map is smooth."""
        last = stop.last
        departure = self._departure(last)
        if departure is None:
            return self.end(last, "step limit")
        cause, way = departure
        index = int(cause.indices[0])
        error = abs(way * float(self.curve.scale[-1] * last.tangent[-1]))
        where: dict[str, Any] = {
            "index": index,
            "error": error + 2 * float(np.spacing(abs(last.parameter))),
        }
        beyond = self._beyond(last, cause)
        if beyond is None:
            inside = self.f.contains(cause.points)[index]
            return self.end(last, "gap" if inside else "end of domain", **where)
        kind, label = beyond
        explain = getattr(self.equations.at(last.parameter), "explain_border", None)
        if explain is not None:
            beside = self.equations.at(cause.value), cause.points[index]
            where["border"] = tuple(explain(self.points(last)[index], *beside))
        onward = self._past(last, half) if kind == "corner" else None
        if kind == "smooth":
            self.equations.pieces[index].add(label)
            onward = replace(last, step=self.control.first)
        if onward is None:
            return self.end(last, "breakpoint", kind=kind, **where)
        text, block = where.get("border", ("", None))
        told = {"what": text, "block": block, "outcome": "persists"}
        half.note(self.event("border", last, where["error"], **told))
        return onward

    def _past(self, last: CurvePoint, half: Half) -> CurvePoint | None:
        """Go on beyond a border that leaves all multipliers as they are; None at any other.

        So does an event of a motion in time that crosses the time at which a map looks at it.
        """
        y = last.y + BEYOND[1] * self.curve.scale * last.tangent
        f = self.equations.at(y[-1])
        # The map itself knows the directions that it forgets: its images are where points belong.
        points = np.roll(sample(f, self.equations.points(y)).value, 1, axis=0)
        got = sample(f, points)
        if (got.status != OK).any():
            return None
        old, new = (np.poly(monodromy(each)) for each in (last.note.slopes, got.derivative))
        if (np.abs(new - old) > LIKE * (1 + np.abs(old).max())).any():
            return None
        pieces, labels = self.equations.pieces, got.label.tolist()
        self.equations.pieces = [{label} for label in labels]
        try:
            start = self.curve.point(self.equations.unknowns(points, y[-1]))
        except (StepTooLong, LeavesRegion):
            self.equations.pieces = pieces
            return None
        rising = last.tangent[-1] > 0
        half.rows.append(start if rising else start.reversed())
        return half.rows[-1]

    def _departure(self, last: CurvePoint) -> tuple[Departure, float] | None:
        """Which points leave their pieces just past the end of a walk, and how far past."""
        for way in PROBES:
            try:
                self.equations(last.y + way * self.curve.scale * last.tangent)
            except LeavesRegion as left:
                cause: Departure = left.cause
                return cause, way
            except StepTooLong:
                continue
        return None

    def _beyond(
        self, last: CurvePoint, cause: Departure
    ) -> tuple[Literal["jump", "corner", "smooth"], int] | None:
        """Compare the two sides of the border that a point meets; None without a value there."""
        index = cause.indices[0]
        far, near = (self._other_side(last, index, way) for way in BEYOND)
        if far is None or near is None:
            return None
        note: Linearized = last.note
        slope = note.slopes[index]
        offs = (apart(self.f, side.value, note.values[index]) for side in (far, near))
        gaps = [float(np.abs(off / self.unit).max()) for off in offs]
        label = int(near.label)
        if gaps[1] > max(FINE, JUMPS * gaps[0]):
            return "jump", label
        changed = np.abs(measured(near.derivative, self.unit) - slope)
        if (changed > LIKE * (1 + np.abs(slope))).any():
            return "corner", label
        return "smooth", label

    def _other_side(self, last: CurvePoint, index: int, way: float) -> PointValues | None:
        """Value past a border, led back to it by the slopes there; and these slopes."""
        y = last.y + way * self.curve.scale * last.tangent
        f, x = self.equations.at(y[-1]), self.equations.points(y)[index]
        values = sample(f, x)
        if values.status != OK:
            return None
        dx = x - self.points(last)[index]
        rate = np.asarray(f.parameter_derivative(x, self.name))
        back = values.value - values.derivative @ dx - rate * (y[-1] - last.y[-1])
        return replace(values, value=back)


@part
@dataclass(frozen=True, eq=False)
class OrbitProblem(Problem):
    """The equations of a periodic orbit; `system` is restricted to the window if one was given."""

    system: Any = None
    picture: ClassVar = "bifurcations.draw_orbit_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Any:
        """Start from a straight line between two rows; beside a fold, walk there."""
        if not share:
            return self.row(curve, row)
        orbit = self._solved(curve, value, between(curve.points, row, share))
        for start in (row + 1, row):
            if orbit is not None and not _beyond_fold(curve, row, orbit):
                break
            own = float(curve.values[start])
            low, high = sorted((own, value))
            follower = orbit_follower(self.system, name, low, high)
            last = follower.reached(follower.start(curve.points[start], own), value)
            if last is not None:
                orbit = self._solved(curve, value, follower.points(last))
        return orbit

    def _solved(self, curve: Curve, value: float, guess: Floats) -> Any:
        f = self.system.replace(**{curve.parameter: value})
        if isinstance(f, MapND):
            return solve_orbit_nd(f, guess)
        orbit = solve_orbit(f, guess)
        return orbit if orbit.quality == "located" else None

    def row(self, curve: Curve, row: int) -> Any:
        """Return the orbit of a row as it was solved: at an end a one-sided limit."""
        f = self.system.replace(**{curve.parameter: float(curve.values[row])})
        points, labels = curve.points[row], curve.data["labels"][row]
        residual = float(curve.data["residual"][row])
        if isinstance(f, MapND):
            return orbit_nd_of(f, points, curve.multipliers[row], labels, residual)
        values = sample(f, points)
        error = np.full(points.shape, residual + ROUNDINGS * EPS * np.abs(f.domain).max())
        # On a border that ends the curve, solved for with the points, it may be one-sided.
        if (values.label == labels).all() and np.isfinite(values.derivative).all():
            (error,) = error_bound(values.derivative[None], error[None])
        return orbit_of(
            f,
            points,
            labels,
            multiplier=float(curve.multipliers[row]),
            error=error,
            residual=residual,
        )

    def guess(self, curve: Curve, row: int, share: float, name: str) -> Floats:
        """Return the points, in R^n their first coordinates."""
        points = between(curve.points, row, share)
        return points if points.ndim == 1 else points[:, 0]

    def same(self, one: Any, other: Any) -> bool:
        """Tell whether two orbits coincide, to their errors."""
        if not isinstance(one, PeriodicOrbit):
            return same_points(self.system, one.points, other.points, SAME)
        off, width = np.abs(one.points - other.points), domain_width(self.system)
        known = np.ptp(one.interval, axis=1) + np.ptp(other.interval, axis=1)
        off -= np.minimum(known, CLOSE * width)  # at a fold errors have no bound
        return bool((off <= SAME * (width + np.abs(one.points).max())).all())


def _beyond_fold(curve: Curve, row: int, orbit: PeriodicOrbit | PeriodicOrbitND) -> bool:
    """Tell whether Newton's method went past a fold: det(M - 1) has another sign than nearby."""
    own = orbit.multiplier if isinstance(orbit, PeriodicOrbit) else orbit.multipliers
    multipliers = (*curve.multipliers[row : row + 2], own)
    *beside, there = (off_multiplier(each, 1.0) for each in multipliers)
    return bool(there * max(beside, key=abs) < 0.0)


def orbit_follower(
    f: Any,
    name: str,
    low: float,
    high: float,
    max_step: float = MAX_STEP,
    max_points: int = MAX_POINTS,
) -> OrbitFollower:
    """Choose how orbits of a map meet its borders."""
    kind = SpaceOrbitFollower if isinstance(f, MapND) else LineOrbitFollower
    return kind(f, name, low, high, max_step, max_points)
