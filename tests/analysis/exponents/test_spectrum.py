"""Spectra against closed forms, plain iteration, published numbers and the tests of ChaosTools.jl.

Those are ``test/lyapunovs/discrete_lyapunov.jl`` and ``test/chaosdetection/lyapunovs.jl`` of
JuliaDynamics/ChaosTools.jl. Sprott's numbers: Chaos and Time-Series Analysis (2003), appendix A.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.analysis.known_maps import logistic
from tests.analysis.known_maps_nd import (
    delayed_logistic,
    henon,
    ikeda,
    kinked,
    linear,
    lozi,
    standard,
    towel,
)
from tests.sizes import sizes, slow

import stickslip as ss
from stickslip.analysis.attractors.lyapunov import lyapunov_exponent
from stickslip.analysis.exponents.spectrum import (
    ALIGNING,
    kaplan_yorke,
    lyapunov_spectra,
    lyapunov_spectrum,
)
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.analysis.scales import BLOCK
from stickslip.results.files import load, save

ROUNDING = 1e-12
SIGMAS = 5


def plain_spectrum(f, x, n, skip):
    """Exponents by NumPy's QR, a step at a time."""
    frame, sums = np.eye(len(x)), np.zeros(len(x))
    for k in range(skip + n):
        got = f.evaluate(x)
        x = got.value
        if k >= skip:
            frame, growth = np.linalg.qr(got.derivative @ frame)
            sums += np.log(np.abs(np.diag(growth)))
    return sums / n


def near(value, expected, error, rounded=0.0):
    return abs(value - expected) <= SIGMAS * error + rounded


# ------------------------------------------------------------------ closed forms


@settings(max_examples=25)
@given(n=st.integers(2, 5), seed=st.integers(0, 2**32))
def test_a_linear_map_has_the_logarithms_of_its_eigenvalues(n, seed):
    """The orbit from 0 stays there: a cycle, whose exponents are exact."""
    matrix = np.random.default_rng(seed).normal(size=(n, n))
    got = lyapunov_spectrum(linear(matrix), np.zeros(n), 20)
    expected = np.sort(np.log(np.abs(np.linalg.eigvals(matrix))))[::-1]
    np.testing.assert_allclose(got.values, expected, rtol=0, atol=1e-9)
    assert (got.errors == 0).all()


def test_a_damped_oscillator_looked_at_once_in_a_while():
    """x'' + 2 c x' + x = 0 after the time T: both exponents are -c T."""
    from scipy.linalg import expm

    c, T = 0.1, 0.7
    f = linear(expm(T * np.array([[0.0, 1.0], [-1.0, -2 * c]])))
    got = lyapunov_spectrum(f, [1.0, 0.0], 4000, transient=0)
    assert got.values == pytest.approx([-c * T, -c * T], abs=1e-3)  # not on a cycle yet: 1 / n
    assert got.values.sum() == pytest.approx(-2 * c * T, abs=ROUNDING)


def test_a_motion_in_time_with_saltation():
    """A block that slips on has the multipliers of its cycle; one that sticks forgets."""
    slips = ss.Oscillator(
        V=0.0, friction=ss.Coulomb(mu=0.01), damping=0.2, forcing=ss.Harmonic(5.0, 1.7)
    )
    f = ss.stroboscopic_map(slips)
    got = lyapunov_spectrum(f, [0.1, 0.2], 200, transient=200)
    cycle = f.periodic_point([0.1, 0.2])
    expected = np.log(np.abs(cycle.multipliers)) / cycle.period
    assert got.per_time == pytest.approx(np.sort(expected)[::-1], abs=1e-9)
    assert got.duration == pytest.approx(2 * np.pi / 1.7, rel=1e-12)
    weak = slips.replace(mu=0.5, forcing=ss.Harmonic(1.2, 0.7))
    got = lyapunov_spectrum(ss.stroboscopic_map(weak), [0.1, 0.0], 60, transient=60)
    assert got.values[1] == -np.inf


def test_directions_that_grow_and_shrink():
    """ChaosTools.jl, "analytic": x' = 1.1 x, y' = 0.8 y, 100 steps."""
    got = lyapunov_spectrum(linear(np.diag([1.1, 0.8])), [1.0, 1.0], 100, transient=20)
    assert got.values == pytest.approx(np.log([1.1, 0.8]), rel=1e-3)
    assert lyapunov_exponent(linear(0.9 * np.eye(3)), [0.3, 0.2, 0.7], 1000).value == (
        pytest.approx(np.log(0.9), rel=1e-3)
    )


