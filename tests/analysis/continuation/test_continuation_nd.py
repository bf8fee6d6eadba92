"""Branches of orbits of maps of R^n: bifurcations where they are known in closed form."""

import dataclasses

import numpy as np
import pytest
from tests.analysis.known_maps_nd import SmoothMap, delayed_logistic, henon, kinked

from stickslip.analysis.continuation.continuation import follow_orbit
from stickslip.analysis.maps.map import Map
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.results.files import load, save

EXACT = 1e-11


def branch_of(f, name, ends, period=1, index=0):
    return follow_orbit(periodic_orbits(f, period=period)[index], f, name, ends)


@pytest.fixture(scope="module")
def fixed():
    """The fixed point of the Hénon map that is stable at a = 0.1."""
    f = henon(0.1)
    return follow_orbit(periodic_orbits(f, 1).stable[0], f, "a", (-0.5, 1.4))


def test_a_neimark_sacker_bifurcation_in_closed_form():
    f = delayed_logistic(1.9)
    branch = follow_orbit(periodic_orbits(f, 1).stable[0], f, "a", (1.3, 2.2))
    (found,) = branch.bifurcations
    assert found.kind == "neimark_sacker"
    assert found.value == pytest.approx(2.0, abs=EXACT)
    assert found.rotation == pytest.approx(1 / 6, abs=EXACT)
    assert found.points[0] == pytest.approx([0.5, 0.5], abs=EXACT)
    assert np.abs(found.multipliers) == pytest.approx([1.0, 1.0], abs=EXACT)
    assert branch.stable[0]
    assert not branch.stable[-1]


def test_a_pair_of_reciprocal_real_multipliers_is_no_bifurcation():
    """A saddle whose multipliers have the product 1 in passing."""
    f = SmoothMap(
        lambda z, c: z * [c, 0.5],
        lambda z, c: np.broadcast_to(np.diag([c, 0.5]), (*z.shape, 2)),
        {"c": lambda z, c: z * np.array([1.0, 0.0])},
        ((-1.0, 1.0), (-1.0, 1.0)),
        (("c", 1.8),),
    )
    branch = follow_orbit(periodic_orbits(f, 1)[0], f, "c", (1.5, 2.5))
    products = np.prod(branch.multipliers.real, axis=1)
    assert products[0] < 1.0 < products[-1]
    assert branch.bifurcations == ()


def test_fold_and_flip_of_the_henon_map_in_closed_form(fixed):
    fold, flip = sorted(fixed.bifurcations, key=lambda item: item.value)
    assert (fold.kind, flip.kind) == ("fold", "flip")
    assert fold.value == pytest.approx(-0.49 / 4, abs=EXACT)
    assert flip.value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    assert fold.multipliers[0] == pytest.approx(1.0, abs=1e-9)
    assert flip.multipliers[0] == pytest.approx(-1.0, abs=1e-9)
    assert {end.reason for end in fixed.ends} == {"end of domain", "end of range"}
    for item in fixed.bifurcations:
        assert fixed.values[item.row] == item.value
        assert item.error < EXACT


def test_rows_are_orbits(fixed):
    for a, points in zip(fixed.values, fixed.points, strict=True):
        (x, y) = points[0]
        assert 1 - a * x * x + y == pytest.approx(x, abs=1e-12)
    assert fixed.data["residual"].max() < 1e-11
    for k, orbit in enumerate(fixed):  # at the fold and at both ends, too
        np.testing.assert_array_equal(orbit.points, fixed.points[k])
        np.testing.assert_array_equal(orbit.multipliers, fixed.multipliers[k])
        assert orbit.stable == fixed.stable[k]


def test_orbits_are_solved_anew_at_a_value(fixed):
    on_both_sides_of_the_fold = fixed.all_at(a=-0.1)
    x = np.roots([0.1, -0.7, 1.0])  # 1 - a x^2 + b x = x
    assert sorted(o.points[0, 0] for o in on_both_sides_of_the_fold) == pytest.approx(sorted(x))
    with pytest.raises(ValueError, match="outside the curve"):
        fixed.at(a=-0.2)
    with pytest.raises(ValueError, match=r"at\(a="):
        fixed.at(b=0.3)
    with pytest.raises(ValueError, match=r"a = None .* is not a real number"):
        fixed.at(a=None)


@pytest.mark.parametrize("beside", [1e-8, 1e-9, 1e-11, 1e-13])
def test_both_orbits_beside_a_fold_are_solved_for(fixed, beside):
    value = -0.49 / 4 + beside
    x = [orbit.points[0, 0] for orbit in fixed.all_at(a=value)]
    root = np.sqrt(beside) / value  # x = (0.7 ± 2 sqrt(a - fold)) / -2a
    np.testing.assert_allclose(np.ptp(x), 2 * abs(root), rtol=1e-2)


def test_an_orbit_of_twice_the_period_ends_at_the_flip():
    branch = branch_of(henon(0.5), "a", (0.1, 1.2), period=2)
    end = branch.ends[0]
    assert end.reason == "period halves"
    assert end.value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    assert end.points == pytest.approx(np.roll(end.points, 1, axis=0), abs=EXACT)
    (flip,) = branch.bifurcations
    # x1 + x2 = (1 - b) / a and so on: the 2-cycle flips at a = (1 - b)^2 + (1 + b)^2 / 4
    assert flip.value == pytest.approx(0.7**2 + 1.3**2 / 4, abs=EXACT)


