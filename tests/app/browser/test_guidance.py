"""What the page says of itself: sentences, legend, tour, table."""

import re
from importlib.resources import files

import numpy as np
import pytest
from tests.app.browser.test_looks import violations

import stickslip as ss

VIEWS = ["map", "mechanism", "diagram", "basins", "power", "portrait-1", "plane", "law"]


@pytest.fixture(autouse=True)
def _nothing_is_held(explorer):
    explorer.page.evaluate("() => document.activeElement.blur()")


def sentence(explorer, panel):
    return explorer.panel(panel).locator(".sentence").text_content()


def test_a_sentence_says_what_is_seen(explorer, collision):
    explorer.settle("diagram", "basins", "power")
    assert all(len(sentence(explorer, view)) > 20 for view in VIEWS)
    assert "S1 and S4 attract, 2 repel" in sentence(explorer, "map")
    assert f"{collision.value:.8g}: border collision" in sentence(explorer, "diagram")
    shares = [float(x) for x in re.findall(r"([\d.]+) %", sentence(explorer, "basins"))]
    assert sum(shares) == pytest.approx(100, abs=0.2)
    explorer.type_into("V", 0.037)
    assert "S1 attracts" in sentence(explorer, "map")
    assert "behind, at" in sentence(explorer, "diagram")
    assert sentence(explorer, "diagram").startswith("At V = 0.037, the line; behind")
    explorer.type_into("V", 0.05)
    said = sentence(explorer, "diagram")
    assert said.startswith("At V = 0.05, right of what is shown; behind")


def test_a_map_without_orbits_says_so(explorer):
    explorer.settle("power")
    found = explorer.page.evaluate(
        """() => {
            const answer = explorer.answers.get("map");
            const { parts } = answer;
            const told = [];
            const views = explorer.views.filter(({ id }) => id === "map" || id === "power");
            const say = () => told.push(...views.map((view) => view.sentence()));
            const without = ({ data, ...part }) => ({ ...part, data: { ...data, orbits: [] } });
            answer.parts = parts.map((part) => (part.data.orbits ? without(part) : part));
            say();
            answer.parts = parts.filter(({ data }) => !data.orbits);
            answer.before = [];
            say();
            answer.parts = parts;
            return told;
        }"""
    )
    assert ", at f(d): no orbit is known. Nearest" in found[0]
    assert found[1] == "Repeating after 2 sticks: no orbit is known."
    assert ", at f(d). Nearest" in found[2]
    assert found[3] == "Repeating after 2 sticks."


def test_orbits_that_are_not_asked_for_are_not_those_of_other_values(explorer):
    explorer.type_into("max_period", 0)
    assert explorer.view("map", "view.orbits.orbits") == []
    assert ", at f(d). Nearest" in sentence(explorer, "map")


def test_a_diagram_without_an_attractor_shows_the_map_s_domain(explorer):
    explorer.settle("diagram")
    ends = explorer.page.evaluate(
        """() => {
            const view = explorer.views.find(({ id }) => id === "diagram");
            Object.defineProperty(view, "dots", { get: () => [], configurable: true });
            view.update();
            delete view.dots;
            return view.plot.view.slice(2);
        }"""
    )
    assert ends == pytest.approx(ss.examples.coulomb().domain)


def test_no_two_orbits_have_one_name(explorer):
    orbits = explorer.view("map", "view.orbits.orbits")
    proper = {o["name"]: o["points"] for o in orbits if o["kind"] != "infinitely unstable"}
    assert sorted(proper) == ["S1", "S4", "U1", "U2"]  # as figure 4 of the paper
    assert proper["U1"] < proper["U2"]
    assert len({orbit["name"] for orbit in orbits}) == len(orbits)
    two = [{"stable": True, "kind": "stable", "period": 2, "points": [x, 1]} for x in (0.3, 0.1)]
    names = "async (orbits) => (await import('/static/marks.js')).named(orbits)"
    assert [o["name"] for o in explorer.page.evaluate(names, two)] == ["S2b", "S2"]


def test_words_stand_beside_the_sliders(explorer):
    words = explorer.page.locator(".row.worded:visible .word").all_text_contents()
    assert "driving velocity" in words
    assert all(words)


