"""What an orbit may meet along a parameter: breaks of the map, and the ends of its domain."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from stickslip.analysis.branches.along.tracked import (
    ConditionLost,
    TrackedDiscontinuity,
    piece_end_near,
)
from stickslip.analysis.maps.protocol import sample
from stickslip.status import OK

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Map1D


class Wall(Protocol):
    """A place of the map that moves with its parameters and that an orbit may meet."""

    side: int  # where the orbit is: -1 left of it, 1 right

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Return its place, and value and slope of the map there on the orbit's side."""


@dataclass
class BorderWall:
    """A break of the map; remembers where it was last."""

    border: TrackedDiscontinuity
    side: int  # the orbit's: -1 left, 1 right
    # labels on the orbit's side, at whose end the break is; empty without labels
    piece: frozenset[int] = frozenset()

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Find the break in a map; `ConditionLost` if it is gone."""
        try:
            found = self.border.at(f, successors=False)
        except ConditionLost:
            end = piece_end_near(f, self.piece, self.border.x, self.side)
            if end is None:
                raise
            self.border = end.border
            return end.border.x, end.value, end.slope
        assert isinstance(found.critical, TrackedDiscontinuity)
        self.border = found.critical
        return found.x, found.value(self.side), found.slope(self.side)


@dataclass
class DomainEnd:
    """An end of the domain or window: the orbit's ``side`` of it is -1 for the upper end."""

    side: int

    def reading(self, f: Map1D) -> tuple[float, float, float]:
        """Evaluate the map at its end."""
        x = f.domain[0 if self.side > 0 else 1]
        values = sample(f, x)
        if values.status != OK:
            raise ConditionLost(f"no value at the end {x:.12g} of the domain")
        return x, float(values.value), float(values.derivative)
