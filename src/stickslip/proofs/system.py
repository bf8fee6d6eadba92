"""Two blocks and their laws as exact numbers, and the phases of their motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, Final, NamedTuple, TypeAlias

from flint import arb, fmpq

from stickslip.checks import instance, shown
from stickslip.mechanics.model.arguments import two_blocks
from stickslip.proofs.jet import HALF, Number
from stickslip.proofs.taylor import Falling, TaylorStep, signals
from stickslip.proofs.wave import Wave

Exact: TypeAlias = str | int | float | Fraction | Decimal


class Constant(NamedTuple):
    """Law (8): F = mu."""

    mu: Number


Law: TypeAlias = Constant | Falling
Modes: TypeAlias = tuple[int, int]
Pair: TypeAlias = tuple[Number, Number]
# Least and largest value; the least of None is 0, excluded.
RANGES: Final[dict[str, tuple[int | None, int | None]]] = {
    "alpha": (0, None),
    "beta": (None, None),
    "V": (None, None),
    "mu": (0, 1),
    "gamma": (0, None),
    "delta": (0, 1),
    "eta": (0, None),
}
EQUALITIES: Final = {
    0: "a single slip without friction ends with its force exactly at the lower limit",
    1: "a single slip against the static limit comes back by a touch",
}
LAWS: Final[dict[str, type[Constant] | type[Falling]]] = {
    "coulomb": Constant,
    "popp-stelter": Falling,
}


def fraction(name: str, value: Exact) -> Fraction:
    """Return a number exactly; a float as the shortest decimal that Python prints for it."""
    try:
        exact = Fraction(repr(float(value)) if isinstance(value, float) else value)
        return Fraction(int(exact.numerator), int(exact.denominator))  # NumPy's stay NumPy's
    except (ValueError, TypeError, OverflowError, ZeroDivisionError):
        raise ValueError(
            f"{name} = {shown(value)} is not a finite exact number: give text such as '1.2' or "
            "'6/5', an int, a Fraction, a Decimal or a float, read as the decimal that it prints"
        ) from None


def decimal(value: Fraction) -> str:
    """Write a number exactly: as a decimal if it is one."""
    rest = value.denominator
    for factor in (2, 5):
        while rest % factor == 0:
            rest //= factor
    if rest != 1:
        return str(value)
    places = 0
    while (value * 10**places).denominator != 1:
        places += 1
    text = str(abs(value * 10**places)).rjust(places + 1, "0")
    sign = "-" if value < 0 else ""
    return f"{sign}{text[:-places]}.{text[-places:]}" if places else sign + text


def number(value: Fraction) -> arb:
    """Enclose an exact number at the precision at hand."""
    return arb(fmpq(value.numerator, value.denominator))


def middle_of(x: arb) -> Fraction:
    """Return the middle of a ball, exactly."""
    mantissa, exponent = x.mid().man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def exact_parameters(
    system: object, exact: Mapping[str, Exact] | None = None
) -> dict[str, Fraction]:
    """Return a model's parameters exactly, floats as printed; `exact` ones replace them."""
    model = two_blocks(system, why="Proofs are about the event map of two equal blocks.")
    if exact is not None:
        instance("exact", exact, Mapping, 'values by name, such as {"alpha": "1.2"}')
    laws = model.friction if isinstance(model.friction, tuple) else (model.friction,) * 2
    strange = [law for law in laws if law.name not in LAWS or law.parameters.get("viscous")]
    if strange or model.damping or laws[0].name != laws[1].name:
        what = f"damping = {model.damping!r}" if model.damping else f"friction = {laws!r}"
        raise ValueError(
            f"{what} cannot be certified: proofs cover undamped two-block models whose blocks both "
            "have Coulomb friction, Coulomb(mu=...), or both law (9), PoppStelter(gamma=...)"
        )
    given: dict[str, Exact] = {**model.parameters, **(exact or {})}
    if unknown := sorted(set(given) - set(model.parameters)):
        raise ValueError(
            f"exact names {unknown[0]!r}, which is no parameter of the model: "
            f"{', '.join(model.parameters)}"
        )
    of_law = LAWS[laws[0].name]._fields
    for name in of_law:
        if name in given:
            given[f"{name}_1"] = given[f"{name}_2"] = given[name]
    names = ["alpha", "beta", "V", *(f"{name}_{i}" for i in (1, 2) for name in of_law)]
    values = {name: fraction(name, given[name]) for name in names}
    for name, value in values.items():
        legal(name, value)
    return values


def legal(name: str, value: Fraction) -> None:
    """Refuse a value of a parameter about which nothing can be proven."""
    low, high = RANGES[name.split("_")[0]]
    if not (value > 0 if low is None else value >= low) or (high is not None and value > high):
        allowed = f"{name} > 0" if low is None else f"{low} <= {name}"
        allowed += "" if high is None else f" <= {high}"
        raise ValueError(f"{name} = {value} is out of range: {allowed}")
    if name in ("mu", "mu_1", "mu_2") and value in EQUALITIES:
        raise ValueError(
            f"{name} = {value} cannot be certified: {EQUALITIES[int(value)]}, an equality that "
            "no enclosure decides"
        )


def law_of(values: Mapping[str, Any]) -> type[Constant] | type[Falling]:
    """Return the law whose parameters are among these names."""
    return next(law for law in LAWS.values() if f"{law._fields[0]}_1" in values)


@dataclass(frozen=True)
class System:
    """The parameters as numbers or as coordinates of a box; eqs. (5a)-(10)."""

    alpha: Number
    beta: Number
    V: Number
    laws: tuple[Law, Law]

    @property
    def limits(self) -> tuple[Number, Number]:
        """Static limits of the blocks."""
        return arb(1), self.beta

    def phase(
        self, modes: Modes, w: Pair, e: Pair, released: int | None = None
    ) -> Phase | TaylorStep:
        """Return the motion with constant modes from a state, for ever or for some time."""
        # The `released` block's force has just reached its limit.
        if isinstance(self.laws[0], Falling):
            return TaylorStep(self, modes, w, e, released)
        return Phase(self, modes, w, e)

    def friction(self, block: int, mode: int) -> Number:
        """Constant kinetic friction on a slipping block."""
        law = self.laws[block]
        assert isinstance(law, Constant)
        return law.mu * self.limits[block] * arb(-mode)

    def distance(self, e: Pair) -> Number:
        """D = X_2 - X_1 from the needed forces."""
        return (e[1] - e[0]) / (2 * self.alpha + 1)


class Phase:
    """Motion with constant modes from a state (w, e): each a wave (docs: proofs, the flow)."""

    def __init__(self, system: System, modes: Modes, w: Pair, e: Pair) -> None:
        self.system, self.modes = system, modes
        both = modes[0] and modes[1]
        self.w, self.e = self._both(w, e) if both else self._one(w, e)
        self.signals = signals(modes, system.limits, self.w, self.e)
        self.reach = arb("inf")

    def _one(self, w: Pair, e: Pair) -> tuple[tuple[Wave, Wave], tuple[Wave, Wave]]:
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

    def _both(self, w: Pair, e: Pair) -> tuple[tuple[Wave, Wave], tuple[Wave, Wave]]:
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
