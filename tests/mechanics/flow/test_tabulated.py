"""Motions with friction given by points: each knot ends a step and changes nothing else."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import stickslip as ss
from stickslip.mechanics.flow.engine import sliding_kernels
from stickslip.mechanics.friction.code import law_code

TABLE = ss.TabulatedFriction([0, 0.05, 0.2, 0.5, 1.5], [1, 0.7, 0.45, 0.4, 0.55])
# One law of the user's known by its values only, beside which two blocks move by collocation,
# and known as a formula.
VALUES = ss.friction_law(lambda s: 0.4 if s < 0 else 0.3 + 0.7 / (1 + 4 * s))
FORMULA = ss.friction_law(lambda s: 0.3 + 0.7 / (1 + 4 * s))
D = np.linspace(-0.6, 0.6, 25)
ROUNDING = 1e-13
ORACLE = 2e-11  # of an eighth-order Runge-Kutta method with rtol = 1e-13
DIFFERENCES = 1e-8


def two_blocks(law, V=0.1):
    return ss.TwoBlock(alpha=1.2, beta=1.3, V=V, friction=law)


def test_a_straight_table_is_viscous_coulomb_friction():
    table = ss.TabulatedFriction([0.0, 50.0], [0.2, 5.2])
    f, g = (ss.event_map(two_blocks(law)) for law in (table, ss.Coulomb(0.2, viscous=0.1)))
    np.testing.assert_allclose(f(D), g(D), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(f.derivative(D), g.derivative(D), rtol=0, atol=ROUNDING)


@settings(max_examples=15)
@given(knots=st.sets(st.integers(1, 1200), min_size=1, max_size=6))
def test_knots_on_a_straight_line_change_nothing(knots):
    speed = np.array([0.0, *sorted(k / 997 for k in knots), 50.0])
    plain, knotted = (ss.TabulatedFriction(s, 0.2 + 0.1 * s) for s in (speed[[0, -1]], speed))
    f, g = ss.event_map(two_blocks(plain)), ss.event_map(two_blocks(knotted))
    np.testing.assert_allclose(g(D), f(D), rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(g.derivative(D), f.derivative(D), rtol=0, atol=10 * ROUNDING)


@pytest.mark.parametrize("off", [0.0, 1e-15, -1e-15, 1e-13, -1e-13, 1e-11, -1e-9, 1e-6])
def test_a_speed_that_just_reaches_a_knot(off):
    """The force is kinked there; what a touch of depth h adds is of order h^1.5."""
    plain = ss.TabulatedFriction([0.0, 50.0], [0.2, 5.2])
    x, v = np.array([0.2]), np.array([0.05])
    motion = ss.simulate(ss.Oscillator(V=0.1, friction=plain), x, v, t_end=3.0)
    fastest = np.abs(motion.v(np.linspace(0, 3, 200_001)) - 0.1).max() + off
    bent = ss.TabulatedFriction([0.0, fastest], [0.2, 0.2 + 0.1 * fastest])
    other = ss.simulate(ss.Oscillator(V=0.1, friction=bent), x, v, t_end=3.0)
    t = np.linspace(0, 3, 40)
    depth = max(-off, 1e-9)
    assert np.abs(other.x(t) - motion.x(t)).max() < ROUNDING + depth**1.5
    assert [e.block for e in other.events] == [e.block for e in motion.events]


def test_free_slips_follow_an_independent_integration():
    """A block thrown backward through all pieces of the table and back, without a stick."""
    V, x0, v0, t_end = 0.6, 0.9, -1.2, 2.3
    motion = ss.simulate(ss.Oscillator(V=V, friction=TABLE), [x0], [v0], t_end=t_end)
    assert len(motion.events) == 0
    curve = PchipInterpolator(TABLE.speeds, TABLE.forces)

    def rate(t, y):
        return [y[1], -y[0] + curve(min(V - y[1], TABLE.speeds[-1]))]

    def crossing(knot):
        def signal(t, y):
            return V - y[1] - knot

        signal.terminal = True
        return signal

    signals = [crossing(knot) for knot in TABLE.knots]
    t, y, crossings = 0.0, [x0, v0], 0
    while t < t_end:
        leg = solve_ivp(
            rate, (t, t_end), y, "DOP853", rtol=1e-13, atol=1e-15, events=signals, max_step=0.05
        )
        t, y = leg.t[-1], leg.y[:, -1]
        if leg.status == 1:  # over the knot by a Taylor step
            crossings += 1
            dt = 1e-7
            y = y + dt * np.array(rate(t, y))
            t += dt
    assert crossings == 3  # the last one is a touch from above
    assert motion.x(t_end)[0] == pytest.approx(y[0], abs=ORACLE)


@pytest.mark.parametrize("law", [TABLE, pytest.param((TABLE, VALUES), marks=pytest.mark.slow)])
def test_slopes_are_those_of_differences(law):
    f = ss.event_map(two_blocks(law))
    result = f.evaluate(D)
    h = 1e-6
    safe = (result.margin > 1e-4) & (np.abs(D) < 0.59)
    assert safe.sum() > 12
    slope = (f(D + h) - f(D - h)) / (2 * h)
    np.testing.assert_allclose(
        result.derivative[safe], slope[safe], rtol=DIFFERENCES, atol=DIFFERENCES
    )


def test_two_blocks_are_a_chain_of_two():
    f = ss.event_map(two_blocks(TABLE))
    g = ss.event_map(ss.Chain(static=[1, 1.3], alpha=1.2, V=0.1, friction=TABLE))
    np.testing.assert_allclose(g(D), f(D), rtol=0, atol=ROUNDING)


@pytest.mark.slow  # two sets of kernels that no other test needs
def test_steppers_agree():
    """The same table where the other block's law has no series: collocation against series."""
    f, g = (ss.event_map(two_blocks((TABLE, law))) for law in (VALUES, FORMULA))
    np.testing.assert_allclose(f(D), g(D), rtol=0, atol=1e-11)


def test_energy_is_balanced():
    motion = ss.simulate(two_blocks(TABLE), d=0.1, t_end=300)
    assert np.ptp(motion.energy(np.linspace(0, 300, 200)).balance) < 1e-12


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("low", "high", "falls"),
    [(0.0, 0.89, False), (0.91, 3.9, False), (0.0, 4.0, True), (0.5, 0.9005, True), (3, 9, False)],
)
def test_the_proof_of_sliding_sees_a_narrow_dent(low, high, falls):
    dented = ss.TabulatedFriction([0, 0.9, 0.901, 4.0], [0.1, 0.28, 0.25, 0.9])
    code = law_code([dented])
    least_slope = sliding_kernels(code).least_slope
    assert bool(least_slope(code.parameter_rows([dented]), 0, low, high) < 0.0) is falls
