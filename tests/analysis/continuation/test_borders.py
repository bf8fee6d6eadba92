"""Orbits held on borders of a map."""

import numpy as np
import pytest

from stickslip import PiecewiseMap
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.continuation.borders import Border, meet


@pytest.mark.parametrize("room", [0.1, 1e-17])
def test_an_orbit_is_met_however_narrow_the_range(room):
    """Differences over a share of a range narrower than rounding were divided by zero."""
    f = PiecewiseMap(
        lambda x, q: np.where(x < 0, 0.5 * x + q - 0.3, x * x + 1),
        (-2.0, 2.0),
        parameters={"q": 0.3},
        breakpoints=[0.0],
    )
    (jump,) = branch_table(f).breakpoints
    border = Border(0, TrackedDiscontinuity.of(jump), -1)
    found = meet(
        lambda q: f.replace(q=q), "q", np.array([0.0]), border, 0.3, 0.3 - room, 0.3 + room
    )
    assert found.value == pytest.approx(0.3, abs=1e-15)
