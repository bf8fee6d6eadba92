"""``stickslip doctor``: what this installation can do, and what to install for the rest."""

from __future__ import annotations

import importlib.metadata
import platform
import re
import sys

from stickslip.cli import columns
from stickslip.cli.options import OutputOptions

EXAMPLES = """\
stickslip doctor
stickslip doctor --json
"""

PACKAGE = "stickslip"
Finding = tuple[str, str, str]


def command(*, output: OutputOptions = OutputOptions()) -> None:
    """Show versions, extras, GPU, cache folder and threads."""
    findings = [*_versions(), *_extras(), _gpu(), _cache(), _threads()]
    subjects, states, details = zip(*findings, strict=True)
    table = {"subject": list(subjects), "state": list(states), "detail": list(details)}
    if output.json:
        print(columns.document("doctor", {}, table), end="")
        return
    for subject, state, detail in findings:
        print(f"{subject:<14} {state:<12} {detail}".rstrip())


def _installed(name: str) -> str | None:
    try:
        return importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        return None


def _requirements() -> dict[str, list[str]]:
    """Names of the distributions that the core ("") and each extra ask for."""
    wanted: dict[str, list[str]] = {"": []}
    for line in importlib.metadata.requires(PACKAGE) or []:
        extra = re.search(r"""extra == ['"](\w+)['"]""", line)
        name = re.match(r"[\w.-]+", line)
        assert name is not None, line
        wanted.setdefault(extra[1] if extra else "", []).append(name[0])
    return wanted


def _versions() -> list[Finding]:
    python = ("python", platform.python_version(), sys.executable)
    system = ("system", platform.system(), platform.machine())
    core = [(name, _installed(name) or "missing", "") for name in [PACKAGE, *_requirements()[""]]]
    return [python, system, *core]


def _extras() -> list[Finding]:
    findings = []
    for extra, names in _requirements().items():
        if extra in {"", "dev", "docs", "bench"}:
            continue
        missing = [name for name in names if _installed(name) is None]
        remedy = f'pip install "{PACKAGE}[{extra}]" adds {", ".join(missing)}'
        findings.append(
            (f"extra {extra}", "missing" if missing else "ready", remedy if missing else "")
        )
    return findings


def _gpu() -> Finding:
    if _installed("numba-cuda") is None:
        return "gpu", "not used", f'pip install "{PACKAGE}[gpu]"'
    from numba import cuda

    if not cuda.is_available():
        return "gpu", "none found", "numba-cuda is installed and sees no device"
    return "gpu", "ready", cuda.get_current_device().name.decode()


def _cache() -> Finding:
    from stickslip.numerics.targets import cache_root

    folder = cache_root()
    if folder is None:
        return "kernel cache", "off", "no folder that you alone can write: set STICKSLIP_CACHE_DIR"
    files = [path for path in folder.rglob("*") if path.is_file()]
    compiled = sum(path.suffix == ".nbc" for path in files)
    megabytes = sum(path.stat().st_size for path in files) / 1e6
    return "kernel cache", "ready", f"{folder} ({compiled} compiled, {megabytes:.1f} MB)"


def _threads() -> Finding:
    from stickslip.numerics.targets import available_threads

    return "threads", str(available_threads()), "cores this process may use"
