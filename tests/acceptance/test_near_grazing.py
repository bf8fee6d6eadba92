"""Next to breakpoints: d* +- 10^-k for k = 1.5, 2, .. 13, where sign-change finders fail."""

import numpy as np
import pytest
from tests.acceptance.judge import NOT_SETTLED, Effort, Tally, judge
from tests.acceptance.systems import around, breakpoints, case, paper_case, random_cases
from tests.reference.settle import EXCUSED, RIGHT
from tests.reference.values import COULOMB_JUMPS
from tests.sizes import sizes


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


# Breakpoints where a block lands just as a limit is reached. Forces of size one decide, of which
# doubles are coarser than of d: each was misplaced by up to 1.2e-14 before forces were compared
# as sums of two doubles.
TIES = """alpha beta V mu d
0.43219920107500687 1.5825065569857109 0.051265158000586404 0.3185670375599832 -0.0058786422610226
1.2408297155383676 0.6294857573892398 0.04557960298102941 0.07373387918736599 -0.2482170561427261
0.4827758881595271 1.8231847229003866 0.12167153350404139 0.16988565240073816 -0.0840544183234814
0.959398328799308 1.3740341291981109 0.056147256678066956 0.7555342403431949 -0.0248441919625805
0.558683479208229 1.1796893097623238 0.09038862817744359 0.10939519036839906 0.0075296603674657
0.7452104411873082 1.7394172697896315 0.029021630911724234 0.21764154153257048 -0.0116315810826945
2.293667657692368 1.9395460831944762 0.037646236342900534 0.4311640067162606 0.0061158414404934
0.2523994099034325 1.7717584367816834 0.1413017979091782 0.4780560554461513 0.008477087090139708
2.7401995454738697 1.7982548653831407 0.09148479271716016 0.3122891672395518 0.0082124479760374
1.8822250881957123 1.3609714305177874 0.27400096675932545 0.08399730362467847 -0.1152902581284754"""


def beside(row, engine, steps):
    """What the oracle says of the answers some steps to either side of a breakpoint."""
    alpha, beta, V, mu, d = map(float, row.split())
    system = case("coulomb", alpha=alpha, beta=beta, V=V, mu=mu)
    tally = Tally()
    points = np.unique(np.concatenate([d - steps, d + steps]))
    judge(tally, system, points, engine, np.random.default_rng(0), Effort(0.0, 400))
    return tally


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
@pytest.mark.parametrize("row", TIES.splitlines()[1:])
def test_ties_of_a_landing_and_a_limit_are_found_to_rounding(row, engine):
    away = beside(row, engine, np.array([2e-14, 1e-13]))
    assert away.verdicts[RIGHT] >= 2, str(away)
    assert away.verdicts.keys() <= {RIGHT, NOT_SETTLED}, str(away)
    near = beside(row, engine, np.array([0.0, 0.125, 0.5, 1.0, 4.0, 16.0, 64.0]) * 2.0**-52)
    assert near.verdicts[RIGHT] >= 1, str(near)
    assert near.verdicts.keys() <= {RIGHT, EXCUSED, NOT_SETTLED}, str(near)
    assert near.verdicts[EXCUSED] <= (4 if engine == "adaptive" else 1), str(near)


# Breakpoints where a block, or the force of a rider, just touches. The last bits of a motion
# decide: by doubles each was misplaced by 3e-16 to 1.1e-14.
TOUCHES = """alpha beta V mu d
0.32697026089550385 1.145431838219255 0.25383876775120556 0.8011532247683464 0.00998547315849245
0.3502201638319904 1.2298023463969288 0.2869874948351379 0.8916614953706845 0.21757291829271846
0.4387321515323328 1.3204849984596225 0.19841445790247295 0.7923188013201505 0.0013489980362974574
1.8099730397442493 0.6939828266798636 0.19415331759799256 0.8489754280782028 -0.0009484479886269755
2.273975100079021 1.401079538656792 0.16838905184564765 0.8544137702486747 0.0074253472842736295
2.3187666695408953 1.9617230664731613 0.22938251238434496 0.6472943253423068 -0.002268815074092818
1.1792392090789723 1.826435933084696 0.28516327603936253 0.566055006957176 0.007617850162661392
2.697335672955629 1.3610559957058355 0.012699537275263118 0.5164776966472451 0.0003026267360631025
"""


@pytest.mark.parametrize("row", TOUCHES.splitlines()[1:])
def test_touches_are_found_to_rounding(row):
    steps = np.array([0.0, 0.03125, 0.125, 0.25, 1.0, 4.0, 16.0, 64.0]) * 2.0**-52
    tally = beside(row, "exact", steps)
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] >= 3, str(tally)
    assert tally.verdicts[EXCUSED] <= 1, str(tally)


@pytest.mark.parametrize("n", sizes(1, 4))
def test_around_breakpoints_of_random_systems_of_law_9(n):
    rng = np.random.default_rng(22)
    tally = Tally()
    for system in random_cases("law9", n, rng):
        for d in rng.permutation(breakpoints(system, grid=100))[:1]:
            points = around(d, system, step=1.0)
            judge(tally, system, points, "adaptive", rng, Effort(0.0, 60))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 10 * n, str(tally)
