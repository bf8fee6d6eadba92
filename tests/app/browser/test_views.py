"""Each view shows what the library computes, and leads to the others."""

import itertools
import json
import re

import numpy as np
import pytest
from tests.app.talk import CHAIN

import stickslip as ss
from stickslip.app.requests import MOST_BLOCKS

MODEL = ss.examples.coulomb()
QUICK = ["map", "portrait-1", "portrait-2", "plane", "law"]
SLOW = ["power", "basins", "diagram"]
ENDS = (0.0366, 0.0372)  # of the diagram


def spelled(mechanism):
    return mechanism.replace("X_2", "X₂")


@pytest.mark.parametrize("panel", [*QUICK, *SLOW])
def test_every_view_draws(explorer, panel):
    explorer.settle(*({panel} & set(SLOW)))
    assert explorer.inked(panel) > 8  # frame, ticks and labels alone have fewer colours
    assert explorer.panel(panel).get_attribute("data-state") == "current"


def test_the_first_screen(explorer):
    explorer.shoot("first screen")
    sentence = explorer.panel("map").locator(".sentence").text_content()
    assert "S1 and S4 attract, 2 repel" in sentence


def test_the_map_is_that_of_the_library(explorer):
    x, f = explorer.view("map", "[[...view.values.arrays.x], [...view.values.arrays.f]]")
    x, f = np.array(x), np.array(f, dtype=float)
    inner = np.flatnonzero(np.diff(x) > 0)[5::97]  # ends of branches have one-sided values
    assert ss.event_map(MODEL)(x[inner]) == pytest.approx(f[inner], abs=1e-12)


def test_orbits_and_breakpoints_say_what_they_are(explorer):
    (four,) = ss.periodic_orbits(MODEL, period=4)
    tip = explorer.point_at("map", four.points[0], four.points[1])
    assert tip.startswith("S4: stable, period 4")
    assert f"multiplier {four.multiplier:.6f}" in tip
    graze = next(b for b in ss.breakpoints(MODEL) if "block 2 grazes" in b.mechanism)
    assert spelled(graze.mechanism) in explorer.point_at("map", graze.d, 0.6)
    assert "→" in explorer.point_at("map", -0.6, 0.1)


def test_a_click_on_the_map_starts_that_motion_everywhere(explorer):
    explorer.click("map", -0.3, 0.1)
    d = explorer.state["d"]
    assert d == pytest.approx(-0.3, abs=0.005)
    motion = explorer.page.evaluate("() => [...explorer.clock.arrays.x.slice(0, 2)]")
    assert motion[1] - motion[0] == pytest.approx(d, abs=1e-12)
    assert motion == pytest.approx(ss.simulate(MODEL, d=d, t_end=1).x(0.0), abs=1e-12)
    cobweb = explorer.page.evaluate(
        "() => [...explorer.answers.get('cobweb').parts[0].arrays.orbit]"
    )
    assert cobweb[:30] == pytest.approx(ss.event_map(MODEL).iterate(d, 29), abs=1e-9)


def test_a_box_zooms_in_with_new_points_and_a_double_click_out(explorer):
    explorer.drag("map", (0.2, 0.5), (0.35, -0.3))
    low, high, _, _ = explorer.state["windows"]["map"]
    assert (low, high) == pytest.approx((0.2, 0.35), abs=0.005)
    x = explorer.view("map", "[...view.values.arrays.x]")
    assert low <= min(x)
    assert max(x) <= high
    assert len(x) > 600
    x, y = explorer.spot("map", 0.3, 0.1)
    explorer.page.mouse.dblclick(x, y)
    explorer.settle()
    assert explorer.state["windows"]["map"] is None
    assert explorer.state["d"] == 0.1  # a double click is no click


COLOURS = """Object.fromEntries(view.values.data.itineraries.map(
    (name, branch) => [name, view.color(view.values, branch)]))"""


