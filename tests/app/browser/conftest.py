"""One server, one Chromium and one page for all tests."""

import json
import os
import re
import shutil
import subprocess
import sys
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

import stickslip as ss

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
WARM_UP_S = 600  # a cold cache compiles every kernel that the page needs
SETTLE_MS = 300_000  # where kernels are compiled under load; a second on an idle machine
POLL_MS = 20  # at each frame, as is the default, would have frames made
FRAME = "() => new Promise((r) => requestAnimationFrame(() => setTimeout(r)))"  # has been laid out
SHOTS = Path(os.environ.get("STICKSLIP_SHOTS", "/nonexistent"))


def reason_to_skip() -> str | None:
    """Why the page cannot be driven here, if so."""
    try:
        import playwright.sync_api  # noqa: F401
        import starlette  # noqa: F401
    except ModuleNotFoundError as error:
        return f"the package {error.name} is not installed"
    return None if CHROMIUM else "there is no Chromium: apt install chromium"


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    reason = reason_to_skip()
    for item in items:
        if reason and here in item.path.parents:
            item.add_marker(pytest.mark.skip(reason=f"no browser tests: {reason}"))


def is_warm(url):
    """Whether the server has compiled all its kernels."""
    with urllib.request.urlopen(f"{url}healthz") as answer:
        return json.load(answer)["complete"]


