"""Diagrams of maps of R^n: followed orbits at every value, and what orbits handed on settle on."""

from __future__ import annotations

import functools
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.bifurcations.bifurcation import attempted
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import KINDS
from stickslip.analysis.continuation.curve import CurveEnd
from stickslip.analysis.diagrams.diagram import AttractorTable, Diagram, OrbitCurve
from stickslip.analysis.orbits.newton_nd import solve_orbits
from stickslip.analysis.orbits.orbits_nd import multipliers_of, same_points

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from typing import TypeAlias

    from numpy.typing import NDArray

    from stickslip.analysis.bifurcations.in_space.bifurcations_nd import OrbitSurvey
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.maps.protocol import Floats

    Stretch: TypeAlias = tuple[NDArray[np.intp], CurveEnd, CurveEnd]

SPREAD: Final = 4  # starts at each value, beside those handed on
STRAYED: Final = 1e-2  # of an orbit's size: Newton's method went to another orbit
REASONS: Final = {**KINDS, "end of domain": "outside"}


def diagram_nd(
    survey: OrbitSurvey, values: Floats, iterates: int, report: Callable[[float], None]
) -> Diagram:
    """Evaluate the orbits of a survey at ascending values, and look for attractors there."""
    maps = [survey.at(q) for q in values]
    orbits = [
        _filled(curve, stretch, maps, values)
        for curve in survey.curves
        for stretch in _stretches(curve)
    ]
    report(0.6)
    rows: list[tuple[int, Any]] = []
    starts = np.empty((0, survey.f.dimension))
    for k, f in enumerate(maps if iterates else ()):
        handed = starts[f.contains(starts)]
        spread = np.concatenate([handed, f.spread(SPREAD)])
        task: Callable[[], Any] = functools.partial(attractors, f, starts=spread)
        q = float(values[k])
        found = attempted(task, "attractors", q, q, survey.unresolved) or ()
        rows += [(k, attractor) for attractor in found]
        starts = np.array([a.points[-1] for a in found]).reshape(-1, survey.f.dimension)
        report(0.6 + 0.4 * (k + 1) / len(values))
    known = {key: v for key, v in survey.f.parameters.items() if key != survey.name}
    order = sorted(orbits, key=lambda orbit: (orbit.period, orbit.ends[0].value))
    return Diagram(
        parameter=survey.name,
        values=values,
        max_period=max([survey.max_period, *(orbit.period for orbit in orbits)]),
        window=None,
        parameters=known,
        orbits=tuple(order),
        attractors=_table(rows, iterates, survey.f.dimension),
        breakpoints=(),
        unresolved=tuple(map(str, survey.unresolved)),
    )


def _stretches(curve: Curve) -> Iterator[Stretch]:
    """Cut a curve at its folds into stretches along which the parameter rises or falls."""
    folds = [item for item in curve.bifurcations if item.kind == "fold"]
    cuts = [0, *(item.row for item in folds), len(curve) - 1]
    turns = [CurveEnd("fold", f.parameters, f.points, f.multipliers, f.error) for f in folds]
    first, last = (replace(e, reason=REASONS.get(e.reason, e.reason)) for e in curve.ends)
    ends = [first, *turns, last]
    for (a, b), (start, stop) in zip(pairwise(cuts), pairwise(ends), strict=True):
        if b > a:
            rising = curve.values[a] <= curve.values[b]
            rows = np.arange(a, b + 1)[:: 1 if rising else -1]
            yield (rows, start, stop) if rising else (rows, stop, start)


def _filled(curve: Curve, stretch: Stretch, maps: list[Any], values: Floats) -> OrbitCurve:
    """Solve for the orbit of a stretch at every value on its way."""
    rows, low, high = stretch
    at, path = curve.values[rows], curve.points[rows]
    points = np.full((len(values), *path.shape[1:]), np.nan)
    multipliers = np.full(len(values), np.nan, dtype=np.complex128)
    for k in np.flatnonzero((values >= at[0]) & (values <= at[-1])):
        row = min(int(np.searchsorted(at, values[k], "right")), len(at) - 1)
        gap = at[row] - at[row - 1]
        share = (values[k] - at[row - 1]) / gap if gap > 0.0 else 0.0
        guess = path[row - 1] + share * (path[row] - path[row - 1])
        got = solve_orbits(maps[k], guess[None])
        if got.found[0] and same_points(maps[k], guess, got.points[0], STRAYED):
            points[k], multipliers[k] = got.points[0], multipliers_of(got.jacobians[0])[0]
    return OrbitCurve(path.shape[1], points, multipliers, (low, high))


def _table(rows: list[tuple[int, Any]], iterates: int, dimension: int) -> AttractorTable:
    """Arrange attractors in rows: cycles whole, some points of the others."""
    kept = [a.points if a.kind == "periodic" else a.points[-iterates:] for _, a in rows]
    points = np.full((len(rows), max(map(len, kept), default=1), dimension), np.nan)
    for line, some in zip(points, kept, strict=True):
        line[: len(some)] = some
    return AttractorTable(
        where=np.array([k for k, _ in rows], dtype=np.intp),
        kind=np.array([a.kind for _, a in rows], dtype=np.str_),
        period=np.array([a.period for _, a in rows], dtype=np.intp),
        lyapunov=np.array([a.lyapunov.value for _, a in rows], dtype=np.float64),
        points=points,
    )
