"""Each view's answer is what the library's functions say when they are called directly."""

import json

import numpy as np
import pytest
from tests.app.talk import CHAIN, COULOMB
from tests.mechanics.eventmap.unequal import pair
from tests.sizes import slow

import stickslip as ss
from stickslip.app import jobs
from stickslip.app.as_python import TEXTS, as_python
from stickslip.app.exports import KNOWN
from stickslip.app.folder import presets
from stickslip.app.jobs import Gate, Job
from stickslip.app.page import described_limits
from stickslip.app.pictures import DRAW
from stickslip.app.requests import REQUESTS, request_of
from stickslip.app.views import VIEWS
from stickslip.mechanics.model import locus
from stickslip.mechanics.model.file import model_of_values, model_values
from stickslip.plot.motion import stick_interval

MODEL = ss.examples.coulomb()
UNEQUAL = pair(ss.Coulomb(mu=0.22), 0.2, damped=True)
MIXED = {**COULOMB, "friction": [{"law": "coulomb", "mu": 0.2}, {"law": "coulomb", "mu": 0.3}]}


def test_the_event_map_comes_with_its_branches_and_orbits(page):
    parts = page.parts("event_map", points=101, max_period=2)
    for seldom in ("progress", "followed"):  # while kernels are compiled; of other tests' maps
        parts.pop(seldom, None)
    assert list(parts) == ["samples", "branches", "orbits", "explained", "end"]
    f = ss.event_map(MODEL)
    samples = parts["samples"].arrays
    np.testing.assert_array_equal(samples["f"], f(samples["x"]))
    table, line = ss.branches(f), parts["branches"]
    for k, branch in enumerate(table):
        mine = line.arrays["branch"] == k
        assert line.arrays["x"][mine][[0, -1]].tolist() == [branch.left, branch.right]
        ends = line.arrays["f"][mine][[0, -1]].tolist()
        assert ends == [branch.value_left, branch.value_right]
    np.testing.assert_array_equal(parts["explained"].arrays["f"], line.arrays["f"])
    told = [(item["at"], item["mechanism"]) for item in parts["explained"].data["breakpoints"]]
    assert told == [(item.d, item.mechanism) for item in table.breakpoints]
    orbits = ss.periodic_orbits(f, 2, infinitely_unstable=True)
    assert [o["points"] for o in parts["orbits"].data["orbits"]] == [
        orbit.points.tolist() for orbit in orbits
    ]


DEAD = {**COULOMB, "damping": 5.0}  # both blocks slip for ever: the map has no value anywhere
ENDS = {"parameter": "V", "range": [0.03, 0.04], "values": 4, "max_period": 2}


@pytest.mark.parametrize(
    "asked",
    [
        {"view": "event_map", "points": 50},
        {"view": "event_map", "points": 50, "power": 2, "window": [-0.1, 0.1]},
        {"view": "cobweb", "d": 0.1, "n": 10},
        {"view": "motion", "d": 0.1, "t_end": 20.0},
        {"view": "basins"},
        {"view": "diagram", **ENDS, "window": [-0.1, 0.1]},
        *slow({"view": "diagram", **ENDS}),
    ],
    ids=lambda asked: "-".join(map(str, list(asked.values())[:1] + list(asked)[1:])),
)
def test_a_map_without_a_value_has_every_view(client, page, asked):
    parts = page.parts(model=DEAD, **asked)
    view, request = asked["view"], {k: v for k, v in asked.items() if k != "view"}
    match view:
        case "event_map":
            assert parts["branches"].arrays["x"].size == 0
            assert parts["orbits"].data["orbits"] == []
        case "basins":
            assert parts["basins"].arrays["label"].tolist() == [-2]
        case "diagram":
            assert parts["branches"].data["orbits"] == []
    for kind in ("svg", "csv", "json"):
        body = {"view": view, "request": {"model": DEAD, **request}, "format": kind}
        reply = client.post("/export", json=body)
        assert reply.status_code == 200, reply.text


def test_a_window_and_a_power_are_shown_at_their_own_resolution(page):
    parts = page.parts("event_map", window=[0.1, 0.2], power=2, points=64, max_period=0)
    x, f = (parts["samples"].arrays[name] for name in "xf")
    assert x[[0, -1]].tolist() == [0.1, 0.2]
    np.testing.assert_array_equal(f, ss.event_map(MODEL).power(2)(x))
    found = [item["at"] for item in parts["branches"].data["breakpoints"]]
    whole = [item.d for item in ss.breakpoints(ss.event_map(MODEL).power(2))]
    np.testing.assert_allclose(found, [d for d in whole if 0.1 < d < 0.2], rtol=0, atol=1e-12)


