"""From a key on a slider to changed pixels, in Chromium, as a user sees it.

Run it as a program; it starts a server and a browser of its own:

    python benchmarks/bench_explorer_page.py --keys 40

Each key moves the slider of V by a step. Four times from the key's event: until the event map's
pixels have changed, until its orbits are drawn with it (those that follow from the map before),
until the search has confirmed and completed them, until every other view of that value is there
(power of the map, basins, cobweb, motion; the diagram along V stays what it is). Then 40
keys as fast as the keyboard sends them, timed from the last one until map and orbits are drawn.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
import time
from urllib.request import urlopen

import numpy as np
from playwright.sync_api import Page, sync_playwright

FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)
BURST = 40

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
        low, middle, high = np.percentile(times, [10, 50, 90])
        print(f"key to {text:23}: median {middle:5.0f} ms, 10-90 %: {low:.0f} to {high:.0f} ms")
    settled = [pressed(page, BURST)["orbits"] for _ in range(bursts)]
    print(
        f"burst of {BURST} keys settles  : median {np.median(settled):5.0f} ms, "
        f"{min(settled):.0f} to {max(settled):.0f} ms"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keys", type=int, default=40)
    parser.add_argument("--bursts", type=int, default=5)
    args = parser.parse_args()
    command = [sys.executable, "-m", "stickslip.cli", "explore", "--no-browser", "--port", "0"]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    try:
        url = server.stdout.readline().strip()
        while not json.load(urlopen(f"{url}healthz"))["warm"]:
            time.sleep(0.2)
        with sync_playwright() as playwright:
            chromium = shutil.which("chromium") or shutil.which("chromium-browser")
            browser = playwright.chromium.launch(executable_path=chromium, args=list(FLAGS))
            context = browser.new_context(
                viewport={"width": 1280, "height": 800}, reduced_motion="reduce"
            )
            measured(context.new_page(), url, args.keys, args.bursts)
            browser.close()
    finally:
        server.terminate()
        server.wait(20)


if __name__ == "__main__":
    main()
