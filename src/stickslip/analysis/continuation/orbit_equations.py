"""The equations of a periodic orbit and a parameter, inside one smooth piece of the map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.maps.protocol import sample
from stickslip.numerics.continuation import LeavesRegion, StepTooLong
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels, MapFamily


@dataclass(frozen=True, eq=False)
class Linearized:
    """What a map says at the points of an orbit; shapes (p,)."""

    slopes: Floats
    labels: Labels

    @property
    def multiplier(self) -> float:
        """Product of the slopes."""
        return float(self.slopes.prod())


@dataclass(frozen=True, eq=False)
class Departure:
    """Points outside their pieces (a virtual orbit): the cause of a `LeavesRegion`."""

    value: float
    points: Floats
    indices: tuple[int, ...]  # of these points


@dataclass(eq=False)
class OrbitEquations:
    """F(x_1 ... x_p, q)_i = f(x_i; q) - x_(i+1) of an admissible orbit, points in their pieces."""

    f: MapFamily
    name: str
    # labels that each point may have, smooth continuations of its branch included
    pieces: list[set[int]]

    def at(self, value: float) -> MapFamily:
        """Return the map at a value of the parameter."""
        return self.f.replace(**{self.name: float(value)})

    def __call__(self, y: Floats) -> tuple[Floats, Floats, Linearized]:
        """Evaluate F, its Jacobian and more; the cause of a `LeavesRegion` is a `Departure`."""
        f, points = self.at(y[-1]), y[:-1]
        values = sample(f, points)
        inside = self.stays(values.label, values.status == OK)
        if not inside.all():
            gone = tuple(np.flatnonzero(~inside).tolist())
            raise LeavesRegion(Departure(float(y[-1]), points.copy(), gone))
        rates = np.asarray(f.parameter_derivative(np.clip(points, *f.domain), self.name))
        if not (np.isfinite(rates).all() and np.isfinite(values.derivative).all()):
            raise StepTooLong("an infinite slope")
        p = len(points)
        jacobian = np.zeros((p, p + 1))
        i = np.arange(p)
        jacobian[i, i] = values.derivative
        jacobian[i, (i + 1) % p] -= 1.0
        jacobian[:, p] = rates
        residual = values.value - np.roll(points, -1)
        return residual, jacobian, Linearized(values.derivative, values.label)

    def stays(self, labels: Labels, ok: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Tell which points have a value and are on their pieces, shape (p,)."""
        known = [label in piece for label, piece in zip(labels.tolist(), self.pieces, strict=True)]
        return ok & np.array(known, dtype=bool)
