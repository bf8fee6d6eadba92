"""The Taylor oracle is tested: against the closed forms, the equations and another solver."""

import numpy as np
import pytest
from flint import arb, ctx
from tests.reference import checks, law9
from tests.reference.coulomb import Coulomb
from tests.reference.law9 import Polynomial, Smooth
from tests.reference.laws import PoppStelter, Stribeck, Viscous
from tests.reference.motion import OK, sensitivity
from tests.sizes import slow

PAPER = Smooth(1.208, 1.301, 0.295, PoppStelter(3.0))


def random_systems(n, seed, v_max=0.3):
    rng = np.random.default_rng(seed)
    for _ in range(n):
        alpha, beta, V = (float(rng.uniform(*r)) for r in ((0.1, 3), (0.5, 2), (0.02, v_max)))
        gamma, delta, eta = (float(rng.uniform(*r)) for r in ((0.3, 4), (0, 0.5), (0, 0.1)))
        d = float(rng.uniform(-1, 1)) * (1 + beta) / (1 + 2 * alpha)
        yield Smooth(alpha, beta, V, PoppStelter(gamma, delta, eta)), d


@pytest.mark.parametrize(
    "law",
    [
        PoppStelter(3.0, 0.2, 0.1),
        Viscous(0.3, 0.1),
        Stribeck(0.4, 0.2, 0.05),
        Stribeck(0.4, 0.2, 0.05, 2),
    ],
)
def test_series_of_a_law_are_those_of_its_formula(law):
    # s(t) = 0.3 + 0.2 t - 0.1 t^2; all terms of F(s(t)) against F evaluated at a small t
    s = [arb(0.3), arb(0.2), arb(-0.1)] + [arb(0)] * 37
    coefficient = law.series()
    series = [coefficient(s[: k + 1]) for k in range(40)]
    t = arb("0.003")
    total = sum((c * t**k for k, c in enumerate(series)), arb(0))
    assert abs(total - law.force(s[0] + s[1] * t + s[2] * t * t)) < arb("1e-60")


def test_bounds_of_a_polynomial_hold():
    p = Polynomial([arb(c) for c in (0.5, -3.0, 2.0, 7.0, -11.0, 4.0)], arb(0.8))
    for k in range(81):
        value, slope, curvature = p.jet(arb(k) / 100)
        assert abs(curvature) <= p.bound(2)
        t = k / 100
        assert float(value) == pytest.approx(np.polyval([4, -11, 7, 2, -3, 0.5], t), abs=1e-13)
        assert float(slope) == pytest.approx(np.polyval([20, -44, 21, 4, -3], t), abs=1e-13)


def test_constant_friction_gives_the_closed_forms():
    rng = np.random.default_rng(8)
    compared = 0
    for _ in range(40):
        alpha, beta, mu, V = (
            float(rng.uniform(*r)) for r in ((0.1, 3), (0.5, 2), (0.05, 0.9), (0.005, 0.2))
        )
        d = float(rng.uniform(-1, 1)) * (1 + beta) / (1 + 2 * alpha)
        wanted = Coulomb(alpha, beta, V, mu).motion(d, max_events=30)
        if wanted.status != OK:
            continue
        found = Smooth(alpha, beta, V, Viscous(mu)).motion(d)
        assert found.itinerary == wanted.itinerary
        assert abs(found.value - wanted.value) < arb("1e-40")
        compared += 1
    assert compared > 30


@pytest.mark.parametrize("d", [0.0, 0.66, *slow(-0.3, 0.4)])
def test_without_weakening_law_9_is_coulomb_with_full_friction(d):
    # gamma = 0: touches of the belt at R = limit, outward, that do not stick
    smooth = Smooth(1.2, 1.3, 0.0366, PoppStelter(0.0)).motion(d, max_events=20)
    closed = Coulomb(1.2, 1.3, 0.0366, 1.0).motion(d, max_events=20)
    for a, b in zip(smooth.events, closed.events, strict=False):
        assert (a.before, a.after) == (b.before, b.after)
        assert all(abs(p - q) < arb("1e-20") for p, q in zip(a.x + a.v, b.x + b.v, strict=True))


def test_motions_obey_the_equations_and_the_limits():
    for system, d in [(PAPER, 0.3833), (PAPER, 0.1), *random_systems(12, seed=2, v_max=0.15)]:
        motion = system.motion(d, max_events=40)
        assert checks.worst_residual(system, motion) < 1e-18
        assert checks.worst_violation(system, motion, points=20) <= 1e-40
        if motion.status == OK:
            assert checks.energy_defect(system, motion) < 1e-12


def test_higher_order_and_precision_give_the_same_motion(monkeypatch):
    cases = [(PAPER, 0.3833), *random_systems(8, seed=3)]
    before = [system.motion(d, max_events=40) for system, d in cases]
    monkeypatch.setattr(law9, "ORDER", 64)
    monkeypatch.setattr(law9, "TRUNCATION", arb("1e-60"))
    monkeypatch.setattr(ctx, "prec", 400)
    after = [system.motion(d, max_events=40) for system, d in cases]
    for a, b in zip(before, after, strict=True):
        assert (a.status, a.itinerary) == (b.status, b.itinerary)
        if a.status == OK:
            assert abs(a.value - b.value) < arb("1e-38")


def test_ordinary_motions_agree_with_a_general_solver():
    compared = 0
    for system, d in [(PAPER, 0.1), *random_systems(12, seed=4, v_max=0.15)]:
        motion = system.motion(d, max_events=30)
        if motion.status != OK or motion.n_events > 20:
            continue
        limits = [float(limit) for limit in system.limits]
        law = system.laws[0]
        g, delta, eta = float(law.gamma), float(law.delta), float(law.eta)

        def kinetic(i, s, limits=limits, g=g, delta=delta, eta=eta):
            return limits[i] * ((1 - delta) / (1 + g * s) + delta + eta * s * s)

        # The onset is a double root: the other solver needs a push, good to about 1e-6.
        value, itinerary = checks.by_solve_ivp(system, d, kinetic, push=1e-9)
        assert itinerary == motion.itinerary
        assert abs(value - float(motion.value)) < 1e-6 * sensitivity(system, d, motion)[1]
        compared += 1
    assert compared > 5
