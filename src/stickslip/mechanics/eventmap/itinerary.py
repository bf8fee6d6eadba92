"""Itineraries, the modes of all blocks between two global stick phases: as text and as hash."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.system import Motion
from stickslip.numerics.targets import kernel

# Shifts of the 64-bit hash of itineraries (Marsaglia's xorshift; a product would overflow,
# which NumPy reports where kernels run as plain Python).
LEFT, RIGHT, LEFT_AGAIN = np.uint64(13), np.uint64(7), np.uint64(17)


GLOBAL_STICK = 4


@kernel(inline=True)
def mode_code(motion: Motion) -> int:
    """Give each pair of modes a number, 0..8."""
    return 3 * motion.mode[0] + motion.mode[1] + GLOBAL_STICK


@kernel(inline=True)
def hashed(label: np.uint64, code: int) -> np.uint64:
    """Hash of an itinerary with one more pair of modes."""
    label ^= label << LEFT
    label ^= label >> RIGHT
    label ^= label << LEFT_AGAIN
    return label ^ np.uint64(code + 1)


SYMBOLS = "-.+"


def itinerary_text(codes: NDArray[np.int8]) -> str:
    """Write codes of mode pairs as ``"-. -- .- .."``: backward, stick, forward."""
    return " ".join(SYMBOLS[code // 3] + SYMBOLS[code % 3] for code in codes.tolist())
