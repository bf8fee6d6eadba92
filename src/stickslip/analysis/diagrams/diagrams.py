"""How a bifurcation diagram is made: a survey of the range, its curves evaluated at every value."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial as partial_of
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numpy as np

from stickslip.analysis.attractors.along import TOLD, Motion, Settler
from stickslip.analysis.attractors.attractors import N_STARTS, spread_points
from stickslip.analysis.attractors.attractors import attractors as all_attractors
from stickslip.analysis.bifurcations.bifurcation import attempted
from stickslip.analysis.bifurcations.bifurcations import N_LISTS
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import N_LISTS as N_LISTS_ND
from stickslip.analysis.bifurcations.in_space.bifurcations_nd import OrbitSurvey
from stickslip.analysis.bifurcations.orbit_curves import orbit_curves
from stickslip.analysis.bifurcations.scan.adding_up import concerned_orbits
from stickslip.analysis.bifurcations.scan.nodes import Family, Node
from stickslip.analysis.bifurcations.scan.survey import Survey
from stickslip.analysis.branches.along.breakpoint_lines import BreakpointLine, follow_breakpoints
from stickslip.analysis.diagrams.diagram import AttractorTable, Diagram, OrbitCurve
from stickslip.analysis.diagrams.orbit_curves import SampledOrbit, fill, sampled_orbits
from stickslip.analysis.maps.arguments import checked_range, line_family, map_of, not_for
from stickslip.analysis.maps.protocol import (
    SAME,
    Bools,
    FamilyND,
    Floats,
    Indices,
    MapFamily,
    Modelled,
)
from stickslip.analysis.maps.side_by_side import side_by_side
from stickslip.analysis.scales import FINE
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, flag, shown, whole_number
from stickslip.checks import grid as grid_values
from stickslip.numerics.processes import MOST, in_processes
from stickslip.numerics.waiting import waits
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.side_by_side import Asking

    Filled = list[tuple[Floats, Any]]  # points and multipliers of each orbit at every value


ITERATES: Final = 64
SPREAD: Final = 16  # starting points, besides critical ones, at the values next to these lists
HANDED: Final = 4  # of R^n: starts at each value, beside those handed on
AT_LEAST: Final = 64  # values that an interrupted call is content with


@waits
@suggests
def bifurcation_diagram(
    system: MapFamily | FamilyND | Modelled[MapFamily] | Modelled[FamilyND],
    parameter: str,
    grid: ArrayLike,
    *,
    max_period: int = 4,
    window: tuple[float, float] | None = None,
    iterates: int = ITERATES,
    attractors: bool = True,
    n_lists: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: bool = False,
) -> Diagram:
    """Follow periodic orbits, the attractors and, on a line, the breakpoints over a parameter.

    Parameters
    ----------
    system : model or map with parameters
        Such as a `TwoBlock`, an event map or a `PiecewiseMap`; of R^n a `Chain` or a `Map`.
    parameter : str
        The parameter that varies, as in ``system.parameters``.
    grid : tuple of (float, float, int) or array_like of float, shape (n,)
        ``(lo, hi, n)``, or a list or array of at least two ascending values.
    max_period : int
        Orbits up to this period are followed, stable or not: all of a line, in R^n those found.
    window : tuple of float, optional
        Part of the domain of a map of a line to look at; orbits that leave it end there.
    iterates : int
        Points kept of an attractor that is no cycle.
    attractors : bool
        Whether to look for attractors besides the stable ones among the orbits.
    n_lists : int, optional
        Lists of orbits that are made over the range, besides those next to every bifurcation; two
        orbits born and lost between neighbouring ones stay unseen. 24 by default, complete ones,
        of a line; 12 in R^n.
    progress : callable, optional
        Called with the share of the work that is done, from 0 to 1.
    partial : bool
        Whether Ctrl-C returns what is known by then: at fewer values, or up to the one reached.
        ``unresolved`` says so. While nothing is known Ctrl-C raises as ever.

    Returns
    -------
    Diagram
        Orbits as curves with located ends, attractors and breakpoints; ``.plot()``,
        ``.table()``, ``.save()``, ``.to_xarray()``.

    Raises
    ------
    ValueError
        Neither a model nor a map with parameters; the values do not ascend, `parameter` is not
        one, or a count is too small.

    Notes
    -----
    Every orbit is solved for at every value from where it begins to where it ends, and both
    ends are located. Attractors that are no short cycles are handed on from value to value;
    "chaotic" rests on a finite number of iterates, `attractors` of one map gives proof.

    Examples
    --------
    >>> import stickslip as ss
    >>> diagram = ss.bifurcation_diagram(
    ...     ss.examples.coulomb(), "V", np.linspace(0.0366, 0.0372, 41), n_lists=4
    ... )
    >>> [(curve.period, curve.ends[1].reason) for curve in diagram.orbits][-1]
    (4, 'border_collision')
    """
    family = map_of(system)
    if not (in_space := isinstance(family, FamilyND)):
        family = line_family(family)
    else:
        not_for("a line", window=window is not None)
    values = grid_values("grid", grid).copy()
    if values.size < 2 or (np.diff(values) <= 0).any():
        raise ValueError(
            f"grid = {shown(grid)}: (lo, hi, n) with lo < hi, or at least two numbers "
            "in ascending order are needed."
        )
    checked_range(family, parameter, (values[0], values[-1]), "grid")
    max_period = whole_number("max_period", max_period, 1, at_most=MOST_KEPT)
    iterates = whole_number("iterates", iterates, 1, at_most=MOST_KEPT)
    if n_lists is None:
        n_lists = N_LISTS_ND if in_space else N_LISTS
    n_lists = whole_number("n_lists", n_lists, 2, at_most=MOST_KEPT)
    attractors = flag("attractors", attractors)
    work = Work(progress, partial)
    lo, hi = float(values[0]), float(values[-1])
    survey: Survey | OrbitSurvey
    if in_space:
        survey = OrbitSurvey(family, parameter, lo, hi, max_period, N_STARTS)
        survey.run(n_lists, work.part(0.0, 0.4))
    else:
        survey = Survey(Family(family, parameter, window), lo, hi, max_period, work.part(0.0, 0.4))
        survey.run(n_lists)
        if survey.work.interrupted:
            values = values[values <= max((node.q for node in survey.grid_nodes), default=-np.inf)]
            if values.size < 2:
                raise KeyboardInterrupt
    with work.until_interrupted():
        return diagram_of(survey, values, work, iterates=iterates, attractors=attractors)
    few = values[:: max(1, len(values) // AT_LEAST)]
    found = diagram_of(survey, few, Work(), iterates=iterates, attractors=attractors)
    told = f"interrupted: {len(few)} of {len(values)} values"
    return replace(found, unresolved=(*found.unresolved, told))


def diagram_of(
    survey: Survey | OrbitSurvey,
    values: Floats,
    work: Work,
    *,
    iterates: int = ITERATES,
    attractors: bool = True,
) -> Diagram:
    """Evaluate the curves of a survey at ascending values, and look for attractors there."""
    family: Any = survey if isinstance(survey, OrbitSurvey) else survey.family
    maps = [family.at(q) for q in values]
    breaks: tuple[BreakpointLine, ...] = ()
    if isinstance(survey, OrbitSurvey):
        sampled = sampled_orbits(survey.curves)
    else:
        # All values at which the survey has a complete list.
        nodes = {node.q: node for span in survey.spans for node in (span.left, span.right)}
        anchors = [nodes[q] for q in sorted(nodes)]
        # First what processes do: a list of the same survey may be joining its curves here.
        breaks = follow_breakpoints(maps, values, [(node.q, node.table) for node in anchors])
        spans = enumerate(survey.spans)
        concerned = {k: concerned_orbits(span)[0] for k, span in spans if span.events}
        sampled = sampled_orbits(orbit_curves(survey, concerned))
    work.tell(0.5)
    if isinstance(survey, OrbitSurvey):
        parts: list[Any] = fill(maps, values, sampled)
        if attractors:
            count = work.part(0.6, 1.0).steps(len(values))
            rows = _attractors_in_space(survey, maps, values, count)
        else:
            rows = [_stable_cycles(parts, k) for k in range(len(values))]
    else:
        critical = _critical_points(values, breaks, anchors) if attractors else None
        near_lists = np.searchsorted(values, [node.q for node in anchors])
        chunks = list(_chunks(maps, values, critical, near_lists))
        size = max(1, len(chunks) // MOST)  # fewer parties would leave cores without one
        parties = [chunks[k : k + size] for k in range(0, len(chunks), size)]
        task = partial_of(_on_line, sampled, iterates)
        several = in_processes(task, parties, work.part(0.5, 1.0).tell)
        found = [each for some in several for each in some]
        rows = [row for _, some in found for row in some]
        pieces = zip(*(filled for filled, _ in found), strict=True)
        parts = [tuple(map(np.concatenate, zip(*each, strict=True))) for each in pieces]
    orbits = tuple(
        OrbitCurve(item.period, points, multipliers, ends=(item.ends[0], item.ends[1]))
        for item, (points, multipliers) in zip(sampled, parts, strict=True)
    )
    work.tell(1.0)
    return Diagram(
        parameter=family.name,
        values=values,
        max_period=max([survey.max_period, *(orbit.period for orbit in orbits)]),
        window=getattr(family, "window", None),
        parameters={key: v for key, v in family.f.parameters.items() if key != family.name},
        orbits=orbits,
        attractors=_as_table(rows, iterates, sampled),
        breakpoints=breaks,
        unresolved=(
            *map(str, survey.unresolved),
            *_missing(values, orbits),
        ),
        coverage=getattr(survey, "coverage", None),
    )


# ------------------------------------------------------------------ orbits


# Neighbouring values of a diagram of a line: their maps, the values, critical points of each map
# (None: no attractors are looked for), and where one may be new: next to lists, at the first.
_Chunk: TypeAlias = "tuple[list[Any], Floats, list[Floats] | None, Bools]"


def _chunks(
    maps: list[Any], values: Floats, critical: list[Floats] | None, near_lists: Indices
) -> Iterator[_Chunk]:
    """Cut a diagram into stretches: half as many values each as there are of them."""
    n, looks = len(values), np.zeros(len(values) + 1, dtype=np.bool_)
    looks[near_lists] = True
    edges = np.linspace(0, n, math.isqrt(2 * n) + 1).astype(int)
    looks[edges] = True
    for part in map(slice, *np.array(list(pairwise(edges))).T):
        yield maps[part], values[part], critical and critical[part], looks[part]


def _on_line(
    sampled: Sequence[SampledOrbit], iterates: int, chunks: Sequence[_Chunk]
) -> list[tuple[Filled, list[list[Motion]]]]:
    """Solve for every orbit at every value of some chunks; find the attractors there."""
    filled = [fill(maps, values, sampled) for maps, values, *_ in chunks]
    tasks = [_attractors_on_line(*each, iterates) for each in zip(chunks, filled, strict=True)]
    return list(zip(filled, side_by_side(tasks), strict=True))


def _attractors_on_line(chunk: _Chunk, filled: Filled, iterates: int) -> Asking[list[list[Motion]]]:
    """Gather the stable ones of the orbits at every value, and look for attractors besides."""
    settler, rows, (maps, _, critical, near_lists) = Settler(max(iterates, TOLD)), [], chunk
    for k, f in enumerate(maps):
        rows.append(_stable_cycles(filled, k))
        if critical is not None:
            cycles = [motion.points for motion in rows[-1]]
            spread = spread_points(f, SPREAD, None) if near_lists[k] else np.empty(0)
            rows[-1] += yield from settler.at(f, cycles, critical[k], spread)
    return rows


def _missing(values: Floats, orbits: Sequence[OrbitCurve]) -> tuple[str, ...]:
    """Say which orbits were not found at values where they exist."""
    texts = []
    for orbit in orbits:
        low, high = (end.value for end in orbit.ends)
        slack = FINE * (values[-1] - values[0])  # so close to its end there may be no orbit
        absent = (values > low + slack) & (values < high - slack) & ~orbit.exists
        if absent.any():
            where = ", ".join(f"{value:.12g}" for value in values[absent][:3])
            more = " ..." if absent.sum() > 3 else ""
            texts.append(
                f"an orbit of period {orbit.period} was not found at {absent.sum()} of its "
                f"values: {where}{more}"
            )
    return tuple(texts)


# ------------------------------------------------------------------ attractors


def _critical_points(
    values: Floats, breaks: Sequence[BreakpointLine], anchors: Sequence[Node]
) -> list[Floats]:
    """Gather breaks and, interpolated between anchors, turning points at each value."""
    lines = [line.d for line in breaks]
    for left, right in pairwise(anchors):
        one, other = left.table.turning_points, right.table.turning_points
        inside = (values >= left.q) & (values <= right.q)
        if len(one) != len(other):
            one = other = one if len(one) > len(other) else other
        share = (values - left.q) / (right.q - left.q)
        for a, b in zip(one, other, strict=True):
            lines.append(np.where(inside, a + (b - a) * share, np.nan))
    stacked = np.array(lines).reshape(-1, len(values)).T
    return [np.unique(row[np.isfinite(row)]) for row in stacked]


def _attractors_in_space(
    survey: OrbitSurvey, maps: list[Any], values: Floats, count: Callable[[int], None]
) -> list[list[Any]]:
    """Look for attractors at every value, also where those before and stable orbits are."""
    rows: list[list[Any]] = []
    starts = np.empty((0, survey.f.dimension))
    for q, f in zip(values.tolist(), maps, strict=True):
        spread = survey.starts(q, np.concatenate([starts, f.spread(HANDED)]))
        task: Callable[[], Any] = partial_of(all_attractors, f, starts=spread)
        rows.append(list(attempted(task, "attractors", q, q, survey.unresolved) or ()))
        starts = np.array([a.points[-1] for a in rows[-1]]).reshape(-1, survey.f.dimension)
        count(1)
    return rows


def _stable_cycles(filled: Filled, k: int) -> list[Motion]:
    """Return the stable orbits of one value."""
    found = []
    for points, multipliers in filled:
        multiplier = abs(multipliers[k])
        if multiplier < 1 + SAME:  # at its flip itself an orbit still attracts
            with np.errstate(divide="ignore"):
                exponent = float(np.log(multiplier)) / points.shape[1]
            found.append(Motion("periodic", points[k], exponent))
    return found


def _as_table(
    rows: Sequence[Sequence[Any]], iterates: int, sampled: Sequence[SampledOrbit]
) -> AttractorTable:
    """Arrange motions in rows, with all points of cycles and some of the others."""
    motions = [(k, motion) for k, row in enumerate(rows) for motion in row]
    kept = [
        motion.points if motion.kind == "periodic" else motion.points[-iterates:]
        for _, motion in motions
    ]
    shape = kept[0].shape[1:] if kept else sampled[0].points.shape[2:] if sampled else ()
    points = np.full((len(motions), max(map(len, kept), default=1), *shape), np.nan)
    for line, some in zip(points, kept, strict=True):
        line[: len(some)] = some
    return AttractorTable(
        where=np.array([k for k, _ in motions], dtype=np.intp),
        kind=np.array([motion.kind for _, motion in motions], dtype=np.str_),
        period=np.array([motion.period for _, motion in motions], dtype=np.intp),
        lyapunov=np.array([float(motion.lyapunov) for _, motion in motions], dtype=np.float64),
        points=points,
    )
