"""Steady sliding: where it is, its eigenvalues, the speed at which brakes begin to squeal."""

from __future__ import annotations

import numpy as np
import pytest
from tests.sizes import sizes

import stickslip as ss
from stickslip.mechanics.cycle.hopf import FollowedModes
from stickslip.mechanics.cycle.sliding import force_derivatives


def test_one_block_in_closed_form() -> None:
    """y'' + (c + F'(V)) y' + y = 0."""
    law = ss.PoppStelter(gamma=3, delta=0.2, eta=0.1)
    model = ss.Oscillator(V=0.4, friction=law, damping=0.05)
    (found,) = ss.equilibria(model)
    assert found.x[0] == pytest.approx(law.force(0.4), abs=1e-15)
    slope = 0.05 + law.slope(0.4)
    root = np.sqrt(complex(slope**2 / 4 - 1))
    np.testing.assert_allclose(
        found.eigenvalues, [-slope / 2 + root, -slope / 2 - root], rtol=1e-14
    )
    assert not found.stable
    (critical,) = found.critical_speeds
    assert law.slope(critical) == pytest.approx(-0.05, abs=1e-11)
    (beyond,) = ss.equilibria(model.replace(V=1.01 * critical))
    assert beyond.stable


def test_constant_friction_without_damping_is_neutral() -> None:
    (found,) = ss.equilibria(ss.examples.coulomb())
    assert found.neutral
    assert not found.stable
    np.testing.assert_allclose(np.sort(found.eigenvalues.imag)[2:], [1.0, np.sqrt(3.4)], rtol=1e-14)
    assert found.critical_speeds.size == 0
    assert "neutral" in repr(found)


@pytest.mark.parametrize(
    ("damping", "word"), [(0.0, "neutral"), (1e-3, "stable"), (-1e-3, "unstable")]
)
@pytest.mark.parametrize("coupling", [0.0, 0.3, 1e12])
def test_a_slow_mode_keeps_its_stability_beside_fast_ones(damping, word, coupling):
    """The third body is faster by 1e10; the first two swing against each other, too."""
    beside = np.array([[1.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0, 0.0, 0.0]])
    model = ss.Structure(
        mass=[1, 2, 1e-7],
        stiffness=np.diag([1.0, 3.0, 1e13]) + coupling * beside,
        damping=damping * np.diag([1, 1, 1e-7]),
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=1.0)],
    )
    (found,) = ss.equilibria(model)
    assert f", {word}" in repr(found)
    slow = found.eigenvalues[np.argmin(abs(found.eigenvalues))]
    matrix = np.diag([1.0, 3.0]) / [[1], [2]] + coupling * beside[:2, :2] / [[1], [2]]
    frequency = np.sqrt(np.linalg.eigvals(matrix).min())
    assert abs(slow.imag) == pytest.approx(frequency, rel=1e-6 if coupling < 1.0 else 1e-3)


@pytest.mark.parametrize("n_plants", sizes(60, 2000))
def test_random_plants_without_damping_are_neutral(n_plants: int) -> None:
    """Springs and whirling forces, which do no work, of rates apart by up to 1e3."""
    rng = np.random.default_rng(5)
    for _ in range(n_plants):
        n = int(rng.integers(1, 6))
        spread, turned = 10.0 ** rng.uniform(-1.5, 1.5, n), rng.normal(size=(n, n))
        bent, heavy = rng.normal(size=(n, n)) * spread, rng.normal(size=(n, n))
        model = ss.Structure(
            mass=heavy @ heavy.T + 0.1 * np.eye(n),
            stiffness=bent.T @ bent + np.diag(spread**2),
            damping=turned - turned.T,
            contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=1.0)],
        )
        (found,) = ss.equilibria(model)
        assert found.neutral, found
        assert not found.eigenvalues.real.any()


def test_small_motions_grow_as_the_eigenvalues_say() -> None:
    model = ss.Chain(
        static=[1, 1.3], alpha=1.2, V=1.5, friction=ss.PoppStelter(gamma=1), damping=0.02
    )
    (found,) = ss.equilibria(model)
    x = found.x + 1e-7 * np.array([1.0, -0.5])
    t = np.linspace(0, 30, 7)
    motion = ss.simulate(model, x, np.zeros(2), t_end=30)
    s = model.plant
    slopes = s.damping + np.diag(s.static * model.friction.slope(1.5))  # type: ignore[union-attr]
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-s.stiffness, -slopes]])
    values, vectors = np.linalg.eig(matrix)
    start = np.linalg.solve(vectors, np.concatenate([x - found.x, np.zeros(2)]))
    expected = ((vectors * start) @ np.exp(np.outer(values, t))).real[:2].T
    np.testing.assert_allclose(motion.x(t) - found.x, expected, rtol=0, atol=2e-12)
    np.testing.assert_allclose(
        np.sort(found.eigenvalues.imag), np.sort(values.imag), rtol=0, atol=1e-12
    )


