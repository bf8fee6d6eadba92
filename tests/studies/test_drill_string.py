"""The drill string: Hopf point in closed form, cycles that never stick by another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip import follow, periodic_orbits, return_map, studies
from stickslip.studies.drill_string.string import (
    BELOW,
    DRIVE,
    ELEMENTS,
    INVERSE,
    LAW,
    MODEL,
    STATIC,
    computed_hopf,
    computed_long_hopf,
    cycles,
    drive_at,
    hopf,
    long_cycles,
    long_end,
    long_hopf,
    long_string,
    rotation,
    smooth_motions,
    stick_end,
    stick_slip,
    swing_left,
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
    drive = drive_at(cycle)

    def rates(_: float, z: np.ndarray) -> np.ndarray:
        friction = STATIC * LAW.force(float(z[2]))
        return np.asarray(MODEL.A @ z + [0.0, drive, -INVERSE * friction])

    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    run = solve_ivp(rates, (0.0, cycle.period), cycle.x, **settings)
    assert run.y[2].min() > 0.0
    np.testing.assert_allclose(run.y[:, -1], cycle.x, rtol=0, atol=1e-10)


def test_the_curve_of_cycles_lands_at_the_edge_of_the_map_and_ends_at_the_hopf_point() -> None:
    assert stick_end().value == pytest.approx(37.194052062, rel=1e-10)
    landing, vanishing = cycles().bifurcations
    assert landing.value == pytest.approx(stick_end().value, rel=1e-9)
    assert vanishing.value == pytest.approx(hopf()[0], rel=1e-12)
    assert stick_slip().stable.all()


def test_smooth_friction_ends_stick_slip_too_early() -> None:
    exact, runs = smooth_motions()
    assert stick_slip().at(**{DRIVE: BELOW * stick_end().value}).stable
    assert swing_left(runs[2]) < 1e-6 * exact
    assert swing_left(runs[3]) == pytest.approx(exact, rel=0.02)


def test_one_element_without_damping_is_the_two_discs() -> None:
    one = long_string(30.0, 1)
    np.testing.assert_allclose(one.B, MODEL.B, rtol=1e-14)
    damping = one.A - MODEL.A
    assert np.abs(damping[:, 0]).max() < 1e-14  # a third of the string is in the lower disc
    assert one.A[1:, 0] == pytest.approx([-0.2, 2.0], rel=1e-14)


@pytest.mark.parametrize("n", [1, ELEMENTS])
def test_a_continued_fraction_tells_where_eigenvalues_cross(n: int) -> None:
    assert computed_long_hopf(n) == pytest.approx(long_hopf(n), rel=1e-12)


def test_stick_slip_of_many_elements_comes_back_by_another_integrator() -> None:
    cycle = long_cycles()[-1]
    model = cycle.model
    first, second = cycle.events
    sticks_first = first.kind.startswith("slip")
    phases = ((first.time, sticks_first), (second.time, not sticks_first))

    def slipping(_: float, z: np.ndarray) -> np.ndarray:
        return model.A @ z + model.a - model.B[:, 0] * STATIC * LAW.force(abs(float(z[-1])))

    def sticking(_: float, z: np.ndarray) -> np.ndarray:
        rate = model.A @ z + model.a
        rate[-1] = 0.0
        return rate

    z, since = np.array(cycle.x), 0.0
    for end, sticks in (*phases, (cycle.period, sticks_first)):
        if end > since:
            rule = sticking if sticks else slipping
            run = solve_ivp(rule, (since, end), z, "DOP853", rtol=1e-11, atol=1e-12)
            z, since = run.y[:, -1], end
    np.testing.assert_allclose(z, cycle.x, rtol=0, atol=1e-7)


def test_stick_slip_of_two_discs_ends_where_the_edge_of_their_map_is() -> None:
    f = return_map(long_string(30.0, 1), direction="forward", domain=(0.0, 20.0))
    (orbit,) = periodic_orbits(f, max_period=1)
    (edge,) = (end for end in follow(orbit, DRIVE, (29.0, 35.0)).ends if end.reason == "gap")
    assert 0.0 <= edge.value / long_end(1) - 1.0 < 1e-3


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="drill_string")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 5
