"""The global stick locus (eq. 6a) and the onset rule, for all legal parameters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.mechanics.model import locus

ALPHA = st.floats(0.0, 5.0)
BETA = st.floats(0.2, 3.0)
SHARE = st.floats(-1.0, 1.0)

MODEL = ss.examples.coulomb()  # alpha 1.2, beta 1.3

# Three roundings of numbers of size (1 + alpha) (1 + beta).
ROUNDING = 64 * np.finfo(float).eps


def spring_force(x, alpha):
    """The paper's equation (6a): R_i = X_i + alpha (X_i - X_j)."""
    x = np.asarray(x)
    return x + alpha * (x - x[..., ::-1])


def rides(x, alpha, beta):
    return bool((np.abs(spring_force(x, alpha)) < [1.0, beta]).all())


@given(alpha=ALPHA, beta=BETA, share=SHARE)
def test_onset_lies_on_the_first_upper_limit_and_inside_all_others(alpha, beta, share):
    d = share * locus.half_width(alpha, beta)
    x = locus.onset(d, alpha, beta)
    force = spring_force(x, alpha)
    room = np.array([1.0, beta]) - force
    assert abs(room.min()) <= ROUNDING  # one block stands at its upper limit
    assert np.all(force >= -np.array([1.0, beta]) - ROUNDING)  # no block is beyond its lower
    assert x[1] - x[0] == pytest.approx(d, abs=ROUNDING)


@given(alpha=ALPHA, beta=BETA, share=st.floats(-0.99, 0.99), back=st.floats(1e-3, 0.999))
def test_global_stick_before_the_onset_is_inside_the_locus(alpha, beta, share, back):
    x = locus.onset(share * locus.half_width(alpha, beta), alpha, beta)
    # Both forces fall by one for each unit that the belt is taken back.
    chord = np.min(spring_force(x, alpha) + np.array([1.0, beta]))
    assert rides(x - back * chord, alpha, beta)
    assert not rides(x - 1.001 * chord, alpha, beta)
    assert not rides(x + 1e-9, alpha, beta)


@given(alpha=ALPHA, beta=BETA)
def test_corners_stand_at_two_limits_and_project_on_the_domain(alpha, beta):
    corners = locus.corners(MODEL.replace(alpha=alpha, beta=beta).plant)
    force = spring_force(corners, alpha)
    np.testing.assert_allclose(np.abs(force), np.tile([1.0, beta], (4, 1)), rtol=0, atol=ROUNDING)
    d = corners[:, 1] - corners[:, 0]
    width = locus.half_width(alpha, beta)
    assert d.min() == pytest.approx(-width, abs=ROUNDING)
    assert d.max() == pytest.approx(width, abs=ROUNDING)
    a, b, c, _ = corners
    np.testing.assert_allclose(locus.onset(-width, alpha, beta), a, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(locus.onset(width, alpha, beta), c, rtol=0, atol=ROUNDING)
    both = (beta - 1.0) / (1.0 + 2.0 * alpha)
    np.testing.assert_allclose(locus.onset(both, alpha, beta), b, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("seed", range(20))
def test_the_domain_of_any_two_blocks_is_the_locus_projected(seed):
    """Some belts unload a block: a row of the stiffness then has a negative sum."""
    rng = np.random.default_rng(seed)
    k = rng.uniform(0.5, 3.0, 2)
    coupling = rng.uniform(-0.9, 0.9) * np.sqrt(k.prod())
    damping = np.diag(rng.uniform(0.0, 0.5, 2))
    static = rng.uniform(0.5, 2.0, 2)
    model = ss.Blocks(
        mass=rng.uniform(0.5, 2.0, 2),
        stiffness=[[k[0], coupling], [coupling, k[1]]],
        damping=damping,
        static=static,
        friction=ss.Coulomb(mu=0.3),
        V=rng.uniform(0.1, 0.5),
    )
    low, high = model.domain
    s = model.plant
    corners = locus.corners(s)
    forces = s.needed_force(corners, np.full((4, 2), s.V))
    np.testing.assert_allclose(np.abs(forces), np.tile(static, (4, 1)), rtol=1e-12)
    d = corners[:, 1] - corners[:, 0]
    np.testing.assert_allclose([d.min(), d.max()], [low, high], rtol=1e-12)
    assert {int(d.argmin()), int(d.argmax())} == {0, 2}
    drawn = model.sample_domain(1000, rng)
    assert drawn.shape == (1000,)
    assert model.contains(drawn).all()
    assert drawn.min() < low + 0.2 * (high - low)
    assert drawn.max() > high - 0.2 * (high - low)
    for end in (low, high):
        assert model.contains(end)
        assert not model.contains(end + (end - 0.5 * (low + high)) * 1e-12)
        assert model.admit(np.nextafter(end, 2 * end - 0.5 * (low + high))) == end
    with pytest.raises(ValueError, match=r"outside the global stick locus \[.* model\.domain"):
        model.admit(high + 0.1)


def test_onset_takes_any_shape():
    d = np.linspace(-0.5, 0.5, 6).reshape(2, 3)
    x = locus.onset(d, 1.2, 1.3)
    assert x.shape == (2, 3, 2)
    np.testing.assert_allclose(x[1, 2], locus.onset(d[1, 2], 1.2, 1.3), rtol=1e-14)


class TestAdmit:
    @pytest.mark.parametrize("ulp", range(-locus.ULP_SLACK, locus.ULP_SLACK + 1))
    @pytest.mark.parametrize("side", [-1.0, 1.0])
    def test_a_few_ulp_outside_count_as_the_end(self, ulp, side):
        width = locus.half_width(1.2, 1.3)
        d = side * (width + ulp * np.spacing(width))
        assert abs(MODEL.admit(d)) == min(width, abs(d))

    @pytest.mark.parametrize("share", [1 + 1e-14, -1 - 1e-14, 2.0, np.inf, -np.inf, np.nan])
    def test_outside_and_nan_are_errors(self, share):
        width = locus.half_width(1.2, 1.3)
        with pytest.raises(ValueError, match=r"outside the global stick locus \|d\| <= 0\.67647"):
            MODEL.admit(share * width)

    def test_the_first_bad_element_is_named(self):
        with pytest.raises(ValueError, match=r"^d\[1, 0\] = 0\.7012 .* model\.domain"):
            MODEL.admit([[0.0, 0.1], [0.7012, np.nan]])

    @pytest.mark.parametrize("d", ["0.1", 1j, True, None])
    def test_other_types_are_errors(self, d):
        with pytest.raises(ValueError, match="not made of real numbers"):
            MODEL.admit(d)

    def test_shape_and_values_are_kept(self):
        d = np.array([[0.1, -0.2, 0.3]])
        np.testing.assert_array_equal(MODEL.admit(d), d)
        assert MODEL.admit([]).shape == (0,)
        assert MODEL.admit(0) == 0.0

    def test_nothing_is_copied_but_what_kernels_are_not_compiled_for(self):
        d = np.linspace(-0.5, 0.5, 8)
        assert MODEL.admit(d) is d
        d.flags.writeable = False
        for points in (d, d[::2], d.astype(np.float32)):
            admitted = MODEL.admit(points)
            np.testing.assert_array_equal(admitted, points)
            assert admitted.flags.writeable
            assert admitted.flags.c_contiguous
