"""README shows what works: its Python runs, its commands end well."""

import re
import shlex
from pathlib import Path

import pytest

from stickslip.cli import main

ROOT = Path(__file__).resolve().parents[2]
README = (ROOT / "README.md").read_text()
PYTHON = "\n".join(re.findall(r"```python\n(.*?)```", README, re.DOTALL))
COMMANDS = re.findall(r"^    stickslip (.*)$", README, re.MULTILINE)


def test_the_python_of_the_readme_runs(capsys):
    exec(compile(PYTHON, "README.md", "exec"), {})
    printed = capsys.readouterr().out.splitlines()
    assert len(printed) == PYTHON.count("print(")
    for line, comment in zip(
        printed, re.findall(r"^print\(.*?\)(?:  # (.*))?$", PYTHON, re.M), strict=True
    ):
        for quoted in re.findall(r'"([^"]+)"', comment):
            assert line == quoted


@pytest.mark.parametrize("command", COMMANDS)
def test_the_commands_of_the_readme_end_well(command, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(command)) == 0
    captured = capsys.readouterr()
    assert captured.out
    assert "rror" not in captured.err


def test_pictures_and_links_of_the_readme_exist():
    targets = re.findall(r"\]\(([^)#]+)\)", README)
    assert targets
    for target in targets:
        assert (ROOT / target).is_file(), target


def test_the_way_to_install_comes_first():
    commands = re.findall(r"^    (\S.*?)(?:  .*)?$", README, re.MULTILINE)
    assert commands[:3] == ["pip install .", "make reproduce", "make test"]
