"""What goes into the kernels that follow orbits of many maps, and what comes out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow._lane_kernels import Plant
from stickslip.mechanics.flow.system import Floats, Ints


class ModelTable(NamedTuple):
    """Models of two blocks, and which starting point belongs to which.

    ``alpha``, ``beta``, ``V``, ``law_row``: one entry a model; ``laws`` (rows, 2, columns):
    parameter rows of the laws; ``of_start``: the model of each starting point.
    """

    alpha: Floats
    beta: Floats
    V: Floats
    laws: Floats
    law_row: Ints
    of_start: Ints


class Followed(NamedTuple):
    """What is kept of each orbit besides the verdict.

    ``status``: OK, or why its last motion has no value; ``steps``: maps applied, the transient
    included; the rest is of the stretch after the transient: its last points ``tail``
    (m, kept), and events and time of a step.
    """

    status: NDArray[np.int8]
    steps: NDArray[np.int64]
    tail: Floats
    mean_events: Floats
    most_events: Ints
    mean_duration: Floats


class Abreast(NamedTuple):
    """Orbits that are followed side by side, a slot for each, and scratch of the lanes.

    ``rows`` (plants' numbers, slots), ``x``, ``orbit``: plant, present point and number of the
    orbit in each slot; ``value``, ``slope``: of its next step. ``point`` (slots, n + 1),
    ``label``, ``log_slope`` (slots, n): paths, in the order of the starting points.
    ``streams``, ``lists``: scratch of `_lane_kernels`.
    """

    rows: Floats
    x: Floats
    orbit: Ints
    value: Floats
    slope: Floats
    point: Floats
    label: NDArray[np.uint64]
    log_slope: Floats
    streams: Floats
    lists: NDArray[np.uint64]


def new_abreast(slots: int, n: int, streams: Floats, lists: NDArray[np.uint64]) -> Abreast:
    """Arrays for `slots` orbits whose last n steps are recorded."""
    return Abreast(
        np.zeros((len(Plant._fields), slots)),
        *(np.zeros(slots), np.zeros(slots, dtype=np.int64), np.zeros(slots), np.zeros(slots)),
        *(np.zeros((slots, n + 1)), np.zeros((slots, n), dtype=np.uint64), np.zeros((slots, n))),
        *(streams, lists),
    )


def new_followed(m: int, tail: int) -> Followed:
    """Arrays for m orbits."""
    return Followed(
        np.zeros(m, dtype=np.int8),
        np.zeros(m, dtype=np.int64),
        np.full((m, tail), np.nan),
        np.full(m, np.nan),
        np.zeros(m, dtype=np.int64),
        np.full(m, np.nan),
    )
