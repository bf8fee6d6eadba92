"""Responses with a friction damper: closed form and exact cycles beside harmonic balance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.flow.trajectory import simulate
from stickslip.studies.claim import Claim, Finding, Value, claim
from stickslip.studies.friction_dampers import dampers

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Floats

NOT_READ: Final = "source not read; formulas derived anew"
HERE: Final = "computed here; docs/studies/friction_dampers.md"
CLOSE: Final = 1e-10
FORCES: Final = (0.85, 1.2, dampers.BEST, 3.0)
"""Friction forces of the damper on one mass."""
BLADE_FORCE: Final = 2.0
SWEPT: Final = tuple(np.r_[0.34:0.43:0.01, 0.434:0.474:0.002, 0.475:0.65:0.01].tolist())
LIGHT_FORCE: Final = 0.5
SLOW: Final = tuple(np.r_[0.13:0.15:0.005, 0.151:0.178:0.0015, 0.18:0.3:0.005].tolist())
STARTS: Final = 12
LOWER: Final = 0.5  # of the static limit: friction in motion
HELD: Final = 2.0  # static limit with it
BOTH: Final = 1.15  # frequency at which it both holds and slips


def slipping(load: float, n: int) -> tuple[float, ...]:
    """Frequencies at which one mass cannot be held by the contact."""
    ends = [math.sqrt(max(2.0 - 1.0 / load, 0.5)), math.sqrt(2.0 + 1.0 / load)]
    return tuple(np.linspace(ends[0] + 0.01, min(ends[1] - 0.01, 1.7), n).tolist())


@cache
def errors_of_one() -> tuple[float, float, float]:
    """Largest errors of exact cycles against the closed form, and of one harmonic."""
    amplitude, heat, balanced = [], [], []
    for load in FORCES:
        frequencies = slipping(load, 12)
        found, cycles = dampers.response(dampers.MODEL, load, frequencies)
        for each, cycle, w in zip(found.tolist(), cycles, frequencies, strict=True):
            exact = dampers.symmetric(load, w)[0]
            lost = float(cycle.trajectory.energy([cycle.period]).dissipation[0])
            amplitude.append(abs(each / exact.amplitude - 1.0))
            heat.append(abs(lost / exact.lost - 1.0))
            balanced.append(
                abs(dampers.one_harmonic(dampers.MODEL, load, w) / exact.amplitude - 1.0)
            )
    return max(amplitude), max(heat), max(balanced)


def _one() -> Iterator[Claim]:
    amplitude, heat, balanced = errors_of_one()
    yield claim(
        "dampers.closed_form",
        HERE,
        "A cycle of one mass solves one equation in the time of a stick",
        Finding(
            "amplitude and heat of the cycles found in time are those of the formula",
            f"{len(FORCES)} friction forces at 12 frequencies: relative errors up to "
            f"{amplitude:.0e} and {heat:.0e}",
            max(amplitude, heat) <= CLOSE,
        ),
        Finding(
            "balance of one harmonic is near",
            f"off by {balanced:.1%} at most",
            balanced < 0.06,
        ),
    )


def _best() -> Iterator[Claim]:
    load, least = dampers.best()
    yield claim(
        "dampers.best",
        NOT_READ,
        "Without other damping the best friction force is about pi / 2 of the driving force",
        Finding(
            "by balance of one harmonic pi F / 2, with a peak of pi F / k; exactly a little less",
            f"{load:.5f} beside {dampers.BEST:.5f}, peaks {least:.6f} and {dampers.LEAST:.6f}",
            abs(load / dampers.BEST - 1.0) < 0.02 and abs(least / dampers.LEAST - 1.0) < 0.002,
        ),
        Finding(
            "twice or two thirds of it cost a third of the amplitude more",
            "by one harmonic "
            + " and ".join(
                f"{dampers.peak_of_one_harmonic(q * dampers.BEST) / dampers.LEAST:.4f}"
                for q in (2.0, 2 / 3)
            ),
            all(
                abs(dampers.peak_of_one_harmonic(q * dampers.BEST) / dampers.LEAST - 4.0 / 3.0)
                < 1e-12
                for q in (2.0, 2.0 / 3.0)
            ),
        ),
        values=(
            Value("best friction force", load, 1e-5, 2, "closed form, minimised"),
            Value("its peak", least, 1e-9, 2, "closed form, minimised"),
        ),
    )


@cache
def blade_responses(load: float, swept: tuple[float, ...]) -> tuple[Floats, Floats, Floats]:
    """Tip of the blade: exact, one harmonic, odd harmonics up to 15."""
    exact, _ = dampers.response(dampers.BLADE, load, swept, dampers.TIP)
    one = np.array([dampers.one_harmonic(dampers.BLADE, load, w, dampers.TIP) for w in swept])
    many = np.array([dampers.many_harmonics(dampers.BLADE, load, w, dampers.TIP) for w in swept])
    return exact, one, many


def _blade() -> Iterator[Claim]:
    exact, one, many = blade_responses(BLADE_FORCE, SWEPT)
    slow, slow_one, slow_many = blade_responses(LIGHT_FORCE, SLOW)
    off = [np.abs(each - 1.0).max() for each in (many / exact, slow_many / slow)]
    peaks = np.array([dampers.blade_peak(load) for load in dampers.LOADS])
    chosen, told = (dampers.LOADS[int(np.argmin(peaks[:, k]))] for k in (0, 1))
    worst = float((peaks[:, 1] / peaks[:, 0] - 1.0).max())
    yield claim(
        "dampers.blade",
        HERE,
        "One harmonic misjudges a blade whose modes resonate with each other",
        Finding(
            "it tells another best friction force",
            f"{told:g} of those tried, exactly {chosen:g}; its peak is {worst:.0%} too large "
            "at worst",
            told > chosen and worst > 0.3,
        ),
        Finding(
            "odd harmonics up to 15 are enough",
            f"relative errors up to {max(off):.0e}; one harmonic {_worst(one / exact)} near the "
            f"first resonance, {_worst(slow_one / slow)} far below it",
            max(off) < 2e-3,
        ),
        mechanism="the second mode is near three times the first",
    )
    rng = np.random.default_rng(3)
    frequency = float(SWEPT[int(np.argmax(exact))])
    model = dampers.BLADE.replace(static_1=BLADE_FORCE, **{dampers.FREQUENCY: frequency})
    ends = [
        dampers.swing(
            find_cycle(model, *(rng.normal(size=3) * 30.0 for _ in range(2))), dampers.TIP
        )
        for _ in range(STARTS)
    ]
    yield claim(
        "dampers.unique",
        HERE,
        "Where friction at rest is that in motion no branch is isolated: the cycle is unique",
        Finding(
            "motions from random states come to one cycle",
            f"{STARTS} starts at frequency {frequency:g}: amplitudes differ by "
            f"{np.ptp(ends) / ends[0]:.0e}",
            bool(np.ptp(ends) <= CLOSE * ends[0]),
        ),
        mechanism="the energy of the difference of two motions never grows",
    )


def _worst(ratio: Floats) -> str:
    """Largest relative error, in words."""
    return f"{np.abs(ratio - 1.0).max():.0%}"


PERIODS: Final = 8
NUDGE: Final = 1e-4


def strays(cycle: dampers.Symmetric, nudge: float = 0.0, periods: int = 1) -> float:
    """Distance from a cycle in closed form after some periods, started beside it."""
    (x, foot), v = cycle.start
    t_end = periods * 2.0 * math.pi / cycle.frequency
    run = simulate(cycle.model, [x + nudge, foot + nudge], v, t_end=t_end)
    return float(np.abs(run.final_state.x - cycle.start[0]).max())


def _two() -> Iterator[Claim]:
    large, small = dampers.symmetric(HELD, BOTH, LOWER)
    stuck = 1.0 / (2.0 - BOTH**2)
    off = max(strays(large), strays(small))
    later = [strays(each, NUDGE, PERIODS) for each in (large, small)]
    yield claim(
        "dampers.two",
        HERE,
        "Where friction holds more at rest, a damper that holds may be one jolt from slipping",
        Finding(
            f"at {BOTH:g} of the free resonance it holds, and two cycles slip",
            f"amplitudes {stuck:.4f}, {large.amplitude:.4f} and {small.amplitude:.4f}; it has to "
            f"slip from {dampers.breaks_loose(HELD):.4f} on; the cycles return to {off:.0e}",
            off <= CLOSE and dampers.breaks_loose(HELD) > BOTH,
        ),
        Finding(
            "the larger one attracts, the smaller one repels",
            f"after {PERIODS} periods a distance of {NUDGE:g} is {later[0]:.0e} and {later[1]:.0e}",
            later[0] < 0.1 * NUDGE and later[1] > 100.0 * NUDGE,
        ),
        note=f"Friction in motion {LOWER:g} of the static limit {HELD:g}.",
    )


CLAIMS: Final = {1: _one, 2: _best, 3: _blade, 4: _two}
