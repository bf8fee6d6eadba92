"""Orbits of many models side by side: against one motion at a time, and whatever is beside them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import stickslip as ss
from stickslip.mechanics.eventmap import follow as following
from stickslip.mechanics.eventmap.follow import follow
from stickslip.mechanics.eventmap.records import Controls, ModelTable
from stickslip.mechanics.flow.engine import engine_for

ROUNDING = 1e-14  # relative to how much the motion's events magnify it
CONTROLS = Controls(rtol=1e-15, max_events=2000, max_time=np.inf)


def random_models(seed, count):
    """Parameters of random systems, and a start in the domain of each."""
    rng = np.random.default_rng(seed)
    alpha, beta = rng.uniform(0, 3, count), rng.uniform(0.5, 2, count)
    mu = rng.uniform(0, 0.9, (count, 2))
    V = rng.uniform(0.005, 0.3, count)
    laws = np.stack([engine_for(model_at(1.0, 1.0, 1.0, pair)).laws for pair in mu.tolist()])
    every = np.arange(count)
    end = (1 + beta) / (1 + 2 * alpha)
    return ModelTable(alpha, beta, V, laws, every, every), rng.uniform(-end, end)


def model_at(alpha, beta, V, mu):
    return ss.TwoBlock(alpha=alpha, beta=beta, V=V, friction=tuple(map(ss.Coulomb, mu)))


def followed(models, starts, *, transient=1, n=3, tail=3):
    engine = engine_for(ss.examples.coulomb())
    return follow(
        engine,
        models,
        starts,
        controls=CONTROLS,
        transient=transient,
        n=n,
        max_period=1,
        tail=tail,
    )


def of_some(models, chosen):
    return models._replace(of_start=models.of_start[chosen])


@pytest.mark.parametrize("seed", range(3))
def test_lanes_say_what_the_map_of_each_model_says(seed, monkeypatch):
    held = []
    make = following._batch
    monkeypatch.setattr(following, "_batch", lambda *sizes: held.append(make(*sizes)) or held[0])
    models, starts = random_models(seed, 100)
    verdicts, found = followed(models, starts, transient=0, n=1, tail=1)
    mu = models.laws[:, :, 1]
    for i in range(starts.size):
        f = ss.event_map(
            model_at(models.alpha[i], models.beta[i], models.V[i], mu[i].tolist()),
            max_events=CONTROLS.max_events,
            max_time=1e300,  # one motion at a time
        )
        motion = f.evaluate(starts[i])
        assert found.status[i] == motion.status
        if motion.status != 0:
            assert verdicts.kind[i] == 0
            assert np.isnan(found.tail[i, 0])
            assert np.isnan(found.mean_duration[i])
            continue
        slope = max(1.0, abs(motion.derivative))
        np.testing.assert_allclose(
            found.tail[i, 0], motion.value, rtol=0, atol=100 * ROUNDING * slope
        )
        np.testing.assert_allclose(found.mean_duration[i], motion.duration, rtol=1e-10)
        assert found.mean_events[i] == found.most_events[i] == motion.n_events
        assert held[0].label[i, 0] == motion.label
        if motion.derivative != 0:
            exponent = np.log(abs(motion.derivative))
            np.testing.assert_allclose(verdicts.exponent[i], exponent, rtol=1e-7, atol=1e-9)


@given(data=st.data())
@settings(max_examples=15)
def test_an_orbit_is_the_same_whatever_is_beside_it(data):
    models, starts = random_models(7, 60)
    whole = followed(models, starts)
    chosen = np.array(data.draw(st.lists(st.integers(0, 59), min_size=1, max_size=20)))
    part = followed(of_some(models, chosen), starts[chosen])
    for results, some in zip(whole, part, strict=True):
        for array, piece in zip(results, some, strict=True):
            assert array[chosen].tobytes() == piece.tobytes()


def test_slots_are_used_again(monkeypatch):
    models, starts = random_models(3, 60)
    whole = followed(models, starts)
    monkeypatch.setattr(following, "LEAST_SLOTS", 7)
    monkeypatch.setattr(following, "PATH_POINTS", 1)
    part = followed(models, starts)
    for results, some in zip(whole, part, strict=True):
        for array, piece in zip(results, some, strict=True):
            assert array.tobytes() == piece.tobytes()
