"""Find a paper's figures by the names of their modules."""

from __future__ import annotations

import importlib
import pkgutil
import re
from collections.abc import Iterable
from typing import Any, Protocol, cast

from matplotlib.figure import Figure


class PaperFigure(Protocol):
    """What a figure module offers."""

    TITLE: str
    COLUMNS: str
    HEIGHT: float

    def compute(self) -> Any:
        """All numbers of the figure, as a frozen dataclass."""

    def draw(self, data: Any, figure: Figure) -> None:
        """Draw into an empty figure."""

    def caption(self, data: Any) -> str:
        """Say what is shown, with every parameter, and which of them the paper does not print."""


def available(source: str) -> tuple[int, ...]:
    """Numbers of the figures of a study that can be computed, ascending."""
    names = (
        module.name for module in pkgutil.iter_modules(importlib.import_module(source).__path__)
    )
    found = (re.fullmatch(r"fig(\d+)", name) for name in names)
    return tuple(sorted(int(match[1]) for match in found if match))


def load(number: int, source: str) -> PaperFigure:
    """Import one figure's module."""
    return cast("PaperFigure", importlib.import_module(f"{source}.fig{number:02d}"))


def select(numbers: Iterable[int] | None, source: str) -> tuple[int, ...]:
    """Check figure numbers and sort them; none given means all."""
    known = available(source)
    wanted = known if numbers is None else tuple(sorted(set(numbers)))
    for number in wanted:
        if number not in known:
            listing = ", ".join(map(str, known))
            raise ValueError(f"figure {number!r} cannot be computed. Available figures: {listing}.")
    return wanted or known
