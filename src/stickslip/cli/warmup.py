"""``stickslip warmup``: compile the kernels now rather than at the first question."""

from __future__ import annotations

import time

from stickslip.cli import columns
from stickslip.cli.options import OutputOptions
from stickslip.cli.progress import tracked

EXAMPLES = """\
stickslip warmup
"""

PRESETS = ("coulomb", "law9")


def command(*, output: OutputOptions = OutputOptions()) -> None:
    """Compile the kernels of event maps, sweeps and trajectories into the cache folder."""
    seconds = []
    for preset in tracked(PRESETS, len(PRESETS), "compiling", quiet=output.quiet):
        started = time.perf_counter()
        _use(preset)
        seconds.append(round(time.perf_counter() - started, 3))
    if output.json:
        print(columns.document("warmup", {}, {"preset": PRESETS, "seconds": seconds}), end="")
        return
    for preset, spent in zip(PRESETS, seconds, strict=True):
        print(f"{preset:<8} {spent:6.2f} s")


def _use(preset: str) -> None:
    """Ask one of everything that compiles."""
    import numpy as np

    import stickslip as ss
    from stickslip.sweeps.orbits import Run
    from stickslip.sweeps.systems import as_system

    model = getattr(ss.examples, preset)()
    f = ss.event_map(model)
    middle = sum(model.domain) / 2
    f.evaluate([middle])
    f.itinerary(middle)
    f.iterate(middle, 1)
    as_system(model).follow({}, np.array([[middle]]), Run(1, 1, 2, 1), 1)
    for name in model.parameters:
        f.parameter_derivative(middle, name)
    ss.simulate(model, d=middle, t_end=1.0)
