"""Next to breakpoints: d* +- 10^-k for k = 1.5, 2, .. 13, where sign-change finders fail."""

import numpy as np
import pytest
from tests.acceptance.judge import Effort, Tally, judge
from tests.acceptance.systems import around, breakpoints, paper_case, random_cases
from tests.reference.settle import EXCUSED, RIGHT
from tests.reference.values import COULOMB_JUMPS


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_around_the_jumps_of_the_papers_coulomb_map(engine):
    system = paper_case("coulomb")
    tally = Tally()
    for d, _, _ in COULOMB_JUMPS:
        judge(tally, system, around(float(d), system), engine, np.random.default_rng(0))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[EXCUSED] <= 2 * len(COULOMB_JUMPS), str(tally)
    assert tally.verdicts[RIGHT] > 290 - 12, str(tally)


def test_the_product_finds_the_six_jumps_to_adjacent_doubles():
    system = paper_case("coulomb")
    found = np.array(breakpoints(system, grid=2000))
    for d, _, _ in COULOMB_JUMPS:
        assert np.min(np.abs(found - float(d))) <= 1e-14


def test_around_the_breakpoints_of_the_papers_map_of_law_9():
    """The cusp at d = 0.3815 (figure 12) and its neighbours in the paper's window."""
    system = paper_case("law9")
    tally = Tally()
    window = [d for d in breakpoints(system, grid=1200) if 0.38 < d < 0.384]
    assert any(abs(d - 0.3815) < 1e-3 for d in window)
    for d in window:
        points = around(d, system, step=1.0)
        judge(tally, system, points, "adaptive", np.random.default_rng(0), Effort(0.0, 300))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 20, str(tally)


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_around_breakpoints_of_random_coulomb_systems(engine):
    rng = np.random.default_rng(21)
    tally = Tally()
    for system in random_cases("coulomb", 8, rng):
        for d in rng.permutation(breakpoints(system, grid=200))[:2]:
            judge(tally, system, around(d, system), engine, rng, Effort(0.02, 2000))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 300, str(tally)


def test_around_breakpoints_of_random_systems_of_law_9():
    rng = np.random.default_rng(22)
    tally = Tally()
    for system in random_cases("law9", 2, rng):
        for d in rng.permutation(breakpoints(system, grid=100))[:1]:
            points = around(d, system, step=1.0)
            judge(tally, system, points, "adaptive", rng, Effort(0.0, 60))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 20, str(tally)
