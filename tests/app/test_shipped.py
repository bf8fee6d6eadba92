"""What comes with the package is what the library computes, and makes a page without a server."""

import json
import re
from pathlib import Path

import msgspec
import numpy as np
import pytest
from tests.app.talk import unpacked

import stickslip as ss
from stickslip.app import live, shipped
from stickslip.app.folder import LIMITS, PRESETS, preset_names, presets
from stickslip.app.page import described_limits, made_presets
from stickslip.cli.program import run
from stickslip.files import plain
from stickslip.mechanics.model.file import model_values

LISTED = shipped.listed()
SLOW = {  # 2 to 30 seconds each; there are others of their kinds
    *("law9-diagram.bin", "canards-diagram.bin", "damper-diagram.bin", "drill-string-diagram.bin"),
    *("hunting-axis-diagram.bin", "chain-basins.bin", "brake-basins.bin"),
    "bowed-string-cycle.bin",
}
SINGLE = 1e-6  # relative: arrays are shipped in single precision
DUST = 1e-9  # residuals and errors are of this size or smaller
MOST_BYTES = 700_000  # of all answers


def leaves(value):
    """Numbers, and everything else, in order."""
    if isinstance(value, dict):
        for name, item in value.items():
            yield name
            yield from leaves(item)
    elif isinstance(value, list):
        for item in value:
            yield from leaves(item)
    else:
        yield value


def close(one, other):
    if isinstance(one, float) and isinstance(other, (int, float)):
        return one == pytest.approx(other, rel=SINGLE, abs=DUST)
    return one == other


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in SLOW else ()) for n in LISTED]
)
def test_an_answer_that_is_shipped_is_the_library_s(name):
    kept, computed = unpacked(shipped.read(name)), unpacked(shipped.answer(*LISTED[name]))
    for one, other in zip(kept, computed, strict=True):
        assert one.name == other.name
        assert all(
            close(a, b) for a, b in zip(leaves(one.data), leaves(other.data), strict=True)
        ), one.name
        assert one.arrays.keys() == other.arrays.keys()
        for key, array in one.arrays.items():
            np.testing.assert_allclose(array, other.arrays[key], rtol=SINGLE, atol=SINGLE)


def test_the_presets_that_are_shipped_are_those_that_are_made():
    made = msgspec.json.decode(msgspec.json.encode(made_presets()))
    assert all(close(a, b) for a, b in zip(leaves(presets()), leaves(made), strict=True))


def test_the_limits_that_are_shipped_are_those_that_are_described():
    kept = msgspec.json.decode((shipped.SHIPPED / LIMITS).read_bytes())
    assert kept == msgspec.json.decode(msgspec.json.encode(described_limits()))


def test_the_list_names_every_preset_s_questions():
    entries = json.loads((shipped.SHIPPED / shipped.INDEX).read_text())
    listed = {entry["file"]: (entry["view"], entry["request"]) for entry in entries}
    assert listed == LISTED
    slots = {preset: set() for preset in preset_names()}
    for preset in presets():
        for slot, view, request in shipped.questions(preset["state"]):
            asked = view, plain({"model": preset["state"]["model"], **request})
            assert asked in LISTED.values()
            slots[preset["name"]].add(slot)
    assert slots["coulomb"] >= {"map", "basins", "diagram", "motion"}
    assert slots["chain"] == {"law", "cycle", "motion", "basins"}


def test_what_is_shipped_is_small():
    files = [file for file in shipped.SHIPPED.iterdir() if file.name.endswith(".bin")]
    assert {file.name for file in files} == set(LISTED)
    assert sum(len(file.read_bytes()) for file in files) < MOST_BYTES


def test_making_writes_what_is_read(tmp_path, monkeypatch, capsys):
    few = {name: LISTED[name] for name in ("coulomb-law.bin", "coulomb-map.bin")}
    monkeypatch.setattr(shipped, "listed", lambda: few)
    shipped.make(tmp_path / "made")
    assert {file.name for file in (tmp_path / "made").iterdir()} == {
        *few,
        shipped.INDEX,
        PRESETS,
        LIMITS,
    }
    (law,) = unpacked(shipped.read("coulomb-law.bin", tmp_path / "made"))
    assert law.arrays["force"].dtype == np.float32
    names = [part.name for part in unpacked(shipped.read("coulomb-map.bin", tmp_path / "made"))]
    assert names == ["orbits", "explained"]
    assert capsys.readouterr().out.count("\n") == len(few)


def test_a_motion_that_grows_beyond_single_precision_shows_its_beginning():
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.1)
    model = ss.Structure([1.0, 1.0], [[2.0, -1.0], [-1.0, -30.0]], contacts=[contact])
    asked = {"model": model_values(model), "x": [0.1, 0.1], "v": [0.0, 0.0], "t_end": 60.0}
    (motion,) = unpacked(shipped.answer("motion", plain(asked)))
    x = motion.arrays["x"]
    shown = np.isfinite(x)
    assert not np.isinf(x).any()
    assert 0.1 < shown.mean() < 1.0
    assert np.abs(x[shown]).max() > 1e30


def first_views(page):
    return json.loads((page / "static" / "shipped" / PRESETS).read_text())


