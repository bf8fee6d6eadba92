"""Two blocks on a moving belt: the paper's model (eqs. 5a-10) as immutable numbers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stickslip.checks import instance, model_number, shown
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.belt_model import BeltModel, Friction, belt_velocity, laws_of
from stickslip.mechanics.model.blocks import Chain
from stickslip.mechanics.model.plant import Plant
from stickslip.mechanics.model.units import PhysicalTrajectory, Units
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.eventmap.event_map import EventMap


@suggests
@dataclass(frozen=True)
class TwoBlock(BeltModel):
    """Two equal blocks on a moving belt, each held by a spring and coupled by a third.

    Parameters
    ----------
    alpha : float
        Coupling ratio k12 / k, >= 0.
    beta : float
        Static-friction ratio f_s2 / f_s1, > 0.
    V : float
        Driving velocity in units of f_s1 / sqrt(k m), > 0.
    friction : FrictionLaw or pair of FrictionLaw
        Kinetic friction relative to each block's own static limit: one law for
        both blocks (eq. 10), or one for block 1 and one for block 2.
    units : Units, optional
        Physical scales, kept by `from_physical` for the way back.
    damping : float
        Coefficient of a damper from each block to its support, in units of sqrt(k m), >= 0.

    Raises
    ------
    ValueError
        A parameter is not a finite number in its range, or `friction` is not a
        law or a pair of laws.

    Notes
    -----
    Galvanetto (2001), eqs. (5a)-(10), with the friction force on block i
    opposing its slip and L = (1, beta) the static limits::

        stick     X_i' = V                                         while |R_i| < L_i
        slip      X_i'' + R_i = -sign(w_i) L_i F(|w_i|),           w_i = X_i' - V
        springs   R_i = X_i + alpha (X_i - X_j)

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
    >>> model.parameters
    {'alpha': 1.2, 'beta': 1.3, 'V': 0.0366, 'mu': 0.22}
    >>> model.replace(V=0.037).V
    0.037
    """

    alpha: float
    beta: float
    V: float
    friction: Friction
    units: Units | None = None
    damping: float = 0.0
    forcing = None

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        checked = {
            "alpha": model_number(
                "alpha",
                self.alpha,
                at_least=0.0,
                why="alpha = k12 / k is a ratio of spring stiffnesses; 0 uncouples the blocks.",
            ),
            "beta": model_number(
                "beta",
                self.beta,
                above=0.0,
                why="beta = f_s2 / f_s1 is a ratio of static friction limits.",
            ),
            "V": belt_velocity(self.V),
            "damping": model_number(
                "damping", self.damping, at_least=0.0, why="A damper takes energy."
            ),
            "friction": laws_of(self.friction, 2),
        }
        if self.units is not None and not isinstance(self.units, Units):
            raise ValueError(f"units = {shown(self.units)} must be a Units(m=, k=, fs1=) or None.")
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._check_law_names()

    @classmethod
    def from_physical(
        cls,
        *,
        m: float,
        k: float,
        k12: float,
        fs1: float,
        fs2: float,
        v_dr: float,
        friction: Friction,
        c: float = 0.0,
    ) -> Self:
        """Build the dimensionless model from physical quantities (definitions under eq. 6a).

        Parameters
        ----------
        m, k : float
            Mass of a block and stiffness of its support spring, > 0.
        k12 : float
            Stiffness of the coupling spring, >= 0.
        fs1, fs2 : float
            Static friction limits of the blocks, > 0.
        v_dr : float
            Velocity of the belt, > 0.
        friction : FrictionLaw or pair of FrictionLaw
            In dimensionless form: force over the block's static limit as a
            function of dimensionless slip speed. `Units` says how coefficients
            known in physical speeds convert.
        c : float
            Coefficient of a damper from each block to its support, >= 0.

        Returns
        -------
        TwoBlock
            With ``units`` set, so that `to_physical` needs nothing else.

        Raises
        ------
        ValueError
            A quantity is not a finite number in its range; the physical name is given.
        """
        units = Units(m=m, k=k, fs1=fs1)
        k12 = model_number("k12", k12, at_least=0.0, why="A spring's stiffness is not negative.")
        fs2 = model_number("fs2", fs2, above=0.0, why="A static friction limit is positive.")
        v_dr = belt_velocity(v_dr, "v_dr")
        c = model_number("c", c, at_least=0.0, why="A damper takes energy.")
        return cls(
            alpha=k12 / units.k,
            beta=fs2 / units.fs1,
            V=v_dr / units.scale("velocity"),
            friction=friction,
            units=units,
            damping=c * units.scale("velocity") / units.fs1,
        )

    def physical_parameters(self, units: Units | None = None) -> dict[str, float]:
        """Physical quantities of this model, by the names that `from_physical` takes.

        Parameters
        ----------
        units : Units, optional
            Scales; by default those of `from_physical`.

        Returns
        -------
        dict of str to float
            ``m, k, k12, fs1, fs2, v_dr``, and ``c`` where there is damping.

        Raises
        ------
        ValueError
            The model has no scales and none are given.
        """
        units = self._units(units)
        numbers = {
            "m": units.m,
            "k": units.k,
            "k12": self.alpha * units.k,
            "fs1": units.fs1,
            "fs2": self.beta * units.fs1,
            "v_dr": self.V * units.scale("velocity"),
        }
        if self.damping > 0.0:
            numbers["c"] = self.damping * units.fs1 / units.scale("velocity")
        return numbers

    def to_physical(self, trajectory: Any, units: Units | None = None) -> PhysicalTrajectory:
        """Read a motion of this model in physical units.

        Parameters
        ----------
        trajectory : Trajectory
            From `simulate`.
        units : Units, optional
            Scales; by default those of `from_physical`.

        Returns
        -------
        PhysicalTrajectory
            The same names, physical times in and physical values out.

        Raises
        ------
        ValueError
            The model has no scales and none are given.
        """
        return PhysicalTrajectory(trajectory, self._units(units))

    if TYPE_CHECKING:

        def as_map(self) -> EventMap:
            """Return the event map, which is one of the line."""

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of blocks and belt by name; a damping of 0 is left out."""
        numbers = {"alpha": self.alpha, "beta": self.beta, "V": self.V}
        return {**numbers, "damping": self.damping} if self.damping > 0.0 else numbers

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        alpha, damping = numbers["alpha"], numbers.get("damping", 0.0)
        return Plant.on_belt(  # 0.0 - alpha: no negative zero
            mass=np.ones(2),
            stiffness=np.array([[1.0 + alpha, 0.0 - alpha], [0.0 - alpha, 1.0 + alpha]]),
            damping=np.array([[damping, 0.0], [0.0, damping]]),
            static=np.array([1.0, numbers["beta"]]),
            V=numbers["V"],
        )

    @cached_property
    def chain(self) -> Chain:
        """The same model as a chain of two blocks."""
        return Chain(self.limits, self.alpha, self.V, self.friction, damping=self.damping)

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return 2

    @property
    def domain(self) -> tuple[float, float]:
        """(d_min, d_max) of the event map: the locus projected on d = X_2 - X_1."""
        end = locus.half_width(self.alpha, self.beta)
        return (-end, end)

    @property
    def monotone_loading(self) -> bool:
        """Whether a rider's spring force only grows while the others ride or slip backward."""
        # R_i' = V + alpha (V - X_j') with X_j' <= V: a rider can leave at its upper limit alone.
        return True

    def admit(self, d: ArrayLike) -> NDArray[np.float64]:
        """Check relative displacements against `domain`; as for any blocks."""
        end = self.domain[1]

        def why() -> str:
            return f"|d| <= {end:.17g} (alpha={self.alpha:g}, beta={self.beta:g}, eq. 6a)"

        return locus.admit(d, -end, end, why)

    def onset(self, d: ArrayLike) -> NDArray[np.float64]:
        """Displacements at which the global stick phase of a given ``d`` ends.

        Parameters
        ----------
        d : array_like of float, any shape
            Relative displacements in `domain`, units of f_s1 / k.

        Returns
        -------
        ndarray of float64, shape (..., 2)
            (X_1, X_2), both blocks at velocity V, where the first static limit is reached.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or outside the domain.
        """
        return locus.onset(self.admit(d), self.alpha, self.beta)

    def _units(self, units: Units | None) -> Units:
        units = self.units if units is None else units
        if units is not None:
            instance("units", units, Units, "scales, such as ss.Units(m=1.0, k=2.0, fs1=3.0)")
        else:
            raise ValueError(
                "this model has no physical scales: it was built from dimensionless numbers. "
                "Give units=Units(m=, k=, fs1=), or build it with TwoBlock.from_physical."
            )
        return units

    def __repr__(self) -> str:
        """One line that builds the model again."""
        numbers = f"alpha={self.alpha!r}, beta={self.beta!r}, V={self.V!r}"
        units = "" if self.units is None else f", units={self.units!r}"
        damping = f", damping={self.damping!r}" if self.damping else ""
        return f"TwoBlock({numbers}, friction={self.friction!r}{units}{damping})"
