"""Bifurcations of orbits in R^n, followed in the plane of two parameters.

Folds, flips and Neimark-Sacker bifurcations are one condition: a multiplier exp(i angle), the angle
0, pi or unknown. The other one is that a point of the orbit lies on a border of its piece.
"""

from __future__ import annotations

import sys
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.bifurcations.curves.curves import (
    KIND,
    PlaneFollower,
    PlaneProblem,
    checked_plane,
    other_parameter,
)
from stickslip.analysis.bifurcations.curves.plane_equations import (
    LEAST,
    Plane,
    scale_between,
)
from stickslip.analysis.continuation.curve import Curve, CurveEnd, Problem, between
from stickslip.analysis.continuation.follower import Passed, first_point
from stickslip.analysis.continuation.orbit_equations import Departure, Linearized, OrbitEquations
from stickslip.analysis.maps.protocol import lengths, measured, sample, widths
from stickslip.analysis.orbits.newton import shooting_matrix
from stickslip.analysis.scales import CLOSE, DIFFERENCE, FINE, NEARBY
from stickslip.numerics.continuation import CurvePoint, LeavesRegion, StepControl, WalkEnd
from stickslip.results.parts import part
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from stickslip.analysis.continuation.follower import Half, Test
    from stickslip.analysis.maps.protocol import Bools, FamilyND, Floats, Labels
    from stickslip.analysis.work import Work

CONTROL: Final = StepControl(first=0.01, smallest=1e-11, largest=1 / 32, patience=24)
ANGLES: Final = {"fold": 0.0, "flip": np.pi}
BORDERS: Final = ("border_collision", "enters_gap")
SHARES: Final = np.geomspace(1e-12, 0.1, 12)  # of the domain: ways to a border that are tried
PARTS: Final = 4  # of a bracket of a border, at once: maps may be expensive
ROUNDS: Final = sys.float_info.mant_dig // (PARTS.bit_length() - 1)  # ... down to rounding
ROUGHLY: Final = ROUNDS // 2  # ... for differences, on which only Newton's steps depend
RESONANCES: Final = {
    "resonance 1:1": 0.0,
    "resonance 1:2": np.pi,
    "resonance 1:3": 2 * np.pi / 3,
    "resonance 1:4": np.pi / 2,
}


@dataclass(frozen=True, eq=False)
class Critical:
    """An orbit beside a bifurcation: what a map says there, and its critical vectors."""

    orbit: Linearized
    angle: float
    left: NDArray[Any]
    right: NDArray[Any]
    bend: float  # how fast the critical multiplier moves in the direction of its vector

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """All, largest modulus first."""
        return self.orbit.multipliers

    def others(self, critical: complex) -> float:
        """Slope of the characteristic polynomial: zero where the critical multiplier is double.

        Known to rounding there, of which each of the two multipliers has half the digits.
        """
        off = self.multipliers - critical
        return float(sum(np.prod(np.delete(off, k)).real for k in range(len(off))))


@dataclass(eq=False)
class PlaneOrbit:
    """The equations f(x_i) = x_(i+1) over y = (x, maybe an angle, q, s), and a condition.

    In y, slopes and residuals points are measured in the map's lengths.
    """

    plane: Plane
    pieces: list[set[int]]
    size: Floats  # of the domain, (n,)
    widths: tuple[float, float]  # scales of q and s
    unit: Floats  # of y, (n,)

    def points(self, y: Floats) -> Floats:
        """Return the points of the orbit, (p, n)."""
        return y[: len(self.pieces) * len(self.size)].reshape(len(self.pieces), -1) * self.unit

    def accept(self, note: Critical) -> None:
        """Get ready for the neighbourhood of a point."""

    def orbit(self, f: FamilyND, points: Floats, s: float) -> tuple[Floats, Floats, Linearized]:
        """Return the residual of an orbit, its Jacobian by points, q and s, and the slopes."""
        equations = OrbitEquations(f, self.plane.along, self.pieces, self.unit)
        residual, jacobian, note = equations(equations.unknowns(points, s))
        by_q = np.asarray(f.parameter_derivative(points, self.plane.solve_for)) / self.unit
        return residual, np.insert(jacobian, -1, by_q.ravel(), axis=1), note

    def beside(self, q: float, s: float, share: float) -> list[list[FamilyND | None]]:
        """Return maps a share of the scales beside, in q, then in s; None where not allowed."""
        found: list[list[FamilyND | None]] = []
        for step in share * np.diag(self.widths):
            found.append([None, None])
            for k, way in enumerate((step, -step)):
                with suppress(LeavesRegion):
                    found[-1][k] = self.plane.map_at(*(np.array([q, s]) + way).tolist())
        return found


