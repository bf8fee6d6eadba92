"""The Coulomb oracle itself is tested: against closed forms, the equations and another solver."""

from math import atan, pi, sqrt

import numpy as np
import pytest
from flint import arb, ctx
from tests.reference import checks
from tests.reference.coulomb import Coulomb, Wave
from tests.reference.motion import NEVER_CYCLE, OK, sensitivity
from tests.reference.precision import digits
from tests.reference.roots import NotPositive, earliest, first_root

PAPER = (1.2, 1.3, 0.0366, 0.22)


def random_cases(n, seed, v_max=0.3):
    rng = np.random.default_rng(seed)
    for _ in range(n):
        alpha, beta, mu, V = (
            float(rng.uniform(*r)) for r in ((0.1, 3), (0.5, 2), (0.05, 0.9), (0.005, v_max))
        )
        d = float(rng.uniform(-1, 1)) * (1 + beta) / (1 + 2 * alpha)
        yield Coulomb(alpha, beta, V, mu), d


@pytest.mark.parametrize("gap", ["1e-3", "1e-12", "1e-25", "1e-35"])
def test_a_pair_of_roots_however_close_is_found(gap):
    # 1 - gap - cos(t - 2): first root 2 - acos(1 - gap) = 2 - sqrt(2 gap) (1 + gap / 12 ..)
    two = arb(2)
    wave = Wave(1 - arb(gap), arb(0), ((arb(1), -two.cos(), -two.sin()),))
    assert abs(first_root(wave, arb(10)) - (two - (1 - arb(gap)).acos())) < arb("1e-34")


@pytest.mark.parametrize("gap", ["1e-3", "1e-12", "1e-25", "1e-35"])
def test_a_near_miss_is_not_a_root(gap):
    two = arb(2)
    wave = Wave(1 + arb(gap), arb(0), ((arb(1), -two.cos(), -two.sin()),))
    assert first_root(wave, arb(100)) is None


@pytest.mark.parametrize("longest", [3, 6, 66, 86, 127, 129])
def test_the_earliest_root_is_looked_for_up_to_the_limit(longest):
    # Motions are followed to a limit of time; roots of straight lines
    roots = [arb(1.5), arb(5), arb(65), arb(128.5)]
    for root in roots:
        found = earliest([Wave(root, arb(-1), ())], arb(longest))
        assert (found is None) if root > longest else (abs(found - root) < arb("1e-30"))


def test_a_touch_is_a_root():
    two = arb(2)
    wave = Wave(arb(1), arb(0), ((arb(1), -two.cos(), -two.sin()),))
    assert abs(first_root(wave, arb(10)) - 2) < arb("1e-30")


def test_a_multiple_root_at_the_start_is_left_behind():
    # 1 - cos t starts with a double root, t - sin t with a triple one.
    double = Wave(arb(1), arb(0), ((arb(1), arb(-1), arb(0)),))
    assert abs(first_root(double, arb(9)) - 2 * arb.pi()) < arb("1e-20")
    triple = Wave(arb(0), arb(1), ((arb(1), arb(0), arb(-1)),))
    assert first_root(triple, arb(100)) is None


def test_a_signal_that_falls_from_zero_is_refused():
    with pytest.raises(NotPositive):
        first_root(Wave(arb(0), arb(-1), ()), arb(1))


def test_motions_obey_the_equations_and_the_limits():
    paper = Coulomb(*PAPER)
    for system, d in [(paper, 0.2774), (paper, -0.03), *random_cases(40, seed=2, v_max=0.1)]:
        motion = system.motion(d)
        if motion.n_events > 40:
            continue
        assert checks.worst_residual(system, motion) < 1e-30
        assert checks.worst_violation(system, motion) <= 0
        assert checks.energy_defect(system, motion) < 1e-13


