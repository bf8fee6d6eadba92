"""Install what is built into empty environments, and use it there as a newcomer does.

    make packaging                                  # all of it: a network, uv, half an hour
    python -m tests.acceptance.packaging --python 3.13 --only sweep

Builds the wheel and the sdist. For each Python and each end of the allowed dependencies (`newest`,
`oldest`: direct ones only) it makes an environment for the core and for each extra alone, and runs
there, in an empty folder with an empty home, what the README shows or what the extra offers; the
core must also say which extra is missing. The sdist is installed once. Of the extra ``gpu`` only
the versions are resolved. Exit code 1 if anything fails; ends with a table.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHONS = ("3.11", "3.12", "3.13", "3.14")
RESOLUTIONS = {"newest": "highest", "oldest": "lowest-direct"}
UV = (sys.executable, "-m", "uv")
TOLD = (
    "numba",
    "numpy",
    "scipy",
    "zarr",
    "xarray",
    "starlette",
    "python-flint",
    "sphinx",
    "pytest",
    "numba-cuda",
)
RESOLVED_ONLY = "gpu"  # its packages are large and need a device

BEFORE = """
import os, subprocess, sys
import stickslip as ss
os.environ["PATH"] = os.path.dirname(sys.executable) + os.pathsep + os.environ["PATH"]
"""

REPRODUCE = """
for command in ("--version", "map --preset coulomb -d 0.1", "reproduce 5 --out out"):
    subprocess.run(["stickslip", *command.split()], check=True)
assert os.path.getsize("out/fig05.png") > 0
assert os.path.exists(os.path.join(os.path.dirname(ss.__file__), "py.typed"))
"""

SAYS_WHAT_IS_MISSING = """
for command, extra in {
    "explore": "app", "certify --preset coulomb": "certify", "plot plane.zarr --out a.png": "sweep"
}.items():
    said = subprocess.run(["stickslip", *command.split()], capture_output=True, text=True)
    assert said.returncode == 2 and f"stickslip[{extra}]" in said.stderr, said
try:
    ss.event_map(ss.examples.coulomb(), device="cuda")
except ValueError as error:
    assert "stickslip[gpu]" in str(error)
"""

SWEEP = """
axes = {"V": (0.0366, 0.0372, 4), "alpha": [1.2, 1.21]}
for store in ("plane.zarr", "plane.zip"):
    found = ss.sweep(ss.examples.coulomb(), axes, ["attractor"], store=store)
assert ss.open_sweep("plane.zip").attrs["done"] > 0
subprocess.run(["stickslip", "plot", "plane.zip", "--out", "plane.png"], check=True)
print(found.period.values.tolist())
"""

SAYS_CLUSTER_IS_MISSING = """
try:
    ss.sweep(ss.examples.coulomb(), axes, ["attractor"], store="s3://bucket/plane.zarr")
except ImportError as error:
    assert "stickslip[cluster]" in str(error)
else:
    raise AssertionError
"""

CLUSTER = """
from distributed import Client
with Client(processes=False, dashboard_address=None, n_workers=1) as client:
    again = ss.sweep(ss.examples.coulomb(), axes, ["attractor"], store="dask.zarr", client=client)
