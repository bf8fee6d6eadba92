"""bifurcations of families whose bifurcations are known in closed form."""

from functools import partial

import numpy as np
import pytest
from tests.analysis import known_maps as examples
from tests.sizes import slow

import stickslip as ss
from stickslip.analysis.bifurcations import bifurcations as lists
from stickslip.analysis.bifurcations.bifurcation import BIFURCATION_KINDS, BifurcationList
from stickslip.analysis.bifurcations.cascades import accumulation
from stickslip.results.files import load

# Fewer than by default: what lies between lists is found all the same.
bifurcations = partial(lists.bifurcations, n_lists=6)

SHARP = 1e-12  # of located values

# Flips of the logistic map, r = 3, 1 + sqrt(6), ...; May 1976, and Feigenbaum's accumulation.
LOGISTIC_FLIPS = (3.0, 1 + np.sqrt(6), 3.544090359552, 3.564407266095, 3.568759419544)
LOGISTIC_ACCUMULATION = 3.569945671871


@pytest.fixture(scope="module")
def doubling_logistic():
    return bifurcations(examples.logistic(3.0), "r", (2.9, 3.57), max_period=2)


def test_flips_of_the_logistic_map_and_their_accumulation(doubling_logistic):
    found = doubling_logistic
    (cascade,) = found.cascades
    assert cascade.values[:5] == pytest.approx(LOGISTIC_FLIPS, abs=2e-12)
    assert [flip.period for flip in cascade.flips[:5]] == [1, 2, 4, 8, 16]
    assert {flip.criticality for flip in cascade.flips} == {"super"}
    assert cascade.accumulation == pytest.approx(LOGISTIC_ACCUMULATION, abs=1e-9)
    assert abs(cascade.accumulation - LOGISTIC_ACCUMULATION) <= cascade.error + 1e-12
    assert cascade.ratios[-1] == pytest.approx(4.6692, abs=1e-3)
    assert not found.unresolved


def test_flips_beyond_the_longest_period_are_marked(doubling_logistic):
    assert [b.in_cascade for b in doubling_logistic.of_kind("flip")[:3]] == [False, False, True]
    last = doubling_logistic.cascades[0].flips[-1]
    # A stable parent before, the unstable one and its stable double after.
    assert [orbit.stable for orbit in last.orbits_before] == [True]
    assert [orbit.stable for orbit in last.orbits_after] == [False, True]
    assert [orbit.period for orbit in last.orbits_after] == [last.period, 2 * last.period]


def wide(width):
    """x -> c - x^2 on a domain much wider than its orbits."""
    return ss.PiecewiseMap(
        lambda x, c: c - x * x,
        (-width, width),
        derivative=lambda x, c: -2 * x,
        parameters={"c": 0.6},
    )


def test_a_fold_whose_orbit_is_narrow_is_no_flip_of_a_shorter_one():
    (fold,) = bifurcations(wide(1e5), "c", (1.749, 1.751), max_period=3)
    assert (fold.kind, fold.period) == ("fold", 3)
    assert fold.value == pytest.approx(1.75, abs=1e-8)


def test_a_flip_concerns_the_nearest_orbit_of_its_period():
    # The other fixed point is less than a thousandth of the domain away.
    found = bifurcations(wide(3000), "c", (0.5, 1.0), max_period=2)
    (flip,) = found
    assert flip.value == pytest.approx(0.75, abs=1e-9)
    assert [orbit.stable for orbit in flip.orbits_before] == [True]
    assert [orbit.stable for orbit in flip.orbits_after] == [False, True]
    flipping, *_ = (curve for curve in found.curves if curve.bifurcations)
    assert flipping.points[0, 0] == pytest.approx((np.sqrt(3) - 1) / 2, abs=1e-9)


def test_flips_of_a_cascade_tell_their_attractors(doubling_logistic):
    for flip in doubling_logistic.cascades[0].flips:
        assert [a.period for a in flip.attractors_before] == [flip.period]
        assert [a.period for a in flip.attractors_after] == [2 * flip.period]


def test_a_flip_tells_orbits_and_attractors_on_both_sides(doubling_logistic):
    first = doubling_logistic[0]
    assert first.kind == "flip"
    assert first.points == pytest.approx([2 / 3], abs=SHARP)
    assert first.multipliers == pytest.approx([-1], abs=1e-10)
    assert [orbit.period for orbit in first.orbits_before] == [1]
    assert [orbit.period for orbit in first.orbits_after] == [1, 2]
    assert [a.period for a in first.attractors_before] == [1]
    assert [a.period for a in first.attractors_after] == [2]
    assert first.born == 1


