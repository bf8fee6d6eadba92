"""Two blocks with Coulomb friction as exact numbers, and the phases of their motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, TypeAlias

from flint import arb, fmpq

from stickslip.proofs.jet import HALF, Number, spread
from stickslip.proofs.wave import Wave

if TYPE_CHECKING:
    from stickslip.mechanics.model.two_block import TwoBlock

__all__ = ["NAMES", "Exact", "Phase", "System", "exact_parameters", "fraction", "number"]

Exact: TypeAlias = str | int | float | Fraction | Decimal
NAMES = ("alpha", "beta", "V", "mu_1", "mu_2")


def fraction(name: str, value: Exact) -> Fraction:
    """Return a number exactly; a float as the shortest decimal that Python prints for it.

    Raises
    ------
    ValueError
        It is not a finite number.
    """
    try:
        return Fraction(repr(float(value)) if isinstance(value, float) else value)
    except (ValueError, TypeError, OverflowError, ZeroDivisionError):
        raise ValueError(
            f"{name} = {value!r} is not a finite exact number: give text such as '1.2' or '6/5', "
            "an int, a Fraction, a Decimal or a float, which is read as the decimal it prints"
        ) from None


def number(value: Fraction) -> arb:
    """Enclose an exact number at the precision at hand."""
    return arb(fmpq(value.numerator, value.denominator))


def exact_parameters(
    model: TwoBlock, exact: Mapping[str, Exact] | None = None
) -> dict[str, Fraction]:
    """Return the parameters of a model exactly.

    Parameters
    ----------
    model : TwoBlock
        With Coulomb friction, undamped; its floats are read as the decimals they print.
    exact : mapping of str to exact number, optional
        Values that replace the model's, by the names of ``model.parameters``.

    Raises
    ------
    ValueError
        The model is of another kind, a name is unknown, or a value is out of range.
    """
    laws = model.friction if isinstance(model.friction, tuple) else (model.friction,) * 2
    strange = [law for law in laws if law.name != "coulomb" or law.parameters.get("viscous")]
    if strange or model.damping:
        what = f"damping = {model.damping!r}" if model.damping else f"friction = {strange[0]}"
        raise ValueError(
            f"{what} cannot be certified: proofs cover undamped two-block models with Coulomb "
            "friction, Coulomb(mu=...)"
        )
    given: dict[str, Exact] = {**model.parameters, **(exact or {})}
    if unknown := sorted(set(given) - set(model.parameters)):
        raise ValueError(
            f"exact names {unknown[0]!r}, which is no parameter of the model: "
            f"{', '.join(model.parameters)}"
        )
    if "mu" in given:
        given["mu_1"] = given["mu_2"] = given["mu"]
    values = {name: fraction(name, given[name]) for name in NAMES}
    if values["alpha"] < 0:
        raise ValueError(f"alpha = {values['alpha']} is out of range: alpha >= 0")
    for name in ("beta", "V"):
        if values[name] <= 0:
            raise ValueError(f"{name} = {values[name]} is out of range: {name} > 0")
    for name in ("mu_1", "mu_2"):
        if not 0 <= values[name] <= 1:
            raise ValueError(f"{name} = {values[name]} is out of range: 0 <= {name} <= 1")
    return values


@dataclass(frozen=True)
class System:
    """The parameters as numbers or as coordinates of a box; eqs. (5a)-(10)."""

    alpha: Number
    beta: Number
    V: Number
    mu_1: Number
    mu_2: Number

    @property
    def limits(self) -> tuple[Number, Number]:
        """Static limits of the blocks."""
        return arb(1), self.beta

    def friction(self, block: int, mode: int) -> Number:
        """Kinetic friction on a slipping block."""
        return (self.mu_1, self.mu_2)[block] * self.limits[block] * arb(-mode)

    def distance(self, e: tuple[Number, Number]) -> Number:
        """D = X_2 - X_1 from the needed forces."""
        return (e[1] - e[0]) / (2 * self.alpha + 1)


class Phase:
    """Motion with constant modes from a state (w, e): each a wave (docs: proofs, the flow).

    Parameters
    ----------
    system : System
    modes : pair of int
        -1 backward slip, 0 stick, 1 forward slip; not both 0.
    w, e : pair of Jet or arb
        Relative velocities and needed forces at the start.
    """

    def __init__(
        self,
        system: System,
        modes: tuple[int, int],
        w: tuple[Number, Number],
        e: tuple[Number, Number],
    ) -> None:
        self.system, self.modes = system, modes
        both = modes[0] and modes[1]
        self.w, self.e = self._both(w, e) if both else self._one(w, e)
        self.signals = self._signals()

    def _one(
        self, w: tuple[Number, Number], e: tuple[Number, Number]
    ) -> tuple[tuple[Wave, Wave], tuple[Wave, Wave]]:
        """One block slips; the other rides and feels it through the coupling spring."""
        a = 0 if self.modes[0] else 1
        alpha, V = self.system.alpha, self.system.V
        stiffness = alpha + 1
        slip, force = oscillator(stiffness, V, self.system.friction(a, self.modes[a]), w[a], e[a])
        share = alpha / stiffness
        drift = (2 * alpha + 1) * V / stiffness
        ride = force * -share + (e[1 - a] + share * e[a])
        ride = Wave(ride.constant, drift, ride.terms, ride.omegas)
        still = slip * arb(0)
        return ((slip, still), (force, ride)) if a == 0 else ((still, slip), (ride, force))

    def _both(
        self, w: tuple[Number, Number], e: tuple[Number, Number]
    ) -> tuple[tuple[Wave, Wave], tuple[Wave, Wave]]:
        """Both slip: the sum and the difference of the blocks are oscillators."""
        f = [self.system.friction(i, self.modes[i]) for i in (0, 1)]
        V, stiffness = self.system.V, 2 * self.system.alpha + 1
        total = oscillator(arb(1), 2 * V, f[0] + f[1], w[0] + w[1], e[0] + e[1])
        between = oscillator(stiffness, arb(0), f[1] - f[0], w[1] - w[0], e[1] - e[0])
        omegas = total[0].omegas + between[0].omegas
        (w_sum, e_sum) = (x.stretched(0, 1, omegas) for x in total)
        (w_gap, e_gap) = (x.stretched(1, 0, omegas) for x in between)
        return (
            ((w_sum + -w_gap) * HALF, (w_sum + w_gap) * HALF),
            ((e_sum + -e_gap) * HALF, (e_sum + e_gap) * HALF),
        )

    def _signals(self) -> list[tuple[int, int, Wave]]:
        """Return what stays positive while the modes last: (block, end, wave).

        The end is 0 for a landing, 1 or -1 for a rider's upper or lower limit. A rider whose
        neighbour slips backward is loaded: e' = V - alpha w >= V > 0, so only its upper limit.
        """
        found = []
        for i in (0, 1):
            mode, other = self.modes[i], self.modes[1 - i]
            if mode:
                found.append((i, 0, self.w[i] * arb(mode)))
                continue
            limit = self.system.limits[i]
            found.append((i, 1, -self.e[i] + limit))
            if other > 0:
                found.append((i, -1, self.e[i] + limit))
        return found


def oscillator(
    stiffness: Number, drive: Number, friction: Number, x: Number, y: Number
) -> tuple[Wave, Wave]:
    """Solve x' = friction - y, y' = stiffness x + drive."""
    omega = stiffness.sqrt()
    pull, rest, swing = friction - y, drive / stiffness, x + drive / stiffness
    none = arb(0)
    return (
        Wave(-rest, none, ((swing, pull / omega),), (omega,)),
        Wave(friction, none, ((-pull, swing * omega),), (omega,)),
    )


def positive(x: Number) -> bool:
    """Whether a quantity is positive on the whole box."""
    return bool(spread(x) > 0)
