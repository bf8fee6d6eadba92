"""No answer depends on the units of coordinates and parameters."""

from functools import cache

import numpy as np
import pytest

import stickslip as ss

EXACT = [(2.0**-30, 2.0**-30), (2.0**20, 2.0**-40)]  # powers of 1024
ANY = [(1e-9, 1e-9), (1e-9, 1e9), (2.0**20, 2.0**-25), (1e-12, 1.0)]


def henon(z, a, b):
    """Hénon's map."""
    x, y = z[..., 0], z[..., 1]
    return np.stack([1 - a * x**2 + y, b * x], axis=-1)


def hidden(z, a, b):
    """Hénon's map, that no formula is known of."""
    return henon(np.array(z, dtype=np.float64), a, b)


def broken(z, a, b):
    """Corner, and a jump where a is not 0, at x = 0: the normal form of border collisions."""
    x, y = z[..., 0], z[..., 1]
    right = x >= 0.0
    tau = np.where(right, -1.5, 0.5)
    return np.stack([tau * x + y + b + np.where(right, a, 0.0), -0.25 * x], axis=-1)


def plane(func, units, **parameters):
    """Make a map of the plane whose coordinates are in units."""
    units = np.asarray(units)
    return ss.Map(
        lambda z, **p: func(z / units, **p) * units,
        2,
        parameters=parameters,
        domain=[(-4.0 * unit, 4.0 * unit) for unit in units],
    )


@cache
def orbits(func, units):
    """What is known of orbits of Hénon's map, without units."""
    most = {henon: 4, hidden: 2}[func]
    found = ss.periodic_orbits(plane(func, units, a=1.4, b=0.3), most, n_starts=32)
    assert len(found) == {henon: 4, hidden: 3}[func]
    return of_orbits(found, units)


def of_orbits(found, units):
    """What is known of orbits, without units."""
    return [(o.period, o.points / units, o.multipliers) for o in found]


def agree(found, wanted, rtol):
    """Compare what is known of orbits."""
    assert len(found) == len(wanted)
    for one, other in zip(found, wanted, strict=True):
        assert one[0] == other[0]
        for a, b in zip(one[1:], other[1:], strict=True):
            np.testing.assert_allclose(a, b, rtol=rtol, atol=rtol)


@pytest.mark.parametrize("func", [henon, hidden])
@pytest.mark.parametrize("units", [*EXACT, *ANY])
def test_orbits_of_the_plane_are_the_same_in_any_units(func, units):
    exact = units == EXACT[0] and func is henon
    agree(orbits(func, units), orbits(func, (1.0, 1.0)), 0.0 if exact else 1e-8)


@pytest.mark.parametrize("units", [*EXACT, *ANY])
def test_attractors_of_the_plane_are_the_same_in_any_units(units):
    for a in (0.9, 1.4):
        wanted, found = (
            ss.attractors(plane(henon, each, a=a, b=0.3), n_starts=8)
            for each in ((1.0, 1.0), units)
        )
        assert [(one.kind, one.period) for one in found] == [(o.kind, o.period) for o in wanted]
        assert found.left == wanted.left
        for one, other in zip(found, wanted, strict=True):
            off = abs(one.lyapunov.value - other.lyapunov.value)
            assert off <= 1e-8 + 4 * other.lyapunov.error


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("units", ANY[1:3])
def test_orbits_of_a_random_map_with_a_border_are_the_same_in_any_units(units, seed):
    rng = np.random.default_rng(seed)
    left, right, shift = rng.normal(size=(2, 2)), rng.normal(size=(2, 2)), rng.normal(size=2)

    def random(z):
        side = (z[..., 0] < 0.1)[..., None]
        return 0.3 * shift + 0.8 * np.where(side, z @ left.T, z @ right.T)

    wanted = ss.periodic_orbits(plane(random, (1.0, 1.0)), 3, n_starts=32)
    found = ss.periodic_orbits(plane(random, units), 3, n_starts=32)
    agree(of_orbits(found, units), of_orbits(wanted, 1.0), 1e-9)


@pytest.mark.parametrize("units", [*EXACT, *ANY])
def test_curves_of_the_plane_are_the_same_in_any_units(units):
    def events(units):
        f = plane(henon, units, a=0.2, b=0.3)
        orbit = ss.periodic_orbits(f, period=1, n_starts=16)[-1]
        curve = ss.follow(orbit, "a", (-0.2, 0.5))
        return curve, [(item.kind, item.value, item.error) for item in curve.bifurcations]

    (one, found), (other, wanted) = events(units), events((1.0, 1.0))
    assert [item[0] for item in found] == [item[0] for item in wanted] == ["fold", "flip"]
    np.testing.assert_allclose([i[1] for i in found], [i[1] for i in wanted], rtol=1e-9)
    # Nor is an event known less well.
    np.testing.assert_allclose([i[2] for i in found], [i[2] for i in wanted], rtol=63, atol=0)
    assert len(one) == pytest.approx(len(other), rel=0.2)
    assert [end.reason for end in one.ends] == [end.reason for end in other.ends]


