"""Lists of orbits against closed forms, brute force and theory."""

import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.analysis import known_maps as examples
from tests.reference.affine import Affine, jump_orbits, periodic_points

from stickslip import Coulomb, PoppStelter, TwoBlock, event_map
from stickslip.analysis.branches.branches import breakpoints as breakpoints_of
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits

ROUNDING = 1e-13
BORDER = 1e-6  # random maps with an orbit this close to a border are left out
PERIOD_THREE = 1 + math.sqrt(8)  # the logistic map's fold of period 3


def points_of(orbits, p):
    """Fixed points of f^p."""
    return np.sort(np.concatenate([o.points for o in orbits if p % o.period == 0]))


@pytest.mark.parametrize(
    ("f", "known"),
    [
        (examples.tent(2.0), examples.tent_points),
        (examples.logistic(4.0), examples.logistic_points),
    ],
)
@pytest.mark.parametrize("p", [1, 2, 3, 5, 8, 12])
def test_full_maps_have_all_fixed_points_of_their_powers(f, known, p):
    orbits = periodic_orbits(f, p)
    found = points_of(orbits, p)
    assert found.shape == (2**p,)
    # A multiplier of 2^p blows up rounding of f, but not of the points, polished together.
    assert np.abs(found - known(p)).max() < ROUNDING
    assert not orbits.near_folds
    assert not orbits.unresolved
    assert orbits.complete == p


@pytest.mark.parametrize("p", [1, 2, 3, 4, 5, 6])
def test_number_of_orbits_of_a_minimal_period(p):
    # Moebius inversion of 2^p fixed points.
    necklaces = {1: 2, 2: 1, 3: 2, 4: 3, 5: 6, 6: 9}
    orbits = periodic_orbits(examples.tent(2.0), period=p)
    assert len(orbits) == necklaces[p]
    assert {o.period for o in orbits} == {p}
    assert all(abs(o.multiplier) == 2.0**p for o in orbits)
    assert all(o.points[0] == o.points.min() for o in orbits)


def test_both_orbits_of_a_fold_on_one_lap():
    (stable,), (unstable,) = (
        [
            o
            for o in periodic_orbits(examples.logistic(PERIOD_THREE + 1e-6), period=3)
            if o.stable == wanted
        ]
        for wanted in (True, False)
    )
    # Beside a fold multipliers are 1 ± c sqrt(r - r_fold).
    assert 1 - stable.multiplier == pytest.approx(unstable.multiplier - 1, rel=0.05)
    assert stable.itinerary == unstable.itinerary


@pytest.mark.parametrize("excess", [1e-10, 1e-9, 1e-7, 1e-4])
def test_a_fold_is_resolved_on_both_sides(excess):
    assert len(periodic_orbits(examples.logistic(PERIOD_THREE + excess), period=3)) == 2
    assert len(periodic_orbits(examples.logistic(PERIOD_THREE - excess), period=3)) == 0


def test_a_fold_that_rounding_hides_is_reported():
    orbits = periodic_orbits(examples.logistic(PERIOD_THREE), period=3)
    assert len(orbits) == 0
    (near,) = orbits.near_folds
    assert not near.resolved
    assert near.distance < 1e-13
    assert "none, two" in repr(orbits)


def test_a_piece_close_to_the_diagonal_is_a_near_fold():
    orbits = periodic_orbits(examples.logistic(PERIOD_THREE - 1e-9), period=3)
    (near,) = orbits.near_folds
    assert near.resolved
    assert 1e-11 < near.distance < 1e-8


@pytest.mark.parametrize("excess", [1e-8, 1e-6, 1e-3])
def test_a_doubled_orbit_beside_its_parent(excess):
    r = 3 + excess
    (orbit,) = periodic_orbits(examples.logistic(r), period=2)
    root = math.sqrt((r + 1) * (r - 3))
    known = np.array([(r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)])
    assert orbit.stable
    assert orbit.multiplier == pytest.approx(1 - (r + 1) * (r - 3), abs=1e-10)
    # Close to the flip the orbit itself is as uncertain as rounding / excess.
    assert np.abs(orbit.points - known).max() < 1e-14 / excess + 1e-14
    assert len(periodic_orbits(examples.logistic(3 - excess), period=2)) == 0