def test_forced_models_have_none() -> None:
    model = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.4), forcing=ss.Harmonic(0.1, 1.0))
    with pytest.raises(ValueError, match="no equilibrium"):
        ss.equilibria(model)


def test_where_a_damped_block_begins_to_squeal() -> None:
    """F = 1/(1 + 3 s): damping c is outweighed below c (1 + 3 V)^2 = 3 (Leine et al. 1998)."""
    model = ss.Oscillator(V=0.4, friction=ss.PoppStelter(gamma=3), damping=1.171875)
    (found,) = ss.equilibria(model)
    (point,) = found.hopf_points
    assert found.stable
    assert point.V == pytest.approx(0.2, abs=1e-15)
    assert point.frequency == pytest.approx(1.0, abs=1e-14)
    assert point.crossing == pytest.approx(-0.5 * 18 / 1.6**3, rel=1e-9)
    # Averaging over one period: a' = -F''' a^3 / 16 for y'' + y = ... - F''' y'^3 / 6.
    assert point.lyapunov == pytest.approx(6 * 27 / 1.6**4 / 16, rel=1e-11)
    assert point.criticality == "sub"
    assert point.changes_stability
    assert np.isnan(point.amplitude(0.19))
    assert ss.equilibria(model, speeds=(0.3, 1.0))[0].hopf_points == ()


def test_amplitudes_at_onset_follow_the_lyapunov_coefficient() -> None:
    """Two coupled modes, laws with curvature: 1 / a^2 falls by 2 lyapunov per unit of time."""
    model = ss.Blocks(
        mass=[1, 2],
        stiffness=[[2.2, -1.2], [-1.2, 3.1]],
        damping=[[0.3, 0], [0, 0.5]],
        static=[1, 1.3],
        friction=[ss.PoppStelter(gamma=2), ss.PoppStelter(gamma=3, delta=0.1)],
        V=0.3,
    )
    slow, fast = ss.equilibria(model)[0].hopf_points
    assert (slow.changes_stability, fast.changes_stability) == (False, True)
    assert slow.criticality == fast.criticality == "sub"
    motion = ss.simulate(fast.model, *fast.state(0.04), t_end=60 * fast.period)
    t = np.linspace(0, fast.period, 400, endpoint=False)
    block = int(np.argmax(np.abs(fast.mode)))
    sizes = [
        0.5 * float(np.ptp(motion.x(start + t)[:, block]))
        for start in (20 * fast.period, 59 * fast.period)
    ]
    fall = (sizes[0] ** -2 - sizes[1] ** -2) / (39 * fast.period)
    assert fast.lyapunov is not None
    assert fall == pytest.approx(2 * fast.lyapunov, rel=0.03)


def test_a_mode_crosses_beside_one_that_neither_grows_nor_decays() -> None:
    """F = 1/(1 + 3 s) feeds the first block alone; the other one slides undamped."""
    squealing, neutral = ss.PoppStelter(gamma=3), ss.Coulomb(mu=0.3)
    model = ss.Blocks(
        mass=[1, 1],
        stiffness=np.diag([1.0, 0.5]),
        damping=np.diag([0.5, 0.0]),
        static=[1, 1],
        friction=[squealing, neutral],
        V=0.3,
    )
    (alone,) = ss.equilibria(ss.Oscillator(V=0.3, damping=0.5, friction=squealing))[0].hopf_points
    (found,) = ss.equilibria(model)
    (point,) = found.hopf_points
    for name in ("V", "frequency", "crossing", "lyapunov"):
        assert getattr(point, name) == pytest.approx(getattr(alone, name), rel=1e-9), name
    assert alone.changes_stability
    assert point.changes_stability  # from growing to neutral
    np.testing.assert_array_equal(found.critical_speeds, [point.V])
    curve = ss.follow(found, "V", (0.2, 0.8))
    assert "eigenvalue" in repr(curve)  # of the flow: those of maps are multipliers
    (hopf,) = curve.bifurcations
    assert hopf.value == pytest.approx(alone.V, rel=1e-12)
    assert "frequency 1, calms" in repr(hopf)


