"""What is said of the oscillator with friction 1 / (1 + 3 |w|), computed once and checked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

from stickslip.analysis.continuation.curve import Curve, CurveEvent
from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.equilibria import equilibria
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.blocks import Oscillator
from stickslip.studies.claim import Claim, Finding, Value, claim

MODEL: Final = Oscillator(V=0.2, friction=PoppStelter(gamma=3.0))
DAMPING: Final = (0.0, 1.5)
NOT_READ: Final = "source not read; the oscillator and its parameters as commonly quoted"
PERIOD: Final = "12.00103129483057864690479954"
"""By Taylor series with 45 digits; `tests/studies/test_leine1998.py` repeats it with 30."""
HOPF: Final = 3.0 / (1.0 + 3.0 * 0.2) ** 2
CLOSE: Final = 1e-13


@dataclass(frozen=True)
class Cycles:
    """The branch of cycles over the damping, and the damping at which steady sliding changes."""

    branch: Curve
    sliding: float  # from the eigenvalues of steady sliding alone

    def bifurcation(self, kind: str) -> CurveEvent:
        """Return the one of a kind on the branch."""
        (found,) = (item for item in self.branch.bifurcations if item.kind == kind)
        return found


@cache
def undamped() -> Cycle:
    """Find the stick-slip cycle without damping."""
    return find_cycle(MODEL, [1.0], [MODEL.V])


@cache
def cycles() -> Cycles:
    """Follow the stick-slip cycle along the damping, through its fold, down to steady sliding."""
    branch = follow_cycle(undamped(), "damping", DAMPING)
    # Steady sliding is neutral where damping cancels the slope of the law, -F'(V).
    (sliding,) = equilibria(MODEL)
    return Cycles(branch, 2.0 * float(sliding.eigenvalues[0].real))


def _cycle() -> Iterator[Claim]:
    found = undamped()
    kinds = [event.kind for event in found.events]
    yield claim(
        "leine.cycle",
        NOT_READ,
        "Without damping the block has a stable stick-slip cycle",
        Finding(
            "one slip backward and one stick in each period, and it attracts",
            f"events {', '.join(kinds)}; largest multiplier {abs(found.multipliers).max():.1g}",
            kinds == ["slip backward", "stick"] and found.stable,
        ),
        Finding(
            "the period is that of an integration with many digits",
            f"they differ by {abs(found.period - float(PERIOD)):.1e}",
            abs(found.period - float(PERIOD)) <= CLOSE,
        ),
        values=(Value("period, c = 0", found.period, 1e-13, 1, "shooting from the onset of slip"),),
        mechanism="stick erases the past: the multiplier is zero",
    )


def _branch() -> Iterator[Claim]:
    found = cycles()
    hopf, fold = found.bifurcation("hopf"), found.bifurcation("landing")
    yield claim(
        "leine.hopf",
        NOT_READ,
        "Steady sliding loses stability where c (1 + 3 V)^2 = 3",
        Finding(
            "eigenvalues and the closed form agree",
            f"they differ by {abs(found.sliding - HOPF):.1e}",
            abs(found.sliding - HOPF) <= CLOSE,
        ),
        Finding(
            "the branch of unstable cycles shrinks onto steady sliding there",
            f"it does so at c = {hopf.value:.12f}",
            abs(hopf.value - HOPF) <= CLOSE,
        ),
        values=(Value("c of the Hopf point", hopf.value, max(hopf.error, 1e-15), 2, "c = -F'(V)"),),
        mechanism="the falling law feeds the energy that the damper takes",
    )
    yield claim(
        "leine.fold",
        NOT_READ,
        "The stick-slip cycle ends where it meets an unstable cycle without stick",
        Finding(
            "a discontinuous fold: there the stick has no length, and both cycles end",
            f"at c = {fold.value:.10f} the block lands at its limit; {fold.outcome}",
            fold.outcome == "fold",
        ),
        Finding(
            "between the Hopf point and the fold sliding and cycle both attract",
            f"c from {hopf.value:.6f} to {fold.value:.6f}",
            hopf.value < fold.value,
        ),
        Finding(
            "the multiplier does not come to 1, as it would at a smooth fold",
            "it is 0 on the stick-slip side at each damping",
            all(
                abs(cycle.multipliers).max() == 0.0
                for cycle in found.branch[: fold.row]
                if cycle.events
            ),
        ),
        values=(Value("c of the fold", fold.value, fold.error, 2, "stick of no length"),),
        note=f"V = {MODEL.V:g} throughout.",
    )


CLAIMS: Final = {1: _cycle, 2: _branch}
