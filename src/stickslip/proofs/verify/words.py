"""What a certificate may say: typed theorems, the numbers in them, and the statement they make.

What only the certifier knows, the `mechanism` of a jump, is no part of the statement.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from fractions import Fraction
from math import floor, log10
from typing import Annotated, Any, ClassVar, Final, Literal, TypeAlias

import msgspec
from flint import arb, fmpq
from msgspec import Meta, Struct

SCHEMA: Final = "stickslip-certificate-2"
LONGEST_PERIOD: Final = 1000  # of an orbit
LONGEST_LISTED: Final = 32  # of a complete list, whose work grows like a power of the period
LONGEST_REASON: Final = 500
MOST_CELLS: Final = 100_000
MOST_INTERVALS: Final = 2000  # of a horseshoe
HEAVIEST: Final = 10**18  # weight of one

# Numbers are short, so that no text can ask for endless work. (\Z: $ also stands before "\n".)
Exact = Annotated[str, Meta(pattern=r"^\d{1,1100}([./]\d{1,1100})?\Z")]
Decimal = Annotated[str, Meta(pattern=r"^-?\d{1,1100}\.\d{1,1100} \+/- 5e-\d{1,4}\Z")]
Radius = Annotated[str, Meta(pattern=r"^[1-9]e-\d{2,3}\Z")]
Place = Annotated[str, Meta(pattern=r"^-?\d{1,9}(\.\d{1,1100})?\Z")]
End = Annotated[str, Meta(pattern=r"^-?\d{1,9}\.\d{1,20}(e-\d{2,3})?\Z")]
Name = Annotated[str, Meta(pattern=r"^[A-Za-z]{1,5}(_[12])?\Z")]
Word = Annotated[str, Meta(pattern=r"^([-.+]{2}( [-.+]{2}){1,5000}|[0-9]{1,2})\Z")]  # or a branch
Formula = Annotated[str, Meta(pattern=r"^[-+*/().A-Za-z0-9_ ]{1,1000}\Z")]
Label = Annotated[str, Meta(pattern=r"^[A-Za-z_][A-Za-z0-9_]{0,99}\Z")]
Signed = Annotated[str, Meta(pattern=r"^-?[0-9]{1,1100}([./][0-9]{1,1100})?\Z")]
Remark = Annotated[str, Meta(pattern=r"^[ -~]{1,200}\Z")]
Span = tuple[Exact, Exact]
Period = Annotated[int, Meta(ge=1, le=LONGEST_PERIOD)]
Several = Meta(max_length=10_000)
Side = Literal["above", "below"]


class Refused(ValueError):
    """The certificate does not hold; the message, safe to print, says what was found."""

    def __init__(self, reason: str) -> None:
        plain = "".join(c if " " <= c <= "~" else ascii(c)[1:-1] for c in reason[:LONGEST_REASON])
        super().__init__(plain + "..." * (len(reason) > LONGEST_REASON))


class _Theorem(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True, tag_field="claim"):
    """What is claimed of a system."""


class _OfPeriod(_Theorem, frozen=True, kw_only=True):
    """About one periodic orbit."""

    period: Period
    points: Annotated[list[Decimal], Several]
    itinerary: Annotated[list[Word], Several]

    def __post_init__(self) -> None:
        """Refuse a point too many or too few."""
        if not len(self.points) == len(self.itinerary) == self.period:
            raise ValueError(
                f"{len(self.points)} points and {len(self.itinerary)} itineraries are given for "
                f"period {self.period}"
            )

    def orbit(self) -> str:
        """Name the orbit; the itinerary is that of a round from its first point."""
        return (
            f"periodic orbit of minimal period {self.period} with the itinerary "
            f"{' | '.join(self.itinerary)}"
        )


class Orbit(_OfPeriod, tag="orbit", frozen=True, kw_only=True):
    """A periodic orbit."""

    multiplier: Decimal
    stable: bool
    alone: Radius

    def words(self, of: str = "event map", x: str = "d") -> str:
        """Return the theorem, of a map of points that are named so."""
        kind = "asymptotically stable" if self.stable else "unstable"
        basin = f", and all starts within {self.alone} of it tend to the orbit"
        return (
            f"The {of} has a {self.orbit()} through {x} = {self.points[0]}. Within {self.alone} "
            "of this point there is no other periodic point of that period. The multiplier is "
            f"{self.multiplier}: the orbit is {kind}{basin if self.stable else ''}."
        )


class Jump(_Theorem, tag="jump", frozen=True, kw_only=True):
    """A discontinuity of the map."""

    d: Decimal
    left: Decimal
    right: Decimal
    itinerary_left: Word
    itinerary_right: Word
    mechanism: Remark

    def words(self) -> str:
        """Return the theorem."""
        return (
            f"The event map jumps at d = {self.d}: it is discontinuous between two points that "
            f"agree with this one in all digits given. At the left one the itinerary is "
            f"{self.itinerary_left!r} and f = {self.left}; at the right one it is "
            f"{self.itinerary_right!r} and f = {self.right}."
        )


class Varied(_OfPeriod, frozen=True, kw_only=True):
    """What becomes of an orbit as a parameter varies."""

    parameter: Name
    value: Decimal


class Border(Varied, tag="border", frozen=True, kw_only=True):
    """An orbit that is lost at a jump."""

    itinerary_beyond: Word
    exists: Side
    mechanism: Remark

    @property
    def reach(self) -> str:
        """How far from the stated point the theorem speaks: ten units of its last digit."""
        return f"1e-{int(self.points[0].rpartition('-')[2]) - 2}"

    def words(self) -> str:
        """Return the theorem."""
        side = {"above": "larger", "below": "smaller"}[self.exists]
        near = f"within {self.reach} of this point"
        return (
            f"As {self.parameter} varies, the {self.orbit()} through d = {self.points[0]} is lost "
            f"at a jump of the event map, at {self.parameter} = {self.value}: of two values that "
            f"agree with this one in all digits given, the orbit exists at the {side} one, and at "
            f"the other one no periodic orbit with this itinerary has a point {near}. At both the "
            f"event map is discontinuous {near}: its itinerary changes there between "
            f"{self.itinerary[0]!r} and {self.itinerary_beyond!r}."
        )


class Branch(_Theorem, tag="branch", frozen=True, kw_only=True):
    """An orbit over an interval of a parameter, up to where it is lost if that is known."""

    parameter: Name
    period: Period
    itinerary: Annotated[list[Word], Several]
    stable: bool
    nodes: Annotated[list[tuple[Exact, Place]], Several]  # of a polygon: the parameter and d
    radii: Annotated[list[Radius], Several]  # of the tube around it, between two nodes
    lost: Annotated[list[Border], Meta(max_length=2)]

    def __post_init__(self) -> None:
        """Refuse what no branch is."""
        if len(self.itinerary) != self.period:
            raise ValueError(f"{len(self.itinerary)} itineraries are given for {self.period}")
        if not len(self.nodes) == len(self.radii) + 1 > 1:
            raise ValueError(f"{len(self.nodes)} nodes and {len(self.radii)} radii are given")
        values = [fraction(value) for value, _ in self.nodes]
        if any(a >= b for a, b in itertools.pairwise(values)):
            raise ValueError("the nodes are not in the order of the parameter")
        if len({border.exists for border in self.lost}) < len(self.lost):
            raise ValueError("the orbit is lost twice on one side")
        if any((b.parameter, b.period) != (self.parameter, self.period) for b in self.lost):
            raise ValueError("another orbit is lost, or by another parameter")

    def words(self) -> str:
        """Return the theorem."""
        kind = "asymptotically stable" if self.stable else "unstable"
        (low, start), (high, end) = self.nodes[0], self.nodes[-1]
        told = (
            f"For every {self.parameter} from {low} to {high} the event map has a periodic orbit "
            f"of minimal period {self.period} with the itinerary {' | '.join(self.itinerary)}, "
            f"which is {kind}. One of its points depends continuously on {self.parameter}, from "
            f"d = {start} to d = {end}, both to within the radii there: between two successive "
            f"ones of the {len(self.nodes)} nodes this point lies within the radius given of the "
            "straight line through them, and no other periodic point of period "
            f"{self.period} does."
        )
        for border in self.lost:
            side = {"above": "lower", "below": "upper"}[border.exists]
            told += (
                f" The {side} end agrees with a value at which this orbit is lost, in all digits "
                f"given of that value. {border.words()}"
            )
        return told


class _Critical(Varied, frozen=True, kw_only=True):
    """An orbit at the end of its stability."""

    def at(self, multiplier: int) -> str:
        """Begin the theorem."""
        return (
            f"As {self.parameter} varies, the {self.orbit()} has the multiplier {multiplier} at "
            f"{self.parameter} = {self.value}, with the point d = {self.points[0]}"
        )


class Fold(_Critical, tag="fold", frozen=True, kw_only=True):
    """Two orbits that meet."""

    curvature: Decimal
    exists: Side

    def words(self) -> str:
        """Return the theorem."""
        return (
            f"{self.at(1)}, where the second derivative of that power of the map is "
            f"{self.curvature}. It is a fold: near that value and that point two such orbits exist "
            f"{self.exists} it, which meet there, and none on the other side."
        )


class Flip(_Critical, tag="flip", frozen=True, kw_only=True):
    """A multiplier that passes -1."""

    rate: Decimal
    cubic: Decimal
    stable: Side
    doubled: Side

    def words(self) -> str:
        """Return the theorem."""
        kind, side = (
            ("a stable", "super") if self.stable != self.doubled else ("an unstable", "sub")
        )
        return (
            f"{self.at(-1)}. It passes -1; its derivative in {self.parameter} is {self.rate} at a "
            f"value that agrees with this one in all digits given, and the cubic coefficient of "
            f"the normal form is {self.cubic}: a {side}critical flip. Near that value the orbit is "
            f"asymptotically stable {self.stable} it and unstable on the other side, and {kind} "
            f"orbit of twice the period exists {self.doubled} it."
        )


class List(_Theorem, tag="list", frozen=True, kw_only=True):
    """All orbits up to a period."""

    max_period: Annotated[int, Meta(ge=1, le=LONGEST_LISTED)]
    orbits: Annotated[list[Orbit], Several]
    undecided: Annotated[list[tuple[End, End]], Several]

    def __post_init__(self) -> None:
        """Refuse what no list is."""
        if any(orbit.period > self.max_period for orbit in self.orbits):
            raise ValueError(f"an orbit has a period above max_period = {self.max_period}")
        if any(Fraction(low) > Fraction(high) for low, high in self.undecided):
            raise ValueError("of an undecided interval the lower end comes first")

    def words(self, of: str = "event map", x: str = "d") -> str:
        """Return the theorem, of a map of points that are named so."""
        several = "orbit" if len(self.orbits) == 1 else "orbits"
        count = f"{len(self.orbits)} periodic {several} of period up to {self.max_period}"
        places = "; ".join(f"period {o.period}, {x} = {o.points[0]}" for o in self.orbits)
        listed = f"{count} ({places})" if places else count
        if not self.undecided:
            return f"On its whole domain the {of} has exactly {listed}."
        intervals = ", ".join(f"[{low}, {high}]" for low, high in self.undecided)
        return (
            f"The {of} has at least {listed}. All points of others lie in the undecided "
            f"intervals {intervals}."
        )


class Curves(_Theorem, tag="curves", frozen=True, kw_only=True):
    """All orbits up to a period, for every value of a parameter between two."""

    parameter: Name
    range: Span
    max_period: Annotated[int, Meta(ge=1, le=LONGEST_LISTED)]
    branches: Annotated[list[Branch], Several]

    def __post_init__(self) -> None:
        """Refuse what no complete list is."""
        in_order(self.range)
        for branch in self.branches:
            ends = branch.nodes[0][0], branch.nodes[-1][0]
            if branch.parameter != self.parameter or tuple(map(fraction, ends)) != tuple(
                map(fraction, self.range)
            ):
                raise ValueError("a branch is of another parameter or of another range")
            if branch.lost or branch.period > self.max_period:
                raise ValueError("a branch is lost, or of a period above max_period")

    def words(self) -> str:
        """Return the theorem."""
        several = "orbit" if len(self.branches) == 1 else "orbits"
        told = (
            f"For every {self.parameter} from {self.range[0]} to {self.range[1]} the event map "
            f"has, on its whole domain, exactly {len(self.branches)} periodic {several} of period "
            f"up to {self.max_period}."
        )
        return " ".join([told, *(branch.words() for branch in self.branches)])


class Attractor(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An interval in which one orbit attracts all."""

    period: Period
    itinerary: Annotated[list[Word], Several]
    interval: tuple[Place, Place]
    share: Place

    def __post_init__(self) -> None:
        """Refuse what no interval is."""
        if len(self.itinerary) != self.period:
            raise ValueError(f"{len(self.itinerary)} itineraries are given for {self.period}")
        in_order(self.interval)


