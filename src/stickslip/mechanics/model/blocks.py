"""Any number of blocks, coupled in any linear way, rubbed by a belt."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from stickslip.checks import dimensions, shown
from stickslip.mechanics.model.arrays import (
    belt_velocity,
    one_per_block,
    positive_definite,
    semidefinite,
    symmetric,
)
from stickslip.mechanics.model.belt_model import BeltModel, Friction, laws_of
from stickslip.mechanics.model.harmonic import Harmonic
from stickslip.mechanics.model.structure import Structure
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
        parts += [f"friction={_laws_text(self.friction)}", f"V={self.V!r}"]
        if self.forcing is not None:
            parts.append(f"forcing={self.forcing!r}")
        return f"Blocks({', '.join(parts)})"


def _laws_text(friction: Friction) -> str:
    return repr(list(friction)) if isinstance(friction, tuple) else repr(friction)


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
