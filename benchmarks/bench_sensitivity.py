"""Time derivatives of motions beside the motions, and columns of tangents beside an adjoint."""

import numpy as np
import pytest
from benchmarks.fit_coverage import CASES, DRILL_STRING
from benchmarks.measure import CPU, in_turns

import stickslip as ss

FIVE = "Derivatives of a motion in five numbers, one core"
MANY = "Columns of tangents of a chain of ten blocks, one core"
T_END = 300.0
REST = {"x": [0.0], "v": [0.0]}
SYSTEMS = {
    "Coulomb": (ss.examples.coulomb(), ("V", "alpha", "beta", "mu", "d"), {"d": 0.3}),
    "law (9)": (ss.examples.law9(), ("V", "alpha", "beta", "gamma", "d"), {"d": 0.3}),
    "oscillator": (CASES["oscillator"].model, ("mu", "speed", "damping", "V", "x0"), REST),
    "drill string": (
        DRILL_STRING,
        ("mu_1", "speed_1", "static_1", "viscous_1", "x0_1"),
        {"x": [0.0, 0.0], "v": [0.0, 0.0]},
    ),
}


def chain() -> ss.Structure:
    """Ten blocks, each with numbers of its own."""
    n, rng = 10, np.random.default_rng(1)
    springs = rng.uniform(1.0, 1.4, n - 1)
    stiffness = np.eye(n) - np.diag(springs, 1) - np.diag(springs, -1)
    stiffness += np.diag(np.append(springs, 0.0) + np.append(0.0, springs))
    contacts = [
        ss.Contact(
            at=k,
            friction=ss.Stribeck(mu=rng.uniform(0.3, 0.5), speed=rng.uniform(0.2, 0.4)),
            V=0.1,
            static=rng.uniform(0.8, 1.2),
        )
        for k in range(n)
    ]
    masses, dampers = np.diag(rng.uniform(0.8, 1.2, n)), np.diag(rng.uniform(0.02, 0.1, n))
    return ss.Structure(masses, stiffness, damping=dampers, contacts=contacts)


def numbers(model: ss.Structure, n: int) -> list[str]:
    """Name the first parameters of a chain that are not 0: of each kind, block after block."""
    kinds = ("static", "mu", "speed", "damping", "stiffness", "mass", "V")
    blocks = range(1, len(model.mass) + 1)
    names = [
        f"{kind}_{k}_{k}" if kind in ("damping", "stiffness", "mass") else f"{kind}_{k}"
        for kind in kinds
        for k in blocks
    ]
    return names[:n]


@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.benchmark(timer=CPU, group="derivatives in time")
def bench_five_numbers(benchmark, report, system):
    model, names, start = SYSTEMS[system]
    motion = ss.simulate(model, t_end=T_END, **start)
    pairs = in_turns(
        benchmark,
        lambda: motion.derivative(*names),
        lambda: ss.simulate(model, t_end=T_END, **start),
    )
    report.add(
        FIVE,
        system=system,
        events=len(motion.events),
        **{
            "motion, ms": 1e3 * float(np.median(pairs.other)),
            "derivatives, ms": 1e3 * float(np.median(pairs.ours)),
            "times the motion": 1.0 / pairs.ratio(),
            "three motions over it": pairs.ratio(3.0),
        },
    )


@pytest.mark.parametrize("n", [1, 5, 20, 50])
@pytest.mark.benchmark(timer=CPU, group="derivatives in time")
def bench_columns(benchmark, report, n):
    model = chain()
    x, v = np.random.default_rng(2).uniform(-0.3, 0.3, 10), np.zeros(10)
    motion = ss.simulate(model, x, v, t_end=40.0)
    names = numbers(model, n)
    pairs = in_turns(
        benchmark,
        lambda: motion.derivative(*names),
        lambda: ss.simulate(model, x, v, t_end=40.0),
    )
    times = 1.0 / pairs.ratio()
    report.add(
        MANY,
        columns=n,
        **{
            "times the motion": times,
            "of it, a column": times / n,
            "differences (two motions a column), over it": 2.0 * n / times,
        },
    )
