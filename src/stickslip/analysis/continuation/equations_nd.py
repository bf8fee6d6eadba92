"""The equations of a periodic orbit of a map of R^n and a parameter, on its pieces of the map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.maps.protocol_nd import sample
from stickslip.analysis.orbits.newton_nd import shooting_matrix
from stickslip.analysis.orbits.orbits_nd import multipliers_of
from stickslip.numerics.continuation import LeavesRegion, StepTooLong
from stickslip.status import OK

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.maps.protocol import Floats, Labels
    from stickslip.analysis.maps.protocol_nd import FamilyND


@dataclass(frozen=True, eq=False)
class LinearizedND:
    """What a map says at the points of an orbit; shapes (p, n, n), (p, n), (p,)."""

    jacobians: Floats
    rates: Floats
    values: Floats
    labels: Labels

    @property
    def multipliers(self) -> NDArray[np.complex128]:
        """Eigenvalues of the Jacobian of f^p, largest modulus first."""
        return multipliers_of(self.jacobians)


@dataclass(frozen=True, eq=False)
class DepartureND:
    """Points that are on other pieces or have no value: the cause of a `LeavesRegion`."""

    y: Floats
    indices: tuple[int, ...]


@dataclass(eq=False)
class OrbitEquationsND:
    """F(x_1 ... x_p, q)_i = f(x_i; q) - x_(i+1), unknowns in one row with the parameter last."""

    f: FamilyND
    name: str
    pieces: list[set[int]]  # labels that each point may have

    def at(self, value: float) -> FamilyND:
        """Return the map at a value of the parameter."""
        return self.f.replace(**{self.name: float(value)})

    def points(self, y: Floats) -> Floats:
        """Return the points of an orbit, shape (p, n)."""
        return y[:-1].reshape(len(self.pieces), self.f.dimension)

    def __call__(self, y: Floats) -> tuple[Floats, Floats, LinearizedND]:
        """Evaluate F, its Jacobian and more; the cause of a `LeavesRegion` is a `DepartureND`."""
        f, points = self.at(y[-1]), self.points(y)
        values = sample(f, points)
        stays = [label in piece for label, piece in zip(values.label, self.pieces, strict=True)]
        inside = (values.status == OK) & np.array(stays, dtype=bool)
        if not inside.all():
            raise LeavesRegion(DepartureND(y.copy(), tuple(np.flatnonzero(~inside).tolist())))
        rates = np.asarray(f.parameter_derivative(points, self.name))
        if not (np.isfinite(rates).all() and np.isfinite(values.derivative).all()):
            raise StepTooLong("an infinite slope")
        jacobian = np.column_stack([shooting_matrix(values.derivative), rates.ravel()])
        residual = (values.value - np.roll(points, -1, axis=0)).ravel()
        note = LinearizedND(values.derivative, rates, values.value, values.label)
        return residual, jacobian, note