@dataclass(eq=False)
class CriticalEquations(PlaneOrbit):
    """The condition is a multiplier exp(i angle), which makes a cyclic matrix singular.

    The matrix with a border of nearly its null vectors is not, and what its inverse has in the
    corner vanishes (Govaerts 2000, chapter 4).
    """

    angle: float | None  # None: unknown
    border: tuple[NDArray[Any], NDArray[Any]] | None = None

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Critical]:
        """Return all equations, their Jacobian and what is known of the orbit."""
        points, (q, s) = self.points(y), y[-2:].tolist()
        angle = float(y[-3]) if self.angle is None else self.angle
        f, n = self.plane.map_at(q, s), len(self.size)
        residual, jacobian, note = self.orbit(f, points, s)
        multiplier: Any = np.exp(1j * angle) if self.angle is None else np.cos(angle)
        cyclic = shooting_matrix(note.slopes) + 0.0 * multiplier
        cyclic[-n:, :n] += (1.0 - multiplier) * np.eye(n)
        corner, left, right = self._bordered(cyclic)
        w, v = left.conj().reshape(points.shape), right.reshape(points.shape)
        slopes_by = self._second(f, points, q, s, note)
        rates = [-np.einsum("pa,...pab,pb->...p", w, each, v) for each in slopes_by]
        by_points = rates[0].T.ravel()
        row = np.append(by_points, [rates[1].sum(), rates[2].sum()])
        values, rows = [corner.real], [row.real]
        if self.angle is None:
            row = np.insert(row, -2, 1j * multiplier * (w[-1] @ v[0]))
            values, rows = [corner.real, corner.imag], [row.real, row.imag]
            jacobian = np.insert(jacobian, -2, 0.0, axis=1)
        bend = float((by_points @ right).real)
        critical = Critical(note, angle, left, right, bend)
        return np.append(residual, values), np.vstack([jacobian, *rows]), critical

    def accept(self, note: Critical) -> None:
        """Border the matrix with the newest null vectors."""
        self.border = note.left / np.linalg.norm(note.left), note.right / np.linalg.norm(note.right)

    def tests(self, follower: CriticalFollower) -> Iterator[tuple[str, Test]]:
        """Yield what multipliers and one second derivative tell."""
        if self.angle is None:
            for name, angle in RESONANCES.items():
                yield name, partial(_off_angle, angle)
        elif self.angle == 0.0:
            yield "cusp", lambda point: point.note.bend
            yield "resonance 1:1", lambda point: point.note.others(1.0)
            yield "fold-flip", follower.off_flip
        else:
            yield "resonance 1:2", lambda point: point.note.others(-1.0)
            yield "fold-flip", follower.off_fold

    def _bordered(self, cyclic: NDArray[Any]) -> tuple[Any, NDArray[Any], NDArray[Any]]:
        """Find the corner of a bordered inverse, and what are null vectors where it is zero."""
        if self.border is None:
            u, _, vh = np.linalg.svd(cyclic)
            self.border = u[:, -1], vh[-1].conj()
        b, c = self.border
        whole = np.block([[cyclic, b[:, None]], [c.conj()[None], np.zeros((1, 1))]])
        unit = np.eye(len(whole))[-1]
        right, left = np.linalg.solve(whole, unit), np.linalg.solve(whole.conj().T, unit)
        return right[-1], left[:-1], right[:-1]

    def _second(
        self, f: FamilyND, points: Floats, q: float, s: float, note: Linearized
    ) -> Iterator[Floats]:
        """Differentiate the Jacobians at an orbit by the coordinates, (n, p, n, n), by q and s."""
        ways = DIFFERENCE * np.diag(self.size)[:, None, :]
        sides: list[Any] = [sample(f, points + sign * ways) for sign in (1.0, -1.0)]
        yield self._difference(sides, note, DIFFERENCE * (self.size / self.unit)[:, None])
        for width, pair in zip(self.widths, self.beside(q, s, DIFFERENCE), strict=True):
            sides = [None if g is None else sample(g, points) for g in pair]
            yield self._difference(sides, note, DIFFERENCE * width)

    def _difference(self, sides: list[Any], note: Linearized, h: Any) -> Floats:
        """Differentiate Jacobians over h, from one side where the other is on another piece."""
        moved, inside = [], []
        for side in sides:
            known = side is not None
            own = known and (side.label == note.labels) & (side.status == OK)
            shape = np.shape(np.asarray(h) * np.ones(len(note.labels)))
            inside.append(np.broadcast_to(own, shape))
            there = measured(side.derivative, self.unit) if known else note.slopes
            moved.append(np.where(inside[-1][..., None, None], there, note.slopes))
        count = inside[0].astype(np.float64) + inside[1]
        if not count.all():
            raise LeavesRegion("the map is not smooth on either side of the orbit")
        return np.asarray((moved[0] - moved[1]) / (h * count)[..., None, None])


