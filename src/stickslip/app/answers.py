"""Answers on their way to the page: a small JSON header and arrays, back to back."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

ALIGNED: Final = 8  # bytes: what the page's typed arrays need
DTYPES: Final = {"f8": "<f8", "f4": "<f4", "i4": "<i4", "u1": "|u1"}


@dataclass(frozen=True)
class Part:
    """A part of an answer."""

    name: str  # of the part, such as "samples"
    # floats, integers and booleans travel as f8, i4 and u1
    arrays: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    data: Mapping[str, Any] = field(default_factory=dict)
    progress: float = 1.0  # share of the whole answer that has been sent with this part


def message(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]] | None = None) -> bytes:
    """Pack a header and arrays: length of the header (4 bytes, little-endian), JSON, arrays."""
    # Each array starts at a multiple of 8 bytes.
    packed = {name: _packable(array) for name, array in (arrays or {}).items()}
    listed = [
        {"name": name, "dtype": kind, "shape": list(array.shape)}
        for name, (kind, array) in packed.items()
    ]
    head = msgspec.json.encode({**header, "arrays": listed})
    pieces = [_padded(len(head).to_bytes(4, "little") + head)]
    pieces += [_padded(array.tobytes()) for _, array in packed.values()]
    return b"".join(pieces)


def _packable(array: NDArray[Any]) -> tuple[str, NDArray[Any]]:
    kind = {"f": "f8", "i": "i4", "u": "i4", "b": "u1"}[array.dtype.kind]
    if array.dtype == np.uint8:
        kind = "u1"
    return kind, np.ascontiguousarray(array, dtype=DTYPES[kind])


def _padded(content: bytes) -> bytes:
    return content + bytes(-len(content) % ALIGNED)


def plain(value: Any) -> Any:
    """Return values as JSON has them: lists, numbers, texts; None for NaN and infinities."""
    match value:
        case np.ndarray() | np.generic():
            return plain(value.tolist())
        case float():
            return value if math.isfinite(value) else None
        case complex():
            return [plain(value.real), plain(value.imag)]
        case Mapping():
            return {str(key): plain(item) for key, item in value.items()}
        case list() | tuple():
            return [plain(item) for item in value]
    return value
