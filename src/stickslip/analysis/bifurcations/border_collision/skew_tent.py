"""The attractor of the normal form of a corner: a x + mu left of 0, b x + mu right of it.

Exact, by a renormalisation (docs/theory/bifurcations.md). Sources: Nusse and Yorke, Physica D 57,
39 (1992) and Int. J. Bifurcation Chaos 5, 189 (1995); Maistrenko, Maistrenko and Chua, Int. J.
Bifurcation Chaos 3, 1557 (1993); Banerjee, Karthik, Yuan and Yorke, IEEE Trans. Circuits Syst. I
47, 389 (2000); Sushko, Avrutin and Gardini, J. Difference Equ. Appl. 22, 1040 (2016). With a square
root: Nordmark, Phys. Rev. E 55, 266 (1997); Chin, Ott, Nusse and Grebogi, PRE 50, 4427 (1994).
"""

from __future__ import annotations

import math
from typing import Final

from stickslip.analysis.bifurcations.outcome import LocalAttractor
from stickslip.checks import MOST_KEPT

NONE: Final = LocalAttractor("none")
UNDECIDED: Final = LocalAttractor("undecided")


def attractor_of_skew_tent(a: float, b: float, side: int = 1) -> LocalAttractor:
    """Return the attractor of a x + mu (x < 0), b x + mu (x > 0), side the sign of mu."""
    if side < 0:
        a, b = b, a
    if math.isnan(a) or math.isnan(b) or b == -1.0:
        return UNDECIDED
    if b >= 1.0:
        return NONE  # right of 0 every point moves on to the right
    if b > -1.0:
        return LocalAttractor("periodic", 1)
    if a <= 0.0:  # a homeomorphism, so there are periods 1 and 2 only
        doubled = a > -1.0 and (a == 0.0 or a * b < 1.0)
        return LocalAttractor("periodic", 2) if doubled else NONE
    if (a - 1.0) * (-b - 1.0) > 1.0 and a > 1.0:
        return NONE  # the corner's second image is left of the unstable fixed point
    if math.isinf(b):  # a falling square root: the orbits L^n R, n without bound
        if a > 2 / 3:  # chaos at once
            return LocalAttractor("chaotic")
        return LocalAttractor("period-incrementing", base=1, offset=1)
    return _of_folded_map(a, b)


def _of_folded_map(a: float, b: float) -> LocalAttractor:
    """Attractor for a > 0, b < -1, if there is one: by renormalisation."""
    n = _steps_to_return(a, b)
    if n == 0:
        return UNDECIDED
    left, right = a ** (n - 1) * b, a ** (n - 2) * b * b
    if left == -1.0:
        return UNDECIDED
    if left > -1.0:
        return LocalAttractor("periodic", n)
    if (right - 1.0) * (-left - 1.0) > 1.0:
        return LocalAttractor("chaotic", 1)
    inner = _of_folded_map(right, left)
    return LocalAttractor(inner.kind, n * inner.period)


def _steps_to_return(a: float, b: float) -> int:
    """Return n, the last index up to which the images c_2, c_3, ... of the corner are negative."""
    # For a >= 1 only n = 2 can be renormalised. 0: too many steps, or an image on the corner.
    if a >= 1.0:
        return 2
    c, n = 1.0 + b, 2
    while True:
        c = a * c + 1.0
        if c > 0.0:
            return n
        n += 1
        if c == 0.0 or n > MOST_KEPT:
            return 0


def paired_side(a: float, b: float) -> int:
    """Return the sign of mu with both fixed points, mu / (1 - a) <= 0 <= mu / (1 - b), or 0."""
    if (1.0 - a) * (1.0 - b) > 0.0:
        return 0
    return 1 if a > b else -1


def doubled_side(a: float, b: float) -> int:
    """Return the sign of mu with a cycle of period 2, mu (1 + b) / (1 - a b) < 0 (Feigin), or 0."""
    if not (1.0 + a) * (1.0 + b) < 0.0:
        return 0
    product = 0.0 if 0.0 in (a, b) else a * b
    rising = (1.0 + a > 0.0) == (1.0 - product > 0.0)
    return 1 if rising else -1
