"""Diagrams of families whose orbits, ends and attractors are known in closed form."""

import numpy as np
import pytest
from tests.analysis.known_maps import border_collision, logistic, tent

from stickslip import examples
from stickslip.analysis.bifurcations.bifurcations import (
    N_LISTS,
    bifurcations,
    bifurcations_of,
)
from stickslip.analysis.bifurcations.scan.nodes import Family
from stickslip.analysis.bifurcations.scan.survey import Survey
from stickslip.analysis.diagrams.diagram import Diagram
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram, diagram_of
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram as of_a_system
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.work import Work
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.results.files import load

FLIP_OF_2 = 1 + np.sqrt(6)  # where the logistic map's 2-cycle doubles
FOLD_OF_3 = 1 + np.sqrt(8)
POINTS = 1e-12  # of well-conditioned orbits
NEAR_BIRTH = 1e-9  # where a small step of Newton's method is taken for exact


@pytest.fixture(scope="module")
def doubling():
    """Logistic map from a stable fixed point into chaos."""
    return bifurcation_diagram(logistic(), "r", np.linspace(2.9, 3.7, 161), max_period=4)


@pytest.fixture(scope="module")
def window():
    """Logistic map around the birth of its 3-cycles."""
    return bifurcation_diagram(logistic(), "r", np.linspace(3.80, 3.86, 121), max_period=3)


def test_one_survey_serves_a_diagram_and_a_list():
    f, values = logistic(), np.linspace(2.9, 3.2, 31)
    survey = Survey(Family(f, "r"), 2.9, 3.2, 2)
    survey.run(N_LISTS)
    assert diagram_of(survey, values, Work()) == bifurcation_diagram(f, "r", values, max_period=2)
    assert bifurcations_of(survey, Work()) == bifurcations(f, "r", (2.9, 3.2), max_period=2)


def two_cycle(r):
    root = np.sqrt((r - 3) * (r + 1))
    return (r + 1 - root) / (2 * r), (r + 1 + root) / (2 * r)


class TestOrbits:
    def test_the_fixed_point_is_there_at_every_value(self, doubling):
        nonzero = max(doubling.of_period(1), key=lambda orbit: orbit.points[0, 0])
        r = doubling.values
        np.testing.assert_allclose(nonzero.points[:, 0], 1 - 1 / r, rtol=0, atol=POINTS)
        np.testing.assert_allclose(nonzero.multipliers, 2 - r, rtol=0, atol=NEAR_BIRTH)
        assert [end.reason for end in nonzero.ends] == ["end of range"] * 2

    def test_the_2_cycle_begins_where_the_fixed_point_flips(self, doubling):
        (orbit,) = doubling.of_period(2)
        r = doubling.values
        assert orbit.ends[0].reason == "flip"
        assert orbit.ends[0].value == pytest.approx(3.0, abs=1e-10)
        np.testing.assert_allclose(orbit.ends[0].points, 2 / 3, rtol=0, atol=1e-9)
        np.testing.assert_array_equal(orbit.exists, r > orbit.ends[0].value)
        low, high = two_cycle(r[orbit.exists])
        found = np.sort(orbit.points[orbit.exists], axis=1)
        np.testing.assert_allclose(found, np.column_stack([low, high]), rtol=0, atol=NEAR_BIRTH)

    def test_columns_follow_one_point(self, doubling):
        for orbit in doubling.orbits:
            steps = np.abs(np.diff(orbit.points[orbit.exists], axis=0))
            apart = np.diff(np.sort(orbit.points[orbit.exists], axis=1), axis=1)
            if orbit.period > 1:
                assert np.median(steps) < 0.1 * np.median(apart)

    def test_multipliers_are_those_of_the_2_cycle(self, doubling):
        (orbit,) = doubling.of_period(2)
        r = doubling.values[orbit.exists]
        expected = 4 + 2 * r - r**2
        np.testing.assert_allclose(orbit.multipliers[orbit.exists], expected, rtol=0, atol=1e-7)
        stable = doubling.values[orbit.stable]
        assert stable.max() < FLIP_OF_2 < stable.max() + 0.005

    def test_both_3_cycles_begin_in_the_fold_with_the_same_points(self, window):
        pair = window.of_period(3)
        assert [orbit.ends[0].reason for orbit in pair] == ["fold", "fold"]
        for orbit in pair:
            assert orbit.ends[0].value == pytest.approx(FOLD_OF_3, abs=1e-10)
            np.testing.assert_array_equal(orbit.exists, window.values > FOLD_OF_3)
        one, other = (np.sort(orbit.ends[0].points) for orbit in pair)
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)
        first = np.flatnonzero(pair[0].exists)[0]
        assert (pair[0].multipliers[first] - 1) * (pair[1].multipliers[first] - 1) < 0

    def test_every_point_is_on_its_orbit(self, window):
        for orbit in window.orbits:
            for k in np.flatnonzero(orbit.exists)[::17]:
                image = logistic(window.values[k])(orbit.points[k])
                np.testing.assert_allclose(image, np.roll(orbit.points[k], -1), rtol=0, atol=POINTS)

    def test_nothing_stays_open(self, doubling, window):
        assert doubling.unresolved == window.unresolved == ()