def test_a_branch_keeps_its_colour(explorer):
    before = explorer.view("map", COLOURS)
    names = explorer.view("map", "view.values.data.itineraries")
    assert all(before[one] != before[other] for one, other in itertools.pairwise(names))
    explorer.drag("map", (0.2, 0.5), (0.35, -0.3))
    zoomed = explorer.view("map", COLOURS)
    assert 1 < len(zoomed) < len(before)
    assert zoomed == {name: before[name] for name in zoomed}
    explorer.type_into("V", 0.037)
    moved = explorer.view("map", COLOURS)
    assert {name: moved[name] for name in zoomed} == zoomed


def test_what_is_counted_is_in_the_window(explorer):
    explorer.page.evaluate("() => explorer.zoom('map', [0.2, 0.4, 0.2, 0.5])")
    explorer.settle("map", "basins")
    sentence = explorer.panel("map").locator(".sentence").text_content()
    assert "in this window no orbit attracts, 1 repels; 3 outside." in sentence
    sentence = explorer.panel("basins").locator(".sentence").text_content()
    assert sentence == "Of the starts d shown 100 % end on S4."
    shares = """async () => {
        const { percent } = await import("/static/views/basins.js");
        return [0.994, 0.0004, 0].map(percent);
    }"""
    assert explorer.page.evaluate(shares) == ["99.4 %", "0.04 %", "none"]


def test_what_is_counted_is_in_the_window_asked_for_before_it_is_drawn(explorer):
    counted = explorer.page.evaluate(
        """() => {
            explorer.zoom("map", [0.2, 0.4, 0.2, 0.4]);
            return explorer.views.find(({ id }) => id === "map").sentence();
        }"""
    )
    explorer.settle()
    told = explorer.view("map", "view.sentence()")
    assert counted.split(" Nearest")[0] == told.split(" Nearest")[0]


def test_two_attractors_of_one_period_have_the_names_of_the_map(explorer):
    explorer.settle("basins")
    names = explorer.view(
        "basins",
        """(() => {
            const part = explorer.answers.get("basins").parts.find(({ data }) => data.attractors);
            const { attractors } = part.data;
            const one = (x) => ({ kind: "periodic", period: 1, points: [x] });
            part.data.attractors = [one(0.3), { kind: "chaotic", bands: [] }, one(0.1)];
            const names = view.names();
            part.data.attractors = attractors;
            return names;
        })()""",
    )
    assert names == ["S1b", "chaos", "S1"]


def test_a_map_whose_values_lie_outside_its_view_says_so(explorer):
    outside = "All values lie outside what is shown."
    assert outside not in explorer.view("map", "view.sentence()")
    explorer.page.evaluate("() => explorer.zoom('map', [0.1, 0.15, -0.6, -0.5])")
    explorer.settle("map")
    assert outside in explorer.view("map", "view.sentence()")


def test_a_diagram_whose_points_lie_outside_its_view_says_so(explorer):
    """It said no more than that nothing changes there."""
    outside = "All values lie outside what is shown."
    explorer.settle("diagram")
    low, high = explorer.state["diagram"]["range"]
    (x, *_), (y, *_) = explorer.view("diagram", "view.dots[0].map((some) => [...some])")
    for box, is_empty in (
        ([low, high, -1, 1], False),
        ([low, high, 5, 6], True),
        ([x - 1e-9, x + 1e-9, y - 1e-9, y + 1e-9], False),
    ):
        told = explorer.view(
            "diagram",
            f"(view.plot.view = {box}, view.sentence())",
        )
        assert (outside in told) == is_empty


def test_basins_of_a_narrow_window_are_drawn_at_once(explorer):
    """Bands were hatched as far as they reach: a zoom to 1e-9 stopped the page for minutes."""
    explorer.settle("basins")
    explorer.page.evaluate(
        """() => {
            window.lines = 0;
            const { lineTo } = CanvasRenderingContext2D.prototype;
            CanvasRenderingContext2D.prototype.lineTo = function (...at) {
                window.lines += 1;
                lineTo.apply(this, at);
            };
            const view = explorer.views.find(({ id }) => id === "basins");
            view.plot.view = view.plot.shown = [-0.01, -0.009999, 0, 1];
            view.paint();
            CanvasRenderingContext2D.prototype.lineTo = lineTo;
        }"""
    )
    assert 20 < explorer.page.evaluate("() => lines") < 200


