"""Proofs of what was found in floating point: `certify`, `certify_orbits` and `enclose`."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from math import inf
from typing import TYPE_CHECKING, Any, ClassVar, Final, TypeAlias

import numpy as np
from flint import arb

from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.curve import Curve
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.checks import finite_number, shown, whole_number
from stickslip.numerics.waiting import waits
from stickslip.proofs.basins import Basins
from stickslip.proofs.branch import Tube
from stickslip.proofs.certificate import Certificate, certificate, refusal
from stickslip.proofs.complete import Endless, Survey
from stickslip.proofs.expansion import proven_expansion
from stickslip.proofs.formulas import FormulaMap, formula_map_values
from stickslip.proofs.horseshoe import partition, proven_horseshoe, snap_back
from stickslip.proofs.jet import outward, precision
from stickslip.proofs.jump import proven_border, proven_jump
from stickslip.proofs.newton import NoZero
from stickslip.proofs.orbit import MULTIPLIERS, proven_critical, proven_orbit
from stickslip.proofs.power import MapSetting, Region, Setting
from stickslip.proofs.range import MOST_PARTS, Span, hull_of, parts
from stickslip.proofs.system import (
    Constant,
    Exact,
    decimal,
    exact_parameters,
    fraction,
    law_of,
    legal,
)
from stickslip.proofs.verify.words import LONGEST_LISTED, LONGEST_PERIOD
from stickslip.proofs.wave import Undecided
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from stickslip.mechanics.model.two_block import TwoBlock

ExactValues: TypeAlias = Mapping[str, Exact] | None

SPARE_BITS: Final = 80  # beyond the digits asked for: what events near grazing lose
MOST_BITS: Final = 2**20
MOVES_THE_DOMAIN: Final = ("alpha", "beta")
UNKNOWN: Final = (-inf, inf)
PAST_THE_END: Final = 0.01  # of a curve's range, where a breakpoint ends it


@waits
@suggests
def certify(
    found: object,
    model: TwoBlock | PiecewiseMap,
    *,
    digits: int = 30,
    exact: ExactValues = None,
) -> Certificate:
    """Prove what floating point found, or say why it cannot be proven.

    Parameters
    ----------
    found : PeriodicOrbit, Curve, Breakpoint or Bifurcation
        An orbit: that it exists, alone near by, with its points, multiplier and stability. A
        curve of orbits (`follow`): that the orbit exists, alone in a tube, stable or unstable, for
        every value of the parameter between its ends, and is lost at a jump where it ends at one;
        Coulomb friction only. A breakpoint: that the map jumps there, and its values on both sides.
        A border collision: that the orbit reaches a jump at one parameter value and crosses it
        transversally. A fold or flip: that the multiplier is 1 or -1 there, and the coefficients of
        the normal form.
    model : TwoBlock or PiecewiseMap
        Undamped, with Coulomb friction or law (9). Of a map of one's own, whose branches are given
        as formulas, only orbits are proven. Floats are read as the decimals that
        Python prints for them: 1.2 is exactly 12/10, and the statement says so.
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
    >>> orbit = ss.periodic_orbits(model)[0]
    >>> ss.certify(orbit, model).enclosures["points[0]"]
    '-0.0399143134102819047802431175676 +/- 5e-32'
    """
    if not isinstance(found, PeriodicOrbit | Curve | Breakpoint | Bifurcation):
        raise ValueError(
            f"found = {shown(found)} cannot be certified: give a PeriodicOrbit, a Curve of orbits, "
            "a Breakpoint or a Bifurcation"
        )
    if isinstance(model, PiecewiseMap) and not isinstance(found, PeriodicOrbit):
        raise ValueError(
            f"found = {shown(found)} cannot be certified of a PiecewiseMap: only its orbits are "
            "proven, one by one or in complete lists (certify_orbits)."
        )
    if isinstance(found, PeriodicOrbit):
        if found.infinitely_unstable:
            raise ValueError("an infinitely unstable orbit is no orbit of f: certify its jump")
        start = found.points[0]
        return certify_orbit(model, start, found.period, digits=digits, exact=exact)
    assert not isinstance(model, PiecewiseMap)
    if isinstance(found, Curve):
        return _certify_curve(found, model, digits, exact)
    if isinstance(found, Breakpoint):
        return certify_jump(model, found.d, digits=digits, exact=exact)
    if found.kind not in (*MULTIPLIERS, "border_collision"):
        raise ValueError(
            f"a {found.kind} cannot be certified: only a border_collision, a fold or a flip can"
        )
    model = model.replace(**{found.parameter: float(found.value)})
    for d in found.points:
        proof = certify_bifurcation(
            model, found.kind, d, found.period, found.parameter, digits=digits, exact=exact
        )
        if proof:
            break
    return proof


def certify_orbit(
    model: TwoBlock | PiecewiseMap,
    d: float,
    period: int = 1,
    *,
    digits: int = 30,
    exact: ExactValues = None,
) -> Certificate:
    """Prove the periodic orbit through a point near d; see `certify`."""
    values, digits, period = _checked(model, digits, exact, period, own=True)
    near = _near(d, values)

    def prove() -> dict[str, Any]:
        return proven_orbit(_setting(values), near, period, digits)[2]

    return _proof("orbit", prove, values, digits)


def certify_jump(
    model: TwoBlock, d: float, *, digits: int = 30, exact: ExactValues = None
) -> Certificate:
    """Prove the jump of the event map near d; see `certify`."""
    values, digits, _ = _checked(model, digits, exact)
    near = _near(d, values)
    return _proof("jump", lambda: proven_jump(Setting(values), near, digits), values, digits)


def certify_bifurcation(
    model: TwoBlock,
    kind: str,
    d: float,
    period: int,
    parameter: str,
    *,
    digits: int = 30,
    exact: ExactValues = None,
) -> Certificate:
    """Prove what happens to the orbit near d near the model's own value of a parameter.

    `kind` is ``fold``, ``flip`` or ``border_collision``: the point near d reaches a jump.
    """
    values, digits, period = _checked(model, digits, exact, period)
    near = _near(d, values)
    if kind not in (*MULTIPLIERS, "border_collision"):
        raise ValueError(f"kind = {shown(kind)} is not border_collision, fold or flip")
    _varied(model, parameter)
    value = arb(float(model.parameters[parameter]))
    setting = Setting(values, (parameter,))

    def prove() -> dict[str, Any]:
        if kind == "border_collision":
            return proven_border(setting, near, value, period, digits)
        return proven_critical(kind, setting, near, value, period, digits)

    return _proof("border" if kind == "border_collision" else kind, prove, setting.stated, digits)


def certify_branch(
    model: TwoBlock,
    d: float,
    period: int,
    parameter: str,
    range: tuple[Exact, Exact],
    *,
    digits: int = 30,
    exact: ExactValues = None,
) -> Certificate:
    """Prove the orbit through a point near d for every value of a parameter in a range.

    The model's own value is in the range. Where the orbit is lost at a jump on the way, the branch
    is proven up to there, and that it is lost. See `certify`.
    """
    values, digits, period = _checked(model, digits, exact, period)
    near = _near(d, values)
    low, high = _span(model, values, parameter, range)
    setting = Setting(values, (parameter,))
    own = values[setting.names(parameter)[0]]
    if not low <= own <= high or low == high:
        raise ValueError(
            f"range = ({range[0]}, {range[1]}) is not allowed: it must hold the model's own value, "
            f"{parameter} = {float(own):.12g}, near which the orbit is looked for"
        )

    def prove() -> dict[str, Any]:
        return Tube(setting, near, own, (low, high), period, digits).entries()

    return _proof("branch", prove, setting.stated, digits, factors=(1,))


def _certify_curve(found: Curve, model: TwoBlock, digits: int, exact: ExactValues) -> Certificate:
    """Prove a curve of orbits between its ends, and beyond one at a breakpoint."""
    steps = np.diff(found.values)
    if found.kind != "orbit" or found.period is None or not (all(steps > 0) or all(steps < 0)):
        raise ValueError(
            f"a curve ({found.kind}) cannot be certified: only one of periodic orbits of a map, "
            "whose parameter does not turn back"
        )
    spare = PAST_THE_END * float(np.ptp(found.values))
    low, high = (
        end.value + side * spare * (end.reason == "breakpoint")
        for end, side in zip(sorted(found.ends, key=lambda end: end.value), (-1, 1), strict=True)
    )
    row = len(found) // 2
    return certify_branch(
        model.replace(**{found.parameter: float(found.values[row])}),
        found.points[row, 0],
        found.period,
        found.parameter,
        (low, high),
        digits=digits,
        exact=exact,
    )


@waits
@suggests
def certify_orbits(
    model: TwoBlock | PiecewiseMap,
    max_period: int = 1,
    *,
    along: str | None = None,
    range: tuple[Exact, Exact] | None = None,
    digits: int = 30,
    exact: ExactValues = None,
) -> Certificate:
    """Prove the complete list of periodic orbits up to a period on the whole domain.

    Parameters
    ----------
    model, digits, exact
        As for `certify`.
    max_period : int, optional
        Largest minimal period.
    along, range : str and pair of numbers, optional
        Prove it for every value of this parameter (V, mu, mu_1 or mu_2) between two, between
        which no orbit appears or is lost: the list is one of branches. Coulomb friction only.

    Returns
    -------
    Certificate
        Its document lists the orbits and the intervals, if any, that stayed undecided; outside
        these the list is proven to be the list.

    Raises
    ------
    ValueError
        An argument is out of range.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.certify_orbits(ss.examples.coulomb()).proven  # at most three fixed points, and no other
    True

    Of a map of one's own, by formulas:

    >>> f = ss.PiecewiseMap(["0.5 - 2*x", "0.5 - 0.3*x"], (-1, 1), breakpoints=[0.0])
    >>> proof = ss.certify_orbits(f, max_period=2)
    >>> proof.enclosures["orbits[0].points[0]"], len(proof.document["orbits"])
    ('0.384615384615384615384615384615 +/- 5e-31', 1)
    """
    values, digits, max_period = _checked(
        model, digits, exact, max_period, name="max_period", at_most=LONGEST_LISTED, own=True
    )
    region, stated = _region(model, values, along, range)

    def prove() -> dict[str, Any]:
        found = Survey(region, max_period, digits)
        undecided = [[repr(low), repr(high)] for low, high in found.undecided]
        if not along:
            return {"max_period": max_period, "orbits": found.orbits, "undecided": undecided}
        return {**region.entries(), "max_period": max_period, "branches": found.orbits}

    claim, factors = ("curves", (1,)) if along else ("list", (1, 2, 4))
    return _proof(claim, prove, stated, digits, factors)


@waits
@suggests
def certify_basins(
    model: TwoBlock,
    share: float = 0.999,
    *,
    along: str | None = None,
    range: tuple[Exact, Exact] | None = None,
    max_period: int = 8,
    digits: int = 12,
    exact: ExactValues = None,
) -> Certificate:
    """Prove which starts tend to which orbits, for nearly all of the domain.

    Parameters
    ----------
    model, exact
        As for `certify`; Coulomb friction only.
    share : float, optional
        Of the length of the domain, how much is asked for.
    along, range : str and pair of numbers, optional
        Prove it for every value of this parameter (V, mu, mu_1 or mu_2) between two.
    max_period : int, optional
        Longest period of the orbits that are looked for; those that attract are proven.
    digits : int, optional
        Significant digits that are computed with; ends of intervals have 12 decimals.

    Returns
    -------
    Certificate
        Its document holds, for each orbit, an interval in which it attracts all, and cells: each
        is mapped into what comes before it. Not proven if that is less than asked for.

    Raises
    ------
    ValueError
        An argument is out of range.

    Examples
    --------
    >>> import stickslip as ss
    >>> proof = ss.certify_basins(ss.examples.coulomb(), 0.16)  # 0.999 takes 15 s
    >>> [attractor["share"] for attractor in proof.document["attractors"]]
    ['0.159912', '0.003431']
    """
    share = finite_number("share", share, above=0.0, at_most=1.0)
    values, digits, max_period = _checked(model, digits, exact, max_period, name="max_period")
    region, stated = _region(model, values, along, range)
    _of_constant_friction(values, "basins are")
    middle = model.replace(**{along: float(region.middle)}) if along else model
    orbits = [(o.points[0], o.period) for o in periodic_orbits(middle, max_period) if o.stable]

    def prove() -> dict[str, Any]:
        if not orbits:
            raise Undecided(f"no orbit of period up to {max_period} attracts")
        found = Basins(region, orbits, share)
        if found.share < share:
            raise Undecided(f"only {found.share:.6f} of the domain is shown to tend to an orbit")
        return found.entries()

    return _proof("basins", prove, stated, digits, factors=(1,))


@waits
@suggests
def certify_entropy(
    model: TwoBlock | PiecewiseMap,
    at_least: float = 0.0,
    *,
    digits: int = 12,
    exact: ExactValues = None,
) -> Certificate:
    """Prove chaos: intervals that the map takes over one another, and the entropy they force.

    Parameters
    ----------
    model, exact
        As for `certify`; also a map of one's own by formulas. Under law (9) tiny intervals along an
        orbit that leaves an unstable fixed point and returns force some entropy, far from all.
    at_least : float, optional
        The entropy that is asked for, in natural units: log 2 of a map that doubles.
    digits : int, optional
        Significant digits that are computed with.

    Returns
    -------
    Certificate
        Its document holds the entropy and the intervals. Not proven if it is less than asked for.

    Raises
    ------
    ValueError
        An argument is out of range.

    Notes
    -----
    The entropy counts the orbits that can be told apart, those of a transient too: positive
    entropy does not say that an attractor is chaotic.

    Examples
    --------
    >>> import stickslip as ss
    >>> tent = ss.PiecewiseMap(["1.7*x", "1.7*(1 - x)"], (0, 1), breakpoints=[0.5])
    >>> ss.certify_entropy(tent, at_least=0.53).document["entropy"]  # log(1.7) = 0.530628
    '0.530458'
    """
    at_least = finite_number("at_least", at_least, at_least=0.0)
    values, digits, _ = _checked(model, digits, exact, own=True)
    f = model if isinstance(model, PiecewiseMap) else model.as_map()
    wide = "branches" in values or law_of(values) is Constant  # intervals can be enclosed

    def prove() -> dict[str, Any]:
        intervals = partition(f) if wide else snap_back(f)
        entries = proven_horseshoe(_setting(values), intervals)
        if float(entries["entropy"]) < at_least:
            raise Undecided(f"only an entropy of {entries['entropy']} is shown")
        return entries

    return _proof("horseshoe", prove, values, digits, factors=(1,))


@waits
@suggests
def certify_chaos(
    model: TwoBlock,
    d: float,
    at_least: float = 0.0,
    *,
    digits: int = 12,
    exact: ExactValues = None,
) -> Certificate:
    """Prove that the orbit of a start stays where all orbits expand: a chaotic attractor.

    Intervals are taken into themselves, and derivatives of f^n grow at least like exp(h n) there.
    So no orbit in them attracts, however long its period, and there is an invariant density
    (docs: proofs, expansion).

    Parameters
    ----------
    model, exact
        As for `certify`; Coulomb friction only.
    d : float
        A start that goes to the attractor.
    at_least : float, optional
        The rate h that is to be proven, at least. The Lyapunov exponent is larger, for h is that of
        the slowest orbit.
    digits : int, optional
        Significant digits that are computed with.

    Returns
    -------
    Certificate
        Its document holds the exponent h, and the intervals with weights: a metric in which every
        step expands. Not proven if f' vanishes somewhere in them, as where the attractor has folds.

    Raises
    ------
    ValueError
        An argument is out of range.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.TwoBlock(alpha=3.1, beta=1.26, V=0.065, friction=ss.Coulomb(mu=0.061))
    >>> ss.certify_chaos(model, 0.27).document["exponent"]
    '0.086076'
    """
    at_least = finite_number("at_least", at_least, at_least=0.0)
    values, digits, _ = _checked(model, digits, exact)
    _of_constant_friction(values, "expansions are")
    start = float(_near(d, values))

    def prove() -> dict[str, Any]:
        entries = proven_expansion(Setting(values), model.as_map(), start)
        if float(entries["exponent"]) < at_least:
            raise Undecided(f"only an exponent of {entries['exponent']} is shown")
        return entries

    return _proof("expansion", prove, values, digits, factors=(1,))


@dataclass(frozen=True, eq=False, repr=False)
class Enclosure(Result):
    """What f does on a box of d and parameters.

    Attributes
    ----------
    itineraries : tuple of str
        All that are possible in the box; none if it is too wide to tell.
    value, derivative : tuple of float
        Lowest and highest of f, and of f' where there is one, on the box, rounded outward; infinite
        if nothing is known.
    parameter_derivatives : dict of str to tuple of float
        The same for the parameters that vary in the box.
    reason : str
        Why there is not one itinerary; empty if there is.
    """

    itineraries: tuple[str, ...]
    value: tuple[float, float]
    derivative: tuple[float, float]
    parameter_derivatives: dict[str, tuple[float, float]]
    reason: str = ""
    _plot: ClassVar = "columns.draw_enclosure"
    _has_picture: ClassVar = False

    @property
    def proven(self) -> bool:
        """Whether every motion of the box is proven to have the one itinerary."""
        return len(self.itineraries) == 1

    @property
    def itinerary(self) -> str:
        """The one itinerary; empty if it is not proven."""
        return self.itineraries[0] if self.proven else ""

    def _columns(self) -> dict[str, Any]:
        derivatives = {f"df/d({name})": pair for name, pair in self.parameter_derivatives.items()}
        bounds = {"f": self.value, "df/d(d)": self.derivative, **derivatives}
        return {
            "quantity": list(bounds),
            "low": np.array([low for low, _ in bounds.values()]),
            "high": np.array([high for _, high in bounds.values()]),
        }

    def __repr__(self) -> str:
        """Itinerary, or why there is not one; then the bounds."""
        words = " or ".join(self.itineraries) or "unknown"
        told = f"itinerary {words}" + (f": {self.reason}" if self.reason else "")
        return f"Enclosure: {told}\n{self.table()!r}"


def enclose(
    model: TwoBlock,
    d: Exact | tuple[Exact, Exact],
    *,
    bits: int = 128,
    exact: ExactValues = None,
    **parameters: tuple[Exact, Exact],
) -> Enclosure:
    """Enclose f, f' and df/dp on an interval of d and intervals of parameters.

    The box is cut into parts until what encloses f is at most twice as wide as what f is proven to
    take, or until 2000 parts are of no help, after ten seconds or so (docs: proofs, ranges). Under
    law (9), where only tiny boxes can be enclosed, it is taken whole.

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
        Of a box with breakpoints in it several itineraries: `reason` says which event is open.

    Raises
    ------
    ValueError
        An argument is out of range.

    Examples
    --------
    >>> import stickslip as ss
    >>> box = ss.enclose(ss.examples.coulomb(), ("0.27", "0.2701"), V=("0.0366", "0.03661"))
    >>> box.itinerary
    '.- -- +- +. ..'
    >>> jump = ss.enclose(ss.examples.coulomb(), ("0.2791", "0.2792"))
    >>> jump.itineraries, jump.reason
    (('.- -- +- +. ..', '.- -- -. +. ..'), 'block 2 may graze the belt velocity')
    """
    values = exact_parameters(model, exact)
    if unknown := sorted(set(parameters) - {*model.parameters, *values}):
        raise ValueError(f"{unknown[0]!r} is no parameter that can vary in a proof")
    with precision(whole_number("bits", bits, 2, at_most=MOST_BITS)):
        ends = {"d": d if isinstance(d, tuple) else (d, d), **parameters}
        box = [_interval(name, pair) for name, pair in ends.items()]
        for name, pair in zip(parameters, box[1:], strict=True):
            for end in pair:
                legal(name, end)
        setting = Setting(values, tuple(parameters))
        _inside(box, setting)
        found = parts(setting, box, most=MOST_PARTS if law_of(values) is Constant else 1)
        reason = next((part.reason for part in found if part.reason), "")
        pieces = [piece for part in found for piece in part.pieces]
        words = () if any(not part.pieces for part in found) else {p.itinerary for p in pieces}
        gradient = [
            hull_of([outward(piece.value.gradient[k]) for piece in pieces]) if words else UNKNOWN
            for k in range(len(box))
        ]
        return Enclosure(
            tuple(sorted(words, key=lambda word: (len(word), word))),
            hull_of([part.outer for part in found]),
            gradient[0],
            dict(zip(parameters, gradient[1:], strict=True)),
            reason,
        )


def _interval(name: str, ends: Any) -> Span:
    if not isinstance(ends, tuple) or len(ends) != 2:
        raise ValueError(f"{name} = {shown(ends)} is not allowed: {name} must be a pair (lo, hi).")
    low, high = (fraction(name, end) for end in ends)
    if low > high:
        raise ValueError(f"{name} = ({ends[0]}, {ends[1]}): the lower end comes first")
    return low, high


def _inside(box: list[Span], setting: Setting) -> None:
    given = {name: (value, value) for name, value in setting.values.items()}
    given |= dict(zip(setting.varied, box[1:], strict=True))
    end = (1 + given["beta"][0]) / (1 + 2 * given["alpha"][1])
    for d in box[0]:
        if abs(d) > end:
            value = float(d) if abs(d) <= sys.float_info.max else int(d)
            raise ValueError(f"d = {shown(value)} is outside the domain |d| <= {float(end):.12g}")


def _near(d: float, values: dict[str, Any]) -> arb:
    """Return where an orbit is looked for; ValueError outside the domain of a model."""
    d = finite_number("d", d)
    if "branches" not in values:
        _inside([_interval("d", (d, d))], Setting(values))
    return arb(d)


def _setting(values: dict[str, Any]) -> MapSetting:
    return FormulaMap(values) if "branches" in values else Setting(values)


def _checked(
    model: TwoBlock | PiecewiseMap,
    digits: int,
    exact: ExactValues,
    period: int = 1,
    *,
    name: str = "period",
    at_most: int = LONGEST_PERIOD,
    own: bool = False,
) -> tuple[dict[str, Any], int, int]:
    """Return the exact parameters, the digits and the period; `own` maps where those are proven."""
    period = whole_number(name, period, at_most=at_most)
    digits = whole_number("digits", digits, 5, at_most=1000)
    if own and isinstance(model, PiecewiseMap):
        return formula_map_values(model, exact), digits, period
    return exact_parameters(model, exact), digits, period


def _span(
    model: TwoBlock,
    values: dict[str, Fraction],
    parameter: str,
    range: tuple[Exact, Exact],
) -> tuple[Fraction, Fraction]:
    """Return the ends of a parameter's interval; each must be a legal value."""
    _varied(model, parameter)
    _of_constant_friction(values, "branches are")
    low, high = (fraction("range", end) for end in range)
    for end in (low, high):
        legal(parameter, end)
    return low, high