def test_orbits_follow_from_those_of_a_map_nearby(page):
    page.parts("event_map", points=20, max_period=4)
    moved = {**COULOMB, "V": 0.03665}
    parts = page.parts("event_map", model=moved, points=20, max_period=4)
    found = [o for o in parts["orbits"].data["orbits"] if o["jump"] is None]
    followed = parts["followed"].data["orbits"]
    assert [o["period"] for o in followed] == [o["period"] for o in found]
    for one, other in zip(followed, found, strict=True):
        np.testing.assert_allclose(one["points"], other["points"], rtol=0, atol=1e-12)
        assert one["multiplier"] == pytest.approx(other["multiplier"], rel=1e-9)


def test_orbits_inside_a_window_come_before_the_others(page):
    asked = {"window": [0.05, 0.2], "points": 20, "max_period": 1}
    received = page.answer(page.ask("event_map", **asked))
    first, last = (part.data["orbits"] for part in received if part.name == "orbits")
    everywhere = ss.periodic_orbits(MODEL, 1, infinitely_unstable=True)
    assert [o["points"] for o in last] == [orbit.points.tolist() for orbit in everywhere]
    inside = [o["points"][0] for o in last if 0.05 <= o["points"][0] <= 0.2]
    np.testing.assert_allclose([o["points"][0] for o in first], inside, rtol=0, atol=1e-12)


def test_motions_that_are_long_are_missing_only_from_the_first_picture(page):
    law9 = {
        "kind": "two_block",
        "alpha": 1.208,
        "beta": 1.301,
        "V": 0.295,
        "friction": {"law": "popp-stelter", "gamma": 3.0},
    }
    parts = page.parts("event_map", model=law9, window=[0.3, 0.31], points=20, max_period=0)
    f = ss.event_map(ss.examples.law9())
    exact = parts["branches"].arrays
    inside = (exact["x"] > 0.3) & (exact["x"] < 0.31)
    np.testing.assert_allclose(exact["f"][inside], f(exact["x"][inside]), rtol=0, atol=1e-12)


