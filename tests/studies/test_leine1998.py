"""The oscillator of Leine and others: its period by an integration with 30 digits."""

from __future__ import annotations

from functools import partial

import mpmath as mp
import pytest

from stickslip import studies
from stickslip.studies.leine1998.claims import PERIOD, undamped

DIGITS = 30


def series(x: mp.mpf, s: mp.mpf, speed: mp.mpf, order: int) -> tuple[list, list]:
    """Taylor coefficients of X and of the slip speed s: X' = V - s, s' = X - 1 / (1 + 3 s)."""
    xs, ss, force = [x], [s], [1 / (1 + 3 * s)]
    for k in range(order):
        xs.append(((speed if k == 0 else 0) - ss[k]) / (k + 1))
        ss.append((xs[k] - force[k]) / (k + 1))
        products = (3 * ss[j] * force[k + 1 - j] for j in range(1, k + 2))
        force.append(-mp.fsum(products) / (1 + 3 * s))
    return xs, ss


def value(row: list, u: mp.mpf) -> mp.mpf:
    """Sum of a series at u."""
    return mp.fsum(c * u**k for k, c in enumerate(row))


def period() -> mp.mpf:
    """Slip from X = 1 until s = 0 again, then ride back to X = 1."""
    speed, order, room = mp.mpf(1) / 5, int(1.3 * DIGITS), mp.mpf(10) ** (-DIGITS - 2)
    x, s, t = mp.mpf(1), mp.mpf(0), mp.mpf(0)
    while True:
        xs, ss = series(x, s, speed, order)
        h = mp.mpf("0.8") * min(
            (room / abs(row[k])) ** (mp.mpf(1) / k) for row in (xs, ss) for k in (order, order - 1)
        )
        end = value(ss, h)
        if end <= 0 and t > 1:
            u = mp.findroot(partial(value, ss), h / 2, tol=room)
            return t + u + (1 - value(xs, u)) / speed
        x, s, t = value(xs, h), end, t + h


def test_the_period_without_damping_to_30_digits() -> None:
    with mp.workdps(DIGITS):
        exact = period()
        assert abs(exact - mp.mpf(PERIOD)) < mp.mpf(10) ** (4 - DIGITS)
    assert abs(undamped().period - float(exact)) < 1e-13


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="leine1998")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 3
    numbers = {value.name: value.computed for value in report.values}
    assert numbers["c of the Hopf point"] == pytest.approx(3 / 1.6**2, abs=1e-12)
    assert numbers["c of the fold"] == pytest.approx(1.300882299088, abs=2e-12)