@pytest.fixture(scope="session")
def address():
    """Address of an explorer that has compiled its kernels."""
    command = [sys.executable, "-m", "stickslip.cli", "explore", "--no-browser", "--port", "0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        url = server.stdout.readline().strip()
        until = time.monotonic() + WARM_UP_S
        while not is_warm(url):
            assert time.monotonic() < until, "the server did not get warm"
            time.sleep(0.2)
        yield url
    finally:
        server.terminate()
        server.wait(20)
        server.stdout.close()


@pytest.fixture(scope="session")
def browser():
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        running = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield running
        running.close()


class Explorer:
    """The page, as its user knows it: panels, controls, the state in the address."""

    def __init__(self, page, address):
        self.page = page
        self.address = address
        self.complaints = []
        page.on("console", self._listen)
        page.on("pageerror", lambda error: self.complaints.append(str(error)))
        page.on("request", self._watch)

    def _listen(self, message):
        if message.type == "error":
            self.complaints.append(message.text)

    def _watch(self, request):
        if not request.url.startswith((self.address, "blob:", "data:")):
            self.complaints.append(f"a request leaves the host: {request.url}")

    def open(self, fragment="preset=coulomb"):
        """Load the page anew with a state, and wait for every answer."""
        self.page.goto("about:blank")
        self.page.goto(f"{self.address}#{fragment}")
        self.page.wait_for_selector("html[data-ready]")
        return self.settle()

    def show(self, fragment="preset=coulomb", *slots):
        """Go to a state without loading the page, from a view that is all of its own."""
        self.go(fragment)
        return self.settle(*slots)

    def go(self, fragment):
        """Go to a state without loading the page, and wait for no answer.

        Nothing has the focus, as in a page that was loaded: a field that a test before wrote in
        took the keys of the next, whichever came after it.
        """
        self.page.evaluate(
            """fragment => {
                document.querySelectorAll("dialog[open]").forEach((dialog) => dialog.close());
                document.activeElement.blur();
                history.replaceState(null, "", "#" + fragment);
                dispatchEvent(new HashChangeEvent("hashchange", { newURL: location.href }));
            }""",
            fragment,
        )

    def settle(self, *slots):
        """Wait until what is quick, or the slots named, is answered and drawn."""
        self.page.wait_for_function(
            "slots => explorer.settled(slots.length ? slots : explorer.quickSlots)",
            arg=list(slots),
            timeout=SETTLE_MS,
            polling=POLL_MS,
        )
        wrong = "slots => slots.filter((slot) => explorer.standing(slot).kind === 'failed')"
        assert not self.page.evaluate(wrong, list(slots))
        self.page.evaluate(FRAME)
        return self

    @contextmanager
    def asking_only(self, slot):
        """Ask for one answer alone: for others, kernels of a new law would be compiled first."""
        self.page.evaluate(
            """only => {
                const ask = explorer.ask.bind(explorer);
                explorer.ask = (slot) => slot === only && ask(slot);
            }""",
            slot,
        )
        try:
            yield
        finally:
            self.page.evaluate("() => delete explorer.ask")

    @property
    def state(self):
        return self.page.evaluate("() => explorer.state")

    def view(self, panel, expression):
        """Evaluate an expression of ``view``, the object behind a panel."""
        return self.page.evaluate(
            f"panel => {{ const view = explorer.views.find(({{id}}) => id === panel); "
            f"return {expression}; }}",
            panel,
        )

    def spot(self, panel, x, y):
        """Where a point of a panel's plot is on the screen, once that has been laid out."""
        self.page.evaluate(FRAME)
        at = self.view(
            panel,
            f"[view.plot.x({float(x)}), view.plot.y({float(y)})].map((p) => p * view.plot.scale)",
        )
        box = self.plot(panel).bounding_box()
        return box["x"] + at[0], box["y"] + at[1]

    def panel(self, name):
        return self.page.locator(f"[data-panel='{name}']")

    def plot(self, name):
        return self.panel(name).locator(".plot-over").first

    def point_at(self, panel, x, y):
        """Hover, and read the tip."""
        self.page.mouse.move(*self.spot(panel, x, y))
        return self.panel(panel).locator(".tip").first.text_content()

    def click(self, panel, x, y):
        self.page.mouse.click(*self.spot(panel, x, y))
        self.page.wait_for_timeout(300)  # a click waits for its double
        return self.settle()

    def drag(self, panel, start, end):
        self.page.mouse.move(*self.spot(panel, *start))
        self.page.mouse.down()
        self.page.mouse.move(*self.spot(panel, *end), steps=4)
        self.page.mouse.up()
        return self.settle()

    def picture(self, panel):
        """What is drawn in a panel, as text that changes with any pixel."""
        canvases = self.panel(panel).locator("canvas")
        return [canvas.evaluate("(c) => c.toDataURL()") for canvas in canvases.all()]

    def inked(self, panel):
        """Share of pixels that are drawn on, and how many colours there are."""
        return (
            self.panel(panel)
            .locator("canvas")
            .first.evaluate(
                """(c) => {
                const { data } = c.getContext("2d").getImageData(0, 0, c.width, c.height);
                const colours = new Set();
                for (let k = 0; k < data.length; k += 4) if (data[k + 3] > 200) {
                    colours.add((data[k] << 16) | (data[k + 1] << 8) | data[k + 2]);
                }
                return colours.size;
            }"""
            )
        )

    def type_into(self, name, value):
        field = self.page.locator(f".controls input[name='{name}']:visible")
        field.fill(str(value))
        field.press("Enter")
        return self.settle()

    def shoot(self, name, *slots):
        """Keep a picture of the page, with these slots, where the environment asks for it."""
        if SHOTS.is_dir():
            self.settle(*slots)
            self.page.screenshot(path=SHOTS / f"{re.sub(r'[^a-z0-9]+', '-', name.lower())}.png")


@pytest.fixture(scope="session")
def collision():
    """The bifurcation of the first preset's diagram, as the library finds it."""
    (found,) = ss.bifurcations(ss.examples.coulomb(), "V", (0.0366, 0.0372), n_lists=6)
    return found


@pytest.fixture(scope="session")
def only_page(browser, address):
    context = browser.new_context(
        viewport={"width": 1280, "height": 800},
        reduced_motion="reduce",
        permissions=["clipboard-read", "clipboard-write"],
    )
    explorer = Explorer(context.new_page(), address)
    explorer.open()
    yield explorer
    context.close()


@pytest.fixture
def explorer(only_page):
    """The page at the first preset, for a test that leaves no complaint."""
    only_page.complaints.clear()
    only_page.page.set_viewport_size({"width": 1280, "height": 800})
    only_page.show()
    yield only_page
    only_page.page.keyboard.press("Escape")
    only_page.page.evaluate(
        "() => [...explorer.connection.running.keys()].forEach((s) => explorer.cancel(s))"
    )
    assert not only_page.complaints
