"""Section 4, Coulomb friction: the attractor that follows S4, and its basin."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.attractor import Attractor, AttractorList
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.bifurcations.border_collision.classification import predicted_at_jump
from stickslip.analysis.bifurcations.outcome import LocalAttractor, Outcome
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.studies.claim import Claim, Finding, claim
from stickslip.studies.galvanetto2001 import printed
from stickslip.studies.galvanetto2001.claims.collision import BESIDE, COLLISION, Side, side
from stickslip.studies.galvanetto2001.orbits import jump_of_s4

SAMPLES: Final = (0.0370, 0.0371, 0.0372)  # past the collision; 0.0370 is the paper's figure 6
SAME_EDGE: Final = 1e-5  # basins on both sides of the collision, 2 BESIDE apart


@dataclass(frozen=True)
class Facts:
    """Both sides of the collision, attractors past it, and what the map's shape foretells."""

    before: Side
    after: Side
    past: dict[float, AttractorList]
    predicted: Outcome


def facts() -> Facts:
    """Find basins on both sides of the collision and attractors past it."""
    at = printed.numbers(4)[COLLISION].computed
    return Facts(
        before=side(at - BESIDE),
        after=side(at + BESIDE),
        past={V: attractors(examples.coulomb(V=V)) for V in SAMPLES},
        predicted=_predicted(at),
    )


def _predicted(V: float) -> Outcome:
    """Predict what follows when S4, left of the jump, rises on to it as V grows."""
    f = event_map(examples.coulomb(V=V))
    return predicted_at_jump(f, jump_of_s4(f), side=-1, direction=1, period=4)


def _non_periodic(facts: Facts) -> Claim:
    lists = {**facts.past, facts.after.V: facts.after.basins.attractors}
    found = sorted((V, item) for V, items in lists.items() for item in items if item.period != 1)
    texts = [f"V = {V:.10g}: {_describe(item)}" for V, item in found]
    family = facts.predicted.after
    return claim(
        "collision.non_periodic",
        "section 4, first paragraph, and figures 6 and 7(b)",
        "The attractor that follows S4 is not periodic",
        Finding(
            "at no driving velocity examined is it a stable periodic orbit",
            "; ".join(texts),
            all(item.kind != "periodic" for _, item in found),
        ),
        Finding(
            "the shape of the map at the collision foretells something else than cycles",
            f"it foretells {family}: {facts.predicted.text}",
            family is None or "period" not in family.kind,
        ),
        note=_family(family, [item.period for _, item in found]),
    )


def _family(family: LocalAttractor | None, periods: list[int]) -> str:
    """Explain the periods, if they are of the family foretold."""
    if family is None or not family.base:
        return ""
    if any(period % family.base != family.offset % family.base for period in periods):
        return ""
    return (
        f"The periods {', '.join(map(str, sorted(periods)))} are all {family.base} n + "
        f"{family.offset}: the orbit climbs for n rounds beside the place where S4 was, crosses "
        f"the jump, and is back after {family.offset} more steps. n grows without bound towards "
        "the collision. A period of dozens of global stick phases looks like none."
    )


def _describe(item: Attractor) -> str:
    if item.orbit is None:
        return f"{item.kind}, exponent {item.lyapunov.value:.4f}"
    return f"period {item.period}, multiplier {item.orbit.multiplier:.6f}"


def _same_basin(facts: Facts) -> Claim:
    first, second = facts.before.basin_of_s1, facts.after.basin_of_s1
    same_shape = first.shape == second.shape
    moved = float(np.abs(first - second).max()) if same_shape else np.inf
    rest = [1.0 - side.basins.undecided - side.basins.left for side in (facts.before, facts.after)]
    return claim(
        "collision.same_basin",
        "section 4, below figure 10",
        "The collision merges no basins: the new attractor has the basin that S4 had",
        Finding(
            "the basin of S1 is the same on both sides",
            f"{len(first)} and {len(second)} intervals whose ends differ by {moved:.1e} over "
            f"2 x {BESIDE:.0e} in V",
            moved < SAME_EDGE,
        ),
        Finding(
            "all the rest belongs to what follows S4",
            f"decided: {rest[0]:.6f} of the domain below, {rest[1]:.6f} above",
            min(rest) > 1.0 - 1e-9,
        ),
    )


CLAIMS: Final = {6: (_non_periodic,), 10: (_same_basin,)}
