"""What only `make benchmark` would notice: benchmarks that no longer fit the package."""

import importlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FILES = sorted((ROOT / "benchmarks").glob("bench_*.py"))


@pytest.fixture(autouse=True)
def _from_the_root(monkeypatch):
    monkeypatch.syspath_prepend(ROOT)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_a_benchmark_can_be_imported(file):
    module = importlib.import_module(f"benchmarks.{file.stem}")
    assert any(name == "main" or name.startswith("bench_") for name in vars(module))


def test_the_arithmetic_of_a_map_can_be_counted():
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.counted"],
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    count = json.loads(done.stdout)
    # Two events in closed form need a few hundred operations, and roots and divisions for times.
    assert 300 < count["additions and multiplications"] < 1200
    assert 2 < count["divisions"] < count["additions and multiplications"] / 20
    assert 2 < count["square roots"] < count["additions and multiplications"] / 20


def test_guarded_ratios_are_of_tables_that_some_benchmark_makes():
    texts = [path.read_text(encoding="utf-8") for path in FILES]
    shared = (ROOT / "benchmarks" / "measure.py").read_text(encoding="utf-8")
    for ratio in json.loads((ROOT / "benchmarks" / "ratios.json").read_text(encoding="utf-8")):
        table, column = (f'"{ratio[name]}"' for name in ("table", "column"))
        assert any(table in text and column in text + shared for text in texts), ratio
