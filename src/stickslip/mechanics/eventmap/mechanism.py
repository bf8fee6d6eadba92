"""Why the event map breaks: the mechanism of a breakpoint, read from the motions beside it."""

# Motions from adjacent floats share their events up to one, whose kinds name the mechanism.

from __future__ import annotations

import math
import sys
from typing import TYPE_CHECKING

import numpy as np

from stickslip import status
from stickslip.analysis.maps.protocol import Mechanism
from stickslip.numerics.zeros import halved

if TYPE_CHECKING:
    from typing import Protocol

    from stickslip.mechanics.flow.trajectory import Event, Trajectory

    class Traced(Protocol):
        """A map of the line that shows its motions."""

        @property
        def domain(self) -> tuple[float, float]:
            """Ends of the interval of definition."""

        @property
        def rtol(self) -> float:
            """Of the motions."""

        def itinerary(self, d: float, /) -> str:
            """Modes of each phase of the motion from a point."""

        def slip_from(self, d: float, max_events: int, /) -> Trajectory:
            """Follow the motion from a point to the next one."""


# Events of neighbouring motions that are the same one differ by rounding, times how much the
# motion stretches it.
SAME_TIME = 1e-5
# Events of two blocks this close together are a tie, whatever their order in the list.
TIE = 1e-9
# The map's steps and the trajectory's round differently: where adjacent starting points lead to
# the same events, ones this many ulp apart are compared.
APART = (0, 4, 64, 1024, 16384)
# They truncate differently, too: in multiples of the map's tolerance, how far from its break that
# of the trajectories is looked for.
ASTRAY = (10.0, 100.0)
# A motion without return is followed for so many events, the other's number aside; or for some
# more than itineraries share.
MAX_EVENTS, MORE = 400, 8


UNKNOWN = Mechanism("the motions on both sides make the same events", None)
TOO_LATE = Mechanism(f"the motions on both sides make the same first {MAX_EVENTS} events", None)
UNDECIDED = UNKNOWN, TOO_LATE


def mechanism_between(f: Traced, left: float, right: float) -> Mechanism:
    """Explain why the itinerary changes between two adjacent starting points."""
    # ``text``, such as "block 2 grazes its stick interval near X_2 = 0.00185".
    low, high = f.domain
    down, up = math.ulp(left), math.ulp(right)
    pairs = [(max(left - k * down, low), min(right + k * up, high)) for k in APART]
    # The map's itineraries cost little, and say how far to look.
    for ends in pairs:
        n = _n_shared(*(f.itinerary(d).split() for d in ends))
        if n is not None:
            found = _compare(f, *ends, min(2 * n + MORE, MAX_EVENTS))
            if found not in UNDECIDED:
                return found
    for ends in pairs:
        if (found := _compare(f, *ends, MAX_EVENTS)) not in UNDECIDED:
            return found
    for far in ASTRAY:
        if broken := _break_between(f, left - far * f.rtol, right + far * f.rtol):
            return _compare(f, *broken, MAX_EVENTS)
    return found


def _break_between(f: Traced, left: float, right: float) -> tuple[float, float] | None:
    """Bisect to where the trajectories change their events, if they do between two points."""
    low, high = f.domain
    left, right = max(left, low), min(right, high)
    first = _events(f, left)
    if _events(f, right) == first:
        return None
    return halved(lambda d: _events(f, d) == first, left, right, sys.float_info.mant_dig)


def _events(f: Traced, d: float) -> tuple[list[int], list[tuple[int, str]]]:
    motion = f.slip_from(d, MAX_EVENTS)
    return motion.modes[0].tolist(), [event[1:] for event in motion.events]


def _n_shared(first: list[str], second: list[str]) -> int | None:
    """How many phases two itineraries begin with alike; None if they are the same."""
    if first == second:
        return None
    pairs = enumerate(zip(first, second, strict=False))
    return next((k for k, (a, b) in pairs if a != b), min(len(first), len(second)))


def _compare(f: Traced, left: float, right: float, n: int) -> Mechanism:
    return difference_of(*(f.slip_from(d, n) for d in (left, right)))


