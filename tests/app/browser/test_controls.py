"""Controls: what they change, how fast changes are folded, what undoes them."""

import numpy as np
import pytest

import stickslip as ss


def test_a_slider_is_moved_by_the_keyboard(explorer):
    slider = explorer.page.locator("[data-slider='V']")
    slider.focus()
    slider.press("ArrowRight")
    slider.press("ArrowRight")
    explorer.settle()
    assert explorer.state["model"]["V"] == pytest.approx(0.0368)
    assert explorer.page.locator("input[name='V']").input_value() == "0.0368"
    assert slider.get_attribute("aria-valuetext") == "0.0368"


def test_a_slider_goes_on_from_a_value_beyond_its_end(explorer):
    explorer.type_into("beta", 9)
    slider = explorer.page.locator("[data-slider='beta']")
    slider.focus()
    slider.press("ArrowRight")
    assert explorer.state["model"]["beta"] == 9
    slider.press("ArrowLeft")
    assert 8 < explorer.settle().state["model"]["beta"] < 9


def test_a_slider_is_moved_by_the_pointer(explorer):
    box = explorer.page.locator("[data-slider='alpha']").bounding_box()
    explorer.page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + box["height"] / 2)
    explorer.page.mouse.down()
    explorer.page.mouse.move(box["x"] + 0.6 * box["width"], box["y"] + box["height"] / 2, steps=8)
    explorer.page.mouse.up()
    explorer.settle()
    assert 1.6 < explorer.state["model"]["alpha"] < 2.0


def test_a_belt_below_a_forced_block_is_slid_back_to_rest(explorer):
    explorer.show("preset=canards")
    slider = explorer.page.locator("[data-slider='V']")
    slider.press("ArrowRight")
    assert explorer.state["model"]["V"] == 0.0001
    slider.press("Home")
    assert explorer.settle().state["model"]["V"] == 0


def test_a_number_that_leaves_0_keeps_the_views(explorer):
    """The table leaves 0 out: one with damping was taken for another system, all views blank."""
    slider = explorer.page.locator("[data-slider='damping']")
    slider.press("ArrowRight")
    assert explorer.state["model"]["damping"] == 0.001
    shown = explorer.panel("map").get_attribute("data-state")
    slider.press("Home")
    assert shown != "empty"


def test_many_keys_make_few_questions_and_the_last_wins(explorer):
    explorer.page.evaluate(
        """() => {
            window.sent = [];
            const { socket } = explorer.connection.link;
            const send = socket.send.bind(socket);
            socket.send = (text) => { sent.push(JSON.parse(text)); send(text); };
        }"""
    )
    slider = explorer.page.locator("[data-slider='mu']")
    slider.focus()
    for _ in range(40):
        slider.press("ArrowRight")
    explorer.settle()
    sent = explorer.page.evaluate(
        "() => { delete explorer.connection.link.socket.send; return sent; }"
    )
    asked = [one for one in sent if one.get("slot") == "map"]
    assert explorer.state["model"]["friction"]["mu"] == pytest.approx(0.26)
    assert asked[-1]["request"]["model"]["friction"]["mu"] == pytest.approx(0.26)
    assert len(asked) < 40
    shown = explorer.page.evaluate(
        "() => explorer.answers.get('map').question.request.model.friction.mu"
    )
    assert shown == pytest.approx(0.26)


def test_a_value_out_of_range_is_named_at_its_field(explorer):
    explorer.type_into("mu", 1.7)
    error = explorer.page.locator(".controls > .error")
    assert "μk = 1.7" in error.text_content()
    field = explorer.page.locator("input[name='mu']")
    assert field.get_attribute("aria-invalid") == "true"
    explorer.type_into("mu", 0.22)
    assert error.text_content() == ""
    assert explorer.panel("law").get_attribute("data-state") == "current"
    assert field.get_attribute("aria-invalid") is None


def test_a_duration_that_is_refused_has_its_symbol(explorer):
    explorer.type_into("t_end", -5)
    told = "T = \N{MINUS SIGN}5 is not allowed: T must be a finite number, 0 < T ≤ 5000."
    assert told in explorer.page.locator(".controls > .error").text_content()