def test_forgotten_directions_have_minus_infinity():
    shear = linear([[2.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.5]])
    got = lyapunov_spectrum(shear, [1e-9, 1e-9, 1e-9], 20, transient=0)
    assert got.values[:2] == pytest.approx(np.log([2.0, 0.5]), abs=0.1)
    assert got.values[2] == -np.inf
    assert got.errors[2] == 0.0


def test_a_direction_lost_in_the_rounding_of_another_one_is_not_told_to_be_forgotten():
    got = lyapunov_spectrum(linear(np.diag([1e14, 0.5, 0.25])), [0.0, 1.0, 1.0], 20, transient=0)
    assert got.values[0] == pytest.approx(14 * np.log(10), rel=0.1)
    assert np.isnan([*got.values[1:], got.dimension]).all()


def test_chaos_in_small_units_is_no_cycle():
    """At 1e-13 all points recur within 1e-12."""
    size = 1e-13
    small = ss.Map(
        lambda z: np.stack([size - 1.4 / size * z[..., 0] ** 2 + z[..., 1], 0.3 * z[..., 0]], -1), 2
    )
    got = lyapunov_spectrum(small, [0.1 * size, 0.1 * size], 3000)
    assert got.errors[0] > 0.0
    assert got.values == pytest.approx([0.41922, -1.62319], abs=4 * got.errors[0])


def test_volumes_shrink_by_the_determinant():
    for f, rate in ((henon(), np.log(0.3)), (lozi(), np.log(0.5)), (ikeda(), 2 * np.log(0.9))):
        got = lyapunov_spectrum(f, [0.1, 0.1], 3000)
        assert got.values.sum() == pytest.approx(rate, abs=ROUNDING)


@pytest.mark.parametrize("n", [500, BLOCK - ALIGNING + 1])  # a step in the last piece
def test_a_cycle_has_the_exponents_of_its_multipliers(n):
    f = henon(1.0)  # where a cycle of period 4 attracts
    (cycle,) = periodic_orbits(f, period=4).stable
    got = lyapunov_spectrum(f, [0.1, 0.1], n)
    expected = np.log(np.abs(cycle.multipliers)) / 4
    assert got.values == pytest.approx(expected, abs=ROUNDING)
    assert (got.errors == 0).all()
    assert (got.dimension, got.dimension_error) == (0.0, 0.0)


# ------------------------------------------------------------------ published numbers


@pytest.mark.parametrize(
    ("f", "start", "expected", "dimension"),
    [
        (henon(), (0.1, 0.1), (0.41922, -1.62319), 1.25827),
        *slow((lozi(), (-0.1, 0.1), (0.46987, -1.16302), 1.40401)),
        (ikeda(), (0.1, 0.1), (0.50760, -0.71832), 1.70665),
        *slow((delayed_logistic(2.27), (0.6, 0.6), (0.18312, -1.24199), 1.14744)),
    ],
    ids=["henon", "lozi", "ikeda", "delayed logistic"],
)
def test_sprotts_spectra_and_dimensions(f, start, expected, dimension):
    got = lyapunov_spectrum(f, start, 20_000)
    for value, error, known in zip(got.values, got.errors, expected, strict=True):
        assert near(value, known, error, 1e-4)
    assert near(got.dimension, dimension, got.dimension_error, 1e-4)
    assert 0.0 < got.dimension_error < 0.02


def test_the_henon_map_as_chaostools_has_it():
    def func(z, a, b):
        x, y = z[..., 0], z[..., 1]
        return np.stack([1 - a * x**2 + y, b * x], axis=-1)

    f = ss.Map(func, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-2, 2), (-2, 2)])
    got = lyapunov_spectrum(f, [0.0, 0.0], 1_000_000)
    assert 0.418 < got.values[0] < 0.422
    assert -1.63 < got.values[1] < -1.61
    largest = lyapunov_exponent(f, [0.0, 0.0], 1_000_000)
    assert 0.418 < largest.value < 0.422


@pytest.mark.parametrize("n", sizes(6000, 20_000))
def test_the_towel_map_as_chaostools_has_it(n):
    got = lyapunov_spectrum(towel(), [0.085, -0.121, 0.075], n)
    assert 0.42 < got.values[0] < 0.44
    assert 0.36 < got.values[1] < 0.38
    assert -3.4 < got.values[2] < -3.2
    largest = lyapunov_exponent(towel(), [0.085, -0.121, 0.075], n)
    assert 0.42 < largest.value < 0.44
    assert largest.value == pytest.approx(got.values[0], rel=1e-9)
    assert 2.0 < got.dimension < 3.0


