"""Kinds of motion of the shaken block, checked."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.studies.claim import Claim, Finding
from stickslip.studies.forced_belt.facts import exponent, shaken
from stickslip.studies.values import Value

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

NOT_READ: Final = "source not read; parameters chosen here"
LOCKED: Final = 1.0  # frequencies
NEUTRAL: Final = 0.4
CHAOTIC: Final = 0.76


def compute(figures: Iterable[int] | None = None) -> tuple[Claim, ...]:
    """Check the claims that belong to some figures, by figure."""
    made = {1: _locked, 2: _chaotic}
    wanted = made if figures is None else [number for number in made if number in set(figures)]
    return tuple(claim for number in wanted for claim in made[number]())


def _locked() -> Iterator[Claim]:
    f = shaken(LOCKED)
    cycle = f.periodic_point([0.0, 0.0])
    times = cycle.period / f.period
    size = float(np.abs(cycle.multipliers).max())
    value, error = exponent(NEUTRAL)
    yield Claim(
        key="forced.locked",
        figure=1,
        place=NOT_READ,
        statement="Shaken stick-slip can lock to the forcing, or drift against it",
        findings=(
            Finding(
                f"at frequency {LOCKED:g} it has the period of the forcing and attracts",
                f"{times:.0f} period, largest multiplier {size:.4f}",
                round(times) == 1 and cycle.stable,
            ),
            Finding(
                f"at frequency {NEUTRAL:g} it neither locks nor is chaotic",
                f"exponent {value:.1e} with an error of {error:.0e}",
                abs(value) < 2e-3,
            ),
        ),
        values=(Value("largest multiplier, locked", size, 1e-10, 1, "shooting over a period"),),
        mechanism="sticking forgets one direction: what is left is a map of the circle of phases",
    )


def _chaotic() -> Iterator[Claim]:
    value, error = exponent(CHAOTIC)
    yield Claim(
        key="forced.chaotic",
        figure=2,
        place=NOT_READ,
        statement="Shaken stick-slip can be chaotic",
        findings=(
            Finding(
                f"the largest exponent is positive at frequency {CHAOTIC:g}",
                f"{value:.4f} with an error of {error:.0e}",
                value > 5.0 * error and value > 0.01,
            ),
        ),
        values=(Value("largest exponent, chaotic", value, error, 2, "3000 periods"),),
        note="The other exponent is minus infinity: a stick forgets where the block was.",
    )
