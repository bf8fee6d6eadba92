"""Maps restricted to a part of their domain."""

import math

import numpy as np
import pytest
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip import examples as models
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.branches.table import branch_table
from stickslip.analysis.maps.derived import WindowMap, windowed
from stickslip.analysis.maps.protocol import Map1D, MapFamily, Mechanism, iterate, sample
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.event_map import EventMap

UPPER = (0.5, 1.0)


@pytest.fixture(scope="module")
def logistic():
    return examples.logistic(3.9)


def test_is_a_family(logistic):
    window = WindowMap(logistic, UPPER)
    assert isinstance(window, Map1D)
    assert isinstance(window, MapFamily)
    assert window.parameters == {"r": 3.9}
    moved = window.replace(r=3.5)
    assert moved.whole.parameters == {"r": 3.5}
    assert moved.window == UPPER
    assert moved(0.75) == moved.whole(0.75)
    assert window.parameter_derivative(0.75, "r") == 0.1875


def test_equal_windows_of_one_map_are_equal_and_share_a_table(logistic):
    first, second = WindowMap(logistic, (0.5, 1)), WindowMap(logistic, [0.5, 1.0])
    assert first == second
    assert hash(first) == hash(second)
    assert branch_table(first) is branch_table(second)


def test_orbits_are_those_that_stay(logistic):
    inside = {tuple(o.points) for o in periodic_orbits(WindowMap(logistic, UPPER), 3)}
    staying = {
        tuple(o.points) for o in periodic_orbits(logistic, 3) if (o.points >= UPPER[0]).all()
    }
    assert len(staying) == len(inside) > 0
    assert sorted(inside) == [pytest.approx(orbit, abs=1e-14) for orbit in sorted(staying)]


def test_iterates_end_where_they_leave(logistic):
    window = WindowMap(logistic, UPPER)
    orbits = window.iterate([0.55, 0.7, 0.9], 6)
    assert np.array_equal(orbits, iterate(window, [0.55, 0.7, 0.9], 6), equal_nan=True)
    assert math.isnan(orbits[2, -1])
    assert orbits[2, 1] == logistic(0.9) < UPPER[0]


class Told(ss.PiecewiseMap):
    """A map that says why it breaks, of points in its domain alone, as maps of models do."""

    def explain_break(self, left, right):
        self.evaluate([left, right])
        return Mechanism("", None)


def test_a_power_breaks_where_an_orbit_leaves_and_says_so():
    """A hunting axis at one end of its slider: its map's own refusal came out."""
    f = Told("3*x/2", (0.0, 1.0))
    (edge,) = (b for b in ss.breakpoints(f.power(2)) if 0.0 < b.d < 1.0)
    np.testing.assert_allclose(edge.d, 2 / 3, rtol=1e-9)
    assert edge.mechanism == "the orbit has left the domain (iterate 2)"


def test_powers_have_no_value_where_orbits_leave(logistic):
    square = WindowMap(logistic, UPPER).power(2)
    values = sample(square, [0.7, 0.9])
    assert values.value[0] == logistic(logistic(0.7))
    assert math.isnan(values.value[1])
    # 0.5 is the image of one point right of 1/2: from there on f leaves.
    (gap,) = branch_table(square).gaps
    assert gap == pytest.approx([0.5 + math.sqrt(0.25 - 0.5 / 3.9), 1.0], abs=1e-12)


def test_attractors_of_a_window(logistic):
    (found,) = attractors(WindowMap(logistic.replace(r=3.2), (0.4, 0.9)))
    assert found.kind == "periodic"
    assert found.period == 2


def test_event_maps_keep_their_itineraries():
    f = EventMap(models.coulomb())
    window = WindowMap(f, (-0.3, 0.0))
    assert window.itinerary(-0.1) == f.itinerary(-0.1)
    assert window.whole is f
    (orbit,) = periodic_orbits(window)
    assert orbit.itinerary == (f.itinerary(orbit.points[0]),)


def test_maps_without_texts_have_none_in_a_window(logistic):
    assert not hasattr(WindowMap(logistic, UPPER), "itinerary")
    assert WindowMap(examples.tent(), UPPER).power(2).itinerary(0.75) == "1 | 1"


def test_is_clipped_to_a_domain_that_moves():
    f = EventMap(models.coulomb())
    window = WindowMap(f, (0.0, 5.0))
    assert window.domain == (0.0, f.domain[1])
    assert window.replace(beta=1.0).domain == (0.0, f.replace(beta=1.0).domain[1])


def test_windows_of_windows(logistic):
    inner = WindowMap(WindowMap(logistic, (0.2, 0.9)), UPPER)
    assert inner.whole is logistic
    assert inner.domain == (0.5, 0.9)


def test_no_window_is_the_map_itself(logistic):
    assert windowed(logistic, None) is logistic
    assert windowed(logistic, UPPER) == WindowMap(logistic, UPPER)


@pytest.mark.parametrize(
    ("window", "said"),
    [
        ((0.5, 0.5), "lo < hi"),
        ((0.9, 0.5), "lo < hi"),
        ((0.5, math.nan), "finite"),
        ((0.5, math.inf), "finite"),
        (0.5, "pair of numbers"),
        ("ab", "finite number"),
        ((0.1, 0.2, 0.3), "pair of numbers"),
        ((1.5, 2.0), "does not meet the domain"),
        ((1.0, 2.0), "does not meet the domain"),
    ],
)
def test_bad_windows(logistic, window, said):
    with pytest.raises(ValueError, match="window") as error:
        WindowMap(logistic, window)
    assert said in str(error.value)


def test_points_outside_are_an_error(logistic):
    window = WindowMap(logistic, UPPER)
    for call in (
        window.evaluate, window, window.derivative, lambda x: window.parameter_derivative(x, "r"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=r"0\.25 is outside the domain"):
            call(0.25)
