"""What is said of hunting, checked by the axis's return map and beside bristles."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Final

import numpy as np

from stickslip.analysis.diagrams.diagram import Diagram
from stickslip.analysis.diagrams.diagrams import bifurcation_diagram
from stickslip.analysis.orbits.orbit import OrbitList
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.mechanics.model.contact import Contact, Harmonic
from stickslip.mechanics.model.structure import Structure
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.hunting_axis import axis
from stickslip.studies.smoothed import smoothed

NOT_READ: Final = "sources not read; model as commonly quoted, gains chosen here"
HERE: Final = "computed here; docs/studies/hunting_axis.md"
CLOSE: Final = 1e-12
GAINS: Final = (0.5, 1.0, 2.0, 4.0, 6.0, 8.0, 9.5, 11.0)
DROPS: Final = (0.4, 0.1, 0.01, 1e-3)
LIMIT: Final = float(axis.PROPORTIONAL * axis.DERIVATIVE)
"""Integral gain up to which the axis is stable without friction."""
STIFF: Final = (1e2, 1e3, 1e4, 1e5)
PUSH: Final = (0.6, 0.3)
PUSHES: Final = 50


@cache
def cycles(gain: float, mu: float = axis.KINETIC) -> OrbitList:
    """Find all orbits up to period 2 of the return map."""
    found: OrbitList = periodic_orbits(axis.axis_map(gain, mu), max_period=2)
    return found


@cache
def diagram() -> Diagram:
    """All orbits along the integral gain."""
    f = axis.axis_map(4.0)
    return bifurcation_diagram(f, axis.GAIN, (-max(GAINS), -min(GAINS), 25), max_period=2)


def _map() -> Iterator[Claim]:
    counts = {drop: len(cycles(4.0, 1.0 - drop)) for drop in DROPS}
    sizes = [float(cycles(4.0, 1.0 - drop)[0].points[0]) / drop for drop in DROPS]
    yield claim(
        "hunting.condition",
        NOT_READ,
        "The axis hunts if and only if friction at rest exceeds friction in motion",
        Finding(
            "each excess gives one cycle, in proportion to it",
            f"{len(DROPS)} excesses from {DROPS[0]:g} to {DROPS[-1]:g}: "
            f"{', '.join(map(str, counts.values()))} orbits; distance over excess varies by "
            f"{np.ptp(sizes) / sizes[0]:.0e} of itself",
            set(counts.values()) == {1} and bool(np.ptp(sizes) <= 1e-9 * sizes[0]),
        ),
        _no_excess(),
        mechanism="a release at rest has the acceleration -excess, which carries it past the goal",
    )
    x = np.linspace(0.002, 0.058, 15)
    apart = [
        abs(axis.axis_map(4.0)(x0) + axis.half_map(4.0, -axis.half_map(4.0, x0)))
        for x0 in x.tolist()
    ]
    yield claim(
        "hunting.map",
        HERE,
        "One release to the next is a map of one number in closed form",
        Finding(
            "followed event by event it is the formula",
            f"{x.size} points differ by {max(apart):.0e} at most",
            max(apart) <= CLOSE,
        ),
    )


def _no_excess() -> Finding:
    # As a section starts at rest at its limit: without excess the way there has no size.
    x = np.linspace(0.005, 0.05, 10)
    shrinks = np.asarray(axis.axis_map(8.0, mu=1.0)(x)) / x
    ratio = axis.half_map(8.0, 1.0, 0.0)
    return Finding(
        "without excess there is none: distances shrink by one and the same factor",
        f"by {shrinks[0]:.12f}, in closed form {ratio**2:.12f}",
        bool(np.abs(shrinks / ratio**2 - 1.0).max() <= 1e-11) and abs(ratio) < 1.0,
    )


def _gains() -> Iterator[Claim]:
    found = {gain: cycles(gain) for gain in GAINS}
    errors = []
    for gain, (orbit,) in found.items():
        exact, f = axis.hunting(gain), axis.axis_map(gain)
        errors.append(abs(orbit.points[0] / exact.distance - 1.0))
        errors.append(abs(orbit.multiplier - exact.multiplier))
        errors.append(abs(f.evaluate(orbit.points[0]).duration / exact.period - 1.0))
    beyond = [gain for gain in GAINS if gain > LIMIT]
    curves = diagram().orbits
    ends = sorted({end.reason for curve in curves for end in curve.ends})
    yield claim(
        "hunting.amplitude",
        HERE,
        "Distance, period and multiplier of hunting solve one equation in the time of a slip",
        Finding(
            "the map's only orbit has them",
            f"{len(GAINS)} integral gains, relative errors up to {max(errors):.0e}",
            max(errors) <= CLOSE,
        ),
        Finding(
            "nothing else happens along the gain: no bifurcation, no second orbit",
            f"{len(curves)} orbit between {min(GAINS):g} and {max(GAINS):g}, whose ends are: "
            f"{', '.join(ends)}",
            len(curves) == 1 and ends == ["end of range"],
        ),
        values=tuple(
            Value(f"distance, gain {gain:g}", orbits[0].points[0], 1e-14, 2, "return map")
            for gain, orbits in found.items()
        ),
    )
    limits = [
        float(np.ptp([axis.hunting(g).distance for g in (0.01, 0.5)])) / axis.hunting(0.5).distance
    ]
    yield claim(
        "hunting.gain",
        HERE,
        "Less integral gain makes hunting slower, not smaller",
        Finding(
            "the distance hardly changes where the period grows without bound",
            f"from gain 0.5 to 0.01 by {limits[0]:.1%}, the period from "
            f"{axis.hunting(0.5).period:.0f} to {axis.hunting(0.01).period:.0f}",
            limits[0] < 0.05 and axis.hunting(0.01).period > 30.0 * axis.hunting(0.5).period,
        ),
        Finding(
            "hunting attracts beyond the gain at which the axis without friction is unstable",
            f"limit {LIMIT:g}; multipliers at "
            f"{', '.join(f'{g:g}: {found[g][0].multiplier:.4f}' for g in beyond)}",
            all(found[gain][0].stable for gain in beyond),
        ),
    )


def _bristles() -> Iterator[Claim]:
    exact = axis.hunting(-axis.MODEL.parameters[axis.GAIN])
    runs = [axis.bristles(stiffness) for stiffness in STIFF]
    told = "; ".join(
        f"stiffness {run.stiffness:.0e}: {run.amplitude / exact.distance - 1.0:+.1%}, "
        f"{run.evaluations * exact.period / run.t[-1]:.0f} evaluations a period"
        for run in runs
    )
    smooth = smoothed(axis.MODEL, 1e-4, np.zeros(0), np.array([0.0, 0.05, 0.0]), axis.WATCHED)
    left = float(np.abs(smooth.v[smooth.t > 0.9 * axis.WATCHED, 1]).max())
    yield claim(
        "hunting.bristles",
        HERE,
        "Friction made smooth hunts by another amount, or not at all",
        Finding(
            "LuGre's friction with soft bristles comes to the goal; with stiff ones it hunts",
            f"amplitude beside the exact one, {told}; the exact motion takes 4 events a period",
            runs[0].amplitude < 1e-3 * exact.distance
            and abs(runs[-1].amplitude / exact.distance - 1.0) < 0.02,
        ),
        Finding(
            "a smooth sign, which has no friction at rest, does not hunt",
            f"-F tanh(v / 1e-4): distance {left:.1e} after {0.9 * axis.WATCHED:g} units of time, "
            f"{smooth.evaluations} evaluations",
            left < 0.2 * exact.distance,
        ),
    )
    t_end = PUSHES * 2.0 * np.pi
    drift = [axis.bristles(s, controlled=False, push=PUSH, t_end=t_end).x[-1] for s in STIFF[1:3]]
    still = Structure(
        mass=[1.0],
        stiffness=[[0.0]],
        contacts=[Contact(at=0, friction=axis.MODEL.contacts[0].friction)],
        force=[PUSH[0]],
        forcing=Harmonic(PUSH[1], 1.0),
    )
    rest = simulate(still, [0.0], [0.0], t_end=t_end)
    yield claim(
        "hunting.creep",
        HERE,
        "Bristles creep under a force that friction holds",
        Finding(
            "a mass pushed by 0.6 + 0.3 cos t, limit 1, without controller: it rests",
            f"displacement {abs(float(rest.x(t_end)[0])):g} after {PUSHES} pushes; with bristles "
            f"of stiffness {STIFF[1]:.0e} and {STIFF[2]:.0e} {drift[0]:.2g} and {drift[1]:.2g}",
            float(rest.x(t_end)[0]) == 0.0 and min(drift) > 2.0 * PUSH[0] / STIFF[2],
        ),
        note="Beside them, bristles bend by the force over their stiffness, 1e-3 and 1e-4 at most.",
    )


CLAIMS: Final = {1: _map, 2: _gains, 3: _bristles}
