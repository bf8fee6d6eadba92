"""Periodic orbits of a map followed along a parameter, through folds, to where they end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.continuation.curve import Curve
from stickslip.analysis.continuation.orbit_curve import OrbitProblem
from stickslip.analysis.continuation.orbit_follower import Half, OrbitFollower, Row
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.derived import WindowMap, windowed
from stickslip.checks import finite_number, shown, whole_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.continuation.curve import CurveEnd
    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.numerics.continuation import CurvePoint

MAX_STEP: Final = 1 / 32
MAX_POINTS: Final = 2000


def follow_orbit(
    orbit: PeriodicOrbit,
    f: MapFamily,
    name: str,
    range: tuple[float, float],
    *,
    window: tuple[float, float] | None = None,
    max_step: float | None = None,
    max_points: int | None = None,
) -> Curve:
    """Follow a periodic orbit of a map along a parameter; see `stickslip.follow`.

    Pseudo-arclength with all points of the orbit as unknowns and exact derivatives. The curve
    ends where a point of the orbit meets a jump or corner of the map, a gap, or the end of the
    domain; that is solved as a condition of its own, to rounding. Changes of the label that value
    and slope do not notice are passed.
    """
    low, high = checked_range(f, name, range)
    step, most = checked_steps(max_step, max_points)
    f = windowed(f, window)
    value = float(f.parameters[name])
    if not low <= value <= high:
        raise ValueError(
            f"range = ({low:.12g}, {high:.12g}) does not contain {name} = {value:.12g}, at "
            "which the map and its orbit are given."
        )
    if orbit.jump is not None:
        raise ValueError(
            f"the orbit through the jump d = {orbit.jump.d:.12g} is infinitely unstable and cannot "
            "be followed: it moves with the jump. Follow the jump itself."
        )
    follower = OrbitFollower(f, name, low, high, step, most)
    start = follower.start(orbit.points, value)
    ahead = follower.go(start, [start])
    behind = Half([], ahead.end)
    if not _is_closed(ahead):
        behind = follower.go(start.reversed(), [])
    rows = [*reversed(behind.rows), Row.of(start), *ahead.rows]
    return _curve(f, name, rows, [behind.end, ahead.end])


def _is_closed(half: Half) -> bool:
    return half.end is not None and half.end.reason == "closed"


def follow_on(
    curve: Curve,
    name: str,
    range: tuple[float, float],
    *,
    window: tuple[float, float] | None = None,
    max_step: float | None = None,
    max_points: int | None = None,
) -> Curve:
    """Go on from the ends of a curve of orbits that are ends of its range."""
    if name != curve.parameter:
        raise ValueError(
            f"the curve is one along {curve.parameter}, not {shown(name)}. To follow its orbits "
            f"along {name}, take curve.at({curve.parameter}=...) at a value of your choice."
        )
    f = curve.system
    low, high = checked_range(f, name, range)
    step, most = checked_steps(max_step, max_points)
    if window is None and isinstance(f, WindowMap):
        window = f.window
    f = windowed(getattr(f, "whole", f), window)
    follower = OrbitFollower(f, name, low, high, step, most)
    starts = [_way_out(follower, curve, which) for which in (0, -1)]
    if starts == [None, None]:
        raise ValueError(
            f"neither end of the curve can go on inside range = ({low:.12g}, {high:.12g}): "
            f"they are {curve.end_reasons[0]!r} at {name} = {curve.values[0]:.12g} and "
            f"{curve.end_reasons[1]!r} at {curve.values[-1]:.12g}."
        )
    rows, ends = _rows_of(curve), list(curve.ends)
    for which, start in enumerate(starts):
        if start is None:
            continue
        other = starts[1 - which]
        # The pieces of the map that the points are on may differ between both ends.
        start = follower.start(start.y[:-1], start.parameter).along(start.tangent)
        half = follower.go(start, [] if other is None else [other.reversed()])
        rows = [*reversed(half.rows), *rows] if which == 0 else [*rows, *half.rows]
        assert half.end is not None
        ends[which] = half.end
        if _is_closed(half):
            ends = [half.end, half.end]
            break
    return _curve(f, name, rows, ends)


def _way_out(follower: OrbitFollower, curve: Curve, which: int) -> CurvePoint | None:
    """Return the point to go on from at an end of a curve; None if it does not go on there."""
    value = float(curve.values[which])
    goes_on = curve.end_reasons[which] in ("end of range", "point limit")
    if not goes_on or not follower.low <= value <= follower.high:
        return None
    start = follower.start(curve.points[which], value)
    ahead = np.append(np.zeros(curve.points.shape[1]), -1.0 if which == 0 else 1.0)
    if len(curve) > 1:
        inner = 1 if which == 0 else -2
        last, before = (np.append(curve.points[i], curve.values[i]) for i in (which, inner))
        ahead = last - before
    start = start.along(ahead)
    rate = start.tangent[-1]
    stuck = (value >= follower.high and rate > 0) or (value <= follower.low and rate < 0)
    return None if stuck else start


def checked_steps(max_step: float | None, max_points: int | None) -> tuple[float, int]:
    """Return the longest step, as a share of the range, and the number of points to either side."""
    step = finite_number(
        "max_step",
        MAX_STEP if max_step is None else max_step,
        above=0.0,
        at_most=1.0,
        why="It is a share of the range.",
    )
    return step, whole_number("max_points", MAX_POINTS if max_points is None else max_points, 1)


# ------------------------------------------------------------------ rows of a curve


def _rows_of(curve: Curve) -> list[Row]:
    passed = {item.row: item for item in curve.bifurcations}
    return [
        Row(
            float(curve.values[i]),
            curve.points[i],
            float(curve.multipliers[i]),
            curve.data["labels"][i],
            float(curve.data["residual"][i]),
            passed.get(i),
        )
        for i in range(len(curve))
    ]


def _curve(f: MapFamily, name: str, rows: Sequence[Row], ends: Sequence[CurveEnd | None]) -> Curve:
    """Put rows and ends together."""
    first, last = ends
    assert first is not None
    assert last is not None
    multipliers = np.array([row.multiplier for row in rows])
    return Curve(
        kind="orbit",
        period=len(rows[0].points),
        parameters={name: np.array([row.value for row in rows])},
        points=np.array([row.points for row in rows]),
        multipliers=multipliers,
        stable=np.abs(multipliers) < 1,
        ends=(first, last),
        bifurcations=tuple(
            replace(row.passed, row=i) for i, row in enumerate(rows) if row.passed is not None
        ),
        data={
            "labels": np.array([row.labels for row in rows]),
            "residual": np.array([row.residual for row in rows]),
        },
        problem=OrbitProblem(f),
    )
