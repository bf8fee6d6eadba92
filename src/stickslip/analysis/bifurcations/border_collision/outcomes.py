"""Outcomes of border collisions: predicted from what the map does there, and observed.

Types: `analysis.bifurcations.outcome`. Derivations: ``docs/theory/bifurcations.md``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

from stickslip.analysis.bifurcations.border_collision.jump_return import OneSided, far_image
from stickslip.analysis.bifurcations.border_collision.skew_tent import (
    attractor_of_skew_tent,
    doubled_side,
    paired_side,
)
from stickslip.analysis.bifurcations.outcome import (
    AttractorOutcome,
    LocalAttractor,
    OrbitOutcome,
    Outcome,
)

if TYPE_CHECKING:
    from stickslip.analysis.bifurcations.border_collision.jump_return import FarImage
    from stickslip.analysis.maps.protocol import Map1D

NONE: Final = LocalAttractor("none")


def predicted_at_corner(
    left_slope: float, right_slope: float, direction: int, *, period: int = 1
) -> Outcome:
    """Predict what follows when a corner c of g = f^p crosses the diagonal.

    Complete for the normal form a x + mu (x < 0), b x + mu (x > 0), so for all small mu of a map
    that is C1 on both sides; undecided exactly on the borders of the classification. Orbits: Feigin
    (di Bernardo et al., Chaos Solitons Fractals 10, 1881, 1999); attractors: `skew_tent`.

    >>> outcome = predicted_at_corner(1.4, -2.2, direction=1)
    >>> outcome.orbits, outcome.attractors
    ('born in pairs', 'chaotic')
    >>> print(predicted_at_corner(1.4, -5.0, direction=1).after)
    no attractor
    """
    _check_direction(direction)
    a, b = left_slope, right_slope
    if a != a or b != b:
        raise ValueError(f"slopes ({a}, {b}) at a corner: NaN shows a gap, not a corner.")
    before, after = (
        _in_steps_of_f(attractor_of_skew_tent(a, b, side), period)
        for side in (-direction, direction)
    )
    pairs, doubles = paired_side(a, b), doubled_side(a, b)
    text = f"slopes {a:.6g}, {b:.6g} at the corner: {_orbits_at_corner(pairs, doubles, period)}"
    text += f"; {_attractors_at_corner(a, b)}: before {before}, after {after}"
    return Outcome(_at_corner(pairs, doubles, direction), after.kind, text, before, after)


def _in_steps_of_f(found: LocalAttractor, period: int) -> LocalAttractor:
    """Translate from steps of f^p: a band or point there is p of them."""
    return replace(
        found,
        period=found.period * period,
        base=found.base * period,
        offset=found.offset * period,
    )


def _at_corner(pairs: int, doubles: int, direction: int) -> OrbitOutcome:
    if pairs:
        return "born in pairs" if pairs == direction else "die in pairs"
    return "period-doubled" if doubles else "persist"


def _orbits_at_corner(pairs: int, doubles: int, period: int) -> str:
    both = f"two orbits of period {period} on one side, none on the other"
    text = both if pairs else f"the orbit of period {period} persists"
    if doubles:
        where = "the same side" if pairs == doubles else "one side"
        text += f", one of period {2 * period} on {where}"
    return text


def _attractors_at_corner(a: float, b: float) -> str:
    """Name the numbers that decide."""
    steep, falling = (a, b) if a > b else (b, a)
    if steep > 1 and falling < -1:
        measure = (steep - 1) * (-falling - 1)
        return f"(|b| - 1)(a - 1) = {measure:.6g}, chaos up to 1"
    return "attractors of the skew tent"


def predicted_at_jump(
    f: Map1D, border: OneSided, side: int, direction: int, *, period: int = 1
) -> Outcome:
    """Predict what follows when an orbit of period p meets a jump of f from a side.

    Close to the collision a stable orbit, 0 < a < 1, leaves behind the cycles of `far_image` if the
    far side's image comes back (period-adding after a way back of positive slope, else
    incrementing). The slopes of f^p and the step between them decide only where the far image stays
    where these describe the map (Jain and Banerjee, Int. J. Bifurcation Chaos 13, 3341, 2003):
    ``f`` is asked. Adding and incrementing: Avrutin, Gardini, Sushko and Tramontana, Continuous and
    Discontinuous Piecewise-Smooth One-Dimensional Maps (2019); Granados, Alseda, Krupa, SIAM Rev.
    59, 225 (2017).
    """
    _check_direction(direction)
    far = far_image(f, border, side, period)
    a = far.multiplier
    after_has_orbit = (-side * direction < 0) == (a < 1)
    with_orbit = LocalAttractor("periodic", period) if abs(a) < 1 else NONE
    without = _left_behind(far) if abs(a) < 1 else NONE
    before, after = (without, with_orbit) if after_has_orbit else (with_orbit, without)
    return Outcome(
        "born at a jump" if after_has_orbit else "lost at a jump",
        after.kind,
        _text_at_jump(far),
        before,
        after,
    )


def _left_behind(far: FarImage) -> LocalAttractor:
    """Attractor on the side of the collision where the stable orbit does not exist."""
    if far.fate == "returns":
        rising = far.slope > 0
        kind: AttractorOutcome = "period-adding" if rising else "period-incrementing"
        return LocalAttractor(kind, base=far.period, offset=far.steps)
    return LocalAttractor("undecided") if far.fate == "wanders" else NONE


def _text_at_jump(far: FarImage) -> str:
    text = f"multiplier {far.multiplier:.6g} on the near side; the far side's image "
    if far.fate == "returns":
        text += (
            f"comes back after {far.steps} steps, from a height of {far.height:.6g} and with "
            f"slope {far.slope:.6g}: cycles of period {far.period} n + {far.steps}, n growing "
            f"like log(distance) / log({far.multiplier:.6g})"
        )
    elif far.fate == "settles":
        text += f"settles on the cycle of period {far.cycle} that attracts elsewhere"
    elif far.fate == "leaves":
        text += f"leaves after {far.steps} steps"
    else:
        text += "settles on no cycle"
    alone = _by_slopes_alone(far)
    return f"{text}. {alone}" if alone else text


def _by_slopes_alone(far: FarImage) -> str:
    """Say what the normal form would make of the one-sided slopes of f^p and the step alone."""
    a, b, step = far.multiplier, far.local_slope, far.local_height
    if not 0 < a < 1 or b != b:
        return ""
    if step < 0:
        fate = "period adding" if b > 0 else "period incrementing"
    elif b < -1:
        fate = "period adding, over two steps on the far side"
    else:
        fate = "orbits on a far fixed point" if b < 1 else "no attractor: orbits thrown away"
    return f"Slopes {a:.6g}, {b:.6g} of f^{far.period} and the step {step:.6g} alone: {fate}"


def predicted_at_gap(slope: float, side: int, direction: int, *, period: int = 1) -> Outcome:
    """Predict what follows when an orbit meets the edge of a gap: beyond, all end there."""
    _check_direction(direction)
    if side not in (-1, 1):
        raise ValueError(f"side = {side!r} of a border: -1 (left) or 1 (right) is needed.")
    after_has_orbit = (-side * direction < 0) == (slope < 1)
    with_orbit = LocalAttractor("periodic", period) if abs(slope) < 1 else NONE
    before, after = (NONE, with_orbit) if after_has_orbit else (with_orbit, NONE)
    text = f"multiplier {slope:.6g} at the edge; beyond it every orbit nearby ends in the gap"
    orbits: OrbitOutcome = "born at a gap" if after_has_orbit else "lost in a gap"
    return Outcome(orbits, after.kind, text, before, after)


def _check_direction(direction: int) -> None:
    if direction not in (-1, 1):
        raise ValueError(
            f"direction = {direction!r} of f^p(c) - c: 1 (growing) or -1 (falling) is needed."
        )