def test_a_number_of_a_list_that_is_refused_marks_its_field(explorer):
    explorer.show("preset=chain")
    explorer.page.locator(".controls input[name='x']:visible").fill("0, 5000")
    explorer.page.keyboard.press("Enter")
    told = "x₂ = 5000 is not allowed: x₂ must be a finite number, \N{MINUS SIGN}1000 ≤ x₂ ≤ 1000."
    explorer.page.locator(".controls > .error", has_text=told).wait_for()
    wrong = explorer.page.locator(".controls [aria-invalid]")
    assert wrong.evaluate_all("all => all.map(({ name }) => name)") == ["x"]


def test_an_entry_of_a_list_that_is_no_number_is_refused(explorer):
    """An empty one was passed over: of three blocks two were left, without a word."""
    error = explorer.page.locator(".controls > .error")
    wrong = explorer.page.locator(".controls [aria-invalid]")
    with explorer.asking_only("law"):
        explorer.show("preset=chain", "law")
        before = explorer.state
        for typed, told in (
            ("1,,2", "entry 2 is empty: write 2 to 20 numbers with commas between them."),
            ("1, 2,", "entry 3 is empty: write 2 to 20 numbers"),
            ("1, 1_2 1", "entry 2 '1_2' is not a number: write 2 to 20 numbers"),
        ):
            explorer.page.locator(".controls input[name='static']").fill(typed)
            explorer.page.keyboard.press("Enter")
            assert told in error.text_content()
            assert wrong.evaluate_all("all => all.map(({ name }) => name)") == ["static"]
            assert explorer.state == before


def test_the_range_of_the_start_is_told_in_few_digits(explorer):
    explorer.page.locator(".controls input[name='d']").fill("")
    explorer.page.keyboard.press("Enter")
    told = "its slider goes from \N{MINUS SIGN}0.6764 to 0.6764."
    assert told in explorer.page.locator(".controls > .error").text_content()
    assert ss.event_map(ss.examples.coulomb()).domain[1] > 0.6764
    ends = "import('./static/numbers.js').then(({ within }) => within(...ends))"
    for given, expected in (
        ([-0.25, 1], [-0.25, 1]),
        ([0, 2 / 3], [0, 0.6666]),
        ([-2 / 3, -0.66658], [-0.6666666, -0.66658]),
        ([99.99999, 1234.56], [100, 1234]),
    ):
        assert explorer.page.evaluate(f"(ends) => {ends}", given) == expected


def test_a_start_beyond_the_domain_is_set_to_its_end_with_a_word(explorer):
    toast = explorer.page.locator(".toast")
    explorer.page.evaluate("() => { document.querySelector('.toast').textContent = ''; }")
    explorer.page.locator(".controls input[name='d']").fill("0.1")
    explorer.page.keyboard.press("Enter")
    assert toast.text_content() == ""
    explorer.page.locator(".controls input[name='d']").fill("0.9")
    explorer.page.keyboard.press("Enter")
    assert toast.text_content() == "d = 0.9 lies outside the domain: its end 0.67647 is taken"
    assert explorer.state["d"] == ss.event_map(ss.examples.coulomb()).domain[1]


def test_what_is_wrong_with_all_of_a_model_marks_the_numbers_that_were_changed(explorer):
    """No entry of its matrices is wrong by itself where a motion is too fast to be followed."""
    explorer.show("preset=brake", "law")
    error = explorer.page.locator(".controls > .error")
    wrong = explorer.page.locator(".controls [aria-invalid]")
    for name, value, told in (
        ("damping_1_1", 1e5, "c₁,₁ = 100000: the model's fastest motion has the rate 100000;"),
        ("V_1", 0.03, "V₁ = 0.03 and c₁,₁ = 100000: the model's"),
    ):
        explorer.type_into(name, value)
        assert error.text_content().startswith(told)
    names = wrong.evaluate_all("all => all.map(({ name }) => name).sort()")
    assert names == ["V_1", "damping_1_1"]
    explorer.type_into("damping_1_1", 0.05)
    assert error.text_content() == ""
    assert wrong.count() == 0