def test_branches_join_the_orbits_between_bifurcations(doubling_logistic):
    one, other, double = doubling_logistic.curves
    assert set(double.data) == {"labels", "margin", "residual"}
    assert [branch.period for branch in (one, other, double)] == [1, 1, 2]
    assert double.end_reasons == ("period halves", "end of range")
    passed = [item.value for branch in (one, other, double) for item in branch.bifurcations]
    assert passed == pytest.approx(LOGISTIC_FLIPS[:2], abs=SHARP)
    for branch in doubling_logistic.curves:
        assert np.all(branch.data["residual"] < 1e-14)
        assert np.all(np.diff(branch.values) > 0)
    assert double.at(r=3.2).points == pytest.approx(double_of_logistic(3.2), abs=SHARP)


def double_of_logistic(r):
    """The 2-cycle of r x (1 - x), roots of a quadratic."""
    root = np.sqrt((r + 1) * (r - 3))
    return [(r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)]


def test_windows_end_where_an_image_of_the_top_meets_the_unstable_cycle():
    """What is between two values of the grid, chaos at both, had no mergings and no crisis."""
    found = bifurcations(examples.logistic(3.9), "r", (3.8, 3.99), max_period=4, n_lists=5)
    assert not found.unresolved
    kinds = {"band_merging": {3, 4, 6, 8}, "interior_crisis": {3, 4}}
    for images, (kind, periods) in zip((3, 2), kinds.items(), strict=True):
        events = found.of_kind(kind)
        assert periods <= {event.period for event in events}
        for event in events:
            orbit = examples.logistic(event.value).iterate(0.5, (images + 1) * event.period)
            assert orbit[images * event.period] == pytest.approx(orbit[-1], abs=SHARP)


def test_the_fold_of_period_3_of_the_logistic_map():
    found = bifurcations(examples.logistic(3.8), "r", (3.82, 3.835), max_period=3)
    (fold,) = found.of_kind("fold")
    assert fold.value == pytest.approx(1 + np.sqrt(8), abs=SHARP)
    assert fold.error < 1e-12
    assert (fold.period, len(fold.orbits_before), len(fold.orbits_after)) == (3, 0, 2)
    assert sorted(orbit.stable for orbit in fold.orbits_after) == [False, True]
    (branch,) = [branch for branch in found.curves if branch.period == 3]
    # One branch turns at the fold: the stable and the unstable orbit are its two halves.
    assert [item.kind for item in branch.bifurcations] == ["fold"]
    assert branch.values[0] == branch.values[-1] == 3.835


@pytest.mark.parametrize(
    ("a", "b", "orbits", "after"),
    [
        *slow((0.5, -0.8, "persist", "periodic")),
        *slow((0.5, -1.5, "period-doubled", "periodic")),
        (2.0, -0.5, "die in pairs", "none"),
        (1.4, -1.3, "born in pairs", "chaotic"),
    ],
)
def test_a_border_collision_has_the_outcome_of_the_normal_form(a, b, orbits, after):
    f = examples.border_collision(a, b, mu=0.1, size=2.0)
    if orbits == "die in pairs":
        f = ss.PiecewiseMap(
            lambda x, mu: np.where(x < 0, a * x, b * x) - mu,
            (-2, 2),
            parameters={"mu": 0.1},
            derivative=lambda x, mu: np.where(x < 0, a, b),
            breakpoints=[0.0],
        )
    found = bifurcations(f, "mu", (-0.11, 0.13), max_period=2)
    (collision,) = found.of_kind("border_collision")
    assert collision.value == pytest.approx(0, abs=SHARP)
    assert collision.points == pytest.approx([0], abs=SHARP)
    assert collision.multipliers == pytest.approx([a, b])
    assert collision.outcome.orbits == collision.predicted_outcome.orbits == orbits
    assert collision.outcome.attractors == collision.predicted_outcome.attractors == after
    assert not found.unresolved


def test_a_square_root_border():
    # For mu > 0 the fixed point is on the root's side, its slope there unbounded at mu = 0.
    found = bifurcations(examples.square_root(0.2, 0.1), "mu", (-0.05, 0.06), max_period=2)
    assert 0 in [pytest.approx(b.value, abs=SHARP) for b in found.of_kind("border_collision")]
    assert not found.unresolved


