"""All-slipping motions of undamped blocks under constant friction: a family, not cycles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from scipy.linalg import eigh

from stickslip.mechanics.cycle.sliding import Model, steady_displacements
from stickslip.mechanics.model.arguments import state_vector
from stickslip.mechanics.model.plant import times
from stickslip.results.result import Result
from stickslip.results.table import numbered

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.numerics.arrays import Floats


N_SPEEDS: Final = 65  # at which a law is asked whether it is constant


@dataclass(frozen=True, eq=False, repr=False)
class NeutralFamily(Result):
    """Motions about steady sliding that neither grow nor decay: sums of harmonic modes.

    Every choice of amplitudes and phases is a motion of its own, up to those that graze the
    belt; beyond these a block sticks and the motion leaves the family.

    Attributes
    ----------
    x : ndarray of float, shape (N,)
        Displacements of steady sliding.
    V : float
    frequencies : ndarray of float, shape (N,)
        Ascending, units of sqrt(k / m).
    modes : ndarray of float, shape (N, N)
        Columns, each with largest entry 1.
    """

    x: Floats
    V: float
    frequencies: Floats
    modes: Floats
    _drawn: ClassVar = ("frequency", "boundary")

    @property
    def boundary(self) -> Floats:
        """Amplitude (of the block that moves most) at which each mode alone grazes, shape (N,)."""
        return np.asarray(self.V / self.frequencies)

    def amplitudes(self, x: ArrayLike, v: ArrayLike) -> Floats:
        """Amplitude of each mode in the motion through a state, shape (N,)."""
        offset = state_vector("x", x, self.x.size) - self.x
        cosine = np.linalg.solve(self.modes, offset)
        sine = np.linalg.solve(self.modes, state_vector("v", v, self.x.size)) / self.frequencies
        return np.hypot(cosine, sine)

    def clearance(self, x: ArrayLike, v: ArrayLike) -> float:
        """Least distance in velocity that a motion keeps from the belt, over all blocks.

        ``min_i V - sum_j |a_j phi_ij| omega_j``: exact where the frequencies have no common
        period, else a lower bound. The family ends where it is zero: the motion grazes.
        """
        speeds = np.abs(self.modes) @ (self.amplitudes(x, v) * self.frequencies)
        return float(self.V - speeds.max())

    def __repr__(self) -> str:
        """Frequencies, and where each mode alone grazes."""
        rows = [
            f"  frequency {w:.10g}, grazes the belt at amplitude {a:.10g}"
            for w, a in zip(self.frequencies, self.boundary, strict=True)
        ]
        return "\n".join([f"NeutralFamily: {len(rows)} modes about steady sliding", *rows])

    def _columns(self) -> dict[str, Any]:
        columns = {"frequency": self.frequencies, "boundary": self.boundary}
        return {**columns, **numbered("mode", self.modes.T)}


def neutral_family(model: Model) -> NeutralFamily | None:
    """Return the family of all-slipping motions; None unless undamped with constant friction."""
    plant = model.plant
    if not plant.dissipates or plant.damping.any():  # belts of several speeds among others
        return None
    speeds = np.linspace(0.0, 2.0 * model.V, N_SPEEDS)
    if any(np.asarray(law.slope(speeds)).any() for law in model.laws):
        return None
    squares, modes = eigh(plant.stiffness, times(plant.mass, np.eye(len(plant.mass))))
    largest = np.take_along_axis(modes, np.abs(modes).argmax(axis=0)[None], axis=0)
    return NeutralFamily(
        steady_displacements(model, model.V), model.V, np.sqrt(squares), modes / largest
    )
