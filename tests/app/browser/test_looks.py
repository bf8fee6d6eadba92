"""Looks: nothing overlaps, labels are readable, axe finds nothing, in every size and theme."""

import itertools
from importlib.resources import files

import pytest

SIZES = [(1280, 800), (1680, 1050), (1024, 768), (820, 1100), (640, 400), (400, 800)]


def violations(explorer, within="html"):
    """What axe-core finds (its file comes with axe-playwright-python, MPL 2.0)."""
    if not explorer.page.evaluate("() => 'axe' in window"):
        source = (files("axe_playwright_python") / "axe.min.js").read_text(encoding="utf-8")
        explorer.page.evaluate(source)
    found = explorer.page.evaluate("within => axe.run(within)", within)["violations"]
    return [
        f"{item['id']}: {node['target']} {node.get('failureSummary', '')}"
        for item in found
        for node in item["nodes"]
    ]


def boxes(explorer, selector):
    script = """(all) => all.filter((e) => e.checkVisibility()).map((e) => {
        const { left, top, right, bottom } = e.getBoundingClientRect();
        return [left, top, right, bottom];
    })"""
    return explorer.page.locator(selector).evaluate_all(script)


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
@pytest.mark.parametrize("preset", ["coulomb", "chain"])
def test_nothing_overlaps_or_is_cut_off(explorer, size, preset):
    explorer.page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    explorer.page.wait_for_timeout(200)
    explorer.show(f"preset={preset}")
    explorer.shoot(f"{preset} {size[0]} {size[1]}")
    panels = boxes(explorer, "main .panel")
    for (l0, t0, r0, b0), (l1, t1, r1, b1) in itertools.combinations(panels, 2):
        assert r0 <= l1 or r1 <= l0 or b0 <= t1 or b1 <= t0
    for left, top, right, bottom in panels:
        assert left >= 0
        assert right <= size[0]
        assert right - left > 180
        assert bottom - top > 90
    wide = explorer.page.evaluate("() => document.documentElement.scrollWidth")
    assert wide <= size[0]
    for left, top, right, bottom in boxes(explorer, ".plot"):
        assert right - left > 150
        assert bottom - top > 30
    cut = explorer.page.locator("h2, legend, .symbol, h1").evaluate_all(
        """(all) => all.filter((e) => e.checkVisibility() && e.clientWidth)
            .filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.textContent)"""
    )
    assert not cut


def test_basins_are_seen_on_a_telephone(explorer):
    explorer.page.set_viewport_size({"width": 390, "height": 844})
    explorer.panel("basins").locator(".sentence").evaluate(
        "(p) => (p.textContent = 'long '.repeat(60))"
    )
    explorer.page.wait_for_timeout(200)
    ((_, top, _, bottom),) = boxes(explorer, ".panel-basins .plot")
    assert bottom - top > 60


@pytest.mark.parametrize("preset", ["law9", "drill-string"])
def test_words_of_sliders_are_whole(explorer, preset):
    explorer.page.set_viewport_size({"width": 1024, "height": 768})
    explorer.show(f"preset={preset}")
    cut = explorer.page.locator(".row.worded:visible .word").evaluate_all(
        "(all) => all.filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.textContent)"
    )
    assert not cut