def test_an_error_of_a_question_that_is_past_is_not_named(explorer):
    explorer.page.evaluate(
        """() => {
            const past = structuredClone(explorer.question("diagram"));
            past.request.model.friction.mu = 1.7;
            const error = { field: "model.mu", message: "mu = 1.7 is out of its range" };
            explorer.receive("diagram", past, { data: {}, error });
        }"""
    )
    assert explorer.page.locator(".controls > .error").text_content() == ""


def test_undo_and_redo(explorer):
    explorer.type_into("mu", 0.3)
    explorer.type_into("beta", 1.4)
    explorer.page.locator("button[aria-label='Undo']").click()
    assert explorer.settle().state["model"]["beta"] == 1.3
    explorer.page.keyboard.press("Control+z")
    assert explorer.settle().state["model"]["friction"]["mu"] == 0.22
    explorer.page.keyboard.press("Control+y")
    assert explorer.settle().state["model"]["friction"]["mu"] == 0.3


def test_what_changes_nothing_is_no_step_to_undo(explorer):
    explorer.type_into("mu", 0.3)
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("z")
    past = "() => [explorer.store.past.length, explorer.store.future.length]"
    before = explorer.page.evaluate(past)
    for key in "02":
        explorer.page.keyboard.press(key)
    for box in ("null", "[-9, 9, -9, 9]"):
        explorer.page.evaluate(f"() => explorer.zoom('map', {box})")
    assert explorer.page.evaluate(past) == before
    assert before[1] == 1
    field = explorer.page.locator("input[name='max_period']")
    for typed in (99, explorer.state["max_period"]):
        field.fill(str(typed))
        field.press("Enter")
    assert explorer.page.locator(".controls > .error").is_hidden()


def test_another_law_comes_with_its_parameters(explorer):
    laws = explorer.page.locator("select[aria-label='Friction law']")
    laws.select_option("popp-stelter")
    explorer.settle()
    assert explorer.page.locator("input[name='gamma']").is_visible()
    assert explorer.inked("map") > 8
    with explorer.asking_only("law"):
        laws.select_option("stribeck")
        assert explorer.state["model"]["friction"]["law"] == "stribeck"
        assert explorer.page.locator("input[name='speed']").is_visible()
        explorer.page.locator("select[name='exponent']").select_option("2")
        explorer.settle("law")
        assert explorer.state["model"]["friction"]["exponent"] == 2
        assert explorer.inked("law") > 8
    laws.select_option("coulomb")
    explorer.settle()
    assert explorer.page.locator("input[name='speed']").count() == 0


def test_a_control_that_is_made_anew_keeps_the_focus(explorer):
    laws = explorer.page.locator("select[aria-label='Friction law']")
    laws.focus()
    with explorer.asking_only("law"):
        laws.press("ArrowDown")
        assert explorer.state["model"]["friction"]["law"] == "popp-stelter"
        assert laws.evaluate("(made) => made === document.activeElement")
        explorer.page.get_by_label("a law for each block").check()
        each = explorer.page.get_by_label("Friction law of block 2")
        each.focus()
        each.press("ArrowUp")
        assert explorer.state["model"]["friction"][1]["law"] == "coulomb"
        assert each.evaluate("(made) => made === document.activeElement")
        explorer.show("preset=coulomb", "law")  # or what rests asks for kernels of two laws


def test_each_block_may_have_a_law_of_its_own(explorer):
    explorer.page.get_by_label("a law for each block").check()
    assert explorer.settle().state["model"]["friction"] == 2 * [{"law": "coulomb", "mu": 0.22}]
    explorer.type_into("mu_2", 0.3)
    law = ss.Coulomb(mu=0.22), ss.Coulomb(mu=0.3)
    f = ss.event_map(ss.examples.coulomb(friction=law))
    x, y = explorer.view("map", "[[...view.values.arrays.x], [...view.values.arrays.f]]")
    assert f(np.array(x[5::97])) == pytest.approx(np.array(y[5::97]), abs=1e-12)
    with explorer.asking_only("law"):
        explorer.page.get_by_label("Friction law of block 2").select_option("popp-stelter")
        explorer.settle("law")
        assert [one["law"] for one in explorer.state["model"]["friction"]] == [
            "coulomb",
            "popp-stelter",
        ]
        state = explorer.state
        explorer.page.wait_for_function("() => location.hash.includes('law_2=popp-stelter')")
        explorer.shoot("two laws", "law")
        address = explorer.page.evaluate("() => location.hash.slice(1)")
    explorer.show()
    with explorer.asking_only("law"):
        explorer.show(address, "law")
        assert explorer.state["model"] == state["model"]
    explorer.page.get_by_label("a law for each block").uncheck()
    assert explorer.settle().state["model"]["friction"] == {"law": "coulomb", "mu": 0.22}