def test_work_that_can_be_called_off_has_the_numbers_of_the_event_map(monkeypatch):
    monkeypatch.setattr(jobs, "FIRST", 1e-9)  # a point at a time, at first

    def in_pieces(ask, f):
        with Job(Gate(1), "somebody", 60.0).running():
            return ask(f)

    for model in (MODEL, ss.examples.coulomb(damping=1.0), ss.examples.law9(), UNEQUAL):
        f = ss.event_map(model, threads=1)
        d = np.linspace(*f.domain, 41)
        for ask in (
            lambda h, d=d: h(d),
            lambda h, d=d: h.derivative(d),
            lambda h, d=d: h.value_and_derivative(d),
            lambda h, d=d: h.parameter_derivative(d, "V"),
            lambda h, d=d: h.iterate(d, 30),
            lambda h: h.iterate(0.1, 100),
            lambda h: h(0.1),
            lambda h: h([]),
            lambda h: h.itinerary(0.1),
        ):
            np.testing.assert_array_equal(in_pieces(ask, f), ask(f))
        one, other = in_pieces(lambda h, d=d: h.evaluate(d), f), f.evaluate(d)
        for name in ("value", "margin", "label", "status"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_a_cobweb_is_an_orbit_and_tells_how_it_ends(page):
    part = page.parts("cobweb", d=0.1, n=400)["orbit"]
    np.testing.assert_array_equal(part.arrays["orbit"], ss.event_map(MODEL).iterate(0.1, 400))
    assert part.data["end"] == {"kind": "periodic", "period": 4, "status": ""}


def test_a_motion_is_sampled_with_its_events_and_stick_intervals(page):
    part = page.parts("motion", d=0.1, t_end=30.0, samples=50)["motion"]
    motion = ss.simulate(MODEL, d=0.1, t_end=30.0)
    t = part.arrays["t"]
    assert set(motion.t) <= set(t)
    np.testing.assert_array_equal(part.arrays["x"], motion.x(t))
    np.testing.assert_array_equal(part.arrays["force"], motion.friction(t))
    assert [e["t"] for e in part.data["events"]] == [e.time for e in motion.events]
    x = motion.x(t)
    expected = [stick_interval(MODEL, 2, x_1) for x_1 in x[:, 0]]
    np.testing.assert_allclose(part.arrays["interval"][:, 1], expected, rtol=0, atol=1e-12)
    rides = part.arrays["mode"][:, 0] == 0
    assert (part.arrays["v"][rides, 0] == MODEL.V).all()


def test_a_chain_moves_from_its_differences(page):
    part = page.parts("motion", model=CHAIN, d=[0.1, -0.2], t_end=20.0, samples=20)["motion"]
    assert part.arrays["x"].shape[1] == 3
    assert page.error("event_map", model=CHAIN)["field"] == "model.kind"


def test_laws_that_differ_are_columns(page):
    part = page.parts("law", model=MIXED, range=1.0, points=5)["law"]
    np.testing.assert_array_equal(part.arrays["force"], [[0.2, 0.3]] * 5)


def test_the_locus_has_the_corners_of_the_paper(page):
    data = page.parts("locus")["locus"].data
    assert data["corners"] == locus.corners(MODEL.plant).tolist()
    assert data["domain"] == list(MODEL.domain)


def test_two_blocks_that_are_not_equal_have_all_views(page):
    f, values = ss.event_map(UNEQUAL), model_values(UNEQUAL)
    parts = page.parts("event_map", model=values, points=21, max_period=1)
    x = np.linspace(*f.domain, 21)
    np.testing.assert_array_equal(parts["samples"].arrays["f"], f(x))
    orbits = [o["points"] for o in parts["orbits"].data["orbits"]]
    assert orbits == [o.points.tolist() for o in ss.periodic_orbits(f, 1, infinitely_unstable=True)]
    assert "mechanism" in parts["explained"].data["breakpoints"][0]
    orbit = page.parts("cobweb", model=values, d=0.1, n=5)["orbit"].arrays["orbit"]
    np.testing.assert_array_equal(orbit, f.iterate(0.1, 5))
    data = page.parts("locus", model=values)["locus"].data
    assert data["domain"] == list(UNEQUAL.domain)
    motion = page.parts("motion", model=values, d=0.1, t_end=20.0, samples=3)["motion"]
    assert motion.arrays["t"][-1] == 20.0
    assert "basins" in page.parts("basins", model=values, resolution=1e-3)
    forced = {**CHAIN, "static": [1.0, 1.1], "forcing": {"amplitude": 0.1, "frequency": 1.0}}
    assert "has 3 numbers" in page.error("event_map", model=forced)["message"]


def test_basins_have_the_edges_of_the_library(page):
    parts = page.parts("basins")
    found = ss.basins(MODEL)
    assert parts["basins"].arrays["edges"].tolist() == found.edges.tolist()
    assert parts["basins"].arrays["label"].tolist() == found.index.tolist()
    assert len(parts["attractors"].data["attractors"]) == len(found.attractors)


def test_a_diagram_grows_from_dots_to_bifurcations(page):
    asked = {"max_period": 1, "window": [-0.1, 0.05]}
    ends = {"parameter": "V", "range": [0.03695, 0.037], "values": 5}
    received = page.answer(page.ask("diagram", **ends, **asked))
    names = [part.name for part in received if part.name != "progress"]
    assert names == [*["dots"] * 5, "branches", "bifurcations", "infinitely_unstable", "end"]
    shares = [part.header["progress"] for part in received]
    assert shares == sorted(shares)
    branches = next(part for part in received if part.name == "branches")
    values = np.linspace(0.03695, 0.037, 5)
    diagram = ss.bifurcation_diagram(MODEL, "V", values, max_period=1, window=(-0.1, 0.05))
    assert len(branches.data["orbits"]) == len(diagram.orbits)
    np.testing.assert_array_equal(branches.arrays["points_0"], diagram.orbits[0].points)


def test_orbits_through_jumps_are_those_of_their_values(page):
    along = {"parameter": "V", "range": [0.0366, 0.0368], "values": 5, "max_period": 2}
    rows = page.parts("diagram", **along)["infinitely_unstable"].arrays
    values = np.unique(rows["value"])
    assert (values[0], values[-1]) == (0.0366, 0.0368)
    for value in values[[0, len(values) // 2, -1]]:
        listed = ss.periodic_orbits(MODEL.replace(V=value), 2, infinitely_unstable=True)
        points = [x for orbit in listed if orbit.jump is not None for x in orbit.points]
        found = sorted(rows["d"][rows["value"] == value])
        np.testing.assert_allclose(found, sorted(points), rtol=1e-7)


def numbers_of(view, **request):
    """Run the Python of a view and return what it leaves behind."""
    asked = request_of(view, json.dumps({"model": COULOMB, **request}).encode())
    names = {}
    exec(compile(as_python(asked), view, "exec"), names)
    return names


PYTHON = {
    "event_map": ({"points": 50, "max_period": 2}, "values"),
    "cobweb": ({"d": 0.1, "n": 20}, "orbit"),
    "motion": ({"d": 0.1, "t_end": 20.0, "samples": 30}, "x"),
    "law": ({"range": 1.5, "points": 9}, "force"),
    "basins": ({}, "basins"),
    "locus": ({}, "ax"),
}


@pytest.mark.parametrize("view", PYTHON)
def test_copied_python_gives_the_numbers_of_the_view(page, view):
    request, name = PYTHON[view]
    made, parts = numbers_of(view, **request), page.parts(view, **request)
    arrays = next(iter(parts.values())).arrays
    match view:
        case "event_map":
            np.testing.assert_array_equal(made[name], arrays["f"])
            points = [o["points"] for o in parts["orbits"].data["orbits"]]
            assert [o.points.tolist() for o in made["orbits"]] == points
        case "basins":
            assert made[name].edges.tolist() == parts["basins"].arrays["edges"].tolist()
        case "locus":
            assert made[name].get_xlabel()
        case _:
            np.testing.assert_array_equal(made[name], arrays[name])


def test_python_of_other_models_makes_equal_models():
    for values in (
        MIXED,
        CHAIN,
        {"kind": "oscillator", "V": 0.2, "friction": {"law": "stribeck", "mu": 0.4, "speed": 0.1}}
        | {"forcing": {"amplitude": 0.1, "frequency": 2.0}},
    ):
        made = numbers_of("law", model=values)
        assert made["model"] == model_of_values(values)


def test_every_view_has_python_and_a_picture():
    assert set(TEXTS) == set(DRAW) == set(KNOWN.values())
    assert set(VIEWS) == set(REQUESTS.values())


def test_controls_and_presets_are_allowed_as_they_are():
    described = described_limits()
    models = [entry["default"] for entry in described["models"]]
    models += [preset["state"]["model"] for preset in presets()]
    models += [{**COULOMB, "friction": entry["default"]} for entry in described["laws"]]
    for model in models:
        assert model_of_values(model).n_blocks
    for entry in (*described["models"], *described["laws"]):
        for parameter in entry["parameters"]:
            default = parameter["default"]
            if "values" in parameter:
                assert default in parameter["values"]
            else:
                assert parameter["min"] <= default <= parameter["max"]
            assert parameter["symbol"]
            assert "\\" not in parameter["symbol"]


def test_basins_of_three_blocks_are_those_of_the_library(page):
    model = {**CHAIN, "static": [0.753, 1.374, 1.078], "alpha": 1.616, "V": 0.12}
    model["friction"] = {"law": "coulomb", "mu": 0.59}
    received = page.answer(page.ask("basins", model=model, resolution=0.05))
    parts = {part.name: part for part in received if part.name != "progress"}
    assert list(parts) == ["attractors", "coarse", "basins", "end"]
    x, y, index = (parts["basins"].arrays[name] for name in ("x", "y", "index"))
    f = ss.event_map(model_of_values(model))
    found = ss.attractors(f)
    told = parts["attractors"].data["attractors"]
    assert [each["points"] for each in told] == [each.points.tolist() for each in found]
    basins = ss.basins(f, found, grid=[x, y])
    np.testing.assert_array_equal(index.reshape(len(x), len(y)), basins.index)
    made = numbers_of("basins", model=model, resolution=0.05)
    np.testing.assert_array_equal(made["basins"].index, basins.index)
    inside = 1.0 - basins.left
    shares = [basins.share(k).value / inside for k in range(2)]
    assert parts["basins"].data["shares"] == pytest.approx(shares, rel=1e-12)
    longer = {**model, "static": [*model["static"], 1.0]}
    parts = page.parts("basins", model=longer, resolution=0.1)
    assert parts["basins"].data["held"] == 1
