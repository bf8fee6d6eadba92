"""Why a sweep does not go on."""

from __future__ import annotations


class StoreRefused(ValueError):
    """The store holds something else; nothing was changed."""


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