def test_itineraries_are_bars(explorer):
    (four,) = ss.periodic_orbits(ss.examples.coulomb(), period=4)
    explorer.point_at("map", four.points[0], four.points[1])
    bars = explorer.panel("map").locator(".tip svg.modes")
    assert bars.count() == 4
    first = bars.first.get_attribute("aria-label").split("; ")
    assert len(first) == len(four.itinerary[0].split())
    assert first[-1] == "1 sticks, 2 sticks"


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_legend_has_every_letter(explorer, theme):
    if explorer.page.evaluate("() => document.documentElement.dataset.theme") != theme:
        explorer.page.keyboard.press("t")
    explorer.page.keyboard.press("l")
    legend = explorer.page.locator("dialog.legend")
    text = legend.text_content()
    assert all(name in text for name in ("S4", "U1", "BC", "PD", "LP", "BM", "IC", "CR", "thick"))
    explorer.shoot(f"legend {theme}")
    assert not violations(explorer, ".legend")
    explorer.page.keyboard.press("Escape")
    legend.wait_for(state="detached")
    if theme == "dark":
        explorer.page.keyboard.press("t")


def test_the_tour_is_walked_by_keyboard_alone(explorer):
    seen = []
    explorer.page.keyboard.press("g")
    for step in range(5):
        tour = explorer.page.locator(".tour")
        assert tour.locator("h2").text_content().startswith(f"{step + 1} of 5")
        model = explorer.state["model"]
        seen.append(model["V"] if step < 3 else model["alpha"])
        if step == 2:
            assert not violations(explorer, ".tour")
            explorer.page.keyboard.press("Shift+Tab")  # Back
            explorer.page.keyboard.press("Shift+Tab")  # the last value in the text
            explorer.page.keyboard.press("Shift+Tab")
            explorer.page.keyboard.press("Enter")
            assert explorer.state["model"]["V"] == 0.0369
            for _ in range(3):
                explorer.page.keyboard.press("Tab")
        explorer.page.keyboard.press("Enter")
    assert seen == [0.0366, 0.0369, 0.037, 1.208, 1.211]
    assert explorer.page.locator(".tour").is_hidden()


def seen_of_tour(explorer):
    """Step, value of the model, whether the tour's text is seen, and what has the focus."""
    tour = explorer.page.locator(".tour")
    focus = explorer.page.evaluate("() => document.activeElement.textContent")
    return tour.locator("h2").text_content()[:1], tour.is_visible(), focus


def test_the_tour_goes_on_in_the_large_view(explorer):
    press = explorer.page.keyboard.press
    press("g")
    press("Enter")
    for key, large in (("f", 2), ("f", 0), ("f", 2), ("Escape", 0), ("f", 2)):
        press(key)
        assert seen_of_tour(explorer) == ("2", True, "Next")
        assert len(explorer.state["large"]) == large
    explorer.settle()
    explorer.shoot("tour, large")
    assert not violations(explorer)
    tour = explorer.page.locator(".tour")
    assert tour.evaluate("(e) => parseFloat(getComputedStyle(e).fontSize)") >= 18
    assert explorer.panel("map").bounding_box()["height"] > 450
    box = tour.bounding_box()
    assert box["y"] + box["height"] <= 800
    tour.get_by_role("button", name="V = 0.0366").click()
    assert explorer.state["model"]["V"] == 0.0366
    assert len(explorer.state["large"]) == 2
    press("g")
    assert tour.is_hidden()
    press("g")
    assert seen_of_tour(explorer) == ("2", True, "Next")
    press("Enter")
    assert seen_of_tour(explorer)[0] == "3"
    assert len(explorer.state["large"]) == 2
    tour.get_by_role("button", name="End").click()
    press("Escape")