def test_an_orbit_enters_a_gap():
    # x / 2 + mu has the fixed point 2 mu, which the gap x > 0.5 swallows at mu = 1/4.
    f = ss.PiecewiseMap(
        lambda x, mu: np.where(x <= 0.5, 0.5 * x + mu, np.nan),
        (-1, 1),
        parameters={"mu": 0.1},
        derivative=lambda x, mu: np.full_like(x, 0.5),
        label=lambda x, mu: np.where(x <= 0.5, 0, 1),
    )
    found = bifurcations(f, "mu", (0.1, 0.4), max_period=2)
    (lost,) = found
    assert lost.kind == "enters_gap"
    assert lost.value == pytest.approx(0.25, abs=SHARP)
    assert (len(lost.orbits_before), len(lost.orbits_after)) == (1, 0)
    assert lost.outcome.orbits == lost.predicted_outcome.orbits == "lost in a gap"


def test_where_there_are_no_orbits_nothing_happens():
    f = ss.PiecewiseMap(lambda x, a: x + a, (0, 1), parameters={"a": 0.3})
    found = bifurcations(f, "a", (0.2, 0.4), max_period=2)
    assert len(found) == 0
    assert found.curves == ()
    assert found.unresolved == ()


def test_lists_are_sequences_with_tables(doubling_logistic):
    found = doubling_logistic
    assert isinstance(found, BifurcationList)
    assert list(found) == list(found.bifurcations)
    assert list(found) == sorted(found, key=lambda b: b.value)
    table = found.table()
    assert list(table["value"]) == [b.value for b in found]
    assert table["kind"][0] == "flip"
    assert found.of_kind(*BIFURCATION_KINDS) == found.bifurcations
    with pytest.raises(ValueError, match=r"kind = .*\['fold'\]"):
        found.of_kind(np.array(["fold"]))
    with pytest.raises(ValueError, match=r"kind = 'grazing' is unknown. Known: fold, flip"):
        found.of_kind("grazing")
    assert max(map(len, repr(found).splitlines())) <= 120


def test_lists_are_saved_and_loaded(doubling_logistic, tmp_path):
    path = tmp_path / "found.json"
    doubling_logistic.save(path)
    again = load(path)
    assert repr(again) == repr(doubling_logistic)
    assert again[0].condition == doubling_logistic[0].condition
    np.testing.assert_array_equal(again.curves[0].points, doubling_logistic.curves[0].points)


def test_aitken_extrapolates_a_geometric_sequence_exactly():
    values = 2.0 - 0.5 * 4.0 ** -np.arange(6)
    value, error = accumulation(values, np.full(6, 1e-16))
    assert value == pytest.approx(2.0, abs=1e-14)
    assert error < 1e-13
    assert np.isnan(accumulation(values[:2], np.zeros(2))[0])
    assert not np.isfinite(accumulation(np.arange(4.0), np.full(4, 1e-9))).any()  # equal gaps


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("s", (2.9, 3.1)), r"'s' is not a parameter"),
        (("r", (3.1, 2.9)), r"range = \(3.1, 2.9\).*lo < hi"),
        (("r", (3.0, float("nan"))), r"range\[1\] = nan .*finite"),
        (("r", 3.0), r"range = 3.0: a pair"),
    ],
)
def test_a_range_or_name_that_means_nothing_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        bifurcations(examples.logistic(3.0), *arguments)


@pytest.mark.parametrize("options", [{"max_period": 0}, {"max_period": 1.5}, {"n_lists": 2}])
def test_numbers_that_are_not_whole_are_refused(options):
    (name,) = options
    with pytest.raises(ValueError, match=f"{name} = .*whole number"):
        bifurcations(examples.logistic(3.0), "r", (2.9, 3.1), **options)


def test_a_window_that_is_none_is_refused():
    with pytest.raises(ValueError, match="window"):
        bifurcations(examples.logistic(3.0), "r", (2.9, 3.1), window=(0.6, 0.5))


def test_progress_is_told():
    shares = []
    bifurcations(
        examples.logistic(3.0), "r", (2.9, 3.1), max_period=1, n_lists=5, progress=shares.append
    )
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def one_step_or_two(x, r):
    """Beyond the jump at 1 the map takes two steps for what it does in one below."""
    return np.where(x < 0, 0.5 * (x + 3) + r, np.where(x < 1, 0.5 * x + r, x - 3.0))


def two_steps_or_three(x, r):
    """The same with a step in between, through the points below -3."""
    return np.where(x < -3, -x - 3, np.where(x < 1, -one_step_or_two(x, r) - 3, x - 3.0))