@pytest.mark.parametrize("excess", [1e-6, 2e-5, 1e-3])
def test_three_orbits_beside_a_pitchfork(excess):
    # -r x + x^3 has the cycle ±sqrt(r - 1), and beyond r = 2 two more, x y = 1, x^2 + y^2 = r.
    # On their lap f^2 is so close to its cubic that the slope agrees where it is looked at.
    r = 2 + excess
    f = PiecewiseMap(lambda x, r: -r * x + x**3, (-1.5, 1.6), parameters={"r": r})
    found = sorted(orbit.points[0] for orbit in periodic_orbits(f, period=2))
    root = np.sqrt(r * r - 4)
    known = [-np.sqrt((r + root) / 2), -np.sqrt(r - 1), -np.sqrt((r - root) / 2)]
    assert found == pytest.approx(known, abs=1e-9)


def test_a_superstable_orbit_through_a_turning_point():
    (orbit,) = [o for o in periodic_orbits(examples.logistic(1 + math.sqrt(5)), period=2)]
    assert orbit.points[0] == pytest.approx(0.5, abs=ROUNDING)
    assert abs(orbit.multiplier) < 1e-7


@given(
    inner=st.lists(st.floats(0.05, 0.95), min_size=1, max_size=2, unique=True),
    slopes=st.lists(st.floats(-3, 3), min_size=3, max_size=3),
    starts=st.lists(st.floats(0, 1), min_size=3, max_size=3),
    p=st.integers(1, 4),
)
def test_random_affine_maps_against_every_word(inner, slopes, starts, p):
    edges = (0.0, *sorted(inner), 1.0)
    assume(min(np.diff(edges)) > 0.02)
    slopes = tuple(slopes[: len(edges) - 1])
    assume(all(abs(s) > 0.05 for s in slopes))
    offsets = tuple(y - s * x for y, s, x in zip(starts, slopes, edges, strict=False))
    affine = Affine(edges, slopes, offsets)
    known, doubtful = periodic_points(affine, p, BORDER)
    crossings, also_doubtful = jump_orbits(affine, p, BORDER)
    assume(not doubtful and not also_doubtful)
    assume(all(abs(np.subtract(*affine.limits(i))) > BORDER for i in range(1, len(slopes))))

    got = periodic_orbits(affine.as_map(), period=p, infinitely_unstable=True)
    ordinary = sorted((list(o.points), o.multiplier) for o in got if not o.infinitely_unstable)
    # Without jumps, laps that lead to no orbit are left out before they are pulled back.
    alone = periodic_orbits(affine.as_map(), period=p)
    assert ordinary == sorted((list(o.points), o.multiplier) for o in alone)
    assert len(ordinary) == len(known)
    for (points, multiplier), (expected, slope) in zip(ordinary, known, strict=True):
        assert points == pytest.approx(expected, abs=1e-9)
        assert multiplier == pytest.approx(slope, rel=1e-9)
    through = sorted((o.jump.d, o.jump.y) for o in got if o.infinitely_unstable)
    assert len(through) == len(crossings)
    for found, expected in zip(through, crossings, strict=True):
        assert found == pytest.approx(expected, abs=1e-9)
    for orbit in got:
        assert np.all(orbit.interval[:, 0] <= orbit.points)
        assert np.all(orbit.points <= orbit.interval[:, 1])


@given(r=st.floats(3.0, 4.0), p=st.integers(1, 5))
def test_logistic_maps_against_a_dense_scan(r, p):
    f = examples.logistic(r)
    x = np.linspace(1e-7, 1 - 1e-7, 40_013)
    g = f.iterate(x, p)[:, -1] - x
    assume(np.abs(g).min() > 1e-9)
    orbits = periodic_orbits(f, p)
    # Folds and doublings narrower than the scan's grid could be missed by the scan.
    assume(all(abs(abs(o.multiplier) - 1) > 0.05 for o in orbits) and not orbits.near_folds)
    found = points_of(orbits, p)
    assert len(found[found > 1e-7]) == np.count_nonzero(np.diff(np.sign(g)))


