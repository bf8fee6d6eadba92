"""The equations of a periodic orbit and a parameter, inside smooth pieces of the map, in R^n."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analysis.maps.protocol import MapND, apart, measured, sample
from stickslip.analysis.orbits.newton import shooting_matrix
from stickslip.analysis.orbits.orbits_nd import multipliers_of
from stickslip.numerics.continuation import LeavesRegion, StepTooLong
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Bools, Floats, Labels, PointValues


@dataclass(frozen=True, eq=False)
class Linearized:
    """What a map says at the points of an orbit; shapes (p,) and (p,), or (p, n, n) and (p, n)."""

    slopes: Floats  # of points measured in the equations' units
    values: Floats
    labels: Labels
    margin: float = math.nan  # the least: how close the orbit is to a change of labels

    @property
    def multipliers(self) -> Any:
        """On a line the product of the slopes; all, largest modulus first, in R^n."""
        return float(self.slopes.prod()) if self.slopes.ndim == 1 else multipliers_of(self.slopes)

    def turned(self, turn: int) -> Linearized:
        """Start the orbit at another of its points."""
        slopes, values = (np.roll(each, turn, axis=0) for each in (self.slopes, self.values))
        return Linearized(slopes, values, np.roll(self.labels, turn), self.margin)


@dataclass(frozen=True, eq=False)
class Departure:
    """Points outside their pieces (a virtual orbit): the cause of a `LeavesRegion`."""

    value: float
    points: Floats
    indices: tuple[int, ...]  # of these points


@dataclass(eq=False)
class OrbitEquations:
    """F(x_1 ... x_p, q)_i = f(x_i; q) - x_(i+1) of an admissible orbit, points in their pieces."""

    f: Any  # a family of maps, of a line if it has no dimension
    name: str
    # labels that each point may have, smooth continuations of its branch included
    pieces: list[set[int]]
    unit: Any = 1.0  # of each coordinate, in R^n: of points in y, of F and of slopes

    def __post_init__(self) -> None:
        """Find out how points are kept."""
        self.on_line = not isinstance(self.f, MapND)

    def at(self, value: float) -> Any:
        """Return the map at a value of the parameter."""
        return self.f.replace(**{self.name: float(value)})

    def points(self, y: Floats) -> Floats:
        """Return the points of an orbit, shape (p,), or (p, n) in R^n."""
        return y[:-1] if self.on_line else y[:-1].reshape(len(self.pieces), -1) * self.unit

    def unknowns(self, points: Floats, value: float) -> Floats:
        """Return what stands for an orbit at a value of the parameter."""
        return np.append((points / self.unit).ravel(), value)

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Linearized]:
        """Evaluate F, its Jacobian and more; the cause of a `LeavesRegion` is a `Departure`."""
        f, points = self.at(y[-1]), self.points(y)
        values = sample(f, points)
        inside = self.stays(values.label, values.status == OK)
        if not inside.all():
            gone = tuple(np.flatnonzero(~inside).tolist())
            raise LeavesRegion(Departure(float(y[-1]), points.copy(), gone))
        held = np.clip(points, *f.domain) if self.on_line else points
        rates = np.asarray(f.parameter_derivative(held, self.name))
        if not (np.isfinite(rates).all() and np.isfinite(values.derivative).all()):
            raise StepTooLong("an infinite slope")
        n = 1 if self.on_line else points.shape[1]
        residual, note = self.described(points, values)
        by_points = shooting_matrix(note.slopes.reshape(-1, n, n))
        return residual, np.column_stack([by_points, (rates / self.unit).ravel()]), note

    def described(self, points: Floats, values: PointValues) -> tuple[Floats, Linearized]:
        """Return F, and what a map said at points."""
        residual = apart(self.f, values.value, np.roll(points, -1, axis=0)) / self.unit
        slopes = measured(values.derivative, self.unit)
        parts = slopes, values.value, values.label, float(np.min(values.margin))
        return residual.ravel(), Linearized(*parts)

    def stays(self, labels: Labels, ok: Bools) -> Bools:
        """Tell which points have a value and are on their pieces, shape (p,)."""
        known = [label in piece for label, piece in zip(labels.tolist(), self.pieces, strict=True)]
        return ok & np.array(known, dtype=bool)