def test_coupled_standard_maps_as_chaostools_has_them():
    """Exponents of a symplectic map come in pairs of the sum 0."""
    start = np.concatenate([0.1 + 0.9 * np.arange(5), 0.05 * np.arange(5)])
    got = lyapunov_spectrum(standard(1.3, 5, 0.4), start, 10_000)
    np.testing.assert_allclose(got.values + got.values[::-1], 0.0, rtol=0, atol=0.01)
    assert lyapunov_exponent(standard(1.3, 5, 0.4), start, 2000).value > 0
    assert got.dimension == pytest.approx(10.0, abs=0.2)


# ------------------------------------------------------------------ against plain iteration


@pytest.mark.parametrize(
    ("f", "x"),
    [(lozi(), [0.1, 0.1]), (kinked(0.3), [0.1, 0.1]), (standard(6.0), [0.3, 0.2])],
)
def test_plain_iteration_with_numpys_qr_agrees(f, x):
    got = lyapunov_spectrum(f, x, 3000, transient=200)
    expected = plain_spectrum(f, np.array(x), 3000, 200)
    np.testing.assert_allclose(got.values, expected, rtol=0, atol=2e-3)


def test_errors_are_the_spread_of_independent_orbits():
    starts = 0.1 + 0.01 * np.arange(16)
    found = [lyapunov_spectrum(henon(), [x, 0.1], 1500) for x in starts]
    values = np.array([one.values[0] for one in found])
    claimed = np.mean([one.errors[0] for one in found])
    assert 0.5 < values.std(ddof=1) / claimed < 2.0
    dimensions = np.array([one.dimension for one in found])
    claimed = np.mean([one.dimension_error for one in found])
    assert 0.5 < dimensions.std(ddof=1) / claimed < 2.0


def test_dimensions_of_given_exponents():
    def of(*values):
        return kaplan_yorke(np.array(values), np.tile(values, (4, 1)))[0]

    assert of(-1.0, -2.0) == 0.0
    assert of(1.0, -2.0) == 1.5
    assert of(1.0, 0.0, -4.0) == 2.25
    assert of(2.0, -1.0) == 2.0
    assert of(1.0, -np.inf) == 1.0
    assert np.isnan(of(np.nan, np.nan))


# ------------------------------------------------------------------ answers and refusals


def test_the_largest_exponents_of_several_orbits():
    starts = [[0.1, 0.1], [0.3, 0.1]]
    got = lyapunov_exponent(henon(), starts, 2000)
    single = lyapunov_spectrum(henon(), starts[1], 2000)
    assert got.value.shape == (2,)
    assert got.value[1] == pytest.approx(single.values[0], abs=ROUNDING)
    assert got.error[1] == pytest.approx(single.errors[0], rel=1e-6)


def test_an_orbit_that_leaves_has_no_exponents():
    got = lyapunov_spectrum(henon(), [5.0, 5.0], 100, transient=0)
    assert np.isnan(got.values).all()
    assert np.isnan([*got.errors, got.dimension, got.dimension_error]).all()
    assert np.isnan(lyapunov_exponent(henon(), [5.0, 5.0], 100).value)


def test_of_an_orbit_that_left_nothing_is_known():
    class Timed(ss.Map):
        period = 2.0

    got = lyapunov_spectrum(Timed(lambda z: z + 1, 1, domain=[(0, 5)]), [0.5], 9, transient=0)
    assert np.isnan([got.duration, got.dimension, *got.values]).all()


def test_spectra_along_a_parameter(tmp_path):
    got = lyapunov_spectra(henon(), "a", (1.0, 1.4, 5), [0.1, 0.1], 500)
    assert got.values.shape == (5, 2)
    assert got.values.sum(axis=1) == pytest.approx([np.log(0.3)] * 5, abs=ROUNDING)
    assert got.values[0, 0] < 0 < got.values[-1, 0]
    save(got, tmp_path / "spectra")
    assert load(tmp_path / "spectra") == got
    one = lyapunov_spectra(henon(), "a", [1.4], [0.1, 0.1], 500)
    assert one.at.tolist() == [1.4]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lyapunov_spectrum(logistic(4.0), [0.1]), "ss.lyapunov_exponent"),
        (lambda: lyapunov_spectrum(3, [0.1]), "neither a map of R"),
        (lambda: lyapunov_spectrum(henon(), [0.1]), "x0 = .* 2 numbers"),
        (lambda: lyapunov_spectrum(henon(), [[0.1, 0.1]]), "several points"),
        (lambda: lyapunov_spectrum(henon(), [9.0, 0.1]), "inside the map's domain"),
        (lambda: lyapunov_spectrum(henon(), [0.1, 0.1], 1), "n = 1"),
        (lambda: lyapunov_spectra(henon(), "c", (1, 2, 3), [0.1, 0.1]), "'c' is not a parameter"),
    ],
)
def test_what_is_wrong_is_said(call, words):
    with pytest.raises(ValueError, match=words):
        call()
