"""Any number of blocks, coupled in any linear way, rubbed by a belt."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import dimensions, finite_number, one_of, shown
from stickslip.mechanics.model.belt_model import (
    BeltModel,
    Friction,
    belt_velocity,
    laws_of,
    one_per_block,
    positive_definite,
    semidefinite,
    symmetric,
)
from stickslip.mechanics.model.structure import Harmonic, Structure
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
        self.mass = _frozen(one_per_block("mass", mass, n, above=0.0, why="A mass is positive."))
        self.stiffness = _frozen(symmetric("stiffness", stiffness, n))
        positive_definite("stiffness", self.stiffness)
        given = np.zeros((n, n)) if damping is None else damping
        self.damping = _frozen(symmetric("damping", given, n))
        semidefinite("damping", self.damping)
        why = "A static friction limit is positive."
        self.static = _frozen(one_per_block("static", static, n, above=0.0, why=why))
        self.friction: Friction = laws_of(friction, n)
        self.forcing = checked_forcing(forcing, n)
        self.V = belt_velocity(V, is_forced=forcing is not None)

    @property
    def n_blocks(self) -> int:
        """Number of blocks."""
        return len(self.mass)

    @property
    def numbers(self) -> dict[str, float]:
        """Masses, stiffnesses and dampings (upper triangles), static limits and V, by name."""
        named = {f"mass_{i + 1}": float(m) for i, m in enumerate(self.mass)}
        for name in ("stiffness", "damping"):
            matrix = getattr(self, name)
            named |= {
                f"{name}_{i + 1}_{j + 1}": float(matrix[i, j])
                for i, j in zip(*np.triu_indices(self.n_blocks), strict=True)
                if name == "stiffness" or matrix[i, j] != 0.0 or i == j
            }
        named |= {f"static_{i + 1}": float(s) for i, s in enumerate(self.static)}
        return {**named, "V": self.V}

    def _assemble(self, numbers: Mapping[str, float]) -> Structure:
        n = self.n_blocks

        def vector(name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
            return np.array([numbers[f"{name}_{i + 1}"] for i in range(n)], dtype=np.float64)

        def matrix(name: str) -> np.ndarray[Any, np.dtype[np.float64]]:
            upper = np.zeros((n, n))
            for i, j in zip(*np.triu_indices(n), strict=True):
                upper[i, j] = upper[j, i] = numbers.get(f"{name}_{i + 1}_{j + 1}", 0.0)
            return upper

        return Structure(
            vector("mass"),
            matrix("stiffness"),
            matrix("damping"),
            vector("static"),
            numbers["V"],
            np.zeros(n),
            0.0,
            0.0,
        )

    def _rebuilt(self, numbers: Mapping[str, float], **changes: Any) -> Self:
        plain = self._assemble(numbers)
        given = {
            "mass": plain.mass,
            "stiffness": plain.stiffness,
            "damping": plain.damping,
            "static": plain.static,
            "V": numbers["V"],
            **changes,
        }
        return type(self)(**given)

    _fields = ("mass", "stiffness", "damping", "static")

    def _key(self) -> tuple[Any, ...]:
        arrays = tuple(getattr(self, name).tobytes() for name in self._fields)
        return (type(self), *arrays, self.friction, self.V, self.forcing)

    def __eq__(self, other: object) -> bool:
        """Equal numbers and laws."""
        if not isinstance(other, Blocks):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        """Hash of the numbers and laws."""
        return hash(self._key())

    def __repr__(self) -> str:
        """Call that builds the model again."""
        parts = [f"{name}={getattr(self, name).tolist()!r}" for name in self._fields]
        laws = list(self.friction) if isinstance(self.friction, tuple) else self.friction
        parts += [f"friction={laws!r}", f"V={self.V!r}"]
        if self.forcing is not None:
            parts.append(f"forcing={self.forcing!r}")
        return f"Blocks({', '.join(parts)})"


def _frozen(array: Any) -> Any:
    array.flags.writeable = False
    return array


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
