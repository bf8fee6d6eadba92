"""A condition as one curve in the plane of two parameters, ready for pseudo-arclength.

A walk may stop before the end of a curve, or step over a place where the border becomes another
one. From a point before, such a place is closed in on by short steps that never leave the orbit
and the border they started with.
"""

from __future__ import annotations

import contextlib
import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.bifurcations.conditions.conditions import Fold, fold_reading
from stickslip.analysis.bifurcations.conditions.locate import solve_near
from stickslip.analysis.bifurcations.conditions.orbit_paths import Path, bend, path_of
from stickslip.analysis.branches.along.tracked import ConditionLost, TrackedDiscontinuity
from stickslip.analysis.continuation.borders import FIRST_CHANGE
from stickslip.analysis.maps.protocol import Floats, domain_width
from stickslip.analysis.scales import DIFFERENCE, FINE, HALF_DIGITS, NEARBY

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.conditions.conditions import Condition, Reading
    from stickslip.analysis.branches.along.tracked import CriticalReading
    from stickslip.numerics.continuation import CurvePoint

MOST_DOUBTS: Final = 3  # such changes in a row, after which the gradient is taken anew
SMALLEST: Final = 0.25  # of the parameter solved for: its smallest scale, unless it is about 0 ...
LEAST: Final = 1e-3  # ... of its range, as of a domain: smallest scale of any unknown
LARGEST: Final = 10.0  # of either: its largest scale
CLOSER: Final = (1e-2, -1e-2, 1e-4, -1e-4)  # of that, where a break is in the way
ASIDE: Final = 1e-2  # of such a step: how far the curve may be from its tangent


@dataclass(frozen=True)
class Plane:
    """Two named parameters of a map: ``solve_for`` over ``along``."""

    system: Any  # a family of maps of a line, or of R^n
    along: str
    solve_for: str

    def map_at(self, q: float, s: float) -> Any:
        """Return the map with ``solve_for`` = q, ``along`` = s; `ConditionLost` out of range."""
        try:
            return self.system.replace(**{self.solve_for: q, self.along: s})
        except ValueError as reason:
            raise ConditionLost(str(reason)) from reason


@dataclass
class PlaneEquations:
    """The test function of a condition over y = (solve_for, along).

    A reading starts from the nearest accepted one. The gradient is kept up to date by what each
    reading tells about it (Broyden 1965), so that a point costs three or four readings.
    """

    plane: Plane
    accepted: list[tuple[Floats, Condition]]
    scale: Floats
    gradient: Floats
    last: tuple[Floats, float] | None = None
    doubts: int = 0

    @classmethod
    def at(cls, plane: Plane, start: Reading, q: float, s: float, width: float) -> PlaneEquations:
        """Set the scales (``width``: of ``along``), take the first gradient by differences."""
        here = np.array([q, s])
        steps = HALF_DIGITS * np.array([max(abs(q), LEAST * width), width])
        gradient = _gradient(plane, start.condition, here, steps)
        by_q, by_s = gradient.tolist()
        steep = width * abs(by_s / by_q) if by_q != 0 else math.inf
        scale = np.array([scale_between(steep, q, width), width])
        return cls(plane, [(here, start.condition)], scale, gradient)

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Reading]:
        """Return the test function, its gradient and the reading."""
        if self.doubts > MOST_DOUBTS:
            self.restart()
        reading = self.read(y)
        self._learn(y, reading.value)
        return np.array([reading.value]), self.gradient[None, :].copy(), reading

    def read(self, y: Floats) -> Reading:
        """Evaluate the condition from the nearest accepted reading."""
        distances = [float(np.linalg.norm((y - at) / self.scale)) for at, _ in self.accepted]
        condition = self.accepted[int(np.argmin(distances))][1]
        return condition.at(self.plane.map_at(float(y[0]), float(y[1])))

    def restart(self, y: Floats | None = None) -> None:
        """Take the gradient by differences, at an accepted point or the last one of these."""
        if y is None:
            here, condition = self.accepted[-1]
        else:
            here, condition = min(self.accepted, key=lambda at: float(np.abs(at[0] - y).max()))
        with contextlib.suppress(ConditionLost):
            self.gradient = _gradient(self.plane, condition, here, HALF_DIGITS * self.scale)
        self.last, self.doubts = None, 0

    def accept(self, y: Floats, reading: Reading) -> None:
        """Let later readings start from this one."""
        self.accepted.append((y.copy(), reading.condition))

    def unknowns(self, reading: Reading, q: float, s: float) -> Floats:
        """Return y for a reading at (q, s)."""
        return np.array([q, s])

    def _learn(self, y: Floats, value: float) -> None:
        if self.last is not None:
            step = (y - self.last[0]) / self.scale
            length = float(step @ step)
            if length > HALF_DIGITS**2:  # shorter ones tell no slopes, which may change fast
                slopes = self.gradient * self.scale
                change = (value - self.last[1] - slopes @ step) / length * step
                # A change larger than the gradient itself comes from a jump, and the point will be
                # rejected; or else the gradient is wrong.
                if float(change @ change) <= float(slopes @ slopes):
                    self.gradient = (slopes + change) / self.scale
                    self.doubts = 0
                else:
                    self.doubts += 1
        self.last = (y.copy(), value)