class Basins(_Theorem, tag="basins", frozen=True, kw_only=True):
    """Starts that tend to orbits, at one value of the parameters or all between two of one."""

    parameter: Name | None = None
    range: Span | None = None
    attractors: Annotated[list[Attractor], Meta(min_length=1, max_length=100)]
    cells: Annotated[list[tuple[Place, Place, int]], Meta(max_length=MOST_CELLS)]

    def __post_init__(self) -> None:
        """Refuse what no basins are."""
        if (self.parameter is None) != (self.range is None):
            raise ValueError("a parameter and its range go together")
        if self.range:
            in_order(self.range)
        for low, high, k in self.cells:
            in_order((low, high))
            if not 0 <= k < len(self.attractors):
                raise ValueError(f"a cell belongs to attractor {k}, which there is not")

    def words(self) -> str:
        """Return the theorem."""
        when = "The event map"
        if self.range:
            low, high = self.range
            when = f"For every {self.parameter} from {low} to {high} the event map"
        several = "orbit" if len(self.attractors) == 1 else "orbits"
        places = "; ".join(
            f"[{', '.join(a.interval)}] (minimal period {a.period}, itinerary "
            f"{' | '.join(a.itinerary)})"
            for a in self.attractors
        )
        shares = ", ".join(a.share for a in self.attractors)
        return (
            f"{when} has {len(self.attractors)} asymptotically stable periodic {several}, each "
            f"with one point in an interval all of whose starts tend to it: {places}. All starts "
            f"in the {len(self.cells)} cells tend to the orbit of their number, too. With their "
            f"intervals these are at least {shares} of the length of the domain."
        )


