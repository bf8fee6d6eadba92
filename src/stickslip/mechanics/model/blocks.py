"""Any number of blocks, coupled in any linear way, rubbed by a belt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import dimensions, model_number, one_of, shown
from stickslip.mechanics.model.belt_model import (
    BeltModel,
    Friction,
    array_of,
    belt_velocity,
    check_definite,
    frozen,
    laws_of,
    named,
    one_per_block,
    paired,
    symmetric,
)
from stickslip.mechanics.model.contact import Harmonic
from stickslip.mechanics.model.plant import Plant
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


@suggests
class Blocks(BeltModel):
    """Blocks on a moving belt with full matrices: M X'' + C X' + K X = friction + g(t).

    Parameters
    ----------
    mass : array_like of float, shape (n,)
        > 0.
    stiffness : array_like of float, shape (n, n)
        Symmetric, positive definite.
    damping : array_like of float, shape (n, n), optional
        Symmetric, positive semidefinite; none by default.
    static : float or array_like of float, shape (n,)
        Static limits, > 0.
    friction : FrictionLaw or list of FrictionLaw
        Kinetic friction relative to each block's own static limit: one for all, or n.
    V : float
        Belt velocity, > 0; 0 for forced models.
    forcing : Harmonic, optional

    Raises
    ------
    ValueError
        A number out of range, a matrix of the wrong shape, not symmetric or not definite.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.Blocks(
    ...     mass=[1, 2], stiffness=[[2.2, -1.2], [-1.2, 2.2]], static=[1, 1.3],
    ...     friction=ss.Coulomb(mu=0.22), V=0.0366)
    >>> model.n_blocks
    2
    """

    def __init__(
        self,
        mass: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike | None = None,
        *,
        static: ArrayLike,
        friction: Friction | list[Any],
        V: float,
        forcing: Harmonic | None = None,
    ) -> None:
        n = max(np.size(mass), 1) if dimensions(mass) == 1 else 1
        why = "A mass is positive."
        self.mass = frozen(one_per_block("mass", mass, n, why))
        why = "forces between blocks come in equal and opposite pairs"
        self.stiffness = symmetric("stiffness", stiffness, n, why)
        given = np.zeros((n, n)) if damping is None else damping
        self.damping = symmetric("damping", given, n, why)
        why = "A direction without restoring force lets the belt carry the blocks away for ever."
        check_definite("stiffness", self.stiffness, why)
        why = "A damper that feeds energy belongs into the friction law."
        check_definite("damping", self.damping, why, semi=True)
        why = "A static friction limit is positive."
        self.static = frozen(one_per_block("static", static, n, why))
        self.friction: Friction = laws_of(friction, n)
        self.forcing = checked_forcing(forcing, n)
        self.V = belt_velocity(V, is_forced=forcing is not None)
        self._check_law_names()

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.mass)

    @property
    def numbers(self) -> dict[str, float]:
        """Masses, stiffnesses and dampings (upper triangles), static limits and V, by name."""
        matrices = paired("stiffness", self.stiffness) | paired("damping", self.damping)
        return named("mass", self.mass) | matrices | named("static", self.static) | {"V": self.V}

    def _arrays(self, numbers: Mapping[str, Any]) -> dict[str, Any]:
        n = self.n_blocks
        shapes = {"mass": (n,), "stiffness": (n, n), "damping": (n, n), "static": (n,)}
        arrays = {name: array_of(numbers, name, shape) for name, shape in shapes.items()}
        return {**arrays, "V": numbers["V"]}

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        return Plant.on_belt(**self._arrays(numbers))


def checked_forcing(forcing: object, n_blocks: int) -> Harmonic | None:
    """Return the forcing of a model: None, or a Harmonic for its blocks; else ValueError."""
    if forcing is None:
        return None
    if not isinstance(forcing, Harmonic):
        raise ValueError(
            f"forcing = {shown(forcing)} must be a Harmonic(amplitude=, frequency=, phase=) or "
            "None."
        )
    forcing.amplitudes(n_blocks)
    return forcing


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
        static = one_per_block("static", self.static, n, why)
        one_of("ends", self.ends, get_args(Ends))
        spring = "A spring's stiffness is not negative; 0 uncouples the blocks."
        support = "Without support springs the belt would carry the blocks away."
        checked = {
            "static": tuple(static.tolist()),
            "alpha": model_number("alpha", self.alpha, at_least=0.0, why=spring),
            "support": model_number("support", self.support, above=0.0, why=support),
            "mass": model_number("mass", self.mass, above=0.0, why="A mass is positive."),
            "damping": model_number(
                "damping", self.damping, at_least=0.0, why="A damper takes energy."
            ),
            "friction": laws_of(self.friction, n),
            "forcing": checked_forcing(self.forcing, n),
            "V": belt_velocity(self.V, is_forced=self.forcing is not None),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._check_law_names()

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

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        n = self.n_blocks
        support, coupling = numbers["support"], numbers["support"] * numbers["alpha"]
        return Plant.on_belt(
            mass=np.full(n, numbers["mass"]),
            stiffness=support * np.eye(n) + coupling * _links(n, self.ends),
            damping=numbers["damping"] * np.eye(n),
            static=array_of(numbers, "static", (n,)),
            V=numbers["V"],
        )


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

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5))
    >>> round(ss.find_cycle(block, x=[0.9], v=[0.1]).period, 9)
    13.536383773
    """

    V: float
    friction: Friction
    damping: float = 0.0
    forcing: Harmonic | None = None

    def __post_init__(self) -> None:
        """Check every number once and store it as a float."""
        checked = {
            "damping": model_number(
                "damping", self.damping, at_least=0.0, why="A damper takes energy."
            ),
            "friction": laws_of(self.friction, 1),
            "forcing": checked_forcing(self.forcing, 1),
            "V": belt_velocity(self.V, is_forced=self.forcing is not None),
        }
        for name, value in checked.items():
            object.__setattr__(self, name, value)
        self._check_law_names()

    @property
    def n_blocks(self) -> int:
        """One."""
        return 1

    @property
    def numbers(self) -> dict[str, float]:
        """Belt velocity and damping."""
        return {"V": self.V, "damping": self.damping}

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        one = np.ones(1)
        damping = array_of(numbers, "damping", ())
        return Plant.on_belt(one, np.eye(1), damping.reshape(1, 1), one, numbers["V"])