def test_shares_of_all_starts_are_those_of_the_answer(explorer):
    """Of older values those were told that lie in the present domain, as if they were all."""
    explorer.settle("basins")
    sentence = explorer.panel("basins").locator(".sentence")
    told = sentence.text_content()
    assert told.startswith("Of all starts")
    with explorer.asking_only("map"):
        explorer.page.evaluate("() => explorer.setParameter('alpha', 3)")
        explorer.settle("map")
        assert sentence.text_content() == told
    with explorer.asking_only("locus"):
        explorer.page.evaluate("() => explorer.setParameter('alpha', 0.5)")
        explorer.settle("locus")
        explorer.page.evaluate(
            "() => explorer.store.update({ windows: { map: [0.9, 1, 0.9, 1] } }, '')"
        )
        assert sentence.text_content() == ""


def test_the_axis_of_basins_is_the_map_s_also_before_they_are_known(explorer):
    """It went from -1 to 1 below any map, for good on a page that computes no basins."""
    with explorer.asking_only("map"):
        explorer.go("preset=law9-map")
        explorer.settle("map")
        assert explorer.view("basins", "view.part") is None
        ends = [explorer.view(name, "view.plot.view.slice(0, 2)") for name in ("map", "basins")]
    assert ends[0] == ends[1]


def test_a_zoom_of_the_basins_is_that_of_the_map(explorer):
    explorer.drag("basins", (0.2, 0.5), (0.35, 0.5))
    assert explorer.state["windows"]["map"][:2] == pytest.approx([0.2, 0.35], abs=0.005)
    fit = explorer.panel("basins").locator(".fit")
    fit.click()
    assert explorer.state["windows"]["map"] is None
    assert fit.is_hidden()


def test_starts_that_end_nowhere_have_a_name(explorer):
    explorer.page.evaluate(
        """() => {
            const { arrays } = explorer.answers.get("basins").parts.find((p) => p.arrays.label);
            arrays.label[0] = -1;
            arrays.label[1] = -2;
            explorer.views.forEach((view) => view.refresh());
        }"""
    )
    sentence = explorer.panel("basins").locator(".sentence").text_content()
    assert "never stick together again and" in sentence
    assert sentence.endswith("are not proved.")
    shares = [float(x) for x in re.findall(r"([\d.]+) %", sentence)]
    assert sum(shares) == pytest.approx(100, rel=1e-3)
    explorer.open()  # what was forged is forgotten


def test_orbits_through_jumps_are_curves(explorer, collision):
    """As many as the library lists; the one that meets S4 ends where it does."""
    explorer.settle("diagram")
    strands = explorer.view("diagram", "view.throughJumps")
    at = [ss.periodic_orbits(MODEL.replace(V=V), 4, infinitely_unstable=True) for V in ENDS]
    first, last = [
        sorted(d for orbit in found if orbit.jump is not None for d in orbit.points) for found in at
    ]
    begun = sorted(s["ys"][0] for s in strands if s["xs"][0] == ENDS[0])
    ended = sorted(s["ys"][-1] for s in strands if s["xs"][-1] == ENDS[1])
    assert begun == pytest.approx(first, rel=1e-9)
    assert ended == pytest.approx(last, rel=1e-9)
    met = sorted(s["ys"][-1] for s in strands if s["xs"][-1] != ENDS[1])
    assert met == pytest.approx(sorted(collision.points), rel=1e-9)
    assert all(np.all(np.diff(s["xs"]) > 0) for s in strands)