Weighted = tuple[Place, Place, Annotated[int, Meta(ge=1, le=HEAVIEST)]]  # ends and a weight


class Horseshoe(_Theorem, tag="horseshoe", frozen=True, kw_only=True):
    """Intervals that the map takes over one another."""

    entropy: Place
    intervals: Annotated[list[Weighted], Meta(min_length=1, max_length=MOST_INTERVALS)]

    def __post_init__(self) -> None:
        """Refuse what no horseshoe is."""
        if not fraction(self.entropy) > 0:
            raise ValueError("the entropy is not positive")

    def words(self, of: str = "event map", x: str = "d") -> str:
        """Return the theorem, of a map of points that are named so."""
        (low, *_), (_, high, _) = self.intervals[0], self.intervals[-1]
        return (
            f"The {of} f is continuous on each of {len(self.intervals)} disjoint closed intervals "
            f"from {x} = {low} to {high}. Say that one of them covers another if this lies between "
            "the values of f at its ends. Along each sequence of intervals, of which each covers "
            "the next, there is an orbit; along each that closes after n steps there is one with "
            "f^n(x) = x. The number of such sequences of n steps is at least c exp(h n) with "
            f"c > 0 and h = {self.entropy}, and so is that of orbits told apart after n steps: the "
            f"topological entropy of f is at least {self.entropy}."
        )