def test_a_harmonic_force_and_a_start_that_is_chosen(explorer):
    explorer.show("preset=oscillator")
    explorer.type_into("x", "0.1, 0.2")
    assert "0 to 1 numbers" in explorer.page.locator(".controls > .error").text_content()
    explorer.type_into("x", "0.1")
    explorer.page.get_by_label("harmonic forces").check()
    explorer.settle()
    explorer.type_into("forcing.amplitude", 0.3)
    explorer.type_into("d", 0.4)  # a point of the return map: the phase at which the block slips
    assert explorer.state["model"]["forcing"] == {"amplitude": 0.3, "frequency": 1, "phase": 0}
    law = ss.PoppStelter(gamma=3.0)
    force = ss.Harmonic(amplitude=0.3, frequency=1.0)
    model = ss.Oscillator(V=0.2, damping=0.05, friction=law, forcing=force)
    motion = ss.simulate(*ss.return_map(model).begun(0.4), t_end=120.0)
    t, x = explorer.page.evaluate(
        "() => [[...explorer.clock.arrays.t], [...explorer.clock.arrays.x]]"
    )
    assert motion.x(np.array(t[:500]))[:, 0] == pytest.approx(x[:500], abs=1e-9)
    state = explorer.state
    explorer.page.wait_for_function("() => location.hash.includes('d=0.4')")
    explorer.shoot("forced")
    explorer.show(explorer.page.evaluate("() => location.hash.slice(1)"))
    assert explorer.state == state
    explorer.type_into("forcing.frequency", -1)
    assert "frequency" in explorer.page.locator(".controls > .error").text_content()
    field = explorer.page.locator("input[name='forcing.frequency']")
    assert field.get_attribute("aria-invalid") == "true"


def test_another_model_and_back(explorer):
    kind = explorer.page.locator("select[aria-label='Model']")
    kind.select_option("chain")
    explorer.settle()
    field = explorer.page.locator("input[name='static']")
    field.fill("1, 1.2, 1.1, 1")
    field.press("Enter")
    explorer.settle()
    assert explorer.state["model"]["static"] == [1, 1.2, 1.1, 1]
    assert explorer.page.locator(".panel-portrait:visible").count() == 4
    kind.select_option("two_block")
    assert explorer.settle().panel("map").is_visible()


def test_a_preset(explorer):
    presets = explorer.page.locator("select[aria-label='Preset']")
    assert presets.input_value() == "coulomb"
    presets.select_option("fig08")
    explorer.settle()
    assert explorer.state["model"]["V"] == 0.037
    assert explorer.state["power"] == 4


def test_a_preset_of_a_link_is_named_among_those_of_its_model(explorer):
    named = explorer.page.locator("select[aria-label='Preset']")
    with explorer.asking_only("law"):
        for preset in ("law9-map", "law9", "law9-map"):
            explorer.show(f"preset={preset}", "law")
            assert named.input_value() == preset
        explorer.page.evaluate("() => explorer.startAt(0.2)")
        assert named.input_value() == "law9-map"


def test_stepping_and_playing_along_the_parameter(explorer):
    press = explorer.page.keyboard.press
    explorer.page.locator("main").click(position={"x": 2, "y": 2})
    press("]")
    assert explorer.settle().state["model"]["V"] == pytest.approx(0.036603)
    press("[")
    assert explorer.settle().state["model"]["V"] == pytest.approx(0.0366)
    press("p")
    button = explorer.page.locator("button[aria-label='Play along the parameter']")
    assert button.get_attribute("aria-pressed") == "true"
    explorer.page.wait_for_function("() => explorer.state.model.V > 0.036605")
    press("Escape")
    stopped = explorer.settle().state["model"]["V"]
    explorer.page.wait_for_timeout(150)
    assert explorer.state["model"]["V"] == stopped
    assert button.get_attribute("aria-pressed") == "false"


