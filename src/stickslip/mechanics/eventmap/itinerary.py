"""Itineraries, the modes of all blocks between two global stick phases: as text and as hash."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.blocks.system import BlockMotion
from stickslip.mechanics.flow.system import Motion
from stickslip.numerics.targets import kernel

# Shifts of the 64-bit hash of itineraries (Marsaglia's xorshift; a product would overflow,
# which NumPy reports where kernels run as plain Python).
LEFT, RIGHT, LEFT_AGAIN = np.uint64(13), np.uint64(7), np.uint64(17)


GLOBAL_STICK = 4
# Modes that a number of 64 bits tells.
CODED = 32


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


@kernel
def noted(label: np.uint64, motion: Motion | BlockMotion) -> np.uint64:
    """Hash of an itinerary with one more set of modes."""
    code = 0
    for i in range(motion.mode.shape[0]):
        code = 3 * code + motion.mode[i] + 1
        if i % CODED == CODED - 1:
            label, code = hashed(label, code), 0
    return hashed(label, code)


@kernel
def all_have(motion: Motion | BlockMotion, mode: int) -> bool:
    """Whether all blocks are in one mode."""
    for i in range(motion.mode.shape[0]):
        if motion.mode[i] != mode:
            return False
    return True


SYMBOLS = b"-.+" + bytes(253)  # of modes, from -1 on


def itinerary_text(modes: NDArray[np.int8]) -> str:
    """Write rows of modes as ``"-. -- .- .."``: backward, stick, forward."""
    n = modes.shape[1]
    text = (modes + 1).tobytes().translate(SYMBOLS).decode()
    return " ".join([text[k : k + n] for k in range(0, len(text), n)])
