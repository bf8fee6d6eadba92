"""One verb for following anything: what it takes, what it refuses, and steady sliding."""

import numpy as np
import pytest

import stickslip as ss
from stickslip.analysis.continuation.curve import Curve
from stickslip.results.files import save

BLOCK = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.0)


def logistic(r=3.2):
    return ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": r})


@pytest.fixture(scope="module")
def orbit():
    return ss.periodic_orbits(logistic())[1]


def kept(folder, thing, system=None):
    """Save and load."""
    save(thing, folder / "thing.json")
    return ss.load(folder / "thing.json", system)


# ------------------------------------------------------------------ steady sliding


def test_steady_sliding_along_the_damping_in_closed_form():
    """y'' + (c + F'(V)) y' + y = 0 with F = 1 / (1 + 3 s): the Hopf point is at 3 / (1 + 3 V)^2."""
    (sliding,) = ss.equilibria(BLOCK)
    curve = ss.follow(sliding, "damping", (0.5, 3.0))
    (hopf,) = curve.bifurcations
    assert (curve.kind, hopf.kind) == ("equilibrium", "hopf")
    assert hopf.value == pytest.approx(3 / 1.6**2, abs=1e-14)
    assert hopf.multiplier.imag == pytest.approx(1.0, abs=1e-14)
    slope = curve.values - 3 / 1.6**2
    root = np.sqrt((slope**2 / 4 - 1).astype(complex))
    np.testing.assert_allclose(curve.multipliers[:, 0], -slope / 2 + root, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(curve.stable, curve.values > hopf.value)
    assert curve.points == pytest.approx(1 / 1.6)
    assert curve.values[hopf.row] <= hopf.value < curve.values[hopf.row + 1]
    there = curve.at(damping=2.0)
    assert there.model == BLOCK.replace(damping=2.0)
    assert there.stable
    assert curve[0].model.damping == 0.5
    assert curve.plot().get_xlabel() == "damping"


def test_along_the_speed_the_hopf_points_are_those_of_the_search():
    model = ss.Oscillator(V=0.4, friction=ss.PoppStelter(gamma=3, delta=0.2, eta=0.1), damping=0.05)
    (sliding,) = ss.equilibria(model)
    curve = ss.follow(sliding, "V", (0.1, 3.0))
    assert [item.value for item in curve.bifurcations] == pytest.approx(
        list(sliding.critical_speeds), abs=1e-13
    )
    with pytest.raises(ValueError, match="V must be a finite number > 0"):
        ss.follow(sliding, "V", (0.0, 1.0))
    with pytest.raises(ValueError, match="does not contain V"):
        ss.follow(sliding, "V", (0.5, 1.0))
    with pytest.raises(ValueError, match="'gama' is not a parameter"):
        ss.follow(sliding, "gama", (0.5, 1.0))
    assert curve.plot().get_xlabel() == r"$V_{\mathrm{dr}}$"


# ------------------------------------------------------------------ what is found knows its system


def test_what_is_found_knows_its_system(orbit):
    f = logistic()
    assert orbit.system == f or orbit.system.parameters == f.parameters
    curve = ss.follow(orbit, "r", (2.5, 3.4))
    assert isinstance(curve, Curve)
    assert curve.at(r=3.0).system.parameters == {"r": 3.0}
    assert curve[0].system.parameters == {"r": 2.5}
    (flip,) = ss.bifurcations(f, "r", (2.9, 3.2), max_period=1, n_lists=5)
    assert flip.system.parameters == {"r": 3.2}
    assert flip.orbits_before[0].system.parameters["r"] < 3.0
    assert ss.attractors(f, rng=1)[0].orbit.system.parameters == {"r": 3.2}
    assert ss.breakpoints(ss.examples.coulomb())[0].system == ss.event_map(ss.examples.coulomb())


def test_a_bifurcation_solved_anew_can_be_followed(tmp_path):
    f = ss.PiecewiseMap(
        lambda x, a, b: a - x * x + b * x, (-9, 9), parameters={"a": 0.75, "b": 0.0}
    )
    (flip,) = ss.bifurcations(f, "a", (0.6, 0.9), max_period=1, n_lists=5)
    curve = ss.follow(flip, "b", (-0.5, 0.5), solve_for="a")
    there = curve.at(b=0.3)
    assert (there.kind, there.parameter) == ("flip", "a")
    assert there.value == pytest.approx(0.8775, abs=1e-12)
    again = ss.follow(there, "b", (0.2, 0.4), solve_for="a")
    assert again.at(b=0.25).value == pytest.approx(1.25 * 2.75 / 4, abs=1e-12)
    with pytest.raises(ValueError, match="say which other one is solved for, such as 'a'"):
        ss.follow(flip, "b", (-0.5, 0.5))
    loaded = kept(tmp_path, curve, f)
    assert loaded.at(b=0.3).value == there.value


def test_loaded_without_its_system_it_cannot_be_followed(orbit, tmp_path):
    loaded = kept(tmp_path, orbit)
    assert loaded.system is None
    with pytest.raises(ValueError, match=r"load\(path, system=\.\.\.\)"):
        ss.follow(loaded, "r", (3.0, 3.4))
    given = kept(tmp_path, orbit, logistic())
    assert ss.follow(given, "r", (3.0, 3.4)).end_reasons == ("end of range", "end of range")


def test_a_map_is_written_once(tmp_path):
    model = ss.examples.coulomb()
    found = ss.breakpoints(model)
    loaded = kept(tmp_path, found)
    assert (tmp_path / "thing.json").read_text().count('"event map"') == 1
    assert len({id(item.system) for item in loaded}) == 1
    assert loaded[0].system == ss.event_map(model)


# ------------------------------------------------------------------ solutions at a value


def test_near_says_which_solution_is_meant():
    orbit = ss.periodic_orbits(logistic(3.9), period=3)[0]
    curve = ss.follow(orbit, "r", (3.8, 4.0))
    found = curve.all_at(r=3.84)
    assert len(found) == 2
    with pytest.raises(ValueError, match=r"passes r = 3\.84 2 times, at .*near="):
        curve.at(r=3.84)
    for each in found:
        got = curve.at(r=3.84, near=float(each.points[0]))
        np.testing.assert_array_equal(got.points, each.points)


def test_a_cycle_is_solved_anew():
    cycle = ss.find_cycle(BLOCK, [0.9], [0.0])
    curve = ss.follow(cycle, "damping", (0.9, 1.1))
    there = curve.at(damping=1.03)
    again = ss.find_cycle(BLOCK.replace(damping=1.03), [0.9], [0.0])
    assert there.model == again.model
    assert there.period == pytest.approx(again.period, abs=1e-11)
    assert there.residual < 1e-11
    with pytest.raises(ValueError, match=r"damping = 1\.2 is outside the curve"):
        curve.at(damping=1.2)
    assert list(curve.table())[:3] == ["damping", "multiplier", "stable"]


# ------------------------------------------------------------------ refusals


@pytest.mark.parametrize(
    ("option", "said"),
    [
        ({"solve_for": "b"}, "solve_for is for bifurcations"),
        ({"max_points": 0}, "max_points"),
        ({"max_step": 2.0}, "max_step"),
    ],
)
def test_options_of_an_orbit(orbit, option, said):
    with pytest.raises(ValueError, match=said):
        ss.follow(orbit, "r", (3.0, 3.4), **option)


@pytest.mark.parametrize("name", ["window", "max_step", "max_points", "solve_for"])
def test_options_without_meaning_are_named(name):
    (sliding,) = ss.equilibria(BLOCK)
    with pytest.raises(ValueError, match=f"^{name} is for .*; an equilibrium takes none"):
        ss.follow(sliding, "damping", (0.5, 3.0), **{name: (0.0, 1.0)})


def test_windows_are_for_lines():
    f = ss.Map(lambda z, a: a - z**2, 1, parameters={"a": 0.2}, domain=[(-2, 2)])
    curve = ss.follow(ss.periodic_orbits(f, 1)[0], "a", (0.1, 0.3))
    with pytest.raises(ValueError, match=r"window is for .* a curve in R.n takes none"):
        ss.follow(curve, "a", (0.0, 0.4), window=(0, 1))


def test_other_things_are_refused(orbit):
    with pytest.raises(ValueError, match=r"thing = 3 cannot be followed. What can: an orbit"):
        ss.follow(3, "r", (0, 1))
    (sliding,) = ss.equilibria(BLOCK)
    with pytest.raises(ValueError, match="of kind 'equilibrium' does not go on"):
        ss.follow(ss.follow(sliding, "damping", (0.5, 3.0)), "damping", (0.1, 3.0))
