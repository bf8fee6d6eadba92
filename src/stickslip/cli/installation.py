"""Commands about the program itself: ``stickslip explore``, ``doctor`` and ``warmup``."""

from __future__ import annotations

import platform
import re
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from stickslip.cli.options import Flag, OutputOptions, Whole
from stickslip.cli.output import check_new, note, tracked
from stickslip.cli.process import UsageError

if TYPE_CHECKING:
    from stickslip.mechanics.friction.law import FrictionLaw
    from stickslip.mechanics.model.blocks import Chain
    from stickslip.mechanics.model.two_block import TwoBlock

EXPLORE_EXAMPLES = """\
stickslip explore
stickslip explore --preset law9 --port 0
stickslip explore --model mine.toml
stickslip explore --host 0.0.0.0 --no-browser
stickslip explore --model mine.toml --export page.html
stickslip explore --export folder
"""

HIGHEST_PORT = 65535
PACKAGE = "stickslip"


def explore(
    *,
    host: str = "127.0.0.1",
    port: Whole = 8421,
    no_browser: Annotated[Flag, Parameter(name="--no-browser")] = False,
    preset: str | None = None,
    model: Annotated[Path | None, Parameter(metavar="FILE")] = None,
    export: Path | None = None,
    force: Flag = False,
) -> None:
    """Open the explorer: map, motions and bifurcations of a model, linked, in the browser.

    Prints the address and serves until interrupted. Everything is computed on this machine,
    and only this machine is served unless --host says otherwise. Needs the extra "app".

    Parameters
    ----------
    host
        Address to serve at; 0.0.0.0 serves every machine that reaches this one.
    port
        Port to serve at; 0 takes a free one.
    no_browser
        Do not open a browser.
    preset
        View to begin with, such as coulomb, law9, oscillator, chain, brake or drill-string.
    model
        Begin with the plant of a model file.
    export
        Serve nothing: write the page, which begins with --preset or --model, into one file that
        opens from a disk, if the name ends in .html; else into a folder for any web server. It
        has presets and tour, all answers for the plant of --model, which takes a minute, and
        computes maps and motions of two equal undamped blocks itself.
    force
        Replace the page if it exists.
    """
    if not 0 <= port <= HIGHEST_PORT:
        raise UsageError(f"--port {port}: a port is a number from 0 to {HIGHEST_PORT}")
    if not host:  # sockets take it for every address
        raise UsageError("--host: name an address; 0.0.0.0 serves every machine")
    from stickslip.app import EXTRA
    from stickslip.extras import require_extra

    require_extra("app", "explorers", *EXTRA)
    if preset is not None and model is not None:
        raise UsageError("give either --model or --preset")
    from stickslip.app.folder import preset_names, presets

    if preset is not None and preset not in preset_names():
        raise UsageError(f"--preset {preset}: choose one of {', '.join(preset_names())}")
    if export is not None:
        check_new(export if export.suffix == ".html" else export / "index.html", force=force)
    plant = None
    if model is not None:
        from stickslip.app.page import opened  # loads the library

        plant = opened(model)
    if export is not None:
        from stickslip.app.live import moves
        from stickslip.app.shipped import export as write

        first = plant or next((view for view in presets() if view["name"] == preset), None)
        print(write(export, first), flush=True)
        if first is not None and not moves(first["state"]["model"]):
            note(
                f"the page shows answers for {first['title']} as it is, and no new motion: "
                "without a server it moves two equal undamped blocks alone, with Coulomb, law (9) "
                "or Stribeck",
                quiet=False,
            )
        return
    from stickslip.app.server import listening_socket, serve, url_of

    try:
        listener = listening_socket(host, port)
    except OSError as error:
        raise UsageError(
            f"cannot serve at {host}, port {port}: {error.strerror or error}. "
            "--port 0 takes a free port"
        ) from error
    url = url_of(listener) + ("" if preset is None else f"#preset={preset}")
    print(url, flush=True)
    note("serving; Ctrl-C ends it", quiet=False)
    serve(listener, host, page=None if no_browser else url, opened=plant)


DOCTOR_EXAMPLES = """\
stickslip doctor
stickslip doctor --json
"""

Finding = tuple[str, str, str]


def doctor(*, output: OutputOptions = OutputOptions()) -> None:
    """Show versions, extras, GPU, cache folder and threads."""
    findings = [*_versions(), *_extras(), _gpu(), _cache(), _prepared(), _threads()]
    subjects, states, details = zip(*findings, strict=True)
    table = {"subject": list(subjects), "state": list(states), "detail": list(details)}
    lines = ("{:<14} {:<12} {}".format(*finding).rstrip() for finding in findings)
    output.tell("doctor", {}, table, "\n".join(lines) + "\n")


def _installed(name: str) -> str | None:
    from importlib import metadata  # 13 ms, which every command would wait for

    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def _requirements() -> dict[str, list[str]]:
    """Names of the distributions that the core ("") and each extra ask for."""
    from importlib import metadata

    wanted: dict[str, list[str]] = {"": []}
    for line in metadata.requires(PACKAGE) or []:
        extra = re.search(r"""extra == ['"]([\w-]+)['"]""", line)
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
        if extra in {"", "dev", "docs", "bench", "bench-peers"}:
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
    from stickslip.numerics.gpu import gpu_fault, gpu_name

    fault = gpu_fault()
    return ("gpu", "not usable", fault) if fault else ("gpu", "ready", gpu_name())