@dataclass(eq=False)
class BorderEquations(PlaneOrbit):
    """The condition is that a point of the orbit lies on a border, known by labels alone.

    Its test function is the way from the point to the border, in a fixed direction. Beyond it the
    map is continued by its slope just inside.
    """

    index: int = 0
    way: Any = None  # to the far side, as long as the domain

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Critical]:
        """Return all equations, their Jacobian and what is known of the orbit."""
        points, (q, s) = self.points(y), y[-2:].tolist()
        f, n, x = self.plane.map_at(q, s), len(self.size), self.points(y)[self.index]
        steps = DIFFERENCE * np.diag(self.size)
        distance = self._distance(f, x[None], ROUNDS)[0]
        ahead, behind = np.split(self._distance(f, np.concatenate([x + steps, x - steps])), 2)
        row = np.zeros(len(y))
        at = self.index * n
        row[at : at + n] = (ahead - behind) / (2 * DIFFERENCE * self.size / self.unit)
        for k, pair in enumerate(self.beside(q, s, DIFFERENCE)):
            here = [distance if g is None else self._distance(g, x[None])[0] for g in pair]
            count = sum(g is not None for g in pair)
            row[k - 2] = (here[0] - here[1]) / (count * DIFFERENCE * self.widths[k])
        inside = points.copy()  # the map is read just inside
        inside[self.index] += min(distance - FINE, 0.0) * self.way
        residual, jacobian, note = self.orbit(f, inside, s)
        shift = ((points - inside) / self.unit).ravel()
        residual = residual + jacobian[:, :-2] @ shift
        none = np.zeros(0)
        critical = Critical(note, np.nan, none, none, np.nan)
        return np.append(residual, distance), np.vstack([jacobian, row]), critical

    def tests(self, follower: CriticalFollower) -> Iterator[tuple[str, Test]]:
        """Yield where the colliding orbit also folds, flips or turns."""
        yield "multiplier 1", follower.off_fold
        yield "multiplier -1", follower.off_flip

    def _distance(self, f: FamilyND, x: Floats, rounds: int = ROUGHLY) -> Floats:
        """Measure the way from points (m, n) to the border, negative beyond it."""
        shares = np.append(-SHARES[::-1], np.append(0.0, SHARES))
        inside = self._inside(f, x, np.broadcast_to(shares, (len(x), len(shares))))
        if not (inside.any(axis=1) & ~inside.all(axis=1)).all():
            raise LeavesRegion("the border is lost")
        # The change nearest to the point, from inside to beyond.
        change = inside[:, :-1] & ~inside[:, 1:]
        off = np.where(change, np.abs(shares[:-1] + shares[1:]), np.inf)
        if not np.isfinite(off.min(axis=1)).all():
            raise LeavesRegion("the border is lost")
        k = np.argmin(off, axis=1)
        low, high = shares[k], shares[k + 1]
        for _ in range(rounds):
            trial = np.linspace(low, high, PARTS + 1, axis=1)
            # Ends are known; beyond the first change others may follow.
            within = self._inside(f, x, trial[:, 1:-1])
            k = np.argmin(np.column_stack([within, np.zeros(len(x), dtype=bool)]), axis=1)
            rows = np.arange(len(x))
            low, high = trial[rows, k], trial[rows, k + 1]
        return np.asarray(0.5 * (low + high))

    def _inside(self, f: FamilyND, x: Floats, shares: Floats) -> Bools:
        """Tell which points x + share way, (m, k), are on the orbit's own piece."""
        got = sample(f, x[:, None, :] + shares[..., None] * self.way)
        own = np.isin(got.label, np.array(sorted(self.pieces[self.index]), dtype=np.uint64))
        return np.asarray(own & (got.status == OK))

    def choose(self, y: Floats) -> bool:
        """Find which point is on a border, and its best direction; False if none is."""
        q, s = y[-2:].tolist()
        f, points, axes = self.plane.map_at(q, s), self.points(y), np.diag(self.size)
        for index in range(len(points)):
            for way in (*axes, *-axes):
                self.index, self.way = index, way
                near = self._inside(f, points[index, None], np.array([[-CLOSE, CLOSE]]))[0]
                if near[0] and not near[1]:
                    slopes = self(y)[1][-1, index * len(way) :][: len(way)]
                    k = int(np.argmax(np.abs(slopes) * self.size / self.unit))
                    self.way = -np.sign(slopes[k]) * axes[k]
                    return True
        return False


