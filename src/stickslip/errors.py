"""What goes wrong by name; illegal arguments are plain ValueErrors.

>>> import stickslip as ss
>>> block = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5), damping=0.1)
>>> try:
...     ss.find_cycle(block, x=[0.1], v=[0.1])
... except ss.errors.NoCycleError as error:
...     print(error.kind)
slides
"""

from __future__ import annotations

from typing import Literal

__all__ = [
    "MissingExtraError",
    "NoCycleError",
    "StoreAbsent",
    "StoreBusy",
    "StoreFull",
    "StoreRefused",
    "TilesFailed",
    "WorkersLost",
]


class MissingExtraError(ModuleNotFoundError):
    """A package that one of the project's extras brings is not installed."""


class NoCycleError(ValueError):
    """No cycle was found from a state: all blocks slip for ever, or the search gave up."""

    def __init__(self, why: str, kind: Literal["slides", "undecided"] = "undecided") -> None:
        super().__init__(f"no cycle was found from this state{why}")
        self.kind: Literal["slides", "undecided"] = kind


class StoreRefused(ValueError):
    """The store holds something else than what is asked for; nothing was changed."""


class StoreAbsent(StoreRefused):
    """There is no store."""


class StoreBusy(RuntimeError):
    """Another process writes to the store."""


class StoreFull(OSError):
    """No space is left where the store lies; what was finished is kept."""


class TilesFailed(RuntimeError):
    """Some chunks could not be computed; the others are stored."""


class WorkersLost(RuntimeError):
    """The scheduler of the workers, or the client to it, is gone; what was finished is stored."""
