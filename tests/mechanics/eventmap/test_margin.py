"""Margin: how far a motion is from another itinerary. It vanishes at every breakpoint."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from tests.mechanics.flow.systems import LAW_OF, random_model
from tests.sizes import slow

import stickslip as ss
from stickslip.mechanics.flow._exact_kernels import new_work, watch_both
from stickslip.mechanics.flow.system import System, new_motion


def adjacent_floats(f, low: float, high: float) -> tuple[float, float]:
    """Bisect a change of label to neighbouring doubles."""
    left = f.evaluate(low).label
    while True:
        middle = 0.5 * (low + high)
        if not low < middle < high:
            return low, high
        if f.evaluate(middle).label == left:
            low = middle
        else:
            high = middle


def breakpoints(f, grid: int):
    d = np.linspace(*f.domain, grid + 2)[1:-1]
    label = f.evaluate(d).label
    for i in np.flatnonzero(label[1:] != label[:-1]):
        yield adjacent_floats(f, d[i], d[i + 1])


# Collocation shares Taylor's `dense`.
@pytest.mark.parametrize(("stepper", "n"), [("exact", 2), ("taylor", 2), *slow(("exact", 20))])
def test_the_margin_vanishes_on_both_sides_of_every_breakpoint(stepper, n):
    rng = np.random.default_rng(31)
    models = [random_model(rng, LAW_OF[stepper]) for _ in range(n)]
    if stepper == "exact":
        models.append(ss.examples.coulomb())
    if stepper == "taylor":
        models.append(ss.examples.law9(V=0.15))
    found = 0
    for model in models:
        f = ss.event_map(model, max_events=200, threads=1)
        for low, high in breakpoints(f, 150):
            result = f.evaluate([low, high])
            if not np.all(result.status == ss.status.OK):
                continue
            # a graze shows as the square root of the distance on its side with contact
            assert np.all(result.margin < 1e-6), (model, low, result.margin, f.itinerary(low))
            found += 1
    assert found > 5


def lobes(motion, samples: int) -> list[float]:
    """Distances from the belt at which slipping blocks turned back."""
    found = []
    for start, end, modes in zip(motion.t, motion.t[1:], motion.modes, strict=False):
        t = np.linspace(start, end, samples)[1:-1]
        speed = np.abs(motion.v(t)[:, modes != 0] - motion.model.V)
        for block, values in zip(np.flatnonzero(modes), speed.T, strict=True):
            turns = 1 + np.flatnonzero((values[1:-1] < values[:-2]) & (values[1:-1] < values[2:]))
            for k in turns:

                def distance(time, block=block):
                    return abs(motion.v(time)[block] - motion.model.V)

                bounds = (t[k - 1], t[k + 1])
                best = minimize_scalar(distance, bounds=bounds, options={"xatol": 1e-9})
                found.append(best.fun)
    return found


@pytest.mark.parametrize(
    ("model", "d"),
    [
        # just beyond a graze of law (9), where one block comes close to the belt and turns back
        (ss.examples.law9(V=0.15), -0.095),
        # in the middle of a slip of both, while the other lands, and just after an event
        (ss.TwoBlock(alpha=1.78, beta=1.22, V=0.28, friction=ss.Coulomb(0.18)), -0.155),
        (ss.TwoBlock(alpha=2.6, beta=1.82, V=0.09, friction=ss.Coulomb(0.81)), 0.161),
        (ss.TwoBlock(alpha=2.56, beta=0.55, V=0.28, friction=ss.Coulomb(0.51)), 0.008),
    ],
)
def test_the_margin_of_a_lobe_is_how_far_it_stayed_from_the_belt(model, d):
    nearest = min(lobes(ss.simulate(model, d=d, until="stick"), samples=400))
    assert 0.0 < nearest < 0.1
    for limit in (np.inf, 1e300):  # in lanes, and one motion at a time
        margin = ss.event_map(model, max_time=limit).evaluate(d).margin
        assert margin == pytest.approx(nearest, rel=1e-6)


def test_the_margin_of_a_landing_is_its_distance_from_the_limit():
    # One block slips and returns at once to global stick: R = 2 mu - 1 there (alpha = 0), and
    # w' = 1 - mu; the rider has come to -1.5 + 1 + V T; no lobe turns back.
    V, mu, beta = 0.1, 0.3, 1.3
    model = ss.TwoBlock(alpha=0.0, beta=beta, V=V, friction=ss.Coulomb(mu))
    duration = 2.0 * (np.pi - np.arctan((1.0 - mu) / V))
    rider = -0.5 + V * duration
    result = ss.event_map(model).evaluate(-1.5)
    expected = min(1.0 - abs(2 * mu - 1), 1.0 - mu, beta - abs(rider))
    assert result.margin == pytest.approx(expected, rel=1e-12)


def test_simultaneous_events_have_no_margin():
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    assert f.evaluate(0.3 / 3.4).margin == 0.0
    twins = ss.event_map(model.replace(beta=1.0))
    assert twins.itinerary(0.0) == "-- .."
    assert twins.evaluate(0.0).margin == 0.0


def test_the_margin_is_positive_inside_branches():
    f = ss.event_map(ss.examples.coulomb())
    result = f.evaluate(np.linspace(*f.domain, 501)[1:-1])
    assert np.mean(result.margin > 1e-3) > 0.9


@pytest.mark.kernel
def test_a_lobe_between_two_looks_at_the_slope_is_found():
    # |w_1|' = 0.997 cos(t - c) - cos(2 (t - c)) is below 0 for 0.09; looks are 0.12 apart.
    end, c, V, mu = 0.6, 0.3, 0.2, 0.3
    system, laws, motion, work = (
        System(1.5, 1.0, V),
        np.full((2, 8), mu),
        new_motion(0, 0),
        new_work(),
    )
    swing, pull = -2.0 * 0.997 * np.sin(-c), -2.0 * 0.997 * np.cos(c)  # of the sum of both blocks
    gap, gap_pull = -np.sin(-2.0 * c), -2.0 * np.cos(2.0 * c)
    work.start_w[:] = 0.5 * (swing - gap) - V, 0.5 * (swing + gap) - V
    work.start_e[:] = mu - 0.5 * (pull - gap_pull), mu - 0.5 * (pull + gap_pull)
    motion.mode[:] = -1
    watch_both(system, laws, motion, work, end)
    t = np.linspace(0.0, end, 100_001)
    slope = 0.997 * np.cos(t - c) - np.cos(2.0 * (t - c))
    ended = np.flatnonzero((slope[:-1] < 0.0) & (slope[1:] >= 0.0))
    assert slope[::20_000].min() > 0.0
    risen = 0.997 * (np.sin(t - c) + np.sin(c)) - 0.5 * (np.sin(2.0 * (t - c)) + np.sin(2.0 * c))
    assert work.margin[0] == pytest.approx(-work.start_w[0] + risen[ended[0]], abs=1e-8)
