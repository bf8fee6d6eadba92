"""The linear equations of Newton's method for periodic orbits, compiled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Bools, Floats, Indices, Labels


@kernel
def cyclic_rows(s: Floats, b: Floats, periods: Indices, y: Floats) -> None:
    """Solve s_i y_i - y_(i+1) = b_i, cyclic in each row of its own length."""
    for k in range(len(s)):
        cyclic_row(s[k, : periods[k]], b[k, : periods[k]], y[k, : periods[k]])


@kernel
def cyclic_row(s: Floats, b: Floats, y: Floats) -> None:
    """Solve for one row; never divide by what should be large."""
    columns = len(s)
    product, now = 1.0, 0.0
    for j in range(columns):
        product = product * s[j]
    if abs(product) <= 1:
        # Start where going round once leads back.
        for j in range(columns):
            now = s[j] * now - b[j]
        now = now / (1 - product)
        for j in range(columns):
            y[j] = now
            now = s[j] * now - b[j]
    else:
        for j in range(columns - 1, -1, -1):
            now = (now + b[j]) / s[j]
        now = now / (1 - 1 / product)
        for j in range(columns - 1, -1, -1):
            now = (now + b[j]) / s[j]
            y[j] = now


class NewtonStates(NamedTuple):
    """Newton's method for k orbits (k, P) of their own periods, between its steps."""

    periods: Indices
    guess: Floats
    lower: Floats  # bounds of the points
    upper: Floats
    points: Floats
    slopes: Floats
    residuals: Floats
    steps: Floats
    labels: Labels
    last: Floats  # size of the last step, (k,)
    moving: Bools
    given_up: Bools


class NewtonLimits(NamedTuple):
    """When Newton's method ends; lengths in units of the points."""

    singular: float  # distance of a multiplier from 1
    rounding: float  # of a value
    steepest: float  # slope that may excuse a residual
    enough: float  # a step no longer is the last one
    stalled: float  # steps that are shorter must go on shrinking by `shrinking`
    shrinking: float
    closed: float  # ... unless a residual is larger: no orbit as yet
    contraction: float  # of longer steps, each against the one before
    trust_radius: float


@kernel
def newton_step(
    states: NewtonStates, limits: NewtonLimits, value: Floats, slope: Floats, label: Labels
) -> None:
    """Take in the map at all points of the orbits that move, in turn, and move them on."""
    start = 0
    for k in range(len(states.periods)):
        if states.moving[k]:
            stop = start + states.periods[k]
            for j in range(states.periods[k]):
                states.slopes[k, j] = slope[start + j]
                states.labels[k, j] = label[start + j]
            step_of_orbit(states, limits, k, value[start:stop])
            start = stop


@kernel
def step_of_orbit(states: NewtonStates, limits: NewtonLimits, k: int, value: Floats) -> None:
    """Move one orbit by Newton's step, if there is one, or let it rest."""
    period = states.periods[k]
    points, slope = states.points[k, :period], states.slopes[k, :period]
    residuals, step = states.residuals[k, :period], states.steps[k, :period]
    product, finite, is_rounding = 1.0, True, True
    for j in range(period):
        residuals[j] = value[j] - points[(j + 1) % period]
        product = product * slope[j]
        finite = finite and math.isfinite(slope[j])
        allowed = limits.rounding * (1 + min(abs(slope[j]), limits.steepest))
        is_rounding = is_rounding and abs(residuals[j]) <= allowed
    step[:] = math.nan  # to be taken away
    if finite and not abs(product - 1) <= limits.singular:
        cyclic_row(slope, residuals, step)
    size, before = largest(step), states.last[k]
    states.last[k] = size
    # Not if NaN: the orbit is lost.
    moves = not (is_rounding and finite) and size > max(limits.rounding, limits.enough)
    # Small steps that shrink no more are the rounding of the map itself; beside a fold they halve.
    shrinks = size < limits.shrinking * before or largest(residuals) > limits.closed
    moves = moves and (size > limits.stalled or shrinks)
    lost = moves and size > limits.stalled and not size <= limits.contraction * before
    if moves:
        for j in range(period):
            points[j] = min(max(points[j] - step[j], states.lower[k, j]), states.upper[k, j])
            lost = lost or abs(points[j] - states.guess[k, j]) > limits.trust_radius
    states.given_up[k] = lost
    states.moving[k] = moves and not lost


@kernel
def largest(row: Floats) -> float:
    """Return the largest size of some numbers, NaN if one is."""
    size = 0.0
    for x in row:
        if math.isnan(x):
            return math.nan
        size = max(size, abs(x))
    return size