@pytest.mark.parametrize("units", [*EXACT, *ANY])
@pytest.mark.parametrize(("jump", "kind"), [(0.0, "corner"), (1e-5, "jump")])
def test_what_ends_a_curve_of_the_plane_is_the_same_in_any_units(units, jump, kind):
    f = plane(broken, units, a=jump, b=-0.2)
    orbit = ss.periodic_orbits(f, period=1, n_starts=16)[0]
    end = ss.follow(orbit, "b", (-0.3, 0.2)).ends[1]
    assert (end.reason, end.kind) == ("breakpoint", kind)
    assert abs(end.value) <= end.error <= 1e-10


@pytest.mark.parametrize("units", [EXACT[1], ANY[1]])
def test_bifurcations_of_the_plane_are_the_same_in_any_units(units):
    def found(units):
        f = plane(henon, units, a=0.3, b=0.3)
        listed = ss.bifurcations(f, "a", (0.3, 0.5), max_period=2, n_lists=2, n_starts=16)
        curve = ss.follow(listed[0], "b", (0.2, 0.4), solve_for="a")
        return [(b.kind, b.period, b.criticality) for b in listed], listed[0].value, curve

    one, other = found(units), found((1.0, 1.0))
    assert one[0] == other[0] == [("flip", 1, "super")]
    assert one[1] == pytest.approx(other[1], rel=1e-12)
    a, b = one[2].parameters["a"], one[2].parameters["b"]
    np.testing.assert_allclose(a, 0.75 * (1 - b) ** 2, rtol=1e-9)
    assert len(a) == pytest.approx(len(other[2]), rel=0.2)


# ------------------------------------------------------------------ on a line

FAMILIES = {
    "logistic": (lambda u, r: r * u * (1 - u), lambda u, r: r * (1 - 2 * u), (0, 1), 3.5),
    "cubic": (lambda u, r: r * u - u**3, lambda u, r: r - 3 * u**2, (-2, 2), 2.2),
    "kink": (
        lambda u, r: np.where(u < 0, 0.4 * u, -1.7 * u) + r,
        lambda u, r: np.where(u < 0, 0.4, -1.7) + 0 * u,
        (-1, 1),
        0.1,
    ),
    "jump": (
        lambda u, r: 0.6 * u + r + np.where(u < 0, 0.4, -0.5),
        lambda u, r: 0.6 + 0 * u,
        (-1, 1),
        0.1,
    ),
    "gap": (
        lambda u, r: np.where((u > 0.1) & (u < 0.25), np.nan, 1 - r * u * u),
        lambda u, r: -2 * r * u,
        (-1, 1),
        1.6,
    ),
}
UNITS = [(2.0**-30, 2.0**20), (1e-9, 1e9), (1e9, 1e-9), (2.0**15, 2.0**-15)]


def line(name, unit, of_parameter, given):
    """Make a map of a line in units, with a derivative if it is given."""
    func, slope, (low, high), r = FAMILIES[name]
    return ss.PiecewiseMap(
        lambda x, r: unit * func(x / unit, r / of_parameter),
        (low * unit, high * unit),
        parameters={"r": r * of_parameter},
        derivative=(lambda x, r: slope(x / unit, r / of_parameter)) if given else None,
    )


@cache
def known(name, unit, of_parameter, given):
    """What is known of a map of a line, without units."""
    f = line(name, unit, of_parameter, given)
    listed, basins = ss.periodic_orbits(f, 6), ss.basins(f)
    attractors = basins.attractors
    return (
        [(o.period, o.points / unit, np.array([o.multiplier])) for o in listed],
        [(a.kind, a.period) for a in attractors],
        [*(basins.share(k) for k in range(len(attractors))), listed.resolution / unit],
    )


@pytest.mark.parametrize("given", [True, False])
@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("name", FAMILIES)
def test_orbits_attractors_and_basins_of_a_line_are_the_same_in_any_units(name, units, given):
    one, other = known(name, *units, given), known(name, 1.0, 1.0, given)
    agree(one[0], other[0], 1e-9)
    assert one[1] == other[1]
    np.testing.assert_allclose(one[2][:-1], other[2][:-1], rtol=1e-9)
    assert 1 / 32 <= one[2][-1] / other[2][-1] <= 32


@pytest.mark.parametrize(("units", "given"), [(UNITS[1], True), (UNITS[1], False)])
@pytest.mark.parametrize(
    ("name", "ends"), [("logistic", (2.9, 3.5)), ("cubic", (0.9, 2.1)), ("kink", (-0.1, 0.2))]
)
def test_bifurcations_of_a_line_are_the_same_in_any_units(name, ends, units, given):
    def events(unit, of_parameter):
        f = line(name, unit, of_parameter, given)
        low, high = (end * of_parameter for end in ends)
        found = ss.bifurcations(f, "r", (low, high), max_period=2)
        assert not found.unresolved
        return [(b.kind, b.period, b.criticality, b.value / of_parameter) for b in found]

    one, other = events(*units), events(1.0, 1.0)
    assert [item[:3] for item in one] == [item[:3] for item in other]
    assert len(one) > 0
    values = [[item[3] for item in found] for found in (one, other)]
    np.testing.assert_allclose(*values, rtol=1e-11, atol=1e-14)
