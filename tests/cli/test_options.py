"""``--model FILE`` in every command that takes a model, through the real program."""

import json
import subprocess
import sys

import numpy as np
import pytest
from tests.mechanics.eventmap.unequal import pair

import stickslip as ss
from stickslip.cli import main
from stickslip.cli.options import ModelOptions
from stickslip.cli.output import Spoken, in_options
from stickslip.mechanics.friction.values import parse_law
from stickslip.mechanics.model.file import write_model

QUESTIONS = {
    "map": "-d 0.1",
    "simulate": "-d 0.1 --t-end 5 --samples 3",
    "orbits": "",
    "cycles": "--n-starts 4",
    "basins": "--resolution 1e-3",
    "diagram": "--parameter mu --range 0.22 0.221 --values 3 --max-period 1",
}


@pytest.fixture
def file(tmp_path, monkeypatch):
    """Write a model file into the working folder."""
    monkeypatch.chdir(tmp_path)

    def writing(model_or_text):
        if isinstance(model_or_text, str):
            (tmp_path / "mine.toml").write_text(model_or_text)
        else:
            write_model(model_or_text, tmp_path / "mine.toml")

    return writing


def answer(capsys, command):
    assert main([*command.split(), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("command", "options"), QUESTIONS.items(), ids=QUESTIONS)
def test_a_file_answers_as_the_preset_of_the_same_numbers(command, options, file, capsys):
    file(ss.examples.coulomb())
    of_file = answer(capsys, f"{command} --model mine.toml {options}")
    of_preset = answer(capsys, f"{command} --preset coulomb {options}")
    assert of_file == of_preset


@pytest.mark.parametrize(("command", "options"), QUESTIONS.items(), ids=QUESTIONS)
def test_options_override_the_file(command, options, file, capsys):
    file(ss.examples.coulomb())
    changes = "--alpha 1.201 --V 0.0365 --friction coulomb:mu=0.221"
    document = answer(capsys, f"{command} --model mine.toml {options} {changes}")
    parameters = {"alpha": 1.201, "beta": 1.3, "V": 0.0365, "mu": 0.221}
    assert document["parameters"].items() >= parameters.items()


def test_two_laws_and_an_option_for_both(file, capsys):
    laws = (ss.Coulomb(mu=0.3), ss.PoppStelter(gamma=2.0))
    file(ss.examples.coulomb().replace(friction=laws))
    document = answer(capsys, "map --model mine.toml -d 0.1")
    model = ss.examples.coulomb().replace(friction=laws)
    assert document["result"]["value"] == [ss.event_map(model)(0.1)]
    document = answer(capsys, "map --model mine.toml -d 0.1 --friction coulomb:mu=0.22")
    assert document["result"]["value"] == [ss.event_map(ss.examples.coulomb())(0.1)]


def test_a_law_as_a_formula(capsys):
    text = "1/(1+a*s),a=3.0"  # the README's law, whose kernels others need too
    numbers = "--alpha 1.2 --beta 1.3 --V 0.1"
    document = answer(capsys, f"map {numbers} --friction {text} -d 0.1")
    law = ss.friction_law("1/(1+a*s)", parameters={"a": 3.0})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    assert document["result"]["value"] == [ss.event_map(model)(0.1)]
    assert document["parameters"]["a"] == 3.0
    assert parse_law(document["parameters"]["friction"][0]) == law


TEXT = "1/(1+a*s)"
NUMBERS = "--alpha 1.2 --beta 1.3 --V 0.1"


@pytest.mark.parametrize(
    "command",
    [
        f"map {NUMBERS} --friction {TEXT} -p a=3 -d 0.1",
        f"map {NUMBERS} --friction {TEXT},a=2 --set a=3.0 -d 0.1",
        f"map --alpha 1.2 -p beta=1.3 -p V=0.1 --friction {TEXT} -p a=3 -d 0.1",
        f"map --preset coulomb -p V=0.1 --friction {TEXT} -p a=3 -d 0.1",
        "map --model mine.toml -p V=0.1 -p a=3 -d 0.1",
    ],
)
def test_numbers_by_name(command, capsys, file):
    law = ss.friction_law(TEXT, parameters={"a": 3.0})
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
    file(model.replace(V=0.2, a=1.0))
    document = answer(capsys, command)
    assert document["result"]["value"] == [ss.event_map(model)(0.1)]
    assert document["parameters"]["friction"] == [f"{TEXT}, a=3.0"]
    assert {name: document["parameters"][name] for name in model.parameters} == model.parameters


def test_a_model_of_a_file_may_have_no_number_of_that_option(file, capsys):
    contacts = [ss.Contact(at=0, friction=ss.Coulomb(mu=0.3), V=0.5)]
    file(ss.Structure([1.0], [1.0], contacts=contacts))
    assert main(["cycles", "--model", "mine.toml", "--V", "0.1"]) == 2
    told = "--V: Structure has no parameter 'V'. Known: mass_1, stiffness_1_1, damping_1_1, "
    assert f"{told}static_1, V_1, mu_1, " in capsys.readouterr().err


def test_laws_of_each_block_take_their_numbers():
    laws, numbers = (TEXT, "-0.1*s+mu"), ("a=3", "mu=0.5", "V=0.1", "mu_2=0.4")
    model = ModelOptions(preset="coulomb", friction=laws, numbers=numbers).model()
    assert model.parameters == {"alpha": 1.2, "beta": 1.3, "V": 0.1, "a_1": 3.0, "mu_2": 0.4}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (f"{NUMBERS} --friction {TEXT}", "needs a value for a: write ', a=...' behind it"),
        (f"{NUMBERS} --friction {TEXT} -p b=3", "needs a value for a"),
        (f"{NUMBERS} --friction {TEXT} -p a=3 -p b=3", "TwoBlock has no parameter 'b'. Known: alp"),
        (
            "--preset coulomb -p friction=3",
            "'friction'. Known: alpha, beta, V, mu, viscous, dam",
        ),
        ("--preset coulomb --mu 0.3", "Unknown option: --mu. Did you mean --out? A number of the"),
        ("--preset coulomb --mu=0.3", "A number of the model is given as -p mu=VALUE."),
        ("--preset coulomb -p units=3", "-p: TwoBlock has no parameter 'units'. Known: alpha"),
        (f"{NUMBERS} --friction {TEXT} -p a", "-p a: NAME=VALUE is needed"),
        (f"{NUMBERS} --friction {TEXT} -p a=x", "-p a=x: NAME=VALUE is needed"),
        (f"{NUMBERS} --friction {TEXT} -p =3", "-p =3: NAME=VALUE is needed"),
        (f"{NUMBERS} --friction {TEXT} -p a=3 -p a=3", "-p a=3: a is given twice"),
        (f"{NUMBERS} --friction {TEXT} -p a=nan", "a must be a finite number"),
        (f"{NUMBERS} -p alpha=2 --friction {TEXT} -p a=3", "--alpha and -p alpha=... are the same"),
        ("-p alpha=2 -p V=0.1 -p a=3", "the model lacks --beta, --friction"),
        (f"{NUMBERS} --friction 1/(1+np.exp(s))", "has '.' at character 8, where ) is expected"),
        (f"{NUMBERS} --friction coulmb", "no friction law 'coulmb'. Known: coulomb, popp-stelter"),
        (f"{NUMBERS} --friction __import__('os').system('true')", "calls '__import__' at charac"),
    ],
)
def test_what_is_wrong_with_a_formula_or_a_number_is_said(options, message, capsys):
    assert main(["map", *options.split(), "-d", "0.1"]) == 2
    told = capsys.readouterr().err
    assert message in told
    assert told.count("\n") == 1