def _off_angle(angle: float, point: CurvePoint) -> float:
    return float(point.note.angle - angle)


class CriticalFollower(PlaneFollower):
    """Follows a bifurcation of an orbit in R^n in the plane of two parameters."""

    def start(self, points: Floats, labels: Labels, angle: float, q: float, s: float) -> CurvePoint:
        """Set out from a bifurcation; a ValueError if there is none nearby."""
        f: Any = self.plane.map_at(q, s)
        size, width = widths(f), self.high - self.low or 1.0
        unit = lengths(f)
        wrong = f"there is no such bifurcation near {self.name} = {s:.12g}: "
        pieces = [{label} for label in labels.tolist()]
        known = self.plane, pieces, size, (max(abs(q), 1e-3 * width), width), unit
        turn = [angle] if self.which == "neimark_sacker" else []
        y = np.concatenate([(points / unit).ravel(), turn, [q, s]])
        self.equations: CriticalEquations | BorderEquations
        if self.which in BORDERS:
            self.equations = border = BorderEquations(*known)
            if not border.choose(y):
                raise ValueError(f"{wrong}no point of the orbit is at a border of its piece.")
        else:
            self.equations = CriticalEquations(*known, ANGLES.get(self.which))
        try:
            jacobian = self.equations(y)[1]
        except LeavesRegion as left:
            raise ValueError(f"{wrong}{left.cause}.") from left
        # How far all else moves while the parameter crosses its range.
        moves = width * np.abs(np.linalg.lstsq(jacobian[:, :-1], -jacobian[:, -1], rcond=None)[0])
        domain = np.tile(size / unit, len(points))
        reach = np.clip(moves[: domain.size], LEAST * domain, domain)
        steep = scale_between(float(moves[-1]), q, width)
        scale = np.array([*reach, *np.ones(len(turn)), steep, width])
        self.equations.widths = steep, width
        self.curve = self.line(self.equations, scale)
        near = NEARBY * float((domain / reach).max())
        return first_point(self.curve, y, wrong, near, self.equations.points)

    def points(self, point: CurvePoint) -> Floats:
        """Return the points of the orbit."""
        return self.equations.points(point.y)

    def accept(self, here: CurvePoint, new: CurvePoint) -> None:
        """Get ready for the neighbourhood of the new point."""
        self.equations.accept(new.note)

    def restart(self, start: CurvePoint) -> None:
        """Return to the start."""
        self.equations.accept(start.note)

    def tests(self, here: CurvePoint, new: CurvePoint) -> Iterator[tuple[str, Test]]:
        """Points of codimension two."""
        return self.equations.tests(self)

    def passed(self, here: CurvePoint, new: CurvePoint) -> Iterator[Passed]:
        """End where a critical pair becomes real: beyond, the curve comes back mirrored."""
        for item in super().passed(here, new):
            kind = "" if item.event is None else item.event.kind
            ends = self.which == "neimark_sacker" and kind in ("resonance 1:1", "resonance 1:2")
            assert item.point is not None
            yield item._replace(end=self.end(item.point, kind)) if ends else item

    def stopped(self, stop: WalkEnd, half: Half) -> CurveEnd:
        """Say why a walk has ended."""
        if isinstance(stop.cause, Departure):
            return self.end(stop.last, "a point of the orbit meets a break of the map")
        return self.end(stop.last, str(stop.cause) if stop.cause else stop.reason)

    def described(self, rows: list[CurvePoint]) -> tuple[dict[str, Any], Problem]:
        """Return the angles of the critical multipliers, and labels."""
        angle = np.array([row.note.angle for row in rows])
        labels = np.array([row.note.orbit.labels for row in rows])
        return {"angle": angle, "labels": labels}, CriticalProblem(self.plane.system)


