"""Where a drill string begins to stick and slip, and where it stops, computed and checked."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.drill_string import string

NOT_READ: Final = "sources not read; model as commonly quoted, parameters chosen here"
HERE: Final = "computed here; docs/studies/drill_string.md"
CLOSE: Final = 1e-12  # relative
MET: Final = 1e-9  # relative, of the ends of two branches found in two ways
BETWEEN: Final = 30.0  # a drive at which rotation and stick-slip both attract


def _branches() -> Iterator[Claim]:
    drive, speed, frequency = string.hopf()
    found = string.computed_hopf()
    errors = [
        abs(found.value / drive - 1.0),
        abs(np.abs(found.multipliers.imag).max() / frequency - 1.0),
        abs(string.drive_of(float(string.rotation(BETWEEN).w[0])) / BETWEEN - 1.0),
    ]
    yield claim(
        "drill_string.hopf",
        NOT_READ,
        "Steady rotation loses its stability as the drive is turned down",
        Finding(
            "drive and frequency are those of Routh's test of a 3 by 3 matrix",
            f"they differ by {max(errors):.0e} of themselves at most",
            found.kind == "hopf" and max(errors) <= CLOSE,
        ),
        values=(
            Value("drive at the Hopf point", found.value, 1e-13, 1, "follow"),
            Value("speed at the Hopf point", speed, 1e-14, 1, "Routh's test"),
        ),
        mechanism="the falling law takes out the damping that the motor's side puts in",
    )
    never, end, curve = string.turning(), string.stick_end(), string.stick_slip()
    landing, vanishing = string.cycles().bifurcations
    slowest, fastest = string.drive_at(never[0]), string.drive_at(never[-1])
    sizes = [abs(each.largest_multiplier) for each in never]
    yield claim(
        "drill_string.hysteresis",
        NOT_READ,
        "Stick-slip goes on far above the drive at which rotation became stable",
        Finding(
            "the cycle attracts from the slowest drive followed up to a drive of its own",
            f"from {curve.values.min():g} to {end.value:.9f}, {end.value / drive:.3f} times that "
            "of the Hopf point",
            bool(curve.stable.all()) and end.value > 1.2 * drive,
        ),
        Finding(
            "there its stick has no length, and it meets an unstable cycle that never sticks",
            f"a {landing.kind} on the curve of cycles, {abs(landing.value / end.value - 1.0):.0e} "
            "of the drive from the edge of the map",
            landing.kind == "landing" and abs(landing.value / end.value - 1.0) <= MET,
        ),
        Finding(
            "unstable cycles lead from there back to the Hopf point",
            f"{len(never)} of them, drives from {fastest:.6f} to {slowest:.6f}, multipliers from "
            f"{sizes[0]:.6f} to {max(sizes):.4f}; a {vanishing.kind} point "
            f"{abs(vanishing.value / drive - 1.0):.0e} of the drive from Routh's",
            min(sizes) > 1.0 and abs(vanishing.value / drive - 1.0) <= CLOSE,
        ),
        Finding(
            "no multiplier tells beforehand that stick-slip will end",
            f"it is {np.abs(curve.multipliers).max():.1e} at most along the branch",
            bool(np.abs(curve.multipliers).max() < 1e-2),
        ),
        values=(Value("drive where stick-slip ends", end.value, 1e-8, 1, "edge of the map"),),
        mechanism="the stick has no length any more: a discontinuous fold",
    )


def _both() -> Iterator[Claim]:
    model = string.MODEL.replace(**{string.DRIVE: BETWEEN})
    near = min(string.turning(), key=lambda each: abs(string.drive_at(each) - BETWEEN))
    border = string.lower_speed(near.trajectory).min()
    steady = string.rotation(BETWEEN).x
    runs = [
        simulate(model, steady - [0.0, 0.0, f * (steady[2] - border)], [], t_end=string.LONG)
        for f in (0.5, 2.0)
    ]
    sticks = [run.events[-1].time > 0.9 * string.LONG if run.events else False for run in runs]
    yield claim(
        "drill_string.both",
        HERE,
        "In between a jolt decides whether the string turns or sticks and slips",
        Finding(
            "one that brings the lower disc halfway to the unstable cycle's slowest speed dies "
            "out, one twice as far as that speed does not",
            f"at drive {BETWEEN:g}, sticks in the end: {', '.join(map(str, sticks))}",
            sticks == [False, True],
        ),
    )


def _smooth() -> Iterator[Claim]:
    exact, runs = string.smooth_motions()
    period, left = string.turning()[-1].period, [string.swing_left(run) for run in runs]
    told = "; ".join(
        f"width {run.width:g}: range of speed {swing:.2g}, "
        f"{run.evaluations * period / string.LONG:.0f} evaluations a period"
        for run, swing in zip(runs, left, strict=True)
    )
    yield claim(
        "drill_string.smooth",
        HERE,
        "Friction made smooth ends stick-slip too early",
        Finding(
            f"at {string.BELOW:g} of the drive at which it ends, from the exact cycle, smooth laws "
            "as narrow as 1 % of the speed of rotation come to rotate steadily",
            f"exact range {exact:.4f}, 2 events a period; {told}",
            max(left[:3]) < 1e-6 * exact,
        ),
        Finding(
            "one five times narrower sticks and slips",
            f"its range of speed differs by {abs(left[-1] / exact - 1.0):.1%}",
            abs(left[-1] / exact - 1.0) < 0.02,
        ),
    )


def _long() -> Iterator[Claim]:
    sizes = (string.ELEMENTS, 1)
    many, two = ((*string.long_hopf(n), string.long_end(n)) for n in sizes)
    errors = np.divide([string.computed_long_hopf(n) for n in sizes], [many[:2], two[:2]]) - 1.0
    whole, reduced = string.long_cycles(), string.long_cycles(1)
    slow = [abs(each[-1].largest_multiplier) for each in (whole, reduced)]
    yield claim(
        "drill_string.long",
        HERE,
        f"A string of {string.ELEMENTS} elements does the same, and two discs tell it roughly",
        Finding(
            "rotation changes its stability where a continued fraction of impedances says",
            f"drives and frequencies, of {string.ELEMENTS} elements and of one, differ from those "
            f"of eigenvalues by {np.abs(errors).max():.0e} of themselves at most",
            np.abs(errors).max() <= CLOSE,
        ),
        Finding(
            "stick-slip attracts up to a drive far above that one",
            f"{len(whole)} cycles of two events from {string.DRIVES[0]:g} to "
            f"{string.DRIVES[-1]:g}, all stable; motions stick up to {many[2]:.2f}, "
            f"{many[2] / many[0]:.3f} times that of the Hopf point",
            all(each.stable and len(each.events) == 2 for each in whole)
            and many[2] > 1.4 * many[0],
        ),
        Finding(
            "two discs, of which the lower one takes a third of the string, put both too high",
            f"rotation becomes stable at {two[0] / many[0] - 1.0:+.1%}, stick-slip ends at "
            f"{two[2] / many[2] - 1.0:+.1%}",
            0.0 < two[0] / many[0] - 1.0 < 0.1 and 0.0 < two[2] / many[2] - 1.0 < 0.1,
        ),
        Finding(
            "and do not see that waves on the string make disturbances of stick-slip last",
            f"largest multipliers at {string.DRIVES[-1]:g}: {slow[0]:.2f}, two discs {slow[1]:.0e}",
            slow[0] > 100.0 * slow[1],
        ),
        values=(
            Value(
                f"drive at the Hopf point, {string.ELEMENTS} elements",
                many[0],
                1e-12,
                4,
                "fraction",
            ),
            Value(
                f"drive where stick-slip ends, {string.ELEMENTS}",
                many[2],
                10 * string.FINEST,
                4,
                "motions",
            ),
        ),
    )


CLAIMS: Final = {1: _branches, 2: _both, 3: _smooth, 4: _long}