def test_through_the_real_program(file, tmp_path):
    file(ss.examples.coulomb())
    command = "map --model mine.toml -d 0.1 -d 0.2 --out map.csv"
    done = subprocess.run(
        [sys.executable, "-m", "stickslip.cli", *command.split()],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (0, "map.csv\n")
    said = done.stderr.splitlines()
    assert not said or (len(said) == 1 and "compiling kernels" in said[0])  # a cold cache
    values = ss.event_map(ss.examples.coulomb())([0.1, 0.2])
    lines = (tmp_path / "map.csv").read_text().splitlines()
    assert [float(line.split(",")[1]) for line in lines[1:]] == values.tolist()


GOOD = 'kind = "two_block"\nalpha = 1.2\nbeta = 1.3\nV = 0.0366\n[friction]\nlaw = "coulomb"\n'
GOOD += "mu = 0.22\n"
BAD = {
    "not TOML": ("alpha: 1.2", ["mine.toml", "not TOML", "line 1"]),
    "unknown key": (GOOD.replace("alpha", "alhpa"), ["mine.toml", "'alhpa'", "'alpha'"]),
    "unknown law": (GOOD.replace("coulomb", "columb"), ["mine.toml", "[friction]", "'coulomb'"]),
    "unknown kind": (GOOD.replace("two_block", "tow_block"), ["mine.toml", "kind", "'two_block'"]),
    "wrong type": (GOOD.replace("1.2", '"1.2"'), ["mine.toml", "alpha", "number"]),
    "out of range": (GOOD.replace("0.22", "2"), ["mine.toml", "[friction]", "mu", "0 <= mu <= 1"]),
    "NaN": (GOOD.replace("1.3", "nan"), ["mine.toml", "beta", "nan", "> 0"]),
}


@pytest.mark.parametrize(("content", "fragments"), BAD.values(), ids=BAD)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_files_say_what_and_where_and_write_nothing(
    content, fragments, as_json, file, tmp_path, capsys
):
    file(content)
    command = "orbits --model mine.toml --out orbits.csv".split()
    refused(command, fragments, as_json, capsys)
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


@pytest.mark.parametrize(
    ("options", "fragments"),
    [
        ("--model missing.toml", ["missing.toml", "No such file"]),
        ("--model .", ["directory"]),
        ("--model latin.toml", ["latin.toml", "UTF-8"]),
        ("--model mine.toml --preset coulomb", ["--model", "--preset"]),
        ("--model mine.toml --alpha -1", ["alpha = -1", ">= 0"]),
        ("--model mine.toml --friction coulom:mu=0.2", ["coulom", "coulomb"]),
        ("--model", ["--model"]),
    ],
)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_use_of_files(options, fragments, as_json, file, tmp_path, capsys):
    file(ss.examples.coulomb())
    (tmp_path / "latin.toml").write_bytes(b"# caf\xe9\n")
    refused(f"orbits {options}".split(), fragments, as_json, capsys)


def refused(command, fragments, as_json, capsys):
    assert main(command[:1] + ["--json"] * as_json + command[1:]) == 2
    captured = capsys.readouterr()
    if as_json:
        assert captured.err == ""
        message = json.loads(captured.out)["error"]["message"]
    else:
        assert captured.out == ""
        message = captured.err
    assert "Traceback" not in message
    for fragment in fragments:
        assert fragment in message


CHAIN = ss.Chain([1, 1.3, 1.1], 1.2, 0.05, ss.Coulomb(0.22), damping=0.1)


def test_a_chain_is_followed_in_time(file, capsys):
    file(CHAIN)
    document = answer(capsys, "simulate --model mine.toml -d 0.1 -d -0.2 --t-end 9 --samples 2")
    motion = ss.simulate(CHAIN, d=[0.1, -0.2], t_end=9)
    for block, x in enumerate(motion.x(9.0), start=1):
        assert document["result"][f"x_{block}"][-1] == x


def test_orbits_of_a_chain_are_listed_with_a_column_for_each_number(file, capsys):
    file(CHAIN)
    columns = answer(capsys, "orbits --model mine.toml --max-period 2")["result"]
    known = ss.periodic_orbits(CHAIN, 2)
    points = np.concatenate([orbit.points for orbit in known])
    assert len(points)
    assert np.array_equal(np.transpose([columns["d_1"], columns["d_2"]]), points)
    largest = [orbit.multipliers[0] for orbit in known for _ in orbit.points]
    assert columns["multipliers_1"] == [value.real for value in largest]
    assert columns["multipliers_1_imag"] == [value.imag for value in largest]
    main(["orbits", "--model", "mine.toml"])
    assert "(Good-Turing)" in capsys.readouterr().err


def test_a_block_without_a_map_is_told_the_command_that_lists_its_cycles(file, capsys):
    file(ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5)))
    assert main(["orbits", "--model", "mine.toml"]) == 2
    told = capsys.readouterr().err
    assert told.endswith(
        "nothing to map. Take its limit cycles (on the command line: stickslip cycles).\n"
    )