def test_a_better_precision_gives_the_same_motion():
    cases = list(random_cases(60, seed=3))
    before = [system.motion(d, max_events=100) for system, d in cases]
    ctx.prec *= 2
    try:
        after = [system.motion(d, max_events=100) for system, d in cases]
    finally:
        ctx.prec //= 2
    for a, b in zip(before, after, strict=True):
        assert (a.status, a.itinerary) == (b.status, b.itinerary)
        if a.status == OK:
            assert abs(a.value - b.value) < arb("1e-30")


def test_ordinary_motions_agree_with_a_general_solver():
    compared = 0
    for system, d in random_cases(25, seed=4, v_max=0.1):
        motion = system.motion(d)
        if motion.status != OK or motion.n_events > 20:
            continue
        limits = [float(limit) for limit in system.limits]
        mu = float(system.mu[0])
        value, itinerary = checks.by_solve_ivp(system, d, lambda i, s: mu * limits[i])  # noqa: B023
        kappa = sensitivity(system, d, motion)[1]
        assert itinerary == motion.itinerary
        assert abs(value - float(motion.value)) < 1e-10 * kappa
        compared += 1
    assert compared > 15


def test_free_blocks_follow_the_closed_form():
    """alpha = 0: each block slips by itself, from R = L to the mirrored point 2 L mu - L."""
    mu, V, beta = 0.3, 0.1, 1.5
    for d in (-1.0, 0.2, 2.0):
        # Block 1 releases at X = 1; time on the belt until block 2 does: (beta - d - 1) / V.
        motion = Coulomb(0.0, beta, V, mu).motion(d)
        assert motion.status == OK
        x1 = min(1.0, beta - d)
        lonely = [1.0, beta][x1 + d >= beta]
        slip = 2 * (pi - atan(lonely * (1 - mu) / V))
        other = (x1 + d if lonely == 1.0 else x1) + V * slip
        if motion.n_events == 1:
            end = lonely * (2 * mu - 1)
            wanted = other - end if lonely == 1.0 else end - other
            assert abs(float(motion.duration) - slip) < 1e-14
            assert abs(float(motion.value) - wanted) < 1e-14
        else:
            assert other > [beta, 1.0][lonely == beta]


def test_one_slip_lands_where_symmetry_says():
    """One slip among riders is a sinusoid about the moving balance: R goes from L to 2 L mu - L."""
    for system, d in random_cases(10, seed=5):
        motion = system.motion(d)
        if motion.itinerary in ("-. ..", ".- .."):
            block = 0 if motion.itinerary[0] == "-" else 1
            x = motion.events[-1].x
            force = x[block] + system.alpha * (x[block] - x[1 - block])
            wanted = system.limits[block] * (2 * system.mu[block] - 1)
            assert abs(force - wanted) < arb("1e-80")
            # and the slope of f on such a piece is exactly one
            assert abs(sensitivity(system, d, motion)[0] - 1) < 1e-12


def test_without_friction_a_single_slip_lands_on_the_opposite_limit_and_sticks():
    for d in (-0.6, 0.66):
        motion = Coulomb(1.2, 1.3, 0.0366, 0.0).motion(d)
        assert motion.status == OK
        assert motion.itinerary in ("-. ..", ".- ..")


def test_at_the_ends_of_the_domain_only_the_loaded_block_leaves():
    for system, _ in random_cases(10, seed=6):
        end = (1 + float(system.beta)) / (1 + 2 * float(system.alpha))
        for side, first in ((1, ".-"), (-1, "-.")):
            motion = system.motion(side * end)
            assert motion.itinerary.startswith(first)
            near = system.motion(arb(side * end) * (1 - arb("1e-30")))
            if motion.status == near.status == OK:
                assert abs(motion.value - near.value) < arb("1e-25")


def test_at_the_corner_of_the_locus_both_leave_together():
    motion = Coulomb(0.75, 1.0, 0.05, 0.2).motion(0.0)
    assert motion.itinerary == "-- .."
    assert motion.value == 0
    exact_corner = (arb(1.3) - 1) / (1 + 2 * arb(1.2))
    assert Coulomb(*PAPER).motion(exact_corner).itinerary.startswith("--")


