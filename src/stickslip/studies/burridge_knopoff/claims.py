"""What is said of chains of blocks, and what keeps the computation honest, checked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.studies.burridge_knopoff import facts
from stickslip.studies.burridge_knopoff.power_law import PowerLaw, fit_power_law
from stickslip.studies.claim import Claim, Finding, Value, claim

ACCEPTED: Final = 0.1  # least p-value of a fit that is not ruled out, as the source of the method
DECISIVE: Final = 2.0  # standard errors
SCATTER: Final = 2.0  # of exponents from other starts, in errors of one fit: slips know of others
BALANCED: Final = 1e-10  # relative, of sums of moments
CLOSE: Final = 1e-9  # relative, between the chain's lone slips and Runge and Kutta's
WATCHED: Final = 5.0  # time over which energy is accounted for
UNREAD: Final = "Of the source only the first page was read: no number of it is compared."


def _motion() -> Iterator[Claim]:
    found = facts.catalogue(facts.STIFF, facts.SPEEDS[0])
    counts, waits = np.unique(found.count).size, np.diff([slip.start for slip in found.slips])
    yield claim(
        "burridge_knopoff.noisy",
        "Carlson and Langer (1989), abstract",
        "A uniform chain without randomness makes noisy sequences of slips of all sizes",
        Finding(
            "slips differ, though all blocks are alike",
            f"{len(found.slips)} slips of {counts} different numbers of blocks, from 1 to "
            f"{found.count.max()}",
            counts > 10 and float(np.std(waits)) > 0.0,
        ),
        Finding(
            "nearly all of the motion is that of the largest",
            f"{found.whole.size} slips of the whole chain make up "
            f"{found.whole.sum() / found.size.sum():.1%} of the moment",
            found.whole.sum() > 0.9 * found.size.sum(),
            essential=False,
        ),
        note=UNREAD,
    )
    motion = simulate(
        facts.chain(facts.STIFF, facts.SPEEDS[0]), found.end.x, found.end.v, t_end=WATCHED
    )
    balance = motion.energy(np.linspace(0.0, WATCHED, 50)).balance
    drift = float(np.ptp(balance) / np.abs(balance).max())
    yield claim(
        "burridge_knopoff.balance",
        "docs/theory/blocks.md",
        "Slips bring the blocks back as far as the belt takes them forward",
        Finding(
            "moments add up to what the belt has left the blocks behind",
            f"{found.lag:.1f} from the first to the last time at which all blocks ride; the "
            f"sum of moments differs by {abs(found.moment / found.lag - 1.0):.0e} of itself",
            found.lag > 0.9 * facts.BLOCKS * found.travel
            and abs(found.moment / found.lag - 1.0) < BALANCED,
        ),
        Finding(
            "energy is accounted for",
            f"over {WATCHED:g} units of time the balance changes by {drift:.0e} of itself",
            drift < 1e-12,
        ),
    )


def _sizes() -> Iterator[Claim]:
    law = facts.fitted(facts.STIFF, facts.SPEEDS[0])
    yield claim(
        "burridge_knopoff.power_law",
        "Carlson and Langer (1989), abstract",
        "Sizes are distributed consistently with the law of Gutenberg and Richter",
        Finding(
            "a power law of the moments of local slips is not ruled out",
            f"Kolmogorov-Smirnov distance {law.distance:.3f} of {law.n} slips above "
            f"{law.smallest:.2g}, p = {law.p_value:.2f}",
            law.p_value > ACCEPTED,
        ),
        Finding(
            "it describes them better than an exponential law",
            f"log likelihood ratio {law.exponential:+.1f} standard errors",
            law.exponential > DECISIVE,
        ),
        values=(_exponent(law, facts.SPEEDS[0]),),
        note=(
            f"{UNREAD} Local: more than one block and not all {facts.BLOCKS}. Slips of one block "
            "have one and the same moment, those of the whole chain stand apart: neither is part "
            "of the power law."
        ),
    )
    local = facts.catalogue(facts.SOFT, facts.SPEEDS[0]).local
    soft = fit_power_law(local, np.random.default_rng(facts.SEED), smallest=float(np.median(local)))
    yield claim(
        "burridge_knopoff.equal_springs",
        "De Sousa Vieira (1996), abstract",
        "With springs of equal stiffness sizes are distributed exponentially",
        Finding(
            "an exponential law describes the larger half better than a power law",
            f"log likelihood ratio {soft.exponential:+.1f} standard errors, above a moment of "
            f"{soft.smallest:.2g}; no slip takes more than "
            f"{facts.catalogue(facts.SOFT, facts.SPEEDS[0]).count.max()} of {facts.BLOCKS} blocks",
            soft.exponential < -DECISIVE,
        ),
        note="Of the source only the abstract was read. Friction here is as in the other motions.",
    )


def _drive() -> Iterator[Claim]:
    laws = [facts.fitted(facts.STIFF, V) for V in facts.SPEEDS]
    found = [facts.catalogue(facts.STIFF, V) for V in facts.SPEEDS]
    error = SCATTER * np.hypot(laws[0].error, laws[1].error)
    away = abs(laws[0].exponent - laws[1].exponent) / error
    yield claim(
        "burridge_knopoff.drive",
        "docs/studies/burridge_knopoff.md",
        "Sizes do not depend on how slowly the belt moves; overlaps do",
        Finding(
            "a belt ten times as slow gives the same exponent",
            f"{laws[0].exponent:.3f} at V = {facts.SPEEDS[0]:g}, {laws[1].exponent:.3f} at "
            f"V = {facts.SPEEDS[1]:g}: {away:.1f} times as far apart as motions from other starts",
            bool(away < DECISIVE),
        ),
        Finding(
            "slips go on beside each other for less of their time",
            f"{found[0].overlap:.0%} and {found[1].overlap:.0%} of it; none in the limit "
            "V -> 0, where a slip takes no time of the belt's",
            found[1].overlap < 0.5 * found[0].overlap,
        ),
        values=(_exponent(laws[1], facts.SPEEDS[1]),),
    )
    expected = [facts.lone_moment(facts.STIFF, V) for V in facts.SPEEDS]
    worst = max(
        float(np.ptp(f.lone - e, axis=None) + np.abs(f.lone - e).max()) / e
        for f, e in zip(found, expected, strict=True)
    )
    limit = facts.lone_moment(facts.STIFF, 0.0)
    excess = [e / limit - 1.0 for e in expected]
    yield claim(
        "burridge_knopoff.lone",
        "docs/studies/burridge_knopoff.md",
        "A block that slips alone always does so by as much, which has a limit V -> 0",
        Finding(
            "all lone slips are those of one block on a spring of stiffness 1 + 2 alpha",
            f"{sum(f.lone.size for f in found)} slips differ from an integration by Runge and "
            f"Kutta by {worst:.0e} of it at most",
            worst < CLOSE,
        ),
        Finding(
            "the limit is approached in proportion to V",
            f"their moment exceeds the limit by {excess[0]:.3f} and {excess[1]:.4f} of it",
            abs(excess[0] / excess[1] - facts.SPEEDS[0] / facts.SPEEDS[1]) < 1.0,
        ),
        values=(Value("moment of a lone slip, V -> 0", limit, 1e-15, 3, "one block, V = 0"),),
    )


def _exponent(law: PowerLaw, V: float) -> Value:
    return Value(
        f"exponent of the density of moments, V = {V:g}",
        law.exponent,
        law.error,
        2,
        "maximum likelihood (Clauset et al. 2009)",
    )


CLAIMS: Final = {1: _motion, 2: _sizes, 3: _drive}
