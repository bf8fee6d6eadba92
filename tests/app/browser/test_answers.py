"""One rule for the state of an answer: shown at once, current, stale or failed, in every view."""

import json

import pytest
from tests.app.browser.test_looks import violations
from tests.app.talk import COULOMB

from stickslip.app.folder import preset_names
from stickslip.app.requests import message

STATES = """() => Object.fromEntries(explorer.views.filter(({ panel }) => !panel.section.hidden)
    .map(({ id, panel }) => [id, panel.section.dataset.state]))"""
SHOWN = "() => explorer.quickSlots.every((slot) => explorer.answers.has(slot))"


def states(page):
    return page.evaluate(STATES)


@pytest.fixture
def lonely(browser, address):
    """A page whose server takes its questions and never answers."""
    context = browser.new_context(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    page = context.new_page()
    page.sockets = []
    page.route_web_socket("**/ws", lambda socket: page.sockets.append(socket))
    page.goto(address)
    page.wait_for_function("() => window.explorer")
    yield page
    context.close()


@pytest.mark.parametrize("preset", preset_names())
def test_every_view_of_every_preset_shows_something_at_once(lonely, address, preset):
    lonely.evaluate(  # at once
        "(newURL) => dispatchEvent(new HashChangeEvent('hashchange', { newURL }))",
        f"{address}#preset={preset}",
    )
    lonely.wait_for_function(
        "() => explorer.views.every(({ panel }) => panel.section.hidden || "
        "panel.section.dataset.state === 'example')"
    )
    badge = lonely.locator("[data-panel=mechanism] .badge")
    assert badge.text_content() == "shipped answer"
    assert "being computed" in badge.get_attribute("title")


def test_progress_of_the_kernels_is_told(lonely):
    lonely.wait_for_function("() => explorer.answers.has('diagram')")
    lonely.evaluate(
        "() => explorer.connection.onchange(true, { done: 3, of: 11 })",
    )
    assert "3 of 11 steps" in lonely.locator(".connection").text_content()
    lonely.evaluate("() => explorer.connection.onchange(true)")
    assert lonely.locator(".connection").text_content() == ""


def test_a_server_that_is_still_loading_is_not_called_gone(browser, address):
    page = browser.new_page(viewport={"width": 1280, "height": 800}, reduced_motion="reduce")
    page.add_init_script("window.WebSocket = class { readyState = 0; }")
    page.goto(address)
    page.wait_for_function("() => window.explorer")
    page.wait_for_function(SHOWN)
    badge = page.locator("[data-panel=map] .badge")
    assert badge.text_content() == "shipped answer"
    assert "being computed" in badge.get_attribute("title")
    page.evaluate("() => explorer.setParameter('mu', 0.3)")
    assert badge.text_content() == "older values: computing"
    assert page.locator(".connection").text_content() == ""
    page.context.close()


def test_what_is_shipped_gives_way_to_what_is_computed(explorer):
    explorer.open()
    explorer.settle("map", "basins")
    assert states(explorer.page)["map"] == "current"
    assert explorer.page.evaluate("() => explorer.answers.get('map').shipped") is None


def test_word_of_progress_redraws_nothing(explorer):
    explorer.open()
    explorer.settle("diagram")
    redrawn = explorer.page.evaluate(
        """async () => {
            await new Promise((next) => requestAnimationFrame(() => setTimeout(next)));
            const { plot } = explorer.views.find(({ id }) => id === "diagram");
            const { question } = explorer.answers.get("diagram");
            const told = { part: 0, last: false, progress: 0.9, arrays: {} };
            explorer.receive("diagram", question, { ...told, data: { part_name: "progress" } });
            return plot.dirty;
        }"""
    )
    assert not redrawn


@pytest.mark.parametrize(
    ("change", "marked"),
    [
        ("setParameter('V', explorer.parameter + 1e-4)", {"diagram"}),
        ("startAt(explorer.state.d + 1e-3)", {"map", "power", "basins", "diagram"}),
    ],
)
def test_until_answers_come_only_what_marks_a_new_value_is_drawn(explorer, change, marked):
    explorer.open()
    explorer.settle("basins", "power")
    drawn = explorer.page.evaluate(
        f"""async () => {{
            explorer.askAll = () => {{}};
            explorer.{change};
            delete explorer.askAll;
            const due = ({{ plots }}) => plots.some(({{ pending }}) => pending);
            return explorer.views.filter(due).map(({{ id }}) => id);
        }}"""
    )
    assert set(drawn) == marked


def test_of_the_map_its_power_draws_the_orbits_alone(explorer):
    explorer.open()
    explorer.settle("power")
    drawn = explorer.page.evaluate(
        """async () => {
            const { plot } = explorer.views.find(({ id }) => id === "power");
            const { question } = explorer.answers.get("map");
            const drawn = (data) => {
                explorer.receive("map", question, { part: 0, last: false, arrays: {}, data });
                return plot.dirty;
            };
            return [drawn({ part_name: "samples" }), drawn({ part_name: "orbits", orbits: [] })];
        }"""
    )
    assert drawn == [False, True]


def test_older_values_are_dimmed_with_the_reason(lonely):
    lonely.wait_for_function(SHOWN)
    slider = lonely.locator("[data-slider='V']")
    slider.focus()
    slider.press("ArrowRight")
    found = states(lonely)
    assert {found[name] for name in ("map", "basins", "power", "mechanism", "plane")} == {"stale"}
    assert found["diagram"] in ("example", "empty")  # along V it is what it was
    assert lonely.locator("[data-panel=map] .badge").text_content() == "older values: computing"
    lonely.wait_for_timeout(800)
    canvas = lonely.locator("[data-panel=map] canvas").first
    assert float(canvas.evaluate("(c) => getComputedStyle(c).opacity")) < 0.5


def test_a_server_that_is_gone_is_the_reason(lonely):
    lonely.wait_for_function(SHOWN)
    for socket in lonely.sockets:
        socket.close()
    lonely.locator(".connection.error").wait_for()
    assert states(lonely)["map"] == "example"  # it is of these values, whoever is gone
    slider = lonely.locator("[data-slider='V']")
    slider.focus()
    slider.press("ArrowRight")
    badge = lonely.locator("[data-panel=map] .badge")
    assert badge.text_content() == "older values: the server does not answer"
    lonely.get_by_label("Model", exact=True).select_option("oscillator")
    for panel in ("mechanism", "portrait-1", "cycle", "law"):  # nothing of it was seen before
        badge = lonely.locator(f"[data-panel={panel}] .badge")
        assert badge.text_content() == "the server does not answer"
        assert states(lonely)[panel] == "empty"  # so its words are not dimmed


def test_a_server_that_says_nothing_for_long_does_not_answer(lonely):
    """Where the network was offline, or the server stopped, all went on saying that it computes."""
    lonely.wait_for_function(SHOWN)
    lonely.clock.install()
    slider = lonely.locator("[data-slider='V']")
    slider.focus()
    slider.press("ArrowRight")
    badge = lonely.locator("[data-panel=map] .badge")
    status = lonely.locator(".connection")
    beat = message({"view": "beat", "data": {}})
    for patience in (5_000, 10_000):  # it spoke after all: the line is slow
        lonely.sockets[0].send(beat)
        lonely.wait_for_function("() => !explorer.connection.lost")
        lonely.clock.run_for(patience - 1_000)
        assert badge.text_content() == "older values: computing"
        assert not status.text_content()
        lonely.clock.run_for(2_000)
        assert badge.text_content() == "older values: the server does not answer"
        assert status.text_content() == "The server does not answer; waiting for it …"
        assert states(lonely)["map"] == "stale"


def test_of_a_server_that_is_asked_nothing_no_word_is_waited_for(lonely):
    lonely.wait_for_function(SHOWN)
    lonely.clock.install()
    lonely.evaluate(
        """() => {
            const { connection } = explorer;
            [...connection.running.keys()].forEach((slot) => connection.cancel(slot));
        }"""
    )
    lonely.clock.run_for(60_000)
    assert not lonely.locator(".connection").text_content()


def places(page):
    return page.locator("main .panel, .controls .row, fieldset").evaluate_all(
        "(all) => all.map((e) => JSON.stringify(e.getBoundingClientRect()))"
    )


def test_one_error_in_one_place_that_moves_nothing(explorer):
    before = places(explorer.page)
    explorer.type_into("mu", 1.7)
    explorer.page.wait_for_function(
        "() => explorer.views.every(({ panel }) => panel.section.hidden || "
        "panel.section.dataset.state === 'failed')"
    )
    assert explorer.page.get_by_text("μk = 1.7").count() == 1
    assert explorer.view("map", "view.values.arrays.x.length") > 600  # dimmed, but there
    assert places(explorer.page) == before
    explorer.type_into("mu", 0.22)
    assert explorer.page.locator(".controls > .error").is_hidden()
    assert "failed" not in states(explorer.page).values()


@pytest.mark.parametrize(
    ("formula", "told"),
    [
        ("a_2 - 3*a_1", " of the friction law 'a_2 - 3*a_1'; allowed: 0 ≤ F(0) ≤ 1"),
        ("exp(-1*s) + z(-2)", "the formula 'exp(-1*s) + z(-2)' calls 'z' at character 13"),
        ("s**-2", "friction law 's**-2' failed at s = 0: division by zero"),
    ],
)
def test_a_formula_is_told_as_it_was_typed(explorer, formula, told):
    law = {"law": formula} | {name: 0.1 for name in ("a_1", "a_2") if name in formula}
    model = {**COULOMB, "friction": law}
    explorer.page.evaluate(
        "(m) => { location.hash = 'model=' + encodeURIComponent(JSON.stringify(m)); }", model
    )
    error = explorer.page.locator(".controls > .error")
    explorer.page.wait_for_function("() => document.querySelector('.controls > .error').innerText")
    assert told in error.text_content()


def test_errors_name_numbers_as_the_page_does(explorer):
    error = explorer.page.locator(".controls > .error")
    for model, name, told in [
        ("coulomb", "alpha", "α = 40 is not allowed: α must be a finite number, 0 ≤ α ≤ 30."),
        ("brake", "mu_1", "contact 1: μk = 40 of the friction law Coulomb is not allowed: μk must"),
    ]:
        explorer.show(f"preset={model}")
        explorer.type_into(name, 40)
        explorer.page.wait_for_function(
            "() => document.querySelector('.controls > .error').innerText"
        )
        assert told in error.text_content()


def test_of_two_laws_the_number_at_fault_is_marked_alone(explorer):
    laws = [{"law": "coulomb", "mu": mu} for mu in (0.2, 0.3)]
    explorer.show(f"model={json.dumps({**COULOMB, 'friction': laws})}")
    explorer.type_into("mu_2", 40)
    explorer.page.wait_for_selector(".controls [aria-invalid]")
    marked = "() => [...document.querySelectorAll('[aria-invalid]')].map(({ name }) => name)"
    assert explorer.page.evaluate(marked) == ["mu_2"]


def test_a_start_and_a_window_that_the_domain_leaves_behind_are_left(explorer):
    """They were refused, one after the other, where a slider had moved what they lie in."""
    explorer.show("preset=law9")
    with explorer.asking_only("locus"):
        explorer.page.evaluate("() => explorer.setParameter('alpha', 3)")
        explorer.settle("locus")
    explorer.page.evaluate("() => explorer.askAll()")
    explorer.page.wait_for_function("() => explorer.standing('motion').kind === 'current'")
    explorer.settle("map")
    low, high = explorer.state["map"]["domain"]
    assert high == pytest.approx(2.301 / 7, rel=1e-12)
    field = explorer.page.locator(".controls input[name='d']")
    assert float(field.input_value()) == low + high == 0.0
    assert "0.3812 lies outside" in explorer.page.locator(".controls").text_content()
    assert explorer.page.locator(".controls > .error").is_hidden()
    assert explorer.view("map", "view.plot.view.slice(0, 2)") == [low, high]
    assert explorer.panel("map").locator(".fit").is_visible()  # it can be removed
    explorer.page.evaluate("() => explorer.setParameter('alpha', 1.208)")
    explorer.page.wait_for_function("() => explorer.question('motion').request.d === 0.3812")
    explorer.settle("map")
    assert explorer.view("map", "view.plot.view.slice(0, 2)") == [0.379, 0.39]


def test_what_is_typed_wrong_is_told_until_it_changes(explorer):
    field = explorer.page.locator("input[name='max_period']")
    field.fill("99")
    field.press("Enter")
    error = explorer.page.locator(".controls > .error")
    assert "whole number" in error.text_content()
    explorer.page.wait_for_timeout(300)
    assert "whole number" in error.text_content()  # answers that come meanwhile leave it
    field.fill("3")
    field.press("Enter")
    assert error.is_hidden()


def test_an_answer_to_older_values_replaces_no_present_one(explorer):
    explorer.page.evaluate(
        """() => {
            const past = structuredClone(explorer.question("map"));
            past.request.model.friction.mu = 0.5;
            const arrays = { x: Float64Array.of(0, 1), f: Float64Array.of(0, 1),
                             branch: Int32Array.of(0, 0) };
            explorer.receive("map", past, { data: { domain: [0, 1], labels: ["a"] }, arrays });
        }"""
    )
    assert explorer.view("map", "view.values.arrays.x.length") > 600


def test_which_map_an_older_model_has_is_not_taken_for_the_present_one(explorer):
    explorer.show("preset=oscillator")
    told = explorer.state["map"]
    explorer.page.evaluate(
        """() => {
            const past = structuredClone(explorer.question("returns"));
            past.request.model.V = 0.9;
            const data = { kind: "line", why: "", coordinates: ["phase"], domain: [0, 1] };
            data.part_name = "returns";
            explorer.receive("returns", past, { data, arrays: {} });
        }"""
    )
    assert explorer.state["map"] == told


def test_what_is_stopped_says_so(lonely):
    lonely.wait_for_function(SHOWN)
    lonely.evaluate(
        """() => {
            explorer.setParameter("mu", 0.3);
            const question = explorer.question("map");
            explorer.connection.forget("map");
            explorer.receive("map", question, { data: {}, last: true, cancelled: true });
        }"""
    )
    badge = lonely.locator("[data-panel=map] .badge")
    assert badge.text_content() == "older values: stopped"


def test_what_is_stopped_stays_so_where_a_sentence_has_another_line(explorer):
    """A plot that got lower had everything asked again, what had been stopped, too."""
    explorer.settle("diagram")
    explorer.type_into("beta", 1.31)
    explorer.page.wait_for_function("() => explorer.connection.running.has('diagram')")
    explorer.page.keyboard.press("Escape")
    explorer.page.wait_for_function("() => !explorer.connection.running.has('diagram')")
    explorer.panel("diagram").locator(".sentence").evaluate(
        "(sentence) => (sentence.style.minHeight = '60px')"
    )
    explorer.page.wait_for_timeout(400)  # sizes are taken up, and answers asked for, by then
    badge = explorer.panel("diagram").locator(".badge").text_content()
    explorer.panel("diagram").locator(".sentence").evaluate("({ style }) => (style.minHeight = '')")
    assert badge == "older values: stopped"


def test_who_comes_back_asks_what_is_wanted_now(explorer):
    """Not first what a slot asked before the connection was lost, nor what was given up."""
    sent, told = explorer.page.evaluate(
        """async () => {
            const { Connection } = await import("/static/connection.js");
            const sent = [], told = [];
            const link = { open: (hears) => (link.hears = hears), send: (one) => sent.push(one) };
            const connection = new Connection(link, () => {});
            const ask = (slot, view) => connection.ask(slot, { view, request: {} },
                ({ cancelled }) => told.push([view, cancelled]));
            link.hears.onopen();
            ask("map", "old");
            ask("diagram", "stopped");
            link.hears.onclose();
            ask("map", "new");
            connection.cancel("diagram");
            sent.length = 0;
            link.hears.onopen();
            return [sent.map(({ slot, view }) => [slot, view]), told];
        }"""
    )
    assert sent == [["map", "new"]]
    assert told == [["stopped", True]]


def test_what_the_next_model_has_not_is_called_off(explorer):
    explorer.page.evaluate(
        """() => {
            window.sent = [];
            const { link } = explorer.connection;
            const send = link.send.bind(link);
            link.send = (message) => { sent.push(message); send(message); };
            explorer.setParameter("mu", 0.23);
        }"""
    )
    explorer.page.wait_for_function("() => explorer.connection.running.has('diagram')")
    explorer.show("preset=oscillator")
    sent = explorer.page.evaluate("() => { delete explorer.connection.link.send; return sent; }")
    assert {"cancel": "diagram"} in sent
    explorer.page.wait_for_function("() => !explorer.connection.running.has('diagram')")


def test_nothing_blanks_while_a_parameter_plays(explorer):
    explorer.settle("basins", "diagram", "power")
    explorer.page.evaluate(
        """() => {
            window.blank = [];
            const slots = ["map", "basins", "power", "diagram", "motion", "cobweb", "locus"];
            window.watch = setInterval(() => {
                for (const slot of slots) {
                    if (!explorer.answers.get(slot)?.parts.length) blank.push(slot);
                }
                const { parts } = explorer.answers.get("basins");
                if (!parts.some(({ arrays }) => arrays.label)) blank.push("bands");
            }, 5);
        }"""
    )
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("p")
    explorer.page.wait_for_function("() => explorer.parameter > 0.03662")
    explorer.page.keyboard.press("p")
    assert explorer.page.evaluate("() => { clearInterval(watch); return blank; }") == []


def test_what_an_answer_leaves_undecided_is_told_and_listed(explorer):
    """The diagram's, in its own panel and in the table that lists its bifurcations."""
    explorer.settle("diagram")
    keys = explorer.page.keyboard
    keys.press("o")
    diagram, table = (explorer.panel(name).locator(".incomplete") for name in ("diagram", "table"))
    assert diagram.is_hidden()
    explorer.page.evaluate(
        """() => {
            const { parts } = explorer.answers.get("diagram");
            const said = { data: { unresolved: ["orbits at X_2", "a sudden change"] }, arrays: {} };
            parts.push(said, said);
            explorer.judge();
        }"""
    )
    for told in (table, diagram):
        assert told.text_content() == "incomplete: 2 unresolved"
        told.focus()
        keys.press("Enter")
        dialog = explorer.page.get_by_role("dialog")
        assert dialog.get_by_role("heading").text_content().endswith(": unresolved")
        assert dialog.get_by_role("listitem").all_text_contents() == [
            "orbits at X₂",
            "a sudden change",
        ]
        assert not violations(explorer, "dialog")
        keys.press("Escape")
        dialog.wait_for(state="detached")
        assert told.evaluate("(button) => button === document.activeElement")
    explorer.shoot("incomplete")
    assert not violations(explorer, "[data-panel=diagram]")
    keys.press("o")
    explorer.page.evaluate("() => explorer.setParameter('alpha', 1.21)")
    assert diagram.is_hidden()  # of older values


def test_of_another_system_nothing_is_shown_as_of_this_one(explorer):
    """Where its own answers failed, those of the last system were told, and their domain."""
    explorer.settle("basins", "diagram")
    stribeck = {**COULOMB, "friction": {"law": "stribeck", "mu": 0.3, "speed": 0.2}}
    with explorer.asking_only("law"):
        explorer.show(f"model={json.dumps(stribeck)}", "law")
        for panel in ("map", "power", "diagram", "basins"):
            assert explorer.view(panel, "view.sentence()") == ""
        assert explorer.view("mechanism", "view.sentence()") == ""
        assert "along V: not of these values" in explorer.view("table", "view.sentence()")
        for panel in ("portrait-1", "plane"):
            assert explorer.view(panel, "view.x ?? null") is None
        assert explorer.page.evaluate("() => explorer.domain() ?? null") is None
    explorer.show()
    assert "S4" in explorer.view("map", "view.sentence()")


FAIL = """(parts) => {
    const none = { id: 0, part: 0, view: "", last: true, progress: 1, data: {}, arrays: {} };
    const question = explorer.question("map");
    for (const part of [...parts, { error: { message: "took too long" } }])
        explorer.receive("map", question, { ...none, ...part });
}"""


def test_of_a_map_that_failed_no_older_orbits_are_told(explorer):
    explorer.settle("power")
    assert "attracts" in explorer.view("power", "view.sentence()")
    values = {"x": [0.0, 0.1], "f": [0.1, 0.2], "branch": [0, 0]}
    first = {"last": False, "arrays": values, "data": {"labels": ["0"], "domain": [-0.6, 0.6]}}
    with explorer.asking_only("power"):
        explorer.page.evaluate("() => explorer.setParameter('alpha', 1.21)")
        explorer.settle("power")
        explorer.page.evaluate(FAIL, [])
        assert explorer.view("power", "view.sentence()") == "Repeating after 2 sticks."
        explorer.page.evaluate(FAIL, [first])
        assert "attract" not in explorer.view("map", "view.sentence()")


@pytest.mark.parametrize("preset", ["coulomb", "drill-string", "brake"])
def test_names_have_no_underscores(explorer, preset):
    explorer.show(f"preset={preset}")
    explorer.settle("basins")
    assert "_" not in explorer.page.evaluate("() => document.body.innerText")
    along = explorer.page.get_by_label("Parameter of the diagram").locator("option")
    assert not any("_" in text for text in along.all_text_contents())


HYPHENS = """() => {
    const said = [...document.querySelectorAll("[title], [aria-valuetext]")];
    const texts = said.flatMap((one) => [one.title, one.getAttribute("aria-valuetext") ?? ""]);
    return [document.body.innerText, ...texts].join("\\n").match(/(?<![\\w.])-\\.?\\d.*/g) ?? [];
}"""


def test_all_numbers_have_one_minus_sign(explorer):
    found = []
    for preset, key in (("coulomb", "o"), ("drill-string", "l"), ("coulomb", "g")):
        explorer.show(f"preset={preset}")
        explorer.page.keyboard.press(key)
        found += explorer.page.evaluate(HYPHENS)
    for _ in range(4):  # the tour's steps
        explorer.page.keyboard.press("Enter")
        found += explorer.page.evaluate(HYPHENS)
    explorer.page.get_by_role("button", name="Done").click()
    explorer.page.keyboard.press("o")
    explorer.type_into("V", "-1")
    found += explorer.page.evaluate(HYPHENS)
    assert not found
