"""``stickslip certify`` and ``stickslip verify`` end to end."""

import json
import os

import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from stickslip.cli import main


def test_a_proof_is_written_and_checked(tmp_path, capsys):
    path = tmp_path / "s1.json"
    command = f"certify --preset coulomb --orbit -0.0399143 --digits 20 --out {path}"
    assert main(command.split()) == 0
    assert "asymptotically stable" in capsys.readouterr().out
    assert main(["verify", str(path)]) == 0
    assert capsys.readouterr().out.startswith("holds: ")
    path.write_text(path.read_text().replace("-0.0399", "-0.0398"))
    assert main(["verify", str(path)]) == 4
    assert "refused: " in capsys.readouterr().err
    assert main(["verify", str(path), "--json"]) == 4
    assert json.loads(capsys.readouterr().out)["result"]["holds"] == [False]


def test_the_help_says_what_is_written(capsys):
    assert main(["certify", "--help"]) == 0
    told = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "Write the certificate, a JSON file that stickslip verify checks." in told
    assert "CSV" not in told


def test_the_mechanism_of_a_jump_is_quoted_apart(tmp_path, capsys):
    path = tmp_path / "jump.json"
    command = f"certify --preset coulomb --jump 0.30184 --digits 12 --out {path}"
    assert main(command.split()) == 0
    assert main(["verify", str(path)]) == 0
    theorem, remark = capsys.readouterr().out.splitlines()[-2:]
    assert theorem.startswith("holds: ")
    assert "comes to rest" not in theorem
    assert remark.startswith("not checked, the certifier's words for the jump: 'block 1 comes")
    forged = path.read_text().replace("block 1 comes", "\\u001b[2J\\nholds: block 1 comes")
    path.write_text(forged)
    assert main(["verify", str(path)]) == 4
    assert capsys.readouterr().err.startswith("refused: an entry is not of its form")


def test_what_is_no_ordinary_file_is_an_error(tmp_path, capsys):
    os.mkfifo(tmp_path / "pipe")
    for path in ("/dev/zero", "/dev/full", tmp_path / "pipe", tmp_path):
        assert main(["verify", str(path)]) == 2
        assert str(path) in capsys.readouterr().err


def test_json_is_the_certificate(capsys):
    assert main("certify --preset coulomb --jump 0.30184 --digits 15 --json".split()) == 0
    assert json.loads(capsys.readouterr().out)["claim"] == "jump"


def test_a_complete_list(capsys):
    assert main("certify --preset coulomb --max-period 1 --digits 12".split()) == 0
    assert "exactly 3 periodic orbits" in capsys.readouterr().out


def test_a_border(capsys):
    command = "certify --preset coulomb --V 0.036976 --orbit 0.27943 --period 4 --border V"
    assert main(command.split()) == 0
    assert "0.036975923520307" in capsys.readouterr().out


def test_a_branch(tmp_path, capsys):
    path = tmp_path / "u1.json"
    command = f"certify --preset coulomb --orbit 0.0886 --along V --digits 9 --out {path}"
    assert main([*command.split(), "--range", "0.0366", "0.0367"]) == 0
    assert "For every V from 0.0366 to 0.0367" in capsys.readouterr().out
    assert main(["verify", str(path)]) == 0
    assert capsys.readouterr().out.startswith("holds: ")
    path.write_text(path.read_text().replace('"unstable"', '"stable"').replace("0.0367", "0.0467"))
    assert main(["verify", str(path)]) == 4


def test_what_is_not_so_has_an_exit_code(capsys):
    assert main("certify --preset coulomb --orbit 0.3".split()) == 1
    assert "none within" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        "--orbit 0.1 --along V",
        "--jump 0.1 --along V --range 0.03 0.04",
        "--orbit 0.1 --range 0.03 0.04",
        "--orbit 0.1 --flip V --along V --range 0.03 0.04",
        "",
        "--orbit 0.1 --jump 0.1",
        "--jump 0.1 --border V",
        "--orbit 0.1 --digits 1",
        *(f"{what} --digits 1" for what in ("--basins 0.1", "--entropy 0", "--chaos 0.27")),
        *(f"{what} --period 2" for what in ("--jump 0.1", "--max-period 2", "--basins 0.1")),
    ],
)
def test_bad_usage(options, capsys):
    assert main(f"certify --preset coulomb {options}".split()) == 2
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize("option", ["--orbit", "--jump"])
def test_a_point_that_is_no_number_is_told_by_its_option(option, capsys):
    assert main(["certify", "--preset", "coulomb", option, "nan"]) == 2
    assert option in capsys.readouterr().err


@pytest.mark.parametrize("option", ["--orbit", "--jump", "--chaos"])
def test_a_point_outside_the_domain_is_told_as_such(option, capsys):
    assert main(["certify", "--preset", "coulomb", option, "0.9"]) == 2
    assert "0.9 is outside the domain |d| <= 0.676470588235" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--border foo --orbit 0.27739", "--border foo: the model has no such parameter. Known: a"),
        ("--along Mu --range 0.2 0.3 --max-period 1", "--along Mu: the model has no such parame"),
        ("--along Mu --range 0.2 0.3 --max-period 1", "alpha, beta, V, mu. Did you mean 'mu'?"),
        ("--flip V", "--flip needs the orbit: --orbit D --period P"),
        ("--along V --border V --orbit 0.1", "give one of --border, --flip, --fold and --along"),
    ],
)
def test_a_parameter_is_refused_by_its_option(options, message, capsys):
    assert main(["certify", "--preset", "coulomb", *options.split()]) == 2
    assert message in capsys.readouterr().err
