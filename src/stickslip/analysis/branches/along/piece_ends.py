"""Where a piece of a map ends, told by its own labels alone.

Beyond the end there may be anything: a branch, a gap, or branches without number that
accumulate there and change with every parameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.along.borders import Border, NearBreak
from stickslip.analysis.branches.breakpoints import kind_of
from stickslip.analysis.branches.limits import Limits, limits_inside
from stickslip.analysis.branches.mesh import Nodes
from stickslip.analysis.maps.protocol import domain_width, sample
from stickslip.status import OK

if TYPE_CHECKING:
    from collections.abc import Collection

    from stickslip.analysis.maps.protocol import Map1D

FAN: Final = 33  # points between which the end is looked for ...
ROUNDS: Final = 12  # ... so often: adjacent floats after ten
ADJACENT: Final = 2  # floats
FAN_OUT: Final = 8.0 ** np.arange(-12, -2)  # of the domain: how far an end may have moved


@dataclass(frozen=True, eq=False)
class PieceEnd:
    """The end of a piece; value and slope of the map are limits from the piece."""

    border: Border
    side: int  # where the piece is: -1 left of its end, 1 right
    value: float
    slope: float

    @property
    def beyond(self) -> int | None:
        """Label on the other side; None where there is no value."""
        return self.border.right_label if self.side < 0 else self.border.left_label


def piece_end(f: Map1D, piece: Collection[int], inside: float, outside: float) -> PieceEnd | None:
    """Find, to adjacent floats, the first end of a piece from a point on it towards one outside.

    None if ``inside`` is not on the piece, or if the piece does not end before ``outside``.
    """
    allowed = np.array(sorted(piece), dtype=np.uint64)
    room = found = None
    for _ in range(ROUNDS):
        x = np.linspace(inside, outside, FAN)
        values = sample(f, x)
        on_piece = (values.status == OK) & np.isin(values.label, allowed)
        if on_piece.all() or not on_piece[0]:
            break
        first = int(np.argmin(on_piece))
        found = Nodes.at(x, values).take(slice(first - 1, first + 1))
        if room is None:
            room = abs(float(x[first - 1]) - inside)
        inside, outside = found.x.tolist()
        if abs(outside - inside) <= ADJACENT * np.spacing(abs(outside)):
            break
    if found is None or room is None:
        return None
    return _described(NearBreak(f), found, room)


def _described(mesh: NearBreak, pair: Nodes, room: float) -> PieceEnd:
    """Take limits from the piece, and compare them with what comes next."""
    last, beyond = pair.take(slice(0, 1)), pair.take(slice(1, 2))
    side = -1 if beyond.x[0] > last.x[0] else 1
    limits = limits_inside(mesh, last, np.array([float(side)]), np.array([room]))
    other = Limits(beyond.value, beyond.slope)
    left, right = (limits, other) if side < 0 else (other, limits)
    (kind,) = kind_of(mesh, left, right, np.abs(beyond.x - last.x))
    labels = int(last.label[0]), (int(beyond.label[0]) if beyond.ok[0] else None)
    left_label, right_label = labels if side < 0 else labels[::-1]
    border = Border(left_label, right_label, float(last.x[0]), kind)
    return PieceEnd(border, side, float(limits.value[0]), float(limits.slope[0]))


def piece_end_near(f: Map1D, piece: Collection[int], x: float, side: int) -> PieceEnd | None:
    """Find the end of a piece close to x; side is -1 for a piece left of its end, else 1."""
    reach = side * domain_width(f) * FAN_OUT
    inside, outside = (np.clip(x + k * reach, *f.domain).tolist() for k in (1, -1))
    for a, b in zip(inside, outside, strict=True):
        found = piece_end(f, piece, a, b)
        if found is not None:
            return found
    return None
