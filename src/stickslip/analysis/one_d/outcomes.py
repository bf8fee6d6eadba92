"""Outcomes of border collisions: predicted from normal forms, and observed.

Types: `stickslip.analysis.outcome`. The derivations are in ``docs/theory/bifurcations.md``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from stickslip.analysis.outcome import Outcome

if TYPE_CHECKING:
    from stickslip.analysis.attractors import Attractor
    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import Map1D

__all__ = ["observed", "predicted_at_corner", "predicted_at_gap", "predicted_at_jump"]


def predicted_at_corner(
    left_slope: float, right_slope: float, direction: int, *, period: int = 1
) -> Outcome:
    """Predict what follows when a corner of f^p crosses the diagonal.

    Parameters
    ----------
    left_slope, right_slope : float
        One-sided slopes of g = f^p at the corner c.
    direction : {1, -1}
        Sign of the change of g(c) - c as the parameter grows.
    period : int
        The p.

    Returns
    -------
    Outcome
    """
    raise NotImplementedError


def predicted_at_jump(
    f: Map1D, interval: tuple[float, float], side: int, direction: int, *, period: int = 1
) -> Outcome:
    """Predict what follows when an orbit of period p meets a jump.

    Parameters
    ----------
    f : Map1D
        The map at the collision.
    interval : tuple of float
        Points on the left and the right branch beside the jump, as close as they come
        (`Breakpoint.interval`).
    side : {-1, 1}
        On which side of the jump the orbit's point lies: -1 left, 1 right.
    direction : {1, -1}
        Sign of the change of f^p(c) - c on that side as the parameter grows.
    period : int
        The p.

    Returns
    -------
    Outcome
    """
    raise NotImplementedError


def predicted_at_gap(slope: float, side: int, direction: int, *, period: int = 1) -> Outcome:
    """Predict what follows when an orbit of period p meets the edge of a gap.

    Parameters as in `predicted_at_jump`; ``slope`` is that of f^p at the edge.
    """
    raise NotImplementedError


def observed(
    orbits_before: Sequence[PeriodicOrbit],
    orbits_after: Sequence[PeriodicOrbit],
    attractors_before: Sequence[Attractor] = (),
    attractors_after: Sequence[Attractor] = (),
    *,
    period: int = 1,
) -> Outcome:
    """Name what happened, from the orbits and attractors that take part on both sides.

    Parameters
    ----------
    orbits_before, orbits_after : sequence of PeriodicOrbit
        Those that end or begin at the bifurcation, at a smaller and a larger parameter.
    attractors_before, attractors_after : sequence of Attractor
        All attractors there; those that are on both sides unchanged are left out of account.
    period : int
        Period of the orbit on the border.

    Returns
    -------
    Outcome
    """
    raise NotImplementedError
