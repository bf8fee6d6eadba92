"""How the program ends: exit codes, where messages go, and never with a traceback."""

import json
import os
import resource
import subprocess
import sys

import pytest

from stickslip import __version__
from stickslip.cli import main, program
from stickslip.cli.process import ComputationError
from stickslip.cli.program import COMMANDS

NAMES = list(COMMANDS)


def stickslip(*arguments, **options):
    return subprocess.run(
        [sys.executable, "-m", "stickslip.cli", *arguments],
        capture_output=True,
        text=True,
        check=False,
        **options,
    )


def test_version(capsys):
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"{__version__}\n"


def test_without_arguments_it_shows_its_commands(capsys):
    assert main([]) == 0
    out = capsys.readouterr().out
    assert all(name in out for name in NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_every_help_shows_its_examples(name, capsys):
    _, examples = COMMANDS[name]
    assert main([name, "--help"]) == 0
    out = capsys.readouterr().out
    for line in examples.splitlines():
        assert line.rstrip("\\").strip() in out
    assert f"stickslip {name}" in examples


@pytest.mark.parametrize(
    ("arguments", "fragments"),
    [
        (["map", "--alhpa", "1"], ["--alhpa", "--alpha"]),
        (["mpa"], ["mpa", "map"]),
        (["map", "--alpha", "much"], ["--alpha", "much"]),
        (["map", "--preset", "columb"], ["columb", "coulomb", "law9"]),
        (["simulate", "--preset", "coulomb", "-d", "0.1"], ["--t-end"]),
        (["reproduce", "five"], ["five"]),
        (["study", "leine1998", "1.5"], ["'1.5' is not a whole number"]),
        (["safety", "--preset", "coulomb", "--attractor", "0.6"], ["--attractor", "not a whole"]),
        (["safety", "--preset", "coulomb", "--within", "9.5"], ["--within", "not a whole number"]),
        (["explore", "--host", ""], ["--host"]),
    ],
)
def test_bad_usage_is_said_on_stderr_with_code_2(arguments, fragments, capsys):
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.startswith("stickslip")
    assert "Traceback" not in captured.err
    for fragment in fragments:
        assert fragment in captured.err


def test_with_json_an_error_is_a_document(capsys):
    assert main(["map", "--alhpa", "1", "--json"]) == 2
    captured = capsys.readouterr()
    assert captured.err == ""
    parts = json.loads(captured.out)
    assert parts["schema"] == 1
    assert parts["command"] == "map"
    assert parts["error"]["type"] == "UnknownOptionError"
    assert "--alpha" in parts["error"]["message"]


@pytest.mark.parametrize(
    ("failure", "code", "fragment"),
    [
        (ValueError("alpha = -1.0: must be >= 0"), 2, "alpha = -1.0"),
        (PermissionError(13, "Permission denied", "out"), 2, "Permission denied"),
        (RuntimeError("a surprise"), 1, "RuntimeError: a surprise"),
        (ComputationError("nothing is proven"), 1, "map: nothing is proven\n"),
        (KeyboardInterrupt(), 130, "interrupted"),
    ],
)
def test_failures_have_codes_and_no_traceback(failure, code, fragment, monkeypatch, capsys):
    def failing():
        raise failure

    monkeypatch.setattr(program, "application", lambda *_: lambda *_, **__: failing())
    monkeypatch.setattr(program, "_options", lambda *_: {})
    assert main(["map"]) == code
    captured = capsys.readouterr()
    assert fragment in captured.err
    assert "Traceback" not in captured.err
    assert main(["map", "-v"]) == code
    assert "Traceback" in capsys.readouterr().err


def test_a_reader_that_leaves_ends_it_quietly():
    command = f"{sys.executable} -m stickslip.cli doctor | true"
    done = subprocess.run(command, shell=True, capture_output=True, text=True, check=False)
    assert done.stderr == ""


def test_completion_is_offered_for_the_usual_shells(tmp_path):
    script = tmp_path / "stickslip.bash"
    home = {"HOME": str(tmp_path), "PATH": ""}  # it adds a line to the shell's start file
    done = stickslip("--install-completion", "--shell", "bash", "--output", str(script), env=home)
    assert done.returncode == 0, done.stderr
    assert "reproduce" in script.read_text()


def test_doctor_reports_as_json():
    done = stickslip("doctor", "--json")
    assert done.returncode == 0, done.stderr
    result = json.loads(done.stdout)["result"]
    found = dict(zip(result["subject"], result["state"], strict=True))
    assert found["stickslip"] == __version__
    assert int(found["threads"]) >= 1
    assert "numba" in found
    assert {"extra sweep", "extra gpu", "kernel cache", "prepared", "gpu"} <= found.keys()


def test_doctor_names_the_cache_folder_in_use(tmp_path):
    done = stickslip("doctor", env={"STICKSLIP_CACHE_DIR": str(tmp_path), "PATH": ""})
    assert done.returncode == 0, done.stderr
    (line,) = (line for line in done.stdout.splitlines() if line.startswith("kernel cache"))
    assert str(tmp_path) in line


@pytest.mark.parametrize("as_json", [False, True])
def test_an_argument_that_is_no_text_is_refused(as_json, capsys):
    assert main(["study", "99", "\udcff", *["--json"] * as_json]) == 2
    captured = capsys.readouterr()
    told = json.loads(captured.out)["error"]["message"] if as_json else captured.err
    assert r"argument 3, '\udcff', is not text" in told
    assert main(["\udcff", *["--json"] * as_json]) == 2
    assert "argument 1, " in "".join(capsys.readouterr())


def test_what_would_steer_a_terminal_is_escaped(capsys):
    assert main(["\x1b[2J"]) == main(["explore", "--preset", "\x1b[2J"]) == 2
    err = capsys.readouterr().err
    assert err.isascii()
    assert "\x1b" not in err


@pytest.mark.parametrize(
    "arguments",
    [
        ["map", "--alpha", "x" * 100_000],
        ["x" * 100_000],
        ["map", "--friction", "x" * 100_000, "--alpha", "1", "--beta", "1", "--V", "1", "-d", "0"],
        ["map", "--preset", "coulomb", "-d", "0.1", "--out", "x" * 100_000],
        ["map", "--model", "x" * 100_000],
        ["explore", "--preset", "x" * 100_000],
        ["study", "x" * 100_000],
    ],
    ids=lambda arguments: " ".join(arguments)[:30],
)
@pytest.mark.parametrize("as_json", [[], ["--json"]])
def test_messages_are_short(arguments, as_json, capsys):
    assert main(arguments + as_json) == 2
    captured = capsys.readouterr()
    assert 0 < len(captured.out + captured.err) < 1500


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="the system has no full device")
@pytest.mark.parametrize(
    "arguments", [["study", "--list"], ["doctor"], ["study", "--list", "--json"]]
)
def test_a_full_standard_output_is_said(arguments):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "stickslip.cli", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.returncode == 2
    assert done.stderr == (
        f"stickslip {arguments[0]}: cannot write to the standard output: No space left on device\n"
    )


@pytest.mark.parametrize(
    ("command", "suffix"),
    [
        ("map --preset coulomb --grid 100", ".csv"),
        ("map --preset coulomb --grid 100", ".svg"),
        ("certify --preset coulomb --orbit -0.0399 --digits 5", ".json"),
    ],
)
def test_a_full_disk_is_said_with_the_file_and_leaves_nothing(command, suffix, tmp_path, capsys):
    out = tmp_path / f"out{suffix}"
    assert main([*command.split(), "--out", str(out)]) == 0  # what it caches is kept
    capsys.readouterr()
    out.unlink()
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, before[1]))
    try:
        code = main([*command.split(), "--out", str(out)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert code == 2
    told = capsys.readouterr().err
    assert told == f"stickslip {command.split()[0]}: cannot use {out}: File too large\n"
    assert list(tmp_path.iterdir()) == []
