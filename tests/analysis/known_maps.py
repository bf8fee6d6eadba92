"""Maps whose orbits are known in closed form."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stickslip.analysis.maps.piecewise_map import PiecewiseMap

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import Floats


def tent(slope: float = 2.0) -> PiecewiseMap:
    """Make the tent map slope * min(x, 1 - x) on [0, 1], slope in [0, 2]: a corner at 1/2.

    Every orbit has multiplier ±slope^p; at 2 f^p has 2^p fixed points (`tent_points`).
    """
    return PiecewiseMap(
        _tent,
        (0.0, 1.0),
        parameters={"slope": slope},
        derivative=_tent_slope,
        parameter_derivative={"slope": lambda x, slope: np.minimum(x, 1 - x)},
        breakpoints=[0.5],
    )


def _tent(x: Any, slope: float) -> Any:
    return slope * np.minimum(x, 1 - x)


def _tent_slope(x: Any, slope: float) -> Any:
    return np.where(x < 0.5, slope, -slope)


def tent_points(p: int) -> Floats:
    """Return the 2^p fixed points of the p-th power of the tent map of slope 2, ascending.

    The lap number j, 0 <= j < 2^p, is x -> 2^p x - j or j + 1 - 2^p x, j even or odd.
    """
    j = np.arange(2**p)
    return np.where(j % 2 == 0, j / (2.0**p - 1), (j + 1) / (2.0**p + 1))


def logistic(r: float = 4.0) -> PiecewiseMap:
    """Make the logistic map r x (1 - x) on [0, 1]: one branch, parameter ``r`` in [0, 4]."""
    return PiecewiseMap(
        _logistic,
        (0.0, 1.0),
        parameters={"r": r},
        derivative=lambda x, r: r * (1 - 2 * x),
        parameter_derivative={"r": lambda x, r: x * (1 - x)},
    )


def _logistic(x: Any, r: float) -> Any:
    return r * x * (1 - x)


def logistic_points(p: int) -> Floats:
    """Return the 2^p fixed points of the p-th power of the logistic map at r = 4, ascending.

    They are the image of `tent_points` under x -> sin(pi x / 2)^2.
    """
    points: Floats = np.sin(np.pi / 2 * tent_points(p)) ** 2
    return points


def doubling(slope: float = 2.0) -> PiecewiseMap:
    """Make the expanding map slope * x mod 1 on [0, 1], slope > 1, with jumps at k / slope.

    The value at a jump is the right one; at x = 1 it is the limit from the left, so that at slope 2
    both ends are fixed points and f^p has the 2^p fixed points k / (2^p - 1). The fixed point of
    each full branch number k is k / (slope - 1).
    """
    return PiecewiseMap(
        _doubling,
        (0.0, 1.0),
        parameters={"slope": slope},
        derivative=lambda x, slope: np.full_like(x, slope),
        parameter_derivative={"slope": lambda x, slope: x},
        breakpoints=lambda slope: np.arange(1, math.ceil(slope)) / slope,
    )


def _doubling(x: Any, slope: float) -> Any:
    branch = np.minimum(np.floor(slope * x), math.ceil(slope) - 1)
    return slope * x - branch


def tent_with_hole(slope: float = 3.0) -> PiecewiseMap:
    """Make the tent map slope * min(x, 1 - x), slope > 2, without a value above 1: a gap.

    The gap is (1/slope, 1 - 1/slope). Both branches are onto [0, 1]: f^p has 2^p unstable fixed
    points, multipliers ±slope^p, and almost every orbit ends in the gap.
    """
    return PiecewiseMap(
        _tent_with_hole,
        (0.0, 1.0),
        parameters={"slope": slope},
        derivative=_tent_slope,
        parameter_derivative={"slope": lambda x, slope: np.minimum(x, 1 - x)},
        breakpoints=[0.5],
    )


def _tent_with_hole(x: Any, slope: float) -> Any:
    value = slope * np.minimum(x, 1 - x)
    return np.where(value <= 1, value, np.nan)


def border_collision(
    a: float = 0.5, b: float = -2.0, mu: float = 1.0, jump: float = 0.0, *, size: float = 10.0
) -> PiecewiseMap:
    """Make a border's normal form on [-size, size]: a x + mu left of 0, b x + mu + jump right.

    Fixed points: mu / (1 - a) if that is <= 0, (mu + jump) / (1 - b) if that is >= 0. Continuous
    (Nusse and Yorke 1992; di Bernardo et al. 2008, section 3.1) and with a jump (Jain and Banerjee
    2003; Avrutin et al. 2019).
    """
    return PiecewiseMap(
        _border_collision,
        (-size, size),
        parameters={"a": a, "b": b, "mu": mu, "jump": jump},
        derivative=lambda x, a, b, mu, jump: np.where(x < 0, a, b),
        parameter_derivative={
            "a": lambda x, a, b, mu, jump: np.where(x < 0, x, 0.0),
            "b": lambda x, a, b, mu, jump: np.where(x < 0, 0.0, x),
            "mu": lambda x, a, b, mu, jump: np.ones_like(x),
            "jump": lambda x, a, b, mu, jump: np.where(x < 0, 0.0, 1.0),
        },
        breakpoints=[0.0],
    )


def _border_collision(x: Any, a: float, b: float, mu: float, jump: float) -> Any:
    return np.where(x < 0, a * x + mu, b * x + mu + jump)


def maximal_window(a: float, b: float, n: int) -> tuple[float, float]:
    """Return low < mu <= high for the cycle L^n R of `border_collision`, jump -1, 0 < a < 1.

    At ``low`` the positive point, at ``high`` the last negative one is on the border. For 0 < b < 1
    the windows are disjoint, and between those of n and n + 1 lie the cycles of period adding;
    those with n points right of the border exist for ``low < 1 - mu <= high`` with the slopes
    exchanged. For b < 0 neighbouring windows overlap (period incrementing, both cycles attract),
    for b = 0 they touch. Avrutin and Schanz, Nonlinearity 19, 531 (2006); Avrutin, Gardini, Sushko
    and Tramontana, Continuous and Discontinuous Piecewise-Smooth One-Dimensional Maps (2019),
    chapter 3.
    """
    low = a**n * (1 - a) / (1 - a ** (n + 1))
    bottom = (a ** (1 - n) - a) / (1 - a) + b  # without bound if a falling branch is that steep
    return low, 1 / bottom if bottom > 0 else math.inf


def square_root(lam: float = 0.2, mu: float = 0.1) -> PiecewiseMap:
    """Make Nordmark's square-root map of grazing: lam x + mu left of 0, mu - sqrt(x) right.

    Nordmark, J. Sound Vib. 145, 279 (1991) and Phys. Rev. E 55, 266 (1997); Chin, Ott, Nusse and
    Grebogi, Phys. Rev. E 50, 4427 (1994). For lam < 1/4 the orbits with one point right of the
    border (`maximal_orbit`) add a point after another as mu falls to 0.
    """
    return PiecewiseMap(
        _square_root,
        (-2.0, 2.0),
        parameters={"lam": lam, "mu": mu},
        derivative=_square_root_slope,
        parameter_derivative={
            "lam": lambda x, lam, mu: np.where(x < 0, x, 0.0),
            "mu": lambda x, lam, mu: np.ones_like(x),
        },
        breakpoints=[0.0],
    )


def _square_root(x: Any, lam: float, mu: float) -> Any:
    return np.where(x < 0, lam * x, -np.sqrt(np.maximum(x, 0.0))) + mu


def _square_root_slope(x: Any, lam: float, mu: float) -> Any:
    return np.where(x < 0, lam, -0.5 / np.sqrt(np.maximum(x, 0.0)))


def maximal_orbit(lam: float, mu: float, p: int) -> tuple[Floats, float]:
    """Return the orbit of `square_root` with its first point alone right of 0; its multiplier.

    With u the root of the positive point, u^2 + lam^(p-1) u = mu (1 - lam^p) / (1 - lam).
    """
    q = lam ** (p - 1)
    height = mu * (1 - lam**p) / (1 - lam)
    # The form of the positive solution without cancellation.
    root = 2 * height / (q + math.sqrt(q * q + 4 * height))
    left = [mu - root]
    for _ in range(p - 2):
        left.append(lam * left[-1] + mu)
    points = np.array([root * root, *left[: p - 1]])
    if root * root > 2 or (points[1:] >= 0).any():
        raise ValueError(f"lam = {lam}, mu = {mu}: no maximal orbit of period {p}.")
    return points, -0.5 / root * q