def test_a_large_diagram_is_linked(explorer):
    """More points than a call takes arguments."""
    counted = explorer.page.evaluate(
        """async () => {
            const { strands } = await import("/static/strands.js");
            const of = (f) => Float64Array.from({ length: 200_000 }, (_, k) => f(k));
            const rows = { value: of((k) => k >> 1), d: of((k) => k % 2), period: of(() => 1) };
            return strands(rows, []).map(({ xs }) => xs.length);
        }"""
    )
    assert counted == [100_000, 100_000]


@pytest.mark.parametrize("ends", [(-4, 4), (0.9, 2.9), (-1, 1e-3)])
def test_every_axis_has_two_ticks(explorer, ends):
    """However narrow it is: one tells no scale."""
    ticks = "async ([low, high]) => (await import('/static/numbers.js')).ticks(low, high, 2).values"
    assert len(explorer.page.evaluate(ticks, ends)) >= 2


def test_bands_have_no_gaps(explorer):
    explorer.settle("diagram")
    assert explorer.view("diagram", "view.column") > 1
    assert (
        explorer.view(
            "diagram",
            """(() => {
            const { plot } = view;
            const [[values, d]] = view.dots;
            const last = Math.max(...values);
            const low = Math.min(...[...d].filter((_, k) => values[k] === last));
            const [left, right, y] = [plot.x(0.03701), plot.right - 4, plot.y(low) - 1];
            const { data } = plot.base
                .getContext("2d").getImageData(left, y, Math.round(right - left), 1);
            let blank = 0;
            for (let k = 0; k < data.length; k += 4) if (data[k + 3] === 0) blank += 1;
            return blank;
        })()""",
        )
        == 0
    )


def test_the_wheel_zooms_about_the_pointer(explorer):
    explorer.page.mouse.move(*explorer.spot("map", 0.3, 0.1))
    for _ in range(8):
        explorer.page.mouse.wheel(0, -120)
    explorer.settle()
    low, high, bottom, top = explorer.state["windows"]["map"]
    assert high - low < 0.4
    assert low < 0.3 < high
    assert bottom < 0.1 < top
    assert "d_{n+2}" == explorer.view("power", "view.plot.options.ylabel")


def test_the_power_of_the_map(explorer):
    explorer.page.locator("main").click(position={"x": 2, "y": 2})
    explorer.page.keyboard.press("4")
    explorer.settle("power")
    assert explorer.state["power"] == 4
    x, f = explorer.view("power", "[[...view.values.arrays.x], [...view.values.arrays.f]]")
    x, f = np.array(x), np.array(f, dtype=float)
    inner = np.flatnonzero(np.diff(x) > 0)[5::97]
    expected = ss.event_map(MODEL).iterate(x[inner], 4)[:, -1]
    assert expected == pytest.approx(f[inner], abs=1e-9, nan_ok=True)
    (four,) = ss.periodic_orbits(MODEL, period=4)
    assert "S4" in explorer.point_at("power", four.points[0], four.points[0])


def test_bifurcations_are_located_and_explained(explorer, collision):
    explorer.settle("diagram")
    tip = explorer.point_at("diagram", collision.value, collision.points[0])
    assert tip.startswith("BC: border collision, period 4 at 0.03697592")
    assert spelled(collision.mechanism) in tip


def test_the_line_in_the_diagram_is_the_parameter(explorer):
    before = explorer.picture("map")
    explorer.drag("diagram", (0.0366, 0.1), (0.037, 0.1))
    assert explorer.state["model"]["V"] == pytest.approx(0.037, abs=2e-6)
    assert explorer.picture("map") != before
    asked = explorer.page.evaluate("() => explorer.answers.get('map').question.request.model.V")
    assert asked == explorer.state["model"]["V"]


def test_a_click_on_the_diagram_goes_there(explorer):
    explorer.click("diagram", 0.0369, -0.1)
    assert explorer.state["model"]["V"] == pytest.approx(0.0369, abs=2e-6)
    assert explorer.state["d"] == pytest.approx(-0.1, abs=0.01)


