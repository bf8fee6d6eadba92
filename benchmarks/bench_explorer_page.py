"""From a key on a slider to changed pixels, in Chromium, as a user sees it.

Run it as a program; it starts a server and a browser of its own:

    python benchmarks/bench_explorer_page.py --keys 40

Each key moves the slider of V by a step. Four times from the key's event: until the event map's
pixels have changed, until its orbits are drawn with it (those that follow from the map before),
until the search has confirmed and completed them, until every other view of that value is there
(power of the map, basins, cobweb, motion; the diagram along V stays what it is). Then 40
keys as fast as the keyboard sends them, timed from the last one until map and orbits are drawn.
Then the diagrams of Coulomb friction and of law (9), from another value of another parameter to the
last part. Before all that, from the command to the first event map on the screen: with an empty
cache of kernels, and with the usual one. Each has a limit that was promised for an idle machine,
and how fast this one is against that one is told first.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from urllib.request import urlopen

import numpy as np
from playwright.sync_api import Page, sync_playwright

import stickslip as ss

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
BURST = 40

# Million maps a second and core of the machine of the promises: Coulomb friction, many points.
MILLIONS = 28
# What was promised when it is idle, in ms: of 95 % of the keys, of diagrams, of first maps.
PROMISED = {
    **{"pixels": 40, "searched": 150},
    **{"coulomb": 5000, "law9": 10_000},
    **{"cold": 3000, "warm": 1000},
}

# Whether the event map has a picture.
DRAWN = """() => {
    const canvas = document.querySelector("[data-panel=map] canvas");
    const map = window.explorer?.answers.get("map");
    if (!canvas || !map) return false;
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return data.some((value) => value > 0);
}"""

# Times, in ms from a key's event, at which something is on the screen for the newest value.
WATCH = """() => {
    const panel = document.querySelector("[data-panel=map]");
    const canvas = panel.querySelector("canvas");
    const map = explorer.views.find(({ id }) => id === "map");
    const others = ["cobweb", "motion", "power", "basins"];
    const text = (question) => JSON.stringify(question);
    const isAsked = () => text(explorer.question("map")) === explorer.asked.get("map");
    const now = () => text(explorer.answers.get("map").question) === explorer.asked.get("map");
    let start = 0;
    addEventListener("keydown", () => { start = performance.now(); }, { capture: true });
    const frame = () => new Promise((next) => requestAnimationFrame(() => setTimeout(next)));
    window.watch = async (keys) => {
        const before = canvas.toDataURL();
        const times = {};
        let seen = 0;
        const count = () => { seen += 1; };
        addEventListener("keydown", count);
        while (!times.pixels || !times.orbits || !times.searched || !times.others) {
            await frame();
            const passed = performance.now() - start;
            if (seen < keys || !isAsked()) continue;
            if (!times.pixels && now()) times.pixels = passed;
            if (!times.orbits && now() && !map.orbits.old) times.orbits = passed;
            if (!times.searched && now() && map.orbits.searched) times.searched = passed;
            if (!times.others && explorer.settled(others)) times.others = passed;
        }
        removeEventListener("keydown", count);
        times.changed = canvas.toDataURL() !== before;
        return times;
    };
}"""


def pressed(page: Page, keys: int) -> dict[str, float]:
    """Press a key so many times, and time what follows the last."""
    page.evaluate("keys => { window.watched = watch(keys); }", keys)
    for _ in range(keys):
        page.keyboard.press("ArrowRight")
    times = page.evaluate("() => watched")
    assert times["changed"], "the event map has not changed"
    return times


def measured(page: Page, url: str, keys: int, bursts: int) -> None:
    page.goto(f"{url}#preset=coulomb")
    page.wait_for_selector("html[data-ready]")
    page.wait_for_function("() => explorer.settled()", timeout=300_000)
    page.evaluate(WATCH)
    page.locator("[data-slider=V]").focus()
    for _ in range(5):
        pressed(page, 1)
    singles = [pressed(page, 1) for _ in range(keys)]
    for name, text in (
        ("pixels", "event map"),
        ("orbits", "event map with orbits"),
        ("searched", "complete list of orbits"),
        ("others", "all other views"),
    ):
        times = [single[name] for single in singles]
        told(f"key to {text}", times, PROMISED.get(name))
    settled = [pressed(page, BURST)["orbits"] for _ in range(bursts)]
    told(f"burst of {BURST} keys settles", settled)


def told(what: str, times: list[float], promised: float | None = None) -> None:
    """Print percentiles in ms, beside what was promised of the third."""
    middle, late, most = np.percentile(times, [50, 95, 100])
    limit = f", promised {promised:.0f}" if promised else ""
    print(f"{what:34}: median {middle:6.0f} ms, 95 % {late:6.0f}{limit}, most {most:.0f}")


def diagrams(page: Page, url: str, times: int) -> None:
    """Time diagrams from a new value of another parameter to their last parts."""
    for preset, name, start in (("coulomb", "alpha", 1.2), ("law9", "beta", 1.301)):
        page.goto("about:blank")
        page.goto(f"{url}#preset={preset}")
        page.wait_for_selector("html[data-ready]")
        page.wait_for_function("() => explorer.settled()", timeout=300_000)
        taken = []
        for k in range(times):
            begun = time.monotonic()
            change = [name, start * (1 + 1e-4 * (k + 1))]
            page.evaluate("([name, value]) => explorer.setParameter(name, value)", change)
            # Asked at every frame, the page would take a share of what is timed.
            settled = "() => explorer.settled(['diagram'])"
            page.wait_for_function(settled, timeout=300_000, polling=50)
            taken.append(1e3 * (time.monotonic() - begun))
        told(f"diagram of {preset} after a new {name}", taken, PROMISED[preset])


@contextmanager
def served(cache: str | None = None) -> Iterator[str]:
    """Start the command; yield the page's address."""
    command = [sys.executable, "-m", "stickslip.cli", "explore", "--no-browser", "--port", "0"]
    environment = {**os.environ, **({"NUMBA_CACHE_DIR": cache} if cache else {})}
    server = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment
    )
    try:
        yield server.stdout.readline().strip()
    finally:
        server.terminate()
        server.wait(20)
        server.stdout.close()


