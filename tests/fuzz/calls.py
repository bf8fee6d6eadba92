"""One good and quick call of everything public that takes an argument."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import Any, Final

from tests.analysis import known_maps as maps

import stickslip as ss
from stickslip.results.result import Result

API: Final = Path(__file__).parents[2] / "docs" / "api.md"

LAW: Final = ss.Coulomb(mu=0.22)
BRIEF: Final = {"n": 8, "transient": 2, "max_period": 2}

# ---------------------------------------------------------------- what methods are called on


def coulomb() -> Any:
    return ss.examples.coulomb()


def chain() -> Any:
    return ss.Chain(static=(1.0, 1.1, 1.2), alpha=1.0, V=0.1, friction=LAW)


def oscillator() -> Any:
    return ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3.0), damping=1.0)


def blocks() -> Any:
    return ss.Blocks([1.0, 2.0], [[2.0, -1.0], [-1.0, 2.0]], static=1.0, friction=LAW, V=0.1)


@cache
def event_map() -> Any:
    return ss.event_map(coulomb(), threads=1)


@cache
def quasistatic() -> Any:
    return ss.quasistatic_map(coulomb(), threads=1)


@cache
def blocks_map() -> Any:
    return ss.event_map(chain(), threads=1)


def logistic() -> Any:
    return maps.logistic(3.2)


def plane() -> Any:
    return ss.Map(
        lambda z, r: r * z * (1 - z), 2, parameters={"r": 3.2}, domain=[(0.0, 1.0), (0.0, 1.0)]
    )


def turning() -> Any:
    return ss.Map(lambda x, w: x + w, 1, parameters={"w": 0.4}, periodic=[1.0])


@cache
def orbits() -> Any:
    return ss.periodic_orbits(logistic(), 2)


@cache
def attractors() -> Any:
    return ss.attractors(logistic(), rng=1)


@cache
def bifurcations() -> Any:
    return ss.bifurcations(logistic(), "r", (2.9, 3.2), max_period=1, n_lists=5)


@cache
def diagram() -> Any:
    return ss.bifurcation_diagram(
        logistic(), "r", [3.0, 3.1, 3.2], n_lists=2, iterates=2, max_period=1
    )


@cache
def orbit_branch() -> Any:
    return ss.follow(orbits()[0], "r", (3.0, 3.3))


@cache
def trajectory() -> Any:
    return ss.simulate(coulomb(), d=0.1, t_end=5.0)


@cache
def cycle() -> Any:
    return ss.find_cycle(oscillator(), [0.9], [0.0])


@cache
def cycles() -> Any:
    return ss.limit_cycles(oscillator(), n_starts=1, rng=1)


@cache
def cycle_branch() -> Any:
    return ss.follow(cycle(), "damping", (0.99, 1.01))


@cache
def trapping() -> Any:
    model = ss.examples.law9()
    return ss.trapping_ball(ss.find_cycle(model, model.onset(0.62), [model.V] * 2))


@cache
def region() -> Any:
    return ss.return_region(coulomb(), "V", (0.45, 0.5), n_values=2, n_points=41)


@cache
def hopf_point() -> Any:
    return ss.equilibria(oscillator())[0].hopf_points[0]


@cache
def neutral() -> Any:
    return ss.equilibria(ss.Oscillator(V=0.2, friction=LAW))[0].neutral_family


def forced() -> Any:
    return oscillator().replace(forcing=ss.Harmonic(0.5, 0.7))


@cache
def stroboscopic() -> Any:
    return ss.stroboscopic_map(forced(), domain=[(-1.0, 1.0), (-1.0, 1.0)])


@cache
def returning() -> Any:
    return ss.return_map(forced())


@cache
def landing() -> Any:
    return ss.return_map(forced(), event="landing", domain=[(0.0, 6.0), (-1.0, 1.0)])


def parabola() -> Any:
    """A map with two parameters: its flips are followed in their plane."""
    return ss.PiecewiseMap(_parabola, (-9.0, 9.0), parameters={"a": 0.75, "b": 0.0})


def _parabola(x: Any, a: float, b: float) -> Any:
    return a - x * x + b * x


@cache
def flip() -> Any:
    return ss.bifurcations(parabola(), "a", (0.6, 0.9), max_period=1, n_lists=3)[0]


@cache
def curve() -> Any:
    return ss.follow(flip(), "b", (-0.1, 0.1), solve_for="a")


@cache
def chain_orbits() -> Any:
    return ss.periodic_orbits(chain(), 1, n_starts=16)


@cache
def chain_branch() -> Any:
    return ss.follow(chain_orbits()[0], "V", (0.1, 0.1003))


# ---------------------------------------------------------------- files


@cache
def _scratch() -> TemporaryDirectory[str]:
    return TemporaryDirectory(prefix="stickslip-fuzz-")


def folder() -> Path:
    """Return an empty folder that goes with the process."""
    return Path(mkdtemp(dir=_scratch().name))


def fresh(name: str) -> Path:
    """Return a path that nobody has used."""
    return folder() / name


@cache
def saved() -> Path:
    path = fresh("saved.json")
    bifurcations().save(path)
    return path


@cache
def model_file() -> Path:
    path = fresh("model.toml")
    ss.write_model(coulomb(), path)
    return path


def points_file() -> Path:
    """Return a file of measurements."""
    path = fresh("points.csv")
    path.write_text("speed,force\n0.1,0.7\n0.2,0.6\n0.3,0.5\n", encoding="utf-8")
    return path


def force_fit() -> Any:
    """Return a fit of a law."""
    points = ss.ForcePoints([0.1, 0.2, 0.3], [0.7, 0.6, 0.5])
    return ss.fit(oscillator(), points, ["gamma"], max_evaluations=5)


def sweep(
    system: Any,
    axes: Any,
    observables: Any,
    *,
    d: Any = None,
    rng: Any = 0,
    chunks: Any = None,
    client: Any = None,
    device: Any = "cpu",
    threads: Any = None,
    storage_options: Any = None,
    progress: Any = None,
) -> Any:
    """Sweep into a store of its own: a second call would only open the first one's."""
    return ss.sweep(**locals(), store=fresh("store"))