def _cache() -> Finding:
    from stickslip.numerics.kernel_cache import cache_root

    folder = cache_root()
    if folder is None:
        return "kernel cache", "off", "no folder that you alone can write: set STICKSLIP_CACHE_DIR"
    files = [path for path in folder.rglob("*") if path.is_file()]
    compiled = sum(path.suffix == ".nbc" for path in files)
    megabytes = sum(path.stat().st_size for path in files) / 1e6
    return "kernel cache", "ready", f"{folder} ({compiled} compiled, {megabytes:.1f} MB)"


def _prepared() -> Finding:
    from stickslip.numerics.kernel_cache import prepared_levels, prepared_root

    if prepared_levels():
        return "prepared", "ready", "kernels of the laws that ship came with the package"
    why = "not for this processor" if prepared_root() else "none came with the package"
    return "prepared", "none", f"{why}: compiled when they are first asked for"


def _threads() -> Finding:
    from stickslip.numerics.targets import available_threads

    return "threads", str(available_threads()), "cores this process may use"


WARMUP_EXAMPLES = """\
stickslip warmup
"""


def warmup(*, output: OutputOptions = OutputOptions()) -> None:
    """Compile the kernels of the friction laws that ship into the cache folder.

    Asks one question of each kind: maps, orbits, attractors, bifurcations, sweeps and motions of
    two blocks, of a chain and of a forced oscillator. A wheel with prepared kernels has them.
    """
    seconds = []
    models = _warm_models()
    for ask in tracked(list(models.values()), "compiling"):
        started = time.perf_counter()
        ask()
        seconds.append(round(time.perf_counter() - started, 3))
    lines = map("{:<22} {:6.2f} s\n".format, models, seconds)
    output.tell("warmup", {}, {"model": list(models), "seconds": seconds}, "".join(lines))


def _warm_models() -> dict[str, Callable[[], None]]:
    """Questions by the names of the models that are asked."""
    import stickslip as ss

    laws: dict[str, tuple[FrictionLaw, dict[str, Any]]] = {
        "coulomb": (ss.Coulomb(mu=0.22), {"V": (0.0369, 0.037)}),
        "law9": (ss.PoppStelter(gamma=3.0), {"alpha": (1.2095, 1.2105)}),
        "stribeck": (ss.Stribeck(mu=0.4, speed=0.5), {"V": (0.2, 0.2001)}),
    }
    asked: dict[str, Callable[[], None]] = {"motions that never return": _ask_gap}
    for name, (law, ranges) in laws.items():
        base = ss.examples.coulomb() if name == "coulomb" else ss.examples.law9()
        asked[f"{name}, two blocks"] = partial(_ask_two_blocks, base.replace(friction=law), ranges)
        asked[f"{name}, chain"] = partial(
            _ask_chain, ss.Chain(static=[1.0, 1.1, 1.2], alpha=1.2, V=0.1, friction=law)
        )
        asked[f"{name}, oscillator"] = partial(_ask_oscillator, law)
    return asked


def _ask_gap() -> None:
    import numpy as np

    import stickslip as ss

    law = ss.PoppStelter(gamma=2.8, delta=0.25, eta=0.075)
    f = ss.event_map(ss.TwoBlock(alpha=1.2, beta=0.58, V=0.135, friction=law))
    f.evaluate(np.linspace(*f.domain, 30))


def _ask_two_blocks(model: TwoBlock, ranges: dict[str, Any]) -> None:
    import numpy as np

    import stickslip as ss
    from stickslip.sweeps.system import Run
    from stickslip.sweeps.systems import as_system

    f = ss.event_map(model)
    middle = sum(model.domain) / 2
    f.evaluate([middle])
    f.itinerary(middle)
    f.iterate(middle, 1)
    as_system(model).follow({}, np.array([[middle]]), Run(1, 1, 2, 1), 1)
    for name in model.parameters:
        f.parameter_derivative(middle, name)
    trajectory = ss.simulate(model, d=middle, t_end=20.0)
    trajectory.x([1.0]), trajectory.friction([1.0]), trajectory.energy([1.0])
    ss.branches(f)
    ss.periodic_orbits(f, max_period=2)
    ss.basins(f, resolution=0.01)
    ss.lyapunov_exponent(f, middle, 100)
    for name, span in ranges.items():
        ss.bifurcations(model, name, span, max_period=1)


def _ask_chain(model: Chain) -> None:
    import stickslip as ss

    f = ss.event_map(model)
    start = [0.01, 0.02]
    f.evaluate([start])
    f.iterate(start, 1)
    f.parameter_derivative(start, "V")
    ss.simulate(model, d=start, t_end=20.0)


def _ask_oscillator(law: FrictionLaw) -> None:
    import stickslip as ss

    free = ss.Oscillator(V=0.2, damping=0.05, friction=law)
    ss.find_cycle(free, [0.0], [0.0])
    forced = ss.Oscillator(V=0.2, friction=law, forcing=ss.Harmonic(amplitude=0.3, frequency=1.1))
    ss.stroboscopic_map(forced).evaluate([[0.1, 0.2]])