def test_full_friction_starts_with_a_double_root():
    """mu = 1: w = w' = 0 at release; the block creeps off all the same, and swings back to touch.

    A free block then has w = V (cos t - 1): after 2 pi it touches the belt with R at its limit and
    growing, so that it slips on, for ever.
    """
    motion = Coulomb(0.0, 2.0, 0.3, 1.0).motion(0.0, max_events=3)
    assert [float(e.time) for e in motion.events][:2] == pytest.approx([0, 1 / 0.3])
    assert motion.itinerary.startswith("-. --")
    alone = Coulomb(0.0, 2.0, 0.01, 1.0).motion(0.0, max_events=10)
    assert alone.status == "EVENT_LIMIT"
    assert alone.itinerary == "-."


def test_grazing_is_seen_from_both_sides():
    """Block 2 touches the belt at a jump of the paper's map; bisect it to 1e-34."""
    system = Coulomb(*PAPER)
    low, high = arb("0.2774"), arb("0.2874")
    inner, outer = system.motion(low).itinerary, system.motion(high).itinerary
    assert inner != outer
    while high - low > arb("1e-34"):
        middle = ((low + high) / 2).mid()
        if system.motion(middle).itinerary == inner:
            low = middle
        else:
            high = middle
    left, right = system.motion(low), system.motion(high)
    assert left.itinerary == inner
    assert right.itinerary != inner
    assert abs(left.value - right.value) > 1e-3


def test_small_amplitudes_never_return():
    # Both blocks in balance, moving slowly: they oscillate for ever below the belt's velocity.
    system = Coulomb(0.0, 1.0, 0.3, 1.0)
    phase = system.phase((arb(1), arb(1)), (arb(0), arb(0.1)), (-1, -1))
    assert phase.never_ends()
    fast = system.phase((arb(1), arb(0.69)), (arb(0), arb(0)), (-1, -1))
    assert not fast.never_ends()


def test_a_common_period_proves_what_the_amplitudes_do_not():
    """alpha = 1.5: frequencies 1 and 2. cos t - cos 2 t stays below 9 / 8 though 2 is its bound."""
    system = Coulomb(1.5, 1.0, 1.0, 1.0)
    assert abs(system.period - 2 * arb.pi()) < arb("1e-60")
    # X_2' = s/2 + r/2 with s' = a cos t, r' = -a cos 2t; X_1' = (a cos t + a cos 2t) / 2 <= a
    for a, ends in ((0.99, False), (1.01, True)):
        phase = system.phase((arb(1), arb(1)), (arb(0), arb(0)), (-1, -1))
        swing = Wave(arb(0), arb(0), ((arb(1), arb(0), arb(a)), (arb(2), arb(0), arb(-a) / 2)))
        phase.x = (swing * 0.5, swing * 0.5)
        assert phase.never_ends()  # 9/16 a < 1
        phase.x = (phase.x[0] * (16 / 9), phase.x[1])
        assert phase.never_ends() is not ends


def test_a_cycle_without_global_stick_is_named():
    motion = Coulomb(1.2, 1.3, 0.2, 0.05).motion(0.48)
    assert motion.status == NEVER_CYCLE


def test_fixed_points_of_the_paper():
    system = Coulomb(*PAPER)
    for d in (-0.0399, 0.0886, 0.3716):
        assert abs(float(system.motion(d).value) - d) < 2e-3, digits(system.motion(d).value)


def test_kappa_of_a_single_slip():
    """'.-' from the onset: |dX/dd| = |(-(1 + alpha), -alpha)| at the start, |(1 + a, a)| after."""
    system = Coulomb(*PAPER)
    assert abs(sensitivity(system, 0.5)[1] - sqrt(2.2**2 + 1.2**2)) < 1e-12