@pytest.mark.parametrize("how", ["undo", "tour", "link", "slider", "along"])
def test_who_goes_elsewhere_stops_what_plays(explorer, how):
    explorer.type_into("mu", 0.3)
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("p")
    explorer.page.wait_for_function("() => explorer.state.model.V > 0.036605")
    match how:
        case "undo":
            explorer.page.keyboard.press("z")
        case "tour":
            explorer.page.keyboard.press("g")
        case "link":
            explorer.show("preset=fig08")
        case "slider":
            explorer.page.locator("[data-slider='alpha']").press("ArrowRight")
        case "along":
            along = explorer.page.locator("select[aria-label='Parameter of the diagram']")
            along.select_option("beta")
    button = explorer.page.locator("button[aria-label='Play along the parameter']")
    assert button.get_attribute("aria-pressed") == "false"
    state = explorer.settle().state
    explorer.page.wait_for_timeout(200)
    assert explorer.state == state
    if how == "tour":
        explorer.page.keyboard.press("g")


def test_what_plays_goes_on_while_the_view_changes(explorer):
    explorer.page.evaluate("() => document.activeElement.blur()")
    explorer.page.keyboard.press("p")
    explorer.page.evaluate("() => explorer.zoom('map', [0, 0.4, 0, 0.4])")
    explorer.page.evaluate("() => explorer.startAt(0.2)")
    value = explorer.page.evaluate("() => explorer.parameter")
    explorer.page.wait_for_function(f"() => explorer.parameter > {value} + 1e-5")


def test_nothing_plays_along_what_has_no_diagram(explorer):
    press = explorer.page.keyboard.press
    explorer.page.evaluate("() => document.activeElement.blur()")
    press("p")
    explorer.show("preset=chain")
    state = explorer.state
    button = explorer.page.locator("button[aria-label='Play along the parameter']")
    assert button.get_attribute("aria-pressed") == "false"
    for key in ("]", "}", "p", "3"):
        press(key)
    explorer.page.wait_for_timeout(200)
    assert explorer.state == state


def test_the_player_taken_up_again_goes_no_faster(explorer):
    steps = explorer.page.evaluate(
        """async () => {
            const key = { key: "p", bubbles: true };
            const press = () => document.body.dispatchEvent(new KeyboardEvent("keydown", key));
            const times = [];
            explorer.goTo = () => times.push(performance.now()); // no map is asked for
            for (let k = 0; k < 7; k++) press();
            while (times.length < 8) await new Promise((go) => setTimeout(go, 20));
            press();
            delete explorer.goTo;
            return times.slice(1).map((time, k) => time - times[k]);
        }"""
    )
    assert min(steps) > 30


def test_the_diagram_takes_another_parameter_and_range(explorer):
    explorer.page.locator("select[aria-label='Parameter of the diagram']").select_option("beta")
    low = explorer.page.locator("input[aria-label='from']")
    low.fill("1.295")
    low.press("Enter")
    high = explorer.page.locator("input[aria-label='to']")
    high.fill("1.305")
    high.press("Enter")
    explorer.settle()
    assert explorer.state["diagram"]["range"] == [1.295, 1.305]
    assert explorer.view("diagram", "view.plot.options.xlabel") == "β"
    told = [
        (low, "2", "β, from = 2: it must be less than 1.305, the range's other end."),
        (high, "", "β, to = no number: it must be more than 1.295, the range's other end."),
        (low, "0.01", "β = 0.01 is not allowed: β must be a finite number, 0.05 ≤ β ≤ 25."),
        (high, "99", "β = 99 is not allowed: β must be a finite number, 0.05 ≤ β ≤ 25."),
    ]
    for end, value, why in told:
        end.fill(value)
        end.press("Enter")
        explorer.page.locator(".controls > .error", has_text=why).wait_for()
        wrong = explorer.page.locator(".controls [aria-invalid]")
        assert wrong.evaluate_all("all => all.map(({ ariaLabel }) => ariaLabel)") == [
            end.get_attribute("aria-label")
        ]
        explorer.show("kind=two_block&along=beta:1.295:1.305")


