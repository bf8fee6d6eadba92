"""Searches of many parts: a fault of the program is told, and costs its own part alone."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, TypeVar

from stickslip.analysis.bifurcations.bifurcation import UnresolvedChange

if TYPE_CHECKING:
    from collections.abc import Callable

T = TypeVar("T")


def attempted(
    part: Callable[[], T], what: str, lo: float, hi: float, unresolved: list[UnresolvedChange]
) -> T | None:
    """Return what a part of a search finds between two values; None, noted, if it fails."""
    try:
        return part()
    except Exception as error:
        logging.getLogger(__name__).exception("a fault of the program in %s", what)
        reason = f"a fault of the program left out {what} ({type(error).__name__}, logged)"
        unresolved.append(UnresolvedChange(reason, lo, hi))
        return None
