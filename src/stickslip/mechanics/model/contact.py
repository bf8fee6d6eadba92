"""What acts on a structure from outside: dry contacts, and forces that oscillate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.checks import (
    LARGEST,
    MOST_KEPT,
    dimensions,
    instance,
    model_number,
    real_numbers,
    shown,
    whole_number,
)
from stickslip.mechanics.friction.coulomb import is_constant
from stickslip.mechanics.friction.law import FrictionLaw
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike

    from stickslip.numerics.arrays import Floats


@suggests
@dataclass(frozen=True)
class Harmonic:
    """Forces ``g_i = amplitude_i cos(frequency t + phase)`` on the blocks.

    Parameters
    ----------
    amplitude : float or sequence of float
        One for all blocks, or one per block; units of f_s1.
    frequency : float
        Angular, > 0, units of sqrt(k / m).
    phase : float
        Radians.

    Raises
    ------
    ValueError
        A number is not finite, or the frequency not positive.

    Examples
    --------
    >>> import stickslip as ss
    >>> force = ss.Harmonic(0.2, frequency=4.0)
    >>> shaken = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5), forcing=force)
    >>> round(force.period, 6)
    1.570796
    """

    amplitude: float | tuple[float, ...]
    frequency: float
    phase: float = 0.0

    def __post_init__(self) -> None:
        """Check every number once."""
        given = self.amplitude
        if dimensions(given) == 0:
            why = "An amplitude is a force in units of f_s1."
            amplitude: float | tuple[float, ...] = model_number("amplitude", given, why=why)
        else:
            amplitude = _weights("amplitude", given)
        object.__setattr__(self, "amplitude", amplitude)
        why = "A forcing repeats after 2 pi / frequency."
        frequency = model_number("frequency", self.frequency, above=0.0, why=why)
        object.__setattr__(self, "frequency", frequency)
        phase = model_number("phase", self.phase, why="The phase is an angle in radians.")
        object.__setattr__(self, "phase", phase)

    @property
    def period(self) -> float:
        """Time after which the forcing repeats, 2 pi / frequency."""
        return 2.0 * np.pi / self.frequency

    @property
    def numbers(self) -> dict[str, float]:
        """Its numbers by name."""
        given = self.amplitude
        if isinstance(given, tuple):
            named = {f"amplitude_{i}": a for i, a in enumerate(given, start=1)}
        else:
            named = {"amplitude": given}
        return {**named, "frequency": self.frequency, "phase": self.phase}

    def amplitudes(self, n_blocks: int) -> tuple[float, ...]:
        """Amplitude on each block.

        Raises
        ------
        ValueError
            As many amplitudes as blocks are needed, or one for all.
        """
        n_blocks = whole_number("n_blocks", n_blocks, at_most=MOST_KEPT)
        if not isinstance(self.amplitude, tuple):
            return (self.amplitude,) * n_blocks
        if len(self.amplitude) != n_blocks:
            raise ValueError(
                f"forcing amplitude has {len(self.amplitude)} entries for {n_blocks} blocks: "
                "give one number for all blocks, or one per block."
            )
        return self.amplitude


def harmonic_of(numbers: Mapping[str, Any]) -> Harmonic:
    """Make a harmonic of its numbers by name."""
    *amplitude, frequency, phase = numbers.values()
    given = amplitude[0] if "amplitude" in numbers else tuple(amplitude)
    return Harmonic(given, frequency, phase)


@suggests
@dataclass(frozen=True)
class Contact:
    """A place of a structure where dry friction acts; it slips at ``w = b v - V``.

    Parameters
    ----------
    at : int, pair of int, or array_like of float, shape (n,)
        A coordinate, counted from 0; a tuple ``(i, j)``: body i rubs on body j; or a list or array:
        weights b. Of a structure in state-space form: the column of B and the row of C.
    friction : FrictionLaw
        Kinetic friction relative to the static limit.
    static : float
        Static limit at zero positions; > 0.
    V : float, Harmonic, or a pair (float, Harmonic)
        Velocity of what it rubs on, of either sign: constant, oscillating, or both. 0: the ground.
    load : array_like of float, shape (n,), optional
        Weights l of the positions: the static limit is ``static + l . q``, as of a normal force
        that springs carry. In state-space form: of the state.
    stiffness : float, optional
        > 0: an elastic contact (Jenkins element): a spring between the structure and a foot
        without mass, which rubs. Its kinetic friction is constant, ``Coulomb(mu)``.

    Raises
    ------
    ValueError
        A number that is not finite, a static limit or a stiffness that is not positive.

    Examples
    --------
    >>> import stickslip as ss
    >>> belt = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=0.1)
    >>> between = ss.Contact(at=(0, 1), friction=ss.Coulomb(mu=0.5), static=0.4)  # the two bodies
    >>> stiffness = [[2, -1], [-1, 1]]
    >>> pair = ss.Structure(mass=[1, 2], stiffness=stiffness, contacts=[belt, between])
    >>> pair.parameters["static_2"]
    0.4
    """

    at: int | tuple[int, int] | tuple[float, ...]
    friction: FrictionLaw
    static: float = 1.0
    V: float | tuple[float, Harmonic] = 0.0
    load: tuple[float, ...] | None = None
    stiffness: float | None = None

    def __post_init__(self) -> None:
        """Check every number once; weights become tuples of floats."""
        known = "a friction law. Take Coulomb(mu=), PoppStelter(gamma=) or friction_law(...)"
        why = "A static friction limit is positive: the contact is closed at rest."
        checked: dict[str, Any] = {
            "at": _place(self.at),
            "friction": instance("friction", self.friction, FrictionLaw, known),
            "static": model_number("static", self.static, above=0.0, why=why),
            "V": _velocity(self.V),
            "load": None if self.load is None else _weights("load", self.load),
            "stiffness": None if self.stiffness is None else _stiffness(self.stiffness),
        }
        if self.stiffness is not None and not is_constant(self.friction):
            raise ValueError(
                f"friction = {shown(self.friction)} of a contact with stiffness = "
                f"{shown(self.stiffness)}: its foot has no mass, so that its speed would have to "
                "follow from the force, and no speed or several might do. Take Coulomb(mu=)."
            )
        for name, value in checked.items():
            object.__setattr__(self, name, value)

    @property
    def belt(self) -> tuple[float, Harmonic | None]:
        """Constant velocity of what it rubs on, and how it oscillates."""
        return self.V if isinstance(self.V, tuple) else (self.V, None)


def _stiffness(given: object) -> float:
    why = "The spring of an elastic contact pulls back; without stiffness= the contact is rigid."
    return model_number("stiffness", given, above=0.0, why=why)


def weights_of(contact: Contact, n: int, name: str) -> Floats:
    """Weights b of n coordinates; ValueError if they are not there."""
    entries = contact.at if isinstance(contact.at, tuple) else (contact.at,)
    if all(isinstance(entry, float) for entry in entries):
        return fitting(f"{name}.at", np.array(entries), n)
    b = np.zeros(n)
    for entry, sign in zip(entries, (1.0, -1.0), strict=False):
        what = "a coordinate, counted from 0"
        b[whole_number(f"{name}.at", entry, 0, at_most=n - 1, what=what)] += sign
    return b


def _place(at: Any) -> int | tuple[int, int] | tuple[float, ...]:
    if not isinstance(at, tuple):
        return _weights("at", at) if dimensions(at) else whole_number("at", at, 0)
    if all(isinstance(entry, float) for entry in at):
        return _weights("at", at)  # as they are kept
    if len(at) != 2 or at[0] == at[1]:
        raise ValueError(
            f"at = {shown(at)}: a tuple names two bodies (i, j) that rub on each other. Give "
            "weights as a list or an array."
        )
    return whole_number("at[0]", at[0], 0), whole_number("at[1]", at[1], 0)


def _weights(name: str, given: ArrayLike) -> tuple[float, ...]:
    weights = real_numbers(name, given)
    if weights.ndim != 1 or not (np.abs(weights) <= LARGEST).all() or weights.size == 0:
        raise ValueError(
            f"{name} = {shown(given)}: give one finite number per coordinate, at most {LARGEST:g} "
            "in size."
        )
    return tuple(weights.tolist())


def fitting(name: str, weights: Floats, n: int) -> Floats:
    """Return weights of n coordinates; ValueError if there are more or fewer."""
    if weights.shape != (n,):
        raise ValueError(f"{name} has {weights.size} entries for {n} coordinates.")
    return weights


def _velocity(given: Any) -> float | tuple[float, Harmonic]:
    mean, wave = (0.0, given) if isinstance(given, Harmonic) else (given, None)
    if isinstance(given, tuple) and len(given) == 2:
        mean, wave = given
    mean = model_number("V", mean, why="V is the velocity of what the contact rubs on.")
    if wave is None:
        return mean
    wave = instance("V[1]", wave, Harmonic, "a Harmonic(amplitude=, frequency=, phase=)")
    if isinstance(wave.amplitude, tuple):
        raise ValueError(
            f"V = {shown(given)}: the velocity of one belt has one amplitude, a number."
        )
    return mean, wave