@cache
def store() -> Path:
    path = fresh("store")
    ss.sweep(
        logistic(),
        {"r": (3.0, 3.2, 2)},
        [ss.observables.Attractor(**BRIEF)],
        store=path,
        threads=1,
    )
    return path


# ---------------------------------------------------------------- the table

MODEL: Final = {
    "admit": {"d": 0.1},
    "contains": {"d": 0.1},
    "replace": {"V": 0.05},
    "sample_domain": {"n": 2, "rng": 1},
    "sample_state": {"rng": 1},
    "positions": {"d": 0.1},
    "spread_domain": {"n": 2},
    "plant_direction": {"name": "V"},
    "moved_plant": {"name": "V"},
}
FAMILY: Final = {
    **MODEL,
    "admit": {"d": [0.1]},
    "contains": {"d": [0.1]},
    "positions": {"d": [0.1]},
}
CONTACTS: Final = [ss.Contact(at=k, friction=LAW, V=0.1) for k in range(2)]


def structure() -> ss.Structure:
    return ss.Structure([1.0, 2.0], [[2.0, -1.0], [-1.0, 2.0]], contacts=CONTACTS)


WAVE: Final = {"s": 0.1}
LAWS: Final = {"force": WAVE, "slope": WAVE, "static_value": {}}
EVENT_MAP: Final = {
    "__call__": {"d": 0.1},
    "derivative": {"d": 0.1},
    "value_and_derivative": {"d": 0.1},
    "evaluate": {"d": 0.1},
    "iterate": {"d": 0.1, "n": 2},
    "itinerary": {"d": 0.1},
    "parameter_derivative": {"d": 0.1, "name": "V"},
    "power": {"p": 2},
    "preimages": {"x": 0.1},
    "replace": {"V": 0.05},
    "slip_from": {"d": 0.1, "max_events": 100},
}


def of_several(make: Callable[[], Any]) -> dict[str, dict[str, Any]]:
    """Calls of several event maps."""
    call = {"maps": lambda: [make(), make()], "starts": [0.1, 0.2], "n": 2}
    return dict.fromkeys(("follow_each", "iterate_each"), call)


