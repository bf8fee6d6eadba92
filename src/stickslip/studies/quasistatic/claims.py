"""What is said of symmetric and asymmetric pairs of blocks, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.studies.claim import Claim, Finding
from stickslip.studies.quasistatic.facts import AWAY, CHAOTIC, MU, limit, plane
from stickslip.studies.values import Value

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

AGREES: Final = 1e-10  # exact and extrapolated limit


def compute(figures: Iterable[int] | None = None) -> tuple[Claim, ...]:
    """Check the claims that belong to some figures, by figure."""
    made = {1: _limit, 2: _plane}
    wanted = made if figures is None else [number for number in made if number in set(figures)]
    return tuple(claim for number in wanted for claim in made[number]())


def _limit() -> Iterator[Claim]:
    found = limit()
    worst = float(np.abs(found.exact - found.extrapolated).max())
    yield Claim(
        key="quasistatic.limit",
        figure=1,
        place="docs/theory/quasistatic.md",
        statement="As V goes to 0 the event map has a limit, in which the belt rests in a slip",
        findings=(
            Finding(
                "the map at V = 0 is the limit of those of moving belts",
                f"they differ by {worst:.1e} at most, at {found.d.size} values of d farther than "
                f"{AWAY:g} from a breakpoint",
                worst <= AGREES,
            ),
        ),
    )


def _plane() -> Iterator[Claim]:
    found = plane()
    symmetric = found.exponents[:, 0]
    largest = float(symmetric.max())
    yield Claim(
        key="quasistatic.symmetric",
        figure=2,
        place="Huang and Turcotte (1992), abstract; Nussbaum and Ruina (1987), source not read",
        statement="Symmetric pairs move periodically, whatever the coupling",
        findings=(
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
        ),
        values=(Value("largest exponent, beta = 1", largest, 1e-3, 2, "mean of log |f'|"),),
        note=(
            "The sources use other laws of friction: of two of them only the abstracts were "
            f"read, so no number of theirs is compared. Here friction is constant, mu = {MU:g}."
        ),
    )
    asymmetric = found.chaotic[1:]
    share = float(asymmetric.mean())
    yield Claim(
        key="quasistatic.asymmetric",
        figure=2,
        place="Huang and Turcotte (1990), source not read; (1992), abstract",
        statement="Asymmetric pairs are chaotic for some parameters and periodic for others",
        findings=(
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
        ),
        values=(
            Value("largest exponent", float(found.exponents.max()), 0.03, 2, "mean of log |f'|"),
        ),
    )
