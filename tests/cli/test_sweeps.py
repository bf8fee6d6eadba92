"""``stickslip sweep`` and ``stickslip plot``: plans, refusals, pictures."""

import json
import os

import numpy as np
import pytest

try:
    import resource
except ImportError:  # Windows
    resource = None

import stickslip as ss
from stickslip.cli import main
from stickslip.mechanics.model.file import write_model
from stickslip.sweeps.identity import law_identity
from stickslip.sweeps.plan import read_plan

pytest.importorskip("zarr")

PLAN = """\
store = "map.zarr"
seed = 3
observables = [
    {name = "attractor", transient = 40, n = 64},
    {name = "lyapunov_exponent", transient = 40, n = 64},
]

[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366
friction = {law = "coulomb", mu = 0.22}

[axes]
V = {from = 0.03, to = 0.05, n = 8}
alpha = [1.1, 1.2, 1.3]

[chunks]
V = 4
alpha = 1
"""


LONG = "9" * 300


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(PLAN)
    return path


def ended(capsys, *tokens):
    code = main(list(map(str, tokens)))
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.mark.skipif(not os.path.exists("/proc/self"), reason="a folder of Linux")
def test_a_place_where_nothing_can_be_written_is_told(plan, capsys):
    code, _, err = ended(capsys, "sweep", plan, "--store", "/proc/map")
    assert code == 2
    assert "cannot write /proc/map: No such file or directory (/proc/.map.lock)" in err


def test_a_store_is_named_as_it_was_given(plan, capsys):
    assert "sweep: --store '" in ended(capsys, "sweep", plan, "--store", plan)[2]
    assert (
        "sweep: --store 'foo" in ended(capsys, "sweep", plan, "--store", "foo://x", "--resume")[2]
    )
    plan.write_text(PLAN.replace("map.zarr", plan.name))
    assert "sweep: store = '" in ended(capsys, "sweep", plan)[2]


def test_a_plan_names_its_store_by_a_key(plan, capsys):
    plan.write_text(plan.read_text().replace('"map.zarr"', '"foo://x"'))
    for more in ([], ["--status"], ["--resume"]):
        code, _, err = ended(capsys, "sweep", plan, *more)
        assert (code, err.count("store")) == (2, 1)
        assert "sweep: store = 'foo://x' cannot be reached" in err


@pytest.mark.parametrize("options", [[], ["--store", ""]])
def test_a_store_without_a_name_is_refused(plan, capsys, options):
    """The folder of the plan is none, nor is the plan's store meant by an empty option."""
    if not options:
        plan.write_text(plan.read_text().replace('"map.zarr"', '""'))
    code, _, err = ended(capsys, "sweep", plan, *options)
    assert code == 2
    assert "store" in err
    assert "'' is neither a path nor an address" in err


def test_a_plan_is_run_beside_its_file(plan, capsys):
    code, out, err = ended(capsys, "sweep", plan)
    assert (code, out) == (0, f"{plan.parent / 'map.zarr'}\n")
    assert "rror" not in err
    found = ss.open_sweep(plan.parent / "map.zarr")
    assert found.kind.shape == (8, 3)
    assert found.attrs["description"]["seed"] == 3
    same = ss.sweep(
        ss.examples.coulomb(),
        {"V": (0.03, 0.05, 8), "alpha": [1.1, 1.2, 1.3]},
        [
            ss.observables.Attractor(transient=40, n=64),
            ss.observables.LyapunovExponent(transient=40, n=64),
        ],
        store=plan.parent / "map.zarr",
        rng=3,
    )
    np.testing.assert_array_equal(same.kind, found.kind)


def test_values_that_are_refused_together_are_told(plan, capsys):
    own = PLAN.replace('"coulomb", mu = 0.22', '"a + b * exp(-s)", a = 0.1, b = 0.5')
    axes = own.index("[axes]")
    plan.write_text(f"{own[:axes]}[axes]\na = [0.1, 0.6]\nb = [0.2, 0.5]\n")
    drawn = ("plot", plan.parent / "map.zarr", "--out", plan.parent / "map.png")
    for command in (("sweep", plan), ("sweep", plan, "--status"), drawn):
        code, _, err = ended(capsys, *command)
        assert code == 0
        assert "stickslip: without values: 1 of 4 grid points, parameters of which" in err
        assert "a = 0.6, b = 0.5: F(0) = 1.1" in err