def at_point(d: Any) -> dict[str, dict[str, Any]]:
    """Calls of a return map at a point."""
    names = ("__call__", "derivative", "value_and_derivative", "evaluate", "itinerary", "state")
    return {
        **{name: {"d": d} for name in names},
        "begun": {"d": d},
        "iterate": {"d": d, "n": 2},
        "parameter_derivative": {"d": d, "name": "V"},
        "point": {"x": [0.9], "v": [0.2], "t": 0.0},
        "replace": {"V": 0.05},
        "slip_from": {"d": d, "max_events": 100},
        "turned": {"d": d},
    }


AT_TIME: Final = {name: {"t": 1.0} for name in ("energy", "friction", "needed_force", "v", "x")}
STATE: Final = {"x": [0.9], "v": [0.1]}
ALONG: Final = {"name": "r", "range": (3.0, 3.3)}
UNITS: Final = {"units": lambda: ss.Units(m=2.0, k=8.0, fs1=4.0)}
SAVE: Final = {"save": {"path": fresh("result.json")}}

FUNCTIONS: Final[dict[str, dict[str, Any]]] = {
    "Blocks": {
        "mass": [1.0, 2.0],
        "stiffness": [[2.0, -1.0], [-1.0, 2.0]],
        "static": [1.0, 1.0],
        "friction": LAW,
        "V": 0.1,
    },
    "Chain": {"static": (1.0, 1.1, 1.2), "alpha": 1.0, "V": 0.1, "friction": LAW},
    "Contact": {"at": 0, "friction": LAW, "V": 0.1},
    "Coulomb": {"mu": 0.2},
    "Harmonic": {"amplitude": 0.1, "frequency": 1.0},
    "Oscillator": {"V": 0.2, "friction": LAW},
    "Map": {
        "func": lambda z, r=1.0: r * z * (1 - z),
        "dimension": 2,
        "parameters": {"r": 3.0},
        "domain": [(0.0, 1.0), (0.0, 1.0)],
        "periodic": [None, 1.0],
    },
    "PiecewiseMap": {
        "func": lambda x, r=1.0: r * x * (1 - x),
        "domain": (0.0, 1.0),
        "parameters": {"r": 3.0},
    },
    "PoppStelter": {"gamma": 3.0},
    "Stribeck": {"mu": 0.3, "speed": 0.1},
    "Structure": {
        "mass": [1.0, 2.0],
        "stiffness": [[2.0, -1.0], [-1.0, 2.0]],
        "contacts": CONTACTS,
    },
    "Structure.from_state_space": {
        "A": [[0.0, 1.0], [-1.0, -0.1]],
        "B": [[0.0], [1.0]],
        "C": [[0.0, 1.0]],
        "contacts": CONTACTS[:1],
    },
    "TabulatedFriction": {"speed": [0.0, 0.1, 0.2], "force": [1.0, 0.8, 0.7]},
    "TwoBlock": {"alpha": 1.2, "beta": 1.3, "V": 0.1, "friction": LAW},
    "TwoBlock.from_physical": {
        "m": 1.0,
        "k": 2.0,
        "k12": 1.0,
        "fs1": 1.0,
        "fs2": 1.2,
        "v_dr": 0.1,
        "friction": LAW,
    },
    "Units": {"m": 1.0, "k": 2.0, "fs1": 3.0},
    "Record": {"t": [0.0, 1.0, 2.0, 3.0, 4.0], "x": [0.0, 0.1, 0.2, 0.1, 0.3], "sigma": 0.1},
    "EventTimes": {"times": [1.0, 2.0], "d": 0.1},
    "MapPoints": {"d": [0.1, 0.2], "value": [0.2, 0.3]},
    "CyclePeriods": {"V": [0.1, 0.2], "period": [9.0, 8.0]},
    "ForcePoints": {"speed": [0.1, 0.2, 0.3], "force": [0.3, 0.25, 0.2]},
    "fit": {
        "model": oscillator,
        "data": lambda: ss.ForcePoints([0.1, 0.2, 0.3], [0.7, 0.6, 0.5]),
        "parameters": ["gamma"],
        "max_evaluations": 5,
    },
    "compare_fits": {"fits": lambda: {"a": force_fit(), "b": force_fit()}, "left_out": False},
    "propagate": {
        "system": logistic,
        "draws": {"r": [3.1, 3.2]},
        "quantity": "coexisting_attractors",
        "variable": "left_share",
        "rng": 1,
    },
    "attractors": {"f": logistic, "n_starts": 4, "max_steps": 100, "rng": 1},
    "rotation_number": {"f": turning, "x0": 0.1, "n": 8, "transient": 2},
    "basin_fractions": {
        "system": plane,
        "parameter": "r",
        "values": [3.1, 3.2],
        "n_samples": 8,
        "n_starts": 2,
    },
    "safety": {
        "system": logistic,
        "parameter": "r",
        "values": [3.1],
        "attractor": 0,
        "kicks": 0.1,
        "distribution": "normal",
        "within": 5,
        "n_runs": 5,
        "n_samples": 16,
        "n_impulses": 0,
        "tolerance": 1e-3,
        "rng": 1,
    },
    "axis": {"lo": 0.1, "hi": 0.2, "n": 3},
    "basins": {"f": logistic, "found": attractors, "resolution": 1e-3, "n_samples": 20, "rng": 1},
    "bifurcation_diagram": {
        "system": logistic,
        "parameter": "r",
        "grid": [3.0, 3.1],
        "n_lists": 2,
        "iterates": 2,
        "max_period": 1,
    },
    "bifurcations": {
        "system": logistic,
        "parameter": "r",
        "range": (2.9, 3.2),
        "max_period": 1,
        "n_lists": 3,
    },
    "branches": {"f": maps.tent},
    "breakpoints": {"f": maps.tent},
    "certify": {"found": lambda: ss.periodic_orbits(event_map())[0], "model": coulomb, "digits": 5},
    "certify_basins": {"model": coulomb, "share": 0.1},
    "certify_chaos": {"model": coulomb, "d": 0.1},
    "certify_entropy": {
        "model": lambda: ss.PiecewiseMap(["2*x", "2 - 2*x"], (0.0, 1.0), breakpoints=[0.5])
    },
    "certify_orbits": {"model": coulomb, "digits": 5},
    "enclose": {"model": coulomb, "d": "0.1"},
    "equilibria": {"model": oscillator},
    "event_map": {"model": coulomb, "threads": 1},
    "examples.coulomb": {"V": 0.1},
    "examples.law9": {"V": 0.1},
    "explore": {"model": None},
    "find_cycle": {"model": oscillator, **STATE, "max_events": 200},
    "follow": {
        "thing": lambda: orbits()[0],
        "parameter": "r",
        "range": (3.15, 3.25),
        "solve_for": None,
        "window": None,
        "max_step": 0.1,
        "max_points": 10,
    },
    "friction_law": {"force": lambda s, mu=0.2: mu, "parameters": {"mu": 0.3}},
    "invariant_density": {
        "f": lambda: maps.tent(1.9),
        "attractor": lambda: ss.attractors(maps.tent(1.9), rng=1)[0],
        "cells": 100,
    },
    "limit_cycles": {"model": oscillator, "n_starts": 1, "max_events": 100, "rng": 1},
    "load": {"path": saved},
    "lyapunov_exponent": {"f": logistic, "d": 0.1, "n": 50, "transient": 5},
    "lyapunov_spectra": {
        "system": chain,
        "parameter": "V",
        "grid": [0.1, 0.11],
        "x0": [0.1, 0.2],
        "n": 5,
        "transient": 2,
    },
    "lyapunov_spectrum": {"f": chain, "x0": [0.1, 0.2], "n": 5, "transient": 2},
    "observables.Attractor": BRIEF,
    "observables.CoexistingAttractors": {**BRIEF, "n_starts": 2},
    "observables.Events": BRIEF,
    "observables.Function": {"function": "tests.sweeps.small:start_of"},
    "observables.LimitCycles": {"n_starts": 1, "max_events": 100},
    "observables.LyapunovExponent": BRIEF,
    "observables.NeverReturns": {"n_starts": 2, "n": 3},
    "observables.OrbitPoints": {**BRIEF, "count": 2},
    "observables.as_observables": {"given": ["attractor"]},
    "open_sweep": {"store": store},
    "periodic_orbits": {"f": logistic, "max_period": 2},
    "quasistatic_map": {"model": coulomb, "threads": 1},
    "read_measurements": {"path": points_file},
    "read_model": {"path": model_file},
    "return_region": {
        "model": coulomb,
        "parameter": "V",
        "range": (0.03, 0.04),
        "n_values": 2,
        "n_points": 5,
        "max_events": 100,
    },
    "simulate": {"model": oscillator, **STATE, "t_end": 5.0, "max_events": 100},
    "slips": {"model": oscillator, **STATE, "t_end": 5.0, "max_events": 100},
    "return_map": {"model": forced, "contact": 0, "event": "release", "max_events": 100},
    "stroboscopic_map": {"model": coulomb, "period": 2.0},
    "sweep": {
        "system": logistic,
        "axes": {"r": (3.0, 3.2, 2)},
        "observables": lambda: [ss.observables.Attractor(**BRIEF)],
        "threads": 1,
    },
    "trapping_ball": {"cycle": cycle},
    "write_model": {"model": coulomb, "path": fresh("written.toml")},
    "zero_one_test": {"series": [0.1, 0.2] * 50, "n_frequencies": 3, "rng": 1},
}
"""Arguments of a good call; those that are functions without parameters are called first."""

