"""What the documentation shows works: its Python, its commands, its tutorials."""

import ast
import inspect
import json
import re
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from docs import figures
from docs.sources import place_of

import stickslip as ss
from stickslip.cli import main

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
SCRIPTS = sorted([*(DOCS / "tutorials").glob("*.py"), *(DOCS / "gallery").glob("*.py")])
# Many seconds each, of kernels or of questions that tests of the package ask in every run.
LONG = {
    *("proven_basins", "proven_branches", "measured-laws", "measured_friction"),
    *("own_law", "own_map", "reading_a_bifurcation"),
    *("parameter_plane", "bifurcation_curve", "bifurcations", "two_bifurcations"),
    *("api", "from_a_record", "chain_of_blocks", "return_region"),
}
NEEDS_A_GPU = {"gpu.md"}
PAGES = [
    page
    for page in sorted([*DOCS.glob("*.md"), *DOCS.glob("howto/*.md")])
    if "```python" in page.read_text() and page.name not in NEEDS_A_GPU
]
START = (DOCS / "start.md").read_text()


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """An empty folder, and pictures that need no screen."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(plt, "show", lambda: None)
    yield tmp_path
    plt.close("all")


def each(paths):
    return [
        pytest.param(path, marks=[pytest.mark.slow] * (path.stem in LONG), id=path.stem)
        for path in paths
    ]


@pytest.mark.parametrize("script", each(SCRIPTS))
def test_a_tutorial_or_picture_runs_and_draws(script, elsewhere):
    exec(compile(small(script.read_text()), script.name, "exec"), {})
    assert plt.get_fignums()
    assert not list(elsewhere.iterdir())


def test_every_tutorial_and_picture_has_its_place_in_the_order_of_reading():
    order = re.search(r"READING_ORDER = (\(.*?\n\))", (DOCS / "conf.py").read_text(), re.DOTALL)
    places = ast.literal_eval(order[1])
    assert sorted(places) == sorted(script.stem for script in SCRIPTS)


@pytest.mark.parametrize("page", each(PAGES))
def test_the_python_of_a_page_runs(page, elsewhere):
    needed = {"jax.md": "jax", "pytorch.md": "torch"}.get(page.name)
    if needed:
        pytest.importorskip(needed, reason=f"{needed} is not installed")
    ss.write_model(ss.examples.coulomb(), elsewhere / "coulomb.toml")
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    exec(compile("\n".join(map(small, blocks)), page.name, "exec"), {})


def test_the_commands_for_other_languages_write_what_those_can_read(elsewhere, capsys):
    page = (DOCS / "howto" / "matlab-julia.md").read_text()
    commands = re.findall(r"^stickslip (.*)$", page, re.MULTILINE)
    assert len(commands) == 3
    for command in commands:
        assert f'"stickslip {command}"' in page or "simulate" in command
        assert main(shlex.split(command)) == 0, command
        out = capsys.readouterr().out
        if "--json" in command:
            assert json.loads(out)
    for name, columns in (("map.csv", 2), ("motion.csv", 3)):
        assert len((elsewhere / name).read_text().splitlines()[1].split(",")) >= columns


SMALLER = {
    "frames=240": "frames=3",
    ", 1000)": ", 4)",
    "n = 200": "n = 4",
    'plane["V"], 36)': 'plane["V"], 4)',
    'plane["alpha"], 24)': 'plane["alpha"], 3)',
    "n_values=12, n_points=61": "n_values=3, n_points=31",
    "stream, 300, 2300": "stream, 300, 700",
    "certify_basins(model, 0.999)": "certify_basins(model, 0.3)",
}


def small(code):
    """The same sweep on fewer points, film of fewer frames, proof of fewer starts."""
    for large, few in SMALLER.items():
        code = code.replace(large, few)
    return code


@pytest.mark.parametrize("large", SMALLER)
def test_what_is_made_smaller_is_there(large):
    assert any(large in page.read_text() for page in (*SCRIPTS, *PAGES))


def test_the_ten_minutes_end_with_pictures_of_ones_own_system(elsewhere, capsys):
    (model,) = re.findall(r"```toml\n(.*?)```", START, re.DOTALL)
    (elsewhere / "mine.toml").write_text(model)
    commands = re.findall(r"^stickslip (.*)$", START, re.MULTILINE)
    assert len(commands) >= 7
    for command in commands:
        assert main(shlex.split(command)) == 0, command
    assert {"map.png", "motion.png"} <= {path.name for path in elsewhere.iterdir()}
    assert (elsewhere / "report" / "report.md").is_file()
    assert (elsewhere / "report" / "diagram.png").is_file()


THEORY = sorted((DOCS / "theory").glob("*.md"))
SOURCE = re.compile(r"\{source\}`(?:[^`<]*<)?([\w.]+)>?`")


@pytest.mark.parametrize("page", THEORY, ids=lambda path: path.stem)
def test_equations_are_linked_to_what_implements_them(page):
    text = page.read_text()
    for section in re.split(r"^## ", text, flags=re.MULTILINE):
        if "$$" in section:
            assert SOURCE.search(section), section.partition("\n")[0]
    for target in SOURCE.findall(text):
        file, line = place_of(target)
        assert line <= len(file.read_text().splitlines())


CITED = [page for page in sorted([*THEORY, *DOCS.glob("studies/*.md")]) if page.stem != "index"]
ENTRIES = re.findall(r"^\((\w+)\)=\n(.+)$", (DOCS / "bibliography.md").read_text(), re.MULTILINE)
CITATION = re.compile(r"\]\(#([a-z]+\d{4}[a-z]?)\)")


@pytest.mark.parametrize("page", CITED, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_page_cites_the_bibliography(page):
    cited = set(CITATION.findall(page.read_text()))
    assert cited
    assert cited - {key for key, _ in ENTRIES} == set()


def test_every_entry_of_the_bibliography_is_cited_once_at_least_and_in_order():
    keys = [key for key, _ in ENTRIES]
    assert keys == sorted(set(keys))
    texts = "".join(page.read_text() for page in DOCS.rglob("*.md"))
    assert set(keys) - set(CITATION.findall(texts)) == set()


def test_dois_have_the_form_of_dois_and_link_to_themselves():
    text = (DOCS / "bibliography.md").read_text()
    links = re.findall(r"\[doi:([^\]]+)\]\(<https://doi\.org/([^>]+)>\)", text)
    assert len(links) == text.count("doi:") > 20
    for shown, target in links:
        assert shown == target
        assert re.fullmatch(r"10\.\d{4,5}/[\w.:;()/-]+", shown), shown
    assert len(set(links)) == len(links)


def test_every_relative_link_between_pages_leads_to_a_file():
    for page in DOCS.rglob("*.md"):
        if {"_build", "generated"} & set(page.relative_to(DOCS).parts):
            continue
        for target in re.findall(r"\]\(([^)#\s<>:]+\.md)(?:#[^)]*)?\)", page.read_text()):
            assert (page.parent / target).is_file(), f"{page.name}: {target}"


FIGURES = sorted(figures.pictures())


@pytest.mark.parametrize("name", FIGURES)
def test_a_figure_is_drawn_and_shown_on_a_page(name, tmp_path):
    path = figures.draw(name, tmp_path)
    assert path.stat().st_size > 5000
    shown = [
        page for page in DOCS.rglob("*.md") if f"generated/figures/{name}.png" in page.read_text()
    ]
    assert shown


def test_pages_show_no_figure_that_is_not_drawn():
    texts = "".join(page.read_text() for page in DOCS.rglob("*.md"))
    assert set(re.findall(r"generated/figures/(\w+)\.png", texts)) == set(FIGURES)


def test_a_link_to_a_definition_that_is_gone_is_found_out():
    file, line = place_of("mechanics.model.two_block.TwoBlock.from_physical")
    assert "def from_physical" in file.read_text().splitlines()[line - 1]
    for gone in ("mechanics.model.two_block.TwoBlock.gone", "mechanics.gone", "gone"):
        with pytest.raises(LookupError):
            place_of(gone)


EXPLAINED = [
    page
    for folder in ("theory", "studies", "tutorials")
    for page in sorted((DOCS / folder).iterdir())
    if page.suffix in {".md", ".py"} and page.stem != "index"
]


@pytest.mark.parametrize("page", EXPLAINED, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_page_says_how_sure_it_is(page):
    _, found, answer = page.read_text().partition("How sure is this?")
    assert found
    for kind in ("Proved", "Checked", "Fails, or is only evidence"):
        assert f"**{kind}" in answer, kind


@pytest.mark.parametrize("name", ss.__all__)
def test_a_public_name_has_an_example(name):
    thing = getattr(ss, name)
    own = vars(thing).values() if inspect.isclass(thing) else ()
    shown = [inspect.getdoc(part) or "" for part in (thing, *own)]
    assert any(">>>" in text for text in shown)  # which runs: pytest collects them


def test_tests_that_the_docs_name_exist():
    texts = [*DOCS.rglob("*.md"), *DOCS.rglob("*.py"), *ROOT.glob("*.md")]
    text = "\n".join(path.read_text() for path in texts)
    paths = set(re.findall(r"\btests/[\w/*]*(?:\.py|\.csv|\.txt)?", text))
    assert len(paths) > 50
    assert {path for path in paths if not any(ROOT.glob(path))} == set()
    code = {path.name: path.read_text() for path in (ROOT / "tests").rglob("*.py")}
    names = set(re.findall(r"\btest_\w+\b(?:\.py)?", text))
    defined = set(re.findall(r"^ *def (test_\w+)", "\n".join(code.values()), re.MULTILINE))
    assert names - defined - set(code) == set()
