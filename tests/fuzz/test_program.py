"""The program, with wrong options and broken files: one line of error, and nothing left."""

from __future__ import annotations

import random
import shutil
from functools import cache
from pathlib import Path
from typing import Any, Final, get_args

import pytest
from tests.fuzz import calls

import stickslip as ss
from stickslip.cli.process import BAD_USAGE, COMPUTATION_FAILED, REFUSED
from stickslip.cli.program import application, run

pytestmark = pytest.mark.slow

COULOMB: Final = {"--preset": ["coulomb"]}
ALONG: Final = {**COULOMB, "--parameter": ["V"], "--range": ["0.0366", "0.0367"]}
PLAN: Final = """\
store = "map.zarr"
observables = [{ name = "attractor", transient = 2, n = 8, max_period = 2 }]

[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366
friction = { law = "coulomb", mu = 0.22 }

[axes]
V = { from = 0.03, to = 0.04, n = 2 }
"""
GOOD: Final[dict[str, dict[str, list[str]]]] = {
    "map": {**COULOMB, "-d": ["0.1"]},
    "orbits": COULOMB,
    "basins": {**COULOMB, "--resolution": ["0.01"]},
    "bifurcations": {**ALONG, "--max-period": ["1"], "--values": ["3"]},
    "diagram": {**ALONG, "--max-period": ["1"], "--values": ["3"]},
    "simulate": {**COULOMB, "-d": ["0.1"], "--t-end": ["5"]},
    "cycles": {**COULOMB, "--n-starts": ["1"]},
    "fit": {
        "RECORDS": ["forces.csv"],
        "--model": ["model.toml"],
        "--parameters": ["mu"],
        "--sigma": ["0.1"],
    },
    "sweep": {"--plan": ["plan.toml"]},
    "plot": {"--store": ["map.zarr"], "--out": ["map.svg"]},
    "certify": {**COULOMB, "--orbit": ["-0.0399"], "--digits": ["5"]},
    "verify": {"CERTIFICATE": ["proof.json"]},
    "reproduce": {"FIGURES": ["4"], "--out": ["out"]},
    "study": {"--name": ["leine1998"], "FIGURES": ["99"], "--out": ["out"]},
    "explore": {"--port": ["0"]},
    "doctor": {},
    "warmup": {},
}
"""Arguments of a good call of each command (of `study` and `explore` of one that ends at once)."""

NUMBERS: Final = ("spam", "", "nan", "inf", "-inf", "1e999", "1j", "0x1", "1,5", "½", "1e-400")
COUNTS: Final = (*NUMBERS, "1.5", "-1", "0", "9" * 40, "--")
# No text with a NUL: the system passes none to a program.
WORDS: Final = ("", "spam", "a b", "ä", "../..", "spam:mu=1", "coulomb:mu=spam", "coulomb:")
PATHS: Final = ("", ".", "missing/file", "/proc/none/file", "a" * 300, "plan.toml/file")


@cache
def options(command: str) -> dict[str, Any]:
    """Type of what each option of a command takes."""
    collection = application()[command].assemble_argument_collection()
    return {arg.names[0]: arg.hint for arg in collection if not arg.children}


def bad_values(hint: Any) -> tuple[str, ...]:
    """Texts that are no good, or doubtful, for an option of that type."""
    kinds = {hint, *get_args(hint), *(k for part in get_args(hint) for k in get_args(part))}
    if bool in kinds:
        return ()
    if int in kinds:
        return COUNTS
    if float in kinds:
        return NUMBERS
    return PATHS if Path in kinds else WORDS


CASES: Final = [
    (command, option, value)
    for command in GOOD
    if command not in ("explore", "doctor", "warmup")
    for option, hint in options(command).items()
    for value in bad_values(hint)
]


def words(command: str, changes: dict[str, list[str]]) -> list[str]:
    """Lay out a call; options that are given by their place come first."""
    given = {**GOOD[command], **changes}
    tokens = [command]
    for option, values in given.items():
        if not option.startswith("-") or (command, option) in PLACED:
            tokens += values
    for option, values in given.items():
        if option.startswith("-") and (command, option) not in PLACED:
            tokens += [option, *values]
    return tokens


PLACED: Final = {("sweep", "--plan"), ("plot", "--store"), ("study", "--name")}


@cache
def _made() -> Path:
    """A folder with a plan, the store that it makes, a model, results and a certificate."""
    folder = calls.folder()
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    assert run(["sweep", str(folder / "plan.toml"), "--quiet", "--threads", "1"]) == 0
    ss.write_model(calls.coulomb(), folder / "model.toml")
    forces = "speed,force\n0.1,0.2\n0.2,0.2\n0.3,0.25\n"
    (folder / "forces.csv").write_text(forces, encoding="utf-8")
    ss.certify_orbits(calls.coulomb(), digits=5).save(folder / "proof.json")
    return folder


