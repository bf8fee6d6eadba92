"""Structures in the explorer: their maps, what they are made of, motions by contacts, own files."""

import json

import numpy as np
import pytest
from starlette.testclient import TestClient
from tests.app.test_views import numbers_of

import stickslip as ss
from stickslip.app import requests
from stickslip.app.folder import presets
from stickslip.app.server import application
from stickslip.app.views.model import assembly
from stickslip.cli.program import run
from stickslip.mechanics.model.file import model_of_values, model_values

PRESETS = {preset["name"]: preset["state"] for preset in presets()}
OF_STUDIES = ("brake", "drill-string", "hunting-axis", "bowed-string", "rubbing", "blade")
OWN = """
kind = "structure"
mass = [1.0, 0.5]
stiffness = [[2.0, -1.0], [-1.0, 1.0]]

[[contact]]
at = 0
V = 0.1
friction = "coulomb:mu=0.3"

[[contact]]
at = [0, 1]
static = 0.4
friction = "coulomb:mu=0.5"
"""


@pytest.mark.parametrize("name", OF_STUDIES)
def test_sliders_of_presets_are_parameters_within_their_ranges(name):
    state = PRESETS[name]
    parameters = model_of_values(state["model"]).parameters
    for parameter, (low, high) in state["sliders"].items():
        assert low <= parameters[parameter] <= high
        for end in (low, high):
            model_of_values(state["model"]).replace(**{parameter: end})


def test_which_map_a_model_has_is_told(page):
    kinds = {}
    for name in OF_STUDIES:
        state = PRESETS[name]
        asked = {"model": state["model"], "section": state.get("section")}
        told = page.parts("returns", **asked)["returns"].data
        told.pop("part_name")
        assert told == json.loads(json.dumps(state["map"]))
        kinds[name] = told["kind"]
        assert bool(told["why"]) == (told["kind"] == "none")
    assert kinds == {
        "brake": "space",
        "drill-string": "line",
        "hunting-axis": "line",
        "bowed-string": "none",
        "rubbing": "none",
        "blade": "none",
    }
    assert "contacts that share inertia" in PRESETS["rubbing"]["map"]["why"]
    assert PRESETS["rubbing"]["map"]["why"].startswith("This model has contacts")


@pytest.mark.parametrize("name", ["drill-string", "hunting-axis", "canards"])
def test_a_return_map_of_the_line_is_that_of_the_library(page, name):
    state = PRESETS[name]
    asked = {"model": state["model"], "section": state["section"]}
    answer = page.parts("event_map", **asked, points=50, max_period=1)
    section = {key: value for key, value in state["section"].items() if value is not None}
    f = ss.return_map(model_of_values(state["model"]), **section)
    x, value = answer["samples"].arrays["x"], answer["samples"].arrays["f"]
    assert np.isfinite(value).any()
    np.testing.assert_array_equal(value, f(x))
    (orbit,) = ss.periodic_orbits(f, 1)
    told = answer["orbits"].data["orbits"][0]
    assert told["points"] == pytest.approx(orbit.points.tolist(), rel=1e-12)
    made = numbers_of("cobweb", **asked, d=state["d"], n=20)
    orbit = page.parts("cobweb", **asked, d=state["d"], n=20)["orbit"].arrays["orbit"]
    np.testing.assert_array_equal(made["orbit"], orbit)


def test_a_motion_from_a_point_of_a_map_begins_there_in_the_forcing_s_phase(page):
    state = PRESETS["canards"]
    asked = {"model": state["model"], "section": state["section"], "d": 5.0}
    motion = page.parts("motion", **asked, t_end=30.0, samples=10)["motion"]
    f = ss.return_map(model_of_values(state["model"]), direction="forward")
    again = next(e["t"] for e in motion.data["events"] if e["kind"] == "slip forward")
    phase = (5.0 + state["model"]["forcing"]["frequency"] * again) % (2 * np.pi)
    assert phase == pytest.approx(f(5.0), rel=1e-9)
    made = numbers_of("motion", **asked, t_end=30.0, samples=10)
    np.testing.assert_array_equal(made["x"], motion.arrays["x"])


def test_contacts_have_their_own_displacements(page):
    state = PRESETS["rubbing"]
    asked = {"model": state["model"], "x": state["x"] + [0.0], "v": state["v"]}
    motion = page.parts("motion", **asked, t_end=4.0, samples=20)["motion"]
    x, u, v, w = (motion.arrays[name] for name in ("x", "u", "v", "w"))
    assert x.shape[1] == 2
    assert motion.arrays["mode"].shape == u.shape == (len(x), 3)
    np.testing.assert_array_equal(u, np.column_stack([x, x[:, 1] - x[:, 0]]))
    np.testing.assert_array_equal(w, np.column_stack([v, v[:, 1] - v[:, 0]]))
    assert [contact["bodies"] for contact in motion.data["contacts"]] == [[0], [1], [1, 0]]
    assert {event["block"] for event in motion.data["events"]} == {1, 2, 3}


