"""Random systems, random starts: a fixed sample of what `evidence.py` does at length."""

from dataclasses import replace

import numpy as np
import pytest
from tests.acceptance.judge import Effort, Tally, judge
from tests.acceptance.systems import case, paper_case, random_cases, random_points
from tests.reference.motion import sensitivity
from tests.reference.settle import GAVE_UP, RIGHT, settle
from tests.sizes import sizes, slow

import stickslip as ss


@pytest.mark.parametrize("n", sizes(150, 500))
@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_no_coulomb_value_is_wrong(engine, n):
    rng = np.random.default_rng(11)
    tally = Tally()
    for system in random_cases("coulomb", n, rng):
        judge(tally, system, random_points(system, 1, rng), engine, rng, Effort(0.05, 2000))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 0.9 * n, str(tally)
    assert tally.verdicts[GAVE_UP] < 0.034 * n, str(tally)


def test_no_value_of_law_9_is_wrong():
    rng = np.random.default_rng(12)
    tally = Tally()
    for system in random_cases("law9", 25, rng):
        d = random_points(system, 1, rng)
        judge(tally, system, d, "adaptive", rng, Effort(0.0, 200))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 20, str(tally)


@pytest.mark.parametrize(("kind", "n"), [("coulomb", 60), ("law9", 4)])
def test_a_belt_that_runs_backward_gives_the_mirror_image(kind, n):
    """(X, V) -> -(X, V): the oracle, whose belt may run either way, carries -d to -f(d)."""
    rng = np.random.default_rng(13)
    sides, returned = str.maketrans("+-", "-+"), 0
    for system in random_cases(kind, n, rng):
        (d,) = random_points(system, 1, rng).tolist()
        backward = replace(system, V=-system.V).oracle()
        image = backward.motion(-d, max_events=100)
        f = ss.event_map(system.model(), threads=1)
        found = f.evaluate(d)
        if image.value is None or found.margin < 1e-6:
            continue
        _, kappa = sensitivity(backward, -d, image)
        assert abs(found.value + float(image.value)) <= system.tolerance * kappa
        assert f.itinerary(d).translate(sides) == image.itinerary
        returned += 1
    assert returned > 0.8 * n


# Of law (9): changes of a state on the way grow 100 and 1500 times more than those of the start,
# by which a value is judged, and rounding is such a change.
LONG_SMOOTH_MOTIONS = {
    53: (
        {"alpha": 2.8727566161451663, "beta": 0.5587875918420768, "V": 0.2487218978467824},
        {"gamma": 3.6850487966796335, "delta": 0.4641590898481221, "eta": 0.042846242456074414},
        -0.20088331504225282,
    ),
    351: (
        {"alpha": 1.0879358318367196, "beta": 1.3841131758362284, "V": 0.07528535294069341},
        {"gamma": 0.6040974765546392, "delta": 0.10990032142622452, "eta": 0.024727645429073963},
        0.23792923517808345,
    ),
}


@pytest.mark.parametrize(
    "n_events",
    [pytest.param(n, marks=[pytest.mark.slow] * (n > 300)) for n in LONG_SMOOTH_MOTIONS],
)
def test_rounding_does_not_add_up_in_long_motions_of_law_9(n_events):
    plant, law, d = LONG_SMOOTH_MOTIONS[n_events]
    system = case("law9", **plant, **law)
    f = ss.event_map(system.model())
    assert f.evaluate(d).n_events == n_events
    for value in (f(d), f(np.array([d, d]))[0]):
        verdict = settle(
            system.oracle(), d, float(value), "OK", 0.1 * system.tolerance, max_events=400
        )
        assert verdict.verdict == RIGHT, f"{system} {verdict}"


@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_the_papers_coulomb_map_is_right_everywhere(engine):
    tally = Tally()
    system = paper_case("coulomb")
    d = np.linspace(-system.end, system.end, 1000)
    judge(tally, system, d, engine, np.random.default_rng(0))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] == 1000, str(tally)


def test_the_papers_map_of_law_9_is_right():
    tally = Tally()
    system = paper_case("law9")
    d = np.linspace(-system.end, system.end, 20)
    judge(tally, system, d, "adaptive", np.random.default_rng(0), Effort(0.0, 300))
    assert not tally.wrong, str(tally)
    assert tally.verdicts[RIGHT] > 12, str(tally)


@pytest.mark.parametrize(
    ("engine", "share"), [("exact", 0.15), *slow(("exact", 0.5)), ("adaptive", 0.1)]
)
def test_motions_without_return_are_named_alike(engine, share):
    """mu = 0.05, V = 0.2: one start in thirteen is caught by a cycle without global stick."""
    tally = Tally()
    system = paper_case("coulomb", V=0.2, mu=0.05)
    d = np.linspace(-system.end, system.end, 300)
    judge(tally, system, d, engine, np.random.default_rng(3), Effort(share))
    assert not tally.wrong, str(tally)
    assert tally.statuses["NEVER_CYCLE"] > 10, str(tally)
    assert tally.verdicts[GAVE_UP] < 5, str(tally)


@pytest.mark.parametrize("n", sizes(10, 40))
@pytest.mark.parametrize("engine", ["exact", "adaptive"])
def test_slow_returns_are_not_called_never(engine, n):
    """Returns after hundreds of events and thousands of time units, found among random systems."""
    tally = Tally()
    rng = np.random.default_rng(19)
    for system in random_cases("coulomb", n, rng):
        slow = paper_case(
            "coulomb", **dict(system.law), alpha=system.alpha, beta=system.beta, V=0.3
        )
        judge(tally, slow, random_points(slow, 5, rng), engine, rng, Effort(0.0, 3000))
    assert not tally.wrong, str(tally)


# Motions of 107 to 253 events whose rounding once added up, phase by phase, to 4e-14 kappa.
LONG_MOTIONS = [
    ((1.6441273136689696, 1.4653031273557684, 0.12338770682374306, 0.8886560846380369),
     [0.21052515829976787, 0.2103682482738563]),
    ((1.6815609248840602, 1.446738498163256, 0.13594938245262755, 0.8428526024116845),
     [0.21558767129229325, 0.2139653394979211, 0.22264192740096667]),
    ((1.5985011190501526, 0.7300899055433248, 0.1743284044446922, 0.7861647516564207),
     [-0.21888061719198598]),
    ((1.561321295284151, 0.6329625374605351, 0.2775192408110796, 0.7755844706977831),
     [-0.305270887000074, -0.3058591956684014, -0.3089231425104189]),
    ((1.6325631609373041, 1.329039812737647, 0.18923217472998607, 0.7888153474178874),
     [0.23622507335204704, 0.23703231420459264, 0.2375499216934613]),
]  # fmt: skip


@pytest.mark.parametrize("max_time", [np.inf, 1e300], ids=["lanes", "alone"])
def test_rounding_does_not_add_up_in_long_motions(max_time):
    """A limit on time, here without effect, has the engine carry each motion alone."""
    for (alpha, beta, V, mu), starts in LONG_MOTIONS:
        system = case("coulomb", alpha=alpha, beta=beta, V=V, mu=mu)
        f = ss.event_map(system.model(), max_time=max_time)
        for d in starts:
            verdict = settle(system.oracle(), d, float(f(d)), "OK", 0.1 * system.tolerance)
            assert verdict.verdict == RIGHT, f"{system} {verdict}"
