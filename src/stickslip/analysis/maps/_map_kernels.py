"""Orbits of a recorded map of R^n, and the cells they come to: a template around its ``step``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from stickslip.numerics.targets import kernel

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

if TYPE_CHECKING:  # bound when the template is executed: functions of points as tuples
    step = load = store = inside = cell = cast("Any", None)

NOWHERE, LEFT = -1, -2  # labels beside those of cells


@kernel
def orbits(x: Floats, p: Floats, box: Floats, out: Floats, n: int, start: int, stop: int) -> None:
    """Fill rows i (n + 1) .. of `out` with the orbit of point i, as far as it is in the box."""
    for i in range(start, stop):
        z = load(x, i)
        for k in range(n + 1):
            store(z, out, i * (n + 1) + k)
            if not inside(z, box):
                break
            z = step(z, p)


@kernel
def fates(
    x: Floats,
    p: Floats,
    box: Floats,
    held: Floats,
    per_cell: Floats,
    counts: Integers,
    labels: NDArray[np.int16],
    hits: int,
    max_steps: int,
    fate: NDArray[np.int16],
    steps: NDArray[np.int32],
) -> None:
    """Follow points until they stay in cells of one label for some steps, or leave the box."""
    for i in range(len(x)):
        z = load(x, i)
        found, last, run, k = NOWHERE, NOWHERE, 0, 0
        while k <= max_steps:
            label = NOWHERE
            if inside(z, held):  # which lies in the box
                label = int(labels[cell(z, held, per_cell, counts)])
            elif not inside(z, box):
                found = LEFT
                break
            run = run + 1 if label == last else 1
            last = label
            if label != NOWHERE and run >= hits:
                found = label
                break
            z = step(z, p)
            k += 1
        fate[i], steps[i] = found, k
