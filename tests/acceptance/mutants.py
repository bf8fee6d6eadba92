"""How many small changes of the core layers the tests notice: the mutation score.

    python -m tests.acceptance.mutants                        # all layers, an hour of one core
    python -m tests.acceptance.mutants friction --n 20 --seed 7

A mutant is the package with one operator, comparison, number or keyword changed (cosmic-ray does
that). Of all mutants of a layer a random sample is tried, in a copy of the sources: tests are run
until one fails, first those that run the changed statement, which coverage tells. Kernels run as
plain Python, and tests that are slow then are left out: the score is a lower bound for the
suite's. Some mutants change nothing that anyone could see. Counts go to `docs/mutants.csv`, ten
mutants at a time; those that no test noticed to the terminal.
"""

from __future__ import annotations

import argparse
import ast
import csv
import difflib
import itertools
import json
import multiprocessing
import os
import random
import resource
import shutil
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path
from typing import Any

import cosmic_ray.plugins
import pytest
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from coverage import CoverageData
from scipy.stats import binomtest

from . import clock

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "docs" / "mutants.csv"
HEAD = ("layer", "version", "date", "seed", "of", "tried", "noticed", "score_low", "score_high")

ENOUGH = 30.0  # seconds of processor time of the tests that are run for one mutant, and ...
PATIENCE = 60  # ... when it is taken to have no end: then it is noticed
PIECE = 10  # mutants between two entries in the table
SWAPS = (
    *("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "Pow_Mul"),
    *("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt", "LtE_GtE", "GtE_LtE"),
    *("Eq_NotEq", "NotEq_Eq", "Is_IsNot", "IsNot_Is"),
)
WORDS = (
    *("AddNot", "NumberReplacer", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ZeroIterationForLoop"),
    *("ReplaceBreakWithContinue", "ReplaceContinueWithBreak"),
    *("ReplaceTrueWithFalse", "ReplaceFalseWithTrue"),
    *("ReplaceUnaryOperator_Delete_Not", "ReplaceUnaryOperator_Delete_USub"),
)
PRELOADED = (
    *("hypothesis.extra.numpy", "matplotlib.figure", "mpmath", "numpy"),
    *("scipy.integrate", "scipy.interpolate", "scipy.optimize", "scipy.sparse.linalg"),
)
"""What tests import and no mutant is made of: loaded once."""

QUIETLY = (
    *("-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist"),
    *("-W", "ignore::pytest.PytestAssertRewriteWarning"),
)


@dataclass(frozen=True)
class Layer:
    """Files of the package, and the tests that may notice a change of them."""

    sources: tuple[str, ...]
    tests: tuple[str, ...]
    compiled: bool = False


MECHANICS = (
    *("tests/contracts", "tests/mechanics/friction", "tests/mechanics/flow"),
    *("tests/mechanics/eventmap", "--deselect=tests/mechanics/eventmap/test_cuda.py"),
    *(f"--deselect=tests/mechanics/eventmap/test_{name}.py" for name in ("lanes", "pools")),
)
"""Lanes and pools run generated text, which is much too slow as plain Python."""
LAYERS = {
    "friction": Layer(("mechanics/friction/*.py",), MECHANICS),
    "flow": Layer(("mechanics/flow/[!_]*.py", "mechanics/flow/_[!l]*.py"), MECHANICS),
    "event map": Layer(
        (
            *("mechanics/eventmap/_kernels.py", "mechanics/eventmap/_pair_kernels.py"),
            "mechanics/eventmap/itinerary.py",
        ),
        MECHANICS,
    ),
    "maps of a line": Layer(("analysis/**/[!_]*.py",), ("tests/analysis",), compiled=True),
}


@dataclass(frozen=True)
class Mutant:
    """One change of one file; `occurrence` counts the places for the same change."""

    path: str
    operator: str
    occurrence: int
    line: int

    def text(self, source: str) -> str:
        """Return the changed source."""
        changed = mutate_code(source, operator(self.operator), self.occurrence)
        assert changed is not None
        return changed


@cache
def operator(name: str) -> Any:
    """Return what makes a change of a sort."""
    return cosmic_ray.plugins.get_operator(f"core/{name}")()


def mutants(root: Path, layer: Layer) -> Iterator[Mutant]:
    """Yield all mutants of a layer."""
    kinds = {"comparison": "ReplaceComparisonOperator", "binary": "ReplaceBinaryOperator"}
    swaps = [
        f"{kinds['comparison' if name[:2] in ('Lt', 'Gt', 'Eq', 'No', 'Is') else 'binary']}_{name}"
        for name in SWAPS
    ]
    package = root / "src" / "stickslip"
    for path in sorted(path for pattern in layer.sources for path in package.glob(pattern)):
        nodes = list(ast_nodes(get_ast(path.read_text(encoding="utf-8"))))
        for name in (*swaps, *WORDS):
            lines = [at[0][0] for node in nodes for at in operator(name).mutation_positions(node)]
            for occurrence, line in enumerate(lines):
                yield Mutant(str(path.relative_to(root)), name, occurrence, line)


# ---------------------------------------------------------------- tests in a copy of the sources


def _run_tests(root: Path, arguments: list[str], compiled: bool, times: Path | None) -> None:
    """Run pytest in this process, and end it."""
    os.chdir(root)
    os.environ |= {"CI": "1", "PYTHONPATH": str(root / "src")}  # the same examples each time
    if not compiled:
        os.environ |= {"NUMBA_DISABLE_JIT": "1", "STICKSLIP_CACHE_DIR": str(root / "cache")}
    for name in [name for name in sys.modules if name.split(".")[0] in ("stickslip", "tests")]:
        del sys.modules[name]
    sys.path[:0] = [str(root / "src"), str(root)]
    sys.stdout = sys.stderr = (root / "out.txt").open("w")
    if not times:
        resource.setrlimit(resource.RLIMIT_CPU, (PATIENCE, PATIENCE))
    code = pytest.main(
        [*QUIETLY, *arguments],
        plugins=[clock] if times else [],
    )
    if times:
        times.write_text(json.dumps(clock.seconds))
    sys.stdout.flush()
    os._exit(int(code))


def tested(root: Path, arguments: list[str], compiled: bool, times: Path | None) -> int | None:
    """Run tests in a process of their own; return pytest's exit code, below 0 if they do not end.

    Parameters
    ----------
    root : pathlib.Path
        Of the copy.
    arguments : list of str
        For pytest.
    compiled : bool
        Whether kernels are compiled, or run as plain Python.
    times : pathlib.Path or None
        Where to write how long each test took; then slow ones are stopped.
    """
    fork = multiprocessing.get_context("fork")
    process = fork.Process(target=_run_tests, args=(root, arguments, compiled, times))
    process.start()
    process.join()
    return process.exitcode


@dataclass(frozen=True)
class Runs:
    """Which tests run which lines, and how long they take."""

    root: Path
    data: CoverageData
    seconds: dict[str, float]

    @classmethod
    def of(cls, root: Path, tests: tuple[str, ...], compiled: bool) -> Runs:
        """Run all of some tests."""
        file, times, settings = root / "lines", root / "times.json", root / "coverage.ini"
        settings.write_text(f"[run]\nsource = {root}/src/stickslip\ndata_file = {file}\n")
        cover = ["--cov", f"--cov-config={settings}", "--cov-context=test", "--cov-report="]
        tested(root, ["-m", "not slow", *cover, *tests], compiled, times)
        if not times.exists():
            raise RuntimeError((root / "out.txt").read_text()[-2000:])
        data = CoverageData(str(file))
        data.read()
        return cls(root, data, json.loads(times.read_text()))

    def tests(self, mutant: Mutant) -> list[str]:
        """Return tests, as many as are enough: first those that run the changed statement.

        Then all others, the quickest first: what is made once and kept is run by one test and
        used by many.
        """
        by_line = self.data.contexts_by_lineno(str(self.root / mutant.path))
        source = (self.root / mutant.path).read_text(encoding="utf-8")
        contexts = [by_line.get(line, []) for line in _statement(source, mutant.line)]
        nearest = {name.removesuffix("|run") for names in contexts for name in names}
        ordered = sorted(self.seconds, key=lambda name: (name not in nearest, self.seconds[name]))
        sums = itertools.accumulate(self.seconds[name] for name in ordered)
        return [name for name, total in zip(ordered, sums, strict=True) if total <= ENOUGH]


def _statement(source: str, line: int) -> range:
    """Lines of the innermost statement around a line; of one with a body, its head."""
    best = range(line, line + 1)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            assert node.end_lineno is not None
            end = body[0].lineno if body else node.end_lineno + 1
            if node.lineno <= line < max(end, node.lineno + 1):
                best = range(node.lineno, max(end, node.lineno + 1))
    return best


def noticed(runs: Runs, mutant: Mutant, compiled: bool) -> bool:
    """Whether some test fails, or does not end, with a mutant in the place of its file."""
    path = runs.root / mutant.path
    whole = path.read_text(encoding="utf-8")
    try:
        path.write_text(mutant.text(whole), encoding="utf-8")
        code = tested(runs.root, ["-x", *runs.tests(mutant)], compiled, None)
    finally:
        path.write_text(whole, encoding="utf-8")
    return code != pytest.ExitCode.OK


def shown(mutant: Mutant, source: str) -> str:
    """Return the lines that a mutant changes, before and after."""
    lines = difflib.unified_diff(
        source.splitlines(), mutant.text(source).splitlines(), n=0, lineterm=""
    )
    changes = [line for line in lines if line[:1] in "+-" and line[:3] not in ("+++", "---")]
    return "\n".join([f"{mutant.path}:{mutant.line} {mutant.operator}", *changes])


# ---------------------------------------------------------------- the table


def record(layer: str, seed: int, of: int, tried: int, noticed: int) -> None:
    """Put a row into the table; it replaces one of the same layer, version, day and seed."""
    low, high = binomtest(noticed, tried).proportion_ci(method="wilson")  # of 95 %
    day = datetime.now(UTC).date().isoformat()
    counts = (of, tried, noticed, f"{low:.2f}", f"{high:.2f}")
    row = [str(item) for item in (layer, version("stickslip"), day, seed, *counts)]
    rows = list(csv.reader(TABLE.open(newline="")))[1:] if TABLE.exists() else []
    kept = [old for old in rows if old[:4] != row[:4]]
    with TABLE.open("w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows([HEAD, *kept, row])


def try_layer(runs: Runs, name: str, n: int, seed: int) -> None:
    """Try a sample of a layer's mutants, say which go unnoticed, and count."""
    root, layer, began = runs.root, LAYERS[name], time.monotonic()
    everything = list(mutants(root, layer))
    sample = random.Random(seed).sample(everything, min(n, len(everything)))
    print(f"{name}: {len(everything)} mutants, {len(runs.seconds)} tests", flush=True)
    told = 0
    if tested(root, runs.tests(sample[0]), layer.compiled, None) != pytest.ExitCode.OK:
        raise RuntimeError((root / "out.txt").read_text()[-2000:])  # nothing has been changed yet
    for number, mutant in enumerate(sample, 1):
        if noticed(runs, mutant, layer.compiled):
            told += 1
        else:
            source = (root / mutant.path).read_text(encoding="utf-8")
            print(f"not noticed: {shown(mutant, source)}", flush=True)
        if number % PIECE == 0 or number == len(sample):
            print(f"{told} of {number}, {time.monotonic() - began:.0f} s", flush=True)
            record(name, seed, len(everything), number, told)


def main() -> None:
    """Try the layers that are named, or all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("layers", nargs="*", choices=[*LAYERS, []], default=list(LAYERS))
    parser.add_argument("--n", type=int, default=60, help="mutants of each layer")
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    for module in PRELOADED:
        import_module(module)
    with tempfile.TemporaryDirectory(prefix="stickslip-mutants-") as folder:
        root = Path(folder)
        for item in ("src", "tests", "docs", "conftest.py", "pyproject.toml", "README.md"):
            copy = shutil.copytree if (ROOT / item).is_dir() else shutil.copy
            copy(ROOT / item, root / item)
        runs = cache(lambda tests, compiled: Runs.of(root, tests, compiled))
        for name in given.layers:
            layer = LAYERS[name]
            try_layer(runs(layer.tests, layer.compiled), name, given.n, given.seed)


if __name__ == "__main__":
    main()
