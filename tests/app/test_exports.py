"""Views as files."""

import csv
import io
import json
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image
from tests.app.talk import CHAIN, COULOMB

import stickslip as ss
from stickslip.app.exports import formats
from stickslip.app.folder import presets
from stickslip.app.shipped import questions
from stickslip.mechanics.model.file import model_of_values
from stickslip.plot import animation

SAMPLED = 1e-2  # extremes of a curve and of its samples

ASKED = {
    "event_map": {"points": 60, "max_period": 1},
    "cobweb": {"d": 0.1, "n": 10},
    "motion": {"d": 0.1, "t_end": 20.0, "samples": 40},
    "portrait": {"d": 0.1, "t_end": 20.0, "block": 2},
    "plane": {"d": 0.1, "t_end": 20.0},
    "locus": {},
    "law": {"points": 11},
}


def export(client, view, kind, **request):
    body = {"view": view, "request": {"model": COULOMB, **request}, "format": kind}
    return client.post("/export", json=body)


@pytest.mark.parametrize("view", ASKED)
def test_every_format_of_a_view_parses(client, view):
    for kind in formats(view):
        if kind == "png" and view != "law":
            continue  # drawn as the SVG is
        reply = export(client, view, kind, **ASKED[view])
        assert reply.status_code == 200, reply.text
        assert reply.headers["content-disposition"].startswith("attachment")
        match kind:
            case "svg":
                assert ET.fromstring(reply.text).tag.endswith("svg")
            case "png":
                assert Image.open(io.BytesIO(reply.content)).format == "PNG"
            case "csv":
                rows = list(csv.reader(io.StringIO(reply.text)))
                assert len(rows) > 1
                assert len({len(row) for row in rows}) == 1
            case "json":
                assert json.loads(reply.text)["parts"]
            case "python":
                compile(reply.text, view, "exec")


def test_csv_has_the_numbers_to_the_last_digit(client):
    text = export(client, "motion", "csv", **ASKED["motion"]).text
    rows = list(csv.DictReader(io.StringIO(text)))
    t = np.array([float(row["t"]) for row in rows])
    x = np.array([[float(row["x_1"]), float(row["x_2"])] for row in rows])
    motion = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=20.0)
    np.testing.assert_array_equal(x, motion.x(t))


def test_a_diagram_s_bifurcations_stand_between_its_values(client):
    asked = {"parameter": "V", "range": [0.0369, 0.0371], "values": 9}
    rows = list(csv.DictReader(io.StringIO(export(client, "diagram", "csv", **asked).text)))
    values = [float(row["value"]) for row in rows]
    assert values == sorted(values)
    (row,) = [row for row in rows if row["kind"]]
    (found,) = ss.bifurcations(ss.examples.coulomb(), "V", (0.0369, 0.0371), max_period=4)
    assert row["kind"] == found.kind
    assert float(row["value"]) == found.value
    assert json.loads(row["points"]) == found.points.tolist()
    assert row["mechanism"] == found.mechanism


def test_a_picture_shows_what_is_seen_of_its_axes(client):
    """Of a map zoomed off its diagonal the picture was empty."""
    limits = {"xlim": [0.274, 0.284], "ylim": [-0.27, -0.2]}
    asked = {"points": 60, "max_period": 1, "window": limits["xlim"], "model": COULOMB}
    body = {"view": "event_map", "request": asked, "frame": limits}
    picture = client.post("/export", json={**body, "format": "png"}).content
    assert Image.open(io.BytesIO(picture)).size == (1200, 1200)
    names = {}
    exec(client.post("/export", json={**body, "format": "python"}).text, names)
    for name, ends in limits.items():
        assert list(getattr(names["ax"], f"get_{name}")()) == ends


def test_a_power_of_the_map_has_the_orbits_that_are_its_fixed_points(client):
    names = {}
    text = export(client, "event_map", "python", points=60, max_period=4, power=2).text
    exec(text, names)
    periods = {orbit.period for orbit in names["orbits"]}
    assert periods == {1, 2}
    drawn = [line for line in names["ax"].lines if line.get_label() in ("stable", "unstable")]
    assert drawn
    for line in drawn:
        np.testing.assert_array_equal(*line.get_data())


def test_basins_are_rows_of_intervals(client):
    rows = list(csv.DictReader(io.StringIO(export(client, "basins", "csv").text)))
    assert [float(row["left"]) for row in rows] == ss.basins(ss.examples.coulomb()).edges[
        :-1
    ].tolist()


@pytest.mark.parametrize("start", [{"d": 0.1}, {"model": CHAIN, "d": [0.1, -0.2]}])
def test_a_film_has_frames(client, start):
    reply = export(client, "mechanism", "gif", t_end=0.5, **start)
    assert reply.status_code == 200
    with Image.open(io.BytesIO(reply.content)) as film:
        assert film.n_frames == 3


