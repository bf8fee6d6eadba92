"""What a sweep records: against the maps themselves, and whatever way it was run."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.sweeps import small

import stickslip as ss

pytest.importorskip("zarr")

ROUNDING = 1e-12


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    return small.run(tmp_path_factory.mktemp("sweeps") / "whole").load()


def test_a_sweep_is_labelled(done):
    assert done.kind.dims == ("V", "alpha")
    assert done.orbit.dims == ("V", "alpha", "iterate")
    np.testing.assert_array_equal(done.V, np.linspace(0.03, 0.05, 12))
    assert done.kind.attrs["flag_meanings"] == "undecided left periodic chaotic"
    assert done.attrs["done"] == done.attrs["chunks"] == 12
    assert done.attrs["description"]["seed"] == 0
    assert done.attrs["target"]["device"] == "cpu"


@given(data=st.data())
@settings(max_examples=8)
def test_orbits_are_those_of_the_event_map(done, data, tmp_path_factory):
    at = {name: data.draw(st.sampled_from(done[name].values.tolist())) for name in ("V", "alpha")}
    d = data.draw(st.floats(-0.4, 0.4))
    model = ss.examples.coulomb().replace(**at)
    run = {"transient": 40, "n": 64}
    found = ss.sweep(
        model,
        {"d": [d]},
        [ss.observables.OrbitPoints(**run, count=65), ss.observables.Events(**run)],
        store=tmp_path_factory.mktemp("sweeps") / "one",
        threads=1,
    )
    f = ss.event_map(model)
    orbit = found.orbit[0].values
    np.testing.assert_allclose(orbit[1:], f(orbit[:-1]), rtol=0, atol=ROUNDING)
    motions = f.evaluate(orbit[:-1])
    np.testing.assert_allclose(found.mean_events[0], motions.n_events.mean(), rtol=ROUNDING)
    np.testing.assert_allclose(found.mean_duration[0], motions.duration.mean(), rtol=1e-10)
    assert found.most_events[0] == motions.n_events.max()


def test_the_exponent_is_the_mean_of_log_slopes(tmp_path):
    model = ss.examples.coulomb()
    found = ss.sweep(
        model,
        {"V": [0.0366, 0.0371, 0.045], "d": [0.1, 0.279]},
        ["attractor", "lyapunov_exponent", ss.observables.OrbitPoints(count=1001)],
        store=tmp_path / "x",
        threads=1,
    )
    for V in found.V.values:
        f = ss.event_map(model.replace(V=V))
        for d in found.d.values:
            here = found.sel(V=V, d=d)
            path = here.orbit.values
            logs = np.log(np.abs(f.derivative(path[:-1])))
            steps = int(here.period) or 1000
            expected = logs[-steps:].mean()
            np.testing.assert_allclose(here.lyapunov_exponent, expected, rtol=1e-9)
            if here.period:
                assert abs(path[-1] - path[-1 - steps]) < 1e-9
                assert here.kind == 1


def test_the_paper_s_attractors_are_found_from_their_orbits(tmp_path):
    # S1 and S4 of figure 5 coexist; which one is reached depends on the start alone.
    model = ss.examples.coulomb()
    orbits = {p: ss.periodic_orbits(model, period=p) for p in (1, 4)}
    starts = {p: next(o for o in orbits[p] if o.stable).points[0] for p in orbits}
    values = sorted(starts.values())
    found = ss.sweep(model, {"d": values}, ["attractor"], store=tmp_path / "x", threads=1)
    periods = {d: int(p) for d, p in zip(values, found.period.values, strict=True)}
    assert periods == {d: p for p, d in starts.items()}


def test_coexisting_attractors_are_counted(tmp_path):
    model = ss.examples.coulomb()
    speeds = [0.0366, 0.08, 0.15]
    found = ss.sweep(
        model,
        {"V": speeds},
        [ss.observables.CoexistingAttractors(n_starts=12), "never_returns"],
        store=tmp_path / "x",
        threads=1,
    )
    expected = [len(ss.attractors(model.replace(V=V))) for V in speeds]
    assert found.n_attractors.values.tolist() == expected == [2, 2, 1]
    assert (found.left_share == 0).all()
    assert (found.never_share == 0).all()


def test_motions_that_never_return_are_counted(tmp_path):
    # A fast belt leaves the blocks sliding for ever.
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.3, friction=ss.Coulomb(mu=0.22))
    speeds = [0.05, 0.9, 1.8]
    found = ss.sweep(
        model,
        {"V": speeds},
        [ss.observables.NeverReturns(n_starts=20, n=30)],
        store=tmp_path / "x",
        threads=1,
    )
    for V, share in zip(speeds, found.never_share.values, strict=True):
        f = ss.event_map(model.replace(V=V))
        low, high = f.domain
        rough = np.isnan(f.iterate(np.linspace(low, high, 22)[1:-1], 30)[:, -1]).mean()
        assert abs(share - rough) <= 0.25
    assert found.never_share.values[0] < found.never_share.values[-1]
    assert (found.gave_up_share == 0).all()


def test_a_start_outside_the_domain_is_data(tmp_path):
    found = ss.sweep(
        ss.examples.coulomb(), {"d": [-5.0, 0.1]}, ["attractor"], store=tmp_path / "x", threads=1
    )
    assert found.kind.values.tolist()[0] == 0
    assert found.status.values.tolist() == [-2, 0]


@pytest.mark.parametrize(
    ("function", "parameter", "values", "kinds", "periods", "exponents"),
    [
        # Closed forms: superstable fixed point, 2-cycle with multiplier 4 + 2r - r^2, full chaos.
        (
            small.logistic,
            "r",
            [2.5, 3.3, 4.0],
            [1, 1, 2],
            [1, 2, 0],
            [np.log(0.5), np.log(0.29) / 2, np.log(2)],
        ),
        (small.tent, "s", [0.8, 1.9], [1, 2], [1, 0], [np.log(0.8), np.log(1.9)]),
    ],
)
def test_maps_with_known_answers(tmp_path, function, parameter, values, kinds, periods, exponents):
    f = ss.PiecewiseMap(function, (0, 1), parameters={parameter: values[0]})
    found = ss.sweep(
        f,
        {parameter: values},
        [
            ss.observables.Attractor(transient=300, n=400),
            ss.observables.LyapunovExponent(transient=300, n=400),
            ss.observables.CoexistingAttractors(n_starts=3, transient=300, n=400),
        ],
        store=tmp_path / "x",
        threads=1,
    )
    assert found.kind.values.tolist() == kinds
    assert found.period.values.tolist() == periods
    assert found.n_attractors.values.tolist() == [1] * len(values)
    np.testing.assert_allclose(found.lyapunov_exponent, exponents, rtol=0, atol=0.03)


def test_parameters_of_the_law_and_damping_vary_too(tmp_path):
    model = ss.examples.coulomb()
    axes = {"mu": [0.2, 0.3], "viscous": [0.0, 0.05], "damping": [0.0, 0.02], "d": [0.1]}
    found = ss.sweep(
        model,
        axes,
        [ss.observables.OrbitPoints(transient=2, n=3, count=2, max_period=1)],
        store=tmp_path / "x",
        threads=1,
    )
    for at in found.orbit.isel(iterate=-1).stack(point=list(axes)).T:
        values = {name: float(at[name]) for name in axes if name != "d"}
        expected = ss.event_map(model.replace(**values)).iterate(0.1, 5)[-1]
        np.testing.assert_allclose(float(at), expected, rtol=0, atol=ROUNDING)


def test_law_9_and_a_law_for_each_block(tmp_path):
    laws = (ss.PoppStelter(gamma=3.0), ss.Coulomb(mu=0.3))
    model = ss.examples.law9().replace(friction=laws)
    found = ss.sweep(
        model,
        {"gamma_1": [2.0, 3.0], "mu_2": [0.2, 0.3], "d": [0.3]},
        [ss.observables.OrbitPoints(transient=0, n=2, count=1, max_period=1)],
        store=tmp_path / "x",
        threads=1,
    )
    for gamma in found.gamma_1.values:
        for mu in found.mu_2.values:
            f = ss.event_map(model.replace(gamma_1=gamma, mu_2=mu))
            np.testing.assert_array_equal(
                found.orbit.sel(gamma_1=gamma, mu_2=mu)[0, 0], f.iterate(0.3, 2)[-1]
            )


@pytest.mark.parametrize("chunks", [{}, {"V": 2, "gamma": 1}], ids=str)
def test_orbits_under_law_9_share_pools_and_are_those_of_each_map(tmp_path, chunks):
    model = ss.examples.law9()
    axes = {"V": [0.1, 0.15, 0.3], "gamma": [2.5, 3.0], "damping": [0.0, 0.01]}
    run = {"transient": 30, "n": 20}
    o = ss.observables
    wanted = [o.OrbitPoints(**run, count=8), o.Events(**run), o.Attractor(**run)]
    found = ss.sweep(model, axes, wanted, store=tmp_path / "x", chunks=chunks, d=0.6, threads=1)
    for V, gamma, damping in itertools.product(*axes.values()):
        at = {"V": V, "gamma": gamma, "damping": damping}
        f = ss.event_map(model.replace(**at))
        orbit, here = f.iterate(0.6, 50), found.sel(at)
        if np.isnan(orbit[-1]):
            assert np.isnan(here.orbit).all()
            assert here.status == f.evaluate(orbit[np.isfinite(orbit)][-1]).status
        else:
            np.testing.assert_array_equal(here.orbit, orbit[-8:])
            motions = f.evaluate(orbit[-21:-1])
            assert here.most_events == motions.n_events.max()
            assert here.mean_duration == motions.duration.mean()


def test_a_user_s_function_is_recorded(tmp_path):
    model = ss.examples.coulomb()
    wanted = [
        small.second_iterate,
        ss.observables.Function(function="tests.sweeps.small:both", shape=(2,), label="pair"),
    ]
    found = ss.sweep(model, {"V": (0.03, 0.04, 3)}, wanted, store=tmp_path / "x", d=0.1)
    assert found.pair.dims == ("V", "pair_0")
    for V in found.V.values:
        f = ss.event_map(model.replace(V=V))
        assert found.second_iterate.sel(V=V) == f(f(0.1))
        np.testing.assert_array_equal(found.pair.sel(V=V), [0.1, f(0.1)])


@pytest.mark.parametrize(
    "more",
    [{"chunks": {"V": 12, "alpha": 1}}, {"chunks": {"V": 5, "alpha": 7}}, {"threads": 3}],
    ids=str,
)
def test_values_depend_neither_on_chunks_nor_on_threads(done, tmp_path, more):
    found = small.run(tmp_path / "other", **more)
    for name in done.data_vars:
        assert found[name].values.tobytes() == done[name].values.tobytes()


def test_other_seeds_start_elsewhere(done, tmp_path):
    found = small.run(tmp_path / "other", rng=1)
    assert (found.orbit.values != done.orbit.values).mean() > 0.2
