"""Periodic orbits of a map followed along a parameter, through folds, to where they end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.analysis.continuation.orbit_branch import BranchEnd, OrbitBranch
from stickslip.analysis.continuation.orbit_follower import Half, OrbitFollower, Row
from stickslip.analysis.maps.arguments import checked_range
from stickslip.analysis.maps.derived import WindowMap, windowed
from stickslip.checks import finite_number, shown, whole_number

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.numerics.continuation import CurvePoint

MAX_STEP: Final = 1 / 32
MAX_POINTS: Final = 2000


def continue_orbit(
    orbit: PeriodicOrbit | OrbitBranch,
    f: MapFamily,
    name: str,
    range: tuple[float, float],
    *,
    window: tuple[float, float] | None = None,
    max_step: float = MAX_STEP,
    max_points: int = MAX_POINTS,
) -> OrbitBranch:
    """Follow a periodic orbit of a map along a parameter, both ways, through folds.

    Parameters
    ----------
    orbit : PeriodicOrbit or OrbitBranch
        An orbit of ``f`` at the parameter value that ``f`` has. Or a branch, which goes on
        from its ends that are ends of its range.
    f : MapFamily
    name : str
        Of the parameter.
    range : pair of float
        The parameter is followed from one to the other; must contain the orbit's value.
    window : pair of float, optional
        Part of the domain: the branch ends where a point of the orbit leaves it. Of a
        branch by default its own.
    max_step : float
        Longest step along the branch, as a share of the range and of the domain.
    max_points : int
        Of the branch to either side; it ends there with reason "point limit".

    Returns
    -------
    OrbitBranch
        From its end towards lower parameter values, as seen from the orbit, to the other.

    Raises
    ------
    ValueError
        The orbit is infinitely unstable or none of ``f``; the parameter is unknown; the range
        is not an interval, not allowed for the map, or does not contain the orbit; a step or
        a number of points that is not positive.

    Notes
    -----
    Pseudo-arclength with all points of the orbit as unknowns and exact derivatives. The
    branch ends where a point of the orbit meets a jump or corner of the map, a gap, or the
    end of the domain; that is solved as a condition of its own, to rounding. Changes of the
    label that value and slope do not notice are passed.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 3.9})
    >>> orbit = ss.periodic_orbits(f, period=3)[0]
    >>> branch = continue_orbit(orbit, f, "r", (3.8, 4.0))
    >>> [(item.kind, round(item.value, 9)) for item in branch.bifurcations]
    [('fold', 3.828427125), ('flip', 3.841499008)]
    """
    low, high = checked_range(f, name, range)
    why = "It is a share of the range."
    max_step = finite_number("max_step", max_step, above=0.0, at_most=1.0, why=why)
    max_points = whole_number("max_points", max_points, 1)
    if isinstance(orbit, OrbitBranch):
        return _continued(orbit, f, name, low, high, window, max_step, max_points)
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
    follower = OrbitFollower(f, name, low, high, max_step, max_points)
    start = follower.start(orbit.points, value)
    ahead = follower.go(start, [start])
    behind = Half([], ahead.end)
    if not _is_closed(ahead):
        behind = follower.go(start.reversed(), [])
    rows = [*reversed(behind.rows), Row.of(start), *ahead.rows]
    return _branch(f, name, rows, [behind.end, ahead.end])


def _is_closed(half: Half) -> bool:
    return half.end is not None and half.end.reason == "closed"


def _continued(
    branch: OrbitBranch,
    f: MapFamily,
    name: str,
    low: float,
    high: float,
    window: tuple[float, float] | None,
    max_step: float,
    max_points: int,
) -> OrbitBranch:
    """Go on from the ends of a branch that are ends of its range."""
    f = _same_system(branch, f, name, window)
    follower = OrbitFollower(f, name, low, high, max_step, max_points)
    starts = [_way_out(follower, branch, which) for which in (0, -1)]
    if starts == [None, None]:
        raise ValueError(
            f"neither end of the branch can go on inside range = ({low:.12g}, {high:.12g}): "
            f"they are {branch.end_reasons[0]!r} at {name} = {branch.values[0]:.12g} and "
            f"{branch.end_reasons[1]!r} at {branch.values[-1]:.12g}."
        )
    rows, ends = _rows_of(branch), list(branch.ends)
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
    return _branch(f, name, rows, ends)


def _way_out(follower: OrbitFollower, branch: OrbitBranch, which: int) -> CurvePoint | None:
    """Return the point to go on from at an end of a branch; None if it does not go on there."""
    value = float(branch.values[which])
    goes_on = branch.end_reasons[which] in ("end of range", "point limit")
    if not goes_on or not follower.low <= value <= follower.high:
        return None
    start = follower.start(branch.points[which], value)
    ahead = np.append(np.zeros(branch.period), -1.0 if which == 0 else 1.0)
    if len(branch) > 1:
        inner = 1 if which == 0 else -2
        last, before = (np.append(branch.points[i], branch.values[i]) for i in (which, inner))
        ahead = last - before
    start = start.along(ahead)
    rate = start.tangent[-1]
    stuck = (value >= follower.high and rate > 0) or (value <= follower.low and rate < 0)
    return None if stuck else start


def _same_system(
    branch: OrbitBranch, f: MapFamily, name: str, window: tuple[float, float] | None
) -> MapFamily:
    """Check that a branch is one of a system, along the parameter; return the map to use."""
    if name != branch.parameter:
        raise ValueError(
            f"the branch is one along {branch.parameter}, not {shown(name)}. To follow its orbits "
            f"along {name}, take branch.at({branch.parameter}=...) at a value of your choice."
        )
    if window is None and isinstance(branch.f, WindowMap):
        window = branch.f.window
    f = windowed(getattr(f, "whole", f), window)
    if branch.f is not None:
        other = {key: v for key, v in branch.f.parameters.items() if f.parameters.get(key) != v}
        other.pop(name, None)
        if other:
            raise ValueError(
                f"the branch was computed at {', '.join(f'{k} = {v!r}' for k, v in other.items())}"
                "; give the same system."
            )
    return f


# ------------------------------------------------------------------ rows of a branch


def _rows_of(branch: OrbitBranch) -> list[Row]:
    passed = {item.row: item for item in branch.bifurcations}
    return [
        Row(
            float(branch.values[i]),
            branch.points[i],
            float(branch.multipliers[i]),
            branch.labels[i],
            float(branch.residual[i]),
            passed.get(i),
        )
        for i in range(len(branch))
    ]


def _branch(
    f: MapFamily, name: str, rows: Sequence[Row], ends: Sequence[BranchEnd | None]
) -> OrbitBranch:
    """Put rows and ends together."""
    first, last = ends
    assert first is not None
    assert last is not None
    return OrbitBranch(
        parameters={name: np.array([row.value for row in rows])},
        points=np.array([row.points for row in rows]),
        multipliers=np.array([row.multiplier for row in rows]),
        period=len(rows[0].points),
        labels=np.array([row.labels for row in rows]),
        residual=np.array([row.residual for row in rows]),
        ends=(first, last),
        bifurcations=tuple(
            replace(row.passed, row=i) for i, row in enumerate(rows) if row.passed is not None
        ),
        f=f,
    )