def test_a_branch_goes_on_to_the_other_side_of_where_it_was_halved():
    """The same with the parameter -a, along which the flip is met first."""
    plain = henon(0.5)
    mirrored = dataclasses.replace(
        plain,
        func=lambda z, c: plain.func(z, -c, 0.3),
        jacobian=lambda z, c: plain.jacobian(z, -c, 0.3),
        rates={"c": lambda z, c: -plain.rates["a"](z, -c, 0.3)},
        values=(("c", -0.5),),
    )
    branch = branch_of(mirrored, "c", (-1.2, -0.1), period=2)
    assert [end.reason for end in branch.ends] == ["end of range", "period halves"]
    assert branch.ends[1].value == pytest.approx(-3 * 0.49 / 4, abs=EXACT)


@pytest.mark.parametrize(("jump", "kind"), [(0.0, "corner"), (0.2, "jump")])
def test_a_border_collision_in_closed_form(jump, kind):
    branch = branch_of(kinked(-0.1, jump), "mu", (-0.3, 0.3))
    end = branch.ends[1]
    assert (end.reason, end.kind, end.index) == ("breakpoint", kind, 0)
    assert end.value == pytest.approx(0.0, abs=1e-10)
    assert abs(end.value) <= end.error < 1e-10
    assert end.points[0] == pytest.approx([0.0, 0.0], abs=1e-10)


def test_a_border_that_the_map_does_not_notice_is_passed():
    plain = henon(0.1)
    labelled = dataclasses.replace(plain, label=lambda z, a, b: 1 + (z[..., 0] > 1.0))
    orbit = periodic_orbits(plain, 1).stable[0]
    ways = [follow_orbit(orbit, g, "a", (0.05, 0.6)) for g in (plain, labelled)]
    assert len(set(ways[1].data["labels"].ravel().tolist())) == 2
    for way in ways:
        assert [end.reason for end in way.ends] == ["end of range"] * 2
        assert way.bifurcations[-1].value == pytest.approx(3 * 0.49 / 4, abs=EXACT)
    border, _ = ways[1].bifurcations  # the fixed point is at 1 where a = 1 - 0.7
    assert (border.kind, border.outcome) == ("border", "persists")
    assert abs(border.value - 0.3) <= border.error < 1e-10
    assert len(ways[0].bifurcations) == 1


def test_what_cannot_be_followed_is_said(fixed):
    f = henon(0.1)
    orbit = periodic_orbits(f, 1).stable[0]
    with pytest.raises(ValueError, match="does not contain a"):
        follow_orbit(orbit, f, "a", (0.5, 1.0))
    with pytest.raises(ValueError, match="'c' is not a parameter"):
        follow_orbit(orbit, f, "c", (0.0, 1.0))
    with pytest.raises(ValueError, match="no such orbit"):
        follow_orbit(orbit, henon(0.3), "a", (0.0, 1.0))


def test_a_branch_is_saved_and_loaded_exactly(fixed, tmp_path):
    fixed.save(tmp_path / "branch")
    again = load(tmp_path / "branch", henon())
    assert repr(again) == repr(fixed)
    assert np.array_equal(again.multipliers, fixed.multipliers)
    assert again.all_at(a=0.2)[0].residual < 1e-14
    save(fixed.ends, tmp_path / "ends")
    assert load(tmp_path / "ends")[1].reason == fixed.ends[1].reason


# ------------------------------------------------------------------ angles


def circle_map(om, K):
    """Arnold's map of the circle, an angle in turns."""

    def func(x, om, K):
        return x + om - K / (2 * np.pi) * np.sin(2 * np.pi * x)

    return Map(func, 1, parameters={"om": om, "K": K}, periodic=[1.0])


def test_a_curve_that_comes_back_after_turning_round_is_closed():
    """The points of the cycle of rotation number 1/2 drift round as its tongue is crossed."""
    f = circle_map(0.5, 0.9)
    for orbit in periodic_orbits(f, period=2):
        branch = follow_orbit(orbit, f, "om", (0.45, 0.55))
        assert branch.end_reasons == ("closed", "closed")
        folds = [b.value for b in branch.bifurcations if b.kind == "fold"]
        assert len(folds) == 2
        assert sum(folds) == pytest.approx(1.0, rel=EXACT)  # x -> -x takes om to 1 - om
        assert len(branch.all_at(om=0.5)) == 2


def test_halves_of_an_orbit_that_merge_across_a_turn():
    """0 flips where 1 - K = -1; its double lies on both sides of 0, which is 1."""
    f = circle_map(0.0, 2.3)
    (orbit,) = periodic_orbits(f, period=2)
    branch = follow_orbit(orbit, f, "K", (1.5, 2.5))
    assert branch.end_reasons == ("period halves", "end of range")
    assert branch.ends[0].value == pytest.approx(2.0, rel=EXACT)
    assert np.ptp(branch.ends[0].points) == pytest.approx(1.0, rel=EXACT)
    np.testing.assert_allclose(branch.points[0], branch.points[1], rtol=0, atol=0.1)
    assert not branch.bifurcations


def test_halves_a_half_turn_apart_do_not_merge():
    f = circle_map(0.5, 0.9)
    orbit = next(o for o in periodic_orbits(f, period=2) if o.stable)  # 0 and 1/2
    branch = follow_orbit(orbit, f, "om", (0.48, 0.52))
    assert branch.end_reasons == ("end of range", "end of range")
