"""Periodic orbits of maps of R^n followed along a parameter, through folds, to where they end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, Literal

import numpy as np

from stickslip.analysis.continuation.continuation import checked_steps
from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent
from stickslip.analysis.continuation.equations_nd import DepartureND, LinearizedND, OrbitEquationsND
from stickslip.analysis.continuation.orbit_curve_nd import OrbitProblemND
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.protocol_nd import sample
from stickslip.numerics.continuation import (
    ArclengthCurve,
    CurvePoint,
    LeavesRegion,
    StepControl,
    StepTooLong,
    turns_back,
)
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, PointValues
    from stickslip.analysis.maps.protocol_nd import FamilyND
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
    from stickslip.numerics.continuation import WalkEnd

BENDS: Final = 0.5  # an entry of a Jacobian changes at most so much per step, beside 1 + abs(it)
ORBIT_OF_MAP: Final = 1e-6  # scaled: the orbit given must be so close to one of the map
# A border is approached by halving steps that cross it, down to little more than the error of a
# point; then a little further on the way the cause is seen.
SMALLEST: Final = 2e-12
PROBES: Final = (2e-11, 2e-10, 2e-9, 2e-8)
MAX_BORDERS: Final = 200  # ends of pieces that are passed because the map is smooth there
BEYOND: Final = (1e-5, 1e-7)  # scaled ways past a border at which the two sides are compared
SMOOTH: Final = 1e-9  # a larger difference of values is a jump ...
JUMPS: Final = 0.5  # ... if it does not shrink with the way as that of a root-like corner does
SAME_SLOPE: Final = 1e-3  # of Jacobians, beside 1 + their size: a larger difference is a corner
HALF: Final = 1e-5  # scaled: points half a period apart that coincide at a fold
ON_CIRCLE: Final = 1e-6  # modulus of a critical pair, and its distance from the real axis


def follow_orbit_nd(
    orbit: PeriodicOrbitND,
    f: FamilyND,
    name: str,
    range: tuple[float, float],
    *,
    max_step: float | None = None,
    max_points: int | None = None,
) -> Curve:
    """Follow a periodic orbit of a map of R^n along a parameter; see `stickslip.follow`.

    Pseudo-arclength with all points of the orbit as unknowns and exact derivatives. Where a
    point of the orbit gets to another piece of the map the two sides are compared: a map that is
    smooth there is followed on, else the curve ends in a border collision, located by halving
    to its `error`.
    """
    low, high = checked_range(f, name, range)
    step, most = checked_steps(max_step, max_points)
    follower = _Follower(f, name, low, high, step, most)
    start = follower.start(orbit)
    ahead = follower.go(start)
    behind = follower.go(start.reversed())
    rows = [*reversed(behind.rows), _Row(start), *ahead.rows]
    return follower.joined(rows, behind, ahead)


@dataclass(frozen=True, eq=False)
class _Row:
    point: CurvePoint
    kind: str | None = None


@dataclass(eq=False)
class _Half:
    """A curve to one side of its start, which is not part of it."""

    rows: list[_Row] = field(default_factory=list)
    end: CurveEnd | None = None


class _Follower:
    """Follows one orbit of a map along a parameter."""

    def __init__(
        self, f: FamilyND, name: str, low: float, high: float, max_step: float, max_points: int
    ) -> None:
        self.f, self.name, self.low, self.high = f, name, low, high
        first = min(0.01, max_step)
        self.control = StepControl(
            first=first, smallest=SMALLEST, largest=max_step, patience=max_points
        )
        self.max_points = max_points
        self.pending: list[_Row] = []
        self.halved = False

    def start(self, orbit: PeriodicOrbitND) -> CurvePoint:
        """Set out from an orbit, the parameter rising; a ValueError if the map has none there."""
        value = float(self.f.parameters[self.name])
        if not self.low <= value <= self.high:
            raise ValueError(
                f"range = ({self.low:.12g}, {self.high:.12g}) does not contain {self.name} = "
                f"{value:.12g}, at which the map and its orbit are given."
            )
        pieces = [{label} for label in sample(self.f, orbit.points).label.tolist()]
        self.equations = OrbitEquationsND(self.f, self.name, pieces)
        size = np.ptp(self.f.spread(256), axis=0)
        scale = np.append(np.tile(size, orbit.period), self.high - self.low)
        self.curve = ArclengthCurve(
            self.equations, scale, self.low, self.high, self.control, self._accept
        )
        y = np.append(orbit.points.ravel(), value)
        wrong = f"the map has no such orbit at {self.name} = {value:.15g}: "
        try:
            found = self.curve.point(y)
        except (StepTooLong, LeavesRegion) as reason:
            raise ValueError(f"{wrong}Newton's method does not converge.") from reason
        if np.abs((found.y - y) / scale).max() > ORBIT_OF_MAP:
            raise ValueError(f"{wrong}the nearest one is at {found.y[:-1]}.")
        return found

    def go(self, start: CurvePoint) -> _Half:
        """Follow the orbit from a start in the direction of its tangent."""
        half, here = _Half(), start
        for _ in range(MAX_BORDERS):
            stop = self._walk(here, half)
            if half.end is not None:
                return half
            assert stop is not None
            onward = self._stopped(stop, half)
            if onward is None:
                return half
            here = onward
        half.end = self._end(here, "step limit")
        return half

    def _walk(self, here: CurvePoint, half: _Half) -> WalkEnd | None:
        """Walk as far as it goes; None if the half branch has its end."""
        walk = self.curve.walk(here)
        while True:
            try:
                new = next(walk)
            except StopIteration as stop:
                result: WalkEnd = stop.value
                return result
            half.rows += self.pending
            if self.halved:
                half.end = self._end(self.pending[-1].point, "period halves")
                return None
            half.rows.append(_Row(new))
            if len(half.rows) >= self.max_points:
                half.end = self._end(new, "point limit")
                return None

    # ------------------------------------------------------------------ on the way

    def _accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Look at a step: no Jacobian may change by much; note what it passes."""
        before, after = here.note.jacobians, new.note.jacobians
        if (np.abs(after - before) > BENDS * (1 + np.minimum(abs(before), abs(after)))).any():
            raise StepTooLong("a slope changes")
        self.halved = False
        passed = self._passed(here, new)
        self.pending = [_Row(point, kind) for kind, point in passed]

    def _passed(self, here: CurvePoint, new: CurvePoint) -> list[tuple[str | None, CurvePoint]]:
        """Solve for the bifurcations between two neighbours, in their order."""
        found = list(self._bifurcations(here, new))
        chord = (new.y - here.y) / self.curve.scale
        places = [float((point.y - here.y) / self.curve.scale @ chord) for _, point in found]
        return [found[k] for k in np.argsort(places)]

    def _bifurcations(
        self, here: CurvePoint, new: CurvePoint
    ) -> Iterator[tuple[str | None, CurvePoint]]:
        if turns_back(here, new):
            point = self.curve.turning_point(here, new)
            self.halved = self._is_halved(point)
            yield ("fold" if not self.halved else None), point
        tests: Sequence[tuple[str, Callable[[CurvePoint], float]]] = (
            ("flip", _off_flip),
            ("neimark_sacker", _off_circle),
        )
        for kind, test in tests:
            if test(here) * test(new) < 0:
                point = self.curve.between(here, new, test)
                if kind == "flip" or _has_critical_pair(point):
                    yield kind, point

    def _is_halved(self, point: CurvePoint) -> bool:
        """Whether points half a period apart coincide."""
        points = self.equations.points(point.y)
        p = len(points)
        apart = (points - np.roll(points, p // 2, axis=0)).ravel() / self.curve.scale[:-1]
        return p % 2 == 0 and bool(np.abs(apart).max() < HALF)

    # ------------------------------------------------------------------ ends

    def _end(
        self, point: CurvePoint, reason: str, index: int | None = None, error: float = 0.0
    ) -> CurveEnd:
        points = self.equations.points(point.y)
        where = {self.name: point.parameter}
        return CurveEnd(reason, where, points, point.note.multipliers, error, index)

    def _stopped(self, stop: WalkEnd, half: _Half) -> CurvePoint | None:
        """Find out what ended a walk; return where to go on from, if that was nothing."""
        last = stop.last
        if stop.reason == "end of range":
            half.end = self._end(last, "end of range")
            return None
        departure = self._departure(last)
        if departure is None:
            half.end = self._end(last, "step limit")
            return None
        cause, way = departure
        index = int(cause.indices[0])
        error = abs(way * float(self.curve.scale[-1] * last.tangent[-1]))
        error += 2 * float(np.spacing(abs(last.parameter)))
        beyond = self._beyond(last, cause)
        if beyond is None:
            inside = self.f.contains(self.equations.points(cause.y))[index]
            reason: str = "gap" if inside else "end of domain"
            half.end = self._end(last, reason, index, error)
            return None
        kind, label = beyond
        if kind == "smooth":
            self.equations.pieces[index].add(label)
            return replace(last, step=self.control.first)
        half.end = replace(self._end(last, "breakpoint", index, error), kind=kind)
        return None

    def _departure(self, last: CurvePoint) -> tuple[DepartureND, float] | None:
        """Which points leave their pieces just past the end of a walk, and how far past."""
        for way in PROBES:
            try:
                self.equations(last.y + way * self.curve.scale * last.tangent)
            except LeavesRegion as left:
                cause: DepartureND = left.cause
                return cause, way
            except StepTooLong:
                continue
        return None

    def _beyond(
        self, last: CurvePoint, cause: DepartureND
    ) -> tuple[Literal["jump", "corner", "smooth"], int] | None:
        """Compare the two sides of the border that a point meets; None without a value there."""
        index = cause.indices[0]
        far, near = (self._other_side(last, index, way) for way in BEYOND)
        if far is None or near is None:
            return None
        note: LinearizedND = last.note
        slope = note.jacobians[index]
        gaps = [float(np.abs(side.value - note.values[index]).max()) for side in (far, near)]
        label = int(near.label)
        if gaps[1] > max(SMOOTH, JUMPS * gaps[0]):
            return "jump", label
        if (np.abs(near.derivative - slope) > SAME_SLOPE * (1 + np.abs(slope))).any():
            return "corner", label
        return "smooth", label

    def _other_side(self, last: CurvePoint, index: int, way: float) -> PointValues | None:
        """Value past a border, led back to it by the slopes there; and these slopes."""
        y = last.y + way * self.curve.scale * last.tangent
        f, x = self.equations.at(y[-1]), self.equations.points(y)[index]
        values = sample(f, x)
        if values.status != OK:
            return None
        dx = x - self.equations.points(last.y)[index]
        rate = np.asarray(f.parameter_derivative(x, self.name))
        back = values.value - values.derivative @ dx - rate * (y[-1] - last.y[-1])
        return replace(values, value=back)

    # ------------------------------------------------------------------ the curve

    def joined(self, rows: Sequence[_Row], behind: _Half, ahead: _Half) -> Curve:
        """Put rows and ends together."""
        assert behind.end is not None
        assert ahead.end is not None
        points = np.array([self.equations.points(row.point.y) for row in rows])
        multipliers = np.array([row.point.note.multipliers for row in rows])
        passed = tuple(
            CurveEvent(
                row.kind, {self.name: row.point.parameter}, points[k], multipliers[k], math.nan, k
            )
            for k, row in enumerate(rows)
            if row.kind is not None
        )
        return Curve(
            kind="orbit",
            period=points.shape[1],
            parameters={self.name: np.array([row.point.parameter for row in rows])},
            points=points,
            multipliers=multipliers,
            stable=np.asarray(np.abs(multipliers).max(axis=1) < 1.0),
            ends=(behind.end, ahead.end),
            bifurcations=passed,
            data={
                "labels": np.array([row.point.note.labels for row in rows]),
                "residual": np.array([row.point.residual for row in rows]),
            },
            problem=OrbitProblemND(self.f),
        )


def _off_flip(point: CurvePoint) -> float:
    """det(M + 1), zero where a multiplier is -1."""
    multipliers: NDArray[np.complex128] = point.note.multipliers
    return float(np.prod(multipliers + 1.0).real)


def _off_circle(point: CurvePoint) -> float:
    """Product of m_i m_j - 1 over pairs: zero where two multipliers have the product 1."""
    m: Floats = point.note.multipliers
    first, second = np.triu_indices(len(m), 1)
    return float(np.prod(m[first] * m[second] - 1.0).real) if len(m) > 1 else 1.0


def _has_critical_pair(point: CurvePoint) -> bool:
    """Whether multipliers lie on the unit circle off the real axis (else m and 1/m are real)."""
    m = point.note.multipliers
    on = np.abs(np.abs(m) - 1.0) < ON_CIRCLE
    return bool((on & (np.abs(m.imag) > ON_CIRCLE)).any())
