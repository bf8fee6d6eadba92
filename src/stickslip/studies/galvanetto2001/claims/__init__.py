"""What section 4 of Galvanetto (2001) says, and sections 2, 3 and 5 of the same systems, checked.

One module per topic. Each offers ``FIGURES``, ``facts()`` (all quantities, computed, as a frozen
dataclass) and ``CLAIMS``, functions that make claims from them by stated criteria.
"""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING, Final

from stickslip.studies.galvanetto2001.claims import (
    aftermath,
    birth,
    collision,
    coulomb,
    crisis,
    cusps,
    event_map,
    flip,
    grazing,
    vanishing,
)

if TYPE_CHECKING:
    from types import ModuleType

    from stickslip.studies.claim import Claim

TOPICS: Final[tuple[ModuleType, ...]] = (
    event_map,
    coulomb,
    collision,
    aftermath,
    grazing,
    cusps,
    birth,
    flip,
    crisis,
    vanishing,
)


@cache
def _of_topic(topic: ModuleType) -> tuple[Claim, ...]:
    facts = topic.facts()
    return tuple(make(facts) for make in topic.CLAIMS)


def _of_figure(figure: int) -> list[Claim]:
    of_topics = (_of_topic(topic) for topic in TOPICS if figure in topic.FIGURES)
    return [claim for claims in of_topics for claim in claims if claim.figure == figure]


CLAIMS: Final = {
    figure: partial(_of_figure, figure)
    for figure in sorted({figure for topic in TOPICS for figure in topic.FIGURES})
}
