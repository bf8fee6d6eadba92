"""Where a shaken block can move, what a touch of the limit does, and what smooth friction adds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Final

import numpy as np

from stickslip.numerics.zeros import halved
from stickslip.studies.canards import block
from stickslip.studies.claim import Claim, Finding, Value, claim

NOT_READ: Final = "source not read; its abstract's phenomenon, parameters chosen here"
HERE: Final = "computed here; docs/studies/canards.md"
CLOSE: Final = 1e-12
SLIPS: Final = (2.75, 2.9, 3.3, 3.6, 3.9, 4.2)
"""Durations of slips of regular motions that are compared."""
PHASES: Final = (0.1, 0.3, 0.5, 0.7, 0.9, 1.1)
WIDTHS: Final = (0.02, 0.01, 0.005)
WAITED: Final = 0.5
TOLERANCES: Final = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
STEP: Final = 0.01
ROUNDINGS: Final = 4.0 * 2.0**-52


def off(motion: block.Motion) -> float:
    """Largest difference of a regular motion's closed form from the map of releases."""
    phase = motion.phase % (2.0 * math.pi)
    found = block.release_map(motion.force).evaluate(phase)
    size = max(1.0, motion.multiplier)
    apart = (float(found.value) - phase, float(found.duration) - block.PERIOD)
    slope = (float(found.derivative) - motion.multiplier) / size**2
    return max(abs(apart[0]) / size, abs(apart[1]) / size, abs(slope))


def _branches() -> Iterator[Claim]:
    curve, least, touch = block.cycles(), block.onset(), block.touching()
    balance, exact = block.harmonic_balance(block.GIVEN), _attracting().x
    (fold,) = (event for event in curve.bifurcations if event.kind == "fold")
    formula = block.MU * block.STATIC / math.cos(0.5 * math.pi * block.FREQUENCY)
    apart = [abs(fold.value / formula - 1.0), abs(least.force / formula - 1.0)]
    errors = [off(block.regular(slip)) for slip in SLIPS]
    yield claim(
        "canards.onset",
        HERE,
        "A block that friction holds can be kept in motion from a force on that has a closed form",
        Finding(
            "two motions are born there, which attracts and which does not",
            f"a fold {apart[0]:.0e} of the force from mu (1 - f^2) / cos(pi f / 2)",
            max(apart) <= CLOSE,
        ),
        Finding(
            "displacement, phase and multiplier of both are explicit in the time of a slip",
            f"{len(SLIPS)} motions, errors up to {max(errors):.0e}",
            max(errors) <= CLOSE,
        ),
        Finding(
            "harmonic balance puts the onset too high, and the motion too small",
            f"at {4.0 * block.MU / math.pi:.4f} instead of {formula:.4f}; at force {block.GIVEN:g} "
            f"with an amplitude of {balance:.3f} instead of {exact:.3f}",
            4.0 * block.MU / math.pi > 1.1 * formula and balance < 0.7 * exact,
        ),
        values=(Value("force at the onset", fold.value, fold.error, 1, "fold"),),
        mechanism="friction in motion alone sets the onset: friction at rest does not enter",
    )
    (end,) = (end for end in curve.ends if end.reason != "end of range")
    short = abs(float(end.parameters[block.FORCE]) / touch.force - 1.0)
    steep = float(np.abs(end.multipliers).max())
    yield claim(
        "canards.end",
        NOT_READ,
        "The branch of unstable motions ends where the needed force only just touches the limit",
        Finding(
            "followed, it ends there, with a multiplier without bound",
            f"up to {short:.0e} of the force before the closed form, multiplier {steep:.0e}",
            short < 1e-5 and steep > 1e9,
        ),
        values=(Value("force where it ends", touch.force, 1e-14, 1, "closed form"),),
    )


def _attracting() -> block.Motion:
    """Return the regular motion that attracts at the file's force."""
    low, _ = halved(lambda slip: block.regular(slip).force < block.GIVEN, math.pi, 4.5, 60)
    return block.regular(low)