@pytest.mark.parametrize(("lam", "mu"), [(0.2, 0.02), (0.2, 0.06), (0.1, 0.03), (0.23, 0.004)])
def test_maximal_orbits_of_the_square_root_map(lam, mu):
    orbits = periodic_orbits(examples.square_root(lam, mu), 5)
    assert not orbits.unresolved
    n_found = 0
    for p in range(1, 6):
        try:
            points, multiplier = examples.maximal_orbit(lam, mu, p)
        except ValueError:
            continue
        n_found += 1
        start = int(np.argmin(points))
        points = np.roll(points, -start)
        (match,) = [o for o in orbits.of_period(p) if np.abs(o.points - points).max() < ROUNDING]
        assert match.multiplier == pytest.approx(multiplier, rel=1e-9)
    assert n_found > 0


@pytest.mark.parametrize(
    ("a", "b", "mu", "fixed"),
    [(0.5, -2.0, -1.0, [-2.0]), (0.5, -2.0, 1.0, [1 / 3]), (2.0, -3.0, 1.0, [-1.0, 0.25])],
)
def test_fixed_points_of_a_border_collision(a, b, mu, fixed):
    orbits = periodic_orbits(examples.border_collision(a, b, mu))
    assert [o.points[0] for o in orbits] == pytest.approx(fixed, abs=ROUNDING)


@pytest.mark.parametrize(
    ("mu", "periods"),
    # Slopes 0.4 and 0.4 with a falling jump of 1: rotation-like, period adding (Jain and
    # Banerjee 2003); between mu = 0.6 and 0.4 exactly one orbit, of period 2.
    [(0.5, {2}), (0.8, {3}), (0.2, {3}), (-0.1, {1}), (1.1, {1})],
)
def test_period_adding_of_the_map_with_a_gap(mu, periods):
    orbits = periodic_orbits(examples.border_collision(0.4, 0.4, mu, -1.0), 6)
    assert {o.period for o in orbits} == periods
    assert all(o.stable for o in orbits)


def test_a_gap_swallows_no_orbit():
    p = 8
    orbits = periodic_orbits(examples.tent_with_hole(3.0), p)
    assert points_of(orbits, p).shape == (2**p,)
    assert {abs(o.multiplier) for o in orbits} == {3.0**o.period for o in orbits}


def test_a_continuum_of_orbits_is_reported_not_listed():
    orbits = periodic_orbits(examples.tent(1.0))
    assert any(not near.resolved for near in orbits.near_folds)


def test_an_orbit_on_a_jump_is_reported():
    # The right branch starts exactly on the diagonal: f(0) = 0, a border collision.
    f = examples.border_collision(0.5, 0.5, -1.0, 1.0)
    orbits = periodic_orbits(f)
    assert [o.points[0] for o in orbits] == pytest.approx([-2.0])
    assert any("jump" in item.reason for item in orbits.unresolved)


def test_orbits_of_a_power_are_those_of_the_map():
    f = examples.logistic(3.9)
    powers = periodic_orbits(f.power(3), 2)
    assert points_of(powers, 2) == pytest.approx(points_of(periodic_orbits(f, 6), 6), abs=1e-12)


def test_flat_branch_gives_a_superstable_orbit():
    f = PiecewiseMap(
        lambda x: np.where(x < 0.5, 0.75, 2 * x - 1.2),
        (0, 1),
        derivative=lambda x: np.where(x < 0.5, 0.0, 2.0),
        breakpoints=[0.5],
    )
    orbits = periodic_orbits(f, 4)
    (flat,) = [o for o in orbits if o.stable]
    assert flat.multiplier == 0
    assert flat.points == pytest.approx([0.3, 0.75], abs=ROUNDING)


