"""Results in files: versioned JSON, floats exact."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import os

__all__ = ["load", "register", "save"]


def save(result: Any, path: str | os.PathLike[str]) -> None:
    """Write a result to a file."""
    raise NotImplementedError


def load(path: str | os.PathLike[str], system: Any = None) -> Any:
    """Read a result from a file."""
    raise NotImplementedError


def register(cls: type, name: str | None = None) -> type:
    """Let a dataclass be saved: all its fields are written, by name."""
    raise NotImplementedError
