"""Many periodic orbits of one map, of any periods, moved to another parameter value at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import Floats, Labels, Map1D, MapFamily

__all__ = ["Moved", "OrbitBundle", "move_orbits", "polish_orbits"]


@dataclass(frozen=True, eq=False)
class OrbitBundle:
    """k periodic orbits of one map; arrays are padded to the longest period P.

    Attributes
    ----------
    periods : ndarray of int, shape (k,)
    points, slopes : ndarray of float, shape (k, P)
        In the map's order; NaN beyond the period.
    labels : ndarray of uint64, shape (k, P)
        0 beyond the period.
    """

    periods: NDArray[np.intp]
    points: Floats
    slopes: Floats
    labels: Labels

    @classmethod
    def of(cls, orbits: Sequence[PeriodicOrbit], f: Map1D) -> OrbitBundle:
        """Gather orbits of the map f."""
        raise NotImplementedError

    @property
    def multipliers(self) -> Floats:
        """Product of each orbit's slopes, shape (k,)."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Moved:
    """Orbits after a change of the parameter; arrays of shape (k,).

    Attributes
    ----------
    bundle : OrbitBundle
        The orbits where they are now; meaningless where not `converged`.
    converged : ndarray of bool
        Newton's method has ended at a residual that rounding explains.
    same_labels : ndarray of bool
        All points are on the branches that they were on.
    distance : ndarray of float
        Largest move of a point from where it was.
    surprise : ndarray of float
        Largest move of a point from where the derivatives foretold it.
    """

    bundle: OrbitBundle
    converged: NDArray[np.bool_]
    same_labels: NDArray[np.bool_]
    distance: Floats
    surprise: Floats


def move_orbits(
    bundle: OrbitBundle, f: MapFamily, name: str, value: float
) -> tuple[MapFamily, Moved]:
    """Move orbits of the map f to another value of a parameter, together."""
    raise NotImplementedError


def polish_orbits(bundle: OrbitBundle, f: Map1D) -> Moved:
    """Solve for the orbits of the map f that are closest to those of a bundle."""
    raise NotImplementedError