def test_a_clicker_walks_the_tour(explorer):
    press = explorer.page.keyboard.press
    press("PageDown")
    assert explorer.page.locator(".tour").is_hidden()
    press("g")
    steps = []
    for key in (*["PageDown"] * 5, "PageUp", "ArrowLeft", "ArrowRight"):
        press(key)
        steps.append(seen_of_tour(explorer)[0])
    assert steps == [*"2345", "5", *"434"]
    slider = explorer.page.locator(".row:visible input[type=range]").first
    slider.focus()
    before = slider.input_value()
    press("ArrowRight")
    press("PageDown")
    assert seen_of_tour(explorer)[0] == "4"
    assert slider.input_value() != before
    slider.blur()
    press("PageDown")
    assert seen_of_tour(explorer)[0] == "5"
    explorer.page.locator(".tour").get_by_role("button", name="Done").click()


def test_the_tour_shows_what_it_speaks_of(explorer):
    explorer.page.keyboard.press("g")
    for said in ("", "at 0.2794: block 2", "at 0.2795: block 2", "at 0.3815: block 2", ""):
        explorer.settle()
        explorer.shoot(f"tour {explorer.page.locator('.tour h2').text_content()[:1]}", "diagram")
        assert said in sentence(explorer, "map")
        explorer.page.keyboard.press("PageDown")
    # Those that are shipped: test_shipped.py computes them anew.
    diagram = "explorer.views.find(({ id }) => id === 'diagram')"
    explorer.page.wait_for_function(f"() => {diagram}.bifurcations.length")
    seen, known = explorer.page.evaluate(
        """() => {
            const { prototype } = CanvasRenderingContext2D;
            const { fillText } = prototype;
            const seen = [];
            prototype.fillText = function (...of) {
                seen.push(of[0]);
                return fillText.apply(this, of);
            };
            const view = explorer.views.find(({ id }) => id === "diagram");
            view.plot.paint();
            prototype.fillText = fillText;
            return [seen, view.bifurcations.map(({ short }) => short)];
        }"""
    )
    assert seen.count("CR") >= known.count("CR") == 2
    explorer.page.get_by_role("button", name="Done").click()


def test_the_tour_says_what_the_library_finds(collision):
    source = (files("stickslip.app") / "static" / "tour.js").read_text(encoding="utf-8")
    text = source.replace("\N{MINUS SIGN}", "-")
    assert f"V = {collision.value:.6f}" in text
    jumps = ss.breakpoints(ss.examples.coulomb(V=0.0369))
    (graze,) = [one for one in jumps if "block 2 grazes" in one.mechanism]
    assert f"d = {graze.d:.4f}" in text
    f = ss.event_map(ss.examples.law9())
    (s1,) = [orbit for orbit in ss.periodic_orbits(f, 1) if orbit.stable]
    assert f"{s1.multiplier:.2f}" in text
    (corner,) = [one for one in ss.breakpoints(f) if 0.38 < one.d < 0.383]
    assert f"d = {corner.d:.4f}" in text
    assert f"from {corner.left_slope:.2f} to {corner.right_slope:.2f}" in text
    periods = [found.period for found in ss.attractors(ss.examples.coulomb(V=0.037))]
    assert f"after {max(periods)} sticks" in text
    found = ss.bifurcations(
        ss.examples.law9(), "alpha", (1.208, 1.2105), window=(0.379, 0.39), max_period=2
    )
    assert [f"{one.value:.5f}" in text for one in found] == [True, True]


