"""Breakpoints: where the branches of a map end, and how."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

import numpy as np

from stickslip.analysis.branches.limits import limits_inside

if TYPE_CHECKING:
    from stickslip.analysis.branches.discontinuities import Cuts
    from stickslip.analysis.branches.limits import Limits
    from stickslip.analysis.branches.mesh import Mesh, Prober
    from stickslip.analysis.maps.protocol import Floats

Kind: TypeAlias = Literal["jump", "corner", "smooth", "edge"]

JUMP: Final = 1e-10  # of the range of values: smaller steps are rounding, beside a tie of events
BEND: Final = 1e-6  # of the slopes: smaller changes are beyond what limits can tell


@dataclass(frozen=True)
class Breakpoint:
    """End of a branch.

    Attributes
    ----------
    d : float
        Where; the label changes between adjacent floats, of which this is one.
    left, right : float
        One-sided values of the map, NaN beside a gap.
    left_slope, right_slope : float
        One-sided slopes; an infinite one shows a square root.
    kind : str
        ``jump``; ``corner`` (continuous, slopes differ); ``smooth`` (value and slope agree:
        the label changes and the map does not care); ``edge`` (no value on one side).
    mechanism : str
        What happens there, for who knows what the map stands for; empty here.
    block : int or None
        Block that the mechanism concerns.
    left_label, right_label : int
        Labels of the two branches; 0 beside a gap.
    interval : tuple of float
        Points on either side, adjacent floats unless several changes fell within the
        resolution.
    quality : str
        ``located``, or ``bracketed`` where the interval is wider than rounding.
    system : map or None
        The map that it is a breakpoint of; None if it was loaded without.
    """

    d: float
    left: float
    right: float
    left_slope: float
    right_slope: float
    kind: Kind
    mechanism: str = ""
    block: int | None = None
    left_label: int = field(default=0, repr=False)
    right_label: int = field(default=0, repr=False)
    interval: tuple[float, float] = field(default=(math.nan, math.nan), repr=False)
    quality: str = field(default="located", repr=False)
    system: Any = field(default=None, repr=False, compare=False)

    @property
    def residual(self) -> float:
        """Width of `interval`."""
        return self.interval[1] - self.interval[0]

    @property
    def jump(self) -> float:
        """Step of the value from left to right."""
        return self.right - self.left


def limits_at_cuts(mesh: Mesh, cuts: Cuts) -> tuple[Limits, Limits]:
    """Return the limits at both ends of every segment between cuts, shapes (n_cuts + 1,)."""
    starts, ends = cuts.starts, cuts.ends
    room = ends.x - starts.x
    ones = np.ones(len(room))
    return limits_inside(mesh, starts, ones, room), limits_inside(mesh, ends, -ones, room)


def kind_of(mesh: Prober, left: Limits, right: Limits, width: Floats) -> list[Kind]:
    """Classify breaks by their limits from both sides, which are ``width`` apart."""
    with np.errstate(all="ignore"):
        steepness = np.abs(left.slope) + np.abs(right.slope)
        slack = np.where(np.isfinite(steepness), steepness * width, 0.0)
        edge = np.isnan(left.value) | np.isnan(right.value)
        jump = np.abs(left.value - right.value) > JUMP * mesh.value_scale + slack
        bend = np.abs(left.slope - right.slope) > BEND * (mesh.slope_scale + steepness)
    bend |= ~(np.isfinite(left.slope) & np.isfinite(right.slope))
    names: list[Kind] = []
    for is_edge, is_jump, is_bend in zip(edge, jump, bend, strict=True):
        names.append(
            "edge" if is_edge else "jump" if is_jump else "corner" if is_bend else "smooth"
        )
    return names
