"""What a user keeps: the address, pictures, data, the calls in Python."""

import csv
import io
import json

import pytest


def test_the_address_holds_the_whole_state(explorer):
    explorer.show("preset=fig08")
    explorer.click("map", -0.2, 0.1)
    explorer.drag("map", (0.2, 0.5), (0.35, -0.3))
    explorer.page.wait_for_function("() => location.hash.includes('zoom.map')")
    state, picture = explorer.state, explorer.picture("map")[0]
    fragment = explorer.page.evaluate("() => location.hash.slice(1)")
    assert fragment.startswith("kind=two_block&alpha=1.2&beta=1.3&V=0.037&law=coulomb&mu=0.22")
    explorer.open(fragment)
    assert explorer.state == state
    assert explorer.picture("map")[0] == picture  # above it moves what the time shows


def test_a_typed_address_is_followed_though_the_state_is_written_over_it_at_once(explorer):
    explorer.page.evaluate(
        """() => {
            const before = location.href;
            location.hash = "preset=brake";
            history.replaceState(null, "", before);
        }"""
    )
    explorer.page.wait_for_function("() => explorer.state.model.kind !== 'two_block'")
    explorer.page.wait_for_function("() => !location.hash.includes('two_block')")


def test_a_diagram_zoomed_upright_comes_back_with_the_button_that_shows_all(explorer):
    explorer.page.evaluate("() => explorer.zoom('diagram', [0.0366, 0.0372, 0, 1])")
    fit = explorer.panel("diagram").locator(".fit")
    assert fit.is_visible()
    explorer.page.wait_for_function("() => location.hash.includes('diagram=0:1')")
    explorer.open(explorer.page.evaluate("() => location.hash.slice(1)"))
    fit.click()
    assert explorer.state["diagram"]["view"] is None
    assert fit.is_hidden()


@pytest.mark.parametrize("preset", ["oscillator", "chain"])
def test_other_models_come_back_from_their_address(explorer, preset):
    explorer.show(f"preset={preset}")
    state = explorer.state
    explorer.page.wait_for_function("() => location.hash.includes('kind=')")
    explorer.show(explorer.page.evaluate("() => location.hash.slice(1)"))
    assert explorer.state == state


def test_nonsense_in_the_address_gives_the_first_preset(explorer):
    explorer.show("kind=three_block&alpha=<script>&d=[]")
    assert explorer.state["model"]["alpha"] == 1.2
    explorer.show("kind=two_block&alpha=nonsense&d=1e999&power=zzz&along=V:1:0")
    assert explorer.state["model"]["alpha"] == 1.2
    assert explorer.state["power"] == 2


BROKEN = {
    "model=%7B%22kind%22%3A%22chain": "its model has no kind",  # a link that was cut
    'model={"kind":"structure","mass":[1],"contact":[null]}': "contact 1 of its model is no table",
    'model={"kind":"structure","mass":[1],"contact":[{"at":0}]}': "friction law 1 of its model",
    'model={"kind":"structure","contact":[{"friction":{"law":"coulomb"}}]}': "has no mass",
    'model={"kind":"structure","mass":1,"contact":[{"friction":{"law":"coulomb"}}]}': "mass of its",
    'model={"kind":"chain","V":"x","friction":{"law":"coulomb"}}': "V of its model is no number",
    "kind=three_block&alpha=1": "no known model",
    "kind=two_block&law=glue": "no known model and law",
    "kind=two_block&alpha=nonsense": "α = nonsense is no number",
    "preset=nothing": "there is no preset nothing",
    "section=nothing": "section = nothing is no table such as {",
}


@pytest.mark.parametrize("fragment", BROKEN)
def test_a_broken_link_says_what_is_wrong_and_begins_with_the_first_preset(explorer, fragment):
    explorer.page.evaluate("() => explorer.setParameter('V', 0.037)")
    explorer.show(fragment)
    assert BROKEN[fragment] in explorer.page.locator(".controls > .error").text_content()
    assert explorer.page.locator("select[aria-label='Preset']").input_value() == "coulomb"


def test_a_section_is_of_the_preset_that_is_shown(explorer):
    with explorer.asking_only("law"):
        for before, kind in (("", "two_block"), ("preset=brake&", "structure")):
            explorer.show(f'{before}section={{"direction":"forward"}}', "law")
            assert explorer.state["section"] == {"direction": "forward"}
            assert explorer.state["model"]["kind"] == kind


def test_a_plus_in_an_address_that_was_typed_is_a_plus(explorer):
    law = '{"law":"mu+(1-mu)*exp(-s/v)","mu":0.3,"v":0.1}'
    model = f'{{"kind":"two_block","alpha":1.2,"beta":1.3,"V":1e-2,"friction":{law}}}'
    with explorer.asking_only("law"):
        explorer.show(f"model={model}&t_end=1e+2", "law")
    assert explorer.state["model"]["friction"]["law"] == "mu+(1-mu)*exp(-s/v)"
    assert explorer.state["t_end"] == 100


def test_what_was_wrong_with_a_link_is_told_until_something_changes(explorer):
    explorer.open('model={"kind":"structure","mass":[1],"contact":[null]}')
    error = explorer.page.locator(".controls > .error")
    told = "contact 1 of its model is no table. Shown is Coulomb friction (figure 5)."
    assert error.text_content() == f"The address cannot be read: {told}"
    assert explorer.state["model"]["V"] == 0.0366
    explorer.type_into("V", 0.037)
    assert error.is_hidden()


