"""What the documentation shows works: its Python, its commands, its tutorials."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest
from docs.sources import place_of

import stickslip as ss
from stickslip.cli import main

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
SCRIPTS = sorted([*(DOCS / "tutorials").glob("*.py"), *(DOCS / "gallery").glob("*.py")])
NEEDS_A_GPU = {"gpu.md"}
PAGES = [
    page
    for page in sorted(DOCS.glob("*.md"))
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


@pytest.mark.parametrize("script", SCRIPTS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_a_tutorial_or_picture_runs_and_draws(script, elsewhere):
    runpy.run_path(str(script))
    assert plt.get_fignums()
    assert not list(elsewhere.iterdir())


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_the_python_of_a_page_runs(page, elsewhere):
    ss.write_model(ss.examples.coulomb(), elsewhere / "coulomb.toml")
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(), re.DOTALL)
    exec(compile("\n".join(map(small, blocks)), page.name, "exec"), {})


def small(code):
    """The same sweep on fewer points."""
    return code.replace(", 1000)", ", 4)")


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


def test_tests_that_the_docs_name_exist():
    texts = [*DOCS.rglob("*.md"), *DOCS.rglob("*.py"), *ROOT.glob("*.md")]
    text = "\n".join(path.read_text() for path in texts)
    paths = set(re.findall(r"\btests/[\w/*]*(?:\.py)?", text))
    assert len(paths) > 50
    assert {path for path in paths if not any(ROOT.glob(path))} == set()
    code = {path.name: path.read_text() for path in (ROOT / "tests").rglob("*.py")}
    names = set(re.findall(r"\btest_\w+\b(?:\.py)?", text))
    defined = set(re.findall(r"^ *def (test_\w+)", "\n".join(code.values()), re.MULTILINE))
    assert names - defined - set(code) == set()
