"""What linear theory says of the brake, and what it cannot see, computed and checked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.mode_coupling import squeal

NOT_READ: Final = "source not read; model as commonly quoted, parameters chosen here"
HERE: Final = "computed here; docs/studies/mode_coupling.md"
CLOSE: Final = 1e-12  # relative, of thresholds
TOUCHED: Final = 1e-9  # where a branch ends because a stick has no length
SAME: Final = 1e-10  # relative, of what does not depend on the speed
KICKS: Final = (0.5, 0.55, 0.6, 0.65, 0.7)


def _branch() -> Iterator[Claim]:
    c = float(squeal.MODEL.damping[0, 0])
    free, damped = squeal.flutter("constant", damped=False), squeal.flutter("constant")
    apart = [
        abs(free.value / squeal.threshold(0.0) - 1.0),
        abs(damped.value / squeal.threshold(c) - 1.0),
    ]
    frequency = float(abs(damped.multipliers.imag).max())
    yield claim(
        "mode_coupling.flutter",
        NOT_READ,
        "Steady sliding flutters from a friction coefficient on that has a closed form",
        Finding(
            "without damping two modes meet there, with damping a pair crosses the axis",
            f"kinds {free.kind} and {damped.kind}; loads differ from the formula by "
            f"{apart[0]:.0e} and {apart[1]:.0e} of themselves",
            [free.kind, damped.kind] == ["flutter", "hopf"] and max(apart) <= CLOSE,
        ),
        Finding(
            "the squared frequency is the mean of the two stiffnesses over the mass",
            f"it differs by {abs(frequency / squeal.flutter_frequency() - 1.0):.0e}",
            abs(frequency / squeal.flutter_frequency() - 1.0) <= CLOSE,
        ),
        values=(
            Value("mu k_n at flutter, c = 0", free.value, 1e-13, 1, "two modes meet"),
            Value(f"mu k_n at flutter, c = {c:g}", damped.value, 1e-13, 1, "Hopf"),
        ),
        mechanism="friction that follows the normal motion feeds one of two coupled modes",
    )
    found = squeal.cycles()
    onset, end = found.onset, found.small_end
    folds = sorted(event.value for event in found.curve.bifurcations)
    point = np.ravel(end.points)
    off = float(np.abs(point - squeal.touching_point()).max()) / squeal.SPEED
    yield claim(
        "mode_coupling.coexists",
        HERE,
        "A stick-slip cycle attracts far below the threshold of flutter, beside stable sliding",
        Finding(
            "with the same friction at rest and in motion, whatever the speed",
            f"from a fold at {onset.value:.10f} on, {onset.value / damped.value:.1%} of the "
            "threshold",
            onset.value < 0.9 * damped.value,
        ),
        Finding(
            "the branch of unstable cycles goes up to the threshold and ends where its stick has "
            "no length: at the neutral motion that touches stick",
            f"it ends {abs(end.value - squeal.threshold(c)):.0e} from the threshold, "
            f"{off:.0e} V from the closed form of that motion",
            abs(end.value - squeal.threshold(c)) <= TOUCHED and off <= 1e-6,
        ),
        Finding(
            "just above the threshold there is a small cycle at first",
            f"a second fold at {folds[-1]:.10f}, {folds[-1] / damped.value - 1.0:.1e} above",
            len(folds) == 2 and folds[-1] > damped.value,
            essential=False,
        ),
        values=(
            Value("mu k_n of the onset", onset.value, max(onset.error, 1e-13), 1, "fold"),
            Value("mu k_n of the second fold", folds[-1], 1e-13, 1, "fold"),
        ),
        mechanism=(
            "in stick friction gives way by less than its limit, so that the pad gathers energy"
        ),
    )
    faster = squeal.cycles("constant", 2.0 * squeal.SPEED)
    away = abs(faster.onset.value / onset.value - 1.0)
    yield claim(
        "mode_coupling.scale",
        HERE,
        "Speed and brake force set the size of the cycle, not the coefficient of its onset",
        Finding(
            "at twice the speed the onset is the same",
            f"it differs by {away:.0e} of itself",
            away <= SAME,
        ),
        Finding(
            "and the cycle twice as large",
            f"{squeal.amplitude(faster.here) / squeal.amplitude(found.here):.12f} times",
            abs(squeal.amplitude(faster.here) / squeal.amplitude(found.here) - 2.0) <= 2.0 * SAME,
        ),
        mechanism="with one coefficient all equations are homogeneous in displacements and V",
    )


def _kicks() -> Iterator[Claim]:
    edges = [squeal.squeal_kick(load) for load in KICKS]
    floors = [squeal.touching_kick(load) for load in KICKS]
    sides = [
        (
            squeal.squeals(squeal.kicked(load, 0.999 * low)),
            squeal.squeals(squeal.kicked(load, 1.001 * high)),
        )
        for load, (low, high) in zip(KICKS, edges, strict=True)
    ]
    yield claim(
        "mode_coupling.kick",
        HERE,
        "Below the threshold a kick decides, and the smaller the nearer to the threshold",
        Finding(
            "there is an edge: smaller kicks die out, larger ones squeal",
            f"at loads {', '.join(map(str, KICKS))} between "
            f"{', '.join(f'{high:.3f}' for _, high in edges)} times the disc's speed",
            all(side == (False, True) for side in sides),
        ),
        Finding(
            "it falls along the load",
            f"from {edges[0][1]:.2f} to {edges[-1][1]:.2f} V",
            bool(np.all(np.diff([high for _, high in edges]) < 0.0)),
        ),
        Finding(
            "no kick squeals whose slip does not come to stick: linear theory gives a floor",
            f"edges are {', '.join(f'{e[1] / f:.2f}' for e, f in zip(edges, floors, strict=True))}"
            " times the floor",
            all(high >= floor for (_, high), floor in zip(edges, floors, strict=True)),
        ),
        values=tuple(
            Value(f"kick at mu k_n = {load:g}, over V", high, high - low, 2, "bisection")
            for load, (low, high) in zip(KICKS, edges, strict=True)
        ),
    )


def _laws() -> Iterator[Claim]:
    onset = {law: squeal.cycles(law) for law in squeal.LAWS}
    linear = {law: squeal.flutter(law).value for law in squeal.LAWS}
    falling, drop = "falls with speed", "drops at once"
    lowest = float(onset[drop].curve.values[onset[drop].curve.stable].min())
    yield claim(
        "mode_coupling.falling",
        HERE,
        "A falling law moves the threshold of flutter much, the onset of the cycle little",
        Finding(
            "friction that falls by 1 % over ten times the speed: the threshold comes down",
            f"from {linear['constant']:.6f} to {linear[falling]:.6f}, the onset from "
            f"{onset['constant'].onset.value:.6f} to {onset[falling].onset.value:.6f}",
            linear["constant"] - linear[falling]
            > 5.0 * (onset["constant"].onset.value - onset[falling].onset.value),
        ),
        Finding(
            "5 % less friction in motion than at rest: the threshold goes up, yet the cycle is "
            "there at all loads followed",
            f"threshold {linear[drop]:.6f}; a cycle attracts from {lowest:g} on",
            linear[drop] > linear["constant"] and lowest < 0.3,
        ),
        values=(
            Value("onset, friction falls", onset[falling].onset.value, 1e-13, 3, "fold"),
            Value("threshold, friction falls", linear[falling], 1e-12, 3, "Hopf"),
            Value("threshold, friction drops", linear[drop], 1e-12, 3, "Hopf"),
        ),
        note="Linear theory sees friction in motion alone; what happens at rest drives a cycle.",
    )


def _smooth() -> Iterator[Claim]:
    orbit, runs = squeal.smooth_motions()
    exact, period = squeal.amplitude(orbit), squeal.motion(orbit).t[-1]
    errors = [squeal.amplitude_left(run) / exact - 1.0 for run in runs]
    told = "; ".join(
        f"V / width {ratio:g}: amplitude off by {error:+.1%}, "
        f"{run.evaluations * period / squeal.LONG:.0f} evaluations a period"
        for ratio, run, error in zip(squeal.RATIOS, runs, errors, strict=True)
    )
    events = len(squeal.motion(orbit).events)
    yield claim(
        "mode_coupling.smooth",
        HERE,
        "Friction made smooth says that there is no squeal where there is",
        Finding(
            "1 % above the onset the widest of the smooth laws lets it die out",
            told,
            errors[0] < -0.9,
        ),
        Finding(
            "narrower ones come close to the exact cycle, at a price",
            f"the error falls from {abs(errors[1]):.0%} to {abs(errors[-1]):.1%}; the exact motion "
            f"takes {events} events a period, and its stick is a straight line",
            bool(np.all(np.diff(np.abs(errors)) < 0.0)) and abs(errors[-1]) < 0.05,
        ),
        note="LSODA, relative tolerance 1e-6, from a state of the exact cycle, 300 time units.",
    )


CLAIMS: Final = {1: _branch, 2: _kicks, 3: _laws, 4: _smooth}