def test_the_page_is_written_into_a_folder(tmp_path, capsys):
    folder = tmp_path / "page"
    older = folder / "static" / "shipped" / PRESETS
    older.parent.mkdir(parents=True)
    older.write_text("{}")  # by an older version
    (folder / "index.html").write_text("older")
    assert run(["explore", "--export", str(folder)]) == 3
    assert "index.html exists; --force replaces it" in capsys.readouterr().err
    assert (folder / "index.html").read_text() == "older"
    assert run(["explore", "--export", str(folder), "--force"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == str(folder / "index.html")
    assert "data-alone" in (folder / "index.html").read_text(encoding="utf-8")
    assert len(first_views(folder)) == len(preset_names())
    content = shipped.read("coulomb-map.bin", folder / "static" / "shipped")
    explained = list(unpacked(content))[-1].arrays
    f = ss.event_map(ss.examples.coulomb())
    inner = slice(5, None, 97)  # ends of branches have one-sided values
    x = explained["x"][inner].astype(float)
    np.testing.assert_allclose(f(x), explained["f"][inner], rtol=SINGLE, atol=1e-5)


def test_a_file_of_the_page_for_which_there_is_no_room_is_named(tmp_path, monkeypatch, capsys):
    resource = pytest.importorskip("resource")
    folder = tmp_path / "page"
    write = Path.write_bytes

    def full(path, content):
        if folder in path.parents:
            before = resource.getrlimit(resource.RLIMIT_FSIZE)
            resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
            try:
                return write(path, content)
            finally:
                resource.setrlimit(resource.RLIMIT_FSIZE, before)
        return write(path, content)

    monkeypatch.setattr(live, "LAWS", {})
    monkeypatch.setattr(Path, "write_bytes", full)
    assert run(["explore", "--export", str(folder)]) == 2
    said = capsys.readouterr().err
    assert re.fullmatch(rf"stickslip explore: cannot use {folder}/[^:]*: File too large\n", said)
    assert not (folder / "index.html").exists()


def test_the_page_is_written_into_one_file(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(live, "LAWS", {})  # which take long to compile
    page = tmp_path / "page.html"
    assert run(["explore", "--export", str(page)]) == 0
    assert capsys.readouterr().out == f"{page}\n"
    assert [file.name for file in tmp_path.iterdir()] == ["page.html"]
    text = page.read_text(encoding="utf-8")
    assert re.findall(r'(?:src|href)="([^"#]*)"', text) == []  # it loads nothing
    assert "from a web server" not in text
    assert run(["explore", "--export", str(page)]) == 3
    assert page.read_text(encoding="utf-8") == text


@pytest.mark.parametrize(
    ("model", "moved"),
    [
        (ss.examples.coulomb(), True),
        (ss.examples.law9(), True),
        (ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.2, viscous=0.1)), False),
        (ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.2), damping=0.1), False),
        (ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.2)), False),
    ],
)
def test_a_plant_that_the_page_cannot_move_is_told(model, moved, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(live, "write", lambda folder: None)  # which takes long
    monkeypatch.setattr(shipped, "questions", lambda state: ())
    ss.write_model(model, tmp_path / "mine.toml")
    page = tmp_path / "page"
    assert run(["explore", "--model", str(tmp_path / "mine.toml"), "--export", str(page)]) == 0
    told = "answers for mine.toml as it is, and no new motion"
    assert (told in capsys.readouterr().err) == (not moved)


@pytest.mark.parametrize(
    ("model", "slots"),
    [
        (ss.examples.coulomb(alpha=0.7, V=0.08), {"law", "map", "power", "cobweb", "basins"}),
        (ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.2)), {"law", "cycle"}),
    ],
)
def test_the_written_page_has_the_answers_for_a_plant_of_ones_own(
    model, slots, tmp_path, monkeypatch
):
    monkeypatch.setattr(live, "write", lambda folder: None)
    asked = shipped.questions
    later = {"diagram", "motion", "locus"}  # takes long, or is the same for all
    monkeypatch.setattr(shipped, "questions", lambda s: (q for q in asked(s) if q[0] not in later))
    mine, page = tmp_path / "mine.toml", tmp_path / "page"
    ss.write_model(model, mine)
    assert run(["explore", "--model", str(mine), "--export", str(page)]) == 0
    state = first_views(page)[0]["state"]
    assert "diagram" in {slot for slot, *_ in asked(state)} or model.n_blocks == 1
    kept = page / "static" / "shipped"
    entries = json.loads((kept / shipped.INDEX).read_text())
    own = [each for each in entries if each["request"]["model"] == state["model"]]
    assert {each["file"] for each in own} == {f"model-{slot}.bin" for slot in slots}
    assert len(entries) == len(LISTED) + len(own)
    for each in own:
        assert shipped.read(each["file"], kept) == shipped.answer(each["view"], each["request"])


def test_the_written_page_begins_with_the_plant_of_a_file_or_a_preset(tmp_path, monkeypatch):
    monkeypatch.setattr(live, "LAWS", {})
    monkeypatch.setattr(shipped, "questions", lambda state: ())
    mine, folder = tmp_path / "mine.toml", tmp_path / "page"
    ss.write_model(ss.examples.coulomb(alpha=0.7, V=0.08), mine)
    assert run(["explore", "--model", str(mine), "--export", str(folder)]) == 0
    first, *others = first_views(folder)
    assert (first["title"], first["state"]["model"]["alpha"]) == ("mine.toml", 0.7)
    assert [view["name"] for view in others] == list(preset_names())
    assert run(["explore", "--preset", "law9", "--export", str(folder), "--force"]) == 0
    views = [view["name"] for view in first_views(folder)]
    assert (views[0], sorted(views)) == ("law9", sorted(preset_names()))
    assert run(["explore", "--preset", "no", "--export", str(folder)]) == 2
