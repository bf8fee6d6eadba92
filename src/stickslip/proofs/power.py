"""Powers of the event map on a box, by the chain rule from one global stick to the next.

Carried through all events of all steps at once, enclosures would grow like products of matrices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from flint import arb

from stickslip.proofs.flow import Piece, images
from stickslip.proofs.germ import Germ, germ, like, principal
from stickslip.proofs.jet import Jet, Number, variables
from stickslip.proofs.system import System, law_of, number


@dataclass(frozen=True)
class Setting:
    """A system with exact parameters, some of which may vary."""

    values: dict[str, Fraction]
    varied: tuple[str, ...] = ()  # coordinates of the box, behind d; ``mu`` is both blocks'

    def names(self, varied: str) -> tuple[str, ...]:
        """Names in `values` that a varied parameter stands for: its own, or both blocks'."""
        return (varied,) if varied in self.values else (f"{varied}_1", f"{varied}_2")

    @property
    def replaced(self) -> frozenset[str]:
        """Names of `values` that the varied parameters stand for."""
        return frozenset(each for name in self.varied for each in self.names(name))

    def system(self, coordinates: Sequence[Jet], kind: Number) -> System:
        """Return the system on a box, its numbers that vary written as `kind`, a jet or a germ."""
        given: dict[str, Any] = {name: number(value) for name, value in self.values.items()}
        for name, coordinate in zip(self.varied, coordinates, strict=True):
            given |= dict.fromkeys(self.names(name), like(kind, coordinate))
        law = law_of(given)
        first, second = (law(*(given[f"{n}_{i}"] for n in law._fields)) for i in (1, 2))
        return System(given["alpha"], given["beta"], given["V"], (first, second))


def step(
    setting: Setting,
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
    middle = first.centre.mid()
    centres = [middle, *(p.centre for p in parameters)]
    widths = [(x.range - c).abs_upper() for x, c in zip((first, *parameters), centres, strict=True)]
    start, *local = variables(centres, widths)
    kind = start if isinstance(d, Jet) else germ(start, len(d.coefficients) - 1)
    pieces = images(setting.system(local, kind), kind, forks=forks, at_touch=at_touch)
    return [_composed(piece, d, middle, parameters) for piece in pieces]


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
