"""Periodic orbits followed along a parameter, to where they end."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stickslip.analysis.continuation.follower import checked_steps, contained
from stickslip.analysis.continuation.orbit_follower import orbit_follower
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.derived import WindowMap, windowed
from stickslip.checks import shown

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve
    from stickslip.analysis.maps.protocol import FamilyND, MapFamily
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
    from stickslip.analysis.work import Work


def follow_orbit(
    orbit: PeriodicOrbit | PeriodicOrbitND,
    f: MapFamily | FamilyND,
    name: str,
    range: tuple[float, float],
    *,
    window: tuple[float, float] | None = None,
    max_step: float | None = None,
    max_points: int | None = None,
    work: Work | None = None,
) -> Curve:
    """Follow a periodic orbit of a map along a parameter; see `stickslip.follow`.

    Pseudo-arclength with all points of the orbit as unknowns and exact derivatives. The curve
    ends where a point of the orbit meets a jump or corner of the map, a gap, or the end of the
    domain; on a line that is solved as a condition of its own, to rounding. Changes of the label
    that value and slope do not notice are passed.
    """
    low, high = checked_range(f, name, range)
    steps = checked_steps(max_step, max_points)
    f = windowed(f, window)
    value = contained(low, high, name, float(f.parameters[name]), "orbit")
    if (jump := getattr(orbit, "jump", None)) is not None:
        raise ValueError(
            f"the orbit through the jump d = {jump.d:.12g} is infinitely unstable and cannot "
            "be followed: it moves with the jump. Follow the jump itself."
        )
    follower = orbit_follower(f, name, low, high, *steps)
    return follower.follow(follower.start(orbit.points, value), work)


def follow_on(
    curve: Curve,
    name: str,
    range: tuple[float, float],
    *,
    window: tuple[float, float] | None = None,
    max_step: float | None = None,
    max_points: int | None = None,
    work: Work | None = None,
) -> Curve:
    """Follow a curve of orbits anew over a wider range, if one of its ends goes on there."""
    if name != curve.parameter:
        raise ValueError(
            f"the curve is one along {curve.parameter}, not {shown(name)}. To follow its orbits "
            f"along {name}, take curve.at({curve.parameter}=...) at a value of your choice."
        )
    f, values = curve.system, curve.values
    low, high = checked_range(f, name, range)
    step, most = checked_steps(max_step, max_points)
    wide = min(low, float(values.min())), max(high, float(values.max()))
    if not any(
        end.reason == "point limit" or (end.reason == "end of range" and wide[0] < value < wide[1])
        for end, value in zip(curve.ends, values[[0, -1]].tolist(), strict=True)
    ):
        raise ValueError(
            f"neither end of the curve can go on inside range = ({low:.12g}, {high:.12g}): "
            f"they are {curve.end_reasons[0]!r} at {name} = {values[0]:.12g} and "
            f"{curve.end_reasons[1]!r} at {values[-1]:.12g}."
        )
    if window is None and isinstance(f, WindowMap):
        window = f.window
    f = windowed(getattr(f, "whole", f), window)
    follower = orbit_follower(f, name, *wide, step, most + len(curve))
    middle = len(curve) // 2
    return follower.follow(follower.start(curve.points[middle], float(values[middle])), work)
