"""Periodic orbits of a map followed along a parameter."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stickslip.analysis.orbit_branch import OrbitBranch
    from stickslip.analysis.orbits import PeriodicOrbit
    from stickslip.analysis.protocol import MapFamily

__all__ = ["continue_orbit"]


def continue_orbit(
    orbit: PeriodicOrbit | OrbitBranch,
    f: MapFamily,
    name: str,
    range: tuple[float, float],  # noqa: A002
    *,
    window: tuple[float, float] | None = None,
    max_step: float = 1 / 32,
    max_points: int = 2000,
) -> OrbitBranch:
    """Follow a periodic orbit along a parameter, both ways, through folds."""
    raise NotImplementedError