def test_the_table_leads_to_orbits_breaks_and_bifurcations(explorer, collision):
    explorer.settle("diagram")
    explorer.page.keyboard.press("o")
    table = explorer.panel("table")
    assert table.is_visible()
    explorer.shoot("table")
    assert not violations(explorer, "[data-panel=table]")
    rows = table.locator("tbody tr")
    assert rows.count() == explorer.view("table", "view.things.length") > 20
    assert explorer.page.evaluate("() => document.activeElement.className") == "name"
    explorer.page.keyboard.press("ArrowDown")
    assert " at d = " in explorer.page.evaluate("() => document.activeElement.ariaLabel")
    table.get_by_label("Go to BC").click()
    assert explorer.settle().state["model"]["V"] == pytest.approx(collision.value, rel=1e-9)
    table.get_by_label("Just before BC").click()
    assert explorer.state["model"]["V"] == pytest.approx(collision.value - 1.5e-6, rel=1e-9)
    explorer.settle()
    names = explorer.view("table", "view.things.map(({ name }) => name)")
    table.get_by_role("button", name="Name").first.click()
    shown = table.locator("tbody button.name").all_text_contents()
    numbers = [int(name[1:]) for name in shown if re.fullmatch(r"U\d+", name)]
    assert numbers == sorted(numbers)
    assert sorted(shown) == sorted(names)
    where = table.get_by_role("button", name="Where")
    where.click()
    assert table.locator("th").nth(2).get_attribute("aria-sort") == "ascending"
    values = table.locator("tbody tr td:nth-child(3)").all_text_contents()
    d = [float(v.removeprefix("d = ").replace("\u2212", "-")) for v in values if v.startswith("d")]
    assert d == sorted(d)
    where.click()
    assert table.locator("th").nth(2).get_attribute("aria-sort") == "descending"
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("o")
    assert table.is_hidden()
    assert explorer.panel("plane").is_visible()


def test_no_row_of_the_table_is_seen_above_its_head_nor_has_the_focus_beneath(explorer):
    explorer.page.keyboard.press("o")
    table = explorer.panel("table")
    table.locator("tbody button.name").last.focus()
    above, beneath = table.evaluate(
        """(table) => {
            const place = (part) => part.getBoundingClientRect();
            const [holder, head] = ["[role=region]", "th"].map((one) => table.querySelector(one));
            const above = holder.scrollTop && place(head).top - place(holder).top;
            const upwards = [...table.querySelectorAll("button.name")].reverse();
            const isBeneath = (name) => (name.focus(), place(name).top < place(head).bottom);
            return [above, upwards.filter(isBeneath).length];
        }"""
    )
    assert (above, beneath) == (pytest.approx(0.0, rel=0.0, abs=0.1), 0)
    explorer.page.keyboard.press("o")


@pytest.mark.parametrize(("tool", "key"), [("Table", "o"), ("Tour", "g")])
def test_what_takes_the_focus_gives_it_back(explorer, tool, key):
    explorer.page.locator(f".tool[aria-label={tool}]").focus()
    explorer.page.keyboard.press("Enter")
    focused = "() => document.activeElement.ariaLabel ?? document.activeElement.textContent"
    assert explorer.page.evaluate(focused) != tool
    explorer.page.keyboard.press(key)
    assert explorer.page.evaluate(focused) == tool


def test_the_table_takes_no_place_where_it_is_not_shown(explorer):
    table, portrait = explorer.panel("table"), explorer.panel("portrait-1")
    explorer.page.keyboard.press("o")
    assert table.is_visible()
    assert portrait.is_hidden()
    explorer.show("preset=chain")
    assert table.is_hidden()
    assert portrait.is_visible()
    explorer.show()
    explorer.page.evaluate("() => explorer.store.update({ large: ['portrait-1'] }, 'test')")
    assert portrait.is_visible()
    explorer.page.keyboard.press("Escape")
    assert table.is_visible()
    explorer.page.keyboard.press("o")
    explorer.show("preset=chain")
    explorer.page.keyboard.press("o")
    assert "this model has none" in explorer.page.locator(".toast").text_content()
    explorer.page.keyboard.press("o")


def test_the_table_has_no_bifurcations_of_older_values(explorer):
    """Its state is that of the map, which is known long before the diagram."""
    explorer.settle("diagram")
    explorer.page.keyboard.press("o")
    rows = explorer.panel("table").get_by_label("Go to BC")
    assert rows.count() == 1
    explorer.page.evaluate(
        """() => {
            const ask = explorer.ask.bind(explorer);
            explorer.ask = (slot) => slot !== "diagram" && ask(slot);
            explorer.setParameter("mu", 0.23);
        }"""
    )
    explorer.settle("map")
    assert rows.count() == 0
    assert "bifurcations along V: not of these values." in sentence(explorer, "table")
    explorer.page.evaluate("() => { delete explorer.ask; explorer.setParameter('mu', 0.22); }")
    explorer.settle("diagram")
    assert rows.count() == 1
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("o")


