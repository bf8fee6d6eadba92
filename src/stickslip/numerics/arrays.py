"""Names of the types of arrays, columns of them, points in intervals, a product, two numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, ClassVar, Final, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray

Floats: TypeAlias = NDArray[np.float64]
Ints: TypeAlias = NDArray[np.int64]
Complexes: TypeAlias = NDArray[np.complex128]

EPS: Final = float(np.finfo(np.float64).eps)
# As far from all fractions as a number can be: its multiples modulo 1 have no pattern.
GOLDEN: Final = 0.6180339887498949


class Columns:
    """Arrays of one length, the fields of a dataclass: of rows some are taken, others joined on."""

    __slots__ = ()
    if TYPE_CHECKING:
        __dataclass_fields__: ClassVar[dict[str, Any]]

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(getattr(self, next(iter(self.__dataclass_fields__))))

    def take(self, index: Any) -> Self:
        """Return the rows at an index, mask or slice."""
        return type(self)(*[getattr(self, name)[index] for name in self.__dataclass_fields__])

    def put(self, index: Any, other: Self) -> None:
        """Replace the rows at an index or mask."""
        for name in self.__dataclass_fields__:
            getattr(self, name)[index] = getattr(other, name)

    def replaced(self, where: Any, other: Self) -> Self:
        """Return a copy, the rows at an index or mask taken from another."""
        made = self.joined()
        made.put(where, other.take(where))
        return made

    def joined(self, *others: Self) -> Self:
        """Return the rows of all, one after the other."""
        names, parts = self.__dataclass_fields__, (self, *others)
        return type(self)(*[np.concatenate([getattr(p, name) for p in parts]) for name in names])


def interval_of(x: Floats, lefts: Floats, rights: Floats) -> NDArray[np.intp]:
    """Tell which of ascending intervals holds each point, of two the right one; -1 for none."""
    found = np.searchsorted(lefts, x, side="right") - 1
    return np.where((found >= 0) & (x <= np.append(rights, -np.inf)[found]), found, -1)


def applied(matrix: Floats, rows: Floats) -> Floats:
    """Return ``matrix @ row`` for each row, shape (..., m) for rows (..., n)."""
    # BLAS takes threads for many rows, which go on spinning for a tenth of a second beside ours.
    if rows.ndim == 1:
        return np.asarray(rows @ matrix.T)
    return np.asarray(np.einsum("...j,ij->...i", rows, matrix))
