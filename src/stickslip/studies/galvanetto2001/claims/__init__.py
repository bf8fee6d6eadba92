"""What section 4 of Galvanetto (2001) says, and sections 2, 3 and 5 of the same systems, checked.

One module per topic. Each offers ``FIGURES``, ``facts()`` (all quantities, computed, as a frozen
dataclass) and ``claims(facts)``, which makes the claims from them by stated criteria.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Final, Protocol, cast

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from stickslip.studies.claim import Claim

__all__ = ["TOPICS", "Topic", "compute", "topic"]

TOPICS: Final = (
    "event_map",
    "coulomb",
    "collision",
    "aftermath",
    "grazing",
    "cusps",
    "birth",
    "flip",
    "crisis",
    "vanishing",
)


class Topic(Protocol):
    """What a module of this package offers."""

    FIGURES: tuple[int, ...]

    def facts(self) -> Any:
        """Compute all quantities of the topic, as a frozen dataclass."""

    def claims(self, facts: Any) -> Iterator[Claim]:
        """Make the claims from the quantities."""


def topic(name: str) -> Topic:
    """Import one topic's module."""
    return cast("Topic", importlib.import_module(f"{__name__}.{name}"))


def compute(figures: Iterable[int] | None = None) -> tuple[Claim, ...]:
    """Check the claims that belong to some figures, all by default."""
    wanted = None if figures is None else set(figures)
    found: list[Claim] = []
    for name in TOPICS:
        module = topic(name)
        if wanted is None or wanted & set(module.FIGURES):
            found += module.claims(module.facts())
    chosen = (claim for claim in found if wanted is None or claim.figure in wanted)
    return tuple(sorted(chosen, key=lambda claim: claim.figure))