def test_a_store_that_exists_is_gone_on_with_only_if_asked(plan, capsys):
    assert ended(capsys, "sweep", plan, "--status") == (
        0,
        f"{plan.parent / 'map.zarr'}: not begun\n",
        "",
    )
    assert ended(capsys, "sweep", plan)[0] == 0
    (plan.parent / "map.zarr/checksum/c/0/0").write_bytes(b"torn")
    code, out, err = ended(capsys, "sweep", plan)
    assert (code, out) == (3, "")
    assert "map.zarr exists" in err
    assert "--resume goes on with it" in err
    code, out, _ = ended(capsys, "sweep", plan, "--status", "--json")
    result = json.loads(out)["result"]
    assert (result["done"], result["chunks"]) == ([5], [6])
    assert ended(capsys, "sweep", plan, "--resume", "--threads", "1")[0] == 0
    told = ended(capsys, "sweep", plan, "--status")[1]
    assert told.startswith(f"{plan.parent / 'map.zarr'}: 6 of 6 chunks done; not verified: content")


def test_a_store_of_another_plan_is_refused(plan, capsys):
    assert ended(capsys, "sweep", plan)[0] == 0
    plan.write_text(PLAN.replace("seed = 3", "seed = 4"))
    code, out, err = ended(capsys, "sweep", plan, "--resume")
    assert (code, out) == (3, "")
    assert "holds another sweep: seed = 3 there, 4 here" in err


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("seed = 3", "sead = 3", "sead: unknown key. Known: store,"),
        ("seed = 3", 'seed = "x"', "seed = 'x': a whole number is needed"),
        ("seed = 3", "seed = -1", "seed = -1 is not allowed: seed must be a whole number >= 0"),
        ("seed = 3", "engine = 4", "engine = 4: a table is needed"),
        ("from = 0.03", "from = nan", "axes.V: from = nan is not allowed: from must be"),
        ('store = "map.zarr"', "", "store: missing"),
        ("[axes]", "[axis]", "axis: unknown key"),
        ("to = 0.05", "till = 0.05", "axes.V.till: unknown key. Known: from, to, n, scale"),
        ("n = 8}", "n = 8.5}", "axes.V.n = 8.5: a whole number is needed"),
        ("n = 8}", "n = 0}", "axes.V: n = 0 is not allowed: n"),
        (
            "n = 8}",
            'n = 8, scale = "cubic"}',
            "axes.V: scale = 'cubic' is unknown. Known: linear, log",
        ),
        ("from = 0.03, ", "", "axes.V.from: missing"),
        ("[1.1, 1.2, 1.3]", "7", "axes.alpha = 7: a list of values is needed, or a table {"),
        ("[1.1, 1.2, 1.3]", '[1.1, "x"]', "axes.alpha[1] = 'x': a number is needed"),
        ("alpha = [", "alhpa = [", "axes.alhpa is no parameter that takes a number. Known: alpha"),
        ("mu = 0.22", "mu = 7.0", "[model] [friction] mu = 7.0"),
        (
            '"coulomb"',
            '"mu + exp("',
            "[model] [friction] the formula 'mu + exp(' ends where a numb",
        ),
        ('"coulomb"', '"v * mu + 0*s"', "needs a value for v: write v = ... below it"),
        ('kind = "two_block"', 'kind = "one_block"', "[model] kind = 'one_block' is no kind"),
        ('{name = "attractor", ', '{name = "atractor", ', "observables[0].name = 'atractor' is"),
        ("transient = 40, n = 64},\n]", "trans = 40},\n]", "observables[1].trans: unknown key"),
        ("n = 64},\n]", "n = 1},\n]", "observables[1]: n of lyapunov_exponent = 1"),
        ("V = 4\nalpha = 1", "beta = 4", "chunks: 'beta' is no axis"),
        ("V = 4", "V = 4.5", "chunks.V = 4.5 is not allowed: chunks.V must be a whole number >= 1"),
        ("[1.1, 1.2, 1.3]", "[1.1, 1.0, 1.3]", "axes.alpha: its values must be distinct"),
        ('{name = "attractor", ', '{name = "function"}, {name = "attractor", ', "].function: miss"),
        ("seed = 3", "seed = = 3", "not TOML"),
        ("[chunks]\nV = 4\nalpha = 1", "[engine]\nrtol = 2.0", "engine: rtol = 2.0"),
        ("n = 8}", f"n = {LONG}}}", "to 100000000"),
        (
            "to = 0.05",
            f"to = {LONG}{LONG}",
            "axes.V.to = 999999999999... (600 digits): number out of range",
        ),
        ("to = 0.05", "to = inf", "axes.V: to = inf is not allowed"),
        ("to = 0.05", 'to = 0.05, scale = "lo"', "axes.V: scale = 'lo' is unknown"),
        ("[1.1, 1.2, 1.3]", LONG, "a list of values is needed"),
        ("V = 4", f"V = {LONG}", "that fits into 63 bits"),
        ("seed = 3", f"seed = {LONG}", "that fits into 63 bits"),
        ("seed = 3", f"d = {LONG}{LONG}", "d = 999999999999... (600 digits): number out of range"),
        ("n = 64},\n]", f"n = {LONG}}},\n]", "n of lyapunov_exponent = 9999"),
        ("n = 64},\n]", f"transient = {LONG}}},\n]", "transient"),
        ("n = 64},\n]", f"max_period = {LONG}}},\n]", "max_period of lyapunov_exponent = 9999"),
        ('name = "attractor"', f"name = {LONG}", "observables[0].name = 9999"),
        ("transient = ", "needs = ", "observables[0].needs: unknown key. Known: transient, n, max"),
        ('name = "attractor"', "name = [1]", "observables[0].name = [1]"),
        ("seed = 3", f"seed = {LONG * 20}", "a whole number of more than 4300 digits"),
        ("seed = 3", 'map = "m:f"', "model, map: exactly one of them"),
    ],
)
def test_a_bad_plan_is_told_by_file_and_key(plan, capsys, old, new, words):
    assert old in PLAN
    plan.write_text(PLAN.replace(old, new))
    code, out, err = ended(capsys, "sweep", plan)
    assert (code, out) == (2, "")
    assert f"{plan}: " in err
    assert words in err, err
    assert len(err) < len(str(plan)) + 400
    assert not (plan.parent / "map.zarr").exists()


