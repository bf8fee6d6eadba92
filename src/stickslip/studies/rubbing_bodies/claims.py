"""Closed forms of bodies that rub, checked; published motions of a train of clutches beside."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.mechanics.flow.trajectory import simulate
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.rubbing_bodies import bodies, clutches

HERE: Final = "computed here; docs/studies/rubbing_bodies.md"
PUBLISHED: Final = "CoupledClutches of the Modelica Standard Library; model and results read"
CLOSE: Final = 1e-12
STACKS: Final = 60
MIDDLES: Final = tuple(np.linspace(0.05, 0.95, 18).tolist())
STEPS: Final = (1e-1, 1e-2, 1e-3)


def _stacks() -> Iterator[Claim]:
    drawn = bodies.random_stacks(STACKS)
    errors = [bodies.largest_error(given) for given in drawn]
    apart = [given for given in drawn if len(bodies.stages(given)) > 3]
    yield claim(
        "rubbing.stack",
        HERE,
        "Two sliders upon each other stop after times that are rational numbers",
        Finding(
            "all events, ways and heat are those of exact arithmetic",
            f"{STACKS} random stacks, {len(apart)} of which part again after they had met: "
            f"relative errors up to {max(errors):.0e}",
            max(errors) <= CLOSE and 0 < len(apart) < STACKS,
        ),
        mechanism="after equal speeds they go on together as far as the friction between them can",
    )
    exact = float(bodies.stages(bodies.PULLED)[-1].x[0])
    rest = 1.25 * float(bodies.stages(bodies.PULLED)[-1].t)
    off = [
        abs(bodies.stepped(bodies.PULLED.model, [3.0, 0.0], h, rest)[1][-1, 0] / exact - 1.0)
        for h in STEPS
    ]
    told = ", ".join(f"{error:.1e}" for error in off)
    yield claim(
        "rubbing.stepping",
        HERE,
        "Time stepping puts every event at the end of a step",
        Finding(
            "the way of the lower slider is wrong in proportion to the step, to its first power",
            f"Moreau's scheme with steps {', '.join(f'{h:g}' for h in STEPS)}: relative errors "
            f"{told}; exact motion: 3 events",
            bool(np.allclose(np.array(off) / STEPS, off[-1] / STEPS[-1], rtol=0.1)),
        ),
    )


def _walled() -> Iterator[Claim]:
    found = [(bodies.break_away(f), bodies.mechanism(f)) for f in MIDDLES]
    errors = [abs(a[0] / b[0] - 1.0) for a, b in found]
    yield claim(
        "rubbing.mechanism",
        HERE,
        "Friction forces at rest are not unique, but the force at which something moves is",
        Finding(
            "it is that of the weaker mechanism: the lower slider alone, or both against the wall",
            f"{len(MIDDLES)} friction forces between the sliders: relative errors up to "
            f"{max(errors):.0e}, the contacts that slip as said",
            max(errors) <= CLOSE and all(a[1] == b[1] for a, b in found),
        ),
        mechanism="two bodies and three contacts: limit analysis, as of frames",
        note="The Modelica library's manual tells to put springs between friction elements, as "
        "their forces are not unique while they stick.",
    )
    weight = bodies.HELD * bodies.mechanism(bodies.WALLED.contacts[2].static)[0]
    rest = simulate(
        bodies.WALLED.replace(force=[weight, 0.0]), np.zeros(2), np.zeros(2), t_end=bodies.CREPT
    )
    runs = bodies.creeping()
    speeds = [float(run.v[-1, 0]) / bodies.creep_speed(run.width) for run in runs]
    yield claim(
        "rubbing.creep",
        HERE,
        "Friction made smooth lets bodies creep under forces that friction holds",
        Finding(
            f"at {bodies.HELD:g} of that force the exact bodies rest",
            f"displacement {abs(float(rest.final_state.x[0])):g} after {bodies.CREPT:g}, 0 events",
            float(np.abs(rest.final_state.x).max()) == 0.0,
        ),
        Finding(
            "smooth ones creep, at a speed in closed form in proportion to the width",
            "; ".join(f"width {run.width:g}: by {run.x[-1, 0]:.2g}" for run in runs)
            + f"; speeds differ from the formula by {max(abs(s - 1.0) for s in speeds):.0e}",
            all(abs(s - 1.0) < 1e-3 for s in speeds),
        ),
    )


def _clutch() -> Iterator[Claim]:
    run = clutches.CLUTCH.motion(clutches.WATCHED)
    heat = float(run.energy([clutches.WATCHED]).dissipation[0])
    errors = [
        abs(run.events[0].time / clutches.CLUTCH.lock - 1.0),
        abs(heat / clutches.CLUTCH.heat - 1.0),
        abs(abs(float(run.friction([clutches.WATCHED])[0, 0])) / clutches.CLUTCH.carried - 1.0),
    ]
    yield claim(
        "rubbing.clutch",
        HERE,
        "A clutch locks after a time, and for a heat, in closed form",
        Finding(
            "followed, it has them, and carries the torque of the formula thereafter",
            f"relative errors up to {max(errors):.0e}",
            len(run.events) == 1 and max(errors) <= CLOSE,
        ),
    )
    runs = clutches.smooth_clutches()
    slips = [float(each.v[-1, 0] - each.v[-1, 1]) for each in runs]
    off = [
        abs(s / clutches.CLUTCH.slip(each.width) - 1.0) for s, each in zip(slips, runs, strict=True)
    ]
    yield claim(
        "rubbing.slipping",
        HERE,
        "A clutch with smooth friction never locks under torque",
        Finding(
            "the exact one turns as one body",
            f"slip {float(np.ptp(run.final_state.v)):g} at {clutches.WATCHED:g}",
            float(np.ptp(run.final_state.v)) <= 1e-14,
        ),
        Finding(
            "the smooth one keeps a slip of width times artanh(torque / capacity), and heats",
            "; ".join(
                f"width {each.width:g}: slip {s:.3g}, power lost {s * clutches.CLUTCH.carried:.2g}"
                for s, each in zip(slips, runs, strict=True)
            ),
            max(off) < 1e-3,
        ),
    )


def _train() -> Iterator[Claim]:
    found, (times, speeds) = clutches.train(), clutches.closed_form()
    ends = found.speeds(1.5)
    events = [time for time in times if time not in (0.4, 0.9, 1.25, 1.5)]
    error = max(
        *(abs(event[0] - time) for event, time in zip(found.events, events, strict=True)),
        float(np.abs(ends - speeds).max()),
    )
    angles = found.angles()
    known = {
        "angle 1": angles[0],
        "speed 1": ends[0],
        "speed 2 less speed 1": ends[1] - ends[0],
        **{f"angle {k + 2} less angle {k + 1}": angles[k + 1] - angles[k] for k in range(3)},
    }
    read = {name: float(text) for name, text in clutches.DYMOLA.items()}
    apart = max(abs(read[name] - value) for name, value in known.items())
    one, other = read["speed 1"], read["speed 1"] + read["speed 2 less speed 1"]
    momentum = 10.0 + 2.0 / math.pi
    lost = [one + 3.0 * other - momentum, float(ends.sum()) - momentum]
    yield claim(
        "rubbing.train",
        HERE,
        "Times and speeds of three coupled clutches solve equations in sines and cosines",
        Finding(
            "followed event by event they are the same",
            f"{len(found.events)} events and four speeds, errors up to {error:.0e}",
            error <= CLOSE,
        ),
        values=tuple(
            Value(f"event {k}: clutch {clutch + 1}, {kind}", time, 1e-13, 4, "simulate")
            for k, (time, clutch, kind) in enumerate(found.events, start=1)
        ),
    )
    yield claim(
        "rubbing.dymola",
        f"{PUBLISHED}: MAP-LIB_ReferenceResults, Dymola 2020x, DASSL, tolerance 1e-6",
        "The library's reference results are motions of its equations",
        Finding(
            "angles and speeds at the end are the exact ones to 1e-4",
            f"they differ by {apart:.1e} at most",
            apart < 1e-4,
        ),
        Finding(
            "they balance momentum to their tolerance",
            f"off by {lost[0]:.1e}; the exact motion by {abs(lost[1]):.0e}",
            abs(lost[0]) < 1e-5,
            essential=False,
        ),
        values=tuple(
            Value(name, float(known[name]), 1e-12, 4, "simulate", printed=text)
            for name, text in clutches.DYMOLA.items()
        ),
    )
    theirs = [float(text) for text in clutches.MWORKS]
    yield claim(
        "rubbing.mworks",
        f"{PUBLISHED}: fmi-cross-check, MWorks 2016, FMI 1.0 for co-simulation",
        "Published results of another tool show clutches 2 and 3 locked at the end",
        Finding(
            "speeds 2, 3 and 4 are one",
            f"they are {', '.join(f'{w:.4f}' for w in theirs[1:])}, from the steps at which each "
            f"clutch closed on; exact: {ends[1]:.6f}, all three to {np.ptp(ends[1:]):.0e}",
            float(np.ptp(theirs[1:])) < 1e-6,
        ),
        Finding(
            "momentum balances",
            f"off by {sum(theirs) - momentum:.0e}",
            abs(sum(theirs) - momentum) < 1e-5,
            essential=False,
        ),
        note="It seems that a step which ends a little after equal speeds locked bodies that turn "
        "at different ones.",
    )


CLAIMS: Final = {1: _stacks, 2: _walled, 3: _clutch, 4: _train}
