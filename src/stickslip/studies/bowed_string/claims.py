"""Schelleng's limits beside what the string does, and its pitch beside fixed time steps."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.studies.bowed_string import string
from stickslip.studies.claim import Claim, Finding, Value, claim

LIMITS: Final = "Schelleng's limits as derived in euphonics.org, section 9.3.1"
HERE: Final = "computed here; docs/studies/bowed_string.md"
STEPS: Final = (225, 900)
"""Steps a period; the first is 44.1 kHz at a violin's open G."""


def _limits() -> Iterator[Claim]:
    found = string.plane()
    places = sorted({each.place for each in found})
    kept = [each for each in found if each.kind == string.KINDS[0]]
    shares = [
        [s.force / string.largest(s.place) for s in kept if s.place == place] for place in places
    ]
    above = [s for s in kept if s.force > string.largest(s.place)]
    yield claim(
        "bowed.maximum",
        LIMITS,
        "Above 2 Z V / (beta (mu_s - mu_d)) Helmholtz motion breaks down",
        Finding(
            "none is left above, at any place of the bow",
            f"{len(above)} of {sum(s.force > string.largest(s.place) for s in found)} motions "
            f"above; the largest forces with one are {min(map(max, shares)):.2f} to "
            f"{max(map(max, shares)):.2f} of the limit",
            not above,
        ),
        mechanism="the bow holds the string against the corner that should release it",
    )
    below = [s for s in kept if s.force < string.smallest(s.place)]
    weak = [s for s in found if s.force < 1.5 * string.smallest(s.place)]
    yield claim(
        "bowed.minimum",
        LIMITS,
        "Below Z^2 V / (2 R beta^2 (mu_s - mu_d)) it does so, too",
        Finding(
            "none is left below",
            f"{len(below)} of {sum(s.force < string.smallest(s.place) for s in found)} motions "
            "below",
            not below and bool(weak),
        ),
        Finding(
            "down to that force it goes on",
            f"it gives way to longer slips at {min(map(min, shares)):.2f} to "
            f"{max(map(min, shares)):.2f} of the maximum already",
            any(s.force < 1.5 * string.smallest(s.place) for s in kept),
            essential=False,
        ),
        note="Friction in motion is constant here, unlike that of rosin; the string has 20 modes.",
    )


def _cycle() -> Iterator[Claim]:
    orbits = [string.cycle(share) for share in string.SHARES]
    slips = [_slip(each.events, each.period) for each in orbits]
    yield claim(
        "bowed.cycle",
        HERE,
        "Helmholtz motion is a cycle of two events that attracts",
        Finding(
            "found by Newton's method, it has one stick and one slip a period",
            f"{len(orbits)} bow forces: largest multipliers "
            f"{', '.join(f'{abs(each.largest_multiplier):.4f}' for each in orbits)}",
            all(len(each.events) == 2 and each.stable for each in orbits),
        ),
        Finding(
            "the slip takes the share beta of the period, or a little more",
            f"beta {string.PLACE:g}, shares {', '.join(f'{share:.4f}' for share in slips)}",
            all(1.0 < share / string.PLACE < 1.5 for share in slips),
        ),
        values=tuple(
            Value(f"period at {share:g} of the maximum", each.period, 1e-10, 2, "find_cycle")
            for share, each in zip(string.SHARES, orbits, strict=True)
        ),
    )


def _slip(events: tuple[tuple[float, int, str], ...], period: float) -> float:
    """Share of a period in which the string slips."""
    times = {kind.partition(" ")[0]: time for time, _, kind in events}
    return (times["stick"] - times["slip"]) % period / period


def _pitch() -> Iterator[Claim]:
    exact = [string.cents(string.cycle(share).period) for share in string.SHARES]
    runs = {steps: [string.stepped(share, steps) for share in string.SHARES] for steps in STEPS}
    spread = {n: max(float(np.ptp(run)) for run in given) for n, given in runs.items()}
    off = {
        n: max(
            abs(string.cents(float(run.mean())) - e) for run, e in zip(given, exact, strict=True)
        )
        for n, given in runs.items()
    }
    coarse, fine = STEPS
    yield claim(
        "bowed.pitch",
        HERE,
        "The pitch flattens as the bow presses harder, by a few cents",
        Finding(
            "exact periods tell it",
            ", ".join(f"{e:.3f}" for e in exact) + " cents",
            bool(np.all(np.diff(exact) < 0.0) and exact[0] < 0.0),
        ),
        Finding(
            "fixed steps release the string a step early or late",
            f"{coarse} steps a period (44.1 kHz): periods vary by "
            f"{spread[coarse] / string.PERIOD:.2%}, "
            f"{string.cents(string.PERIOD - spread[coarse]):.1f} cents, and their mean is off by "
            f"{off[coarse]:.1f}; {fine} steps: {off[fine]:.1f}. The exact period does not vary",
            abs(spread[coarse] - string.PERIOD / coarse) < 1e-9 and off[fine] < off[coarse],
        ),
    )


CLAIMS: Final = {1: _limits, 2: _cycle, 3: _pitch}