def _region(
    model: TwoBlock | PiecewiseMap,
    values: dict[str, Any],
    along: str | None,
    range: tuple[Exact, Exact] | None,
) -> tuple[Region, dict[str, Any]]:
    """Return where something is proven, and the parameters that are the same everywhere there."""
    if (along is None) != (range is None):
        raise ValueError("along and range go together: along='V', range=(0.0366, 0.0372)")
    if along is None or range is None:
        return Region(_setting(values)), values
    if isinstance(model, PiecewiseMap):
        raise ValueError("along: a map of one's own is certified at one value of its parameters")
    if along in MOVES_THE_DOMAIN:
        raise ValueError(f"along = {along!r} is not allowed: as it varies, the domain does, too")
    low, high = _span(model, values, along, range)
    if not low < high:
        raise ValueError(f"range = ({range[0]}, {range[1]}): the lower end comes first")
    setting = Setting(values, (along,))
    return Region(setting, (low, high)), setting.stated


def _of_constant_friction(values: dict[str, Fraction], what: str) -> None:
    if law_of(values) is not Constant:
        raise ValueError(f"{what} proven with Coulomb friction alone; certify orbits of law (9)")


def _varied(model: TwoBlock, parameter: str) -> None:
    if parameter not in model.parameters:
        known = ", ".join(model.parameters)
        raise ValueError(f"parameter = {shown(parameter)} is not one of the model's: {known}")


def _proof(
    claim: str,
    prove: Callable[[], dict[str, Any]],
    values: dict[str, Any],
    digits: int,
    factors: tuple[int, ...] = (1, 2, 4),
) -> Certificate:
    """Run a proof with enough bits; more of them if they turn out too few."""
    numbers = {n: decimal(value) for n, value in values.items() if isinstance(value, Fraction)}
    system = {**values, **numbers}
    reason: Exception = Undecided("")
    for factor in factors:
        with precision(factor * (int(digits * 7) + SPARE_BITS)):
            try:
                return certificate(claim, system, digits, prove())
            except (NoZero, Endless) as error:
                return refusal(error, digits)
            except (Undecided, ValueError) as error:
                reason = error
    return refusal(reason, digits)
