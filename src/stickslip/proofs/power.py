"""Powers of the event map on a box, by the chain rule from one global stick to the next.

Carried through all events of all steps at once, enclosures would grow like products of matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, ClassVar, Final, Protocol, cast

from flint import arb

from stickslip.proofs.flow import Piece, images
from stickslip.proofs.germ import Germ, germ, like, principal
from stickslip.proofs.jet import Jet, Number, box_of, variables
from stickslip.proofs.system import System, decimal, law_of, number
from stickslip.proofs.taylor import Falling
from stickslip.proofs.verify.cover import WEIGHT

FORKS: Final = 4  # questions that a box may leave open where all answers are followed


class MapSetting(Protocol):
    """A map whose parameters are exact, or coordinates of a box."""

    @property
    def coarse(self) -> float:
        """Radius above which boxes are halved rather than followed along all possibilities."""

    @property
    def shares(self) -> Sequence[int]:
        """Parts of a box to try, in which the second program may tell that an orbit is alone."""

    def boxes(self, n: int) -> list[arb]:
        """Cut the domain into so many intervals, which overlap."""

    def images(
        self, d: Number, parameters: Sequence[Jet], *, forks: int, at_touch: bool
    ) -> list[Piece]:
        """Return the map on a box: one piece for each itinerary, as `flow.images`."""


@dataclass(frozen=True)
class Setting:
    """A system with exact parameters, some of which may vary."""

    values: dict[str, Fraction]
    varied: tuple[str, ...] = ()  # coordinates of the box, behind d; ``mu`` is both blocks'
    coarse: ClassVar[float] = 1e-3

    def names(self, varied: str) -> tuple[str, ...]:
        """Names in `values` that a varied parameter stands for: its own, or both blocks'."""
        return (varied,) if varied in self.values else (f"{varied}_1", f"{varied}_2")

    @property
    def stated(self) -> dict[str, Fraction]:
        """Values of the parameters that do not vary."""
        replaced = {each for name in self.varied for each in self.names(name)}
        return {name: value for name, value in self.values.items() if name not in replaced}

    def system(self, coordinates: Sequence[Jet], kind: Number) -> System:
        """Return the system on a box, its numbers that vary written as `kind`, a jet or a germ."""
        given: dict[str, Any] = {name: number(value) for name, value in self.values.items()}
        for name, coordinate in zip(self.varied, coordinates, strict=True):
            given |= dict.fromkeys(self.names(name), like(kind, coordinate))
        law = law_of(given)
        first, second = (law(*(given[f"{n}_{i}"] for n in law._fields)) for i in (1, 2))
        return System(given["alpha"], given["beta"], given["V"], (first, second))

    @property
    def end(self) -> Fraction:
        """Where the domain ends, if no parameter that moves it varies."""
        return (1 + self.values["beta"]) / (1 + 2 * self.values["alpha"])

    @property
    def shares(self) -> Sequence[int]:
        """Of the box; the second program follows law (9) without the mean value form."""
        return (10**7, 10**8) if law_of(self.values) is Falling else (100, 1000, 10000)

    def boxes(self, n: int) -> list[arb]:
        """Cut the domain; balls round outward, so that nothing lies between neighbours."""
        end = number(self.end)
        return [end * arb(k, 1) / n for k in range(1 - n, n, 2)]

    def images(
        self, d: Number, parameters: Sequence[Jet], *, forks: int, at_touch: bool
    ) -> list[Piece]:
        """Follow the motion."""
        return images(self.system(parameters, d), d, forks=forks, at_touch=at_touch)