def test_points_stay_inside_their_interval_and_residuals_are_rounding():
    for orbit in periodic_orbits(examples.logistic(3.9), 8):
        assert np.all(orbit.interval[:, 0] <= orbit.points)
        assert np.all(orbit.points <= orbit.interval[:, 1])
        assert orbit.residual < 1e-14
        assert orbit.quality == "located"


@pytest.mark.parametrize("wrong", [0, -1, 1.5, True])
def test_periods_are_whole_and_positive(wrong):
    with pytest.raises(ValueError, match="whole number"):
        periodic_orbits(examples.tent(), wrong)
    with pytest.raises(ValueError, match="period = "):
        periodic_orbits(examples.tent(), period=wrong)


def test_too_many_pieces_is_said():
    orbits = periodic_orbits(examples.doubling(90.5), 3)
    assert orbits.complete == 2
    assert "more than the" in orbits.unresolved[0].reason


@pytest.mark.parametrize("text", ["-x - x**2", "-x + x**3", "-x - x**3", "1 - x", "x - x**3"])
def test_orbits_on_the_unit_circle_are_neutral(text):
    # 0 attracts under the first two and the last, and repels under the third.
    domain = (0.0, 1.0) if text == "1 - x" else (-0.6, 0.6)
    (orbit, *_) = periodic_orbits(PiecewiseMap([text], domain), 1)
    assert orbit.kind == "neutral"
    assert not orbit.stable
    assert "neutral" in repr(orbit)


@pytest.mark.parametrize("alpha", [2.64521, 2.64525, 2.64527, 2.6452717])
def test_an_orbit_beside_a_graze_is_not_lost_on_it(alpha):
    """Its multiplier grows without bound, to 3311 here: Newton's method ran on to the break.

    It is born at a fold at 2.6451287316 with the stable one, and is lost at 2.6452718085.
    """
    model = TwoBlock(
        alpha=alpha,
        beta=1.7923799989712168,
        V=0.008568266272892918,
        friction=Coulomb(mu=0.06668225491413128),
    )
    found = periodic_orbits(event_map(model), 3)
    assert [orbit.period for orbit in found] == [3, 3]
    assert not found.unresolved
    step = 1e-9 * np.array([-1.0, 1.0])
    for orbit in found:
        x = orbit.points[0] + step / max(1.0, abs(orbit.multiplier))
        off = event_map(model).iterate(x, 3)[:, -1] - x
        assert off[0] * off[1] < 0


@pytest.mark.parametrize("gamma", [1.495159874, 1.495164897, 1.496])
def test_no_orbit_is_within_a_break_that_is_not_located(gamma):
    """Breaks accumulate: within a billionth they are one, a corner that is not located.

    Laps that went on across it came to f(x) = x with a slope of 1.9e6, where f(x) - x is -0.004.
    """
    law = PoppStelter(gamma=gamma, delta=0.14738161134097152)
    f = event_map(TwoBlock(1.762201433794681, 1.7601884603776112, 0.060922356212718694, law))
    found = periodic_orbits(f, 1)
    for orbit in found:
        x = orbit.points[0]
        assert abs(f(x) - x) <= 1e-12 * max(1.0, abs(f.derivative(x)))
    assert any("closer to each other than" in item.reason for item in found.unresolved)


def test_an_orbit_on_one_rising_lap_is_a_fixed_point():
    """Here values are good to 2e-13 only, and three points so close were an orbit of period 3."""
    law = PoppStelter(gamma=2.5817884506976814, delta=0.049714888231339405)
    model = TwoBlock(3.3907706542832443, 0.9602374741322695, 0.21131947896424041, law)
    for orbit in periodic_orbits(event_map(model), 3):
        assert orbit.period == 1 or np.ptp(orbit.points) > 1e-9