@ss.friction_law
def flat_then_rising(s: float) -> float:
    """Constant up to s = 0.8, as far as small motions feel."""
    return 0.3 + 0.1 * max(s - 0.8, 0.0) ** 2


def test_a_mode_crosses_beside_one_that_is_neutral_in_part_of_the_range() -> None:
    """The second block slides undamped below V = 0.8, and damped above."""
    squealing = ss.PoppStelter(gamma=3)
    model = ss.Blocks(
        mass=[1, 1],
        stiffness=np.diag([1.0, 0.5]),
        damping=np.diag([0.5, 0.0]),
        static=[1, 1],
        friction=[squealing, flat_then_rising],
        V=0.3,
    )
    (point,) = ss.equilibria(model, speeds=(0.1, 2.0))[0].hopf_points
    assert point.V == pytest.approx((np.sqrt(6.0) - 1.0) / 3.0, rel=1e-12)  # 3 = c (1 + 3 V)^2
    assert point.frequency == pytest.approx(1.0, rel=1e-12)
    (hopf,) = ss.follow(ss.equilibria(model)[0], "V", (0.2, 1.5)).bifurcations
    assert hopf.value == pytest.approx(point.V, rel=1e-12)


def test_points_are_told_apart_that_lie_closer_than_their_growth_rates_show() -> None:
    """Two blocks that do not feel each other, one damped more by 1e-9."""
    law = ss.PoppStelter(gamma=3)
    damping = np.array([0.5, 0.5 + 1e-9])
    model = ss.Blocks(
        mass=[1, 1],
        stiffness=np.diag([1.0, 2.0]),
        damping=np.diag(damping),
        static=[1, 1],
        friction=law,
        V=0.3,
    )
    points = ss.equilibria(model)[0].hopf_points
    speeds = (np.sqrt(3.0 / damping) - 1.0) / 3.0
    np.testing.assert_allclose([point.V for point in points], speeds[::-1], rtol=1e-13)
    np.testing.assert_allclose(
        [point.frequency for point in points], [np.sqrt(2.0), 1.0], rtol=1e-8
    )


def test_modes_that_are_neutral_between_two_values_do_not_cross_there() -> None:
    """They part on both sides of p = 0."""

    def eigenvalues(p: float) -> np.ndarray:
        upper = 1j + np.sqrt(complex(p**2 - 0.3**2)) * np.array([1.0, -1.0])
        return np.concatenate([upper, upper.conj()])

    assert FollowedModes(eigenvalues, np.arange(-5.4, 6.0)).crossings() == []