def test_basins_of_a_chain_are_shares_of_starts(file, capsys):
    file(CHAIN)
    columns = answer(capsys, "basins --model mine.toml --samples 64")["result"]
    known = ss.basins(CHAIN, n_samples=64)
    assert columns["share"] == [known.share(k).value for k in columns["attractor"]]


def test_basins_of_a_chain_have_no_resolution(file, capsys):
    file(CHAIN)
    assert main("basins --model mine.toml --resolution 1e-3".split()) == 2
    assert "--samples" in capsys.readouterr().err


def test_orbits_of_a_chain_are_drawn(file, tmp_path):
    file(CHAIN)
    assert main(["orbits", "--model", "mine.toml", "--out", "orbits.png"]) == 0


RANGE = "--parameter V --range 0.051 0.052 --max-period 2"


@pytest.mark.slow
def test_bifurcations_of_a_chain_are_reported(file, capsys):
    file(CHAIN)
    found = answer(capsys, f"bifurcations --model mine.toml {RANGE}")["result"]["bifurcations"]
    (flip,) = ss.bifurcations(CHAIN, "V", (0.051, 0.052), max_period=2)
    assert [(one["kind"], one["value"]) for one in found] == [("flip", flip.value)]
    (before, doubled), (after,) = found[0]["orbits_before"], found[0]["orbits_after"]
    assert (before["period"], doubled["period"], after["period"]) == (2, 4, 2)
    value = flip.orbits_after[0].multipliers[0]
    assert after["multipliers"][0] == [value.real, value.imag]
    assert main(["bifurcations", "--model", "mine.toml", *RANGE.split(), "--out", "report"]) == 0
    page = capsys.readouterr().out
    assert "lists, which may lack some, of orbits" in page
    assert f"multipliers        {flip.multipliers[0].real:.8g}, -1" in page