def test_a_click_on_the_diagram_starts_in_the_domain(explorer):
    explorer.page.evaluate("() => explorer.zoom('diagram', [0.0366, 0.0372, -3, 3])")
    explorer.type_into("alpha", 1.25)  # the end of the domain, 2.3 / 3.5, is rounded upwards
    explorer.click("diagram", 0.0369, 2.5)
    assert explorer.state["d"] == MODEL.replace(alpha=1.25).domain[1]
    explorer.settle("cobweb", "motion")
    assert explorer.page.locator(".controls > .error").text_content() == ""


def test_a_zoom_of_the_diagram_recomputes_it(explorer):
    explorer.drag("diagram", (0.03690, 0.5), (0.03705, 0.4))
    assert explorer.state["diagram"]["range"] == pytest.approx([0.0369, 0.03705], abs=3e-6)
    explorer.page.wait_for_function(
        "() => explorer.answers.get('diagram').question.request.range[0] > 0.03685"
        " && explorer.answers.get('diagram').parts.some(({ arrays }) => arrays.d?.length)"
    )
    dots = explorer.view("diagram", "view.dots.flatMap(([values]) => [...values])")
    assert min(dots) >= explorer.state["diagram"]["range"][0] - 1e-12
    explorer.panel("diagram").locator(".fit").click()
    explorer.settle("diagram")
    assert explorer.state["diagram"]["range"] == [0.0366, 0.0372]


def test_basins_are_those_of_the_library_and_start_motions(explorer):
    explorer.settle("basins")
    basins = ss.basins(ss.event_map(MODEL))
    edges = explorer.view("basins", "[...view.part.arrays.edges]")
    assert edges == pytest.approx(basins.edges, abs=1e-5)
    assert explorer.point_at("basins", 0.0, 0.5).startswith("d = ")
    assert "S1" in explorer.point_at("basins", -0.04, 0.5)
    explorer.click("basins", 0.0, 0.5)
    assert explorer.state["d"] == pytest.approx(0.0, abs=0.005)


def test_the_mechanism_moves_and_tells_stick_from_slip(explorer):
    seek = """t => {
        const { clock } = explorer;
        clock.seek(t);
        return clock.arrays.mode[2 * clock.index()];
    }"""
    riding = explorer.page.evaluate(seek, 30)
    first = explorer.settle().picture("mechanism")
    slip = explorer.page.evaluate(
        """() => {
            const { t, mode } = explorer.clock.arrays;
            return t[mode.findIndex((m, k) => k % 2 === 0 && m !== 0) / 2];
        }"""
    )
    slipping = explorer.page.evaluate(seek, slip + 0.2)
    assert riding == 0
    assert slipping != 0
    assert explorer.settle().picture("mechanism") != first
    assert explorer.page.locator("output.time").text_content() != "0.0"


def test_a_click_on_the_time_goes_there(explorer):
    host = explorer.panel("mechanism").locator(".timeline .plot-over").bounding_box()
    explorer.page.mouse.click(host["x"] + host["width"] / 2, host["y"] + 20)
    explorer.page.wait_for_timeout(50)
    assert explorer.page.evaluate("() => explorer.clock.t") == pytest.approx(60, abs=3)


def test_portraits_and_plane_show_the_motion(explorer):
    explorer.page.evaluate("() => explorer.clock.seek(30)")
    for panel in ("portrait-1", "portrait-2", "plane"):
        explorer.page.mouse.move(*explorer.spot(panel, 0.0, 0.0))
        assert explorer.panel(panel).locator(".tip").text_content().startswith("X")
    corners = explorer.view("plane", "view.locus.corners")
    assert corners[0][1] - corners[0][0] == pytest.approx(MODEL.domain[0])


def test_every_block_of_the_longest_chain_has_its_portrait(explorer):
    static = [1.0 + 0.01 * k for k in range(MOST_BLOCKS)]
    with explorer.asking_only("motion"):
        explorer.show("model=" + json.dumps({**CHAIN, "static": static}), "motion")
        assert explorer.page.locator(".panel-portrait:visible").count() == MOST_BLOCKS
        assert explorer.inked(f"portrait-{MOST_BLOCKS}") > 8


