"""The page that was written into a folder, shown by a web server that knows nothing of it."""

import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from scipy.spatial import KDTree
from tests.app.browser.conftest import SETTLE_MS, Explorer
from tests.app.browser.test_looks import boxes, violations
from tests.sizes import slow

import stickslip as ss
from stickslip.app import live
from stickslip.app.folder import STATIC, preset_names
from stickslip.app.one_file import one_file
from stickslip.app.shipped import export
from stickslip.mechanics.model.file import model_of_values

ALL_SHOWN = """() => explorer.views.every(({ panel }) => panel.section.hidden ||
    panel.section.dataset.state === "example")"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page") / "explorer"
    some = {name: law for name, law in live.LAWS.items() if name != "stribeck"}
    with pytest.MonkeyPatch.context() as patch:  # each law is compiled
        patch.setattr(live, "LAWS", some)
        assert export(folder) == folder / "index.html"
    return folder


@pytest.fixture(scope="module")
def folder_address(folder):
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder.parent))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/explorer/"
    server.shutdown()
    server.server_close()


@pytest.fixture
def alone(browser, folder_address):
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    context.set_default_timeout(SETTLE_MS)
    explorer = Explorer(context.new_page(), folder_address)
    explorer.page.goto(folder_address)
    explorer.page.wait_for_function("() => window.explorer")
    yield explorer
    context.close()
    assert not explorer.complaints


@pytest.mark.parametrize("preset", preset_names())
def test_presets_are_shown(alone, preset):
    alone.go(f"preset={preset}")
    alone.page.wait_for_function(ALL_SHOWN)
    alone.shoot(f"alone {preset}")


def test_its_numbers_are_the_library_s(alone):
    alone.page.wait_for_function(ALL_SHOWN)
    x, f = alone.view("map", "[[...view.values.arrays.x], [...view.values.arrays.f]]")
    inner = slice(5, None, 97)  # ends of branches have one-sided values
    expected = ss.event_map(ss.examples.coulomb())(np.array(x)[inner])
    np.testing.assert_allclose(np.array(f)[inner], expected, rtol=1e-5, atol=1e-5)
    motion = alone.page.evaluate(
        "() => [explorer.clock.arrays.t.at(-1), ...explorer.clock.arrays.x.slice(-2)]"
    )
    end = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=120).x(120.0)
    np.testing.assert_allclose(motion, [120, *end], rtol=1e-6)


def test_a_motion_of_few_samples_is_drawn_as_a_curve(alone):
    """Portraits of a chain were polygons with corners that everybody saw."""
    alone.go("preset=chain")
    alone.page.wait_for_function(ALL_SHOWN)
    x, v = np.array(alone.view("portrait-2", "[[...view.path.x], [...view.path.v]]"), dtype=float)
    values = alone.state["model"]
    start = alone.page.evaluate("() => explorer.question('motion').request")
    motion = ss.simulate(model_of_values(values), start["x"], start["v"], t_end=120.0)
    t = np.linspace(0.0, 120.0, 40_001)
    true = np.stack([motion.x(t)[:, 1], motion.v(t)[:, 1]], axis=1)
    span = np.ptp(true, axis=0)
    corners = np.stack([x, v], axis=1) / span
    middles = 0.5 * (corners[1:] + corners[:-1])
    middles = middles[np.isfinite(middles).all(axis=1)]
    off, _ = KDTree(true / span).query(middles)
    assert len(middles) > 100
    assert off.max() < 2e-3  # half a pixel


def states(alone):
    """State of each view, by its name."""
    shown = "explorer.views.filter(({ panel }) => !panel.section.hidden)"
    entries = f"{shown}.map(({{ id, panel }}) => [id, panel.section.dataset.state])"
    return dict(alone.page.evaluate(f"() => {entries}"))


def test_a_thread_that_hears_nothing_makes_way(alone):
    """All that was asked later waited for an answer that nobody wanted any more, up to 40 s."""
    alone.go("preset=law9-map")
    alone.page.wait_for_function(ALL_SHOWN)
    for name, value in (("alpha", 3), ("V", 0.001), ("damping", 0.1)):
        alone.page.evaluate("([name, value]) => explorer.setParameter(name, value)", [name, value])
        alone.page.wait_for_timeout(500)
    told = "() => explorer.standing('map').reason.startsWith('not computed on this page')"
    alone.page.wait_for_function(told, timeout=20_000)


def test_what_is_never_computed_there_is_told_at_once(alone):
    """It was said to be computed, until the thread had computed something else to its end."""
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate(
        """() => {
            explorer.connection.link.worker.postMessage = () => {}; // heard when it pauses
            explorer.setParameter("alpha", 1.3);
        }"""
    )
    told = """() => ["basins", "diagram"].every((slot) =>
        explorer.standing(slot).reason.startsWith("not computed on this page"))"""
    alone.page.wait_for_function(told, timeout=5_000)


def test_a_thread_that_waits_for_its_engine_hears(alone):
    """On a slow line it was ended, and loaded all anew, with each change of a value."""
    alone.page.wait_for_function(ALL_SHOWN)
    held = []
    alone.page.context.route("**/coulomb.wasm", lambda route: held.append(route))
    alone.page.evaluate(
        """() => {
            window.first = explorer.connection.link.worker;
            explorer.setParameter("V", 0.05);
            setTimeout(() => explorer.setParameter("V", 0.06), 300);
        }"""
    )
    alone.page.wait_for_timeout(1800)
    assert alone.page.evaluate("() => first === explorer.connection.link.worker")
    assert len(held) == 1
    held[0].continue_()
    alone.page.wait_for_function(CURRENT)


@pytest.mark.parametrize("last", [False, True])
def test_a_thread_makes_way_whatever_it_told_before_it_could_hear(alone, last):
    """A part on its way stopped the clock for good; so did an end, before what was called off."""
    begun = alone.page.evaluate(
        """async (last) => {
            const { Thread } = await import("./static/connection.js");
            const begun = [];
            window.Worker = class {
                constructor() { begun.push(this); }
                postMessage() {}
                terminate() {}
            };
            const thread = new Thread();
            thread.open({ onopen() {}, onpart() {} });
            const view = "event_map";
            ["map", "power"].forEach((slot, k) => thread.send({ id: k + 1, slot, view }));
            ["power", "map"].forEach((cancel) => thread.send({ cancel }));
            begun[0].onmessage({ data: { id: 1, last } });
            await new Promise((go) => setTimeout(go, 1100));
            return begun.length;
        }""",
        last,
    )
    assert begun == 2


def test_a_thread_goes_on_with_what_is_wanted(alone):
    """It was ended, and began anew, when anything else that it had been asked was called off."""
    alone.go("preset=law9")
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate(
        """() => {
            const { worker } = explorer.connection.link;
            explorer.setParameter("alpha", 1.2);
            setTimeout(() => explorer.cancel("power"), 1000); // the map takes some seconds
            worker.terminate = () => (window.ended = true);
        }"""
    )
    alone.page.wait_for_function(CURRENT.replace('"power", ', ""))
    assert not alone.page.evaluate("() => window.ended")
    assert alone.page.evaluate("() => explorer.standing('power').reason") == "stopped"


def test_what_is_stopped_there_is_told_to_be_stopped(alone):
    """Of a map that the page computes it said that it does not compute it."""
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("() => { explorer.setParameter('mu', 0.3); explorer.cancel('map'); }")
    assert alone.page.evaluate("() => explorer.standing('map').reason") == "stopped"


CURRENT = """() => ["map", "power", "portrait-1", "plane", "law"].every((name) =>
    explorer.views.find(({ id }) => id === name).panel.section.dataset.state === "current")"""


@pytest.mark.parametrize(
    ("preset", "parameter", "value"),
    [("coulomb", "V", 0.05), ("coulomb", "mu", 0.3), ("law9", "alpha", 1.2)],
)
def test_maps_and_motions_are_computed_there(alone, preset, parameter, value):
    alone.go(f"preset={preset}")
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("([name, value]) => explorer.setParameter(name, value)", [parameter, value])
    alone.page.wait_for_function(CURRENT)
    model = getattr(ss.examples, preset)().replace(**{parameter: value})
    f = ss.event_map(model)
    x, y, branch = alone.view(
        "map",
        "[[...view.values.arrays.x], [...view.values.arrays.f], [...view.values.arrays.branch]]",
    )
    expected = f.evaluate(np.array(x))
    np.testing.assert_allclose(np.array(y, dtype=float), expected.value, rtol=1e-13, atol=2e-15)
    assert max(branch) == np.count_nonzero(np.diff(expected.label.astype(np.int64)))
    orbits = alone.view("map", "view.orbits.orbits")
    assert any(orbit["stable"] for orbit in orbits)
    for orbit in (one for one in orbits if one["kind"] != "infinitely unstable"):
        points = np.array(orbit["points"])
        np.testing.assert_allclose(f(points), np.roll(points, -1), rtol=1e-9, atol=1e-10)
        slope = f.derivative(points).prod()
        np.testing.assert_allclose(orbit["multiplier"], slope, rtol=1e-6)
    t, last = alone.page.evaluate(
        "() => [explorer.clock.arrays.t.at(-1), [...explorer.clock.arrays.x.slice(-2)]]"
    )
    motion = ss.simulate(model, d=alone.state["d"], t_end=120.0)
    np.testing.assert_allclose([t, *last], [120.0, *motion.x(120.0)], rtol=1e-9)
    assert states(alone)["basins"] == "stale"
    assert not violations(alone)
    alone.shoot(f"alone, computed {preset} {parameter}")


COLLISION = 0.0369759235  # of S4 and a jump; the page's own numbers come within 1e-6 of it


def by_period(orbits):
    """Points of orbits by kind and period, from left to right."""
    found = {}
    for points, kind in orbits:
        found.setdefault((kind, len(points)), []).append(sorted(map(float, points)))
    return {key: sorted(found[key]) for key in sorted(found)}


@pytest.mark.parametrize(
    ("preset", "parameter", "value"),
    [
        *(("coulomb", "V", V) for V in (0.1441, 0.037027, COLLISION - 1e-6)),
        *slow(*(("coulomb", "V", V) for V in (0.0367, 0.03696, 0.03697, 0.036975))),
        *slow(("law9", "alpha", 1.2095)),  # beside a border collision and a flip
    ],
)
def test_orbits_and_breaks_are_the_library_s(alone, preset, parameter, value):
    alone.go(f"preset={preset}")
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("([name, value]) => explorer.setParameter(name, value)", [parameter, value])
    alone.page.wait_for_function(CURRENT)
    f = ss.event_map(getattr(ss.examples, preset)().replace(**{parameter: value}))
    seen = by_period((o["points"], o["kind"]) for o in alone.view("map", "view.orbits.orbits"))
    listed = ss.periodic_orbits(f, alone.state["max_period"], infinitely_unstable=True)
    expected = by_period((orbit.points, orbit.kind) for orbit in listed)
    assert seen.keys() == expected.keys()
    for key, orbits in expected.items():
        np.testing.assert_allclose(seen[key], orbits, rtol=1e-8, atol=1e-9)
    breaks = alone.view("map", "view.values.data.breakpoints")
    expected = ss.breakpoints(f)
    assert [one["kind"] for one in breaks] == [one.kind for one in expected]
    sides = [[one["at"], one["left"], one["right"]] for one in breaks]
    np.testing.assert_allclose(
        np.array(sides, dtype=float), [[b.d, b.left, b.right] for b in expected], rtol=0, atol=1e-9
    )
    assert (
        alone.view("map", "view.thing(view.values.data.breakpoints[0].at, NaN).modes.length") == 2
    )
    alone.shoot(f"alone, orbits {preset} {value}")


def test_it_says_what_it_does_not_compute(alone):
    assert "pip install" in alone.page.locator(".connection").text_content()
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("() => explorer.setParameter('damping', 0.1)")
    alone.page.wait_for_function(
        "() => document.querySelector('main').textContent.includes('not computed on this page')"
    )
    alone.page.evaluate("() => explorer.setParameter('damping', 0)")
    alone.page.evaluate("() => explorer.setParameter('V', -1)")
    alone.page.wait_for_function(
        r"() => document.querySelector('.error').textContent.includes('V = \u22121 is not above 0')"
    )


@pytest.mark.parametrize("width", [1280, 1024, 870, 400])
def test_how_all_is_computed_is_read_in_every_width(alone, width):
    """The command was cut off, where it was not seen at all."""
    alone.page.set_viewport_size({"width": width, "height": 800})
    cut = "(e) => e.scrollWidth > e.clientWidth || e.scrollHeight > e.clientHeight"
    for _ in ("small", "large"):
        alone.page.evaluate("() => new Promise(requestAnimationFrame)")
        (left, top, right, bottom), header = boxes(alone, ".connection, header.top")[::-1]
        assert header[0] <= left
        assert header[1] <= top
        assert right <= header[2]
        assert bottom <= header[3] <= 110
        assert not alone.page.locator(".connection").evaluate(cut)
        alone.page.keyboard.press("f")


def test_it_refuses_what_the_server_refuses(alone):
    """It computed for 40 s, or at last froze, with numbers far beyond its sliders."""
    alone.page.wait_for_function(ALL_SHOWN)
    with alone.asking_only("map"):
        alone.page.evaluate("() => explorer.setParameter('alpha', 1e6)")
        alone.page.wait_for_selector("[data-panel=map][data-state=failed]")
    told = alone.page.locator(".controls > .error").text_content()
    assert told.startswith("\u03b1 = 1\u00b710\u2076 is not from 0 to 30: the explorer computes no")


def test_it_takes_the_values_that_the_library_takes(alone):
    alone.show("preset=law9")
    with alone.asking_only("law"):
        alone.page.evaluate("() => explorer.setParameter('delta', 1.5)")
        alone.page.wait_for_selector("[data-panel=law][data-state=failed]")
        error = alone.page.locator(".controls > .error")
        assert error.text_content() == "\u03b4 = 1.5 is not from 0 to 1"
        alone.page.evaluate("() => explorer.setParameter('delta', 1)")
        alone.page.wait_for_selector("[data-panel=law][data-state=current]")
        alone.show("preset=coulomb", "law")
        alone.page.evaluate("() => explorer.setParameter('mu', 0)")
        alone.page.wait_for_selector("[data-panel=law][data-state=current]")
        assert not error.text_content()


def test_what_takes_too_long_is_given_up_after_what_is_quick(alone):
    """Values take long without kinetic friction; with as much as static, half a second each."""
    script = (STATIC / "live.js").read_text(encoding="utf-8")
    hasty = re.sub(r"PATIENCE_MS = \S+;", "PATIENCE_MS = 1;", script)
    assert hasty != script
    alone.page.context.route(
        "**/static/live.js", lambda route: route.fulfill(body=hasty, content_type="text/javascript")
    )
    alone.page.reload()
    alone.page.wait_for_function("() => window.explorer")
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("() => explorer.setParameter('mu', 0)")
    alone.page.wait_for_selector("[data-panel=portrait-1][data-state=current]", timeout=SETTLE_MS)
    alone.page.wait_for_selector("[data-panel=map][data-state=failed]", timeout=SETTLE_MS)
    assert "took too long" in alone.panel("map").locator(".badge").text_content()
    alone.page.evaluate("() => explorer.setParameter('mu', 0.3)")
    alone.page.wait_for_selector("[data-panel=law][data-state=current]", timeout=SETTLE_MS)


def test_what_is_not_computed_is_told_while_something_else_is(alone):
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.evaluate("() => explorer.setParameter('mu', 1)")  # values take half a second each
    for name in ("diagram", "basins"):
        alone.page.wait_for_selector(
            f"[data-panel={name}] .badge[title*='not computed on this page']"
        )
    assert alone.page.evaluate("() => explorer.connection.running.has('map')")


def test_an_answer_that_does_not_load_has_failed(alone):
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.route("**/fig14-power.bin", lambda route: route.abort())
    alone.page.route("**/fig14-basins.bin", lambda route: route.fulfill(status=404))
    alone.go("preset=fig14")
    failed = "[data-panel={}][data-state=failed]"
    for name in ("power", "basins"):
        alone.page.wait_for_selector(failed.format(name))
        assert "does not load" in alone.panel(name).locator(".badge").text_content()
    alone.page.unroute_all()
    alone.page.evaluate("() => explorer.store.update({ t_end: 60 }, 'test')")
    alone.page.wait_for_selector("[data-panel=basins][data-state=example]")
    alone.page.wait_for_selector("[data-panel=power][data-state=example]")
    # The browser's own lines; more may come as long as something asks again.
    assert all("Failed to load" in one for one in alone.complaints)
    alone.complaints.clear()


@pytest.mark.parametrize("file", ["live.js", "live/laws.json", "live/coulomb.wasm"])
def test_what_computes_and_does_not_load_has_failed(alone, file):
    alone.page.context.route(f"**/static/{file}", lambda route: route.fulfill(status=404))
    alone.page.reload()
    alone.page.wait_for_function("() => window.explorer")
    for name, value in (("V", 0.05), ("mu", 0.3)):
        alone.page.evaluate("([name, value]) => explorer.setParameter(name, value)", [name, value])
        alone.page.wait_for_selector("[data-panel=map][data-state=failed]")
        alone.page.wait_for_selector("[data-panel=plane][data-state=failed]")
        assert "does not load" in alone.panel("map").locator(".badge").text_content()
    alone.complaints.clear()  # the browser's own lines


def test_the_motion_plays_and_the_tour_goes(alone):
    alone.page.wait_for_function(ALL_SHOWN)
    alone.page.keyboard.press("Space")
    alone.page.wait_for_function("() => explorer.clock.t > 0.5")
    alone.page.keyboard.press("Space")
    alone.page.keyboard.press("g")
    for _ in range(4):
        alone.page.wait_for_function(ALL_SHOWN)
        alone.page.keyboard.press("Enter")
    alone.page.wait_for_function(ALL_SHOWN)
    assert alone.state["model"]["alpha"] == 1.211
    alone.page.get_by_role("button", name="α = 1.208").click()
    alone.page.wait_for_function(ALL_SHOWN)


def opened_as_a_file(browser, file):
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    explorer = Explorer(context.new_page(), file.as_uri())
    explorer.page.goto(file.as_uri())
    return explorer


def test_one_file_opens_from_a_disk_and_computes(browser, folder, tmp_path):
    page = tmp_path / "page.html"
    page.write_text(one_file(folder), encoding="utf-8")
    explorer = opened_as_a_file(browser, page)
    explorer.page.wait_for_function("() => window.explorer")
    explorer.page.wait_for_function(ALL_SHOWN)
    explorer.page.evaluate("() => explorer.setParameter('V', 0.05)")
    explorer.page.wait_for_function(CURRENT)
    x, y = explorer.view("map", "[[...view.values.arrays.x], [...view.values.arrays.f]]")
    expected = ss.event_map(ss.examples.coulomb(V=0.05))(np.array(x))
    np.testing.assert_allclose(np.array(y, dtype=float), expected, rtol=1e-13, atol=2e-15)
    assert not violations(explorer)
    assert not explorer.complaints
    explorer.shoot("one file")


def test_a_folder_opened_as_a_file_says_what_it_needs(browser, folder):
    explorer = opened_as_a_file(browser, folder / "index.html")
    said = explorer.page.locator(".connection").text_content()
    assert "from a web server" in said
    assert "--export page.html" in said