def test_coordinates_and_parameters_have_one_name_in_all_texts(explorer):
    explorer.show("preset=damper", "map", "basins")
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("o")
    table = explorer.panel("table")
    assert "φ = 3.14" in table.locator("tbody").text_content()
    assert table.get_by_label("Go to S1 at φ = ").count() == 1
    assert "along a:" in sentence(explorer, "table")
    assert explorer.view("basins", "view.read(1)").startswith("φ = 1: no further return")
    assert explorer.view("diagram", "view.read(1.5, 2)") == "a = 1.5, φ = 2"
    explorer.page.keyboard.press("o")
    assert explorer.plot("map").get_attribute("aria-label").startswith("From one return of")
    assert "from each φ" in explorer.plot("basins").get_attribute("aria-label")
    explorer.show("preset=hunting-axis", "map")
    assert explorer.page.evaluate("() => explorer.written('A_3_1')") == "A₃,₁"


def test_a_click_on_a_mark_snaps_to_it(explorer, collision):
    (four,) = ss.periodic_orbits(ss.examples.coulomb(), period=4)
    x, y = explorer.spot("map", four.points[0], four.points[1])
    explorer.page.mouse.click(x + 3, y + 2)
    explorer.page.wait_for_timeout(300)
    assert explorer.settle().state["d"] == pytest.approx(min(four.points), rel=1e-9)
    explorer.settle("diagram")
    x, y = explorer.spot("diagram", collision.value, collision.points[0])
    explorer.page.mouse.click(x - 3, y + 2)
    explorer.page.wait_for_timeout(300)
    assert explorer.state["model"]["V"] == pytest.approx(collision.value, rel=1e-9)
    assert np.isclose(explorer.state["d"], collision.points[0], rtol=1e-9)


@pytest.mark.parametrize(
    ("preset", "two"),
    [("coulomb", ["map", "mechanism"]), ("oscillator", ["mechanism", "portrait-1"])],
)
def test_two_views_are_presented_large(explorer, preset, two):
    explorer.show(f"preset={preset}")
    explorer.page.keyboard.press("f")
    explorer.settle()
    explorer.shoot(f"present {preset}")
    visible = "explorer.views.filter(({ panel }) => panel.section.checkVisibility())"
    assert explorer.page.evaluate(f"() => {visible}.map(({{ id }}) => id)") == two
    sizes = [explorer.panel(name).bounding_box() for name in two]
    assert all(box["width"] > 600 and box["height"] > 700 for box in sizes)
    font = "(e) => parseFloat(getComputedStyle(e).fontSize)"
    assert explorer.panel(two[0]).locator(".sentence").evaluate(font) >= 18
    assert explorer.view(two[1], "view.plot.scale") == 1.6
    assert explorer.page.locator(".controls").is_hidden()
    assert not violations(explorer)
    explorer.page.keyboard.press("Escape")
    assert explorer.page.locator(".controls").is_visible()
    assert explorer.state["large"] == []


def test_what_is_presented_is_chosen_and_kept_in_the_address(explorer):
    explorer.page.get_by_role("button", name="Present").click()
    first, second = (explorer.page.get_by_label(f"{n} large view") for n in ("First", "Second"))
    first.select_option("diagram")
    second.select_option("")
    explorer.settle("diagram")
    assert explorer.state["large"] == ["diagram"]
    assert explorer.panel("diagram").bounding_box()["width"] > 1200
    explorer.page.wait_for_function("() => location.hash.includes('large=diagram')")
    explorer.open(explorer.page.evaluate("() => location.hash.slice(1)"))
    assert explorer.panel("diagram").is_visible()
    assert explorer.panel("map").is_hidden()
    first.focus()
    explorer.page.keyboard.press("Escape")
    assert explorer.state["large"] == []
    explorer.page.keyboard.press("Control+z")
    assert explorer.panel("map").is_hidden()
    explorer.click("diagram", 0.0369, -0.1)  # the pointer means what it is drawn on
    assert explorer.state["model"]["V"] == pytest.approx(0.0369, rel=1e-4)
    explorer.page.get_by_role("button", name="Present").click()
    assert explorer.panel("map").is_visible()
