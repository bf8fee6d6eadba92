"""Border collisions classified: predicted (Feigin and others), and as observed on both sides.

Side: -1 left of the border c, 1 right. Direction: sign of the change of f^p(c) - c.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.bifurcations.border_collision.jump_return import (
    OneSided,
    far_image,
    near_multiplier,
)
from stickslip.analysis.bifurcations.border_collision.skew_tent import (
    NONE,
    UNDECIDED,
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
from stickslip.analysis.scales import ON_THE_WAY

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.border_collision.jump_return import FarImage
    from stickslip.analysis.maps.protocol import Floats, Map1D
    from stickslip.analysis.orbits.orbit import PeriodicOrbit


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
    no attractor nearby
    """
    a, b = left_slope, right_slope
    if a != a or b != b:
        raise ValueError(f"slopes ({a}, {b}) at a corner: NaN shows a gap, not a corner.")
    # Of f^p; in steps of f a band or point there is p of them.
    found = (attractor_of_skew_tent(a, b, side) for side in (-direction, direction))
    before, after = (
        LocalAttractor(x.kind, x.period * period, x.base * period, x.offset * period) for x in found
    )
    pairs, doubles = paired_side(a, b), doubled_side(a, b)
    text = f"slopes {a:.6g}, {b:.6g} at the corner: {_orbits_at_corner(pairs, doubles, period)}"
    text += f"; {_attractors_at_corner(a, b)}: before {before}, after {after}"
    orbits: OrbitOutcome = "period-doubled" if doubles else "persist"
    if pairs:
        orbits = "born in pairs" if pairs == direction else "die in pairs"
    return Outcome(orbits, after.kind, text, before, after)


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
    f: Map1D,
    border: OneSided,
    side: int,
    direction: int,
    *,
    period: int = 1,
    multiplier: float | None = None,
    others: Sequence[tuple[OneSided, int]] = (),
) -> Outcome:
    """Predict what follows when an orbit of period p meets a jump of f from a side.

    ``others``: jumps that it meets at the same time, with their sides; then give the multiplier.
    """
    # The slopes of f^p and the step between them decide only where the far image stays where these
    # describe the map (Jain and Banerjee, Int. J. Bifurcation Chaos 13, 3341, 2003): ``f`` is
    # asked. Adding and incrementing: Avrutin, Gardini, Sushko and Tramontana (2019); Granados,
    # Alseda, Krupa, SIAM Rev. 59, 225 (2017).
    a = near_multiplier(f, border, side, period) if multiplier is None else multiplier
    after_has_orbit = (-side * direction < 0) == (a < 1)
    orbits: OrbitOutcome = "born at a jump" if after_has_orbit else "lost at a jump"
    if not abs(a) < 1:
        text = f"multiplier {a:.6g} on the near side: no attractor takes part"
        return Outcome(orbits, NONE.kind, text, NONE, NONE)
    images = [
        far_image(f, jump, near, period, multiplier=a) for jump, near in ((border, side), *others)
    ]
    with_orbit, without = LocalAttractor("periodic", period), _left_behind(images)
    before, after = (without, with_orbit) if after_has_orbit else (with_orbit, without)
    return Outcome(orbits, after.kind, _text_at_jump(images), before, after)


def _left_behind(images: Sequence[FarImage]) -> LocalAttractor:
    """Attractor on the side of the collision where the stable orbit does not exist."""
    far = images[0]
    if len(images) > 1:
        # Orbits cross the jump that they come to first, and may come back beside another one.
        local = all(each.fate in ("settles", "leaves") for each in images)
        return NONE if local else UNDECIDED
    if far.fate == "returns":
        rising = far.slope > 0
        kind: AttractorOutcome = "period-adding" if rising else "period-incrementing"
        return LocalAttractor(kind, base=far.period, offset=far.steps)
    return UNDECIDED if far.fate == "wanders" else NONE


def _text_at_jump(images: Sequence[FarImage]) -> str:
    far = images[0]
    text = f"multiplier {far.multiplier:.6g} on the near side"
    if len(images) > 1:
        fates = ", or ".join(_fate(each) for each in images)
        return f"{text} of {len(images)} jumps at once; the far side's image {fates}"
    text += f"; the far side's image {_fate(far)}"
    if far.fate == "returns":
        text += (
            f": cycles of period {far.period} n + {far.steps}, n growing "
            f"like log(distance) / log({far.multiplier:.6g})"
        )
    alone = _by_slopes_alone(far)
    return f"{text}. {alone}" if alone else text


def _fate(far: FarImage) -> str:
    if far.fate == "returns":
        way = f"from a height of {far.height:.6g} and with slope {far.slope:.6g}"
        return f"comes back after {far.steps} steps, {way}"
    if far.fate == "settles":
        return f"settles on the cycle of period {far.cycle} that attracts elsewhere"
    return f"leaves after {far.steps} steps" if far.fate == "leaves" else "settles on no cycle"


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
        fate = "orbits on a far fixed point" if b < 1 else "no attractor: orbits leave"
    return f"Slopes {a:.6g}, {b:.6g} of f^{far.period} and the step {step:.6g} alone: {fate}"


