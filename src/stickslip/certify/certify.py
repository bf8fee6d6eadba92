"""Proofs of what was found in floating point: `certify`, `certify_orbits` and `enclose`."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, Final

from flint import arb

from stickslip.analysis.bifurcation import Bifurcation
from stickslip.analysis.one_d.breakpoints import Breakpoint
from stickslip.analysis.orbits import PeriodicOrbit
from stickslip.certify.border import proven_border
from stickslip.certify.certificate import Certificate, certificate, refusal
from stickslip.certify.complete import survey
from stickslip.certify.jet import precision, variables
from stickslip.certify.jump import proven_jump
from stickslip.certify.newton import NoZero
from stickslip.certify.orbit import proven_orbit
from stickslip.certify.power import Setting, step
from stickslip.certify.system import Exact, exact_parameters, fraction, number
from stickslip.certify.wave import Undecided

if TYPE_CHECKING:
    from stickslip.mechanics.model.two_block import TwoBlock

__all__ = ["Enclosure", "certify", "certify_orbits", "enclose"]

SPARE_BITS: Final = 80  # beyond the digits asked for: what events near grazing lose


def certify(
    found: PeriodicOrbit | Breakpoint | Bifurcation,
    model: TwoBlock,
    *,
    digits: int = 30,
    exact: Mapping[str, Exact] | None = None,
) -> Certificate:
    """Prove what floating point found, or say why it cannot be proven.

    Parameters
    ----------
    found : PeriodicOrbit, Breakpoint or Bifurcation
        An orbit: that it exists, alone near by, with its points, multiplier and stability. A
        breakpoint: that the map jumps there, and its values on both sides. A border collision:
        that the orbit reaches a jump at one parameter value and crosses it transversally.
    model : TwoBlock
        Undamped, with Coulomb friction. Its floats are read as the decimals that Python prints
        for them: 1.2 is exactly 12/10, and the statement says so.
    digits : int, optional
        Significant digits of the enclosures.
    exact : mapping of str to str, int, Fraction or Decimal, optional
        Values that replace parameters of the model, as ``{"alpha": "1.2"}``; a `Fraction` of a
        float gives its binary value.

    Returns
    -------
    Certificate
        Its `proven` says whether; a claim that does not hold is an answer, not an error.

    Raises
    ------
    ValueError
        The model, `digits` or `found` is of a kind that cannot be certified.

    Notes
    -----
    Sets flint's global precision while it runs: one proof at a time in a process.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.examples.coulomb()
    >>> proof = ss.certify(ss.periodic_orbits(model)[0], model)  # doctest: +SKIP
    >>> proof.enclosures["points[0]"]  # doctest: +SKIP
    '-0.0399143134102819047802431175676 +/- 5e-32'
    """
    values = _checked(model, digits, exact)
    if isinstance(found, Bifurcation):
        if found.kind != "border_collision":
            raise ValueError(f"a {found.kind} cannot be certified: only a border_collision")
        varied = found.parameter
        if varied not in model.parameters or varied not in ("mu", *values):
            raise ValueError(f"{varied!r} is no parameter of the model that can vary in a proof")
        values_ = values
        starts = [arb(float(x)) for x in found.points]

        def prove() -> dict[str, Any]:
            setting = Setting(values_, (varied,))
            return _first_of(
                lambda x: proven_border(setting, x, arb(found.value), found.period, digits), starts
            )

        return _proof("border", prove, _shown(values, varied), digits)
    setting = Setting(values)
    if isinstance(found, Breakpoint):
        return _proof(
            "jump", lambda: proven_jump(setting, arb(found.d), digits)[1], _shown(values), digits
        )
    if isinstance(found, PeriodicOrbit):
        if found.infinitely_unstable:
            raise ValueError(
                "an infinitely unstable orbit is no orbit of the map: certify its jump"
            )
        near = arb(float(found.points[0]))
        return _proof(
            "orbit",
            lambda: proven_orbit(setting, near, found.period, digits)[2],
            _shown(values),
            digits,
        )
    raise ValueError(
        f"{type(found).__name__} cannot be certified: give a PeriodicOrbit, a Breakpoint or a "
        "Bifurcation"
    )


def certify_orbits(
    model: TwoBlock,
    max_period: int = 1,
    *,
    digits: int = 30,
    exact: Mapping[str, Exact] | None = None,
) -> Certificate:
    """Prove the complete list of periodic orbits up to a period on the whole domain.

    Parameters
    ----------
    model, digits, exact
        As for `certify`.
    max_period : int, optional
        Largest minimal period.

    Returns
    -------
    Certificate
        Its document lists the orbits and the intervals, if any, that stayed undecided; outside
        these the list is proven to be the list.

    Raises
    ------
    ValueError
        An argument is out of range.
    """
    values = _checked(model, digits, exact)
    if max_period < 1:
        raise ValueError(f"max_period = {max_period} is not allowed: it must be at least 1")

    def prove() -> dict[str, Any]:
        found = survey(Setting(values), max_period, digits)
        undecided = [[repr(low), repr(high)] for low, high in found.undecided]
        return {"max_period": max_period, "orbits": found.orbits, "undecided": undecided}

    return _proof("list", prove, _shown(values), digits)


@dataclass(frozen=True)
class Enclosure:
    """What f does on a box of d and parameters.

    Attributes
    ----------
    proven : bool
        Whether every motion of the box is proven to have the one itinerary.
    itinerary : str
        Empty if not.
    value, derivative : tuple of float
        Lowest and highest of f and f' on the box, rounded outward; NaN if not proven.
    parameter_derivatives : dict of str to tuple of float
        The same for the parameters that vary in the box.
    reason : str
        Why nothing is proven; empty if it is.
    """

    proven: bool
    itinerary: str
    value: tuple[float, float]
    derivative: tuple[float, float]
    parameter_derivatives: dict[str, tuple[float, float]]
    reason: str = ""


def enclose(
    model: TwoBlock,
    d: Exact | tuple[Exact, Exact],
    *,
    bits: int = 128,
    exact: Mapping[str, Exact] | None = None,
    **parameters: tuple[Exact, Exact],
) -> Enclosure:
    """Enclose f, f' and df/dp on an interval of d and intervals of parameters.

    Parameters
    ----------
    model, exact
        As for `certify`.
    d : number or pair of numbers
        A point, or the lowest and highest, inside the domain.
    bits : int, optional
        Precision.
    **parameters : pair of numbers
        Intervals of parameters by name.

    Returns
    -------
    Enclosure
        Not proven if the box is too wide, or holds a breakpoint: `reason` says which event.

    Raises
    ------
    ValueError
        An argument is out of range.
    """
    values = exact_parameters(model, exact)
    if unknown := sorted(set(parameters) - {"mu", *values}):
        raise ValueError(f"{unknown[0]!r} is no parameter that can vary in a proof")
    with precision(bits):
        ends = [d if isinstance(d, tuple) else (d, d), *parameters.values()]
        box = [_interval(name, *pair) for name, pair in zip(("d", *parameters), ends, strict=True)]
        x, *coordinates = variables([m for m, _ in box], [r for _, r in box])
        setting = Setting(values, tuple(parameters))
        _inside(x.range, setting, [c.range for c in coordinates])
        try:
            (piece,) = step(setting, x, coordinates)
        except Undecided as error:
            nothing = (float("nan"), float("nan"))
            return Enclosure(False, "", nothing, nothing, {}, str(error))
        value = piece.value
        return Enclosure(
            True,
            piece.itinerary,
            _outward(value.range),
            _outward(value.gradient[0]),
            dict(zip(parameters, map(_outward, value.gradient[1:]), strict=True)),
        )


def _interval(name: str, low: Exact, high: Exact) -> tuple[arb, arb]:
    a, b = fraction(name, low), fraction(name, high)
    if a > b:
        raise ValueError(f"{name} = ({low}, {high}): the lower end comes first")
    middle = number((a + b) / 2)
    return middle.mid(), (number((b - a) / 2) + middle.rad()).upper()


def _inside(d: arb, setting: Setting, coordinates: list[arb]) -> None:
    given = {name: number(value) for name, value in setting.values.items()}
    given |= dict(zip(setting.varied, coordinates, strict=True))
    end = (1 + given["beta"]) / (1 + 2 * given["alpha"])
    if abs(d) > end:
        raise ValueError(f"d = {d} is outside the domain |d| <= {end.str(12, radius=False)}")


def _outward(x: arb) -> tuple[float, float]:
    """Return ends as floats, rounded outward."""
    from math import inf, nextafter

    return nextafter(float(x.lower()), -inf), nextafter(float(x.upper()), inf)


def _checked(
    model: TwoBlock, digits: int, exact: Mapping[str, Exact] | None
) -> dict[str, Fraction]:
    if not 5 <= digits <= 1000:
        raise ValueError(f"digits = {digits} is not allowed: 5 <= digits <= 1000")
    return exact_parameters(model, exact)


def _shown(values: dict[str, Fraction], varied: str = "") -> dict[str, str]:
    """Write exact numbers as decimals where they are, else as fractions."""
    return {name: _decimal(value) for name, value in values.items()}


def _decimal(value: Fraction) -> str:
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


def _first_of(prove: Callable[[arb], dict[str, Any]], starts: list[arb]) -> dict[str, Any]:
    """Return the first proof that succeeds: the border may be at any point of the orbit."""
    reasons: list[Exception] = []
    for start in starts:
        try:
            return prove(start)
        except (Undecided, NoZero) as error:
            reasons.append(error)
    raise Undecided("; ".join(dict.fromkeys(map(str, reasons))))


def _proof(
    claim: str, prove: Callable[[], dict[str, Any]], system: dict[str, str], digits: int
) -> Certificate:
    """Run a proof with enough bits; more of them if they turn out too few."""
    reason: Exception = Undecided("")
    for factor in (1, 2, 4):
        with precision(factor * (int(digits * 7) + SPARE_BITS)):
            try:
                return certificate(claim, system, digits, prove())
            except NoZero as error:
                return refusal(error, digits)
            except (Undecided, ValueError) as error:
                reason = error
    return refusal(reason, digits)
