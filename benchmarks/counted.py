"""Count the arithmetic of a Coulomb map: kernels of the lanes as plain Python on counting floats.

    NUMBA_DISABLE_JIT=1 python -m benchmarks.counted

prints operations per map as JSON: additions and multiplications, divisions, square roots. What a
vector does for lanes that do not need it, the other side of a choice, is not counted.
"""

from __future__ import annotations

import json
import math
from collections import Counter
from types import SimpleNamespace
from typing import Any

import numpy as np

import stickslip as ss
from stickslip.mechanics.eventmap import _lane_kernels, _lane_list_kernels
from stickslip.mechanics.eventmap.lanes import lanes_of
from stickslip.mechanics.flow import _lane_kernels as flow
from stickslip.mechanics.flow.engine import engine_for
from stickslip.numerics import trigonometry

COUNT: Counter[str] = Counter()
MAPS = 512
MAX_EVENTS = 400


class Counted(float):
    """A float that notes what is done to it."""


def _operation(kind: str, name: str) -> Any:
    plain = getattr(np.float64, name)  # as compiled code: x / 0 is infinite

    def operation(self: Counted, other: float) -> Counted:
        COUNT[kind] += 1
        return Counted(plain(np.float64(self), np.float64(other)))

    return operation


for names, kind in (
    (("add", "radd", "sub", "rsub", "mul", "rmul"), "additions and multiplications"),
    (("truediv", "rtruediv"), "divisions"),
):
    for name in names:
        setattr(Counted, f"__{name}__", _operation(kind, f"__{name}__"))
Counted.__neg__ = lambda self: Counted(float.__neg__(self))  # a bit, no arithmetic


def _root(x: float) -> Counted:
    COUNT["square roots"] += 1
    return Counted(np.sqrt(np.float64(x)))


class Numbers(list):
    """An array of them."""

    size = 0  # no room for slopes

    def __getitem__(self, k: Any) -> Counted:
        """Return a number that counts."""
        return Counted(super().__getitem__(int(k)))

    def __setitem__(self, k: Any, x: float) -> None:
        """Keep a number."""
        super().__setitem__(int(k), x)


class Constants(list):
    """Plain floats: what they alone give is computed once."""

    ndim = 1  # the same for all motions


def counts(model: ss.TwoBlock) -> dict[str, float]:
    """Operations per map, uniform starts."""
    row = Constants(lanes_of(engine_for(model, "exact"), MAX_EVENTS).row.tolist())
    kernels_math = SimpleNamespace(**{**vars(math), "sqrt": _root})
    for module in (_lane_kernels, _lane_list_kernels, flow, trigonometry):
        module.math = kernels_math
    stride = _lane_kernels.STRIDE
    streams = Numbers([0.0] * (_lane_kernels.N_STREAMS * stride))
    lists = np.zeros(_lane_kernels.N_LISTS * stride, dtype=np.uint64)
    d = np.random.default_rng(1).uniform(*model.domain, MAPS)
    value, no_slope = Numbers(d.tolist()), Numbers()
    COUNT.clear()
    _lane_list_kernels.carry_lanes(
        row, None, streams, lists, value, no_slope, 0, MAPS, MAX_EVENTS, None, None
    )
    return {kind: n / MAPS for kind, n in COUNT.items()}


if __name__ == "__main__":
    with np.errstate(all="ignore"):
        print(json.dumps(counts(ss.examples.coulomb())))