class TestAttractors:
    def rows(self, diagram, low, high):
        at = diagram.values[diagram.attractors.where]
        return np.flatnonzero((at >= low) & (at <= high))

    def test_one_attractor_at_every_value(self, doubling, window):
        for diagram in (doubling, window):
            assert diagram.attractors.where.tolist() == list(range(len(diagram.values)))

    def test_stable_orbits_are_the_attractors(self, doubling):
        table = doubling.attractors
        rows = self.rows(doubling, 3.05, 3.4)
        assert set(table.period[rows]) == {2}
        low, high = two_cycle(doubling.values[table.where[rows]])
        found = np.sort(table.points[rows, :2], axis=1)
        np.testing.assert_allclose(found, np.column_stack([low, high]), rtol=0, atol=POINTS)

    def test_cycles_longer_than_the_orbits_listed_are_recognised(self, doubling):
        # Period 8 from 3.5440903596 to 3.5644072661, 16 up to 3.5687594195 (Feigenbaum 1978).
        table = doubling.attractors
        assert set(table.period[self.rows(doubling, 3.55, 3.56)]) == {8}
        assert set(table.kind[self.rows(doubling, 3.55, 3.56)]) == {"periodic"}
        assert set(table.period[self.rows(doubling, 3.565, 3.5685)]) == {16}

    def test_chaos_has_a_positive_exponent_and_a_window_has_none(self, window):
        table = window.attractors
        before = self.rows(window, 3.80, 3.826)
        assert np.mean(table.kind[before] == "chaotic") > 0.9
        assert (table.lyapunov[before][table.kind[before] == "chaotic"] > 0).all()
        inside = self.rows(window, 3.829, 3.841)
        assert set(table.period[inside]) == {3}
        assert (table.lyapunov[inside] < 0).all()

    def test_chaotic_points_are_iterates(self, window):
        table = window.attractors
        row = int(np.flatnonzero(table.kind == "chaotic")[0])
        points = table.points[row]
        points = points[np.isfinite(points)]
        assert points.size == 64
        f = logistic(window.values[table.where[row]])
        np.testing.assert_allclose(f(points[:-1]), points[1:], rtol=0, atol=1e-15)

    def test_an_attractor_that_leaks_is_none(self):
        """The corner's second image 1 + b meets the left fixed point -2 at b = -3."""
        f = border_collision(a=1.5, b=-2.6, mu=1.0)
        values = np.linspace(-3.21, -2.61, 31)
        diagram = bifurcation_diagram(f, "b", values, max_period=1, window=(-9.0, 1.5))
        table = diagram.attractors
        kept = np.unique(values[table.where[table.kind == "chaotic"]])
        np.testing.assert_array_equal(kept, values[values > -3.0])
        assert set(table.kind) == {"chaotic"}

    def test_as_few_iterates_are_kept_as_are_asked_for(self):
        diagram = bifurcation_diagram(
            tent(1.5), "slope", np.linspace(1.5, 1.9, 9), max_period=1, iterates=3
        )
        assert diagram.attractors.points.shape == (9, 3)
        np.testing.assert_allclose(diagram.attractors.lyapunov, np.log(diagram.values), rtol=1e-14)

    def test_the_search_can_be_left_out(self):
        diagram = bifurcation_diagram(
            logistic(), "r", np.linspace(3.5, 3.6, 21), max_period=1, attractors=False
        )
        assert len(diagram.attractors) == 0
        assert len(diagram.orbits) == 2


