"""What goes into the kernels that follow orbits of many maps, and what comes out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stickslip.mechanics.flow._lane_kernels import Plant
from stickslip.mechanics.flow.system import Floats, Ints


class ModelTable(NamedTuple):
    """Models of two blocks, one entry each, and which starting point belongs to which."""

    alpha: Floats
    beta: Floats
    V: Floats
    laws: Floats  # (rows, 2, columns): parameter rows
    law_row: Ints
    of_start: Ints  # the model of each starting point


class Followed(NamedTuple):
    """What is kept of each orbit besides the verdict."""

    status: NDArray[np.int8]  # OK, or why the last motion has no value
    steps: NDArray[np.int64]  # maps applied, the transient included
    tail: Floats  # (m, kept): last points
    mean_events: Floats  # of a step after the transient, as the rest
    most_events: Ints
    mean_duration: Floats


class Abreast(NamedTuple):
    """Orbits that are followed side by side, a slot for each, and scratch of `_lane_kernels`."""

    rows: Floats  # (numbers of a plant, slots)
    x: Floats
    orbit: Ints  # number of the orbit in the slot
    value: Floats  # of the next step, as slope
    slope: Floats
    point: Floats  # (slots, n + 1), paths as label and log_slope (slots, n)
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
