"""What every arrangement of blocks on a belt offers: parameters by name, global stick, checks."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from functools import cache, cached_property
from inspect import signature
from typing import TYPE_CHECKING, Any, Final, Self, TypeAlias

import numpy as np

from stickslip.checks import (
    LARGEST,
    TOO_LARGE,
    dimensions,
    model_number,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.mechanics.friction.values import within
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.contact import Harmonic, harmonic_of
from stickslip.mechanics.model.orders import orders
from stickslip.mechanics.model.plant import ROUNDING, TINY, Numbers, Plant, Reduced, derivative
from stickslip.numerics.arrays import applied
from stickslip.vocabulary import did_you_mean

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.mechanics.cycle.return_map import LineReturnMap, ReturnMap
    from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap
    from stickslip.numerics.arrays import Floats


MOST_BLOCKS: Final = 2000
"""Springs and modes of so many fill a small memory, and take a minute."""


def one_per_block(name: str, values: Any, n_blocks: int, why: str) -> Floats:
    """Return one positive number per block; one number stands for all."""
    if dimensions(values) == 0:
        return np.full(n_blocks, model_number(name, values, above=0.0, why=why))
    what = "blocks: a model has a matrix with a row for each"
    whole_number(f"len({name})", n_blocks, at_most=MOST_BLOCKS, what=what)
    entries = list(values)
    if len(entries) != n_blocks or any(dimensions(entry) for entry in entries):
        raise ValueError(
            f"{name} = {shown(values)} for {n_blocks} blocks: give one number per block."
        )
    return np.array(
        [model_number(f"{name}[{i}]", entry, above=0.0, why=why) for i, entry in enumerate(entries)]
    )


def matrix_of(name: str, given: object, shape: tuple[int, ...]) -> Floats:
    """Return finite numbers of this shape; else ValueError."""
    array = real_numbers(name, given)
    if array.shape != shape:
        raise ValueError(f"{name} has the shape {array.shape}: {shape} is needed.")
    if not (allowed := np.abs(array) <= LARGEST).all():
        index = tuple(int(k) for k in np.argwhere(~allowed)[0])
        finite = np.isfinite(array[index])
        why = f"is not allowed: {TOO_LARGE}" if finite else "is not a finite number"
        raise ValueError(f"{name}{list(index)} = {array[index]} {why}")
    return frozen(array.copy())


def symmetric(name: str, given: object, n: int, why: str) -> Floats:
    """Return a symmetric (n, n) matrix; else ValueError."""
    matrix = matrix_of(name, given, (n, n))
    apart = np.abs(matrix - matrix.T)
    if apart.max(initial=0.0) > ROUNDING * np.abs(matrix).max(initial=0.0):
        i, j = np.unravel_index(np.argmax(apart), apart.shape)
        raise ValueError(
            f"{name}[{i}, {j}] = {matrix[i, j]} but {name}[{j}, {i}] = {matrix[j, i]}: the "
            f"matrix must be symmetric ({why})."
        )
    return frozen(np.asarray(0.5 * matrix + 0.5 * matrix.T))


def check_definite(name: str, matrix: Floats, why: str, *, semi: bool = False) -> None:
    """Check that a symmetric matrix is positive definite, or semidefinite."""
    size = np.sqrt(np.abs(np.diag(matrix)))
    size[size == 0.0] = 1.0
    # Rounding of the stiffest direction may be more than all of the others: each by its own, too.
    for each in (matrix, matrix / size / size[:, None]):
        least, zero = float(np.linalg.eigvalsh(each)[0]), ROUNDING * np.abs(each).max()
        if least >= -zero if semi else least > zero:
            return
    least = float(np.linalg.eigvalsh(matrix)[0])
    raise ValueError(
        f"{name} has the eigenvalue {least:.6g}: it must be positive {'semi' * semi}definite. {why}"
    )


def belt_velocity(value: object, name: str = "V", *, is_forced: bool = False) -> float:
    """Return the belt velocity: positive, or 0 in forced models."""
    remedy = (
        f"A belt that runs backward is the mirror image (X, V) -> -(X, V): take |{name}| and "
        "change the sign of all displacements and forces; of a law that depends on the direction "
        "exchange the two functions."
    )
    if is_forced:
        why = "The belt moves towards positive displacements, or rests."
        return model_number(name, value, at_least=0.0, why=why, remedy=remedy)
    why = (
        "The belt loads the springs by moving towards positive displacements (V = 0 makes sense "
        "for forced models only)."
    )
    return model_number(name, value, above=0.0, why=why, remedy=remedy)


Friction: TypeAlias = FrictionLaw | tuple[FrictionLaw, ...]

MOST_POINTS = 10**8
"""That a sample of the domain may have."""

DOMAIN_SLACK = 8 * np.finfo(np.float64).eps
"""Of the longest shift that loads a block: how far outside the locus counts as its edge."""


class BeltModel(ABC):
    """Blocks on a moving belt, held by springs: the family that every model belongs to.

    Immutable. A model is differentiated exactly in each of its numbers (`plant_direction`).
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
    def size(self) -> str:
        """How many blocks there are, in words."""
        return counted(self.n_blocks, "block", "blocks")

    @property
    @abstractmethod
    def numbers(self) -> dict[str, float]:
        """Parameters of masses, springs, dampers, limits and belt, by name."""

    @abstractmethod
    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        """Plant with these numbers, real or complex, and no harmonics; they are not checked."""

    def _rebuilt(
        self, numbers: Mapping[str, float], waves: Mapping[str, Harmonic], **changes: Any
    ) -> Self:
        """Model with these numbers and harmonics, checked, and some fields changed."""
        given = {name: getattr(self, name) for name in _arguments_of(type(self))}
        for name, value in given.items():
            if f"{name}_1" in numbers or f"{name}_1_1" in numbers:
                given[name] = array_of(numbers, name, np.shape(value))
        own = {name: numbers[name] for name in given.keys() & numbers.keys()}
        return type(self)(**{**given, **own, **waves, **changes})

    @property
    def _waves(self) -> dict[str, tuple[Harmonic, int | None]]:
        """Harmonics by name, and the contact whose belt each moves; None: forces."""
        return {} if self.forcing is None else {"forcing": (self.forcing, None)}

    def as_map(self) -> EventMap | BlocksEventMap | ReturnMap | LineReturnMap:
        """Return the event map, or the return map of models without one; default settings."""
        from stickslip.mechanics.eventmap.of_model import map_of  # not for the model alone

        return map_of(self)

    # --- parameters --------------------------------------------------------------------------

    @cached_property
    def plant(self) -> Plant:
        """Masses, springs, dampers, contacts and forcing as arrays."""
        return self._plant_with({**self.numbers, **self._wave_numbers})

    def plant_direction(self, name: object) -> Reduced:
        """Differentiate the reduced plant in one of its numbers."""
        known = self._directions.get(name) if isinstance(name, str) else None
        if known is None:
            known = self._directions[name] = self._direction(name)
        return known

    @cached_property
    def _directions(self) -> dict[object, Reduced]:
        """Derivatives found so far: each motion that is fitted asks for them."""
        return {}

    def _direction(self, name: object) -> Reduced:
        moved = self.moved_plant(name)
        if moved.is_coupled and not self.plant.is_coupled:
            raise ValueError(
                f"{name} = {self.parameters[str(name)]!r} has no derivative: as soon as it "
                "changes, contacts share inertia. Give it a value beside."
            )
        return derivative(moved.reduction(self.plant))

    def moved_plant(self, name: object) -> Plant:
        """Return the plant with one of its numbers moved by ``TINY`` i."""
        numbers = {**self.numbers, **self._wave_numbers}
        if not isinstance(name, str) or name not in numbers:
            known = did_you_mean(name, list(self.parameters))
            raise ValueError(f"{type(self).__name__} has no parameter {shown(name)}. {known}")
        return self._plant_with({**numbers, name: numbers[name] + 1j * TINY})

    def _plant_with(self, numbers: Mapping[str, Any]) -> Plant:
        plant = self._assemble(numbers)
        for name, (_, contact) in self._waves.items():
            n, m = plant.into.shape
            size, which = (n, None) if contact is None else (m, contact)
            alike = numbers.get(f"{name}.amplitude", 0.0)
            given = [numbers.get(f"{name}.amplitude_{i + 1}", alike) for i in range(size)]
            forces, belts = np.zeros(n), np.zeros(m)
            if which is None:
                forces = np.array(given)
            else:
                belts = np.where(np.arange(m) == which, alike, 0.0)
            plant = plant.with_harmonic(
                forces, belts, numbers[f"{name}.frequency"], numbers[f"{name}.phase"]
            )
        return plant

    @property
    def _wave_numbers(self) -> dict[str, float]:
        named: dict[str, float] = {}
        for name, (wave, _) in self._waves.items():
            named |= {f"{name}.{key}": value for key, value in wave.numbers.items()}
        return named

    @property
    def laws(self) -> tuple[FrictionLaw, ...]:
        """Friction law of each block."""
        if isinstance(self.friction, tuple):
            return self.friction
        return (self.friction,) * self.n_blocks

    @property
    def law_parameters(self) -> dict[str, tuple[tuple[int, str], ...]]:
        """Blocks, and names in their laws, that each friction parameter of the model belongs to."""
        return owners_of(self.friction, self.n_blocks)

    @property
    def parameters(self) -> dict[str, float]:
        """All numbers by name."""
        laws = self.laws
        friction = {
            name: laws[where[0][0]].parameters[where[0][1]]
            for name, where in self.law_parameters.items()
        }
        return {**self.numbers, **friction, **self._wave_numbers}

    def _check_law_names(self) -> None:
        """Refuse a friction law whose parameter has the name of something else of the model."""
        names = owners_of(self.friction, self.n_blocks, hidden=True)
        if twice := names.keys() & {*self.numbers, *_arguments_of(type(self))}:
            name = min(twice)
            law = shown(self.laws[names[name][0][0]])
            raise ValueError(
                f"friction = {law} has a parameter {name}: {type(self).__name__} has one of that "
                "name itself. Give the law's another name."
            )

    @property
    def replaceable(self) -> tuple[str, ...]:
        """Names for which `replace` takes a number, those not shown while they are 0 included."""
        own = (name for name, value in self._arguments.items() if isinstance(value, float))
        laws = owners_of(self.friction, self.n_blocks, hidden=True)
        return tuple(dict.fromkeys([*self.numbers, *self._wave_numbers, *laws, *own]))

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
        numbers, forcing = {**self.numbers}, {**self._wave_numbers}
        own = {*_arguments_of(type(self)), "friction"}
        for_laws: dict[str, Any] = {}
        fields: dict[str, Any] = {}
        for name, value in changes.items():
            kinds = ((numbers, numbers), (forcing, forcing), (own, fields))
            next((into for known, into in kinds if name in known), for_laws)[name] = value
        fields["friction"] = self._friction_with(fields.get("friction", self.friction), for_laws)
        waves = {
            wave: harmonic_of({key: forcing[f"{wave}.{key}"] for key in known.numbers})
            for wave, (known, _) in self._waves.items()
        }
        return self._rebuilt(numbers, waves, **fields)

    def _friction_with(self, friction: Any, changes: Mapping[str, Any]) -> Any:
        """Friction with some of its parameters changed; ValueError for any other name."""
        if not changes:
            return friction
        friction = laws_of(friction, self.n_blocks)
        owners = owners_of(friction, self.n_blocks, hidden=True)
        laws = list(friction) if isinstance(friction, tuple) else [friction]
        per_law: list[dict[str, str]] = [{} for _ in laws]  # the given name by the law's own
        for name in changes:
            if name not in owners:
                others = [*self.numbers, *self._wave_numbers, *owners, *_arguments_of(type(self))]
                known = did_you_mean(name, list(dict.fromkeys(others)))
                raise ValueError(f"{type(self).__name__} has no parameter {shown(name)}. {known}")
            block, own_name = owners[name][0]
            per_law[block][own_name] = name
        for k, given in enumerate(per_law):
            with within(f"{', '.join(given.values())}: " if isinstance(friction, tuple) else ""):
                laws[k] = laws[k].replace(**{own: changes[name] for own, name in given.items()})
        return tuple(laws) if isinstance(friction, tuple) else laws[0]

    # --- as a value -------------------------------------------------------------------------

    @property
    def _arguments(self) -> dict[str, Any]:
        """What builds the model again, arrays as lists."""
        given = {name: getattr(self, name) for name in _arguments_of(type(self))}
        return {
            name: value.tolist() if isinstance(value, np.ndarray) else value
            for name, value in given.items()
            if value is not None
        }

    def __eq__(self, other: object) -> bool:
        """Equal numbers and laws."""
        if type(other) is not type(self):
            return NotImplemented
        return self._arguments == other._arguments

    def __hash__(self) -> int:
        """Hash of the numbers and laws."""
        return hash((type(self), repr(self._arguments)))

    def __repr__(self) -> str:
        """Call that builds the model again."""
        parts = (
            f"{name}={list(value) if name == 'friction' and type(value) is tuple else value!r}"
            for name, value in self._arguments.items()
        )
        return f"{self._maker}({', '.join(parts)})"

    @property
    def _maker(self) -> str:
        """Name of what builds the model."""
        return type(self).__name__

    # --- global stick ------------------------------------------------------------------------

    @property
    def limits(self) -> tuple[float, ...]:
        """Static limits of the blocks."""
        return tuple(self.plant.static.tolist())

    @property
    def monotone_loading(self) -> bool:
        """Whether a rider's needed force only grows while the others ride or slip backward."""
        s = self.plant
        if not s.rubs_as_one or s.damping.any() or s.is_forced:
            return False
        off = s.stiffness - np.diag(np.diag(s.stiffness))
        return bool((off <= 0.0).all() and (s.stiffness @ s.V >= 0.0).all())

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
                f"the domain of {self.size} is no interval: model.contains(d) tells "
                "which differences belong to it."
            )
        return locus.ends(self.plant)

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
                f"d = {shown(steps.tolist())}: along its last axis {n - 1} numbers are needed, the "
                f"differences X_(i+1) - X_i of {n} blocks."
                if n > 1
                else f"d = {shown(d)}: one block has no neighbour to differ from. Start it from x "
                "and v, or with d = [] at the end of its stick phase."
            )
        x = np.zeros((*steps.shape[:-1], n))
        np.cumsum(steps, axis=-1, out=x[..., 1:])
        return x

    @cached_property
    def _riding(self) -> tuple[Floats, Floats]:
        """Forces that all blocks need to ride: their change with displacements, and at 0."""
        s, n = self.plant, self.n_blocks
        x = np.concatenate([np.zeros((1, n)), np.eye(n)])
        forces = s.needed_force(x, np.broadcast_to(s.V, x.shape))
        return (forces[1:] - forces[0]).T, forces[0]

    def _stick_range(self, d: ArrayLike) -> tuple[Floats, Floats]:
        """Displacements of block 1 between which all blocks ride, shapes (...), or low > high."""
        s = self.plant
        matrix, at_rest = self._riding
        rate = s.stiffness.sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            force = at_rest + applied(matrix, self.positions(d))
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
        s = self.plant
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
            return locus.admit(d, low, high, lambda: f"[{low:.17g}, {high:.17g}]")
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
        """Draw differences of global stick phases, shape ``(n, *d_shape)``.

        They belong to displacements drawn uniformly from those with which all blocks ride.
        """
        x = self.plant.sample_sticking(n, rng)
        return np.asarray(np.diff(x, axis=-1).reshape(len(x), *self.d_shape))

    def spread_domain(self, n: int) -> Floats:
        """Return differences spread evenly over those of global stick phases, always the same.

        Shape (n, *d_shape); the needed forces are a Sobol sequence within the limits.
        """
        from scipy.stats.qmc import Sobol

        n = whole_number("n", n, at_most=MOST_POINTS)
        shares = Sobol(self.n_blocks, rng=0).random_base2(max(n - 1, 1).bit_length())[:n]
        return np.asarray(np.diff(self.plant.sticking(shares)).reshape(n, *self.d_shape))

    def sample_state(
        self, rng: np.random.Generator | int | None = None, *, riding: bool = False
    ) -> tuple[Floats, Floats]:
        """Draw a legal state (x, v), each of shape (n_blocks,), for `stickslip.simulate`.

        Needed forces are uniform within the static limits; velocities are the belt's if
        `riding`, else within one unit of f_s1 / sqrt(k m) of it, to the nearest power of ten.
        """
        speed = orders(self.plant).velocity
        return self.plant.sample_state(rng, riding=riding, speed=speed)