@pytest.fixture
def here(tmp_path, monkeypatch):
    shutil.copytree(_made(), tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def told(tokens: list[str], capsys: pytest.CaptureFixture[str], names: tuple[str, ...]) -> None:
    """Run; an error is one line that names the option, without a traceback."""
    capsys.readouterr()
    code = run(tokens)
    out, err = capsys.readouterr()
    where = f"{tokens} ended with {code}: {err}"
    assert "Traceback" not in err, where
    if code == BAD_USAGE:
        lines = err.strip().splitlines()
        assert len(lines) == 1, where
        assert lines[0].startswith("stickslip"), where
        assert any(name in err for name in names), where
        assert not out, where
    else:
        assert code != COMPUTATION_FAILED or "(-v shows where)" not in err, where


def check(case: tuple[str, str, str], here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command, option, value = case
    pair = option in ("--range", "--window")
    before = sorted(here.rglob("*"))
    name = option.lstrip("-").replace("-", "_")
    allowed = (option, name, name.upper(), *ALSO.get(option, ()))
    told(words(command, {option: [value, value] if pair else [value]}), capsys, allowed)
    left = [path for path in sorted(here.rglob("*")) if path not in before]
    assert not [path for path in left if "partial" in path.name], left


ALSO: Final = {
    # Told by the value, or by what it does not fit.
    "--d": ("-d", "d["),
    "--plan": ("plan", "cannot use"),
    "--store": ("store", "cannot use", "no sweep"),
    "--out": ("cannot write", "folder", "cannot use", "out", "figure"),
    "--csv": ("cannot write", "folder", "cannot use"),
    "--model": ("model", "cannot use"),
    "--friction": ("friction", "law", "formula"),
    "--parameter": ("parameter",),
    "--set": ("-p", "parameter"),  # its short name
    "--grid": ("-d",),
    "--at": ("at",),
    "--curve": ("curve", "cannot use"),
    "--x": ("x", "-d"),
    "--v": ("v", "-d"),
    "--n-starts": ("n_starts",),
    "--values": ("values", "n_values"),
    "--samples": ("samples",),
    "--variable": ("variable",),
    "--scheduler": ("scheduler", "client"),
    "--border": ("border", "parameter"),
    "--fold": ("fold", "parameter", "--border"),
    "--flip": ("flip", "parameter", "--border"),
    "--jump": ("jump", "--orbit"),
    "--name": ("study", "figure"),
    "--seed": ("seed", "rng"),
    "FIGURES": ("figure", "--figures"),
    "RECORDS": ("cannot use", "path"),
    "--sigma-v": ("sigma_v",),
    "CERTIFICATE": ("cannot use", "certificate"),
    "--period": ("period", "max_period"),
}


def test_every_command_has_a_good_call():
    assert set(GOOD) == {name for name in application() if not name.startswith("-")}


@pytest.mark.parametrize("case", random.Random(1).sample(CASES, 60), ids=repr)
def test_a_bad_option_is_told(case, here, capsys):
    check(case, here, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES, ids=repr)
def test_every_bad_option_is_told(case, here, capsys):
    check(case, here, capsys)


@pytest.mark.parametrize("command", GOOD)
def test_an_unknown_option_is_told(command, here, capsys):
    told([*words(command, {}), "--spam"], capsys, ("--spam",))


def damaged(content: bytes, rng: random.Random) -> bytes:
    """Cut a file, change a byte, or put one in."""
    place = rng.randrange(max(len(content), 1))
    byte = bytes([rng.randrange(256)])
    return rng.choice(
        [
            content[:place],
            content[:place] + byte + content[place + 1 :],
            content[:place] + byte + content[place:],
            content[:place] + content[place + rng.randrange(20) :],
        ]
    )


FILES: Final = {
    "model.toml": ["simulate", "--model", "model.toml", "-d", "0.1", "--t-end", "1"],
    "plan.toml": ["sweep", "plan.toml", "--status"],
    "proof.json": ["verify", "proof.json"],
}
BROKEN: Final = [
    b"",
    b"\x00" * 64,
    b"[" * 100_000,
    b"{" * 100_000,
    b"\xff\xfe",
    b"null",
    b"[]",
    b"{}",
]


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("content", BROKEN, ids=lambda content: repr(content[:8]))
def test_what_is_no_such_file_is_told(name, content, here, capsys):
    (here / name).write_bytes(content)
    told(FILES[name], capsys, (name,))


def damage(name: str, seeds: range, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = (here / name).read_bytes()
    for seed in seeds:
        (here / name).write_bytes(damaged(whole, random.Random(seed)))
        told(FILES[name], capsys, (name,))


@pytest.mark.parametrize("name", FILES)
def test_a_damaged_file_is_told(name, here, capsys):
    damage(name, range(20), here, capsys)


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES)
def test_many_damaged_files_are_told(name, here, capsys):
    damage(name, range(20, 200), here, capsys)


def result_files(here: Path) -> dict[str, Path]:
    """A result of every kind that is saved, in a file."""
    made = {name: call for name, call in calls.calls().items() if name.endswith(".save")}
    for name, call in made.items():
        call({"path": here / name})
    return {name: here / name for name in made}


def read_damaged(seeds: range, here: Path) -> None:
    """Load damaged results: they come back, or a ValueError names the file."""
    for name, path in result_files(here).items():
        whole = path.read_bytes()
        for seed in seeds:
            path.write_bytes(damaged(whole, random.Random(seed)))
            try:
                ss.load(path)
            except ValueError as error:
                said = str(error)
            else:
                said = path.name
            assert path.name in said, f"{name}, {seed}: {said}"


def test_a_damaged_result_is_told(here):
    read_damaged(range(5), here)


@pytest.mark.slow
def test_many_damaged_results_are_told(here):
    read_damaged(range(5, 200), here)


@pytest.mark.parametrize("command", ["map", "orbits", "simulate", "certify"])
def test_a_place_that_cannot_be_written_is_told(command, here, capsys):
    told(words(command, {"--out": ["/proc/file.csv"]}), capsys, ("/proc/file.csv",))


def test_a_file_that_exists_is_refused(here, capsys):
    (here / "here.csv").write_text("mine")
    assert run(words("map", {"--out": ["here.csv"]})) == REFUSED
    assert (here / "here.csv").read_text() == "mine"
