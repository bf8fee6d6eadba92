"""A dimensionless motion read in physical units."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.results.result import Result

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.model.units import Quantity, Units


@dataclass(frozen=True, eq=False, repr=False)
class PhysicalTrajectory(Result):
    """A trajectory whose times, displacements, forces and energies are physical.

    ``TwoBlock.to_physical`` makes it; the names are those of `Trajectory`.

    Attributes
    ----------
    trajectory : Trajectory
        The dimensionless motion.
    units : Units
        The scales.
    """

    trajectory: Any
    units: Units
    _plot: ClassVar = "motion.plot_trajectory"

    @property
    def t(self) -> NDArray[np.float64]:
        """Ends of the phases of constant modes, shape (n + 1,)."""
        return self.units.to_physical("time", self.trajectory.t)

    @property
    def modes(self) -> NDArray[np.int64]:
        """Mode of each block in each phase, shape (n, 2): -1 backward, 0 stick, +1 forward."""
        modes: NDArray[np.int64] = self.trajectory.modes
        return modes

    @property
    def d(self) -> NDArray[np.float64]:
        """``x_2 - x_1`` of the global stick phases."""
        return self.units.to_physical("displacement", self.trajectory.d)

    @property
    def events(self) -> tuple[Any, ...]:
        """Changes of mode, their times physical."""
        scale = self.units.scale("time")
        return tuple(event._replace(time=scale * event.time) for event in self.trajectory.events)

    @property
    def slips(self) -> tuple[Any, ...]:
        """Slips between global stick phases; the moment is a displacement."""
        time, length = self.units.scale("time"), self.units.scale("displacement")
        return tuple(
            slip._replace(
                start=time * slip.start,
                duration=time * slip.duration,
                moment=length * slip.moment,
            )
            for slip in self.trajectory.slips
        )

    @property
    def status(self) -> int:
        """Why the motion ended: a code of `stickslip.status`."""
        return int(self.trajectory.status)

    def x(self, t: ArrayLike) -> NDArray[np.float64]:
        """Displacements of the blocks.

        Parameters
        ----------
        t : array_like of float, any shape
            Physical times within the motion.

        Returns
        -------
        ndarray of float64, shape (..., 2)
            Physical lengths.
        """
        return self._at("x", "displacement", t)

    def v(self, t: ArrayLike) -> NDArray[np.float64]:
        """Velocities of the blocks, shape (..., 2); as `x`."""
        return self._at("v", "velocity", t)

    def friction(self, t: ArrayLike) -> NDArray[np.float64]:
        """Friction force of the belt on each block, shape (..., 2); as `x`."""
        return self._at("friction", "force", t)

    def energy(self, t: ArrayLike) -> Any:
        """Energies of the motion, every field shaped like the times; as `x`."""
        energy = self.trajectory.energy(self._times(t))
        names = (field.name for field in fields(energy) if field.name != "t")
        scaled = {name: self.units.to_physical("energy", getattr(energy, name)) for name in names}
        return replace(energy, **scaled, t=self.units.to_physical("time", energy.t))

    def _at(self, name: str, quantity: Quantity, t: ArrayLike) -> NDArray[np.float64]:
        return self.units.to_physical(quantity, getattr(self.trajectory, name)(self._times(t)))

    def _times(self, t: ArrayLike) -> NDArray[np.float64]:
        """Dimensionless times; the end of the motion survives the division's rounding."""
        times = self.units.to_dimensionless("time", t)
        end = self.trajectory.t[-1]
        nearly = np.abs(times - end) <= 4.0 * np.spacing(end)
        return np.where(nearly, np.minimum(times, end), times)

    def __repr__(self) -> str:
        """Units, then the dimensionless motion."""
        return f"PhysicalTrajectory in {self.units!r}\n{self.trajectory!r}"

    def _columns(self) -> dict[str, Any]:
        columns = dict(self.trajectory.table())
        return {**columns, "time": self.units.to_physical("time", columns["time"])}
