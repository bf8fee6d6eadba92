"""Laps from a refined mesh: smooth stretches between breaks, cut at their turning points."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.branches.laps import HI, LO, Cells, Laps
from stickslip.numerics.slope_zeros import slope_zeros

if TYPE_CHECKING:
    from stickslip.analysis.branches.laps import Indices
    from stickslip.analysis.branches.limits import Limits
    from stickslip.analysis.branches.mesh import Mesh, Nodes
    from stickslip.analysis.maps.protocol import Floats

GUARD: Final = 1 / 64  # of the resolution: closer to a break the map is continued linearly


@dataclass(frozen=True)
class Segments:
    """What lies between neighbouring breaks; arrays of shape (n,), breaks (n - 1,)."""

    first: Nodes
    last: Nodes
    at_first: Limits
    at_last: Limits
    where: Floats  # of the breaks
    smooth: np.ndarray  # breaks that the map does not care about


@dataclass(frozen=True)
class Stretch:
    """Nodes of a smooth piece of a map, from break to break; arrays of shape (n,)."""

    x: Floats
    value: Floats
    slope: Floats
    turns: Indices  # nodes that are turning points
    numbers: tuple[int, int]  # what the stretch ends at, left and right (see `Laps`)
    guards: tuple[float, float]  # between them the map itself may be evaluated
    first_turn: int = 0  # number of turning points left of the stretch


def smooth_stretches(mesh: Mesh, segments: Segments) -> list[Stretch]:
    """Gather the nodes between breaks that matter, with a node at every turning point."""
    n = len(segments.first)
    stretches: list[Stretch] = []
    group: list[int] = []
    for i in range(n):
        if segments.first.ok[i]:
            group.append(i)
        if group and (i == n - 1 or not segments.smooth[i]):
            stretches.append(_stretch(mesh, segments, group))
            group = []
    return _with_turning_points(mesh, stretches)


def _stretch(mesh: Mesh, segments: Segments, group: list[int]) -> Stretch:
    parts = [_nodes_of(mesh, segments, i) for i in group]
    # At a break inside, both one-sided nodes agree: keep the left one.
    x, value, slope = (
        np.concatenate([parts[0][k], *(part[k][1:] for part in parts[1:])]) for k in range(3)
    )
    first, last = group[0], group[-1]
    is_lo, is_hi = first == 0, last == len(segments.first) - 1
    guard = GUARD * mesh.resolution
    at_left = 0.0 if is_lo or np.isinf(slope[0]) else guard
    at_right = 0.0 if is_hi or np.isinf(slope[-1]) else guard
    return Stretch(
        x,
        value,
        slope,
        np.zeros(0, dtype=np.intp),
        (LO if is_lo else first - 1, HI if is_hi else last),
        (
            max(float(segments.first.x[first]), float(x[0]) + at_left),
            min(float(segments.last.x[last]), float(x[-1]) - at_right),
        ),
    )


def _nodes_of(mesh: Mesh, segments: Segments, i: int) -> tuple[Floats, Floats, Floats]:
    """Nodes of one segment: limits at its ends, and the mesh in between."""
    lo, hi = float(segments.first.x[i]), float(segments.last.x[i])
    margin = min(0.5 * mesh.resolution, 0.25 * (hi - lo))
    nodes = mesh.nodes
    inner = nodes.take((nodes.x > lo + margin) & (nodes.x < hi - margin) & nodes.ok)
    start = segments.where[i - 1] if i > 0 else lo
    stop = segments.where[i] if i < len(segments.where) else hi
    return (
        np.concatenate([[start], inner.x, [stop]]),
        np.concatenate([[segments.at_first.value[i]], inner.value, [segments.at_last.value[i]]]),
        np.concatenate([[segments.at_first.slope[i]], inner.slope, [segments.at_last.slope[i]]]),
    )


def _with_turning_points(mesh: Mesh, stretches: list[Stretch]) -> list[Stretch]:
    """Add a node of slope 0 wherever the slope changes its sign."""
    brackets = [_sign_changes(stretch) for stretch in stretches]
    found = [
        (s.x[cells], s.x[cells + 1], s.slope[cells], s.slope[cells + 1])
        for s, cells in zip(stretches, brackets, strict=True)
    ]
    if not found:
        return stretches
    columns = np.stack([np.concatenate(column) for column in zip(*found, strict=True)])
    nodes = mesh.probe(slope_zeros(lambda x: mesh.probe(x).slope, columns[:2], columns[2:]))
    result, done = [], 0
    for stretch, cells in zip(stretches, brackets, strict=True):
        mine = slice(done, done + len(cells))
        result.append(
            replace(
                stretch,
                x=np.insert(stretch.x, cells + 1, nodes.x[mine]),
                value=np.insert(stretch.value, cells + 1, nodes.value[mine]),
                slope=np.insert(stretch.slope, cells + 1, 0.0),
                turns=cells + 1 + np.arange(len(cells)),
                first_turn=done,
            )
        )
        done += len(cells)
    return result


def _signs(stretch: Stretch) -> Floats:
    """Sign of the slope at each node; a zero takes the sign of the node before it."""
    sign = np.sign(stretch.slope)
    known = np.flatnonzero(sign != 0)
    if not known.size:
        return sign
    place = np.searchsorted(known, np.arange(len(sign)), side="right") - 1
    return sign[known[np.maximum(place, 0)]]


def _sign_changes(stretch: Stretch) -> Indices:
    """Cells whose slope changes its sign from one end to the other."""
    sign = _signs(stretch)
    return np.flatnonzero(sign[1:] * sign[:-1] < 0)


def split_at_smooth(stretches: list[Stretch], segments: Segments) -> list[Stretch]:
    """Return the stretches cut at the breaks that the map does not care about, too."""
    numbers = np.flatnonzero(segments.smooth)
    result: list[Stretch] = []
    for stretch in stretches:
        rest = stretch
        for number in numbers:
            if rest.x[0] < segments.where[number] < rest.x[-1]:
                head, rest = _split(rest, float(segments.where[number]), int(number))
                result.append(head)
        result.append(rest)
    return result


def _split(stretch: Stretch, x: float, number: int) -> tuple[Stretch, Stretch]:
    """Cut a stretch at its node x; the map may be evaluated across."""
    at = int(np.searchsorted(stretch.x, x))
    before = stretch.turns < at
    return (
        Stretch(
            stretch.x[: at + 1],
            stretch.value[: at + 1],
            stretch.slope[: at + 1],
            stretch.turns[before],
            (stretch.numbers[0], number),
            (stretch.guards[0], x),
            stretch.first_turn,
        ),
        Stretch(
            stretch.x[at:],
            stretch.value[at:],
            stretch.slope[at:],
            stretch.turns[~before] - at,
            (number, stretch.numbers[1]),
            (x, stretch.guards[1]),
            stretch.first_turn + int(before.sum()),
        ),
    )


def tabulate_laps(mesh: Mesh, stretches: list[Stretch], n_breaks: int) -> Laps:
    """Cut smooth stretches at their turning points, numbered on from the breaks, into laps."""
    rows: list[tuple[float, ...]] = []
    cells: list[tuple[Floats, ...]] = []
    for stretch in stretches:
        _cut(stretch, n_breaks + stretch.first_turn, rows, cells)
    columns = np.array(rows, dtype=np.float64).reshape(len(rows), 11).T
    sizes = [len(cell[0]) for cell in cells]
    flat = [np.concatenate([cell[k] for cell in cells] or [np.empty(0)]) for k in range(6)]
    left, right, value_left, value_right, slope_left, slope_right = columns[:6]
    direction, end_left, end_right = columns[8:].astype(np.intp)
    return Laps(
        f=mesh.f,
        left=left,
        right=right,
        value_left=value_left,
        value_right=value_right,
        slope_left=slope_left,
        slope_right=slope_right,
        guard_left=columns[6],
        guard_right=columns[7],
        direction=direction,
        end_left=end_left,
        end_right=end_right,
        cells=Cells(*flat),
        first_cell=np.concatenate([[0], np.cumsum(sizes)]).astype(np.intp),
        value_scale=mesh.value_scale,
    )


def _cut(
    stretch: Stretch,
    first_turn: int,
    rows: list[tuple[float, ...]],
    cells: list[tuple[Floats, ...]],
) -> None:
    """Append the laps of one stretch and their cells."""
    x, value, slope = stretch.x, stretch.value, stretch.slope
    last = len(x) - 1
    bounds = [0, *stretch.turns.tolist(), last]
    turns = [first_turn + k for k in range(len(stretch.turns))]
    numbers = [stretch.numbers[0], *turns, stretch.numbers[1]]
    for k, (i, j) in enumerate(pairwise(bounds)):
        guards = (stretch.guards[0] if i == 0 else x[i], stretch.guards[1] if j == last else x[j])
        ends = (x[i], x[j], value[i], value[j], slope[i], slope[j])
        rows.append((*ends, *guards, np.sign(value[j] - value[i]), numbers[k], numbers[k + 1]))
        span, after = slice(i, j), slice(i + 1, j + 1)
        cells.append((x[span], x[after], value[span], value[after], slope[span], slope[after]))
