"""Bifurcation diagrams of models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from stickslip.analysis.diagram import bifurcation_diagram as _bifurcation_diagram
from stickslip.study.maps import as_map

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from stickslip.analysis.diagram import Diagram
    from stickslip.analysis.protocol import MapFamily

__all__ = ["bifurcation_diagram"]


def bifurcation_diagram(
    system: Any,
    name: str,
    values: ArrayLike,
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    iterates: int = 64,
    attractors: bool = True,
    progress: Callable[[float], None] | None = None,
) -> Diagram:
    """Follow all periodic orbits, attractors and breakpoints of a system over a parameter."""
    return _bifurcation_diagram(
        cast("MapFamily", as_map(system)),
        name,
        values,
        max_period=max_period,
        window=window,
        iterates=iterates,
        attractors=attractors,
        progress=progress,
    )