def predicted_at_gap(slope: float, side: int, direction: int, *, period: int = 1) -> Outcome:
    """Predict what follows when an orbit meets the edge of a gap: beyond, all end there."""
    after_has_orbit = (-side * direction < 0) == (slope < 1)
    with_orbit = LocalAttractor("periodic", period) if abs(slope) < 1 else NONE
    before, after = (NONE, with_orbit) if after_has_orbit else (with_orbit, NONE)
    text = f"multiplier {slope:.6g} at the edge; beyond it every orbit nearby ends in the gap"
    orbits: OrbitOutcome = "born at a gap" if after_has_orbit else "lost in a gap"
    return Outcome(orbits, after.kind, text, before, after)


def observed(
    orbits_before: Sequence[PeriodicOrbit],
    orbits_after: Sequence[PeriodicOrbit],
    attractors_before: Sequence[Attractor],
    attractors_after: Sequence[Attractor],
    *,
    period: int = 1,
    gap: bool = False,
    width: float,
) -> Outcome:
    """Name what happened, from orbits beside a border and all attractors, before and after."""
    # Bystanders, found on both sides in about the same place, do not count. ``gap``: its edge is
    # the border.
    before, after = _without_bystanders(
        [_Seen(a, orbits_before, ON_THE_WAY * width) for a in attractors_before],
        [_Seen(a, orbits_after, ON_THE_WAY * width) for a in attractors_after],
        ON_THE_WAY * width,
    )
    orbits = _orbits(orbits_before, orbits_after, period, gap)
    text = f"{_counts(orbits_before)} before, {_counts(orbits_after)} after"
    left, right = _summary(before), _summary(after)
    text += f"; before {left}, after {right}"
    return Outcome(orbits, right.kind, text, left, right)


def _orbits(
    before: Sequence[PeriodicOrbit], after: Sequence[PeriodicOrbit], period: int, gap: bool
) -> OrbitOutcome:
    """Compare the numbers of orbits; those across a jump do not count as orbits of the map."""
    one, two = (_number(side, period) for side in (before, after))
    if one == two:
        if one == 0:
            return "undecided"
        doubles = (_number(side, 2 * period) for side in (before, after))
        return "persist" if len(set(doubles)) == 1 else "period-doubled"
    change = two - one
    if change % 2 == 0:
        return "born in pairs" if change > 0 else "die in pairs"
    if change > 0:
        return "born at a gap" if gap else "born at a jump"
    return "lost in a gap" if gap else "lost at a jump"


def _number(orbits: Sequence[PeriodicOrbit], period: int) -> int:
    return sum(o.period == period and not o.infinitely_unstable for o in orbits)


def _counts(orbits: Sequence[PeriodicOrbit]) -> str:
    periods = sorted(o.period for o in orbits if not o.infinitely_unstable)
    return f"periods {', '.join(map(str, periods))}" if periods else "no orbits"


class _Seen:
    """An attractor, and whether it is one of the orbits concerned."""

    def __init__(self, attractor: Attractor, orbits: Sequence[PeriodicOrbit], moved: float) -> None:
        self.kind, self.period = attractor.kind, attractor.period
        self.bands: Floats = np.asarray(attractor.bands, dtype=np.float64)
        # The lists of orbits may have been made a little closer to the collision.
        self.concerned = attractor.kind == "periodic" and any(
            o.period == attractor.period
            and np.abs(np.sort(o.points) - self.bands[:, 0]).max() <= moved
            for o in orbits
        )

    def looks_like(self, other: _Seen, moved: float) -> bool:
        """Whether the other one is this attractor, a little further on."""
        return (
            (self.kind, self.period) == (other.kind, other.period)
            and not (self.concerned or other.concerned)
            and self.bands.shape == other.bands.shape
            and bool(np.abs(self.bands - other.bands).max() <= moved)
        )

    def local(self) -> LocalAttractor:
        if self.kind == "chaotic":
            return LocalAttractor("chaotic", len(self.bands))
        return LocalAttractor("periodic", self.period) if self.kind == "periodic" else UNDECIDED


def _without_bystanders(
    before: list[_Seen], after: list[_Seen], moved: float
) -> tuple[list[_Seen], list[_Seen]]:
    """Take away, one for one, what is on both sides."""
    left, right = [], list(after)
    for seen in before:
        match = next((other for other in right if seen.looks_like(other, moved)), None)
        if match is None:
            left.append(seen)
        else:
            right.remove(match)
    return left, right


def _summary(attractors: list[_Seen]) -> LocalAttractor:
    """One description of all attractors concerned; no number where theirs differ."""
    found = {seen.local() for seen in attractors} or {NONE}
    if len(found) == 1:
        return found.pop()
    kinds = {each.kind for each in found}
    return LocalAttractor(kinds.pop() if len(kinds) == 1 else "undecided")