def test_the_friction_law_follows_its_parameter(explorer):
    before = explorer.picture("law")
    explorer.type_into("mu", 0.5)
    assert explorer.picture("law") != before
    force = explorer.page.evaluate("() => explorer.answers.get('law').parts[0].arrays.force[9]")
    assert force == pytest.approx(0.5)


@pytest.mark.parametrize("kind", ["oscillator", "chain"])
def test_models_without_a_map_of_the_line(explorer, kind):
    explorer.show(f"preset={kind}")
    explorer.shoot(kind)
    explorer.settle("cycle")
    blocks = explorer.page.locator(".panel-portrait:visible").count()
    assert blocks == {"oscillator": 1, "chain": 3}[kind]
    assert explorer.panel("map").is_hidden()
    assert explorer.inked("portrait-1") > 8
    rows = explorer.panel("cycle").locator("th").all_text_contents()
    assert rows[:2] == ["period", "stability"] or rows[0] == "cycle"


def test_a_map_without_a_value_is_told_in_every_panel(explorer):
    """Both blocks slip for ever: no branch, no attractor, and no fault of the program."""
    explorer.type_into("damping", 5)
    explorer.settle("map", "basins")
    assert explorer.state["model"]["damping"] == 5
    assert explorer.panel("map").locator(".sentence").text_content().startswith("No value")
    assert explorer.panel("basins").locator(".sentence").text_content().startswith("No attractor")
    explorer.shoot("no value anywhere")


def test_a_damping_beyond_the_explorer_is_told_at_its_control(explorer):
    field = explorer.page.locator(".controls input[name='damping']:visible")
    field.fill("50")
    field.press("Enter")
    told = explorer.page.get_by_text("0 ≤ c ≤ 10").first
    told.wait_for(timeout=20_000)


LAW = ss.Coulomb(mu=0.59)
TWO_ENDS = {
    "kind": "chain",
    "static": [0.753, 1.374, 1.078],
    "alpha": 1.616,
    "V": 0.12,
    "friction": {"law": "coulomb", "mu": 0.59},
}


def test_basins_of_three_blocks_are_a_plane(explorer):
    """Two fixed points attract: a colour each, and the tip names the one at a point."""
    explorer.show("preset=chain")
    explorer.page.evaluate("model => explorer.setModel(model)", TWO_ENDS)
    explorer.settle("basins")
    explorer.panel("section").scroll_into_view_if_needed()
    explorer.shoot("basins of a chain")
    assert explorer.panel("section").get_attribute("data-state") == "current"
    assert explorer.inked("section") > 8
    sentence = explorer.panel("section").locator(".sentence").text_content()
    assert sentence.startswith("Of the starts 74")
    assert "no proof" in sentence
    found = ss.attractors(ss.Chain(static=(0.753, 1.374, 1.078), alpha=1.616, V=0.12, friction=LAW))
    for who, each in zip(["S1a", "S1b"], found, strict=True):
        assert explorer.point_at("section", *each.points[0]).endswith(who)
    corner = explorer.view("section", "[0.99 * view.plot.view[1], 0.99 * view.plot.view[3]]")
    assert "no global stick" in explorer.point_at("section", *corner)
    assert explorer.panel("basins").is_hidden()


def test_a_power_shows_no_orbits_that_its_map_does_not_list(explorer):
    """Of no periods the map tells no orbits at all, so that nothing took those of before away."""
    explorer.settle("power", "map")
    power = explorer.panel("power").locator(".sentence")
    assert "attract" in power.text_content()
    explorer.type_into("max_period", 0).settle("power", "map")
    assert "attract" not in power.text_content()
    explorer.type_into("power", 1).settle("power")
    assert power.text_content().startswith("Repeating after 1 stick")
    assert "sticks" not in power.text_content()