def scale_between(steep: float, q: float, width: float) -> float:
    """Bound the scale of the parameter solved for, known from the slope of the curve's start."""
    smallest = max(SMALLEST * abs(q), LEAST * width)
    return min(max(steep, smallest), LARGEST * max(abs(q), width))


def _gradient(plane: Plane, condition: Condition, at: Floats, steps: Floats) -> Floats:
    """Differentiate a test function by solve_for and along, from one side if the other is lost."""
    found = []
    for step in np.diag(steps):
        ends: list[tuple[float, float]] = []
        for sign in (1.0, 0.0, -1.0):
            with contextlib.suppress(ConditionLost):
                f = plane.map_at(*(at + sign * step).tolist())
                ends.append((sign, condition.at(f).value))
            if len(ends) == 2 and ends[0][0] == 1.0:
                break
        if len(ends) < 2:
            raise ConditionLost("there is no room for a curve around its start")
        (first, g_first), (last, g_last) = ends[0], ends[-1]
        found.append((g_first - g_last) / ((first - last) * float(step.sum())))
    return np.array(found)


@dataclass
class FoldEquations:
    """f^p(x) = x and (f^p)'(x) = 1 over y = (x, solve_for, along): regular at cusps, too."""

    plane: Plane
    period: int
    scale: Floats

    @classmethod
    def at(cls, plane: Plane, start: Reading, q: float, s: float, width: float) -> FoldEquations:
        """Set the scales; parameters as for `PlaneEquations.at`."""
        assert isinstance(start.condition, Fold)
        domain = domain_width(plane.system)
        rough = np.array([domain, max(abs(q), LEAST * width), width])
        equations = cls(plane, start.condition.period, rough)
        jacobian = equations(np.array([start.points[0], q, s]))[1]
        # How far x and solve_for move while along crosses its range.
        along = np.linalg.lstsq(jacobian[:, :2], -jacobian[:, 2], rcond=None)[0]
        moves, steep = (np.abs(along) * width).tolist()
        equations.scale[0] = min(max(moves, LEAST * domain), domain)
        equations.scale[1] = scale_between(steep, q, width)
        return equations

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Reading]:
        """Return both equations, their Jacobian and the reading."""
        x, q, s = map(float, y)
        f = self.plane.map_at(q, s)
        path, slope, curvature = bend(f, self.period, x, DIFFERENCE * domain_width(f))
        value = path.points[-1] - x
        steps = FIRST_CHANGE * self.scale
        columns = [self._moved(y, k, steps[k], path, slope) for k in (1, 2)]
        jacobian = np.column_stack([(slope - 1.0, curvature), *columns])
        return np.array([value, slope - 1.0]), jacobian, fold_reading(f, path, curvature, value)

    def restart(self, y: Floats | None = None) -> None:
        """Nothing to take anew: the Jacobian is exact everywhere."""

    def accept(self, y: Floats, reading: Reading) -> None:
        """Nothing to remember: x is an unknown."""

    def unknowns(self, reading: Reading, q: float, s: float) -> Floats:
        """Return y for a reading at (q, s)."""
        return np.array([reading.points[0], q, s])

    def _moved(self, y: Floats, k: int, step: float, at: Path, slope: float) -> tuple[float, float]:
        """Differentiate both equations by a parameter, where the orbit stays on its branches."""
        x, value = float(y[0]), at.points[-1] - at.points[0]
        for share in (1.0, -1.0, *CLOSER):
            moved = y.copy()
            moved[k] += share * step
            try:
                f = self.plane.map_at(float(moved[1]), float(moved[2]))
            except ConditionLost:
                # The range of the parameters ends here.
                continue
            path = path_of(f, x, self.period)
            if path.complete and path.labels == at.labels:
                there = path.points[-1] - x
                return (there - value) / (share * step), (path.slope - slope) / (share * step)
        raise ConditionLost(f"f^{self.period} is not smooth in the parameters beside {x:.12g}")