class TestBreakpoints:
    def test_jumps_are_lines(self):
        f = border_collision(a=0.4, b=0.3, mu=0.5, jump=-1.2)
        diagram = bifurcation_diagram(f, "mu", np.linspace(0.1, 0.9, 33), max_period=2)
        (line,) = diagram.breakpoints
        assert line.kind == "jump"
        np.testing.assert_allclose(line.d, 0.0, rtol=0, atol=1e-10)

    def test_period_adding_in_a_jump(self):
        """Between fixed points only cycles: a x + mu and b x + mu - 1, slopes below 1."""
        f = border_collision(a=0.5, b=0.5, mu=0.5, jump=-1.0)
        diagram = bifurcation_diagram(f, "mu", np.linspace(-0.05, 1.05, 111), max_period=2)
        table = diagram.attractors
        assert set(table.kind) == {"periodic"}
        assert set(table.where) == set(range(111))
        (two,) = diagram.of_period(2)
        # One point on each side: x = (a mu + mu - 1) / (1 - a b) < 0 ..., mu from 1/3 to 2/3.
        assert two.ends[0].value == pytest.approx(1 / 3, abs=1e-9)
        assert two.ends[1].value == pytest.approx(2 / 3, abs=1e-9)
        assert {end.reason for end in two.ends} == {"border_collision"}


@pytest.fixture(scope="module")
def coulomb():
    values = np.linspace(0.0366, 0.0372, 61)
    return of_a_system(examples.coulomb(), "V", values, n_lists=5)


class TestPaper:
    """The paper's Coulomb system, on few values."""

    def test_s4_ends_at_its_jump(self, coulomb):
        (s4,) = coulomb.of_period(4)
        assert s4.ends[1].reason == "border_collision"
        assert s4.ends[1].value == pytest.approx(0.036975923520307, abs=1e-14)
        np.testing.assert_array_equal(s4.exists, coulomb.values < s4.ends[1].value)
        lines = np.array([line.d for line in coulomb.breakpoints])
        beside = int(np.flatnonzero(s4.exists)[-1])
        assert np.abs(lines[:, beside, None] - s4.points[beside]).min() < 1e-4

    def test_orbits_are_those_of_the_paper(self, coulomb):
        ones = sorted(orbit.points[0, 0] for orbit in coulomb.of_period(1))
        expected = [-0.039914313410282, 0.088613323894202, 0.371625700599026]
        np.testing.assert_allclose(ones, expected, rtol=0, atol=1e-13)
        assert len(coulomb.orbits) == 4

    def test_long_cycles_follow(self, coulomb):
        table = coulomb.attractors
        at = coulomb.values[table.where]
        for V, period in ((0.0370, 83), (0.0371, 63), (0.0372, 55)):
            assert set(table.period[np.isclose(at, V, rtol=0, atol=1e-12)]) == {1, period}

    def test_breakpoints_are_those_of_the_table(self, coulomb):
        f = event_map(examples.coulomb(V=float(coulomb.values[20])))
        jumps = [item.d for item in _breakpoints(f)]
        found = sorted(line.d[20] for line in coulomb.breakpoints)
        np.testing.assert_allclose(found, jumps, rtol=0, atol=1e-11)


def _breakpoints(f):
    from stickslip.analysis.branches.branches import breakpoints

    return breakpoints(f).of_kind("jump", "corner", "edge")


