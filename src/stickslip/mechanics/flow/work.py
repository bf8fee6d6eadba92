"""Scratch arrays of the adaptive engine's steppers.

Not part of their templates: one class for all laws, or numba would look its type up by the
slow way at every call.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow.system import Floats

Rows = NDArray[np.float64]


class TaylorWork(NamedTuple):
    """Scratch of the engine."""

    w: Floats  # (2, ORDER + 1): series of the step, as e
    e: Floats
    rows: Rows  # series of each block's law
    signal: Floats  # the polynomial that is searched
    w_low: Floats  # what the first coefficients leave out
    e_low: Floats
    d_w: Floats  # of one tangent
    d_e: Floats
    margin: Floats
    watch: Floats
    sliding: Floats


class CollocationWork(NamedTuple):
    """Scratch of the engine."""

    w: Rows  # polynomials of the step in powers of time, as e
    e: Rows
    node_w: Rows  # values at the nodes
    node_e: Rows
    node_a: Rows
    d_node_w: Rows  # d_...: of one tangent
    d_node_e: Rows
    d_node_a: Rows
    d_w: Rows
    d_e: Rows
    signal: Floats
    gradient: Floats  # of a law
    length: Floats  # proposed, of the next step
    margin: Floats
    watch: Floats
    sliding: Floats  # time since the motion began, 0 for a new one