@pytest.mark.parametrize("size", SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def test_the_cobweb_is_square(explorer, size):
    explorer.page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    explorer.page.wait_for_timeout(300)
    frames = [
        explorer.view(panel, "[view.plot.left, view.plot.right, view.plot.top, view.plot.bottom]")
        for panel in ("map", "basins")
    ]
    left, right, top, bottom = frames[0]
    assert right - left == bottom - top > 150
    assert frames[1][:2] == [left, right]  # both over the same d
    assert explorer.view("map", "view.plot.x(0.3) - view.plot.x(0)") == pytest.approx(
        explorer.view("map", "view.plot.y(0) - view.plot.y(0.3)"), rel=1e-12
    )


@pytest.mark.parametrize("size", [(1024, 768), (640, 400), (844, 390)])
def test_what_a_slider_changes_is_seen_beside_it(explorer, size):
    """The second size is that of 1280 x 800 at a zoom of 200 %."""
    width, height = size
    explorer.page.set_viewport_size({"width": width, "height": height})
    explorer.page.wait_for_timeout(200)
    for selector in ("[data-slider=V]", ".panel-map .plot"):
        ((left, top, right, bottom),) = boxes(explorer, selector)
        assert left >= 0
        assert right <= width
        assert top >= 0
        assert bottom <= height


@pytest.mark.parametrize("preset", ["coulomb", "chain"])
@pytest.mark.parametrize("width", [1280, 390])
def test_targets_are_24_pixels_wide_and_high(explorer, preset, width):
    explorer.page.set_viewport_size({"width": width, "height": 844})
    explorer.show(f"preset={preset}")
    explorer.page.keyboard.press("o")
    small = explorer.page.locator("button, select, label, input:not(label input)").evaluate_all(
        """(all) => all.filter((e) => e.checkVisibility()).map((e) => {
            const { width, height } = e.getBoundingClientRect();
            return [e.ariaLabel ?? e.textContent, width, height];
        }).filter(([, width, height]) => Math.min(width, height) < 24)"""
    )
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("o")
    assert not small


def test_the_first_screen_needs_no_scrolling(explorer):
    low = max(bottom for *_, bottom in boxes(explorer, "main .panel"))
    assert low <= 800


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing(explorer, theme):
    if explorer.page.evaluate("() => document.documentElement.dataset.theme") != theme:
        explorer.page.locator("button[aria-label='Light or dark']").click()
    assert explorer.page.evaluate("() => document.documentElement.dataset.theme") == theme
    explorer.shoot(f"theme {theme}")
    explorer.page.keyboard.press("Escape")  # nothing computes meanwhile
    assert not violations(explorer)
    explorer.page.locator("button[aria-label='Help']").click()
    assert not violations(explorer, ".help")
    explorer.page.keyboard.press("Escape")
    explorer.panel("diagram").locator("button.export").click()
    assert not violations(explorer, "[data-panel=diagram]")
    explorer.page.keyboard.press("Escape")
    explorer.show("preset=chain")
    explorer.page.get_by_label("a law for each block").check()
    explorer.page.keyboard.press("Escape")
    assert not violations(explorer)


def test_axe_finds_nothing_in_a_narrow_window(explorer):
    explorer.page.set_viewport_size({"width": 400, "height": 800})
    explorer.settle()
    explorer.page.keyboard.press("Escape")
    assert not violations(explorer)


def test_the_theme_changes_the_drawings(explorer):
    before = explorer.picture("map")
    explorer.page.locator("button[aria-label='Light or dark']").click()
    assert explorer.settle().picture("map") != before
    explorer.page.locator("button[aria-label='Light or dark']").click()
    assert explorer.settle().picture("map") == before


def test_drawings_have_the_colours_of_the_theme_also_where_the_system_forces_others(
    browser, address
):
    """The ink of a light theme lay on the black of a system with high contrast.

    The page is one of its own: in another the theme that a test before chose outlives the system's.
    """
    context = browser.new_context(
        forced_colors="active", color_scheme="dark", reduced_motion="reduce"
    )
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("html[data-ready][data-theme=dark]")
    page.locator("button[aria-label='Light or dark']").click()
    page.keyboard.press("l")
    for drawn in (".plot", ".tip", ".legend canvas"):
        colours = page.locator(drawn).first.evaluate(
            "(e) => [getComputedStyle(e).backgroundColor, getComputedStyle(e).color]"
        )
        assert colours == ["rgb(255, 255, 255)", "rgb(22, 25, 29)"]
    context.close()


def test_motion_is_reduced_where_that_is_wished(explorer):
    """The context asks for reduced motion: nothing moves until it is told to."""
    assert explorer.page.evaluate("() => explorer.clock.playing") is False


def test_the_mechanism_plays_by_itself_where_motion_is_welcome(browser, address):
    context = browser.new_context(reduced_motion="no-preference")
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("html[data-ready]")
    assert page.evaluate("() => explorer.clock.playing") is True
    context.close()


def test_everything_is_reached_by_tab(explorer):
    explorer.page.evaluate("() => document.activeElement.blur()")
    names = set()
    for _ in range(90):
        explorer.page.keyboard.press("Tab")
        names.add(
            explorer.page.evaluate("() => document.activeElement.getAttribute('aria-label') ?? ''")
        )
    assert {"Preset", "Model", "Friction law", "Help", "Undo"} - {"Undo"} <= names
    plots = [name for name in names if name.startswith(("From one global", "Steady motions"))]
    assert len(plots) == 2
