"""Find a paper's figures: each study lists its own in ``FIGURES``, by number."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class PaperFigure:
    """How large a figure is, and what computes and draws it."""

    columns: str  # "one" or "two"
    height: float  # inches
    # into an empty figure; returns the caption: what is shown, with every parameter, and which are
    # not printed
    draw: Callable[[Figure], str]


def of_study(package: str) -> dict[int, PaperFigure]:
    """Figures of a study that can be computed, ascending."""
    found: dict[int, PaperFigure] = importlib.import_module(f"{package}.figures").FIGURES
    return dict(sorted(found.items()))


def select(numbers: Iterable[int] | None, package: str) -> tuple[int, ...]:
    """Check figure numbers and sort them; none given means all."""
    known = tuple(of_study(package))
    wanted = known if numbers is None else tuple(sorted(set(numbers)))
    for number in wanted:
        if number not in known:
            listing = ", ".join(map(str, known))
            raise ValueError(f"figure {number!r} cannot be computed. Available figures: {listing}.")
    return wanted or known