@cache
def _arguments_of(cls: type) -> tuple[str, ...]:
    """Names of what builds a model."""
    return tuple(signature(cls).parameters)


def owners_of(
    friction: Friction, n_blocks: int, *, hidden: bool = False
) -> dict[str, tuple[tuple[int, str], ...]]:
    """Blocks, and names in their laws, that each friction parameter belongs to."""
    # `hidden`: with those that a law does not show as long as they are 0, and its options.
    laws = friction if isinstance(friction, tuple) else (friction,)
    each = [law.names if hidden else tuple(law.parameters) for law in laws]
    if not isinstance(friction, tuple):
        return {name: tuple((k, name) for k in range(n_blocks)) for name in each[0]}
    return {
        f"{name}_{block + 1}": ((block, name),)
        for block, names in enumerate(each)
        for name in names
    }


def frozen(array: Floats) -> Floats:
    """Return an array that nothing can change."""
    array.flags.writeable = False
    return array


def named(name: str, array: Numbers) -> dict[str, float]:
    """Entries of a vector or a matrix by name, counted from 1."""
    return {
        "_".join([name, *(str(k + 1) for k in index)]): float(value)
        for index, value in np.ndenumerate(array)
    }


def paired(name: str, matrix: Numbers) -> dict[str, float]:
    """Entries of a symmetric matrix by name, each pair once; dampers that are 0 left out."""
    kept = named(name, np.triu(matrix))
    n = len(matrix)
    own = {f"{name}_{i + 1}_{j + 1}": (i, j) for i in range(n) for j in range(i, n)}
    return {
        key: kept[key]
        for key, (i, j) in own.items()
        if name != "damping" or i == j or kept[key] != 0.0
    }


def array_of(numbers: Mapping[str, Any], name: str, shape: tuple[int, ...]) -> Numbers:
    """Vector or matrix whose entries have these names; pairs may be given once."""
    flat = []
    for index in np.ndindex(shape):
        one, other = (
            "_".join([name, *(str(k + 1) for k in each)]) for each in (index, index[::-1])
        )
        flat.append(numbers[one] if one in numbers else numbers.get(other, 0.0))
    kind = np.complex128 if any(isinstance(value, complex) for value in flat) else None
    return np.array(flat, dtype=kind).reshape(shape)


def counted(n: int, one: str, many: str) -> str:
    """Return a number of things in words."""
    return f"{n} {one if n == 1 else many}"


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
        "Wrap a function of the slip speed, or a formula, in friction_law(...)."
        if isinstance(friction, str) or (callable(friction) and not isinstance(friction, type))
        else "Take Coulomb(mu=), PoppStelter(gamma=) or friction_law(...)."
    )
    raise ValueError(
        f"friction = {shown(friction)} is neither a friction law nor a list of laws. {remedy}"
    )
