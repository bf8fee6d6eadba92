"""Model files: what is written is read back exactly, and each mistake is named with its place."""

import os
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip as ss
from stickslip.mechanics.friction.values import parse_law
from stickslip.mechanics.model.file import model_text, read_model, write_model

COULOMB = """\
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366

[friction]
law = "coulomb"
mu = 0.22
"""
PHYSICAL = """\
kind = "two_block"

[physical]
m = 2.0
k = 8
k12 = 9.6
fs1 = 4
fs2 = 5.2
v_dr = 0.0366

[friction]
law = "popp-stelter"
gamma = 3
"""
FORMULA = (
    COULOMB.partition("[friction]")[0]
    + """\
[friction]
law = "mu + (1 - mu) * exp(-s / v)"
mu = 0.2
v = 0.5
"""
)
TABULATED = COULOMB.replace("coulomb", "tabulated").replace("mu = 0.22\n", "")
CHAIN = COULOMB.replace("two_block", "chain")
OSCILLATOR = 'kind = "oscillator"\nV = 0.2\n[friction]\nlaw = "coulomb"\nmu = 0.3\n'
PAIR = COULOMB.replace("[friction]", "[[friction]]") + '[[friction]]\nlaw = "stribeck"\n'
PAIR += "mu = 0.1\nspeed = 0.5\nexponent = 2\n"


@pytest.fixture
def read(tmp_path):
    def reading(content):
        path = tmp_path / "model.toml"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_model(path)

    return reading


def test_formulas(read, tmp_path):
    law = ss.friction_law("mu + (1 - mu) * exp(-s / v)", parameters={"mu": 0.2, "v": 0.5})
    model = ss.examples.coulomb().replace(friction=law)
    assert read(FORMULA) == model
    head = COULOMB.partition("[friction]")[0]
    text = "mu + (1 - mu) * exp(-s / v), mu = 0.2, v = 0.5"
    assert read(f'{head}friction = "{text}"\n') == model
    assert read(f'{head}friction = "coulomb:mu=0.22"\n') == ss.examples.coulomb()
    other = ss.friction_law("1 / (1 +\n s)", forward="exp(-s)")
    assert parse_law(str(law)) == law
    assert parse_law(str(other)) == other
    for one in (model, model.replace(friction=other), model.replace(friction=(law, other))):
        write_model(one, tmp_path / "written.toml")
        assert read_model(tmp_path / "written.toml") == one
        assert one.parameters == read_model(tmp_path / "written.toml").parameters


def test_the_papers_system(read):
    assert read(COULOMB) == ss.examples.coulomb()
    assert read(COULOMB.replace("V = 0.0366", "V = 1")).V == 1.0


def test_a_law_for_each_block(read):
    laws = (ss.Coulomb(mu=0.22), ss.Stribeck(mu=0.1, speed=0.5, exponent=2))
    assert read(PAIR) == ss.examples.coulomb().replace(friction=laws)


def test_physical_quantities(read):
    law = ss.PoppStelter(gamma=3.0)
    expected = ss.TwoBlock.from_physical(
        m=2.0, k=8.0, k12=9.6, fs1=4.0, fs2=5.2, v_dr=0.0366, friction=law
    )
    assert read(PHYSICAL) == expected
    assert read(PHYSICAL).units == ss.Units(m=2.0, k=8.0, fs1=4.0)


def test_files_of_other_systems_editors(read):
    windows = b"\xef\xbb\xbf" + COULOMB.replace("\n", "\r\n").encode()
    assert read(windows) == ss.examples.coulomb()


def test_the_documentation_shows_files_that_work(read):
    page = Path(__file__).parents[3].joinpath("docs", "model-files.md").read_text(encoding="utf-8")
    blocks = re.findall(r"^( *)```toml\n(.*?)^ *```", page, flags=re.MULTILINE | re.DOTALL)
    files = [re.sub(f"^{indent}", "", text, flags=re.MULTILINE) for indent, text in blocks]
    whole, chain, full, one, line, laws, physical, formula_table = files
    assert read(chain) == ss.Chain([1, 1.3, 1.1], 1.2, 0.0366, ss.Coulomb(0.22), damping=0.01)
    assert read(full).forcing == ss.Harmonic((0.0, 0.2), 1.3, phase=0.5)
    assert read(one) == ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3.0))
    assert read(whole) == ss.examples.coulomb()
    for text in (line, formula_table):
        formula = read(whole.partition("[friction]")[0] + text).friction
        assert formula.parameters == {"mu": 0.2, "v": 0.5}
    pair = read(whole.partition("[friction]")[0] + laws)
    assert pair.friction == (ss.Coulomb(mu=0.22), ss.PoppStelter(gamma=3.0))
    assert read(physical).units == ss.Units(m=2.0, k=8.0, fs1=4.0)