@part
@dataclass(frozen=True, eq=False)
class CriticalProblem(PlaneProblem):
    """A multiplier on the unit circle, of an orbit in R^n."""

    system: FamilyND | None

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Bifurcation:
        """Start from a straight line between two rows."""
        assert self.system is not None
        other = other_parameter(curve, name)
        kind: Any = curve.kind.removeprefix(KIND)
        follower = CriticalFollower(kind, Plane(self.system, name, other), value, value, CONTROL)
        columns = curve.points, curve.data["angle"], curve.parameters[other]
        points, angle, guess = (between(column, row, share) for column in columns)
        labels = curve.data["labels"][row]
        found = follower.start(points, labels, float(angle), float(guess), value)
        q, error = float(found.y[-2]), follower.solution_error(found, fixed=True)
        return Bifurcation(
            kind=kind,
            parameter=other,
            value=q,
            error=error,
            period=len(points),
            points=follower.points(found),
            interval=(q - error, q + error),
            multipliers=found.note.multipliers,
            residual=found.residual,
            system=self.system.replace(**{name: value, other: q}),
        )


def follow_bifurcation_nd(
    item: Bifurcation,
    system: FamilyND,
    name: str,
    range: tuple[float, float],
    *,
    solve_for: str,
    work: Work | None = None,
) -> Curve:
    """Follow a bifurcation of an orbit in R^n; see `stickslip.follow`."""
    plane, q, s = checked_plane(item, system, name, range, solve_for)
    if item.kind not in (*ANGLES, *BORDERS, "neimark_sacker"):
        raise ValueError(
            f"a bifurcation {item.kind!r} of a map of R^n is not followed in two parameters: "
            f"{', '.join((*ANGLES, 'neimark_sacker', *BORDERS))} are."
        )
    points, multipliers = np.asarray(item.points), np.asarray(item.multipliers)
    labels = sample(plane.map_at(q, s), points).label
    for orbit in (*item.orbits_after, *item.orbits_before):
        if item.kind in BORDERS and orbit.period == len(points):  # labels at the border are of both
            turns = [np.roll(orbit.points, k, axis=0) for k in np.arange(len(points))]
            off = [np.abs((each - points) / lengths(system)).max() for each in turns]
            turn = int(np.argmin(off))
            labels = np.roll(orbit.labels, turn)
    pairs = multipliers[multipliers.imag > 0]
    angle = float(np.angle(pairs[np.argmin(np.abs(np.abs(pairs) - 1.0))])) if pairs.size else 0.0
    follower = CriticalFollower(item.kind, plane, *range, CONTROL)
    first = follower.start(points, labels, angle, q, s)
    follower.restart(first)
    return follower.follow(first, work)