def starts(page: Page, times: int) -> None:
    """Time the command until the first event map is drawn."""
    for what in ("cold", "warm"):
        taken = []
        for _ in range(times):
            with tempfile.TemporaryDirectory() as empty:
                begun = time.monotonic()
                with served(empty if what == "cold" else None) as url:
                    page.goto(url)
                    page.wait_for_function(DRAWN, polling=5)
                    taken.append(1e3 * (time.monotonic() - begun))
                    page.goto("about:blank")
        told(f"command to first map, {what}", taken, PROMISED[what])


def millions() -> float:
    """Million maps a second that a core of this machine makes."""
    f = ss.event_map(ss.examples.coulomb(), threads=1)
    points = np.random.default_rng(0).uniform(*f.domain, 10**6)
    taken = []
    for _ in range(6):  # the first loads kernels
        begun = time.process_time()
        f(points)
        taken.append(time.process_time() - begun)
    return points.size / min(taken) / 1e6


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keys", type=int, default=40)
    parser.add_argument("--bursts", type=int, default=5)
    parser.add_argument("--diagrams", type=int, default=5)
    parser.add_argument("--starts", type=int, default=3)
    args = parser.parse_args()
    print(f"this machine: {millions():.1f} million maps a second and core, promised on {MILLIONS}")
    with sync_playwright() as playwright:
        chromium = shutil.which("chromium") or shutil.which("chromium-browser")
        browser = playwright.chromium.launch(executable_path=chromium, args=list(FLAGS))
        context = browser.new_context(
            viewport={"width": 1280, "height": 800}, reduced_motion="reduce"
        )
        page = context.new_page()
        if args.starts:
            starts(page, args.starts)
        with served() as url:
            while not json.load(urlopen(f"{url}healthz"))["complete"]:
                time.sleep(0.2)
            measured(page, url, args.keys, args.bursts)
            if args.diagrams:
                diagrams(page, url, args.diagrams)
        browser.close()


if __name__ == "__main__":
    main()
