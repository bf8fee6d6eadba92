"""Starting is cheap: nothing heavy is imported before it is needed."""

import os
import subprocess
import sys

import stickslip

HEAVY = ("numba", "scipy", "matplotlib", "xarray", "numpy")


def loaded_after(code):
    """Names of the heavy packages that are loaded after running `code`."""
    probe = f"{code}\nimport sys\nprint(*[name for name in {HEAVY} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1].split()


def test_importing_the_package_loads_nothing_heavy():
    assert loaded_after("import stickslip") == []


def test_parsing_the_command_line_loads_nothing_heavy():
    code = "from stickslip.cli import main\nassert main(['map', '--help']) == 0"
    assert loaded_after(code) == []


def test_the_explorers_page_is_served_without_anything_heavy():
    assert loaded_after("import stickslip.app.server") == []


def test_version_is_told_at_once():
    # Processor time, which other work on the machine disturbs less than the clock; best of some.
    spent = []
    for _ in range(5):
        before = os.times()
        command = [sys.executable, "-m", "stickslip.cli", "--version"]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        after = os.times()
        spent.append(sum(after[2:4]) - sum(before[2:4]))  # of child processes, user and system
        assert done.stdout == f"{stickslip.__version__}\n"
    assert min(spent) < 0.3


def test_the_first_value_needs_no_linear_algebra_and_takes_none_from_others():
    code = """
import sys
import numba, numpy as np, stickslip as ss
assert abs(ss.event_map(ss.examples.coulomb())(0.1)) < 1.0
print("scipy.linalg" in sys.modules)
print(numba.njit(lambda a, b: np.dot(a, b))(np.eye(2), np.full((2, 2), 3.0)).sum())
"""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "0"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout.split() == ["False", "12.0"]


def test_kernels_that_are_kept_are_loaded_without_what_a_compiler_needs():
    code = """
import sys, stickslip as ss
ss.event_map(ss.examples.coulomb())(0.1)
print("numba.np.linalg" in sys.modules)
"""
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "0"}
    command = [sys.executable, "-c", code]
    for _ in range(2):  # once to compile, if need be
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
    assert done.stdout == "False\n"