def test_a_window_is_for_one_number(file, capsys):
    file(CHAIN)
    asked = ["diagram", "--model", "mine.toml", *RANGE.split(), "--window", "0", "1"]
    assert main(asked) == 2
    assert "--window is for maps of one number" in capsys.readouterr().err


ANY_DIMENSION = {"simulate", "cycles", "orbits", "basins", "bifurcations", "diagram"}


@pytest.mark.parametrize("command", sorted(QUESTIONS.keys() - ANY_DIMENSION))
def test_what_asks_about_two_blocks_says_so_of_a_chain(command, file, capsys):
    file(CHAIN)
    assert main([command, "--model", "mine.toml", *QUESTIONS[command].split()]) == 2
    assert "the model is a Chain of 3 blocks" in capsys.readouterr().err


def test_a_structure_is_told_by_its_masses_and_contacts(file, capsys):
    stiffness = [[2.0, 0.5], [0.5, 1.0]]
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=0.5)
    model = ss.Structure([1.0, 1.0], stiffness, contacts=[contact])
    file(model)
    assert main(["map", "--model", "mine.toml", "-d", "0.1"]) == 2
    assert "a Structure of 2 masses with 1 contact, whose map has" in capsys.readouterr().err
    controlled = ss.Structure.from_state_space(
        -np.eye(3), np.eye(3)[:, :1], np.eye(3)[:1], contacts=[contact]
    )
    sizes = [
        each.size
        for each in (ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5)), CHAIN, model, controlled)
    ]
    assert sizes == ["1 block", "3 blocks", "2 masses with 1 contact", "3 states with 1 contact"]


