"""What the documentation shows works: its Python, its commands, its tutorials."""

import re
import runpy
import shlex
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

import stickslip as ss
from stickslip.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.py"))
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


@pytest.mark.parametrize("script", TUTORIALS, ids=lambda path: path.stem)
def test_a_tutorial_runs_and_draws(script, elsewhere):
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