def test_another_parameter_or_law_leaves_the_periods_that_are_followed(explorer):
    explorer.show("kind=two_block&followed=7")
    assert explorer.state["diagram"]["max_period"] == 7
    explorer.page.locator("select[aria-label='Parameter of the diagram']").select_option("beta")
    assert explorer.state["diagram"]["max_period"] == 7
    with explorer.asking_only("law"):
        explorer.page.locator("select[aria-label='Friction law']").select_option("popp-stelter")
        assert explorer.state["diagram"]["max_period"] == 7
        explorer.show("preset=coulomb", "law")


def test_long_work_shows_its_progress_and_can_be_stopped(explorer):
    explorer.page.evaluate(
        """() => {
            const wide = { range: [0.02, 0.2], full: [0.02, 0.2] };
            explorer.store.update({ diagram: { ...explorer.state.diagram, ...wide } }, "test");
        }"""
    )
    panel = explorer.panel("diagram")
    stop = panel.locator("button.cancel")
    stop.wait_for(state="visible")
    assert panel.locator("progress").is_visible()
    stop.click()
    explorer.page.wait_for_function("() => !explorer.connection.running.has('diagram')")
    assert panel.locator("progress").is_hidden()
    assert stop.is_hidden()


@pytest.mark.parametrize("ranges", [[[0.0366, 0.0367]], [[0.02, 0.2], [0.0366, 0.0367]]])
def test_what_was_stopped_can_be_asked_again_at_once(explorer, ranges):
    """Before the server says that it has stopped; also what waited behind an older question."""
    explorer.page.evaluate(
        """ranges => {
            for (const range of ranges) {
                explorer.store.update({ diagram: { ...explorer.state.diagram, range } }, "test");
                explorer.ask("diagram");
            }
            clearTimeout(explorer.restTimer);
            explorer.cancel("diagram");
            explorer.ask("diagram");
        }""",
        ranges,
    )
    explorer.settle("diagram")
    done, shown = explorer.page.evaluate(
        """() => {
            const { done, question } = explorer.answers.get("diagram");
            return [done, question.request.range];
        }"""
    )
    assert done
    assert shown == ranges[-1]


def test_the_motion_plays_and_pauses(explorer):
    explorer.page.locator("main").click(position={"x": 2, "y": 2})
    explorer.page.keyboard.press("Space")
    explorer.page.wait_for_function("() => explorer.clock.t > 0.5")
    explorer.page.keyboard.press("Space")
    assert explorer.page.evaluate("() => explorer.clock.playing") is False


def test_what_plays_leaves_the_processor_time_for_answers(explorer):
    gaps = explorer.page.evaluate(
        """async () => {
            const { clock } = explorer, { ontick } = clock, times = [];
            clock.ontick = () => times.push(performance.now());
            for (const playing of [true, false, true]) {
                clock.play(playing);
                await new Promise((go) => setTimeout(go, 10));
            }
            while (times.length < 12) await new Promise((go) => setTimeout(go, 20));
            clock.play(false);
            clock.ontick = ontick;
            return times.slice(2).map((time, k) => time - times[k + 1]);
        }"""
    )
    assert min(gaps) > 20  # ms: no frame at once after another, whatever the screen's rate


def test_help_lists_the_keys(explorer):
    explorer.page.locator("main").click(position={"x": 2, "y": 2})
    explorer.page.keyboard.press("?")
    dialog = explorer.page.locator("dialog.help")
    assert "play along the parameter" in dialog.text_content()
    explorer.page.keyboard.press("Escape")
    assert dialog.is_hidden()


def test_a_plot_is_moved_by_the_keyboard(explorer):
    explorer.plot("map").focus()
    explorer.page.keyboard.press("+")
    narrow = explorer.settle().state["windows"]["map"]
    assert narrow[1] - narrow[0] < 1
    explorer.page.keyboard.press("ArrowRight")
    assert explorer.settle().state["windows"]["map"][0] > narrow[0]
    explorer.page.keyboard.press("0")
    assert explorer.settle().state["windows"]["map"] is None


