"""A user's program: what it calls has types that a strict checker can use (`make types`)."""

# mypy: warn-return-any

from collections.abc import Sequence
from pathlib import Path
from typing import assert_type

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

import stickslip as ss
from stickslip.analysis.orbits.orbit import OrbitList, PeriodicOrbit
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.eventmap.event_map import BlocksEventMap, EventMap

Floats = NDArray[np.float64]


def maps(model: ss.TwoBlock, many: Sequence[float]) -> None:
    f = ss.event_map(model)
    assert_type(f, EventMap)
    assert_type(f(0.1), float)
    assert_type(f(many), Floats)
    assert_type(f(np.linspace(*f.domain, 5)), Floats)
    assert_type(f.derivative(0.1), float)
    assert_type(f.parameter_derivative([0.1, 0.2], "V"), Floats)
    assert_type(f.itinerary(0.1), str)
    assert_type(f.iterate(0.1, 10), Floats)
    assert_type(f.evaluate(many).margin, Floats)
    assert_type(f.power(2)(0.1), float)
    assert_type(f.replace(V=0.04)(0.1), float)
    assert_type(ss.branches(f).plot(), Axes)
    assert_type(float(ss.lyapunov_exponent(f, 0.1)), float)


def orbits(model: ss.TwoBlock) -> PeriodicOrbit:
    found = ss.periodic_orbits(model, max_period=4)
    assert_type(found, OrbitList)
    assert_type(found[0].points, Floats)
    assert_type(found[0].multiplier, float)
    branch = ss.follow(found[0], "V", (0.036, 0.037))
    assert_type(branch.values, Floats)
    for item in ss.bifurcations(model, "V", (0.0366, 0.0372)):
        kind: str = item.kind
        print(kind)
        assert_type(item.value, float)
        assert_type(item.plot(), Axes)
    assert_type(ss.bifurcation_diagram(model, "V", [0.0366, 0.0367]).plot(), Axes)
    return found[0]


def motions(model: ss.TwoBlock) -> None:
    motion = ss.simulate(model, d=0.1, t_end=10)
    assert_type(motion.x(1.0), Floats)
    assert_type(motion.plot(), Axes)
    assert_type(motion.events[0].time, float)
    assert_type([slip.moment for slip in ss.slips(model, d=0.1, t_end=10)], list[float])


def many_blocks() -> None:
    chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.04, friction=ss.Coulomb(mu=0.22))
    f = ss.event_map(chain)
    assert_type(f, EventMap | BlocksEventMap)
    assert_type(f([0.1, -0.2]), Floats)
    block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=0.1)
    cycle = ss.find_cycle(block, [0.0], [0.0])
    assert_type(cycle, Cycle)
    assert_type(cycle.period, float)
    assert_type(cycle.plot(), Axes)
    assert_type(ss.equilibria(block)[0].stable, bool)


def own(path: Path) -> None:
    law = ss.friction_law(lambda s, a: 1 / (1 + a * s), parameters={"a": 3.0})
    assert_type(law.force(0.5), float)
    assert_type(law.force([0.1, 0.5]), Floats)
    tent = ss.PiecewiseMap(lambda x, mu: mu - abs(x), domain=(-1, 1), parameters={"mu": 0.5})
    assert_type(tent(0.1), float)
    ss.write_model(ss.TwoBlock(alpha=1.2, beta=1.3, V=0.04, friction=law), path)


def proofs(model: ss.TwoBlock) -> None:
    proof = ss.certify_orbits(model)
    assert_type(proof.proven, bool)
    assert_type(proof.enclosures["orbits[0].points[0]"], str)
