"""What every arrangement of blocks on a belt offers: parameters by name, global stick, checks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Self, TypeAlias

import numpy as np

from stickslip.checks import dimensions, finite_number, real_numbers, shown, whole_number
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.structure import Harmonic, Structure
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap
    from stickslip.numerics.arrays import Floats


MOST_BLOCKS: Final = 2000
"""Springs and modes of so many fill a small memory, and take a minute."""

ROUNDING = 64 * np.finfo(np.float64).eps
"""Of a matrix' size: asymmetry and negative eigenvalues that rounding explains."""


def one_per_block(name: str, values: Any, n_blocks: int, *, above: float, why: str) -> Floats:
    """Return one finite number above a bound per block; one number stands for all."""
    if dimensions(values) == 0:
        return np.full(n_blocks, finite_number(name, values, above=above, why=why))
    what = "blocks: a model has a matrix with a row for each"
    whole_number(f"len({name})", n_blocks, at_most=MOST_BLOCKS, what=what)
    entries = list(values)
    if len(entries) != n_blocks or any(dimensions(entry) for entry in entries):
        raise ValueError(
            f"{name} = {shown(values)} for {n_blocks} blocks: give one number per block."
        )
    return np.array(
        [
            finite_number(f"{name}[{i}]", entry, above=above, why=why)
            for i, entry in enumerate(entries)
        ]
    )


def symmetric(name: str, values: object, n_blocks: int) -> Floats:
    """Return a symmetric matrix with a row per block; ValueError if it is none."""
    matrix = real_numbers(name, values)
    if matrix.shape != (n_blocks, n_blocks):
        raise ValueError(
            f"{name} has the shape {matrix.shape}: {n_blocks} blocks need "
            f"({n_blocks}, {n_blocks}), as many rows and columns as masses."
        )
    if not np.isfinite(matrix).all():
        i, j = np.argwhere(~np.isfinite(matrix))[0]
        raise ValueError(f"{name}[{i}, {j}] = {matrix[i, j]} is not a finite number")
    apart = np.abs(matrix - matrix.T)
    if apart.max(initial=0.0) > ROUNDING * np.abs(matrix).max(initial=0.0):
        i, j = np.unravel_index(np.argmax(apart), apart.shape)
        raise ValueError(
            f"{name}[{i}, {j}] = {matrix[i, j]!r} but {name}[{j}, {i}] = {matrix[j, i]!r}: the "
            "matrix must be symmetric (forces between blocks come in equal and opposite pairs)."
        )
    return np.asarray(0.5 * (matrix + matrix.T))


def positive_definite(name: str, matrix: Floats) -> None:
    """Check that springs always pull back."""
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least <= ROUNDING * np.abs(matrix).max():
        raise ValueError(
            f"{name} has the eigenvalue {least:.6g}: it must be positive definite. A direction "
            "without restoring force lets the belt carry the blocks away for ever."
        )


def semidefinite(name: str, matrix: Floats) -> None:
    """Check that dampers only take energy."""
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < -ROUNDING * np.abs(matrix).max():
        raise ValueError(
            f"{name} has the eigenvalue {least:.6g}: it must be positive semidefinite. A damper "
            "that feeds energy belongs into the friction law."
        )


def belt_velocity(value: object, name: str = "V", *, is_forced: bool = False) -> float:
    """Return the belt velocity: positive, or 0 in forced models."""
    remedy = (
        f"A belt that runs backward is the mirror image (X, V) -> -(X, V): take |{name}| and "
        "change the sign of all displacements and forces; a law with forward= exchanges its two "
        "functions."
    )
    if is_forced:
        why = "The belt moves towards positive displacements, or rests."
        return finite_number(name, value, at_least=0.0, why=why, remedy=remedy)
    why = (
        "The belt loads the springs by moving towards positive displacements (V = 0 makes sense "
        "for forced models only)."
    )
    return finite_number(name, value, above=0.0, why=why, remedy=remedy)


Friction: TypeAlias = FrictionLaw | tuple[FrictionLaw, ...]

MOST_POINTS = 10**8
"""That a sample of the domain may have."""

