"""What section 4 of Galvanetto (2001) says, and sections 2, 3 and 5 of the same systems, checked.

One module per topic. Each offers ``facts()`` (all quantities, computed, as a frozen dataclass) and
``CLAIMS``: by figure the functions that make claims from them by stated criteria.
"""

from __future__ import annotations

from functools import cache, partial
from typing import TYPE_CHECKING, Any, Final

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
    from collections.abc import Iterator
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
def _facts(topic: ModuleType) -> Any:
    return topic.facts()


def _of_figure(figure: int) -> Iterator[Claim]:
    for topic in TOPICS:
        for make in topic.CLAIMS.get(figure, ()):
            yield make(_facts(topic))


CLAIMS: Final = {figure: partial(_of_figure, figure) for topic in TOPICS for figure in topic.CLAIMS}