METHODS: Final[dict[str, tuple[Callable[[], Any], dict[str, dict[str, Any]]]]] = {
    "Blocks": (blocks, FAMILY),
    "Chain": (
        chain,
        {**FAMILY, **{n: {"d": [0.1, 0.1]} for n in ("admit", "contains", "positions")}},
    ),
    "Oscillator": (
        oscillator,
        {**FAMILY, **{n: {"d": []} for n in ("admit", "contains", "positions")}},
    ),
    "Harmonic": (lambda: ss.Harmonic(0.1, 1.0), {"amplitudes": {"n_blocks": 2}}),
    "Structure": (
        structure,
        {
            **FAMILY,
            "replace": {"V_1": 0.05},
            "plant_direction": {"name": "V_1"},
            "moved_plant": {"name": "V_1"},
        },
    ),
    "TwoBlock": (
        coulomb,
        {
            **MODEL,
            "onset": {"d": 0.1},
            "physical_parameters": {"units": ss.Units(m=1.0, k=2.0, fs1=3.0)},
            "to_physical": {"trajectory": trajectory, "units": ss.Units(m=1.0, k=2.0, fs1=3.0)},
        },
    ),
    "Units": (
        lambda: ss.Units(m=1.0, k=2.0, fs1=3.0),
        {
            "scale": {"quantity": "displacement"},
            "to_dimensionless": {"quantity": "displacement", "value": 0.1},
            "to_physical": {"quantity": "displacement", "value": 0.1},
        },
    ),
    "Coulomb": (
        lambda: LAW,
        {**LAWS, "replace": {"mu": 0.3}, "from_values": {"values": {"mu": 0.2}}},
    ),
    "PoppStelter": (
        lambda: ss.PoppStelter(gamma=3.0),
        {**LAWS, "replace": {"gamma": 2.0}, "from_values": {"values": {"gamma": 2.0}}},
    ),
    "Stribeck": (
        lambda: ss.Stribeck(mu=0.3, speed=0.1),
        {**LAWS, "replace": {"mu": 0.2}, "from_values": {"values": {"mu": 0.2, "speed": 0.1}}},
    ),
    "TabulatedFriction": (
        lambda: ss.TabulatedFriction([0.0, 0.1, 0.2], [1.0, 0.8, 0.7]),
        {
            **LAWS,
            "replace": {"force": [1.0, 0.9, 0.8]},
        },
    ),
    "Map": (
        plane,
        {
            "__call__": {"x": [0.1, 0.2]},
            "contains": {"x": [0.1, 0.2]},
            "derivative": {"x": [0.1, 0.2]},
            "evaluate": {"x": [0.1, 0.2]},
            "iterate": {"x": [0.1, 0.2], "n": 2},
            "parameter_derivative": {"x": [0.1, 0.2], "name": "r"},
            "replace": {"r": 3.0},
            "spread": {"count": 4},
            "turned": {"x": [0.1, 0.2]},  # of no angle
        },
    ),
    "PiecewiseMap": (
        logistic,
        {
            "__call__": {"x": 0.1},
            "derivative": {"x": 0.1},
            "evaluate": {"x": 0.1},
            "iterate": {"x": 0.1, "n": 2},
            "parameter_derivative": {"x": 0.1, "name": "r"},
            "power": {"p": 2},
            "preimages": {"x": 0.1},
            "replace": {"r": 3.0},
        },
    ),
    "EventMap": (
        event_map,
        {
            **EVENT_MAP,
            "after_impulse": {"d": 0.1, "block": 1, "by": 0.01},
            **of_several(event_map),
        },
    ),
    "QuasistaticMap": (
        quasistatic,
        {
            **EVENT_MAP,
            **of_several(quasistatic),
            "replace": {"alpha": 1.1},
            "parameter_derivative": {"d": 0.1, "name": "alpha"},
            "slips": {"d": 0.1},
        },
    ),
    "BlocksEventMap": (
        blocks_map,
        {
            "__call__": {"d": [0.1, 0.1]},
            "contains": {"d": [0.1, 0.1]},
            "evaluate": {"d": [0.1, 0.1]},
            "iterate": {"d": [0.1, 0.1], "n": 2},
            "itinerary": {"d": [0.1, 0.1]},
            "derivative": {"d": [0.1, 0.1]},
            "value_and_derivative": {"d": [0.1, 0.1]},
            "parameter_derivative": {"d": [0.1, 0.1], "name": "V"},
            "replace": {"V": 0.05},
            "slip_from": {"d": [0.1, 0.1], "max_events": 100},
            "spread": {"n": 2},
            "after_impulse": {"d": [0.1, 0.1], "block": 3, "by": 0.01},
        },
    ),
    "Certificate": (lambda: ss.certify_orbits(coulomb(), digits=5), SAVE),
    "Trajectory": (
        trajectory,
        {**AT_TIME, "table": {"t": [1.0], "energy": False}, "derivative": {"names": "mu"}},
    ),
    "Record": (
        lambda: ss.Record([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 0.1, 0.2, 0.1, 0.3]),
        {"to_dimensionless": UNITS},
    ),
    "EventTimes": (lambda: ss.EventTimes([1.0, 2.0], d=0.1), {"to_dimensionless": UNITS}),
    "CyclePeriods": (lambda: ss.CyclePeriods([0.1], [9.0]), {"to_dimensionless": UNITS}),
    "MapPoints": (lambda: ss.MapPoints([0.1], [0.2]), {"to_dimensionless": UNITS}),
    "ForcePoints": (lambda: ss.ForcePoints([0.1], [0.2]), {"to_dimensionless": UNITS}),
    "Fit": (
        force_fit,
        {
            "misfit": {"data": lambda: ss.ForcePoints([0.1, 0.5], [0.8, 0.5])},
            "predict": {"quantity": lambda: lambda model: model.friction.gamma},
            "profile": {"name": "gamma", "values": [2.9, 3.1]},
            "sample": {"n": 5, "rng": 1},
        },
    ),
    "Sensitivity": (
        lambda: trajectory().derivative("mu", "d"),
        {
            "x": {"t": 1.0, "side": "left"},
            "v": {"t": 1.0, "side": "left"},
            "states": {"t": 1.0, "side": "left"},
        },
    ),
    "PhysicalTrajectory": (
        lambda: coulomb().to_physical(trajectory(), ss.Units(m=2.0, k=8.0, fs1=4.0)),
        {name: AT_TIME[name] for name in ("energy", "friction", "v", "x")},
    ),
    "BreakpointList": (lambda: ss.breakpoints(maps.tent()), {"of_kind": {}}),
    "OrbitList": (orbits, {"of_period": {"p": 1}}),
    "Attractor": (lambda: attractors()[0], {"contains": {"x": 0.1, "slack": 0.0}}),
    "Basins": (
        lambda: ss.basins(logistic()),
        {
            "at": {"x": 0.1},
            "share": {"attractor": 0},
            "proved": {"attractor": 0},
            "sampled": {"attractor": 0},
        },
    ),
    "AttractorListND": (lambda: ss.attractors(plane(), n_starts=4), SAVE),
    "BasinsND": (
        lambda: ss.basins(plane(), n_samples=16),
        {**SAVE, "share": {"attractor": -2}},
    ),
    "BasinFractions": (
        lambda: ss.basin_fractions(plane(), "r", [3.1], n_samples=8, n_starts=2),
        {**SAVE, "share": {"number": 0}},
    ),
    "Safety": (lambda: ss.safety(logistic(), n_samples=16), SAVE),
    "Settling": (
        lambda: ss.safety(logistic(), n_samples=16).settling,
        {"quantile": {"share": 0.5}},
    ),
    "SafetyList": (lambda: ss.safety(logistic(), "r", [3.1], n_samples=16), SAVE),
    "InvariantDensity": (
        lambda: ss.invariant_density(maps.tent(1.9), ss.attractors(maps.tent(1.9))[0], cells=50),
        {"__call__": {"x": 0.5}, "cumulative": {"x": 0.5}, "mean": {"func": abs}},
    ),
    "Cycle": (cycle, {**SAVE, "period_derivative": {"names": "V"}, "derivative": {"names": "V"}}),
    "CycleList": (cycles, SAVE),
    "Curve of cycles": (cycle_branch, {**SAVE, "at": {"damping": 1.005}}),
    "TrappingBall": (
        trapping,
        {"entered": {"x": [0.1, 0.2], "v": [0.0, 0.0], "max_events": 10}},
    ),
    "ReturnRegion": (region, {**SAVE, "attracting": {"curve": 0}}),
    "HopfPoint": (hopf_point, {"amplitude": {"V": 0.9}, "state": {"amplitude": 0.1}}),
    "NeutralFamily": (neutral, {"amplitudes": STATE, "clearance": STATE}),
    "StroboscopicMap": (
        stroboscopic,
        {
            "__call__": {"d": [0.1, 0.1]},
            "diagram": {
                "parameter": "V",
                "grid": [0.1, 0.2],
                "state": [0.1, 0.1],
                "transient": 2,
                "n": 2,
            },
            "iterate": {"d": [0.1, 0.1], "n": 2},
            "contains": {"d": [0.1, 0.1]},
            "evaluate": {"d": [0.1, 0.1]},
            "spread": {"n": 2},
            "derivative": {"d": [0.1, 0.1]},
            "value_and_derivative": {"d": [0.1, 0.1]},
            "itinerary": {"d": [0.1, 0.1]},
            "slip_from": {"d": [0.1, 0.1], "max_events": 100},
            "parameter_derivative": {"d": [0.1, 0.1], "name": "V"},
            "periodic_point": {"state": [0.1, 0.1], "max_periods": 20},
            "replace": {"V": 0.1},
        },
    ),
    "ReturnMap": (
        landing,
        {**at_point([1.0, 0.1]), "contains": {"d": [1.0, 0.1]}, "spread": {"n": 3}},
    ),
    "LineReturnMap": (
        returning,
        {
            **EVENT_MAP,
            **at_point(1.0),
            # where `state` has the phase 1
            "point": {"x": [1.07015115293407], "v": [0.2], "t": 1.4285714285714286},
        },
    ),
    "Bifurcation": (lambda: bifurcations()[0], SAVE),
    "BifurcationList": (bifurcations, {**SAVE, "of_kind": {}}),
    "Curve": (orbit_branch, {**SAVE, "at": {"r": 3.1, "near": None}, "all_at": {"r": 3.1}}),
    "PeriodicOrbitND": (lambda: chain_orbits()[0], SAVE),
    "OrbitListND": (chain_orbits, {**SAVE, "of_period": {"p": 1}}),
    "Curve of orbits in R^n": (chain_branch, {**SAVE, "at": {"V": 0.1001}}),
    "Curve of bifurcations": (curve, {**SAVE, "at": {"b": 0.05, "near": None}}),
    "Diagram": (diagram, {**SAVE, "of_period": {"p": 1}}),
}
"""By class: an object of it, and arguments of a good call of each method."""