@dataclass(frozen=True)
class Region:
    """A system at one value of its parameters, or at every value of the varied one in a span."""

    setting: Any  # a map's; a system's if a parameter varies
    span: tuple[Fraction, ...] = ()  # its two ends

    @property
    def middle(self) -> Fraction:
        """Middle of the span."""
        return sum(self.span, Fraction(0)) / 2

    @property
    def fixed(self) -> MapSetting:
        """The system at the middle of the span."""
        if not self.span:
            return cast(MapSetting, self.setting)
        return Setting(dict.fromkeys(self.setting.values, self.middle) | self.setting.stated)

    def halves(self) -> list[Region]:
        """Cut the span in two."""
        low, high = self.span
        return [replace(self, span=pair) for pair in ((low, self.middle), (self.middle, high))]

    def cut(self, d: arb) -> list[tuple[Region, arb]]:
        """Halve the span or an interval of d, whichever is wider."""
        if self.span and WEIGHT * (self.span[1] - self.span[0]) > 2 * Fraction(float(d.rad())):
            return [(half, d) for half in self.halves()]
        half = d.rad() / 2
        return [(self, d.mid() + sign * half + arb(0, half)) for sign in (-1, 1)]

    def around(self, d: arb) -> tuple[Jet, list[Jet]]:
        """Return d and the varied parameter as coordinates of a box."""
        balls = [d]
        if self.span:
            balls.append(number(self.span[0]).union(number(self.span[1])))
        x, *parameters = box_of(*balls)
        return x, parameters

    def entries(self) -> dict[str, Any]:
        """Describe what varies, for a certificate."""
        if not self.span:
            return {}
        return {"parameter": self.setting.varied[0], "range": [decimal(x) for x in self.span]}


def step(
    setting: MapSetting,
    d: Jet | Germ,
    parameters: Sequence[Jet] = (),
    *,
    forks: int = 0,
    at_touch: bool = False,
) -> list[Piece]:
    """Return f at a point that depends on the coordinates of a box; see `flow.images`.

    Of a germ, for higher derivatives in the first start, the value is a germ.
    """
    first = principal(d)
    middle = (first.centre if first.centre.is_finite() else first.range).mid()
    centres = [middle, *(p.centre for p in parameters)]
    widths = [(x.range - c).abs_upper() for x, c in zip((first, *parameters), centres, strict=True)]
    start, *local = variables(centres, widths)
    kind = start if isinstance(d, Jet) else germ(start, len(d.coefficients) - 1)
    pieces = setting.images(kind, local, forks=forks, at_touch=at_touch)
    return [_composed(piece, d, middle, parameters) for piece in pieces]


def follow(
    setting: MapSetting, x: Any, parameters: Sequence[Jet], period: int
) -> tuple[list[Any], list[str], Any]:
    """Follow an orbit for a period: its points, the itinerary from each, and where it ends."""
    points, words = [], []
    for _ in range(period):
        points.append(x)
        (piece,) = step(setting, x, parameters)
        words.append(piece.itinerary)
        x = piece.value
    return points, words, x


def along(
    setting: MapSetting, x: arb, period: int, *parameters: arb
) -> tuple[list[arb], list[str], arb]:
    """Follow a ball step by step, each from a box of its own: points, itinerary, multiplier."""
    points, words, slope = [], [], arb(1)
    for _ in range(period):
        points.append(x)
        d, *others = box_of(x, *parameters)
        (piece,) = step(setting, d, others)
        words.append(piece.itinerary)
        slope *= piece.value.gradient[0]
        x = piece.value.range
    return points, words, slope


def _composed(piece: Piece, d: Jet | Germ, middle: arb, parameters: Sequence[Jet]) -> Piece:
    """Write a piece in the coordinates of the outer box."""
    start = principal(d)

    def outer(x: Jet | arb) -> Jet:
        if not isinstance(x, Jet):
            return Jet(x, x, tuple(arb(0) for _ in start.box), start.box)
        slope, *rest = x.gradient
        gradient = [slope * g for g in start.gradient]
        for coordinate, by_parameter in zip(parameters, rest, strict=True):
            gradient = [
                g + by_parameter * u for g, u in zip(gradient, coordinate.gradient, strict=True)
            ]
        centre = x.centre + slope * (start.centre - middle)
        return Jet(centre, x.range, tuple(gradient), start.box).tight()

    decisions = tuple(
        replace(each, margin=outer(principal(each.margin))) for each in piece.decisions
    )
    if isinstance(d, Jet):
        return Piece(piece.itinerary, outer(piece.value), decisions)
    coefficients = [outer(c) for c in piece.value.coefficients]
    return Piece(piece.itinerary, d.into(coefficients), decisions)