def difference_of(first: Trajectory, second: Trajectory) -> Mechanism:
    """Explain the first difference between the events of two motions from nearly one state."""
    differ = np.flatnonzero(first.modes[0] != second.modes[0])
    if differ.size == 1:
        i = int(differ[0]) + 1
        return Mechanism(f"block {i} sticks at the start on one side and slips on at the other", i)
    if differ.size:
        which = "both" if first.modes.shape[1] == 2 else "two"
        return Mechanism(f"{which} blocks reach their static limits together at the onset", None)
    for number, (a, b) in enumerate(zip(first.events, second.events, strict=False)):
        if a[1:] != b[1:] or abs(a.time - b.time) > SAME_TIME * (1.0 + a.time):
            return _explain(first, second, number)
    shorter = min(first, second, key=lambda motion: len(motion.events))
    if shorter.status == status.EVENT_LIMIT:
        return TOO_LATE
    if len(first.events) != len(second.events):
        return _explain(first, second, len(shorter.events))
    return UNKNOWN


def _explain(first: Trajectory, second: Trajectory, number: int) -> Mechanism:
    """Name the mechanism from the first events that differ."""
    a = first.events[number] if number < len(first.events) else None
    b = second.events[number] if number < len(second.events) else None
    if a is not None and b is not None and abs(a.time - b.time) <= SAME_TIME * (1.0 + a.time):
        if a.block != b.block:
            return _coincidence(first, a, second, b)
        return _end_point(first, a)
    if b is None or (a is not None and a.time < b.time):
        assert a is not None
        return _alone(first, number)
    return _alone(second, number)


def _alone(trajectory: Trajectory, number: int) -> Mechanism:
    """Name an event without counterpart: a touch, or the one that comes with the last event."""
    # On the tie itself a motion makes both events at once, in either order.
    event = trajectory.events[number]
    if number > 0:
        last = trajectory.events[number - 1]
        if last.block != event.block and event.time - last.time <= TIE * (1.0 + event.time):
            return _coincidence(trajectory, last, trajectory, event)
    return _extra(trajectory, event)


def _coincidence(first: Trajectory, a: Event, second: Trajectory, b: Event) -> Mechanism:
    """Two blocks change mode at the same time: their order, or whether both do, changes."""
    events = sorted(((a, first), (b, second)), key=lambda pair: pair[0].block)
    texts = [f"{_what(trajectory, event)} of block {event.block}" for event, trajectory in events]
    return Mechanism(f"the {texts[0]} and the {texts[1]} coincide", None)


def _what(trajectory: Trajectory, event: Event) -> str:
    if event.kind == "stick":
        return "coming to rest"
    return "release" if _mode_before(trajectory, event) == 0 else "passing through rest"


def _end_point(trajectory: Trajectory, event: Event) -> Mechanism:
    """One block comes to rest on both sides, but does not stay there on one of them."""
    i = event.block
    x = _displacement(trajectory, event)
    end = "upper" if _needed_force(trajectory, event) > 0.0 else "lower"
    text = (
        f"block {i} comes to rest at the {end} end of its stick interval, "
        f"X_{i} = {x:.6g}: it sticks on one side and slips on at the other"
    )
    return Mechanism(text, i)


def _extra(trajectory: Trajectory, event: Event) -> Mechanism:
    """Name an event that only one of the two motions makes: it begins there as a touch."""
    i = event.block
    x = _displacement(trajectory, event)
    force = _needed_force(trajectory, event)
    if _mode_before(trajectory, event) == 0:
        end = "upper" if force > 0.0 else "lower"
        return Mechanism(f"the force on riding block {i} touches its {end} static limit", i)
    limit = trajectory.model.limits[i - 1]
    at_end = abs(abs(force) - limit) < 1e-6 * limit
    where = "at an end point" if at_end else "inside"
    return Mechanism(f"block {i} grazes its stick interval near X_{i} = {x:.3g}, {where}", i)


def _mode_before(trajectory: Trajectory, event: Event) -> int:
    phase = int(np.searchsorted(trajectory.t, event.time, side="left")) - 1
    return int(trajectory.modes[max(phase, 0), event.block - 1])


def _displacement(trajectory: Trajectory, event: Event) -> float:
    return float(trajectory.x(event.time)[event.block - 1])


def _needed_force(trajectory: Trajectory, event: Event) -> float:
    return float(trajectory.needed_force(event.time)[event.block - 1])
