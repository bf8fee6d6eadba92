"""Itineraries as text: the modes of all blocks between two global stick phases."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

SYMBOLS = "-.+"


def itinerary_text(codes: NDArray[np.int8]) -> str:
    """Write codes of mode pairs as ``"-. -- .- .."``: backward, stick, forward."""
    return " ".join(SYMBOLS[code // 3] + SYMBOLS[code % 3] for code in codes.tolist())