def test_a_displacement_that_no_state_tells_is_that_about_the_mean_velocity(page):
    state = PRESETS["drill-string"]
    asked = {"model": state["model"], "section": state["section"], "d": 5.9}
    motion = page.parts("motion", **asked, t_end=60.0, samples=4000)["motion"]
    t, u, w = (motion.arrays[name] for name in ("t", "u", "w"))
    assert motion.data["bodies"] == 0
    slopes = np.diff(u[:, 0]) / np.diff(t)
    drift = 0.5 * (w[1:, 0] + w[:-1, 0]) - slopes
    np.testing.assert_allclose(drift, drift[0], rtol=1e-6)
    assert np.ptp(u) < 20.0 < drift[0] * t[-1]
    hunting = PRESETS["hunting-axis"]
    asked = {"model": hunting["model"], "section": hunting["section"], "d": 0.05}
    motion = page.parts("motion", **asked, t_end=20.0, samples=100)["motion"]
    np.testing.assert_allclose(
        motion.arrays["u"][:, 0], motion.arrays["x"][:, 1], rtol=1e-12, atol=1e-15
    )


def test_what_a_model_is_made_of():
    told = assembly(model_of_values(PRESETS["blade"]["model"]))
    assert told["bodies"] == 3
    assert told["springs"] == [[0, 1, 1.0], [1, 2, 1.0], [0, -1, 1.0]]
    (contact,) = told["contacts"]
    assert (contact["bodies"], contact["elastic"]) == ([0], True)
    assert assembly(model_of_values(PRESETS["bowed-string"]["model"]))["bodies"] == 0
    two = assembly(ss.examples.coulomb())
    walls = [[k, -1, pytest.approx(1.0, rel=1e-12)] for k in (0, 1)]
    assert two["springs"] == [[0, 1, pytest.approx(1.2, rel=1e-12)], *walls]


def test_a_cycle_that_is_not_there_is_told_in_a_sentence(page):
    state = PRESETS["rubbing"]
    asked = {"model": state["model"], "x": [0.0, 0.0], "v": [0.0, 3.0]}
    told = page.parts("cycle", **asked)["cycle"].data
    assert "nothing but friction acts" in told["why"]


def test_sections_have_the_coordinates_of_the_map(page):
    state = PRESETS["brake"]
    asked = {"model": state["model"], "section": state["section"], "resolution": 0.1}
    parts = page.parts("basins", **asked)
    f = ss.return_map(model_of_values(state["model"]), domain=state["section"]["domain"])
    axes = [parts["basins"].arrays[name] for name in ("x", "y")]
    found = ss.basins(f, ss.attractors(f), grid=axes)
    index = parts["basins"].arrays["index"].reshape(found.index.shape)
    np.testing.assert_array_equal(index, found.index)
    assert 0.3 < (index == 0).mean() < 0.7


def test_what_would_keep_the_server_busy_is_refused(page):
    model = PRESETS["bowed-string"]["model"]
    stiff = [[1e8 * entry for entry in row] for row in model["stiffness"]]
    error = page.error("motion", model=model | {"stiffness": stiff}, x=[0.0] * 20, v=[0.0] * 20)
    assert "fastest motion has the rate" in error["message"]
    long = {**model, "contact": model["contact"] * 21}
    assert "takes at most 20" in page.error("law", model=long)["message"]


def test_python_of_structures_makes_equal_models():
    for name in OF_STUDIES:
        values = PRESETS[name]["model"]
        assert numbers_of("law", model=values)["model"] == model_of_values(values)


def test_a_cobweb_that_leaves_the_domain_says_so(page):
    """Of an axis without falling friction, which creeps to rest: each release is nearer to 0."""
    state = PRESETS["hunting-axis"]
    model = model_values(model_of_values(state["model"]).replace(mu_1=1.0))
    asked = {"model": model, "section": state["section"], "d": 0.055, "n": 20}
    part = page.parts("cobweb", **asked)["orbit"]
    assert np.isnan(part.arrays["orbit"][-1])
    assert part.data["end"]["status"] == "the orbit has left the domain"


def test_a_model_file_is_opened(tmp_path):
    with TestClient(application(warm=False), base_url="http://localhost") as client:
        reply = client.post("/open", content=OWN.encode())
        state = reply.json()["state"]
        assert reply.status_code == 200
        path = tmp_path / "own.toml"
        path.write_text(OWN)
        assert state["model"] == json.loads(json.dumps(model_values(ss.read_model(path))))
        assert state["map"]["kind"] == "none"
        marked = client.post("/open", content=b"\xef\xbb\xbf" + OWN.encode())  # as Windows saves
        assert marked.json() == reply.json()
        for wrong, told in (
            (b"kind = ", "not TOML"),
            (b'kind = "structre"', "structure"),
            (b"\n\xff", "not UTF-8 text: byte 0xff in line 2"),
            (OWN.encode() + b"#" * 70_000, "bytes at most"),
        ):
            reply = client.post("/open", content=wrong)
            assert reply.status_code == 422
            assert told in reply.json()["error"]


def test_the_command_opens_a_file_or_a_preset(tmp_path, capsys):
    path = tmp_path / "own.toml"
    path.write_text(OWN)
    assert run(["explore", "--model", str(path), "--preset", "law9"]) == 2
    assert "either --model or --preset" in capsys.readouterr().err
    path.write_text(OWN.replace("0.4", "-0.4"))
    assert run(["explore", "--model", str(path), "--no-browser", "--port", "0"]) == 2
    assert "static" in capsys.readouterr().err
    assert requests.fastest(ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.3))) == pytest.approx(
        1.0, rel=1e-12
    )