class Expansion(_Theorem, tag="expansion", frozen=True, kw_only=True):
    """Intervals that the map takes into themselves, and in which it expands."""

    exponent: Place
    intervals: Annotated[list[Weighted], Meta(min_length=1, max_length=MOST_CELLS)]

    def __post_init__(self) -> None:
        """Refuse what does not expand."""
        if not fraction(self.exponent) > 0:
            raise ValueError("the exponent is not positive")

    def words(self) -> str:
        """Return the theorem."""
        (low, *_), (_, high, _) = self.intervals[0], self.intervals[-1]
        h = self.exponent
        return (
            f"The event map f takes the union J of {len(self.intervals)} closed intervals from "
            f"d = {low} to {high} into itself. There is a c > 0 such that |(f^n)'| is at least "
            f"c exp({h} n) for every n, wherever f^n is differentiable in J: every periodic orbit "
            "in J along which f is differentiable is unstable, and no Lyapunov exponent of an "
            f"orbit in J is less than {h}."
        )


Theorem: TypeAlias = (
    Orbit | Jump | Border | Fold | Flip | List | Branch | Curves | Basins | Horseshoe | Expansion
)


class _Certificate(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A theorem and what it is about."""

    schema: Literal["stickslip-certificate-2"]
    digits: Annotated[int, Meta(ge=5, le=1000)]  # significant, of the decimals


class Certificate(_Certificate, frozen=True, kw_only=True):
    """A theorem about two blocks."""

    system: Annotated[dict[Name, Exact], Meta(max_length=9)]  # one that varies is missing
    theorem: Theorem

    @property
    def remark(self) -> str:
        """What nothing here proves: the certifier's word for how a jump comes about."""
        told = self.theorem.lost if isinstance(self.theorem, Branch) else [self.theorem]
        return "; ".join(filter(None, (getattr(each, "mechanism", "") for each in told)))

    def statement(self) -> str:
        """Say it in words: made from the data, so that the two cannot differ."""
        system = ", ".join(f"{name} = {value}" for name, value in self.system.items())
        falling = {"gamma_1", "delta_1"} & set(self.system)
        law = "friction law (9)" if falling else "Coulomb friction"
        return f"Two blocks with {law}, {system} (exact numbers). {self.theorem.words()}"


class Formulas(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A map of an interval by formulas of x, one for each branch from left to right."""

    branches: Annotated[list[Formula], Meta(min_length=1, max_length=100)]
    breakpoints: Annotated[list[Formula], Meta(max_length=99)]  # the right branch holds there
    domain: tuple[Signed, Signed]
    parameters: Annotated[dict[Label, Signed], Meta(max_length=100)]

    def __post_init__(self) -> None:
        """Refuse branches too many or too few."""
        if len(self.branches) != len(self.breakpoints) + 1:
            raise ValueError(
                f"{len(self.branches)} branches and {len(self.breakpoints)} breakpoints are given"
            )

    def words(self) -> str:
        """Name the map."""
        low, high = self.domain
        ends = [f" for x < {end}" for end in self.breakpoints]
        ends += [f" for x >= {end}" for end in self.breakpoints[-1:]] or [""]
        formula = ", ".join(f"{f}{end}" for f, end in zip(self.branches, ends, strict=True))
        values = "".join(f", {name} = {value}" for name, value in self.parameters.items())
        return f"The map f of [{low}, {high}] with f(x) = {formula}{values} (exact numbers)."


class CertificateOfFormulas(_Certificate, frozen=True, kw_only=True):
    """A theorem about a map by formulas: the itinerary numbers its branches from 0."""

    system: Formulas
    theorem: Orbit | List | Horseshoe
    remark: ClassVar = ""

    def statement(self) -> str:
        """Say it in words: made from the data, so that the two cannot differ."""
        return f"{self.system.words()} {self.theorem.words('map', 'x')}"


def read(document: Any) -> Certificate | CertificateOfFormulas:
    """Read the entries of a certificate, its statement aside; `Refused` names a wrong one."""
    if not isinstance(document, dict) or document.get("schema") != SCHEMA:
        raise Refused(f"not a certificate of the schema {SCHEMA}")
    head = {name: document[name] for name in ("schema", "system", "digits") if name in document}
    theorem = {name: x for name, x in document.items() if name not in {*head, "statement"}}
    system = document.get("system")
    by_formulas = isinstance(system, dict) and "branches" in system
    entries = {**head, "theorem": theorem}
    try:
        if by_formulas:
            return msgspec.convert(entries, CertificateOfFormulas)
        return msgspec.convert(entries, Certificate)
    except msgspec.ValidationError as error:
        raise Refused(f"an entry is not of its form: {error}") from None


def in_order(ends: tuple[str, str]) -> None:
    """Refuse two ends of which the lower does not come first."""
    if not fraction(ends[0]) < fraction(ends[1]):
        raise ValueError(f"of {ends[0]} and {ends[1]} the lower end comes first")


def fraction(text: str) -> Fraction:
    """Read a number exactly."""
    try:
        return Fraction(text)
    except (ValueError, ZeroDivisionError):
        raise Refused(f"{text!r} is not a number") from None


def enclosed(x: Fraction) -> arb:
    """Enclose an exact number at the precision at hand."""
    return arb(fmpq(x.numerator, x.denominator))


def middle_of(x: arb) -> Fraction:
    """Return the middle of a ball, exactly."""
    mantissa, exponent = x.mid().man_exp()
    return int(mantissa) * Fraction(2) ** int(exponent)


def halved(box: arb) -> list[arb]:
    """Cut an interval in two."""
    half = box.rad() / 2
    return [box.mid() + sign * half + arb(0, half) for sign in (-1, 1)]


def check_apart(balls: list[arb], otherwise: str) -> None:
    """Refuse balls of which two may hold the same number."""
    ordered = sorted(balls, key=arb.mid)  # if two overlap, so do two neighbours
    if any(a.overlaps(b) for a, b in itertools.pairwise(ordered)):
        raise Refused(otherwise)


def followed(system: Any, x: arb, words: Sequence[str | None]) -> tuple[list[arb], arb, arb]:
    """Follow a ball along an itinerary, None for any: its points, its end, the derivative there."""
    points, slope = [], arb(1)
    for word in words:
        points.append(x)
        told, x, rate = system.step(x)
        slope *= rate
        if word not in (told, None):
            raise Refused(f"the itinerary is stated as {word!r} and is {told!r}")
    return points, x, slope


def ball(text: str) -> arb:
    """Read ``decimal``, ``p/q`` or ``decimal +/- radius`` exactly."""
    middle, _, radius = text.partition(" +/- ")
    exact, width = fraction(middle), fraction(radius or "0")
    ends = [enclosed(x) for x in (exact - width, exact + width)]
    return ends[0].union(ends[1]) if width else ends[0]


def rounded(x: arb, digits: int) -> str:
    """Write a ball as ``decimal +/- radius``, the radius half a unit of the last digit."""
    # Up to three more digits where the last could not be told: so a number has one form only.
    middle, radius = middle_of(x), middle_of(x.rad())
    size = floor(log10(abs(middle))) if abs(middle) > radius else 0
    several = range(max(digits - 1 - size, 1), digits + 4 - size)
    # The second try is for those near half a unit at each of these places, as 6/11 is.
    for share, places in itertools.product((Fraction(45, 100), Fraction(49, 100)), several):
        unit = Fraction(10) ** -places
        nearest = round(middle / unit)
        if abs(middle - nearest * unit) + radius <= unit * share:
            text = str(abs(nearest)).rjust(places + 1, "0")
            sign = "-" if nearest < 0 else ""
            return f"{sign}{text[:-places]}.{text[-places:]} +/- 5e-{places + 1}"
    raise ValueError(f"{x} has fewer than {digits} digits")
