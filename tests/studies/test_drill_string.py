"""The drill string: Hopf point in closed form, cycles that never stick by another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip import studies
from stickslip.studies.drill_string.string import (
    BELOW,
    DRIVE,
    INVERSE,
    LAW,
    MODEL,
    STATIC,
    computed_hopf,
    hopf,
    rotation,
    smooth_motions,
    stick_end,
    stick_slip,
    turning,
)


def test_rotation_changes_its_stability_where_a_pair_crosses_the_axis() -> None:
    drive, speed, frequency = hopf()
    assert computed_hopf().value == pytest.approx(drive, rel=1e-12)
    assert float(rotation(drive).w[0]) == pytest.approx(speed, rel=1e-12)
    matrix = np.array(MODEL.A)
    matrix[2, 2] -= INVERSE * STATIC * LAW.slope(speed)
    pair = np.linalg.eigvals(matrix)
    pair = pair[pair.imag > 0.0]
    assert abs(pair.real[0]) < 1e-13
    assert pair.imag[0] == pytest.approx(frequency, rel=1e-12)


@pytest.mark.parametrize("which", [3, 15, -3])
def test_a_cycle_that_never_sticks_comes_back_by_another_integrator(which: int) -> None:
    cycle = turning()[which]

    def rates(_: float, z: np.ndarray) -> np.ndarray:
        friction = STATIC * LAW.force(float(z[2]))
        return np.asarray(MODEL.A @ z + [0.0, cycle.drive, -INVERSE * friction])

    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    run = solve_ivp(rates, (0.0, cycle.period), cycle.state, **settings)
    assert run.y[2].min() >= cycle.state[2] * (1.0 - 1e-9)
    np.testing.assert_allclose(run.y[:, -1], cycle.state, rtol=0, atol=1e-10)


def test_both_branches_end_at_one_drive() -> None:
    assert stick_end().value == pytest.approx(37.194052062, rel=1e-10)
    # The last cycle's slowest speed is 1e-7 of that of rotation, not 0.
    assert turning()[-1].drive == pytest.approx(stick_end().value, rel=2e-7)
    assert stick_slip().stable.all()


def test_smooth_friction_ends_stick_slip_too_early() -> None:
    exact, runs = smooth_motions()
    assert stick_slip().at(**{DRIVE: BELOW * stick_end().value}).stable
    assert runs[2].swing < 1e-6 * exact
    assert runs[3].swing == pytest.approx(exact, rel=0.02)


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="drill_string")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 4
