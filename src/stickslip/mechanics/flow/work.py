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
    """Scratch of the engine.

    ``w``, ``e`` (2, ORDER + 1): series of the step; ``rows``: series of each block's law;
    ``w_low``, ``e_low``: what their first coefficients leave out; ``signal``: the polynomial that
    is searched; ``d_w``, ``d_e``: series of one tangent. ``margin``, ``watch``, ``sliding``: as in
    the exact engine.
    """

    w: Floats
    e: Floats
    rows: Rows
    signal: Floats
    w_low: Floats
    e_low: Floats
    d_w: Floats
    d_e: Floats
    margin: Floats
    watch: Floats
    sliding: Floats


class CollocationWork(NamedTuple):
    """Scratch of the engine.

    ``w``, ``e``: polynomials of the step in powers of time; ``node_w``, ``node_e``,
    ``node_a``: values at the nodes; ``d_...``: the same of one tangent; ``gradient``: of a
    law; ``length``: proposed length of the next step; ``sliding``: time since the motion began,
    0 for a new one. ``margin``, ``watch``: as in the exact engine.
    """

    w: Rows
    e: Rows
    node_w: Rows
    node_e: Rows
    node_a: Rows
    d_node_w: Rows
    d_node_e: Rows
    d_node_a: Rows
    d_w: Rows
    d_e: Rows
    signal: Floats
    gradient: Floats
    length: Floats
    margin: Floats
    watch: Floats
    sliding: Floats