Equations: TypeAlias = PlaneEquations | FoldEquations


# ------------------------------------------------------------------ short steps, ends closed in on


def closest_to_end(equations: Equations, last: CurvePoint, step: float) -> CurvePoint:
    """Go on from the last point of a walk as far as there are points, halving a too long step."""
    while step > FINE:
        step *= 0.5
        try:
            last = moved(equations, last, step)
        except (ConditionLost, ValueError):
            continue
    return last


def moved(equations: Equations, last: CurvePoint, length: float) -> CurvePoint:
    """Solve for a point of the curve a short way along its tangent, of the same orbit."""
    plane, (scale_q, scale_s) = equations.plane, equations.scale[-2:]
    along_q, along_s = last.tangent[-2:]
    q, s = (last.y + length * equations.scale * last.tangent)[-2:].tolist()
    # Orthogonal to the curve in the scaled plane.
    normal = np.array([along_s * scale_q, -along_q * scale_s]) / math.hypot(along_q, along_s)
    near = NEARBY * domain_width(plane.system)
    first = last.note.condition.at(plane.map_at(q, s))
    if not _same(last.note, first, near):
        raise ConditionLost("another orbit")
    found = solve_near(
        first.condition,
        lambda t: plane.map_at(q + t * normal[0], s + t * normal[1]),
        0.0,
        step=ASIDE * abs(length),
    )
    if found.quality != "located" or not _same(last.note, found.reading, near):
        raise ConditionLost("another orbit")
    where = (q + found.value * normal[0], s + found.value * normal[1])
    return replace(last, y=equations.unknowns(found.reading, *where), note=found.reading)


def _same(a: Reading, b: Reading, near: float) -> bool:
    """Tell whether a reading is another one, a little moved."""
    away = float(np.max(np.abs(np.subtract(a.points, b.points))))
    kinds = [None if reading.critical is None else reading.critical.kind for reading in (a, b)]
    return (
        away <= near
        and kinds[0] == kinds[1]
        and not changed_labels(a, b)
        and not replaced_sides(a.critical, b.critical)
    )


def changed_labels(a: Reading, b: Reading) -> list[int]:
    """Return which of the points that a test function depends on have changed their branch."""
    pairs = zip(a.labels, b.labels, strict=False)
    return [i for i, (first, second) in enumerate(pairs) if first != second]


def replaced_sides(a: CriticalReading | None, b: CriticalReading | None) -> list[str]:
    """Sides of a border on which there is another branch than before."""
    old, new = (None if reading is None else reading.critical for reading in (a, b))
    if not (isinstance(old, TrackedDiscontinuity) and isinstance(new, TrackedDiscontinuity)):
        return []
    labels = {"left": (old.left_label, new.left_label), "right": (old.right_label, new.right_label)}
    return [side for side, (before, after) in labels.items() if before != after]