# --- the way there and back -------------------------------------------------------------------

positive = st.floats(min_value=1e-100, max_value=1e100)
share = st.floats(min_value=0.0, max_value=1.0)
not_negative = st.floats(min_value=0.0, max_value=1e100)
laws = st.one_of(
    st.builds(ss.Coulomb, mu=share, viscous=not_negative),
    st.builds(ss.PoppStelter, gamma=not_negative, delta=share, eta=not_negative),
    st.builds(ss.Stribeck, mu=share, speed=positive, exponent=st.sampled_from([1, 2])),
    st.lists(share, min_size=2, max_size=6).map(
        lambda force: ss.TabulatedFriction(
            np.cumsum([0.0, *force[1:]]) + np.arange(len(force)), force
        )
    ),
)
two_blocks = st.builds(
    ss.TwoBlock,
    alpha=not_negative,
    beta=positive,
    V=positive,
    friction=st.one_of(laws, st.tuples(laws, laws)),
    damping=st.sampled_from([0.0, 0.1]),
    units=st.one_of(st.none(), st.builds(ss.Units, m=positive, k=positive, fs1=positive)),
)
angle = st.floats(-10, 10)
forcings = st.one_of(
    st.none(),
    st.builds(ss.Harmonic, amplitude=angle, frequency=positive, phase=angle),
    st.builds(ss.Harmonic, amplitude=st.lists(angle, min_size=3, max_size=3), frequency=positive),
)
chains = st.builds(
    ss.Chain,
    static=st.lists(positive, min_size=3, max_size=3),
    alpha=not_negative,
    V=positive,
    friction=st.one_of(laws, st.lists(laws, min_size=3, max_size=3)),
    support=positive,
    mass=positive,
    damping=not_negative,
    ends=st.sampled_from(["free", "fixed", "periodic"]),
    forcing=forcings,
)
oscillators = st.builds(ss.Oscillator, V=positive, friction=laws, damping=not_negative)
K = [[2.3, -1.2, 0.1], [-1.2, 3.5, -1.0], [0.1, -1.0, 2.1]]
blocks = st.builds(
    ss.Blocks,
    mass=st.lists(positive, min_size=3, max_size=3),
    stiffness=st.just(K),
    damping=st.sampled_from([None, (0.1 * np.array(K)).tolist()]),
    static=st.lists(positive, min_size=3, max_size=3),
    friction=st.one_of(laws, st.lists(laws, min_size=3, max_size=3)),
    V=positive,
    forcing=forcings,
)
models = st.one_of(two_blocks, chains, oscillators, blocks)