@pytest.mark.parametrize(
    ("command", "told"),
    [
        ("cycles --preset coulomb --n-starts 0", "--n-starts 0 is not allowed"),
        ("basins --preset coulomb --resolution 2", "--resolution 2.0 must lie"),
        ("orbits --preset law9 --engine exact", "Take --engine 'auto' or 'adaptive'."),
        (
            "map --preset coulomb -d 0.9",
            "map: --d 0.9 is outside the global stick locus |d| <= 0.67647058823529405 "
            "(alpha=1.2, beta=1.3, eq. 6a).\n",
        ),
        (
            "diagram --preset coulomb --parameter V --range 0.1 11 --out a.svg --values 5",
            "V = 11.0 of the grid is not allowed: V must be a finite number, 0 < V <= 10. ",
        ),
        (
            "diagram --preset coulomb --parameter V --range 0.03 0.04 --window nan 1 --out a.svg",
            "--window nan is not allowed: --window must be a finite number. Give --window a value",
        ),
        ("simulate --preset coulomb --x 1 --v 1 --t-end 9", "--x (1.0,) is not allowed"),
        ("certify --preset coulomb --entropy -1", "--entropy -1.0 is not allowed"),
        ("certify --model mine.toml --max-period 1", "certify: model = Structure(mass=[1.0, "),
        ("cycles --preset coulomb --seed -1", "--seed -1: a whole number, 0 or more"),
        (
            f"simulate --preset coulomb -d 0.1 --t-end 9 --samples {'1' * 400}",
            "--samples 111111111111... (400 digits): both ends count",
        ),
        ("simulate --preset coulomb -v 0 --t-end 9", "simulate: Unused Tokens"),
        ("map --preset coulomb --friction coulomb:0.2", "is not of the form NAME=VALUE\n"),
        (
            "orbits --model mine.toml",
            "numbers and no bounds within which to search. stickslip cycles",
        ),
    ],
)
def test_messages_name_options_not_arguments_of_python(command, told, file, capsys):
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=0.5)
    file(ss.Structure([1.0, 1.0], [[2.0, 0.5], [0.5, 1.0]], contacts=[contact]))
    assert main(command.split()) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "where it starts (n_starts=), or (free_zero=)",
            "where it starts (--n-starts), or (--free-zero)",
        ),
        ("raise max_evaluations", "raise --max-evaluations"),
        ("take pieces=1, or free_zero=True", "take --pieces 1, or --free-zero"),
        ("Take Coulomb(mu=), or -p mu=0.3", "Take Coulomb(mu=), or -p mu=0.3"),
        (
            "friction = 'a + s, a=0.3' of coulomb:mu=0.2",
            "friction = 'a + s, a=0.3' of coulomb:mu=0.2",
        ),
        (
            "Chain(static=(1.0, 1.2), n_starts=0.7, friction=Coulomb(mu=0.4), ... is no pair",
            "Chain(static=(1.0, 1.2), n_starts=0.7, friction=Coulomb(mu=0.4), ... is no pair",
        ),
        ("load(path, system=...) of mass_1", "load(path, system=...) of mass_1"),
        ("pieces['mu'][1] = 0.0: pieces['mu'][1] must", "--pieces mu 0.0: --pieces mu must"),
        (
            "is off. Known: free_zero, max_evaluations.",
            "is off. Known: free_zero, max_evaluations.",
        ),
        ("d = 1: outside. Take d from model.domain. So", "d = 1: outside. So"),
        ("d = 1: outside. model.contains(d) tells which. So", "d = 1: outside. So"),
        ("Simulate, or take stickslip.return_map of 1.", "Simulate."),
        ("Choose: --at V=1, or dataset.sel(...).", "Choose: --at V=1."),
        ("./model.toml: lacks kind. Why", "./model.toml: lacks kind. Why"),
    ],
)
def test_arguments_are_called_as_options_are(text, told, monkeypatch):
    names = ("n_starts", "free_zero", "max_evaluations", "pieces")
    options = {name: "--" + name.replace("_", "-") for name in names}
    monkeypatch.setattr(Spoken, "options", lambda: options)
    assert in_options(text) == told


def test_keys_of_a_model_file_are_not_called_options(tmp_path, capsys):
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=0.5)
    model = ss.Structure.from_state_space([[-1.0]], [[1.0]], [[1.0]], contacts=[contact])
    ss.write_model(model, path := tmp_path / "model.toml")
    path.write_text(path.read_text().replace("at = 0", "at = 1"))
    assert main(["simulate", "--model", str(path), "--x", "0", "--t-end", "1"]) == 2
    assert capsys.readouterr().err.endswith("contact k has at=k, its column of B and row of C.\n")


UNEQUAL = pair(ss.Coulomb(mu=0.22), 0.2, damped=True)


@pytest.mark.parametrize(
    "question", ["orbits", "basins --resolution 1e-3", "diagram --parameter mass_2 --values 3"]
)
def test_two_blocks_that_are_not_equal_are_asked_alike(question, file, capsys):
    file(UNEQUAL)
    if question.startswith("diagram"):
        question += " --range 2 2.001 --max-period 1"
    command, *options = question.split()
    document = answer(capsys, " ".join([command, "--model mine.toml", *options]))
    assert document["parameters"]["mass_2"] == 2.0


def test_the_map_of_two_blocks_that_are_not_equal(file, capsys):
    file(UNEQUAL)
    document = answer(capsys, "map --model mine.toml -d 0.1")
    assert document["result"]["value"] == [ss.event_map(UNEQUAL)(0.1)]
    document = answer(capsys, "simulate --model mine.toml -d 0.1 --t-end 9 --samples 2")
    assert document["result"]["x_2"][-1] == ss.simulate(UNEQUAL, d=0.1, t_end=9).x(9.0)[1]
    assert main(["certify", "--model", "mine.toml", "--max-period", "1"]) == 2
    assert "two equal blocks" in capsys.readouterr().err


def test_a_report_on_two_blocks_that_are_not_equal(file, tmp_path):
    file(pair(ss.Coulomb(mu=0.22), 0.0366, damped=True))
    asked = "bifurcations --model mine.toml --parameter V --range 0.0341 0.0343 --max-period 1"
    assert main([*asked.split(), "--values", "5", "--out", "told"]) == 0
    assert "border collision" in (tmp_path / "told" / "report.md").read_text()