def test_hopf_points_are_looked_for_when_they_are_asked_for(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    model = ss.Oscillator(V=0.4, friction=ss.PoppStelter(gamma=3), damping=0.5)
    (found,) = ss.equilibria(model, speeds=(0.1, 1.0))
    curve = ss.follow(found, "damping", (0.4, 0.6))
    searches: list[object] = []

    def noted(*given: object) -> tuple[object, ...]:
        searches.append(given)
        return ()

    monkeypatch.setattr("stickslip.mechanics.cycle.equilibria.hopf_points", noted)
    assert curve.at(damping=0.55).stable == (0.55 * 2.2**2 > 3.0)
    assert not searches
    assert found.hopf_points == found.hopf_points == ()
    assert searches == [(model, (0.1, 1.0))]


def test_two_modes_may_cross_at_one_speed() -> None:
    """Equal blocks but for their limits: damping (d, -d), which time reversal and a swap keep."""
    law = ss.PoppStelter(gamma=3, delta=0.2, eta=0.1)
    model = ss.Chain(static=[1, 1.3], alpha=1.2, V=1.5, friction=law, damping=0.05)
    points = ss.equilibria(model)[0].hopf_points
    assert len(points) == 2
    assert points[0].V == points[1].V
    assert len(ss.equilibria(model)[0].critical_speeds) == 1


@pytest.mark.parametrize("speeds", [(0.0, 1.0), (2.0, 1.0), (0.1, np.inf), 3.0])
def test_a_range_of_speeds_is_checked(speeds: object) -> None:
    with pytest.raises(ValueError, match="speeds"):
        ss.equilibria(ss.examples.law9(), speeds=speeds)  # type: ignore[arg-type]


@pytest.mark.parametrize("share", [0.999, 1.001])
def test_a_neutral_family_ends_where_a_motion_grazes(share: float) -> None:
    """Just inside its boundary no block ever sticks; just outside one does."""
    model = ss.examples.coulomb().replace(V=0.3)
    family = ss.equilibria(model)[0].neutral_family
    assert family is not None
    for mode in range(2):
        x = family.x + share * family.boundary[mode] * family.modes[:, mode]
        assert family.clearance(x, [0, 0]) == pytest.approx(0.3 * (1 - share), abs=1e-13)
        events = ss.simulate(model, x, [0, 0], t_end=20).events
        assert bool(events) == (share > 1)
    together = family.x + 0.45 * share * (family.modes * family.boundary).sum(axis=1)
    assert family.clearance(together, [0, 0]) > 0
    assert not ss.simulate(model, together, [0, 0], t_end=200).events


def test_a_diagonal_mass_may_be_given_as_a_matrix() -> None:
    contacts = [ss.Contact(at=k, friction=ss.Coulomb(mu=0.3), V=0.1) for k in (0, 1)]
    families = [
        ss.equilibria(ss.Structure(mass, [[2, -1], [-1, 2]], contacts=contacts))[0].neutral_family
        for mass in (np.array([1.0, 2.0]), np.diag([1.0, 2.0]))
    ]
    assert families[0] is not None
    assert families[1] is not None
    np.testing.assert_allclose(families[1].frequencies, families[0].frequencies, rtol=1e-14)
    assert families[1].V == 0.1


def test_other_models_have_no_neutral_family() -> None:
    assert ss.equilibria(ss.examples.law9())[0].neutral_family is None
    damped = ss.examples.coulomb().replace(damping=0.1)
    assert ss.equilibria(damped)[0].neutral_family is None


def test_a_measured_law_has_the_derivatives_of_the_piece_that_holds() -> None:
    law = ss.TabulatedFriction(speed=[0, 0.1, 0.4, 1.0, 2.0], force=[0.98, 0.7, 0.5, 0.4, 0.45])
    step = 1e-3
    for V in (0.05, 0.3, 0.7, 1.5, 3.0):
        block = ss.Oscillator(V=V, friction=law)
        (derivatives,) = force_derivatives(block, V)
        below, here, above = law.slope([V - step, V, V + step])
        assert derivatives[0] == pytest.approx(here, abs=1e-14)
        # the slope is a parabola: its differences are exact
        assert derivatives[1] == pytest.approx((above - below) / (2 * step), abs=1e-9)
        assert derivatives[2] == pytest.approx((above - 2 * here + below) / step**2, abs=1e-6)


def test_a_block_under_a_measured_law_begins_to_squeal_where_the_law_falls_faster() -> None:
    law = ss.TabulatedFriction(speed=[0, 0.1, 0.4, 1.0, 2.0], force=[0.98, 0.7, 0.5, 0.4, 0.45])
    (found,) = ss.equilibria(ss.Oscillator(V=0.3, friction=law, damping=0.1))
    assert not found.stable
    for V in found.critical_speeds:
        assert law.slope(V) == pytest.approx(-0.1, abs=1e-9)


def test_thomsen_and_fidlin_s_onset_is_told_along_the_speed_of_a_contact():
    """J. J. Thomsen, A. Fidlin, Int. J. Non-Linear Mech. 38 (2003) 389-403: a cubic law."""
    limit, least, fast, damping = 0.4, 0.25, 0.5, 0.05  # damping: twice it is the coefficient
    law = ss.friction_law(
        "1 - drop * (1.5 * s / fast - 0.5 * (s / fast) ** 3)",
        parameters={"drop": 1.0 - least / limit, "fast": fast},
    )
    contact = ss.Contact(at=0, friction=law, static=limit, V=0.3)
    model = ss.Structure([1.0], [1.0], [2.0 * damping], contacts=[contact])
    (sliding,) = ss.equilibria(model)
    with pytest.raises(ValueError, match=r"V_1\. Take the bifurcations of stickslip\.follow"):
        _ = sliding.hopf_points  # none would be wrong
    (onset,) = ss.follow(sliding, "V_1", (0.1, 0.9)).bifurcations
    expected = fast * np.sqrt(1.0 - 4.0 * damping * fast / (3.0 * (limit - least)))
    assert onset.value == pytest.approx(expected, rel=1e-13)