@given(model=models)
def test_a_written_model_is_read_back_exactly(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("models") / "model.toml"
    write_model(model, path)
    assert read_model(path) == model


@pytest.mark.parametrize("content", [COULOMB, PAIR, PHYSICAL])
def test_a_read_model_is_written_back_exactly(read, content):
    assert read(model_text(read(content))) == read(content)


def test_writing_replaces_and_leaves_nothing_else(tmp_path):
    path = tmp_path / "model.toml"
    write_model(ss.examples.law9(), path)
    write_model(ss.examples.coulomb(), str(path))
    assert path.read_text() == COULOMB
    assert list(tmp_path.iterdir()) == [path]


def test_a_python_function_fits_no_file(tmp_path):
    def falling(s, a):
        return a + (1 - a) / (1 + s)

    model = ss.examples.coulomb().replace(friction=ss.friction_law(falling, parameters={"a": 0.3}))
    path = tmp_path / "model.toml"
    with pytest.raises(ValueError, match=r"falling.*Python function.*coulomb, popp-stelter"):
        write_model(model, path)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_the_way_is_an_error_and_stays(tmp_path):
    path = tmp_path / "model.toml"
    path.mkdir()
    with pytest.raises(OSError):  # noqa: PT011, the system's own words
        write_model(ss.examples.coulomb(), path)
    assert list(tmp_path.iterdir()) == [path]


# --- mistakes ---------------------------------------------------------------------------------


def changed(old, new, content=COULOMB):
    assert old in content
    return content.replace(old, new)


BAD = {
    "empty": ("", ["kind", "two_block"]),
    "kind missing": (changed("kind", "knd"), ["lacks kind", "'knd'", "two_block"]),
    "kind of no such model": (
        changed("two_block", "two-block"),
        ["kind = 'two-block'", "Known: two_block", "Did you mean 'two_block'?"],
    ),
    "key of another kind": (
        changed("two_block", "chain"),
        ["unknown key 'beta'", "Known: kind, static, alpha, V, support, mass, damping, ends"],
    ),
    "chain without its limits": (changed("beta = 1.3\n", "", CHAIN), ["lacks static"]),
    "chain with a bad limit": (
        changed("beta = 1.3\n", "static = [1, -1.3]\n", CHAIN),
        ["static[1] = -1.3", "positive"],
    ),
    "chain with ends of no such kind": (
        changed("beta = 1.3\n", 'static = [1, 1]\nends = "fre"\n', CHAIN),
        ["ends = 'fre'", "Did you mean 'free'?"],
    ),
    "chain with a number for its limits": (
        changed("beta = 1.3\n", "static = 1\n", CHAIN),
        ["static = 1", "list"],
    ),
    "two laws for three blocks": (
        PAIR.replace("two_block", "chain").replace("beta = 1.3", "static = [1, 1, 1]"),
        ["[[friction]] stands 2 times for 3 blocks"],
    ),
    "stiffness of another shape": (
        'kind = "blocks"\nmass = [1, 1]\nstiffness = [[1, 0]]\nstatic = [1, 1]\nV = 0.1\n'
        '[friction]\nlaw = "coulomb"\nmu = 0.2\n',
        ["stiffness", "(1, 2)", "(2, 2)"],
    ),
    "forcing misspelt": (
        OSCILLATOR + "[forcing]\namplitude = 1\nfrequenzy = 1\n",
        ["[forcing]", "'frequenzy'", "'frequency'?"],
    ),
    "forcing out of range": (
        OSCILLATOR + "[forcing]\namplitude = 1\nfrequency = 0\n",
        ["[forcing]", "frequency = 0"],
    ),
    "two laws for one block": (
        changed("[friction]", "[[friction]]", OSCILLATOR)
        + '[[friction]]\nlaw = "coulomb"\nmu = 0\n',
        ["2 times for 1 blocks"],
    ),
    "two forcings of a block": (
        OSCILLATOR + 2 * "[[forcing]]\namplitude = 1\nfrequency = 1\n",
        ["[[forcing]] is for structures", "kind oscillator", "Write [forcing], once"],
    ),
    "two laws of a contact": (
        'kind = "structure"\nmass = [1]\nstiffness = [[1]]\n[[contact]]\nat = 0\n'
        + 2 * '[[contact.friction]]\nlaw = "coulomb"\nmu = 0\n',
        ["[[contact]] 0 ", "one law", "Write [contact.friction] once"],
    ),
    "no contacts": (
        'kind = "structure"\nmass = [1]\nstiffness = [1]\ncontact = []\n',
        ["contact = []", "[[contact]]"],
    ),
    "laws in a plain list": (
        changed('[friction]\nlaw = "coulomb"\nmu = 0.22', 'friction = ["coulomb:mu=0.2"]'),
        ["friction = ['coulomb:mu=0.2']", "[[friction]]"],
    ),
    "kind as number": (changed('"two_block"', "3"), ["kind = 3", "text"]),
    "key misspelt": (changed("alpha", "alhpa"), ["'alhpa'", "Did you mean 'alpha'?"]),
    "key in other case": (changed("V =", "v ="), ["'v'", "Did you mean 'V'?"]),
    "keys missing": (changed("beta = 1.3\nV = 0.0366\n", ""), ["lacks beta, V"]),
    "key twice": (COULOMB + "mu = 0.3\n", ["not TOML", "line 9"]),
    "key under the wrong table": (
        'kind = "two_block"\nalpha = 1\nV = 1\n[friction]\nlaw = "coulomb"\nmu = 0\nbeta = 1.3\n',
        ["[friction]", "'beta'", "before any [table]"],
    ),
    "key twice, once under the wrong table": (
        COULOMB + "beta = 1.3\n",
        ["[friction]", "'beta'", "before any [table]"],
    ),
    "below its range": (changed("1.2", "-1"), ["alpha = -1", ">= 0"]),
    "not above its range": (changed("0.0366", "0"), ["V = 0", "> 0"]),
    "NaN": (changed("1.2", "nan"), ["alpha = nan", "finite"]),
    "infinite": (changed("1.3", "inf"), ["beta = inf", "finite"]),
    "beyond the floats": (changed("1.2", "1" + "0" * 400), ["alpha = 1000", "finite"]),
    "text for a number": (changed("1.2", '"1.2"'), ["alpha = '1.2'", "number"]),
    "truth for a number": (changed("1.2", "true"), ["alpha = True", "number"]),
    "list for a number": (changed("1.2", "[1.2]"), ["alpha = [1.2]", "number"]),
    "date for a number": (changed("1.2", "1979-05-27"), ["alpha = ", "number"]),
    "no value": (changed("1.2", ""), ["not TOML", "line 2"]),
    "no TOML": ("alpha: 1.2\n", ["not TOML", "line 1"]),
    "not UTF-8": (COULOMB.encode() + b"# caf\xe9\n", ["UTF-8", "0xe9", "line 9"]),
    "nested without end": ("a = " + "[" * 5000, ["nested"]),
    "a key of many dots": (changed("alpha", "a" + ".a" * 50_000), ["nested", "line 2"]),
    "a table of many dots": (COULOMB + "[a" + " . 'a'" * 50_000 + "]\n", ["nested", "line 9"]),
    "tables in tables": (
        COULOMB.partition("[friction]")[0] + "friction = " + "{a=" * 200 + "1" + "}" * 200,
        ["nested", "more than 20 levels"],
    ),
    "lists in lists": (changed("1.2", "[" * 100 + "]" * 100), ["nested", "more than 20 levels"]),
    "thousands of digits": (changed("1.2", "1" * 5000), ["not TOML", "digits"]),
    "law missing": (changed('law = "coulomb"\n', ""), ["[friction]", "lacks law", "stribeck"]),
    "law misspelt": (changed("coulomb", "columb"), ["[friction]", "'columb'", "'coulomb'?"]),
    "law as number": (changed('"coulomb"', "8"), ["[friction]", "law = 8", "text"]),
    "law without its parameter": (changed("mu = 0.22\n", ""), ["[friction]", "'mu'"]),
    "parameter of another law": (changed("mu", "gamma"), ["[friction]", "'gamma'", "mu, viscous"]),
    "table without its forces": (TABULATED + "speed = [0, 1]\n", ["[friction]", "lacks force"]),
    "table with a number": (
        TABULATED + "speed = [0, 1]\nforce = [1, 0.5]\nmu = 0.3\n",
        ["[friction]", "'mu'", "speed, force"],
    ),
    "table that falls back": (
        TABULATED + "speed = [0, 1, 1]\nforce = [1, 0.5, 0.5]\n",
        ["[friction]", "speed[2] = 1"],
    ),
    "parameter out of range": (changed("0.22", "1.5"), ["[friction]", "mu", "1.5", "<= 1"]),
    "parameter NaN": (changed("0.22", "nan"), ["[friction]", "mu", "nan"]),
    "parameter beyond the floats": (
        changed("0.22", "1" + "0" * 400),
        ["[friction]", "mu = 1000", "0 <= mu <= 1"],
    ),
    "parameter as text": (changed("0.22", '"0.22"'), ["[friction]", "mu", "'0.22'", "number"]),
    "choice that does not exist": (
        changed("exponent = 2", "exponent = 3", PAIR),
        ["[[friction]] of block 2", "exponent", "3", "1 or 2"],
    ),
    "friction missing": (COULOMB.partition("[friction]")[0], ["lacks friction"]),
    "friction as text": (
        COULOMB.partition("[friction]")[0] + 'friction = "mu + (1 - mu) / (1 + s"\n',
        ["friction: the formula 'mu + (1 - mu) / (1 + s' ends where ) is expected"],
    ),
    "formula without a value": (
        FORMULA.replace("v = 0.5\n", ""),
        ["[friction]", "exp(-s / v)' needs a value for v: write v = ... below it"],
    ),
    "formula without values": (
        FORMULA.replace("mu = 0.2\nv =", "vv ="),
        ["needs values for mu, v: write mu = ... v = ... below it; it has no vv"],
    ),
    "formula in a line without a value": (
        COULOMB.partition("[friction]")[0] + 'friction = "mu + (1 - mu) / (1 + s)"\n',
        ["friction: ", "needs a value for mu: write ', mu=...' behind it"],
    ),
    "formula with one value more": (FORMULA + "vv = 1\n", ["unknown key 'vv'", "mean 'v'?"]),
    "formula above a number of the model": (
        FORMULA + "damping = 0.1\n",
        ["unknown key 'damping'. Known: ", "write it before any [table]"],
    ),
    "formula of a value that is text": (FORMULA.replace("0.5", '"0.5"'), ["v = '0.5'"]),
    "forward as a number": (FORMULA + "forward = 1\n", ["forward = 1 must be a formula"]),
    "formula outside of [0, 1]": (FORMULA.replace("(1 - mu)", "2"), ["[friction]", "F(0) = 2.2"]),
    "friction as a number": (
        COULOMB.partition("[friction]")[0] + "friction = 0.22\n",
        ["friction = 0.22", "[friction]", "coulomb:mu=0.22"],
    ),
    "friction as an empty list": (
        COULOMB.partition("[friction]")[0] + "friction = []\n",
        ["friction = []", "[friction]"],
    ),
    "one law of two": (changed("[friction]", "[[friction]]"), ["1 times", "2 blocks"]),
    "three laws": (PAIR + '[[friction]]\nlaw = "coulomb"\n', ["3 times", "2 blocks"]),
    "physical key misspelt": (
        changed("fs2", "f2", PHYSICAL),
        ["[physical]", "'f2'", "Did you mean 'fs2'?"],
    ),
    "physical key missing": (changed("k12 = 9.6\n", "", PHYSICAL), ["[physical]", "lacks k12"]),
    "physical value": (changed("fs1 = 4", "fs1 = 0", PHYSICAL), ["[physical]", "fs1 = 0", "> 0"]),
    "physical and dimensionless": (
        changed("[physical]", "alpha = 1.2\n[physical]", PHYSICAL),
        ["alpha beside [physical]", "either"],
    ),
    "physical as number": (
        'kind = "two_block"\nphysical = 1\n[friction]\nlaw = "coulomb"\nmu = 0.2\n',
        ["[physical]", "m, k, k12, fs1, fs2, v_dr"],
    ),
    "weights of a contact as whole numbers": (
        'kind = "structure"\nmass = [1, 1, 1]\nstiffness = [1, 1, 1]\n[[contact]]\n'
        'at = [0, 1, 0]\nfriction = "coulomb:mu=0.2"\n',
        ["[[contact]] 0 at = [0, 1, 0] (list): two whole numbers", "decimal numbers, [1.0, 0.0]"],
    ),
    "units lack one": (COULOMB + "[units]\nm = 1\nk = 1\n", ["[units]", "lacks fs1"]),
    "units out of range": (
        COULOMB + "[units]\nm = 1\nk = 1\nfs1 = -2\n",
        ["[units]", "fs1 = -2", "> 0"],
    ),
}


@pytest.mark.parametrize(("content", "fragments"), BAD.values(), ids=BAD)
def test_a_mistake_is_named_with_file_key_and_what_is_allowed(read, content, fragments, tmp_path):
    with pytest.raises(ValueError) as caught:  # noqa: PT011, the fragments are the match
        read(content)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path / 'model.toml'}: ")
    for fragment in fragments:
        assert fragment in message