def test_the_time_is_walked_by_the_keyboard(explorer):
    time = explorer.panel("mechanism").locator(".timeline .plot-over")
    time.focus()
    for key, t in (("Home", 0), ("ArrowRight", 1.2), ("PageUp", 13.2), ("ArrowLeft", 12)):
        time.press(key)
        assert explorer.page.evaluate("() => explorer.clock.t") == pytest.approx(t, rel=1e-9)
    assert explorer.panel("mechanism").locator(".timeline .tip").text_content() == "t = 12"
    time.press("End")
    assert explorer.page.evaluate("() => explorer.clock.t") == 120
    time.blur()
    assert explorer.panel("mechanism").locator(".timeline .tip").is_hidden()


def test_the_law_is_read_by_the_keyboard(explorer):
    law = explorer.plot("law")

    def told(part):
        return explorer.panel("law").locator(part).text_content().replace("\u2212", "-")

    law.focus()
    law.press("ArrowRight")
    assert told(".tip") == "w = 0.01: F = -0.22"
    for _ in range(2):
        law.press("ArrowLeft")
    assert told(".tip") == "w = -0.01: F = 0.22"
    explorer.page.get_by_label("a law for each block").check()
    explorer.type_into("mu_2", 0.3)
    law.focus()
    law.press("End")
    assert told(".tip") == "w = 0.5: F = -0.22 and -0.3"
    assert told(".sentence") == "In stick from -1 to 1; at w = 0.5: F = -0.22 and -0.3."


def test_a_lost_connection_is_told_and_taken_up_again(explorer):
    explorer.page.evaluate("() => explorer.connection.link.socket.close()")
    status = explorer.page.locator(".connection")
    explorer.page.wait_for_function("() => document.querySelector('.connection').textContent")
    assert "The server does not answer" in status.text_content()
    explorer.page.wait_for_function("() => !document.querySelector('.connection').textContent")
    explorer.type_into("mu", 0.23)
    assert explorer.inked("map") > 8


def test_an_answer_that_arrives_leaves_what_is_being_typed(explorer):
    field = explorer.page.locator(".controls input[name='alpha']:visible")
    before = field.input_value()
    field.fill("1.25")
    again = "() => explorer.store.replace({ ...explorer.state })"
    explorer.page.evaluate(again)
    assert field.input_value() == "1.25"
    field.fill("")
    field.blur()
    explorer.page.evaluate(again)
    assert field.input_value() == before


def test_a_formula_of_ones_own(explorer):
    explorer.show("preset=oscillator")
    error = explorer.page.locator(".controls > .error")
    field = explorer.page.locator("input[name='law']")
    with explorer.asking_only("law"):
        explorer.page.locator("select[aria-label='Friction law']").select_option("formula")
        law = explorer.state["model"]["friction"]
        assert law == {"law": "mu + (1 - mu) * exp(-s / v)", "mu": 0.3, "v": 0.1}
        field.fill("mu + a * (s")
        field.press("Enter")
        error.filter(has_text="'mu + a * (s' ends where ) is expected").wait_for()
        assert field.get_attribute("aria-invalid") == "true"
        law_view = "explorer.views.find(({ id }) => id === 'law').panel.section.dataset"
        explorer.page.wait_for_function(f"() => {law_view}.state === 'failed'")
    field.fill("mu + a * s")
    field.press("Enter")
    assert field.evaluate("(field) => field === document.activeElement")
    explorer.type_into("a", 0.2)
    own = {"law": "mu + a * s", "mu": 0.3, "a": 0.2}
    assert explorer.state["model"]["friction"] == own
    assert error.text_content() == ""
    force = explorer.page.evaluate("() => [...explorer.answers.get('law').parts[0].arrays.force]")
    s = explorer.page.evaluate("() => [...explorer.answers.get('law').parts[0].arrays.s]")
    np.testing.assert_allclose(force, 0.3 + 0.2 * np.array(s), rtol=1e-15)
    explorer.page.wait_for_function('() => decodeURIComponent(location.hash).includes(`"a":0.2`)')
    explorer.page.reload()
    explorer.page.wait_for_selector("html[data-ready]")
    explorer.settle()
    assert explorer.state["model"]["friction"] == own