@pytest.mark.parametrize(
    ("func", "domain", "breaks", "before", "after"),
    [
        (one_step_or_two, (-2.5, 2.5), [0.0, 1.0], [1], [-2, 1]),
        (two_steps_or_three, (-5.5, 2.6), [-3.0, 0.0, 1.0], [-4, 1], [-4, -2, 1]),
    ],
)
def test_an_orbit_that_meets_a_jump_goes_on_with_another_period(
    func, domain, breaks, before, after
):
    f = ss.PiecewiseMap(func, domain, parameters={"r": 0.45}, breakpoints=breaks)
    found = bifurcations(f, "r", (0.4, 0.61), max_period=3)
    (collision,) = found
    assert collision.value == pytest.approx(0.5, abs=SHARP)
    assert [o.period for o in collision.orbits_before] == [len(before)]
    assert [o.period for o in collision.orbits_after] == [len(after)]
    assert [branch.end_reasons for branch in found.curves] == [
        ("end of range", "breakpoint"),
        ("breakpoint", "end of range"),
    ]
    assert not found.unresolved
    diagram = ss.bifurcation_diagram(f, "r", np.linspace(0.4, 0.61, 8), n_lists=4)
    assert not diagram.unresolved
    for one, two in (found.curves, diagram.orbits):
        assert sorted(one.ends[1].points) == pytest.approx(before, abs=SHARP)
        assert sorted(two.ends[0].points) == pytest.approx(after, abs=SHARP)


@pytest.mark.parametrize(
    ("module", "name", "lost"),
    [
        ("scan.between", "join", "the changes of orbits"),
        ("bifurcations", "explained", "a flip"),
        ("bifurcations", "orbit_curves", "the curves"),
        ("bifurcations", "cascades", "the cascades"),
        ("bifurcations", "CrisisSearch", "the crises"),
        ("bifurcations", "parameter_point", "the crises"),
    ],
)
def test_a_fault_costs_its_own_part_and_is_told(monkeypatch, caplog, module, name, lost):
    def fault(*_, **__):
        raise IndexError("of no concern to users")

    monkeypatch.setattr(f"stickslip.analysis.bifurcations.{module}.{name}", fault)
    found = bifurcations(examples.logistic(3.0), "r", (2.9, 3.2), max_period=2, n_lists=4)
    assert len(found) == (name not in ("join", "explained"))
    assert "of no concern to users" in caplog.text
    said = "\n".join(map(str, found.unresolved))
    assert f"a fault of the program left out {lost}" in said
    assert said in repr(found).replace("  unresolved: ", "")
    assert "of no concern" not in said


@pytest.mark.parametrize(
    ("system", "name", "ends"),
    [(examples.logistic(3.0), "r", (3.4, 3.5)), (ss.examples.coulomb(), "V", (0.0368, 0.037))],
)
def test_processes_change_nothing(two_processes, system, name, ends):
    asked = partial(bifurcations, system, name, ends, max_period=3, n_lists=8)
    here = asked()
    with two_processes():
        found = asked()
    assert repr(found) == repr(here)
    assert [item.value for item in found] == [item.value for item in here]
    for one, other in zip(found.curves, here.curves, strict=True):
        np.testing.assert_array_equal(one.points, other.points)


@pytest.mark.parametrize("max_period", [1, 2])
def test_a_flip_bears_an_orbit_also_above_the_longest_period(max_period):
    found = bifurcations(examples.logistic(3.0), "r", (2.9, 3.5), max_period=max_period, n_lists=4)
    flips = found.of_kind("flip")
    assert [flip.period for flip in flips] == [1, 2]
    for flip in flips:
        after = [(orbit.period, orbit.stable) for orbit in flip.orbits_after]
        assert after == [(flip.period, False), (2 * flip.period, True)]


def test_a_flip_lies_on_the_curve_of_the_orbit_that_flips_alone():
    # All orbits are closer than a thousandth, in whatever unit.
    f = ss.PiecewiseMap(lambda x, r: r * x * (1 - 1e4 * x), (-1e-5, 1e-4), parameters={"r": 3.0})
    found = bifurcations(f, "r", (2.5, 3.2), max_period=2, n_lists=6)
    on_curves = [[event.kind for event in curve.bifurcations] for curve in found.curves]
    assert [curve.period for curve in found.curves] == [1, 1, 2]
    assert on_curves == [[], ["flip"], []]
    assert abs(found.curves[0].points).max() < 1e-12
