"""Branches of orbits of a model: followed, kept, and followed on."""

import numpy as np
import pytest

import stickslip as ss

END = 0.036975923520307  # S4 meets the jump there


@pytest.fixture(scope="module")
def s4():
    model = ss.examples.coulomb()
    return model, ss.periodic_orbits(model, period=4)[0]


def test_a_model_is_as_good_as_its_map(s4):
    model, orbit = s4
    one = ss.follow(orbit, "V", (0.0366, 0.0372))
    again = ss.periodic_orbits(ss.event_map(model), period=4)[0]
    other = ss.follow(again, "V", (0.0366, 0.0372))
    assert np.array_equal(one.points, other.points)
    assert one.system == other.system == ss.event_map(model)
    assert one.ends[1].value == pytest.approx(END, abs=1e-12)


def test_kept_in_a_file_and_followed_on_with_the_model(s4, tmp_path):
    _, orbit = s4
    part = ss.follow(orbit, "V", (0.0365, 0.0367), window=(-0.6, 0.6))
    part.save(tmp_path / "s4.json")
    loaded = ss.load(tmp_path / "s4.json")
    assert loaded.system.window == (-0.6, 0.6)
    more = ss.follow(loaded, "V", (0.0365, 0.0372))
    assert more.end_reasons == ("end of range", "breakpoint")
    assert more.ends[1].value == pytest.approx(END, abs=1e-12)
    assert more.system.window == (-0.6, 0.6)


def test_texts_of_the_motions(s4):
    _, orbit = s4
    branch = ss.follow(orbit, "V", (0.0366, 0.0372))
    assert branch.at(V=0.0367).itinerary == orbit.itinerary


def test_a_map_without_parameters_cannot_be_continued():
    f = ss.PiecewiseMap(lambda x: 0.5 * x, (-1, 1))
    with pytest.raises(ValueError, match="'r' is not a parameter"):
        ss.follow(ss.periodic_orbits(f)[0], "r", (0, 1))
