"""The shaken block, the faster belt and the one at rest: what their claims rest on."""

from __future__ import annotations

import pytest

from stickslip import studies
from stickslip.studies.forced_belt.claims import exponent, shaken


def test_the_shaken_block_locks_to_its_forcing() -> None:
    f = shaken(1.0)
    cycle = f.periodic_point([0.0, 0.0])
    assert cycle.period == pytest.approx(f.period, rel=1e-12)
    assert cycle.stable


def test_one_exponent_of_three_kinds_of_motion() -> None:
    values = [exponent(frequency, 200)[0] for frequency in (1.0, 0.4, 0.76)]
    assert values[0] < -0.3
    assert values[1] == pytest.approx(0.0, abs=2e-3)
    assert values[2] > 0.02


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "number"), [("forced_belt", 2), ("fast_belt", 2), ("quasistatic", 3)]
)
def test_their_claims_hold(name: str, number: int) -> None:
    report = studies.check(source=name)
    assert [claim.verdict for claim in report.claims] == ["holds"] * number
