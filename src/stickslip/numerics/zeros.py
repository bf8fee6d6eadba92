"""Zeros of continuous functions of one number that cost much to evaluate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import numpy as np

MAX_STEPS: Final = 60
WIDTH: Final = 4 * float(np.finfo(np.float64).eps)  # of the place: a bracket so narrow is closed


def zero_between(g: Callable[[float], float], a: float, b: float, g_a: float, g_b: float) -> float:
    """Find a zero of a continuous function between two points where its signs differ.

    Chandrupatla's method, Advances in Engineering Software 28, 145 (1997). Of the last bracket, the
    end with the smaller value.
    """
    if g_a == 0:
        return a
    if g_b == 0:
        return b
    c, g_c, share = a, g_a, 0.5
    for _ in range(MAX_STEPS):
        x = a + share * (b - a)
        value = g(x)
        if np.sign(value) == np.sign(g_a):
            c, g_c, a, g_a = a, g_a, x, value
        else:
            c, b, a, g_c, g_b, g_a = b, a, x, g_b, g_a, value
        best = a if abs(g_a) < abs(g_b) else b
        width = WIDTH * max(abs(a), abs(b), 1e-3) / abs(b - a) if b != a else 1.0
        if g_a == 0 or width >= 0.5:
            break
        share = min(max(_share(a, b, c, g_a, g_b, g_c), width), 1 - width)
    return best


def _share(a: float, b: float, c: float, g_a: float, g_b: float, g_c: float) -> float:
    """Place of the next trial between a and b."""
    x, y = (a - b) / (c - b), (g_a - g_b) / (g_c - g_b) if g_c != g_b else 0.0
    if not (y * y < x and (1 - y) ** 2 < 1 - x):
        return 0.5
    first = g_a / (g_b - g_a) * g_c / (g_b - g_c)
    second = (c - a) / (b - a) * g_a / (g_c - g_a) * g_b / (g_c - g_b)
    return first + second
