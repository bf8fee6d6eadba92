"""Bifurcation diagrams of models."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stickslip.analysis.diagrams.diagrams import bifurcation_diagram as _bifurcation_diagram
from stickslip.study.bifurcations import as_family

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike

    from stickslip.analysis.diagrams.diagram import Diagram


def bifurcation_diagram(
    system: Any,
    name: str,
    values: ArrayLike,
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    iterates: int = 64,
    attractors: bool = True,
    lists: int = 24,
    progress: Callable[[float], None] | None = None,
) -> Diagram:
    """Follow all periodic orbits, the attractors and the breakpoints over a parameter.

    Parameters
    ----------
    system : model or map with parameters
        Such as a `TwoBlock`, an event map or a `PiecewiseMap`.
    name : str
        The parameter that varies, as in ``system.parameters``.
    values : tuple of (float, float, int) or array_like of float, shape (n,)
        A grid ``(lo, hi, n)``, or a list or array of at least two ascending values.
    max_period : int
        All orbits up to this period are followed, stable or not.
    window : tuple of float, optional
        Part of the map's domain to look at; orbits that leave it have left.
    iterates : int
        Points kept of an attractor that is no cycle.
    attractors : bool
        Whether to look for attractors besides the stable ones among the orbits.
    lists : int
        Complete lists of orbits that are made over the range, besides those next to every
        bifurcation; two orbits born and lost between neighbouring ones stay unseen.
    progress : callable, optional
        Called with the share of the work that is done, from 0 to 1.

    Returns
    -------
    Diagram
        Orbits as curves with located ends, attractors and breakpoints; ``.plot()``,
        ``.table()``, ``.save()``, ``.to_xarray()``.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; the values do not ascend, `name` is not a
        parameter, or a count is too small.

    Notes
    -----
    Every orbit is solved for at every value from where it begins to where it ends, and both
    ends are located. Attractors that are no short cycles are handed on from value to value;
    "chaotic" rests on a finite number of iterates, `attractors` of one map gives proof.

    Examples
    --------
    >>> import stickslip as ss
    >>> diagram = bifurcation_diagram(
    ...     ss.examples.coulomb(), "V", np.linspace(0.0366, 0.0372, 41), lists=4
    ... )
    >>> [(curve.period, curve.ends[1].reason) for curve in diagram.orbits][-1]
    (4, 'border_collision')
    """
    return _bifurcation_diagram(
        as_family(system),
        name,
        values,
        max_period=max_period,
        window=window,
        iterates=iterates,
        attractors=attractors,
        lists=lists,
        progress=progress,
    )