DOMAIN_SLACK = 8 * np.finfo(np.float64).eps
"""Of the longest shift that loads a block: how far outside the locus counts as its edge."""


class BeltModel(ABC):
    """Blocks on a moving belt, held by springs: the family that every model belongs to.

    Immutable. A model depends linearly on each of its numbers (`structure_direction`).
    """

    V: float
    friction: Friction
    forcing: Harmonic | None

    # --- what a kind of model must say of itself -------------------------------------------

    @property
    @abstractmethod
    def n_blocks(self) -> int:
        """Number of blocks."""

    @property
    @abstractmethod
    def numbers(self) -> dict[str, float]:
        """Parameters of masses, springs, dampers, limits and belt, by name."""

    @abstractmethod
    def _assemble(self, numbers: Mapping[str, float]) -> Structure:
        """Structure with these numbers and no forcing; they are not checked."""

    @abstractmethod
    def _rebuilt(self, numbers: Mapping[str, float], **changes: Any) -> Self:
        """Model with these numbers, checked, and some fields changed."""

    def as_map(self) -> EventMap | BlocksEventMap:
        """Return the event map with its default settings."""
        from stickslip.mechanics.eventmap.of_model import event_map  # not for the model alone

        return event_map(self)

    # --- parameters --------------------------------------------------------------------------

    @cached_property
    def structure(self) -> Structure:
        """Masses, springs, dampers, limits and forcing as arrays."""
        return self._structure_with({**self.numbers, **self._forcing_numbers})

    def structure_direction(self, name: object) -> Structure:
        """Differentiate the structure in one of its numbers: linear, so a step of 1 is exact."""
        numbers = {**self.numbers, **self._forcing_numbers}
        if not isinstance(name, str) or name not in numbers:
            known = did_you_mean(name, list(self.parameters))
            raise ValueError(f"{type(self).__name__} has no parameter {shown(name)}. {known}")
        changed = self._structure_with({**numbers, name: numbers[name] + 1.0})
        return self.structure.direction_to(changed)

    def _structure_with(self, numbers: Mapping[str, float]) -> Structure:
        plain = self._assemble(numbers)
        if self.forcing is None:
            return plain
        n = plain.n_blocks
        amplitude = [
            numbers.get(f"forcing.amplitude_{i + 1}", numbers.get("forcing.amplitude", 0.0))
            for i in range(n)
        ]
        return replace(
            plain,
            amplitude=np.array(amplitude),
            frequency=numbers["forcing.frequency"],
            phase=numbers["forcing.phase"],
        )

    @property
    def _forcing_numbers(self) -> dict[str, float]:
        if self.forcing is None:
            return {}
        given = self.forcing.amplitude
        if isinstance(given, tuple):
            names = {f"forcing.amplitude_{i}": a for i, a in enumerate(given, start=1)}
        else:
            names = {"forcing.amplitude": given}
        names["forcing.frequency"] = self.forcing.frequency
        names["forcing.phase"] = self.forcing.phase
        return names

    @property
    def laws(self) -> tuple[FrictionLaw, ...]:
        """Friction law of each block."""
        if isinstance(self.friction, tuple):
            return self.friction
        return (self.friction,) * self.n_blocks

    @property
    def law_parameters(self) -> dict[str, tuple[tuple[int, str], ...]]:
        """Blocks, and names in their laws, that each friction parameter of the model belongs to."""
        if not isinstance(self.friction, tuple):
            blocks = range(self.n_blocks)
            return {
                name: tuple((block, name) for block in blocks) for name in self.friction.parameters
            }
        return {
            f"{name}_{block + 1}": ((block, name),)
            for block, law in enumerate(self.friction)
            for name in law.parameters
        }

    @property
    def parameters(self) -> dict[str, float]:
        """All numbers by name."""
        laws = self.laws
        friction = {
            name: laws[where[0][0]].parameters[where[0][1]]
            for name, where in self.law_parameters.items()
        }
        return {**self.numbers, **friction, **self._forcing_numbers}

    def replace(self, **changes: Any) -> Self:
        """Make a changed copy, by parameter name.

        Parameters
        ----------
        **changes
            Names from `parameters` (those with a dot through ``**{...}``), or fields of the
            model such as ``friction`` and ``forcing``.

        Raises
        ------
        ValueError
            Unknown name (the closest known one is suggested), or a value out of range.
        """
        numbers = {**self.numbers}
        forcing = {**self._forcing_numbers}
        for_laws: dict[str, Any] = {}
        fields: dict[str, Any] = {}
        own = {"friction", "forcing", *getattr(self, "__dataclass_fields__", ())}
        for name, value in changes.items():
            if name in numbers:
                numbers[name] = value
            elif name in forcing:
                forcing[name] = value
            elif name in self.law_parameters:
                for_laws[name] = value
            elif name in own:
                fields[name] = value
            else:
                known = did_you_mean(name, [*self.parameters, *own])
                raise ValueError(f"{type(self).__name__} has no parameter {shown(name)}. {known}")
        fields.setdefault("friction", self._changed_friction(for_laws))
        fields.setdefault("forcing", self._changed_forcing(forcing))
        return self._rebuilt(numbers, **fields)

    def _changed_friction(self, changes: Mapping[str, Any]) -> Friction:
        if not isinstance(self.friction, tuple):
            return self.friction.replace(**changes) if changes else self.friction
        laws = list(self.friction)
        for name, value in changes.items():
            ((block, own_name),) = self.law_parameters[name]
            laws[block] = laws[block].replace(**{own_name: value})
        return tuple(laws)

    def _changed_forcing(self, numbers: Mapping[str, Any]) -> Harmonic | None:
        if self.forcing is None:
            return None
        amplitude: Any = numbers.get("forcing.amplitude")
        if amplitude is None:
            amplitude = [v for k, v in numbers.items() if k.startswith("forcing.amplitude_")]
        return Harmonic(amplitude, numbers["forcing.frequency"], numbers["forcing.phase"])

    # --- global stick ------------------------------------------------------------------------

    @property
    def limits(self) -> tuple[float, ...]:
        """Static limits of the blocks."""
        return tuple(self.structure.static.tolist())

    @property
    def monotone_loading(self) -> bool:
        """Whether a rider's needed force only grows while the others ride or slip backward."""
        s = self.structure
        off = s.stiffness - np.diag(np.diag(s.stiffness))
        undamped = not s.damping.any() and not s.is_forced
        return bool(undamped and (off <= 0.0).all() and (s.loading >= 0.0).all())

    @property
    def d_shape(self) -> tuple[int, ...]:
        """Shape of the d of one global stick phase: a number of two blocks, else (n - 1,)."""
        n = self.n_blocks
        return () if n == 2 else (n - 1,)

    @property
    def domain(self) -> tuple[float, float]:
        """(d_min, d_max) of two blocks: the locus projected on d = X_2 - X_1.

        Raises
        ------
        ValueError
            There are not two blocks.
        """
        if self.n_blocks != 2:
            raise ValueError(
                f"the domain of {self.n_blocks} blocks is no interval: model.contains(d) tells "
                "which differences belong to it."
            )
        return locus.ends(self.structure)

    def positions(self, d: ArrayLike) -> Floats:
        """Displacements of the blocks with the first one at 0, shape (..., n).

        Parameters
        ----------
        d : array_like of float, shape (..., n - 1); of two blocks any shape
            ``X_{i+1} - X_i``.

        Raises
        ------
        ValueError
            The last axis does not have n - 1 entries.
        """
        steps = real_numbers("d", d)
        n = self.n_blocks
        if n == 2:
            steps = steps[..., None]
        if steps.ndim == 0 or steps.shape[-1] != n - 1:
            raise ValueError(
                f"d has the shape {steps.shape}: its last axis must have {n - 1} entries, the "
                f"differences X_(i+1) - X_i of {n} blocks."
            )
        x = np.zeros((*steps.shape[:-1], n))
        np.cumsum(steps, axis=-1, out=x[..., 1:])
        return x

    def _stick_range(self, d: ArrayLike) -> tuple[Floats, Floats]:
        """Displacements of block 1 between which all blocks ride, shapes (...), or low > high."""
        s = self.structure
        x = self.positions(d)
        rate = s.stiffness.sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            force = s.needed_force(x, np.full(x.shape, s.V))
            one = (-s.static - force) / rate
            other = (s.static - force) / rate
        still = rate == 0.0
        inside = np.abs(force) <= s.static
        low = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(one, other))
        high = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(one, other))
        return low.max(axis=-1), high.min(axis=-1)

    def contains(self, d: ArrayLike) -> NDArray[np.bool_]:
        """Whether global stick phases with these differences exist, ends included.

        Parameters
        ----------
        d : array_like of float, shape (..., n - 1); of two blocks any shape

        Returns
        -------
        ndarray of bool, shape (...)
            False for NaN.
        """
        if self.n_blocks == 2:
            least, largest = self.domain
            values = real_numbers("d", d)
            return np.asarray((values >= least) & (values <= largest))
        low, high = self._stick_range(d)
        s = self.structure
        rate = np.abs(s.stiffness.sum(axis=1))
        reach = np.max(s.static[rate > 0] / rate[rate > 0], initial=0.0)
        return np.asarray(low <= high + DOMAIN_SLACK * reach)

    def admit(self, d: ArrayLike) -> Floats:
        """Check differences against the domain of the event map.

        Raises
        ------
        ValueError
            Some ``d`` is NaN or belongs to no global stick phase; the first one is named.
        """
        if self.n_blocks == 2:
            low, high = self.domain
            return locus.admit(d, low, high, f"[{low:.17g}, {high:.17g}]")
        points = np.require(real_numbers("d", d), np.float64, ["C", "W"])
        inside = self.contains(points)
        if not inside.all():
            where = tuple(int(i) for i in np.argwhere(~inside)[0])
            name = f"d[{', '.join(map(str, where))}]" if where else "d"
            raise ValueError(
                f"{name} = {points[where].tolist()} belongs to no global stick phase: the blocks "
                "cannot all ride with these differences. model.contains(d) tells which can, "
                "model.sample_domain(n, rng) draws some."
            )
        return points

    def sample_domain(self, n: int, rng: np.random.Generator | int | None = None) -> Floats:
        """Draw differences of global stick phases, shape (n, *d_shape).

        They belong to displacements drawn uniformly from those with which all blocks ride.
        """
        x = self.structure.sample_sticking(n, rng)
        return np.asarray(np.diff(x, axis=-1).reshape(len(x), *self.d_shape))

    def spread_domain(self, n: int) -> Floats:
        """Return differences spread evenly over those of global stick phases, always the same.

        Shape (n, *d_shape); the needed forces are a Sobol sequence within the limits.
        """
        from scipy.stats.qmc import Sobol

        n = whole_number("n", n, at_most=MOST_POINTS)
        shares = Sobol(self.n_blocks, rng=0).random_base2(max(n - 1, 1).bit_length())[:n]
        return np.asarray(np.diff(self.structure.sticking(shares)).reshape(n, *self.d_shape))

    def sample_state(
        self, rng: np.random.Generator | int | None = None, *, riding: bool = False
    ) -> tuple[Floats, Floats]:
        """Draw a legal state (x, v), each of shape (n_blocks,), for `stickslip.simulate`.

        Needed forces are uniform within the static limits; velocities are the belt's if
        `riding`, else within one unit of f_s1 / sqrt(k m) of it.
        """
        return self.structure.sample_state(rng, riding=riding)


def laws_of(friction: object, n_blocks: int) -> Friction:
    """Return one law for all blocks, or a tuple with one per block; else ValueError."""
    if isinstance(friction, FrictionLaw):
        return friction
    if isinstance(friction, Sequence) and all(isinstance(law, FrictionLaw) for law in friction):
        if len(friction) == n_blocks:
            return tuple(friction)
        raise ValueError(
            f"friction = {shown(friction)}: {len(friction)} laws for {n_blocks} blocks. Give one "
            "law for all, or one per block."
        )
    remedy = (
        "Wrap a function of the slip speed in friction_law(...)."
        if callable(friction) and not isinstance(friction, type)
        else "Take Coulomb(mu=), PoppStelter(gamma=) or friction_law(...)."
    )
    raise ValueError(
        f"friction = {shown(friction)} is neither a friction law nor a list of laws. {remedy}"
    )
