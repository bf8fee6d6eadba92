"""The page that was written into a folder, shown by a web server that knows nothing of it."""

import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from tests.app.browser.conftest import Explorer
from tests.app.browser.test_looks import violations

import stickslip as ss
from stickslip.app.page import preset_names
from stickslip.app.shipped import export

ALL_SHOWN = """() => explorer.views.every(({ panel }) => panel.section.hidden ||
    panel.section.dataset.state === "example")"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope="module")
def folder_address(tmp_path_factory):
    folder = tmp_path_factory.mktemp("page") / "explorer"
    export(folder)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=folder.parent))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/explorer/"
    server.shutdown()
    server.server_close()


@pytest.fixture
def alone(browser, folder_address):
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    explorer = Explorer(context.new_page(), folder_address)
    explorer.page.goto(folder_address)
    explorer.page.wait_for_function("() => window.explorer")
    yield explorer
    context.close()
    assert not explorer.complaints


@pytest.mark.parametrize("preset", preset_names())
def test_presets_are_shown(alone, preset):
    alone.page.evaluate("(preset) => { location.hash = `preset=${preset}`; }", preset)
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


def test_it_says_that_it_only_shows(alone):
    assert "pip install" in alone.page.locator(".connection").text_content()
    assert alone.page.locator("[data-slider='V']").is_disabled()
    alone.page.wait_for_function(ALL_SHOWN)
    before = alone.state
    alone.page.mouse.click(*alone.spot("map", -0.3, 0.0))
    alone.page.wait_for_function(
        "() => document.querySelector('.toast').textContent.includes('stickslip explore')"
    )
    assert alone.state == before
    assert alone.page.evaluate(ALL_SHOWN)
    assert not violations(alone)


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
