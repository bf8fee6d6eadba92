"""What is said of symmetric and asymmetric quasi-static pairs of blocks, computed and checked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from stickslip import examples
from stickslip.analysis.branches.branches import breakpoints
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.mechanics.eventmap.quasistatic_map import quasistatic_map
from stickslip.mechanics.friction.coulomb import Coulomb
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.arrays import Floats
from stickslip.studies.claim import Claim, Finding, Value, claim

MU: Final = 0.8  # kinetic over static friction; of no consequence, see docs/theory/quasistatic.md
SPEEDS: Final = 4e-5 * np.array([1.0, 0.75, 0.5, 0.25])
AWAY: Final = 1e-3  # from a breakpoint: closer, the limit is not uniform
STARTS: Final = 4
TRANSIENT: Final = 200
STEPS: Final = 300
CHAOTIC: Final = 0.02  # smallest exponent that counts as positive
CELLS: Final = 61
AGREES: Final = 1e-10  # exact and extrapolated limit


@dataclass(frozen=True)
class Limit:
    """Values at V -> 0: exact, and extrapolated from slowly moving belts; all of shape (n,)."""

    d: Floats
    exact: Floats
    extrapolated: Floats


@dataclass(frozen=True)
class Plane:
    """Exponents (starts, beta, alpha) over a plane of parameters."""

    alpha: Floats
    beta: Floats
    exponents: Floats

    @property
    def chaotic(self) -> NDArray[np.bool_]:
        """Where some motion is chaotic, shape (beta, alpha)."""
        return np.any(self.exponents > CHAOTIC, axis=0)

    @property
    def both(self) -> NDArray[np.bool_]:
        """Where the start decides between chaos and a periodic motion."""
        periodic = (self.exponents < -CHAOTIC).any(axis=0)
        return np.logical_and(self.chaotic, periodic)


@cache
def limit() -> Limit:
    """Compare the limit with the paper's Coulomb system on slow belts, away from breakpoints."""
    model = examples.coulomb()
    f = quasistatic_map(model)
    d = np.linspace(*f.domain, 203)
    ends = np.array([item.d for item in breakpoints(f)])
    d = d[np.abs(d[:, None] - ends).min(axis=1) > AWAY]
    rows = np.array([event_map(model.replace(V=float(V)))(d) for V in SPEEDS])
    weights = [np.prod([V / (V - U) for V in np.delete(SPEEDS, k)]) for k, U in enumerate(SPEEDS)]
    return Limit(d, f(d), np.array(weights) @ rows)


def exponents(alpha: float, beta: float) -> Floats:
    """Lyapunov exponents (starts,) of motions from different phases, in units of one event."""
    f = quasistatic_map(TwoBlock(alpha, beta, 1.0, Coulomb(MU)), threads=1)
    starts = np.linspace(*f.domain, STARTS + 2)[1:-1] * 0.987  # at no special place
    last = f.iterate(starts, TRANSIENT)[:, -1]
    orbits = f.iterate(last, STEPS)[:, :-1]
    with np.errstate(divide="ignore"):  # -inf: the motion is forgotten altogether
        found: Floats = np.log(np.abs(f.derivative(orbits))).mean(axis=1)
    return found


@cache
def plane() -> Plane:
    """Exponents over (alpha, beta), the symmetric systems beta = 1 included."""
    alpha, beta = np.linspace(0.05, 4.05, CELLS), np.linspace(1.0, 2.5, CELLS)
    found = np.array([[exponents(a, b) for a in alpha.tolist()] for b in beta.tolist()])
    return Plane(alpha, beta, np.moveaxis(found, -1, 0))


def _limit() -> Iterator[Claim]:
    found = limit()
    worst = float(np.abs(found.exact - found.extrapolated).max())
    yield claim(
        "quasistatic.limit",
        "docs/theory/quasistatic.md",
        "As V goes to 0 the event map has a limit, in which the belt rests in a slip",
        Finding(
            "the map at V = 0 is the limit of those of moving belts",
            f"they differ by {worst:.1e} at most, at {found.d.size} values of d farther than "
            f"{AWAY:g} from a breakpoint",
            worst <= AGREES,
        ),
    )


def _plane() -> Iterator[Claim]:
    found = plane()
    symmetric = found.exponents[:, 0]
    largest = float(symmetric.max())
    yield claim(
        "quasistatic.symmetric",
        "Huang and Turcotte (1992), abstract; Nussbaum and Ruina (1987), source not read",
        "Symmetric pairs move periodically, whatever the coupling",
        Finding(
            "no exponent is positive at beta = 1",
            f"the largest of {symmetric.size} is {largest:.1e}",
            largest <= CHAOTIC,
        ),
        Finding(
            "which periodic motion depends on the start (Narkounskaia and Turcotte 1992)",
            f"{np.mean(np.abs(symmetric) < 1e-9):.0%} of the motions are neutral: "
            "multiplier 1, a family with a motion for each start",
            bool((np.abs(symmetric) < 1e-9).any()),
        ),
        values=(Value("largest exponent, beta = 1", largest, 1e-3, 2, "mean of log |f'|"),),
        note=(
            "The sources use other laws of friction: of two of them only the abstracts were "
            f"read, so no number of theirs is compared. Here friction is constant, mu = {MU:g}."
        ),
    )
    asymmetric = found.chaotic[1:]
    share = float(asymmetric.mean())
    yield claim(
        "quasistatic.asymmetric",
        "Huang and Turcotte (1990), source not read; (1992), abstract",
        "Asymmetric pairs are chaotic for some parameters and periodic for others",
        Finding(
            "some are chaotic, and not all",
            f"{share:.1%} of {asymmetric.size} systems with beta > 1 have a motion whose "
            f"exponent exceeds {CHAOTIC:g}; the largest exponent is "
            f"{found.exponents.max():.3f}",
            0.0 < share < 1.0,
        ),
        Finding(
            "for some the start decides (Narkounskaia and Turcotte 1992)",
            f"{int(found.both.sum())} of them have chaotic and periodic attractors",
            bool(found.both.any()),
        ),
        values=(
            Value("largest exponent", float(found.exponents.max()), 0.03, 2, "mean of log |f'|"),
        ),
    )


CLAIMS: Final = {1: _limit, 2: _plane}
