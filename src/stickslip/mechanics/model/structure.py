"""Any linear plant with dry contacts, as users write it: matrices, contacts, forces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Final, Self

import numpy as np

from stickslip.checks import dimensions, instance, model_number, real_numbers, shown, whole_number
from stickslip.mechanics.model.belt_model import (
    MOST_BLOCKS,
    BeltModel,
    array_of,
    check_definite,
    counted,
    frozen,
    laws_of,
    matrix_of,
    named,
    one_per_block,
    paired,
    symmetric,
)
from stickslip.mechanics.model.contact import Contact, Harmonic, fitting, weights_of
from stickslip.mechanics.model.plant import ROUNDING, Plant
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.numerics.arrays import Floats


@suggests
class Structure(BeltModel):
    """Any linear plant with dry contacts: M q'' + C q' + K q = force + forcing + friction.

    Masses that do not rub, free rotors, follower forces, several belts, loads that vary, friction
    between two bodies. Dimensionless or in SI units, as long as all numbers agree.

    Parameters
    ----------
    mass : array_like of float, shape (n,) or (n, n)
        > 0; or a symmetric, positive definite matrix.
    stiffness : array_like of float, shape (n, n), or (n,) of a diagonal
        Of any symmetry; may be singular.
    damping : array_like of float, shape (n, n) or (n,), optional
        Of any symmetry; none by default.
    contacts : sequence of Contact
        One or more; several may act on the same bodies.
    force : array_like of float, shape (n,), optional
        Constant forces.
    forcing : Harmonic or sequence of Harmonic, optional

    Raises
    ------
    ValueError
        A matrix of the wrong shape, a number that is not finite; contacts whose
        velocities nearly depend on each other; a static limit that is not positive at rest.

    Notes
    -----
    Parameters are named as ``mass_1``, ``stiffness_1_2`` (both entries of a symmetric matrix),
    ``force_1``, ``forcing.frequency`` (``forcing_2.frequency`` of several), and by contact
    ``static_1``, ``V_1``, ``V_1.amplitude``, ``load_1_2``, ``contact_stiffness_1``, ``mu_1``.
    States of a structure with elastic contacts go on with displacements and velocities of their
    feet, along ``at`` and in the order of contacts; where these are left out, the springs are
    relaxed and the feet stick. Derivation: docs/theory/plant.md.

    Examples
    --------
    A mass on a belt that carries another one, which does not rub:

    >>> import stickslip as ss
    >>> model = ss.Structure(
    ...     mass=[1.0, 0.3], stiffness=[[2.0, -1.0], [-1.0, 1.0]],
    ...     contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.2)])
    >>> ss.simulate(model, [0.0, 0.0], [0.2, 0.0], t_end=20).events[0].kind
    'slip backward'
    """

    def __init__(
        self,
        mass: ArrayLike,
        stiffness: ArrayLike,
        damping: ArrayLike | None = None,
        *,
        contacts: Sequence[Contact],
        force: ArrayLike | None = None,
        forcing: Harmonic | Sequence[Harmonic] | None = None,
    ) -> None:
        n = len(np.atleast_1d(real_numbers("mass", mass)))
        whole_number("len(mass)", n, at_most=MOST_BLOCKS)
        why = "A mass is positive."
        if dimensions(mass) == 2:
            one_per_block("diagonal of mass", np.diag(matrix_of("mass", mass, (n, n))), n, why)
            self.mass = symmetric("mass", mass, n, "kinetic energy knows no other")
            check_definite("mass", self.mass, "Each motion has kinetic energy.")
        else:
            self.mass = frozen(one_per_block("mass", mass, n, why))
        self.stiffness = _square("stiffness", stiffness, n)
        self.damping = _square("damping", np.zeros(n) if damping is None else damping, n)
        self._set_contacts(contacts, force, forcing, n)
        self._weights = np.array(
            [weights_of(contact, n, f"contacts[{k}]") for k, contact in enumerate(self.contacts)]
        )
        self._check_law_names()
        check_contacts(self.plant)

    def _set_contacts(self, contacts: Any, force: Any, forcing: Any, n: int) -> None:
        known = "a list of ss.Contact(at=, friction=, ...), one at least"
        given: Sequence[Contact] = instance("contacts", contacts, (list, tuple), known)
        self.contacts = tuple(given)
        if not self.contacts:
            raise ValueError(f"contacts = {shown(contacts)} must be {known}.")
        for k, contact in enumerate(self.contacts):
            instance(f"contacts[{k}]", contact, Contact, "an ss.Contact(at=, friction=, ...)")
            if contact.load is not None:
                fitting(f"contacts[{k}].load", np.array(contact.load), n)
        self.force = None if force is None else matrix_of("force", force, (n,))
        several = [] if forcing is None else [forcing] if isinstance(forcing, Harmonic) else forcing
        known = "a Harmonic(amplitude=, frequency=, phase=), or a list of such"
        waves: Sequence[Harmonic] = instance("forcing", several, (list, tuple), known)
        for wave in waves:
            instance("forcing", wave, Harmonic, known).amplitudes(n)
        self.forcing = tuple(waves) or None  # type: ignore[assignment]

    @classmethod
    def from_state_space(
        cls,
        A: ArrayLike,
        B: ArrayLike,
        C: ArrayLike,
        *,
        contacts: Sequence[Contact],
        a: ArrayLike | None = None,
        forcing: Harmonic | Sequence[Harmonic] | None = None,
    ) -> StateSpace:
        """Make a structure of ``x' = A x + a + forcing + B f`` with contacts at ``w = C x - V``.

        Controllers, integrators and filters have states of their own. What takes displacements and
        velocities takes the state as displacements, and no velocities.

        Parameters
        ----------
        A : array_like of float, shape (n, n)
        B : array_like of float, shape (n, m)
            How the friction forces enter.
        C : array_like of float, shape (m, n)
            Velocities at the contacts; ``C B`` is symmetric and positive definite.
        contacts : sequence of Contact
            m of them; ``at`` is the column of B and row of C; a load weighs the state.
        a : array_like of float, shape (n,), optional
            Constant part.
        forcing : Harmonic or sequence of Harmonic, optional

        Returns
        -------
        Structure
            With parameters ``A_1_2``, ``B_1_1``, ``C_1_1``, ``a_1``, else as `Structure`.

        Raises
        ------
        ValueError
            As for `Structure`.
        """
        return StateSpace(A, B, C, contacts=contacts, a=a, forcing=forcing)

    # --- parameters --------------------------------------------------------------------------

    @property
    def n_blocks(self) -> int:
        """Number of contacts."""
        return len(self.contacts)

    @property
    def size(self) -> str:
        """How many masses there are, or states of a state-space form, and contacts, in words."""
        what = ("mass", "masses") if self.plant.n_positions else ("state", "states")
        contacts = counted(self.n_blocks, "contact", "contacts")
        return f"{counted(len(self.plant.mass), *what)} with {contacts}"

    @property
    def friction(self) -> tuple[FrictionLaw, ...]:  # type: ignore[override]
        """Friction law of each contact."""
        return tuple(contact.friction for contact in self.contacts)

    @property
    def V(self) -> float:  # type: ignore[override]
        """Velocity that all contacts rub on, where it is one constant; else NaN."""
        speeds = {contact.V for contact in self.contacts}
        (speed,) = speeds if len(speeds) == 1 else (np.nan,)
        return speed if isinstance(speed, float) else np.nan

    @property
    def numbers(self) -> dict[str, float]:
        """Entries of the matrices, forces, and numbers of the contacts, by name."""
        own = {name: given for name, given in self._matrices.items() if given is not None}
        numbers: dict[str, float] = {}
        for name, array in own.items():
            numbers |= (paired if name in self._pairs else named)(name, array)
        for k, contact in enumerate(self.contacts, start=1):
            numbers |= {f"static_{k}": contact.static, f"V_{k}": contact.belt[0]}
            if contact.load is not None:
                numbers |= named(f"load_{k}", np.array(contact.load))
            if contact.stiffness is not None:
                numbers[f"contact_stiffness_{k}"] = contact.stiffness
        return numbers

    @property
    def _matrices(self) -> dict[str, Floats | None]:
        given = (self.mass, self.stiffness, self.damping, self.force)
        return dict(zip(("mass", "stiffness", "damping", "force"), given, strict=True))

    @property
    def _waves(self) -> dict[str, tuple[Harmonic, int | None]]:
        forcing: Any = self.forcing or ()
        alone = len(forcing) == 1
        waves: dict[str, tuple[Harmonic, int | None]] = {
            "forcing" if alone else f"forcing_{k}": (wave, None)
            for k, wave in enumerate(forcing, start=1)
        }
        belts = [(k, contact.belt[1]) for k, contact in enumerate(self.contacts)]
        return waves | {f"V_{k + 1}": (wave, k) for k, wave in belts if wave is not None}

    def _arrays(self, numbers: Mapping[str, Any]) -> dict[str, Any]:
        return {
            name: None if given is None else array_of(numbers, name, given.shape)
            for name, given in self._matrices.items()
        }

    def _contact_arrays(self, numbers: Mapping[str, Any], n: int) -> dict[str, Any]:
        m = self.n_blocks
        none = np.zeros(0)
        loads = [array_of(numbers, f"load_{k + 1}", (n,)) for k in range(m)]
        return {
            "static": array_of(numbers, "static", (m,)),
            "load": np.array(loads),
            "V": array_of(numbers, "V", (m,)),
            "amplitude": np.zeros((n, 0)),
            "belt": np.zeros((m, 0)),
            "frequency": none,
            "phase": none,
        }

    def _plant_with(self, numbers: Mapping[str, Any]) -> Plant:
        names = {k: f"contact_stiffness_{k + 1}" for k in range(self.n_blocks)}
        springs = {k: numbers[name] for k, name in names.items() if name in numbers}
        return super()._plant_with(numbers).with_feet(springs)

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        arrays = self._arrays(numbers)
        n = len(arrays["mass"])
        force = arrays.pop("force")
        contacts = self._contact_arrays(numbers, n)
        load = contacts.pop("load")
        return Plant(
            **arrays,
            into=self._weights.T,
            out=self._weights,
            load=np.concatenate([load, np.zeros_like(load)], axis=1),
            force=np.zeros(n) if force is None else force,
            **contacts,
        )

    @cached_property
    def _pairs(self) -> frozenset[str]:
        """Symmetric matrices, whose entries have one name a pair."""
        matrices = {name: self._matrices.get(name) for name in PAIRED}
        return frozenset(
            name
            for name, m in matrices.items()
            if m is not None and m.ndim == 2 and np.array_equal(m, m.T)
        )

    def _rebuilt(
        self, numbers: Mapping[str, float], waves: Mapping[str, Harmonic], **changes: Any
    ) -> Self:
        laws = laws_of(changes.pop("friction"), self.n_blocks)
        contacts = []
        for k, contact in enumerate(self.contacts):
            wave = waves.get(f"V_{k + 1}")
            speed = model_number(f"V_{k + 1}", numbers[f"V_{k + 1}"])
            load = contact.load
            if load is not None:
                load = tuple(numbers[f"load_{k + 1}_{j + 1}"] for j in range(len(load)))
            contacts.append(
                replace(
                    contact,
                    friction=laws[k] if isinstance(laws, tuple) else laws,
                    static=model_number(f"static_{k + 1}", numbers[f"static_{k + 1}"], above=0.0),
                    V=speed if wave is None else (speed, wave),
                    load=load,
                    stiffness=numbers.get(f"contact_stiffness_{k + 1}"),
                )
            )
        forcing = [waves[name] for name, (_, contact) in self._waves.items() if contact is None]
        given = {"contacts": contacts, "forcing": forcing or None, **changes}
        made = type(self)(**{**self._arrays(numbers), **given})
        made.__dict__["_pairs"] = made._pairs & (self._pairs | changes.keys())
        return made


CLOSE: Final = 1e-6
"""Of the inertia that a contact acts on: what it must at least have for itself."""
MOST_WAYS: Final = 1000
"""In which dependent contacts can begin to slip."""
PAIRED = ("mass", "stiffness", "damping")
"""Matrices whose entries come in pairs where they are symmetric."""


class StateSpace(Structure):
    """A structure in state-space form; `Structure.from_state_space` makes it."""

    def __init__(
        self,
        A: ArrayLike,
        B: ArrayLike,
        C: ArrayLike,
        *,
        contacts: Sequence[Contact],
        a: ArrayLike | None = None,
        forcing: Harmonic | Sequence[Harmonic] | None = None,
    ) -> None:
        n = len(np.atleast_1d(real_numbers("A", A)))
        self.A = matrix_of("A", A, (n, n))
        self._set_contacts(contacts, a, forcing, n)
        m = len(self.contacts)
        self.B = matrix_of("B", B, (n, m))
        self.C = matrix_of("C", C, (m, n))
        self.a = self.force
        places = [contact.at for contact in self.contacts]
        if places != list(range(m)):
            raise ValueError(
                f"contacts have at = {shown(places)}: in state-space form contact k has at=k, its "
                "column of B and row of C."
            )
        for k, contact in enumerate(self.contacts):
            if contact.stiffness is not None:
                raise ValueError(
                    f"contacts[{k}].stiffness = {contact.stiffness!r}: a structure in state-space "
                    "form tells no displacement that could stretch a spring. Give masses, or a "
                    "rigid contact."
                )
        self._check_law_names()
        check_contacts(self.plant)

    _maker = "Structure.from_state_space"

    @property
    def _matrices(self) -> dict[str, Floats | None]:
        return {"A": self.A, "B": self.B, "C": self.C, "a": self.a}

    def _assemble(self, numbers: Mapping[str, Any]) -> Plant:
        arrays = self._arrays(numbers)
        n = len(self.A)
        return Plant(
            mass=np.ones(n),
            stiffness=np.zeros((n, 0)),
            damping=-arrays["A"],
            into=arrays["B"],
            out=arrays["C"],
            force=np.zeros(n) if arrays["a"] is None else arrays["a"],
            **self._contact_arrays(numbers, n),
        )


def _square(name: str, given: object, n: int) -> Floats:
    """Return an (n, n) matrix, given whole or by its diagonal."""
    array = real_numbers(name, given)
    return matrix_of(name, np.diag(array) if array.shape == (n,) else array, (n, n))


def check_contacts(plant: Plant) -> None:
    """Check that contacts act on inertia, in pairs alike, and independently or exactly not so."""
    response = plant.response
    own = np.diag(response)
    for k in np.flatnonzero(own <= 0.0):
        raise ValueError(
            f"contacts[{k}] acts on no inertia: C B has the entry {own[k]:.6g} there, and > 0 is "
            "needed. Without inertia friction has nothing to slow down."
        )
    size = np.sqrt(np.outer(own, own))
    if not plant.is_coupled:
        return
    odd = np.abs(response - response.T) > ROUNDING * size
    if odd.any():
        i, j = (int(k) for k in np.argwhere(odd)[0])
        raise ValueError(
            f"contacts[{i}] and contacts[{j}] share inertia, but C B has the entries [{i}, {j}] = "
            f"{response[i, j]:.6g} and [{j}, {i}] = {response[j, i]:.6g}: it must be symmetric. "
            "Forces at contacts do their work on the velocities of slip there."
        )
    shares = np.linalg.eigvalsh(response / size)
    unclear = (shares < CLOSE) & (np.abs(shares) > ROUNDING if plant.n_positions else True)
    if unclear.any():
        raise ValueError(
            "the velocities at the contacts nearly depend on each other: C B, scaled to ones on "
            f"its diagonal, has the eigenvalue {shares[unclear][0]:.6g}. At least {CLOSE:g} is "
            "needed, or exact dependence, as of two bodies with three contacts, in a structure "
            "given by masses."
        )
    ways = math.comb(len(own), len(plant.independent) - 1)
    if len(plant.independent) < len(own) and ways > MOST_WAYS:
        raise ValueError(
            f"contacts = {len(own)} whose velocities depend on each other may leave {ways} sets of "
            f"others at rest; at most {MOST_WAYS} are tried."
        )
