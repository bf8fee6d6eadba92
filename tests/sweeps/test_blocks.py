"""Sweeps of models with other numbers of blocks than two, and of forced ones."""

import numpy as np
import pytest
from tests.sweeps import small

import stickslip as ss

pytest.importorskip("zarr")

CHAIN = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.22))
BLOCK = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
FORCED = ss.Oscillator(
    V=0.2, friction=ss.Coulomb(mu=0.4), forcing=ss.Harmonic(amplitude=0.3, frequency=1.1)
)
PAD = ss.Structure(
    mass=[1, 1],
    stiffness=[[2, 0.35], [0.35, 1.3]],
    contacts=[ss.Contact(at=0, V=0.02, friction=ss.Coulomb(mu=0.9))],
)
SHORT = {"transient": 30, "n": 40, "max_period": 8}


def test_two_blocks_of_the_family_are_two_blocks(tmp_path):
    pair = ss.Blocks(
        mass=[1, 1],
        stiffness=[[2.2, -1.2], [-1.2, 2.2]],
        static=[1, 1.3],
        V=0.0366,
        friction=ss.Coulomb(mu=0.22),
    )
    axes = {"V": [0.0366, 0.08, 0.15], "d": [0.1, 0.279]}
    run = {"transient": 300, "n": 300}
    wanted = [
        ss.observables.Attractor(**run),
        ss.observables.LyapunovExponent(**run),
        ss.observables.Events(**run),
    ]
    found = ss.sweep(pair, axes, wanted, store=tmp_path / "pair", threads=1)
    expected = ss.sweep(ss.examples.coulomb(), axes, wanted, store=tmp_path / "two", threads=1)
    np.testing.assert_array_equal(found.kind, expected.kind)
    np.testing.assert_array_equal(found.period, expected.period)
    settled = (expected.kind == 1).values
    assert settled.sum() >= 4
    for name in ("lyapunov_exponent", "mean_events", "mean_duration"):
        a, b = found[name].values[settled], expected[name].values[settled]
        np.testing.assert_allclose(a, b, rtol=1e-6)


def test_orbits_of_a_chain_are_those_of_its_event_map(tmp_path):
    wanted = [
        ss.observables.Attractor(**SHORT),
        ss.observables.LyapunovExponent(**SHORT),
        ss.observables.Events(**SHORT),
        ss.observables.NeverReturns(n_starts=6, n=5),
        ss.observables.Function(function=small.start_of, shape=(2,)),
    ]
    speeds = [0.05, 0.3, 1.5]
    found = ss.sweep(CHAIN, {"V": speeds}, wanted, store=tmp_path / "x", threads=1)
    for V in speeds:
        here, f = found.sel(V=V), ss.event_map(CHAIN.replace(V=V))
        start = here.start_of.values
        assert f.contains(start)
        orbit = f.iterate(start, 70)
        if np.isnan(orbit[-1]).any():
            assert here.kind == 0
            assert here.status != 0
            continue
        motions = f.evaluate(orbit[30:-1])
        np.testing.assert_allclose(here.mean_events, motions.n_events.mean(), rtol=1e-14)
        np.testing.assert_allclose(here.mean_duration, motions.duration.mean(), rtol=1e-14)
        if here.kind == 1:
            p = int(here.period)
            np.testing.assert_allclose(orbit[-1], orbit[-1 - p], rtol=0, atol=1e-8)
            product = np.linalg.multi_dot([*motions.derivative[-p:][::-1], np.eye(2)])
            radius = np.abs(np.linalg.eigvals(product)).max()
            np.testing.assert_allclose(here.lyapunov_exponent, np.log(radius) / p, rtol=1e-14)
    # A fast belt leaves all blocks sliding for ever.
    assert found.never_share.values[-1] > found.never_share.values[0]


def test_a_chain_is_the_same_in_any_chunks(tmp_path):
    axes = {"V": (0.05, 0.3, 4), "alpha": [0.8, 1.2]}
    wanted = [ss.observables.LyapunovExponent(**SHORT)]
    one = ss.sweep(CHAIN, axes, wanted, store=tmp_path / "a", chunks={"V": 1, "alpha": 2})
    other = ss.sweep(CHAIN, axes, wanted, store=tmp_path / "b", chunks={"V": 3, "alpha": 1})
    assert one.lyapunov_exponent.values.tobytes() == other.lyapunov_exponent.values.tobytes()


@pytest.mark.parametrize(
    ("model", "axes"),
    [(BLOCK, {"V": [0.2, 0.4]}), (FORCED, {"forcing.frequency": [0.9, 1.1]})],
    ids=["one block", "forced"],
)
def test_limit_cycles_of_one_block(model, axes, tmp_path):
    wanted = [ss.observables.LimitCycles(n_starts=4), small.mass_of]
    found = ss.sweep(model, axes, wanted, store=tmp_path / "x", threads=1)
    (name, values), *_ = axes.items()
    for value in values:
        here = found.sel({name: value})
        cycles = [c for c in ss.limit_cycles(model.replace(**{name: value}), rng=0) if c.stable]
        assert 1 <= here.n_cycles <= len(cycles)
        near = min(cycles, key=lambda c: abs(c.period - float(here.cycle_period)))
        np.testing.assert_allclose(here.cycle_period, near.period, rtol=1e-8)
        assert here.cycle_events == len(near.events)
        assert here.cycle_multiplier < 1
        assert here.mass_of == 1.0


@pytest.mark.parametrize(
    ("system", "wanted", "more", "words"),
    [
        (BLOCK, "attractor", {}, "observable 'attractor': a single block has no event map"),
        (PAD, "attractor", {}, "a model of more than blocks on a belt has no event map"),
        (ss.return_map(PAD, domain=[(0, 1), (0, 1)]), "attractor", {}, "if that is one of a line"),
        (FORCED, "never_returns", {}, "observable 'never_returns': a forced model has no event"),
        (CHAIN, "coexisting_attractors", {}, "of the event map of 3 blocks are not numbers"),
        (CHAIN, "orbit_points", {}, "of the event map of 3 blocks are not numbers"),
        (CHAIN, "attractor", {"d": 0.1}, "d: points of the event map of 3 blocks"),
        (CHAIN, "attractor", {"device": "cuda"}, "orbits of two undamped blocks"),
    ],
)
def test_what_a_system_does_not_have_is_refused(system, wanted, more, words, tmp_path):
    with pytest.raises(ValueError, match=words):
        ss.sweep(system, {"V": [0.1, 0.2]}, [wanted], store=tmp_path / "x", **more)
    assert not list(tmp_path.iterdir())


def test_a_store_of_another_chain_is_refused(tmp_path):
    wanted = [ss.observables.NeverReturns(n_starts=2, n=2)]
    ss.sweep(CHAIN, {"V": [0.1]}, wanted, store=tmp_path / "x")
    other = ss.Chain(
        static=[1, 1.3, 1.1], alpha=1.2, V=0.05, friction=ss.Coulomb(mu=0.22), ends="fixed"
    )
    with pytest.raises(ValueError, match=r"holds another sweep: system\.structure"):
        ss.sweep(other, {"V": [0.1]}, wanted, store=tmp_path / "x")
