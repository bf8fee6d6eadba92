"""Hash of an itinerary of two blocks, event by event."""

from __future__ import annotations

import numpy as np

from stickslip.numerics.targets import kernel

# Shifts of the 64-bit hash of itineraries (Marsaglia's xorshift; a product would overflow,
# which NumPy reports where kernels run as plain Python).
LEFT, RIGHT, LEFT_AGAIN = np.uint64(13), np.uint64(7), np.uint64(17)


@kernel(inline=True)
def hashed(label: np.uint64, code: int) -> np.uint64:
    """Hash of an itinerary with one more pair of modes."""
    label ^= label << LEFT
    label ^= label >> RIGHT
    label ^= label << LEFT_AGAIN
    return label ^ np.uint64(code + 1)