class TestResult:
    def test_table_and_text_tell_where_orbits_are(self, doubling):
        rows = list(doubling.overview().rows())
        assert [row["period"] for row in rows] == [orbit.period for orbit in doubling.orbits]
        two = next(row for row in rows if row["period"] == 2)
        assert (two["begins"], two["ends"]) == ("flip", "end of range")
        assert two["stable_to"] < FLIP_OF_2
        text = repr(doubling)
        assert "161 values" in text
        assert "flip" in text
        assert max(map(len, text.splitlines())) <= 120

    def test_saved_and_loaded_it_is_the_same(self, window, tmp_path):
        path = tmp_path / "diagram.json"
        window.save(path)
        again = load(path)
        assert isinstance(again, Diagram)
        np.testing.assert_array_equal(again.values, window.values)
        for one, other in zip(again.orbits, window.orbits, strict=True):
            np.testing.assert_array_equal(one.points, other.points)
            assert one.ends[0].value == other.ends[0].value
        np.testing.assert_array_equal(again.attractors.points, window.attractors.points)
        assert repr(again) == repr(window)

    def test_without_any_attractor_there_is_a_table(self, tmp_path):
        f = PiecewiseMap(lambda x, a: x + 10 + a, (-1, 1), parameters={"a": 0.0})
        diagram = bifurcation_diagram(f, "a", (0, 1, 5), n_lists=2)
        assert len(diagram.attractors) == diagram.table().n_rows == 0
        diagram.save(tmp_path / "diagram.csv")

    def test_labelled_arrays(self, doubling):
        pytest.importorskip("xarray", reason="xarray is an extra")
        data = doubling.to_xarray()
        assert data.orbit.dims == ("branch", "r", "point")
        np.testing.assert_array_equal(data.r, doubling.values)
        np.testing.assert_array_equal(data.multiplier[0], doubling.orbits[0].multipliers)

    @pytest.mark.parametrize("share", [0.2, 0.45])
    def test_interrupted_diagrams_say_where_they_end(self, share):
        def interrupt(done):
            if done > share:
                raise KeyboardInterrupt

        grid = np.linspace(1.4, 1.6, 130)
        found = bifurcation_diagram(
            tent(1.5), "slope", grid, max_period=1, progress=interrupt, partial=True
        )
        assert "interrupted" in "".join(found.unresolved)
        assert set(found.values) <= set(grid)
        assert len(found.values) < len(grid)
        assert len(found.attractors.where) >= len(found.values)

    def test_progress_rises_to_one(self):
        seen = []
        bifurcation_diagram(
            tent(1.5), "slope", np.linspace(1.4, 1.6, 130), max_period=1, progress=seen.append
        )
        assert seen == sorted(seen)
        assert seen[-1] == 1.0
        assert len([share for share in seen if 0.6 < share < 1.0]) >= 10

    def test_processes_change_nothing(self, two_processes, doubling):
        with two_processes():
            found = bifurcation_diagram(logistic(), "r", doubling.values, max_period=4)
        for one, other in zip(found.orbits, doubling.orbits, strict=True):
            np.testing.assert_array_equal(one.points, other.points)
        np.testing.assert_array_equal(found.attractors.points, doubling.attractors.points)


class TestErrors:
    @pytest.mark.parametrize(
        "values",
        [[3.0], [3.2, 3.1], [3.0, np.nan], 3.0, [[3.0, 3.1]], (3.2, 3.1, 2), (3.0, 3.1), (3, 4, 1)],
    )
    def test_values_are_a_grid_or_ascending_numbers(self, values):
        with pytest.raises(ValueError, match="grid"):
            bifurcation_diagram(logistic(), "r", values)

    def test_a_tuple_is_a_grid_as_in_a_sweep(self):
        diagram = bifurcation_diagram(logistic(), "r", (2.8, 2.9, 5), max_period=1, n_lists=2)
        assert diagram.values.tolist() == np.linspace(2.8, 2.9, 5).tolist()

    @pytest.mark.parametrize(
        ("name", "far"), [("V", 100), ("alpha", 1e9), ("damping", 1e3), ("V", -1), ("mu", 2)]
    )
    def test_values_far_outside_a_models_range_are_refused(self, name, far):
        model = examples.coulomb().replace(damping=0.1)
        ends = sorted([0.0366, far])
        with pytest.raises(ValueError, match=f"{name} = {far}"):
            of_a_system(model, name, ends)
        with pytest.raises(ValueError, match=f"{name} = {far}"):
            bifurcations(model, name, ends)

    def test_the_parameter_must_be_one(self):
        with pytest.raises(ValueError, match=r"'R' is not a parameter.*Did you mean 'r'"):
            bifurcation_diagram(logistic(), "R", [3.0, 3.1])

    @pytest.mark.parametrize(
        "wrong",
        [{"max_period": 0}, {"iterates": 0}, {"n_lists": 1}, {"max_period": 1.5}]
        + [{name: 1e16} for name in ("max_period", "iterates", "n_lists")],
    )
    def test_counts_are_checked(self, wrong):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            bifurcation_diagram(logistic(), "r", [3.0, 3.1], **wrong)

    def test_a_system_without_parameters_is_refused(self):
        with pytest.raises(ValueError, match=r"no parameters|neither a map"):
            of_a_system(logistic().power(2), "r", [3.0, 3.1])


def test_a_diagram_says_what_long_motions_hide():
    """Without kinetic friction hardly any motion returns: nothing else is there to be told."""
    f = event_map(examples.coulomb().replace(mu=0.0), max_events=300)
    grid = [0.0366, 0.0372]
    found = bifurcation_diagram(f, "V", grid, max_period=1, n_lists=2, attractors=False)
    assert not found.orbits
    narrow, given_up = sorted(found.unresolved, key=lambda told: "max_events" in told)
    assert narrow.endswith("narrow branches inside gaps, where motions are long")
    assert "raise max_events" in given_up