@pytest.mark.parametrize("views", ["law", "table", "law,nothing"])
def test_a_link_to_large_views_that_are_none_shows_all(explorer, views):
    explorer.open(f"preset=coulomb&large={views}")
    explorer.show(f"kind=two_block&large={views}")
    assert explorer.panel("map").is_visible()
    explorer.page.get_by_role("button", name="Present").click()
    assert explorer.state["large"] == ["map", "mechanism"]


def test_the_address_is_copied(explorer):
    explorer.page.locator("button[aria-label='Copy the address of what you see']").click()
    explorer.page.wait_for_function("() => document.querySelector('.toast').textContent")
    copied = explorer.page.evaluate("() => navigator.clipboard.readText()")
    assert copied.startswith(f"{explorer.address}#kind=two_block")


def saved(explorer, panel, kind):
    explorer.panel(panel).locator("button.export").click()
    with explorer.page.expect_download(timeout=120_000) as download:
        explorer.panel(panel).locator(f"[data-format='{kind}']").click()
    return download.value.path().read_bytes()


def wanted(explorer, panel):
    """What is asked of the server for a picture of a panel, and the name that its file gets."""
    explorer.panel(panel).locator("button.export").click()
    with explorer.page.expect_download(timeout=120_000) as download:
        with explorer.page.expect_request("**/export") as request:
            explorer.panel(panel).locator("[data-format='svg']").click()
    return request.value.post_data_json, download.value.suggested_filename


def test_a_picture_shows_what_the_page_shows(explorer):
    explorer.show("preset=fig08")
    asked, name = wanted(explorer, "map")
    assert asked["frame"] == {"xlim": [0.274, 0.284], "ylim": [-0.27, -0.2]}
    assert name == "stickslip-event-map.svg"
    asked, name = wanted(explorer, "power")
    assert asked["request"]["max_period"] == 4
    assert name == "stickslip-map-f4.svg"
    explorer.page.evaluate("() => explorer.zoom('portrait-2', [0, 1, -1, 1])")
    asked, name = wanted(explorer, "portrait-2")
    assert asked["request"]["block"] == 2
    assert asked["frame"] == {"xlim": [0, 1], "ylim": [-1, 1]}
    assert name == "stickslip-block-2.svg"
    explorer.page.evaluate("() => explorer.zoom('diagram', [0.0367, 0.0371, 0, 1])")
    frame = "view.frame"
    assert explorer.view("diagram", frame) == {"ylim": [0, 1]}
    assert explorer.view("basins", frame) == {"xlim": [0.274, 0.284]}


@pytest.mark.parametrize(
    ("panel", "kind", "start"),
    [
        ("map", "svg", b"<?xml"),
        pytest.param("diagram", "png", b"\x89PNG", marks=pytest.mark.slow),
        pytest.param("mechanism", "gif", b"GIF8", marks=pytest.mark.slow),
        ("mechanism", "png", b"\x89PNG"),
        ("law", "png", b"\x89PNG"),
        ("plane", "svg", b"<?xml"),
        ("portrait-2", "png", b"\x89PNG"),
    ],
)
def test_pictures(explorer, panel, kind, start):
    assert saved(explorer, panel, kind).startswith(start)


def test_until_a_file_is_made_the_page_says_so(explorer):
    explorer.page.evaluate(
        """() => {
            window.fetch = () => new Promise(() => {});
            const wait = window.setTimeout;
            window.setTimeout = (then, ms) => wait(then, Math.min(ms ?? 0, 50));
        }"""
    )
    explorer.panel("diagram").locator("button.export").click()
    explorer.panel("diagram").locator("[data-format='svg']").click()
    explorer.page.wait_for_timeout(200)  # other messages would be gone
    assert (
        explorer.page.locator(".toast").text_content()
        == "Making stickslip-bifurcation-diagram.svg …"
    )
    explorer.open()


def test_data_of_the_map(explorer):
    rows = list(csv.reader(io.StringIO(saved(explorer, "map", "csv").decode())))
    assert len(rows) > 600
    assert isinstance(json.loads(saved(explorer, "map", "json")), dict)


@pytest.mark.parametrize("panel", ["map", "power", "basins", "diagram", "mechanism", "law"])
def test_the_calls_in_python_are_python(explorer, panel):
    explorer.panel(panel).locator("button.export").click()
    explorer.panel(panel).locator("[data-format='python']").click()
    explorer.page.wait_for_function(
        "() => document.querySelector('.toast').textContent.startsWith('Copied')"
    )
    code = explorer.page.evaluate("() => navigator.clipboard.readText()")
    assert "import stickslip as ss" in code
    compile(code, panel, "exec")
    explorer.page.evaluate("() => { document.querySelector('.toast').textContent = ''; }")


def test_the_menu_is_walked_with_the_arrows(explorer):
    button = explorer.panel("map").locator("button.export")
    button.focus()
    button.press("Enter")
    menu = explorer.panel("map").locator("[role=menu]")
    assert menu.is_visible()
    explorer.page.keyboard.press("ArrowDown")
    focused = explorer.page.evaluate("() => document.activeElement.dataset.format")
    assert focused == explorer.view("map", "view.app.limits.exports.event_map[1]")
    explorer.page.keyboard.press("Escape")
    assert menu.is_hidden()
