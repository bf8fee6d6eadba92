"""The brake with mode coupling: thresholds in closed form, cycles by another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from stickslip import studies
from stickslip.studies.mode_coupling.squeal import (
    LOAD,
    MODEL,
    cycles,
    flutter,
    flutter_frequency,
    kicked,
    motion,
    squeals,
    threshold,
    touching_kick,
    touching_point,
)
from stickslip.studies.smoothed import smoothed


def test_flutter_begins_where_the_formula_says() -> None:
    for damped, c in ((False, 0.0), (True, float(MODEL.damping[0, 0]))):
        found = flutter("constant", damped=damped)
        assert found.value == pytest.approx(threshold(c), rel=1e-12)
        rel = 1e-12 if damped else 1e-7  # a double eigenvalue has half of the digits
        assert abs(found.multipliers.imag).max() == pytest.approx(flutter_frequency(), rel=rel)


def period_by_steps(y: float, rate: float, load: float) -> tuple[float, float, float]:
    """From release to release by DOP853: y, y' and the time."""
    (a, b), (_, d) = MODEL.stiffness.tolist()
    c, V = float(MODEL.damping[0, 0]), MODEL.V

    def needed(z: np.ndarray) -> float:
        return c * V + a * z[0] + b * z[1]

    def slip(_: float, z: np.ndarray) -> list[float]:
        friction = 1.0 + load * z[1]
        return [
            *(z[2], z[3], friction - c * z[2] - a * z[0] - b * z[1]),
            -c * z[3] - b * z[0] - d * z[1],
        ]

    def stick(_: float, z: np.ndarray) -> list[float]:
        return [V, z[3], 0.0, -c * z[3] - b * z[0] - d * z[1]]

    def lands(t: float, z: np.ndarray) -> float:
        return z[2] - V if t > 0.1 else -1.0

    def leaves(_: float, z: np.ndarray) -> float:
        return needed(z) - 1.0 - load * z[1]

    lands.terminal = leaves.terminal = True  # type: ignore[attr-defined]
    settings = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    x = (1.0 + load * y - b * y - c * V) / a
    first = solve_ivp(slip, (0.0, 20.0), [x, y, V, rate], events=lands, **settings)
    start = first.y[:, -1] * [1, 1, 0, 1] + [0, 0, V, 0]
    second = solve_ivp(stick, (0.0, 20.0), start, events=leaves, **settings)
    return second.y[1, -1], second.y[3, -1], first.t[-1] + second.t[-1]


def test_both_cycles_come_back_by_another_integrator() -> None:
    found = cycles().curve.all_at(**{LOAD: 0.6})
    assert sorted(orbit.stable for orbit in found) == [False, True]
    for orbit in found:
        y, rate = orbit.points[0]
        end = period_by_steps(y, rate, 0.6)
        np.testing.assert_allclose(end[:2], [y, rate], rtol=0, atol=1e-9)
        assert end[2] == pytest.approx(motion(orbit).t[-1], rel=1e-9)


def test_the_unstable_branch_ends_on_the_ellipse_that_touches_stick() -> None:
    end = cycles().small_end
    assert end.value == pytest.approx(threshold(float(MODEL.damping[0, 0])), rel=1e-10)
    np.testing.assert_allclose(np.ravel(end.points), touching_point(), rtol=1e-6)
    assert all(orbit.period == 1 for orbit in cycles().curve)  # folds and this end are orbits, too


def test_a_kick_that_does_not_reach_stick_dies_out() -> None:
    floor = touching_kick(0.65)
    assert not kicked(0.65, 0.999 * floor).events
    assert kicked(0.65, 1.001 * floor).events
    assert squeals(kicked(0.65, 2.0 * floor))


def test_smooth_friction_comes_to_the_exact_motion_as_it_gets_narrow() -> None:
    orbit = cycles().here
    x, v, _ = orbit.system.state(orbit.points[0])
    exact = motion(orbit)
    apart = []
    for width in (1e-3, 1e-4, 1e-5):
        run = smoothed(orbit.system.model, width, x, v, exact.t[-1], rtol=1e-9)
        apart.append(np.abs(run.x - exact.x(run.t)).max())
    assert apart[0] > 3.0 * apart[1] > 9.0 * apart[2]


@pytest.mark.slow
def test_its_claims_hold() -> None:
    report = studies.check(source="mode_coupling")
    assert [claim.verdict for claim in report.claims] == ["holds"] * 6
    numbers = {value.name: value.computed for value in report.values}
    assert numbers["mu k_n of the onset"] == pytest.approx(0.4701110723655, rel=1e-12)
