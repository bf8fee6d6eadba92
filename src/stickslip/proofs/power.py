"""Powers of the event map on a box, by the chain rule from one global stick to the next.

One number d joins two steps, so that derivatives of steps multiply. Carried through all events
of all steps at once, their enclosures would grow like products of matrices instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb

from stickslip.proofs.events import Decision
from stickslip.proofs.flow import Piece, images
from stickslip.proofs.jet import Jet, variables
from stickslip.proofs.system import NAMES, System, number

__all__ = ["Image", "Setting", "step"]


@dataclass(frozen=True)
class Setting:
    """A system with exact parameters, some of which may vary.

    Attributes
    ----------
    values : dict of str to Fraction
        By the names of `system.NAMES`.
    varied : tuple of str
        Parameters that are coordinates of the box, behind d. ``mu`` is both blocks'.
    """

    values: dict[str, Fraction]
    varied: tuple[str, ...] = ()

    @property
    def replaced(self) -> frozenset[str]:
        """Names of `values` that the varied parameters stand for."""
        pairs = (("mu_1", "mu_2") if name == "mu" else (name,) for name in self.varied)
        return frozenset(name for pair in pairs for name in pair)

    def system(self, coordinates: Sequence[Jet]) -> System:
        """Return the system on a box, given the coordinates of the varied parameters."""
        given: dict[str, Jet | arb] = {name: number(self.values[name]) for name in NAMES}
        for name, coordinate in zip(self.varied, coordinates, strict=True):
            for each in ("mu_1", "mu_2") if name == "mu" else (name,):
                given[each] = coordinate
        return System(**given)


@dataclass(frozen=True)
class Image:
    """What `flow.Piece` says, in the coordinates of a box.

    Attributes
    ----------
    itinerary : str
    value : Jet
        The next d.
    decisions : tuple of Decision
    """

    itinerary: str
    value: Jet
    decisions: tuple[Decision, ...]

    @property
    def margin(self) -> Jet:
        """Of the one question that stays open."""
        (decision,) = self.decisions
        assert isinstance(decision.margin, Jet)
        return decision.margin


def step(
    setting: Setting,
    d: Jet,
    parameters: Sequence[Jet] = (),
    *,
    forks: int = 0,
    at_touch: bool = False,
) -> list[Image]:
    """Return f at a point that depends on the coordinates of a box; see `flow.images`.

    Parameters
    ----------
    setting : Setting
    d : Jet
    parameters : sequence of Jet
        Coordinates of the varied parameters.
    forks, at_touch
        As in `flow.images`.
    """
    middle = d.centre.mid()
    centres = [middle, *(p.centre for p in parameters)]
    widths = [(x.range - c).abs_upper() for x, c in zip((d, *parameters), centres, strict=True)]
    local = variables(centres, widths)
    pieces = images(setting.system(local[1:]), local[0], forks=forks, at_touch=at_touch)
    return [_composed(piece, d, middle, parameters) for piece in pieces]


def _composed(piece: Piece, d: Jet, middle: arb, parameters: Sequence[Jet]) -> Image:
    """Write a piece in the coordinates of the outer box."""

    def outer(x: Jet | arb) -> Jet:
        if not isinstance(x, Jet):
            return Jet(x, x, tuple(arb(0) for _ in d.box), d.box)
        slope, *rest = x.gradient
        gradient = [slope * g for g in d.gradient]
        for coordinate, by_parameter in zip(parameters, rest, strict=True):
            gradient = [
                g + by_parameter * u for g, u in zip(gradient, coordinate.gradient, strict=True)
            ]
        centre = x.centre + slope * (d.centre - middle)
        return Jet(centre, x.range, tuple(gradient), d.box).tight()

    decisions = tuple(replace(each, margin=outer(each.margin)) for each in piece.decisions)
    return Image(piece.itinerary, outer(piece.value), decisions)