def test_a_plan_is_told_in_its_own_words(plan, capsys):
    law9 = PLAN.replace('{law = "coulomb", mu = 0.22}', '{law = "popp-stelter", gamma = 3.0}')
    plan.write_text(law9.replace("[chunks]", '[engine]\nengine = "exact"\n[chunks]'))
    code, _, err = ended(capsys, "sweep", plan)
    assert code == 2
    assert err.endswith("Take engine='auto' or 'adaptive'.\n")


def test_models_and_maps_are_named_too(plan, monkeypatch):
    write_model(ss.examples.coulomb(), plan.parent / "model.toml")
    begin, end = PLAN.index("[model]"), PLAN.index("[axes]")
    plan.write_text('model = "model.toml"\n' + PLAN[:begin] + PLAN[end:])
    assert read_plan(plan).arguments["system"] == ss.examples.coulomb()
    plan.write_text('map = "tests.cli.test_sweeps:LOGISTIC"\n' + PLAN[:begin] + PLAN[end:])
    assert read_plan(plan).arguments["system"] is LOGISTIC
    plan.write_text('map = "math:sin"\n' + PLAN[:begin] + PLAN[end:])
    with pytest.raises(
        ValueError, match=r"map = 'math:sin': <built-in function sin>: a sweep takes"
    ):
        read_plan(plan)


def _logistic(x, r):
    return r * x * (1 - x)


LOGISTIC = ss.PiecewiseMap(_logistic, (0, 1), parameters={"r": 3.0})


def test_a_formula_is_swept_over_its_numbers(plan):
    text = "1 / (1 + a * s)"
    model = PLAN.replace('{law = "coulomb", mu = 0.22}', f'{{law = "{text}", a = 3}}')
    plan.write_text(model.replace("alpha = [1.1, 1.2, 1.3]", "a = [2.0, 3.0]"))
    arguments = read_plan(plan).arguments
    law = ss.friction_law(text, parameters={"a": 3.0})
    assert arguments["system"] == ss.examples.coulomb().replace(friction=law)
    assert arguments["axes"]["a"] == [2.0, 3.0]
    same = ss.friction_law(lambda s, a: 1 / (1 + a * s), parameters={"a": 1.0})
    assert law_identity(law) == law_identity(same)
    plan.write_text(PLAN.replace('{law = "coulomb", mu = 0.22}', f'"{text}, a=3"'))
    assert read_plan(plan).arguments["system"] == arguments["system"]


def test_an_interrupted_sweep_says_how_to_go_on(plan, capsys, monkeypatch):
    from stickslip.sweeps import engines

    def interrupted(*_):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(engines, "in_threads", interrupted)
    code, out, err = ended(capsys, "sweep", plan)
    assert (code, out) == (130, "")
    assert "map.zarr; --resume goes on with it" in err


