"""Maps of R^n by a user's function: values, derivatives and pieces against plain NumPy."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.analysis.maps.protocol import UNDEFINED, FamilyND, apart
from stickslip.numerics.point_function import point_function

EXACT = 1e-13  # recorded formulas against their function
DIFFERENCE = 1e-7  # central differences of the test with steps of 1e-6
NUMERIC = 1e-9  # extrapolated differences
TURN = 2 * math.pi


def henon(z, a, b):
    return np.stack([1 - a * z[..., 0] ** 2 + z[..., 1], b * z[..., 0]], axis=-1)


def lozi(z, a, b):
    x, y = z.T
    return np.array([1 - a * np.abs(x) + y, b * x]).T


def border(z, mu, jump):
    x, y = np.moveaxis(z, -1, 0)
    right = x >= 0
    tau = np.where(right, -1.5, 0.5)
    return np.stack([tau * x + y + mu + jump * right, -0.25 * x], axis=-1)


def standard(z, K):
    p = z[..., 1] + K / TURN * np.sin(TURN * z[..., 0])
    return np.stack([z[..., 0] + p, p], axis=-1)


def ikeda(z, u):
    x, y = z[..., 0], z[..., 1]
    t = 0.4 - 6 / (1 + x * x + y * y)
    return np.stack(
        [1 + u * (x * np.cos(t) - y * np.sin(t)), u * (x * np.sin(t) + y * np.cos(t))], axis=-1
    )


def lattice(z, a, coupling):
    f = 1 - a * z**2
    sides = np.roll(f, 1, axis=-1) + np.roll(f, -1, axis=-1)
    return (1 - coupling) * f + coupling / 2 * sides


def matrix(z, c):
    turned = z @ np.array([[1.0, 2.0], [3.0, 4.0]]).T
    out = np.zeros_like(z)
    out[..., 0] = np.where(~(z[..., 0] > c) | (turned[..., 1] <= 0), z[..., 0], c)
    out[..., 1] = np.minimum(turned[..., 1], np.maximum(z[..., 1], -c)) + np.sign(z[..., 0])
    return out


def folded(z, k):
    return np.mod(z * k, 1.0) + np.floor(z) - (z < 0.5) * (z > 0.25)


def oscillator(z, amplitude):
    """A forced pendulum after a period, by 4 steps of Runge and Kutta."""

    def rate(x, v, t):
        return v, -0.2 * v - np.sin(x) + amplitude * np.cos(t)

    x, v = z[..., 0], z[..., 1]
    h = TURN / 4
    for k in range(4):
        x1, v1 = rate(x, v, k * h)
        x2, v2 = rate(x + h / 2 * x1, v + h / 2 * v1, (k + 0.5) * h)
        x3, v3 = rate(x + h / 2 * x2, v + h / 2 * v2, (k + 0.5) * h)
        x4, v4 = rate(x + h * x3, v + h * v3, (k + 1) * h)
        x = x + h / 6 * (x1 + 2 * x2 + 2 * x3 + x4)
        v = v + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
    return np.stack([x, v], axis=-1)


SYSTEMS = {
    henon: (2, {"a": 1.4, "b": 0.3}),
    lozi: (2, {"a": 1.7, "b": 0.5}),
    border: (2, {"mu": -0.1, "jump": 0.3}),
    standard: (2, {"K": 0.9}),
    ikeda: (2, {"u": 0.9}),
    lattice: (5, {"a": 1.7, "coupling": 0.2}),
    matrix: (2, {"c": 0.3}),
    folded: (1, {"k": 3.3}),
    oscillator: (2, {"amplitude": 0.7}),
}


@pytest.fixture(params=SYSTEMS, ids=lambda func: func.__name__)
def system(request):
    dimension, parameters = SYSTEMS[request.param]
    return request.param, ss.Map(request.param, dimension, parameters=parameters)


def _points(f, n=40):
    return np.random.default_rng(1).normal(size=(n, f.dimension))


def _numeric(func):
    """The same function, in a way that cannot be recorded."""

    def plain(z, **parameters):
        return func(z if z.dtype.kind == "c" else z.astype(np.float64), **parameters)

    return plain


def test_a_recorded_function_has_its_own_values(system):
    func, f = system
    assert f.engine == "compiled"
    assert isinstance(f, FamilyND)
    x = _points(f)
    assert np.allclose(f(x), func(x, **f.parameters), rtol=EXACT, atol=EXACT)
    assert np.allclose(f(x[0]), func(x[0], **f.parameters), rtol=EXACT, atol=EXACT)
    assert f.evaluate(x.reshape(2, 20, -1)).value.shape == (2, 20, f.dimension)


def test_derivatives_of_recorded_functions_are_exact(system):
    func, f = system
    x, h = _points(f), 1e-6
    with np.errstate(all="ignore"):
        slopes = [
            (func(x + h * e, **f.parameters) - func(x - h * e, **f.parameters)) / (2 * h)
            for e in np.eye(f.dimension)
        ]
    assert np.allclose(f.derivative(x), np.stack(slopes, axis=-1), rtol=DIFFERENCE, atol=DIFFERENCE)
    for name, value in f.parameters.items():
        more, less = (func(x, **{**f.parameters, name: value + s * h}) for s in (1, -1))
        rate = (more - less) / (2 * h)
        near = np.isclose(f.parameter_derivative(x, name), rate, rtol=DIFFERENCE, atol=DIFFERENCE)
        assert near.mean() > 0.95  # a step across a piece's end tells nothing


@pytest.mark.parametrize("func", [henon, ikeda, lattice])
def test_functions_that_are_not_recorded_are_differentiated_numerically(func):
    dimension, parameters = SYSTEMS[func]

    def plain(z, **parameters):
        return func(np.asarray(z, dtype=np.float64), **parameters)  # takes no formula

    exact = ss.Map(func, dimension, parameters=parameters)
    for f in (
        ss.Map(plain, dimension, parameters=parameters),
        ss.Map(_numeric(func), dimension, parameters=parameters),
    ):
        assert f.engine.startswith("NumPy: ")
        x = _points(f)
        assert np.allclose(f.derivative(x), exact.derivative(x), rtol=NUMERIC, atol=NUMERIC)
        for name in parameters:
            rate = f.parameter_derivative(x, name)
            exactly = exact.parameter_derivative(x, name)
            assert np.allclose(rate, exactly, rtol=NUMERIC, atol=NUMERIC)


def test_comparisons_inside_the_function_name_its_pieces():
    f = ss.Map(border, 2, parameters={"mu": 0.1, "jump": 0.0})
    left, left_too, right = f.evaluate([[-0.5, 0.0], [-0.1, 2.0], [0.5, 0.0]]).label
    assert left == left_too != right
    own = ss.Map(border, 2, parameters={"mu": 0.1, "jump": 0.0}, label=lambda z, mu, jump: 7)
    assert (own.evaluate([[-0.5, 0.0], [0.5, 0.0]]).label == 7).all()


def test_a_comparison_may_choose_between_whole_points():
    def func(z, mu, jump):
        left, right = (z * [a, 0.5] + [mu + a * jump, 0.0] for a in (0.4, -3.0))
        return np.where((z[..., 0] > 0)[..., None], right, left)

    f = ss.Map(func, 2, parameters={"mu": 0.1, "jump": 0.2})
    assert f.engine == "compiled"
    x = np.random.default_rng(0).uniform(-1, 1, (50, 2))
    np.testing.assert_allclose(f(x), func(x, 0.1, 0.2), rtol=EXACT)
    np.testing.assert_allclose(f(x[0]), func(x[0], 0.1, 0.2), rtol=EXACT)


@given(st.lists(st.floats(-3, 3), min_size=2, max_size=2), st.integers(-3, 3), st.integers(-3, 3))
def test_angles_do_not_feel_whole_turns(x, i, j):
    f = ss.Map(standard, 2, parameters={"K": 0.9}, periodic=[1.0, 1.0])
    turned = np.array(x) + np.array([i, j])
    value, moved = f(x), f(turned)
    assert ((value >= 0) & (value < 1)).all()
    assert np.abs(apart(f, value, moved)).max() < EXACT
    assert f.contains(turned)


def test_orbits_of_a_map_with_angles_are_found_and_followed_across_the_turn():
    """Two fixed points (0, 0), (1/2, 0) with traces 2 ± K, and their preimages none."""
    f = ss.Map(standard, 2, parameters={"K": 0.9}, periodic=[1.0, 1.0])
    found = ss.periodic_orbits(f, 2, n_starts=256)
    traces = sorted(float(orbit.multipliers.sum().real) for orbit in found.of_period(1))
    assert np.allclose(traces, [2 - 0.9, 2 + 0.9], rtol=1e-12, atol=EXACT)
    for orbit in found:
        assert np.prod(orbit.multipliers).real == pytest.approx(1.0, abs=1e-10)  # area is kept
    centre = next(o for o in found.of_period(1) if o.multipliers[0].imag)
    assert np.abs(apart(f, centre.points, np.array([[0.5, 0.0]]))).max() < EXACT
    curve = ss.follow(centre, "K", (0.5, 3.9))
    assert curve.end_reasons == ("end of range", "end of range")


def test_fixed_points_of_the_henon_map_and_their_fold():
    f = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-3, 3), (-1, 1)])
    fixed = ss.periodic_orbits(f)
    exact = [(-0.7 + s * math.sqrt(0.49 + 5.6)) / 2.8 for s in (-1, 1)]
    assert np.allclose([orbit.points[0, 0] for orbit in fixed], exact, rtol=1e-12, atol=EXACT)
    curve = ss.follow(fixed[1], "a", (-1.0, 2.0))
    fold = next(b for b in curve.bifurcations if b.kind == "fold")
    assert fold.value == pytest.approx(-0.49 / 4, abs=1e-10)  # -(1 - b)^2 / 4


def test_gaps_and_domains():
    def root(z, a):
        return np.stack([np.sqrt(z[..., 0] - a), z[..., 1]], axis=-1)

    f = ss.Map(root, 2, parameters={"a": 0.0}, domain=[(-1, 1), None])
    values = f.evaluate([[-0.5, 3.0], [0.25, 3.0]])
    assert values.status.tolist() == [UNDEFINED, 0]
    assert np.isnan(values.value[0]).all()
    assert values.value[1].tolist() == [0.5, 3.0]
    assert f.contains([[2.0, 0.0], [0.0, 1e9], [math.nan, 0.0]]).tolist() == [False, True, False]
    with pytest.raises(ValueError, match="outside the domain"):
        f([2.0, 0.0])
    with pytest.raises(ValueError, match="no bounds"):
        f.spread(4)
    orbit = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-2, 2)] * 2).iterate(
        [[0.0, 0.0], [1.9, 1.9]], 4
    )
    assert np.isfinite(orbit[0]).all()
    assert np.isnan(orbit[1, 2:]).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"func": lambda z: z[..., 0]}, "shape"),
        ({"func": lambda z: z / 0 if z.ndim > 9 else [][0]}, "IndexError"),
        ({"dimension": 0}, "dimension = 0"),
        ({"domain": [(0, 1)]}, "must hold 2 entries"),
        ({"domain": [(1, 0), None]}, "lo < hi"),
        ({"periodic": [0.0, None]}, r"periodic\[0\] = 0"),
        ({"jacobian": 3}, "jacobian = 3"),
    ],
)
def test_what_is_no_map_is_refused(arguments, message):
    usual = {"func": lambda z: z, "dimension": 2, "parameters": {}}
    with pytest.raises(ValueError, match=message):
        ss.Map(**(usual | arguments))


@pytest.mark.parametrize("wrong", [-1.0, 2.0, math.nan, math.inf, "transposed"])
def test_a_jacobian_that_is_not_that_of_the_values_is_refused(wrong):
    known = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3})
    given = {"parameters": known.parameters, "domain": [(-2, 2)] * 2}

    def jacobian(z, a, b):
        return known.replace(a=a, b=b).derivative(z)

    def other(z, a, b):
        right = jacobian(z, a, b)
        return np.swapaxes(right, -1, -2) if wrong == "transposed" else wrong * right

    z = [0.3, 0.2]
    assert np.array_equal(
        ss.Map(henon, 2, jacobian=jacobian, **given).derivative(z), known.derivative(z)
    )
    with pytest.raises(ValueError, match=r"jacobian\[0, [01]\] is .* differences of func tell 1"):
        ss.Map(henon, 2, jacobian=other, **given)


def test_a_jacobian_that_leaves_a_parameter_out_is_refused_where_it_moves():
    known = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}, domain=[(-2, 2)] * 2)
    f = ss.Map(
        henon,
        2,
        parameters=known.parameters,
        domain=[(-2, 2)] * 2,
        jacobian=lambda z, a, b: known.replace(a=a).derivative(z),
    )
    assert f.replace(a=1.3) != f
    with pytest.raises(ValueError, match=r"jacobian\[1, 0\] is .* differences of func tell 0.2"):
        f.replace(b=0.2)


def test_maps_are_immutable_values():
    f = ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3})
    assert f == ss.Map(henon, 2, parameters={"a": 1.4, "b": 0.3}) != f.replace(a=1.3)
    assert hash(f) == hash(f.replace(a=1.4))
    assert repr(f) == "Map(henon, 2, a=1.4, b=0.3; compiled)"
    with pytest.raises(ValueError, match="Did you mean 'a'"):
        f.replace(A=1.0)
    assert point_function(henon, 2, ("a", "b")).n_operations < 12
