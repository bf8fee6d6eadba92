"""Section 3: where the event map lives, and whether it is defined there."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from stickslip import examples, status
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.studies.claim import Claim, Finding, claim
from stickslip.studies.galvanetto2001.orbits import WINDOW

SAMPLES: Final = 200  # starting points over a domain
ROUNDING: Final = 1e-15


@dataclass(frozen=True)
class System:
    """The event map of one of the two systems, over its whole domain."""

    name: str
    domain: tuple[float, float]
    projection: tuple[float, float]  # ends of the locus projected on d
    gaps: tuple[tuple[float, float], ...]  # intervals without a value
    endings: tuple[str, ...]  # names of the statuses in the gaps
    forward: int  # global stick phases, of `SAMPLES`, that a block leaves forward

    @property
    def undefined(self) -> float:
        """Share of the domain without a value."""
        lo, hi = self.domain
        return sum(b - a for a, b in self.gaps) / (hi - lo)


@dataclass(frozen=True)
class Facts:
    """Both systems, and how a small oscillation about steady slip goes on with Coulomb friction."""

    coulomb: System
    law9: System
    slipping: str


def facts() -> Facts:
    """Find gaps and first slips of both systems; start the Coulomb system beside steady slip."""
    model = examples.coulomb()
    force = model.parameters["mu"] * np.array([1.0, model.beta])
    stiffness = (1.0 + model.alpha) * np.eye(2) - model.alpha * np.eye(2)[::-1]
    x = np.linalg.solve(stiffness, force) + 0.2 * model.V * np.array([1.0, -1.0])
    motion = simulate(model, x=x, v=np.zeros(2), until="stick")
    return Facts(
        _system("Coulomb", model),
        _system("law (9)", examples.law9()),
        status.NAMES[motion.status],
    )


def _system(name: str, model: TwoBlock) -> System:
    f = event_map(model)
    d = np.linspace(*f.domain, SAMPLES + 2)[1:-1]
    gaps = [(float(a), float(b)) for a, b in f.gaps]
    middles = np.array([0.5 * (a + b) for a, b in gaps])
    ended = f.evaluate(middles).status if gaps else np.array([], dtype=int)
    corners = [corner[1] - corner[0] for corner in locus.corners(model.plant)]
    return System(
        name,
        f.domain,
        (float(min(corners)), float(max(corners))),
        tuple(gaps),
        tuple(status.NAMES[int(code)] for code in ended),
        sum("+" in text.split()[0] for text in f.itinerary(d).tolist()),
    )


def _domain(facts: Facts) -> Claim:
    return claim(
        "map.domain",
        "section 3, below eq. (12)",
        "The map's field of definition is the projection AC of the global stick locus on d",
        *tuple(
            Finding(
                f"{one.name}: the ends of the domain are those of the projection",
                f"{one.name}: domain |d| <= {one.domain[1]:.12f}, projection "
                f"{one.projection[0]:.12f} .. {one.projection[1]:.12f}",
                bool(np.allclose(one.domain, one.projection, rtol=0.0, atol=4 * ROUNDING)),
            )
            for one in (facts.coulomb, facts.law9)
        ),
        note="That the map has a value all over this interval is another claim: see below.",
    )


def _onset(facts: Facts) -> Claim:
    return claim(
        "map.onset",
        "section 3, below eq. (6)",
        "A global stick phase ends where a block reaches the right end of its interval (6)",
        *tuple(
            Finding(
                f"{one.name}: the first slip is backward from every start",
                f"{one.name}: forward from {one.forward} of {SAMPLES} starts over the domain",
                one.forward == 0,
            )
            for one in (facts.coulomb, facts.law9)
        ),
        mechanism="the belt carries both blocks in the direction in which their springs tighten",
    )


def _defined(facts: Facts) -> Claim:
    coulomb, law9 = facts.coulomb, facts.law9
    lo, hi = WINDOW
    clear = all(b < lo or a > hi for a, b in law9.gaps)
    return claim(
        "map.defined",
        "section 3, last paragraph",
        "For a small driving velocity every motion that starts as a global stick phase has more of "
        "them, so that the map is well defined, as the examples show",
        Finding("Coulomb, V = 0.0366: no gap", _gaps(coulomb), not coulomb.gaps),
        Finding(
            "law (9), V = 0.295, alpha = 1.208: no gap in the range of d that is studied",
            f"{WINDOW[0]} < d < {WINDOW[1]} {'is free of gaps' if clear else 'has a gap'}",
            clear,
        ),
        Finding("law (9): no gap anywhere", _gaps(law9), not law9.gaps, essential=False),
        mechanism=(
            "in the gap the motion settles on a cycle on which some block always slips"
            if "NEVER_CYCLE" in law9.endings
            else ""
        ),
    )


def _without_global_stick(facts: Facts) -> Claim:
    never = {"NEVER_SLIPPING", "NEVER_CYCLE"}
    law9 = facts.law9
    return claim(
        "map.no_global_stick",
        "section 3, last paragraph",
        "Even for a small driving velocity, and more probably with Coulomb friction, there can be "
        "steady motions without any global stick phase",
        Finding(
            "Coulomb: a small oscillation of both blocks about steady slip never sticks",
            f"started beside the equilibrium of steady slip: {facts.slipping}",
            facts.slipping in never,
        ),
        Finding(
            "law (9): such a motion exists",
            f"in the middle of each gap: {', '.join(law9.endings) or 'there is no gap'}",
            bool(law9.endings) and set(law9.endings) <= never,
        ),
        Finding(
            "more probably, tested as: in the paper's two systems, which differ in V, alpha and "
            "beta, too, a larger share of the starts in global stick ends so with Coulomb friction",
            f"Coulomb {facts.coulomb.undefined:.2%} of the domain, law (9) {law9.undefined:.2%}",
            facts.coulomb.undefined > law9.undefined,
            essential=False,
        ),
        note=(
            "With Coulomb friction steady slip is neutrally stable: such motions fill an open set "
            "of initial states. With law (9) the falling force makes steady slip unstable."
        ),
    )


def _gaps(one: System) -> str:
    if not one.gaps:
        return f"{one.name}: the map has a value on all of |d| <= {one.domain[1]:.6f}"
    listing = ", ".join(f"({a:.5f}, {b:.5f})" for a, b in one.gaps)
    ended = ", ".join(one.endings)
    return f"{one.name}: no value in {listing}, {one.undefined:.2%} of the domain ({ended})"


CLAIMS: Final = {2: (_domain, _onset, _defined, _without_global_stick)}