def test_mp4_without_ffmpeg_is_said(client, monkeypatch):
    monkeypatch.setattr("shutil.which", lambda _: None)
    reply = export(client, "mechanism", "mp4", d=0.1)
    assert reply.status_code == 501
    assert "ffmpeg" in reply.json()["error"]["message"]


@pytest.mark.parametrize("ffmpeg", [None, "/usr/bin/ffmpeg"])
def test_a_page_offers_the_films_that_are_written_here(client, monkeypatch, ffmpeg):
    monkeypatch.setattr("shutil.which", lambda _: ffmpeg)
    offered = client.get("/static/shipped/limits.json").json()["exports"]["mechanism"]
    assert "gif" in offered
    assert ("mp4" in offered) == bool(ffmpeg)


def test_a_film_of_another_ending_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"\.gif"):
        animation.film(None, str(tmp_path / "x.avi"))


@pytest.mark.parametrize(
    ("view", "kind", "request_", "field"),
    [
        ("law", "exe", {}, "format"),
        ("nothing", "svg", {}, "view"),
        ("law", "svg", {"range": -1}, "range"),
        ("portrait", "svg", {"d": 0.1, "block": 3}, "block"),
        ("locus", "csv", {}, "format"),
        ("motion", "gif", {"d": 0.1}, "format"),
        ("portrait", "python", {"d": 0.1, "block": 3}, "block"),
        ("cobweb", "python", {"d": 9.0}, "d"),
        ("locus", "python", {"model": CHAIN}, "model.kind"),
        ("plane", "python", {"model": CHAIN, "d": [0.1, -0.2]}, "model.kind"),
        ("diagram", "python", {"parameter": "U", "range": [0.1, 0.2]}, "parameter"),
        ("diagram", "python", {"parameter": "V", "range": [0.2, 0.1]}, "range"),
    ],
)
def test_what_cannot_be_exported_is_said(client, view, kind, request_, field):
    reply = export(client, view, kind, **request_)
    assert reply.status_code == 422
    assert reply.json()["error"]["field"] == field


def test_large_and_broken_requests_are_refused(client):
    assert client.post("/export", content=b"{" * 70_000).status_code == 413
    assert client.post("/export", content=b"{").status_code == 422
    assert client.get("/export").status_code == 405


def test_a_formula_is_written_as_python(client):
    law = {"law": "mu + (1 - mu) * exp(-s / v)", "mu": 0.3, "v": 0.1, "forward": "exp(-s)"}
    text = export(client, "law", "python", model={**COULOMB, "friction": law}).text
    line = next(line for line in text.splitlines() if line.startswith("model = "))
    made = ss.friction_law(law["law"], parameters={"mu": 0.3, "v": 0.1}, forward="exp(-s)")
    assert eval(line.removeprefix("model = "), {"ss": ss}).friction == made


STATES = {preset["name"]: preset["state"] for preset in presets()}


def motion_of(preset):
    """Ask for a preset's motion as its page does."""
    asked = (request for slot, _, request in questions(STATES[preset]) if slot == "motion")
    return {"model": STATES[preset]["model"], **next(asked)}


@pytest.mark.parametrize("preset", ["rubbing", "hunting-axis", "brake"])
def test_a_portrait_of_a_structure_is_of_the_contact(client, preset):
    """Coordinates of the state were drawn in its place, where there are as many."""
    request = motion_of(preset)
    rows = list(csv.DictReader(io.StringIO(export(client, "mechanism", "csv", **request).text)))
    contacts = sum(name.startswith("u_") for name in rows[0])
    assert contacts == model_of_values(request["model"]).n_blocks
    del request["samples"]
    for k in range(1, contacts + 1):
        assert export(client, "portrait", "svg", block=k, **request).status_code == 200
        names = {}
        exec(export(client, "portrait", "python", block=k, **request).text, names)
        drawn = np.concatenate([line.get_data() for line in names["ax"].lines[1:]], axis=1)
        for told, seen in zip(("u", "w"), drawn, strict=True):
            column = [float(row[f"{told}_{k}"]) for row in rows]
            ends = [np.nanmin(seen), np.nanmax(seen)]
            assert ends == pytest.approx([min(column), max(column)], abs=SAMPLED)


def test_a_mechanism_that_is_no_row_of_blocks_is_not_drawn_but_told(client):
    request = motion_of("brake")
    reply = export(client, "mechanism", "svg", **request)
    assert reply.status_code == 422
    assert "of blocks on one belt" in reply.json()["error"]["message"]
    assert export(client, "mechanism", "json", **request).json()["parts"]
    assert "ax = motion.plot()" in export(client, "mechanism", "python", **request).text


def test_columns_of_a_plane_are_named_by_its_coordinates(client):
    state = STATES["brake"]
    request = {"model": state["model"], "section": state["section"], "resolution": 0.1}
    text = export(client, "basins", "csv", **request).text
    assert text.splitlines()[0] == "x_2,v_2,attractor"
