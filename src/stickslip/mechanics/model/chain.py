"""A chain of blocks between neighbours' springs (Burridge and Knopoff), and one block alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import dimensions, finite_number, one_of, shown
from stickslip.mechanics.model.arrays import belt_velocity, one_per_block
from stickslip.mechanics.model.belt_model import BeltModel, Friction, laws_of
from stickslip.mechanics.model.blocks import checked_forcing
from stickslip.mechanics.model.harmonic import Harmonic
from stickslip.mechanics.model.structure import Structure
from stickslip.vocabulary import suggests

Ends = Literal["free", "fixed", "periodic"]


@suggests
@dataclass(frozen=True)
class Chain(BeltModel):
    """Equal blocks in a row on a moving belt, each held by a support spring.

    Parameters
    ----------
    static : sequence of float, shape (n,)
        Static limits, > 0; their number is the number of blocks.
    alpha : float
        Coupling stiffness between neighbours over support stiffness, >= 0.
    V : float
        Belt velocity, > 0; 0 for forced models.
    friction : FrictionLaw or list of FrictionLaw
        Relative to each block's own static limit: one for all, or n.
    support : float
        Stiffness of each support spring, > 0.
    mass : float
        Of each block, > 0.
    damping : float
        Coefficient of a damper from each block to the support, >= 0.
    ends : {"free", "fixed", "periodic"}
        The outermost blocks have one neighbour; or a coupling spring to a wall besides; or each
        other as neighbours.
    forcing : Harmonic, optional

    Raises
    ------
    ValueError
        A number out of range, unknown ends, a number of laws or amplitudes that does not fit.

    Notes
    -----
    R. Burridge and L. Knopoff, Bull. Seismol. Soc. Am. 57, 341 (1967). With two blocks, free
    ends and static limits (1, beta) this is the paper's model (`stickslip.TwoBlock`).

    Examples
    --------
    >>> import stickslip as ss
    >>> chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.0366, friction=ss.Coulomb(mu=0.22))
    >>> chain.n_blocks, chain.parameters["static_2"]
    (3, 1.3)
    """

    static: Sequence[float] | NDArray[np.float64]  # kept as a tuple
    alpha: float
    V: float
    friction: Friction
    support: float = 1.0
    mass: float = 1.0
    damping: float = 0.0
    ends: Ends = "free"
    forcing: Harmonic | None = None

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        n = np.size(self.static) if dimensions(self.static) == 1 else 0
        if n == 0:
            raise ValueError(
                f"static = {shown(self.static)}: give a list with the static limit of each block."
            )
        why = "A static friction limit is positive."
        static = one_per_block("static", self.static, n, above=0.0, why=why)
        one_of("ends", self.ends, get_args(Ends))
        spring = "A spring's stiffness is not negative; 0 uncouples the blocks."
        support = "Without support springs the belt would carry the blocks away."
        checked = {
            "static": tuple(static.tolist()),
            "alpha": finite_number("alpha", self.alpha, at_least=0.0, why=spring),
            "support": finite_number("support", self.support, above=0.0, why=support),
            "mass": finite_number("mass", self.mass, above=0.0, why="A mass is positive."),
            "damping": finite_number(
                "damping", self.damping, at_least=0.0, why="A damper takes energy."
            ),
            "friction": laws_of(self.friction, n),
            "forcing": checked_forcing(self.forcing, n),
            "V": belt_velocity(self.V, is_forced=self.forcing is not None),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.static)

    @property
    def numbers(self) -> dict[str, float]:
        """Numbers of the chain by name."""
        named = {"alpha": self.alpha, "V": self.V, "support": self.support}
        named |= {"mass": self.mass, "damping": self.damping}
        return named | {f"static_{i}": value for i, value in enumerate(self.static, start=1)}

    def _assemble(self, numbers: Mapping[str, float]) -> Structure:
        n = self.n_blocks
        links = _links(n, self.ends)
        return Structure(
            np.full(n, float(numbers["mass"])),
            numbers["support"] * np.eye(n) + numbers["support"] * numbers["alpha"] * links,
            numbers["damping"] * np.eye(n),
            np.array([numbers[f"static_{i + 1}"] for i in range(n)], dtype=np.float64),
            numbers["V"],
            np.zeros(n),
            0.0,
            0.0,
        )

    def _rebuilt(self, numbers: Mapping[str, float], **changes: Any) -> Self:
        given = {
            "static": tuple(numbers[f"static_{i + 1}"] for i in range(self.n_blocks)),
            **{name: numbers[name] for name in ("alpha", "V", "support", "mass", "damping")},
            "ends": self.ends,
            **changes,
        }
        return type(self)(**given)


def _links(n: int, ends: Ends) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Stiffness matrix of coupling springs of unit stiffness."""
    links = np.zeros((n, n))
    pairs = [(i, i + 1) for i in range(n - 1)]
    if ends == "periodic" and n > 2:
        pairs.append((n - 1, 0))
    for i, j in pairs:
        links[[i, j], [i, j]] += 1.0
        links[[i, j], [j, i]] -= 1.0
    if ends == "fixed":
        links[0, 0] += 1.0
        links[-1, -1] += 1.0
    return links


@suggests
@dataclass(frozen=True)
class Oscillator(BeltModel):
    """One block on a moving belt: X'' + damping X' + X = friction + g(t), static limit 1.

    Parameters
    ----------
    V : float
        Belt velocity, > 0; 0 for forced models.
    friction : FrictionLaw
        Relative to the static limit.
    damping : float
        >= 0; 2 is critical.
    forcing : Harmonic, optional

    Raises
    ------
    ValueError
        A number out of range.
    """

    V: float
    friction: Friction
    damping: float = 0.0
    forcing: Harmonic | None = None

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        checked = {
            "damping": finite_number(
                "damping", self.damping, at_least=0.0, why="A damper takes energy."
            ),
            "friction": laws_of(self.friction, 1),
            "forcing": checked_forcing(self.forcing, 1),
            "V": belt_velocity(self.V, is_forced=self.forcing is not None),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def n_blocks(self) -> int:
        """One."""
        return 1

    @property
    def numbers(self) -> dict[str, float]:
        """Belt velocity and damping."""
        return {"V": self.V, "damping": self.damping}

    def _assemble(self, numbers: Mapping[str, float]) -> Structure:
        one = np.ones(1)
        damping = np.array([[numbers["damping"]]], dtype=np.float64)
        return Structure(one, np.eye(1), damping, one, numbers["V"], np.zeros(1), 0.0, 0.0)

    def _rebuilt(self, numbers: Mapping[str, float], **changes: Any) -> Self:
        return type(self)(**{"V": numbers["V"], "damping": numbers["damping"], **changes})