@pytest.mark.skipif(resource is None, reason="no limit of a file's size on this system")
@pytest.mark.parametrize(
    ("room", "file"),
    [
        (10, ".map.zarr.writer"),
        (600, "map.zarr/checksum/zarr.json"),
        (20_000, "map.zarr/orbit/c/0/0/0"),
    ],
)
def test_a_file_for_which_there_is_no_room_is_named(plan, capsys, room, file):
    more = '{name = "orbit_points", transient = 2, n = 2000, count = 2000},\n'
    plan.write_text(PLAN.replace("observables = [\n", "observables = [\n" + more))
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        code, out, err = ended(capsys, "sweep", plan, "--threads", "1")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert (code, out) == (2, "")
    assert f"no space is left for {plan.parent}" in err
    assert file in err
    assert not list(plan.parent.rglob("*.partial"))
    assert ended(capsys, "sweep", plan, "--resume")[0] == 0


def test_a_scheduler_that_is_not_there_is_told(plan, capsys, monkeypatch):
    from stickslip.sweeps import engines

    monkeypatch.setattr(engines, "CONNECT_SECONDS", 0.2)
    code, _, err = ended(capsys, "sweep", plan, "--scheduler", "tcp://127.0.0.1:9")
    assert code == 2
    assert "--scheduler tcp://127.0.0.1:9" in err


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    folder = tmp_path_factory.mktemp("plots")
    orbit = '{name = "orbit_points", transient = 40, n = 64, count = 3}'
    (folder / "plan.toml").write_text(PLAN.replace("},\n]", f"}},\n{orbit}]"))
    assert main(["sweep", str(folder / "plan.toml")]) == 0
    return folder / "map.zarr"


@pytest.mark.parametrize(
    "chosen",
    [
        *([], ["--at", "V=0.03"], ["--variable", "orbit", "--at", "iterate=2"]),
        *(["--variable", name] for name in ("kind", "period", "lyapunov_exponent")),
    ],
)
def test_a_map_is_drawn(store, tmp_path, capsys, chosen):
    out = tmp_path / "map.png"
    assert ended(capsys, "plot", store, "--out", out, *chosen)[:2] == (0, f"{out}\n")
    assert out.read_bytes().startswith(b"\x89PNG")
    assert ended(capsys, "plot", store, "--out", out)[0] == 3
    assert ended(capsys, "plot", store, "--out", out, "--force")[0] == 0


def test_a_value_of_an_axis_that_was_not_computed_is_told(store, tmp_path, capsys):
    (code, _, err) = ended(capsys, "plot", store, "--out", tmp_path / "map.png", "--at", "V=9")
    assert (code, err) == (0, "stickslip: --at V=9.0: the nearest computed is 0.05\n")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--variable", "perriod"], "Did you mean 'period'?"),
        (["--at", "V=0.03", "--at", "alpha=1"], "has the axes none: a picture has one or two"),
        (["--at", "v=0.03"], "--at v=0.03: the axes are"),
        (["--at", "V=x"], "--at V=x: NAME=VALUE is needed"),
        (["--at", "V=nan"], "--at V = nan is not allowed: --at V must be a finite number"),
        (["--variable", "orbit"], "has the axes V, alpha, iterate"),
        (["--at", "iterate=3"], "--at iterate (counted from 0) must be a whole number from 0 to 2"),
    ],
)
def test_what_cannot_be_drawn_is_told(store, tmp_path, capsys, options, words):
    code, out, err = ended(capsys, "plot", store, "--out", tmp_path / "map.png", *options)
    assert (code, out) == (2, "")
    assert words in err
    assert not os.listdir(tmp_path)


def test_a_plan_takes_a_model_without_an_event_map(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(
        """
        store = "x.zarr"
        observables = [{name = "limit_cycles", n_starts = 2}]
        [model]
        kind = "oscillator"
        V = 0.2
        friction = {law = "coulomb", mu = 0.4}
        [axes]
        V = [0.2, 0.3]
        forcing.frequency = {from = 0.3, to = 0.5, n = 3}
        forcing."amplitude" = [0.1, 0.2]
        [chunks]
        forcing.frequency = 2
        """
    )
    arguments = read_plan(path).arguments
    assert arguments["system"] == ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    assert list(arguments["axes"]) == ["V", "forcing.frequency", "forcing.amplitude"]
    assert arguments["chunks"] == {"forcing.frequency": 2}