assert again.equals(found)
import s3fs
"""

APP = """
from urllib.request import urlopen
page = urlopen(ss.explore(ss.examples.coulomb()).url.partition("#")[0]).read()
assert b"<title>" in page
print(len(page), "bytes of page")
"""

JAX = """
import jax, stickslip.jax
f = stickslip.jax.event_map(ss.examples.coulomb(), "mu")
print(jax.grad(f)(0.1, jax.numpy.array([0.22])))
"""

IMPORTS = {
    "docs": "import myst_parser, numpydoc, pydata_sphinx_theme, sphinx_gallery, sphinx",
    "bench": "import pytest, pytest_benchmark",
}

EXTRAS = ("", *IMPORTS, "app", "certify", "jax", "sweep", "cluster", RESOLVED_ONLY)


def readme_python() -> list[str]:
    """Return the blocks of Python in the README."""
    return re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)


def use_of(extra: str) -> str:
    """Return a script that uses the core (no extra) or what an extra offers."""
    proofs = [block for block in readme_python() if "certify" in block]
    core = [block for block in readme_python() if block not in proofs]
    return (
        BEFORE
        + {
            "": "\n".join([*core, REPRODUCE, SAYS_WHAT_IS_MISSING]),
            "app": APP,
            "certify": "\n".join(["model = ss.examples.coulomb()", *proofs]),
            "jax": JAX,
            "sweep": SWEEP + SAYS_CLUSTER_IS_MISSING,
            "cluster": SWEEP + CLUSTER,
            **IMPORTS,
        }[extra]
    )


@dataclass(frozen=True)
class Case:
    """An environment: what is installed, with which Python, at which end of the versions."""

    python: str
    resolution: str
    extra: str
    artefact: Path

    @property
    def wanted(self) -> str:
        """What pip is asked for."""
        extra = f"[{self.extra}]" if self.extra else ""
        return f"stickslip{extra} @ {self.artefact.as_uri()}"

    def __str__(self) -> str:
        kind = self.artefact.suffix.lstrip(".").replace("gz", "sdist").replace("whl", "wheel")
        return f"{self.python:5} {self.resolution:7} {self.extra or 'core':8} {kind}"


def cases(dist: Path, pythons: list[str], extras: list[str]) -> list[Case]:
    """Return the environments to make: all with the wheel, the core with the sdist too."""
    (wheel,), (sdist,) = dist.glob("*.whl"), dist.glob("*.tar.gz")
    every = [
        Case(python, resolution, extra, wheel)
        for python in pythons
        for resolution in RESOLUTIONS
        for extra in extras
    ]
    return every + [Case(pythons[0], "newest", "", sdist)] * ("" in extras)


def run(*command: str | Path, cwd: Path = ROOT, **environment: str) -> str:
    """Run a command; what it says, or CalledProcessError."""
    names = ("HOME", "PATH", "LANG", "PIP_", "SSL_", "UV_", "REQUESTS_")
    kept = {name: value for name, value in os.environ.items() if name.startswith(names)}
    done = subprocess.run(
        [str(part) for part in command],
        cwd=cwd,
        env=kept | environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    if done.returncode != 0:
        raise subprocess.CalledProcessError(done.returncode, command, done.stdout)
    return done.stdout


def check(case: Case, folder: Path) -> str:
    """Install a case and use it; return what was installed of the project's own requirements."""
    pins = folder / "pins.txt"
    # Of the oldest versions those that have wheels for this Python: nobody is asked for a compiler.
    options = ("--quiet", "--python-version", case.python, "--output-file", pins)
    options += ("--only-binary", ":all:")
    extra = ("--extra", case.extra) if case.extra else ()
    resolution = ("--resolution", RESOLUTIONS[case.resolution])
    run(*UV, "pip", "compile", *options, *resolution, *extra, "pyproject.toml")
    if case.extra == RESOLVED_ONLY:
        return told(pins.read_text())
    environment = folder / "environment"
    run(*UV, "venv", "--quiet", "--python", case.python, environment)
    python = environment / "bin" / "python"
    run(*UV, "pip", "install", "--quiet", "--python", python, "-c", pins, case.wanted)
    script, empty = folder / "use.py", folder / "empty"
    script.write_text(use_of(case.extra))
    empty.mkdir()
    # One cache of compiled kernels for each Python and set of versions.
    compiled = folder.parent / f"{case.python}-{case.resolution}"
    home = {"HOME": str(empty), "STICKSLIP_CACHE_DIR": str(compiled), "MPLBACKEND": "Agg"}
    run(python, "-I", script, cwd=empty, **home)
    return told(run(*UV, "pip", "freeze", "--python", python))


def told(pins: str) -> str:
    """Return the lines that pin what the table tells."""
    pinned = re.findall(r"^([\w-]+)==(\S+)", pins, re.MULTILINE)
    return " ".join(f"{name} {version}" for name, version in pinned if name in TOLD)


def main() -> int:
    """Return 1 if something fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", action="append", choices=PYTHONS)
    parser.add_argument("--only", action="append", choices=["core", *EXTRAS[1:]])
    chosen = parser.parse_args()
    wanted = [extra.replace("core", "") for extra in chosen.only] if chosen.only else list(EXTRAS)
    failures = 0
    with tempfile.TemporaryDirectory(prefix="stickslip-packaging-") as name:
        dist = Path(name) / "dist"
        run(*UV, "build", "--quiet", "--out-dir", dist, ROOT)
        for number, case in enumerate(cases(dist, chosen.python or list(PYTHONS), wanted)):
            folder = Path(name) / str(number)
            folder.mkdir()
            began = time.monotonic()
            try:
                outcome = check(case, folder)
            except subprocess.CalledProcessError as error:
                failures += 1
                outcome = f"FAILED: {' '.join(map(str, error.cmd[:4]))} ...\n{error.output[-3000:]}"
            print(f"{case}  {time.monotonic() - began:4.0f} s  {outcome}", flush=True)
            shutil.rmtree(folder)
    return int(failures > 0)


if __name__ == "__main__":
    sys.exit(main())