def _touch() -> Iterator[Claim]:
    rests = [not block.from_rest(-excess, 20.0).events for excess in (1e-3, 1e-9, 1e-14)]
    late = [
        block.from_rest(excess).events[0].time * block.FREQUENCY - 0.5 * math.pi
        for excess in (0.0, 1e-14, 1e-9, 1e-4)
    ]
    early = [
        -math.acos((block.GIVEN - excess) / block.GIVEN) for excess in (0.0, 1e-14, 1e-9, 1e-4)
    ]
    apart = float(np.abs(np.subtract(late, early)).max())
    margins = []
    for excess in (1e-3, 1e-6, 1e-9):
        short, beyond = (block.from_rest(e).derivative("x0").margin for e in (-excess, excess))
        rate = block.FREQUENCY * math.sqrt(2.0 * block.GIVEN * excess)
        margins += [abs(short / excess - 1.0), abs(beyond / rate - 1.0)]
    run = block.from_rest(0.0, 40.0)
    x = np.abs(run.x(np.linspace(39.0 * block.PERIOD, 40.0 * block.PERIOD, 20_001))).max()
    yield claim(
        "canards.touch",
        NOT_READ,
        "Where the needed force touches its limit, what follows is not unique",
        Finding(
            "short of the limit by any amount the block rests for ever",
            f"20 periods without an event, 1e-3 to 1e-14 short: {', '.join(map(str, rests))}",
            all(rests),
        ),
        Finding(
            "at a touch, and beyond, it slips at the instant of the limit, and never rests again",
            f"phases of the slip differ from arccos((a - e) / a) by {apart:.0e} at most; after a "
            f"touch it comes to the motion that attracts, to {abs(x - _attracting().x):.0e}",
            apart <= math.sqrt(2.0 * ROUNDINGS / block.GIVEN) and abs(x - _attracting().x) < 1e-6,
        ),
        Finding(
            "margins tell how near it is: what is missing, or the rate f sqrt(2 a e) of the force",
            f"relative errors up to {max(margins):.0e}, from 1e-3 to 1e-9 on either side",
            max(margins) <= 1e-3,
        ),
        note=(
            "The engine's rule: a touch counts as contact, within rounding of the force. Both "
            "answers are limits of unique ones, from either side."
        ),
    )
    missed = block.unseen(STEP)
    slips = bool(block.from_rest(0.9 * missed).events)
    yield claim(
        "canards.steps",
        HERE,
        "Fixed steps do not see a limit that is passed for less than a step",
        Finding(
            f"with steps of {STEP:g} the block rests where it slips",
            f"up to {missed:.1e} beyond the limit nothing is seen; the exact motion slips: {slips}",
            missed > 1e-7 and slips,
        ),
    )
    waits = [block.canard_with(phase) for phase in PHASES]
    ends = [block.slip_of(motion) for motion in waits]
    errors = [
        max(abs(t - motion.slip), abs(x - motion.x))
        for motion, (t, x) in zip(waits, ends, strict=True)
    ]
    held = [motion.force + motion.x - 1.0 for motion in waits]
    yield claim(
        "canards.family",
        HERE,
        "Waits beyond a touch make a family of motions from the branch's end to rest",
        Finding(
            "each touches the limit, waits, slips at a force below the limit, and lands in its "
            "mirror image; in closed form",
            f"{len(waits)} of them: slips followed end as they should to {max(errors):.0e}, "
            f"touches to {max(map(abs, held)):.0e}; needed forces from {waits[0].needed:.3f} down "
            f"to {waits[-1].needed:.3f}",
            max(errors) <= CLOSE and max(map(abs, held)) <= CLOSE,
        ),
        Finding(
            "from no wait, the last regular motion, to a slip without length at force 1",
            f"wait 1e-6: {abs(block.canard_with(1e-6).force - block.touching().force):.0e} from "
            "it; wait arccos(mu) - 0.01: force "
            f"{block.canard_with(math.acos(block.MU) - 0.01).force:.9f}",
            abs(block.canard_with(1e-6).force - block.touching().force) < 1e-5
            and abs(block.canard_with(math.acos(block.MU) - 0.01).force - 1.0) < 1e-5,
        ),
        values=(
            Value(
                f"force of wait {WAITED:g}", block.canard_with(WAITED).force, 1e-14, 2, "formula"
            ),
        ),
    )


def _smooth() -> Iterator[Claim]:
    errors = [
        max(
            abs(block.smooth_canard(phase, width).force - block.canard_with(phase).force)
            for phase in PHASES
        )
        for width in WIDTHS
    ]
    ratios = np.divide(errors[:-1], errors[1:])
    yield claim(
        "canards.smooth",
        NOT_READ,
        "With smooth friction the family exists, and connects what it connects",
        Finding(
            "forces come to the closed form in proportion to the width of the smooth law",
            f"off by {', '.join(f'{error:.4f}' for error in errors)} at widths "
            f"{', '.join(map(str, WIDTHS))}",
            bool(np.all((ratios > 1.6) & (ratios < 2.5))),
        ),
        mechanism="the wait runs along the falling part of the smooth law, where motions part",
    )
    chosen = block.smooth_canard(WAITED, WIDTHS[-1])
    left = [block.smooth_leaving(chosen, rtol) for rtol in TOLERANCES]
    yield claim(
        "canards.forward",
        HERE,
        "No integration forward in time can show it: what is seen is the tolerance",
        Finding(
            "started on the motion itself, steps leave it early or stay at rest",
            f"width {chosen.width:g}, true phase {WAITED:g}: " + _told(left),
            all(not abs(phase - WAITED) < 0.05 for phase in left),
        ),
        Finding(
            "smooth friction also moves the edge between rest and motion, by its width",
            f"at force {chosen.force:.4f} to {chosen.x:.4f}, exactly {1.0 - chosen.force:.4f}",
            _shift(chosen) > 0.5 * chosen.width,
        ),
    )


def _told(left: list[float]) -> str:
    """Say for each tolerance at which phase a motion slips."""
    pairs = zip(TOLERANCES, left, strict=True)
    return "; ".join(
        f"tolerance {rtol:.0e}: {'rest' if math.isnan(phase) else f'{phase:.3f}'}"
        for rtol, phase in pairs
    )


def _shift(canard: block.SmoothCanard) -> float:
    """How far the edge lies from the exact one."""
    return canard.x - (1.0 - canard.force)


CLAIMS: Final = {1: _branches, 2: _touch, 3: _smooth}
