"""What each view shows: a request in, the parts of its answer out, the quickest first."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, Final

from stickslip.app import requests
from stickslip.app.requests import Part
from stickslip.app.views.diagram import diagram
from stickslip.app.views.event_map import basins, cobweb, event_map
from stickslip.app.views.model import cycle, law, locus, motion, returns

__all__ = ["VIEWS", "is_slow"]

VIEWS: Final[dict[type[requests.Request], Callable[[Any], Iterator[Part]]]] = {
    requests.Returns: returns,
    requests.EventMap: event_map,
    requests.Cobweb: cobweb,
    requests.Motion: motion,
    requests.Cycle: cycle,
    requests.Locus: locus,
    requests.Law: law,
    requests.Basins: basins,
    requests.Diagram: diagram,
}

SLOW: Final = (requests.Basins, requests.Cycle, requests.Diagram)


def is_slow(request: requests.Request) -> bool:
    """Whether an answer takes seconds: quick ones of the same user go first."""
    return isinstance(request, SLOW) or getattr(request, "power", 1) > 1
