"""The global stick locus (eq. 6a) and the onset rule, for all legal parameters."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stickslip.mechanics.model import locus

ALPHA = st.floats(0.0, 5.0)
BETA = st.floats(0.2, 3.0)
SHARE = st.floats(-1.0, 1.0)

# Three roundings of numbers of size (1 + alpha) (1 + beta).
ROUNDING = 64 * np.finfo(float).eps


@given(alpha=ALPHA, beta=BETA, share=SHARE)
def test_onset_lies_on_the_first_upper_limit_and_inside_all_others(alpha, beta, share):
    d = share * locus.half_width(alpha, beta)
    x = locus.onset(d, alpha, beta)
    force = locus.spring_force(x, alpha)
    room = np.array([1.0, beta]) - force
    assert abs(room.min()) <= ROUNDING  # one block stands at its upper limit
    assert np.all(force >= -np.array([1.0, beta]) - ROUNDING)  # no block is beyond its lower
    assert x[1] - x[0] == pytest.approx(d, abs=ROUNDING)


@given(alpha=ALPHA, beta=BETA, share=st.floats(-0.99, 0.99), back=st.floats(1e-3, 0.999))
def test_global_stick_before_the_onset_is_inside_the_locus(alpha, beta, share, back):
    x = locus.onset(share * locus.half_width(alpha, beta), alpha, beta)
    # Both forces fall by one for each unit that the belt is taken back.
    chord = np.min(locus.spring_force(x, alpha) + np.array([1.0, beta]))
    assert locus.contains(x - back * chord, alpha, beta)
    assert not locus.contains(x - 1.001 * chord, alpha, beta)
    assert not locus.contains(x + 1e-9, alpha, beta)


@given(alpha=ALPHA, beta=BETA)
def test_corners_stand_at_two_limits_and_project_on_the_domain(alpha, beta):
    corners = locus.corners(alpha, beta)
    force = locus.spring_force(corners, alpha)
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


@given(alpha=ALPHA, x=st.tuples(st.floats(-3, 3), st.floats(-3, 3)))
def test_displacement_undoes_spring_force(alpha, x):
    force = locus.spring_force(x, alpha)
    np.testing.assert_allclose(locus.displacement(force, alpha), x, rtol=0, atol=30 * ROUNDING)


def test_spring_force_is_the_papers_equation_6a():
    x1, x2, alpha = 0.3, -0.4, 1.2
    expected = [x1 + alpha * (x1 - x2), x2 + alpha * (x2 - x1)]
    np.testing.assert_allclose(locus.spring_force([x1, x2], alpha), expected, rtol=1e-15)


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
        assert abs(locus.admit(d, 1.2, 1.3)) == min(width, abs(d))

    @pytest.mark.parametrize("share", [1 + 1e-14, -1 - 1e-14, 2.0, np.inf, -np.inf, np.nan])
    def test_outside_and_nan_are_errors(self, share):
        width = locus.half_width(1.2, 1.3)
        with pytest.raises(ValueError, match=r"outside the global stick locus \|d\| <= 0\.67647"):
            locus.admit(share * width, 1.2, 1.3)

    def test_the_first_bad_element_is_named(self):
        with pytest.raises(ValueError, match=r"^d\[1, 0\] = 0\.7012 .* model\.domain"):
            locus.admit([[0.0, 0.1], [0.7012, np.nan]], 1.2, 1.3)

    @pytest.mark.parametrize("d", ["0.1", 1j, True, None])
    def test_other_types_are_errors(self, d):
        with pytest.raises(ValueError, match="not made of real numbers"):
            locus.admit(d, 1.2, 1.3)

    def test_shape_and_values_are_kept(self):
        d = np.array([[0.1, -0.2, 0.3]])
        np.testing.assert_array_equal(locus.admit(d, 1.2, 1.3), d)
        assert locus.admit([], 1.2, 1.3).shape == (0,)
        assert locus.admit(0, 1.2, 1.3) == 0.0

    def test_nothing_is_copied_but_what_kernels_are_not_compiled_for(self):
        d = np.linspace(-0.5, 0.5, 8)
        assert locus.admit(d, 1.2, 1.3) is d
        d.flags.writeable = False
        for points in (d, d[::2], d.astype(np.float32)):
            admitted = locus.admit(points, 1.2, 1.3)
            np.testing.assert_array_equal(admitted, points)
            assert admitted.flags.writeable
            assert admitted.flags.c_contiguous