LEFT: Final = {
    "QuasistaticMap.after_impulse": "refuses: there is no moving belt",
    "TabulatedFriction.from_values": "a table has no parameters",
    "FrictionLaw": "what laws are made of; tests/contracts",
    "plot": "draws; tests/plot",
    "carry": "kernels' side of the map, takes checked arrays",
    "count": "of tuples",
    "index": "of tuples",
    "compute": "called by sweeps",
    "add_note": "of exceptions",
    "with_traceback": "of exceptions",
    "expression": "traced with symbols, not called with numbers",
    "explain_break": "asked by the analysis, with points that it found",
    "explain_border": "asked by the analysis, with points that it found",
    "labels_at": "asked by the analysis, with points that it found",
    "matters": "asked by the analysis, with laps that it found",
    "text": "asked by the analysis, with labels that it found",
    "get": "of mappings",
    "as_html": "asked by results",
}
"""Methods that are not called, and why."""


class Call:
    """A function or method, and arguments of a good call of it."""

    def __init__(self, name: str, target: Callable[[], Any], given: dict[str, Any]) -> None:
        self.name = name
        self._target = target
        self._given = given

    @property
    def target(self) -> Callable[..., Any]:
        return self._target()

    def parameters(self) -> dict[str, inspect.Parameter]:
        """Of the signature, without those that stand for any others."""
        return {
            name: parameter
            for name, parameter in inspect.signature(self.target).parameters.items()
            if parameter.kind is not parameter.VAR_KEYWORD
        }

    def arguments(self) -> dict[str, Any]:
        """Return a good argument for each parameter that has one, made anew."""
        return {name: made(value) for name, value in self._given.items()}

    def names(self) -> tuple[str, ...]:
        """Return what may be given: the signature's parameters and the keywords of the table."""
        return tuple(dict.fromkeys((*self.parameters(), *self._given)))

    def __call__(self, changes: dict[str, Any]) -> Any:
        """Call with some arguments replaced."""
        given = {**self.arguments(), **changes}
        target = self.target
        by_place = [
            given.pop(name)
            for name, parameter in inspect.signature(target).parameters.items()
            if parameter.kind is parameter.POSITIONAL_ONLY and name in given
        ]
        starred = [
            given.pop(name)
            for name, parameter in inspect.signature(target).parameters.items()
            if parameter.kind is parameter.VAR_POSITIONAL and name in given
        ]
        return target(*by_place, *starred, **given)


