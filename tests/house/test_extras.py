"""Without an extra, what needs it says which one; everything else works."""

import subprocess
import sys

import pytest

from stickslip.cli.program import run
from stickslip.errors import MissingExtraError
from stickslip.extras import require_extra


@pytest.mark.parametrize(
    ("command", "package", "extra"),
    [
        ("explore --no-browser", "uvicorn", "app"),
        ("certify --preset coulomb", "flint", "certify"),
        ("verify certificate.json", "flint", "certify"),
        ("plot plane.zarr --out plane.png", "xarray", "sweep"),
        ("sweep plan.toml", "zarr", "sweep"),
        ("sweep plan.toml --status", "fsspec", "sweep"),
        ("sweep plan.toml --store s3://bucket/plane.zarr", "s3fs", "cluster"),
        ("sweep plan.toml --scheduler tcp://127.0.0.1:9", "distributed", "cluster"),
    ],
)
def test_a_command_names_the_extra(command, package, extra, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "certificate.json").write_text("{}")
    (tmp_path / "plan.toml").write_text(PLAN)
    for name in [name for name in sys.modules if name.startswith("stickslip.proofs")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    assert run(command.split()) == 2
    said = capsys.readouterr().err
    assert f'need the package {package}: pip install "stickslip[{extra}]"' in said
    assert "Error" not in said


WITHOUT_PROOFS = """
import importlib.util
found = importlib.util.find_spec
importlib.util.find_spec = lambda name, *rest: None if name == "flint" else found(name, *rest)
from stickslip import *
import pydoc, stickslip
assert "certify" not in dir() and TwoBlock is stickslip.TwoBlock
assert "TwoBlock" in pydoc.render_doc(stickslip)
try:
    stickslip.certify
except ImportError as error:
    print(error)
"""


def test_help_and_import_of_everything_work_without_an_extra():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_PROOFS], check=True, capture_output=True, text=True
    )
    assert 'pip install "stickslip[certify]"' in done.stdout


PLAN = """\
store = "plane.zarr"
observables = ["attractor"]

[model]
kind = "two_block"
alpha = 1.2
beta = 1.3
V = 0.0366
friction = {law = "coulomb", mu = 0.22}

[axes]
V = {from = 0.0366, to = 0.0372, n = 2}
"""


def test_nothing_is_said_where_everything_is_there():
    require_extra("sweep", "sweeps", "sys", "json")
    with pytest.raises(MissingExtraError, match=r"things need the package nowhere: .*\[sweep\]"):
        require_extra("sweep", "things", "sys", "nowhere")