def test_a_gap_that_no_cell_shows_is_no_orbit():
    # The fixed point is within: no orbit passes 0.25, also not of period 2. A falling lap alone has
    # none of period 3.
    f = PiecewiseMap(lambda x: np.where(abs(x - 0.25) < 1e-4, np.nan, 0.7 - 1.8 * x), (-1, 1.5))
    found = periodic_orbits(f, 3)
    assert len(found) == 0
    assert {item.period for item in found.unresolved} == {1, 2}
    assert all(item.lo < 0.25 < item.hi for item in found.unresolved)


@pytest.mark.parametrize("breakpoints", [None, [0.0]])
def test_orbits_pass_on_both_sides_of_a_pole(breakpoints):
    # Boole's map is two to one of the line, and conjugate to the doubling of angles: 2^p - 2 fixed
    # points of f^p, of which infinity is one more. Period 2: x^2 = 1/2; f'(x)^2 = 9.
    f = PiecewiseMap(lambda x: x - 1 / x, (-10, 10.3), breakpoints=breakpoints)
    (pole,) = breakpoints_of(f)
    assert abs(pole.d) < 1e-18
    assert pole.kind == "jump"
    assert pole.left > 1e18 > -1e18 > pole.right
    found = periodic_orbits(f, 5)
    assert [sum(o.period == p for o in found) for p in range(1, 6)] == [0, 1, 2, 3, 6]
    np.testing.assert_allclose(found[0].points, [-(0.5**0.5), 0.5**0.5], rtol=1e-15)
    assert found[0].multiplier == pytest.approx(9, rel=1e-14)


def test_newtons_method_goes_to_infinity_where_the_slope_vanishes():
    # 2 x^3 / (3 x^2 - 1) for the roots of x^3 - x: superstable, and x = 1/sqrt(5) flees from -x.
    f = PiecewiseMap("2*x**3/(3*x**2 - 1)", (-3, 3.3))
    breaks = [item.d for item in breakpoints_of(f)]
    np.testing.assert_allclose(breaks, [-(3**-0.5), 3**-0.5], rtol=1e-15)
    found = periodic_orbits(f, 2)
    assert [(o.period, round(o.points[-1], 12)) for o in found] == [
        (1, -1),
        (1, 0),
        (1, 1),
        (2, round(5**-0.5, 12)),
    ]
    assert found[-1].multiplier == pytest.approx(36, rel=1e-13)


def test_an_orbit_is_on_a_break_only_within_its_own_error():
    """The fixed point is 5e-13 right of the jump and known to rounding."""
    f = PiecewiseMap(
        lambda x: np.where(x < 0, 0.4 * x + 0.3, 3 * x - 1e-12),
        (-1, 1),
        derivative=lambda x: np.where(x < 0, 0.4, 3.0),
        breakpoints=[0.0],
    )
    found = periodic_orbits(f, 1)
    assert [orbit.points.tolist() for orbit in found] == [[pytest.approx(5e-13, rel=1e-3)]]
    assert found.unresolved == ()


@pytest.mark.parametrize(("at", "right", "top"), [(0.5, 0.012, 0.9), (0.507, 0.0125, 0.889)])
def test_beside_a_logarithm_there_is_an_orbit_for_each_word(at, right, top):
    """Both branches come from -infinity over all but their own ends: a shift, and a sink."""

    def value(x):
        log = np.log(np.maximum(np.abs(x - at), 1e-300))
        return np.where(x < at, top + 0.0156 * log, 0.81 + right * log)

    def slope(x):
        with np.errstate(divide="ignore"):
            return np.where(x < at, 0.0156, right) / (x - at)

    found = periodic_orbits(PiecewiseMap(value, (0, 1), derivative=slope), 4)
    # Lyndon words of two letters, and the sink.
    assert [o.period for o in found] == [1, 1, 1, 2, 3, 3, 4, 4, 4]
    assert found.unresolved == ()
    for orbit in found:
        x = orbit.points
        off = np.abs(value(x) - np.roll(x, -1))
        assert (off <= 1e-15 + 2 * np.abs(slope(x)) * np.spacing(x)).all()