def made(value: Any) -> Any:
    """Call what makes an argument; user functions, which take arguments, are arguments."""
    if not inspect.isfunction(value) and not hasattr(value, "cache_info"):
        return value
    needed = inspect.signature(value).parameters.values()
    return value if any(p.default is p.empty for p in needed) else value()


def calls() -> dict[str, Call]:
    """Return every call of the table by the name of what it calls."""
    named = {name: Call(name, lambda n=name: found(n), given) for name, given in FUNCTIONS.items()}
    for kind, (make, methods) in METHODS.items():
        for method, given in methods.items():
            name = f"{kind}.{method}"
            named[name] = Call(name, lambda mk=make, mt=method: getattr(mk(), mt), given)
    return named


def found(name: str) -> Any:
    """Return what a public name means; the sweep of the table has a store of its own."""
    if name == "sweep":
        return sweep
    thing: Any = ss
    for part in name.split("."):
        thing = getattr(thing, part)
    return thing


# ---------------------------------------------------------------- what the table must hold


def public() -> Iterator[str]:
    """Yield the name of everything public that takes an argument, as the table writes it."""
    # Exceptions are raised, not called; pictures are tried in tests/plot.
    for name in sorted(set(ss.__all__) - {"FrictionLaw", "errors", "plot"}):
        thing = getattr(ss, name)
        if inspect.ismodule(thing):
            members = getattr(thing, "__all__", ())
            yield from (f"{name}.{m}" for m in members if _is_called(f"{name}.{m}"))
        else:
            yield name
            if inspect.isclass(thing):
                yield from _methods(thing)
    for name in re.findall(r"^   ([\w.]+)\.(\w+)$", API.read_text(encoding="utf-8"), re.M):
        yield from _methods(getattr(importlib.import_module(f"stickslip.{name[0]}"), name[1]))


def _is_called(name: str) -> bool:
    thing = found(name)
    return callable(thing) and name not in ("observables.Observable", "observables.Output")


def _methods(kind: type) -> Iterator[str]:
    for name, method in inspect.getmembers(kind):
        is_public = name == "__call__" or not name.startswith("_")
        if not is_public or not LEFT.keys().isdisjoint((name, f"{kind.__name__}.{name}")):
            continue
        if getattr(Result, name, None) is method:
            continue  # what every result has is tried with those of the table
        bound = inspect.ismethod(method)
        if (bound or inspect.isfunction(method)) and len(
            inspect.signature(method).parameters
        ) > 1 - bound:
            yield f"{kind.__name__}.{name}"
