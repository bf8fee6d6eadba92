"""The cycles of the oscillator with friction 1 / (1 + 3 |w|), once for all figures and claims."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final

from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.equilibria import equilibria
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.friction.popp_stelter import PoppStelter
from stickslip.mechanics.model.chain import Oscillator

if TYPE_CHECKING:
    from stickslip.analysis.continuation.curve import Curve, CurveEvent
    from stickslip.mechanics.cycle.cycle import Cycle

MODEL: Final = Oscillator(V=0.2, friction=PoppStelter(gamma=3.0))
DAMPING: Final = (0.0, 1.5)


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