def test_files_that_cannot_be_read_are_the_systems_errors(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"missing\.toml"):
        read_model(tmp_path / "missing.toml")
    with pytest.raises(IsADirectoryError):
        read_model(tmp_path)


@pytest.mark.parametrize("path", ["/dev/zero", "pipe"])
def test_what_has_no_end_is_not_read(tmp_path, path):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(OSError, match="device or a pipe"):
        read_model(tmp_path / path)


def test_a_file_larger_than_any_model_is_refused(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text("#" * 2**22 + "\n")
    with pytest.raises(ValueError, match=r"model\.toml: is too large: more than 4,194,304 bytes"):
        read_model(path)


@pytest.mark.parametrize("path", [None, 3, b"model.toml", ""])
def test_a_path_that_is_none_is_named(path):
    for use in (read_model, lambda path: write_model(ss.examples.coulomb(), path)):
        with pytest.raises(ValueError, match=r"^path = "):
            use(path)


def test_a_model_is_written_as_toml_and_nothing_else(tmp_path):
    with pytest.raises(ValueError, match=r"ends in \.toml"):
        write_model(ss.examples.coulomb(), tmp_path / "model.json")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read all")
def test_a_file_that_may_not_be_read(tmp_path):
    path = tmp_path / "model.toml"
    path.write_text(COULOMB)
    path.chmod(0)
    with pytest.raises(PermissionError):
        read_model(path)
