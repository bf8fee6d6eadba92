"""Physical scales: what one dimensionless unit is (definitions under eq. 6a)."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from math import sqrt
from typing import TYPE_CHECKING, Any, ClassVar, Literal, get_args

import numpy as np

from stickslip.checks import finite_number, one_of, real_numbers
from stickslip.results.parts import part
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


Quantity = Literal[
    "displacement", "time", "frequency", "velocity", "acceleration", "force", "energy"
]


@part
@suggests
@dataclass(frozen=True)
class Units:
    """Scales that make the two-block system dimensionless.

    Any coherent set works (SI: kg, N/m, N). With X = k x / f_s1 and
    tau = sqrt(k / m) t every other scale follows, see `scale`.

    Parameters
    ----------
    m : float
        Mass of a block, > 0.
    k : float
        Stiffness of a support spring, > 0.
    fs1 : float
        Static limit of block 1, > 0.

    Notes
    -----
    Galvanetto (2001), definitions under eq. (6a). The printed
    "tau = sqrt(k/mt)" is a misprint: only sqrt(k/m) t is dimensionless, and only
    it gives d/dt = sqrt(k/m) d/dtau, printed in the same sentence.

    A law given in physical slip speeds becomes dimensionless through the velocity
    scale ``u = units.scale("velocity")``: a coefficient per speed is multiplied by
    u (gamma, viscous), one per speed squared by u**2 (eta), a speed divided by u.
    Shares of the static limit (mu, delta) stay.

    Examples
    --------
    >>> units = Units(m=2.0, k=8.0, fs1=4.0)
    >>> units.scale("displacement"), units.scale("time"), units.scale("velocity")
    (0.5, 0.5, 1.0)
    >>> float(units.to_physical("force", 0.25))
    1.0
    """

    m: float
    k: float
    fs1: float

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        reasons = {
            "m": "A block without mass has no equation of motion.",
            "k": "The support spring's stiffness sets the scales of length and time.",
            "fs1": "The static limit of block 1 sets the scale of force.",
        }
        for name, why in reasons.items():
            value = finite_number(name, getattr(self, name), above=0.0, why=why)
            object.__setattr__(self, name, value)

    def scale(self, quantity: Quantity) -> float:
        """Physical size of one dimensionless unit.

        Parameters
        ----------
        quantity : str
            ``"displacement"`` f_s1/k, ``"time"`` sqrt(m/k), ``"frequency"``
            sqrt(k/m), ``"velocity"`` f_s1/sqrt(k m), ``"acceleration"`` f_s1/m,
            ``"force"`` f_s1 or ``"energy"`` f_s1^2/k.

        Returns
        -------
        float
            In the units in which m, k and fs1 were given.

        Raises
        ------
        ValueError
            Unknown quantity.
        """
        one_of("quantity", quantity, get_args(Quantity))
        match quantity:
            case "displacement":
                return self.fs1 / self.k
            case "time":
                return sqrt(self.m / self.k)
            case "frequency":
                return sqrt(self.k / self.m)
            case "velocity":
                return self.fs1 / sqrt(self.k * self.m)
            case "acceleration":
                return self.fs1 / self.m
            case "force":
                return self.fs1
        return self.fs1**2 / self.k  # of energy

    def to_physical(self, quantity: Quantity, value: ArrayLike) -> NDArray[np.float64]:
        """Multiply dimensionless values by their scale.

        Parameters
        ----------
        quantity : str
            As in `scale`.
        value : array_like of float, any shape
            Dimensionless.

        Returns
        -------
        ndarray of float64, same shape
            Physical.
        """
        return np.multiply(real_numbers("value", value), self.scale(quantity), dtype=np.float64)

    def to_dimensionless(self, quantity: Quantity, value: ArrayLike) -> NDArray[np.float64]:
        """Divide physical values by their scale: the inverse of `to_physical`.

        Parameters
        ----------
        quantity : str
            As in `scale`.
        value : array_like of float, any shape
            Physical.

        Returns
        -------
        ndarray of float64, same shape
            Dimensionless.
        """
        return np.divide(real_numbers("value", value), self.scale(quantity), dtype=np.float64)


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
        """Units, then the motion, its times physical."""
        motion = self.trajectory._told(self.t[-1], self.events)
        return f"PhysicalTrajectory in {self.units!r}\n{motion}"

    def _columns(self) -> dict[str, Any]:
        columns = dict(self.trajectory.table())
        return {**columns, "time": self.units.to_physical("time", columns["time"])}
