"""What becomes of the event map of the Coulomb system on faster belts, computed and checked."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.mechanics.cycle.return_region import ReturnRegion, return_region
from stickslip.studies.claim import Claim, Finding, Value, claim

RANGE: Final = (0.0366, 0.5)  # from the paper's own speed on
VALUES: Final = 41
POINTS: Final = 301
PLACE: Final = "computed here; nothing is printed to compare with"


@cache
def region() -> ReturnRegion:
    """Find the gaps of the event map, and the cycles that attract from them."""
    return return_region(examples.coulomb(), "V", RANGE, n_values=VALUES, n_points=POINTS)


def _gaps() -> Iterator[Claim]:
    found = region()
    gaps = [gap for gaps in found.gaps for gap in gaps]
    slow = found.lost[found.values < 0.3]
    yield claim(
        "fast.gaps",
        PLACE,
        "On faster belts the event map has gaps: motions that never stick together",
        Finding(
            "at small speeds it is defined everywhere",
            f"no gap at {slow.size} speeds below 0.3, {found.n_points} values of d each",
            not slow.any(),
        ),
        Finding(
            "at larger ones it has gaps",
            f"{found.lost[-1]:.0%} of the domain at V = {found.values[-1]:g}",
            found.lost[-1] > 0.0,
        ),
        Finding(
            "a motion from each gap enters a ball that holds it",
            f"{sum(gap.shown for gap in gaps)} of {len(gaps)}",
            all(gap.shown for gap in gaps),
            essential=False,
        ),
    )


def _cycles() -> Iterator[Claim]:
    found = region()
    (born, _), *_rest = found.attracting(0)
    starts = sorted(found.attracting(number)[0][0] for number in range(len(found.curves)))
    kinds = [item.kind for curve in found.curves for item in curve.bifurcations]
    opened = found.values[np.flatnonzero(found.lost)[0]]
    yield claim(
        "fast.cycles",
        PLACE,
        "Gaps open where a cycle without global stick begins to attract",
        Finding(
            "the first such cycle begins to attract at a flip, the second is born at a grazing",
            f"bifurcations on the curves: {', '.join(kinds)}",
            "flip" in kinds and "grazing" in kinds,
        ),
        Finding(
            "there is no gap before the first",
            f"the first speed with a gap is {opened:.4f}, the first cycle attracts "
            f"from {born:.4f} on",
            bool(opened >= starts[0]),
        ),
        values=tuple(
            Value(f"V where cycle {number} begins to attract", start, 1e-12, 2, "follow")
            for number, start in enumerate(starts, start=1)
        ),
    )


CLAIMS: Final = {1: _gaps, 2: _cycles}
