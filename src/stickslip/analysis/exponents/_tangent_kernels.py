"""An orthonormal frame carried along the Jacobians of an orbit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.numerics.arrays import EPS
from stickslip.numerics.targets import kernel

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats

FORGOTTEN: Final = 64 * EPS  # of a Jacobian: growth that is rounding
HIDDEN: Final = float(np.sqrt(FORGOTTEN))  # rounding of so much growth may hide what is kept


@kernel
def carry_frame(jacobians: Floats, frame: Floats, image: Floats, growth: Floats) -> None:
    """Carry k rows of a frame (k, d) along (n, d, d), orthonormal again after each step.

    Fills in the growth (n, k) of each. A direction that a step forgets stays 0 from there on; one
    that is lost in the rounding of others, which the step stretches much more, is NaN for good.
    """
    k, d = frame.shape
    for step in range(len(jacobians)):
        size = 0.0
        for row in range(d):
            for column in range(d):
                size = max(size, abs(jacobians[step, row, column]))
        for i in range(k):
            held = 0.0
            for row in range(d):
                held += abs(frame[i, row])
                total = 0.0
                for column in range(d):
                    total += jacobians[step, row, column] * frame[i, column]
                image[i, row] = total
            for _ in range(2):  # once leaves what rounding made of a direction that shrinks much
                for j in range(i):
                    part = 0.0
                    for row in range(d):
                        part += image[i, row] * frame[j, row]
                    for row in range(d):
                        image[i, row] -= part * frame[j, row]
            length = 0.0
            for row in range(d):
                length += image[i, row] ** 2
            length = np.sqrt(length)
            if length <= FORGOTTEN * size:
                hidden = held > 0.0 and FORGOTTEN * size > HIDDEN
                length = np.nan if hidden else 0.0
            growth[step, i] = length
            for row in range(d):
                frame[i, row] = image[i, row] / length if length != 0.0 else 0.0
