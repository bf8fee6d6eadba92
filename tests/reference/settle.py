"""Right or wrong, as the design says (end of section 3)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

from flint import arb

from .motion import EVENT_LIMIT, OK, TIME_LIMIT, Motion, System, sensitivity
from .precision import exact

LIMITS = (EVENT_LIMIT, TIME_LIMIT)

RIGHT = "right"
WRONG = "wrong"
EXCUSED = "excused"  # the reference's own itinerary changes within 64 kappa ulp of d
GAVE_UP = "gave up"  # one of the two statuses is a limit, and the other cannot be refuted


@dataclass(frozen=True)
class Verdict:
    """What the reference says about one value."""

    verdict: str
    d: float
    value: float
    status: str
    reference: Motion
    error: float  # |value - reference|; NaN where one of them has none
    kappa: float  # 1 where the error alone was small enough

    def __str__(self) -> str:
        ref = self.reference
        wanted = "none" if ref.value is None else repr(float(ref.value))
        return (
            f"{self.verdict}: d={self.d!r} value={self.value!r} status={self.status} "
            f"reference={wanted} {ref.status} error={self.error:.3g} kappa={self.kappa:.3g} "
            f"itinerary={ref.itinerary[:90]!r} ({ref.n_events} events)"
        )


def settle(
    system: System,
    d: float,
    value: float,
    status: str,
    tol: float,
    duration: float = math.inf,
    **limits: float,
) -> Verdict:
    """Judge ``value`` and ``status`` at ``d`` against the oracle of this system.

    ``duration``: when the motion returned, if it did: a reference that has been followed beyond
    that without a return refutes it. ``limits``: ``max_events`` and ``max_time`` of the reference.
    """
    reference = followed(system, d, **limits)
    error, kappa = math.nan, 1.0

    def verdict(word: str) -> Verdict:
        return Verdict(word, d, value, status, reference, error, kappa)

    refuted = status == OK and reference.explored > 1.01 * duration + 1
    if status in LIMITS or (reference.status in LIMITS and not refuted):
        return verdict(GAVE_UP)
    if status == reference.status:
        if status != OK:
            return verdict(RIGHT)
        if math.isfinite(value):
            error = float(abs(exact(value) - reference.value))
            if error <= tol:
                return verdict(RIGHT)
    kappa = stretch(system, d, **limits)
    if error <= tol * kappa:
        return verdict(RIGHT)
    if changes_nearby(system, d, reference, kappa, limits):
        return verdict(EXCUSED)
    return verdict(WRONG)


@lru_cache(2000)
def followed(system: System, d: float, **limits: float) -> Motion:
    """The oracle's motion, kept: the other engines are held against the same one."""
    return replace(system.motion(d, **limits), phases=())


@lru_cache(2000)
def stretch(system: System, d: float, **limits: float) -> float:
    """Kappa of that motion."""
    return sensitivity(system, d, followed(system, d, **limits), **limits)[1]


def changes_nearby(
    system: System, d: float, reference: Motion, kappa: float, limits: dict[str, float]
) -> bool:
    """Whether the reference's itinerary is another one at d - or d + 64 kappa ulp(d).

    Near d = 0 doubles are finer than the forces that a motion starts with, 1 + (1 + 2 alpha) d:
    the reach is no shorter than one ulp of those.
    """
    if not math.isfinite(kappa):
        return True
    (a, b), (c, e) = system.plant.stiffness
    stiff = float(abs(a * e - b * c) / abs(a + b).max(abs(c + e)))  # force per d; 1 + 2 alpha
    reach = kappa * max(64 * math.ulp(d), math.ulp(1.0) / stiff)
    low, high = system.plant.ends
    for side in (-1, 1):
        near = exact(d) + side * arb(reach)
        near = near.max(low).min(high)
        other = system.motion(near, **limits)
        if (other.status, path(other)) != (reference.status, path(reference)):
            return True
    return False


def path(motion: Motion) -> str:
    """The itinerary of a motion that returns; where one does not, its end is arbitrary."""
    return motion.itinerary if motion.status == OK else ""
