"""Periodic orbits of a map of a line followed along a parameter, to where they end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analysis.continuation.curve import Curve
from stickslip.analysis.continuation.follower import (
    Half,
    checked_steps,
    contained,
    is_closed,
)
from stickslip.analysis.continuation.orbit_follower import LineOrbitFollower
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.derived import WindowMap, windowed
from stickslip.checks import shown

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.numerics.continuation import CurvePoint


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
    steps = checked_steps(max_step, max_points)
    f = windowed(f, window)
    value = contained(low, high, name, float(f.parameters[name]), "map and its orbit")
    if orbit.jump is not None:
        raise ValueError(
            f"the orbit through the jump d = {orbit.jump.d:.12g} is infinitely unstable and cannot "
            "be followed: it moves with the jump. Follow the jump itself."
        )
    follower = LineOrbitFollower(f, name, low, high, *steps)
    return follower.follow(follower.start(orbit.points, value))


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
    steps = checked_steps(max_step, max_points)
    if window is None and isinstance(f, WindowMap):
        window = f.window
    f = windowed(getattr(f, "whole", f), window)
    follower = LineOrbitFollower(f, name, low, high, *steps)
    starts = [_way_out(follower, curve, which) for which in (0, -1)]
    if starts == [None, None]:
        raise ValueError(
            f"neither end of the curve can go on inside range = ({low:.12g}, {high:.12g}): "
            f"they are {curve.end_reasons[0]!r} at {name} = {curve.values[0]:.12g} and "
            f"{curve.end_reasons[1]!r} at {curve.values[-1]:.12g}."
        )
    for which, start in enumerate(starts):
        if start is None:
            continue
        other = starts[1 - which]
        # The pieces of the map that the points are on may differ between both ends.
        start = follower.start(start.y[:-1], start.parameter).along(start.tangent)
        half = follower.half(start, [] if other is None else [other.reversed()])
        alone = Half([start], end=curve.ends[which])
        if which == 0:
            curve = _one_after_the_other(follower.joined(half, alone), curve)
        else:
            curve = _one_after_the_other(curve, follower.joined(alone, half))
        if is_closed(half):
            assert half.end is not None
            return replace(curve, ends=(half.end, half.end))
    return curve


def _way_out(follower: LineOrbitFollower, curve: Curve, which: int) -> CurvePoint | None:
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


def _one_after_the_other(first: Curve, second: Curve) -> Curve:
    """Join two curves; the first row of the second is the last of the first."""
    rows = len(first) - 1
    both: dict[str, Any] = {
        name: np.concatenate([getattr(first, name)[:-1], getattr(second, name)])
        for name in ("points", "multipliers", "stable")
    }
    return replace(
        second,
        **both,
        parameters={first.parameter: np.concatenate([first.values[:-1], second.values])},
        ends=(first.ends[0], second.ends[1]),
        bifurcations=first.bifurcations
        + tuple(replace(item, row=rows + item.row) for item in second.bifurcations),
        data={
            name: np.concatenate([first.data[name][:-1], column])
            for name, column in second.data.items()
        },
    )
