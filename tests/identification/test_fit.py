"""Known parameters from synthetic measurements, what data cannot tell, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy import stats
from tests.sizes import slow

import stickslip as ss
from stickslip.identification.fit import Loss
from stickslip.identification.terms import FEW, term_of

BLOCK = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)
FORCED = ss.Oscillator(
    V=0.0, friction=ss.Coulomb(mu=0.5), damping=0.2, forcing=ss.Harmonic(1.5, frequency=0.7)
)
T = np.linspace(0.0, 60.0, 600)


def noisy(values: np.ndarray, seed: int = 1, share: float = 0.01) -> tuple[np.ndarray, float]:
    """Values with normal errors, and their standard error: a share of the scatter."""
    sigma = share * float(values.std())
    rng = np.random.default_rng(seed)
    return values + rng.normal(scale=sigma, size=values.shape), sigma


def record(model, seed: int = 1, **start) -> ss.Record:  # type: ignore[no-untyped-def,name-defined]
    x, sigma = noisy(ss.simulate(model, t_end=T[-1], **start).x(T), seed)
    return ss.Record(T, x, sigma=sigma)


def inside(found, true: dict[str, float], times: float = 4.0) -> bool:  # type: ignore[no-untyped-def]
    """Whether all estimates are within some standard errors of the true values."""
    off = found.values - np.array([true[name] for name in found.parameters])
    return bool((np.abs(off) < times * found.standard_errors).all())


@pytest.mark.parametrize("factor", [0.7, 1.3])
def test_an_oscillator_is_recovered_from_thirty_per_cent_off(factor: float) -> None:
    names = ("mu", "speed", "damping")
    true = {name: BLOCK.parameters[name] for name in names}
    begun = BLOCK.replace(**{name: factor * value for name, value in true.items()})
    found = ss.fit(begun, record(BLOCK, x=[0.0], v=[0.0]), names)
    assert found.converged
    assert inside(found, true)
    assert 0.8 < found.chi2 / found.n_free < 1.2
    assert found.scale == 1.0
    assert found.message == "converged"


@pytest.mark.parametrize("pieces", [None, 5])
@pytest.mark.parametrize("zero", [-20.0, *slow(0.3)])
def test_a_sensor_may_count_from_anywhere(zero: float, pieces: int | None) -> None:
    seen = record(BLOCK, x=[0.0], v=[0.0])
    names = ("mu", "speed")
    begun = BLOCK.replace(mu=0.65, speed=0.2)
    known = ss.fit(begun, seen, names)
    shifted = ss.Record(T, np.asarray(seen.x) + zero, sigma=seen.sigma, free_zero=True)
    found = ss.fit(begun, shifted, names, pieces=pieces)
    assert found.message == "converged"
    assert found.n_unknowns == known.n_unknowns + 1
    assert inside(found, {name: BLOCK.parameters[name] for name in names})
    assert (found.standard_errors > known.standard_errors).all()
    assert 0.8 < found.chi2 / found.n_free < 1.2
    told = float(found.matched[0].rpartition(" ")[2])
    assert abs(told - zero) < 0.01
    again = found.profile("mu", found.values[:1])
    np.testing.assert_allclose(again.root, 0.0, rtol=0, atol=0.05)


@pytest.mark.parametrize("zeros", [[3.0, -8.0], [300.0, -800.0]])
def test_each_of_two_blocks_may_be_counted_from_elsewhere(zeros: list[float]) -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3))
    seen = record(model, d=0.1)
    shifted = ss.Record(T, np.add(seen.x, zeros), sigma=seen.sigma, free_zero=True)
    found = ss.fit(model.replace(mu=0.27, V=0.103), shifted, ["mu", "V"])
    assert inside(found, {"mu": 0.3, "V": 0.1})
    assert 0.8 < found.chi2 / found.n_free < 1.2


def test_where_a_sensor_counts_from_is_a_matter_of_displacements() -> None:
    with pytest.raises(ValueError, match="free_zero: there are no displacements"):
        ss.Record(T, v=np.sin(T), free_zero=True)


def test_what_is_missing_is_left_out(tmp_path: Path) -> None:
    seen, rng = record(BLOCK, x=[0.0], v=[0.0]), np.random.default_rng(4)
    keep = rng.random(len(T)) > 0.3
    x = np.where(keep, seen.x[:, 0], np.nan)
    names, begun = ("mu", "speed"), BLOCK.replace(mu=0.45)
    fewer = ss.fit(begun, ss.Record(T[keep], x[keep], sigma=seen.sigma), names)
    missing = ss.Record(T, x, np.full(len(T), np.nan), sigma=np.where(keep, seen.sigma, np.nan))
    found = ss.fit(begun, missing, names)
    np.testing.assert_allclose(found.values, fewer.values, rtol=1e-6)
    np.testing.assert_allclose(found.covariance, fewer.covariance, rtol=1e-4)
    assert found.n_free == fewer.n_free
    assert found.message == "converged"
    np.testing.assert_allclose(found.autocorrelation, fewer.autocorrelation, rtol=0, atol=1e-4)
    assert found.differentiated[0].all()
    assert len(found.fitted[0]) == len(T)  # the model's motion is known everywhere
    found.save(tmp_path / "fit.json")
    assert ss.load(tmp_path / "fit.json") == found


@pytest.mark.parametrize("fast", ["x", "v"])
def test_channels_may_have_rates_of_their_own(fast: str) -> None:
    motion, rng = ss.simulate(BLOCK, [0.0], [0.0], t_end=T[-1]), np.random.default_rng(7)
    values, errors = {}, {}
    for name in ("x", "v"):
        exact = getattr(motion, name)(T)
        errors[name] = 0.01 * exact.std()
        values[name] = exact + rng.normal(scale=errors[name], size=exact.shape)
        values[name][np.arange(len(T)) % (1 if name == fast else 10) > 0] = np.nan
    seen = ss.Record(T, **values, sigma=errors["x"], sigma_v=errors["v"])
    found = ss.fit(BLOCK.replace(mu=0.4, speed=0.25), seen, ["mu", "speed"])
    assert found.message == "converged"
    assert inside(found, {"mu": 0.5, "speed": 0.3})
    assert found.n_free == 660 - 4
    assert 0.8 < found.chi2 / found.n_free < 1.2


def test_records_at_several_speeds_of_the_belt_share_the_other_parameters() -> None:
    names, t, seen = ("mu", "speed"), T[:200], []
    for seed, V in enumerate((0.15, 0.3)):
        x, sigma = noisy(ss.simulate(BLOCK.replace(V=V), [0.0], [0.0], t_end=20.0).x(t), seed)
        seen.append(ss.Record(t, x, sigma=sigma, x0=[0.0], v0=[0.0], V=V))
    begun = BLOCK.replace(mu=0.48, V=0.22)  # the model's own does not matter
    found = ss.fit(begun, seen, names, pieces=1)
    assert found.message == "converged"
    assert inside(found, {"mu": 0.5, "speed": 0.3})
    assert 0.8 < found.chi2 / found.n_free < 1.2
    alone = [
        ss.fit(begun.replace(V=each.V), replace(each, V=None), names, pieces=1) for each in seen
    ]
    told = sum(np.linalg.inv(each.covariance) for each in alone)
    np.testing.assert_allclose(np.linalg.inv(told), found.covariance, rtol=0.1)
    with_belt = ss.fit(BLOCK, seen[:1], ["mu", "V"], priors={"V": (0.2, 0.01)}, pieces=1)
    assert with_belt.values[1] == pytest.approx(0.2, rel=1e-9)  # told by the prior alone
    assert with_belt.standard_errors[1] == pytest.approx(0.01, rel=1e-9)
    belts = [ss.Contact(at=k, friction=ss.Coulomb(mu=0.5), V=0.1 + k) for k in (0, 1)]
    with pytest.raises(ValueError, match=r"data 1 \(Record\): V is that of blocks on one belt"):
        ss.fit(ss.Structure(mass=[1, 1], stiffness=np.eye(2), contacts=belts), seen, [])


@pytest.mark.parametrize("tau", [0.001, 0.02, 0.2])
def test_what_is_known_besides_weighs_as_much_as_data_of_that_scatter(tau: float) -> None:
    y = 0.5 + np.random.default_rng(5).normal(scale=0.1, size=12)
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    found = ss.fit(
        block, ss.ForcePoints(np.linspace(0.1, 1, 12), y), ["mu"], priors={"mu": (0.45, tau)}
    )
    mu = 0.5
    for _ in range(100):  # of a mean with a scatter that is estimated
        weights = np.array([12.0 / np.mean((y - mu) ** 2), tau**-2])
        mu = weights @ [y.mean(), 0.45] / weights.sum()
    assert found.values[0] == pytest.approx(mu, abs=1e-5)
    assert found.standard_errors[0] == pytest.approx(weights.sum() ** -0.5, rel=1e-3)
    np.testing.assert_allclose(found.profile("mu").interval, found.intervals[0], rtol=1e-4)
    assert found.priors[0, 1] == tau


def test_what_the_data_cannot_part_has_the_error_of_what_is_known_besides() -> None:
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4, viscous=0.1))
    for noise in (1e-3, 1e-6):
        y = 0.55 + np.random.default_rng(5).normal(scale=noise, size=12)
        seen = ss.ForcePoints(np.full(12, 0.5), y)
        found = ss.fit(block, seen, ["mu", "viscous"], priors={"viscous": (0.1, 0.02)})
        np.testing.assert_allclose(found.standard_errors, [0.01, 0.02], rtol=1e-2)


def test_an_outlier_is_told_with_its_place() -> None:
    seen = record(BLOCK, x=[0.0], v=[0.0])
    x = seen.x.copy()
    x[77] += 1.0
    found = ss.fit(BLOCK, replace(seen, x=x), ["mu"], pieces=1)
    assert "data 1: x of block 1 at t = 7.71285 is" in found.message
    assert ss.fit(BLOCK, replace(seen, x=x), ["mu"], pieces=1, loss="huber").message == "converged"
    x[77] = 500.0
    with pytest.raises(ValueError, match=r"data 1 .* x reaches 500 \(block 1, t = 7.71285\)"):
        ss.fit(BLOCK, replace(seen, x=x), ["mu"])


def test_what_lies_within_its_error_is_no_outlier() -> None:
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    y = 0.4 + 0.02 * np.array([0.0, 1.0, 0.0, -1.0, 0.0])
    found = ss.fit(block, ss.ForcePoints(np.full(5, 0.5), y, sigma=0.02), ["mu"])
    assert found.message == "converged"  # it was infinitely many times as far off as most


def test_two_blocks_are_recovered_with_the_speed_of_the_belt() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3))
    true = {"mu": 0.3, "beta": 1.3, "V": 0.1}
    begun = model.replace(mu=0.25, beta=1.2, V=0.11)
    found = ss.fit(begun, record(model, d=0.1), tuple(true))
    assert inside(found, true)
    assert 0.8 < found.chi2 / found.n_free < 1.2


@pytest.mark.parametrize(
    ("begin", "seed", "factors"), [(10, 3, (0.7, 1.3)), (10, 12, (1.3, 1.3)), (0, 0, (0.7, 0.7))]
)
def test_a_record_of_blocks_that_ride_for_long(
    begin: float, seed: int, factors: tuple[float, float]
) -> None:
    # Kinetic friction does not hold what static friction does: no start may let a riding block go.
    model = ss.examples.coulomb()
    t = np.linspace(begin, begin + 60.0, 600)
    x = ss.simulate(model, d=0.1, t_end=t[-1]).x(t)
    sigma = 0.01 * float(x.std(axis=0).max())
    x = x + np.random.default_rng([2, seed]).normal(scale=sigma, size=x.shape)
    released = {} if begin else {"d": x[0, 1] - x[0, 0], "free_start": True}
    data = ss.Record(t, x, sigma=sigma, **released)
    true = {name: model.parameters[name] for name in ("mu", "V")}
    begun = {name: factor * true[name] for name, factor in zip(true, factors, strict=True)}
    found = ss.fit(model.replace(**begun), data, tuple(true))
    assert found.message == "converged"
    assert found.pieces == 1
    assert inside(found, true)


def test_the_velocity_of_a_riding_block_is_no_unknown() -> None:
    model, t = ss.examples.coulomb(), np.linspace(10.0, 70.0, 601)
    motion = ss.simulate(model, d=0.1, t_end=70.0)
    term = term_of(ss.Record(t, motion.x(t)), model, 20)
    rides = motion.v(t[term.first]) == model.V
    assert rides.any()
    assert (~rides).any()
    moves = np.array(term.moves)
    assert moves[:, :2].all()
    assert (moves[:, 2:] == ~rides).all()
    states = term.states(model, term.start).reshape(-1, 4)
    assert (states[:, 2:][rides] == model.V).all()
    assert term.n_unknown == moves[0].sum()
    smooth = ss.examples.law9()  # static and kinetic friction are one at rest: nothing is lost
    seen = ss.Record(t, ss.simulate(smooth, d=0.38, t_end=70.0).x(t))
    assert np.array(term_of(seen, smooth, 20).moves).all()


def test_a_ride_that_alone_tells_the_speed_of_the_belt_is_told() -> None:
    # The motion never sticks, so that any faster belt does as well, unless the record begins with
    # a ride, which its first samples do not rule out.
    block, t = ss.Oscillator(V=3.0, friction=ss.Coulomb(mu=0.5), damping=0.02), T[:400]
    values, sigma = noisy(ss.simulate(block, [0.3], [2.0], t_end=t[-1]).x(t))
    slips = ss.Record(t, values, sigma=sigma)
    rides = replace(slips, x0=[0.3], v0=[2.0], free_start=True)
    found = ss.fit(block, slips, ["mu", "V"])
    assert found.undetermined == ("V",)
    assert "ride" not in repr(found)
    found = ss.fit(block.replace(V=2.0), rides, ["mu", "V"])
    assert not found.undetermined
    assert "400 values of a record, block 1 taken to ride at its start" in repr(found)


@pytest.mark.parametrize("x", [0.7, 1.2])
def test_a_start_that_slips_about_as_fast_as_the_belt_is_no_ride(x: float) -> None:
    block, t = ss.Oscillator(V=0.3, friction=ss.Coulomb(mu=0.4)), np.linspace(0.0, 40.0, 400)
    values, sigma = noisy(ss.simulate(block, [x], [0.24], t_end=t[-1]).x(t))
    begun = block.replace(V=0.27, mu=0.36)
    found = ss.fit(begun, ss.Record(t, values, sigma=sigma), ["mu", "V"])
    assert found.message == "converged"
    assert inside(found, {"mu": 0.4, "V": 0.3})
    assert found.starts[0][1] == pytest.approx(0.24, abs=0.01)


def test_each_value_has_an_error_of_its_own(tmp_path) -> None:  # type: ignore[no-untyped-def]
    law, rng = ss.Stribeck(mu=0.5, speed=0.3), np.random.default_rng(3)
    s, sigma = np.linspace(0.05, 2.0, 80), np.where(np.arange(80) % 2, 0.2, 1e-3)
    force = law.force(s) + sigma * rng.normal(size=80)
    begun = BLOCK.replace(mu=0.6, speed=0.25)
    found = ss.fit(begun, ss.ForcePoints(s, force, sigma=sigma), ["mu", "speed"])
    good = sigma < 0.1
    alone = ss.fit(begun, ss.ForcePoints(s[good], force[good], sigma=1e-3), ["mu", "speed"])
    np.testing.assert_allclose(found.values, alone.values, rtol=0, atol=2e-4)
    assert inside(found, {"mu": 0.5, "speed": 0.3})
    assert 0.6 < found.chi2 / found.n_free < 1.4
    rows = zip(s, force, sigma, strict=True)
    path = tmp_path / "contact.csv"
    path.write_text(
        "speed,force,sigma\n" + "\n".join(",".join(map(repr, map(float, row))) for row in rows)
    )
    again = ss.fit(begun, ss.read_measurements(path), ["mu", "speed"])
    assert (again.values == found.values).all()
    x = ss.simulate(BLOCK, [0.0], [0.0], t_end=T[-1]).x(T)
    whole = ss.fit(BLOCK, ss.Record(T, x, sigma=0.01), ["mu"])
    each = ss.fit(BLOCK, ss.Record(T, x, sigma=np.full(len(T), 0.01)), ["mu"])
    assert (whole.values == each.values).all()
    assert (whole.covariance == each.covariance).all()


@pytest.mark.parametrize(
    ("sigma", "told"),
    [
        ([0.1, 0.1], r"sigma has the shape \(2,\), and there are 3 rows"),
        ([0.1, 0.0, 0.1], r"sigma\[1\] = 0: standard errors are > 0"),
        ([0.1, np.nan, 0.1], r"sigma\[1, 0\] = nan is not a finite number"),
        (np.ones((3, 2)), "sigma has 2 columns: 1, or as many as the data, 1"),
    ],
)
def test_bad_errors_are_refused(sigma, told: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=told):
        ss.ForcePoints([0.1, 0.2, 0.3], [0.5, 0.4, 0.3], sigma=sigma)


def test_velocities_of_one_block_with_a_known_start() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3))
    v, sigma = noisy(ss.simulate(model, d=0.1, t_end=60).v(T)[:, 1:])
    data = ss.Record(T, v=v, sigma_v=sigma, blocks=(2,), d=0.1)
    found = ss.fit(model.replace(mu=0.31), data, ["mu", "beta"])
    assert inside(found, {"mu": 0.3, "beta": 1.3})


def test_a_forced_oscillator_from_velocities() -> None:
    v, sigma = noisy(ss.simulate(FORCED, [0.2], [0.3], t_end=60).v(T))
    data = ss.Record(T, v=v, sigma_v=sigma, x0=[0.2], v0=[0.3])
    found = ss.fit(FORCED.replace(mu=0.6, damping=0.15), data, ["mu", "damping"])
    assert inside(found, {"mu": 0.5, "damping": 0.2})


def test_a_record_under_a_load_that_varies_begins_at_any_time() -> None:
    # Two blocks on a belt; a third mass, which is shaken and does not rub, presses on the first.
    contacts = [
        ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=0.2, load=(0.0, 0.0, 0.6)),
        ss.Contact(at=1, friction=ss.Coulomb(mu=0.6), V=0.2, static=1.2),
    ]
    shaken = ss.Harmonic(amplitude=(0.0, 0.0, 2.0), frequency=0.9, phase=0.4)
    model = ss.Structure(
        mass=[1.0, 1.5, 1.0],
        stiffness=[[2.0, -1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 4.0]],
        damping=[0.05, 0.05, 0.3],
        contacts=contacts,
        forcing=shaken,
    )
    t, start = np.linspace(0.0, 40.0, 400), {"x0": [0.5, 0.2, 0.1], "v0": [0.2, 0.1, 0.0]}
    values, sigma = noisy(ss.simulate(model, *start.values(), t_end=40.0).x(t))
    true = {"mu_1": 0.5, "mu_2": 0.6, "load_1_3": 0.6}
    begun = model.replace(mu_1=0.43, mu_2=0.68, load_1_3=0.51)
    seen = ss.Record(t[200:], values[200:], sigma=sigma)
    found = ss.fit(begun, seen, list(true))
    assert found.message == "converged"
    assert inside(found, true)
    again = found._again([found._started(seen, found.starts[0])])
    assert again.chi2 == pytest.approx(found.chi2, rel=1e-6)
    known = ss.fit(model, replace(seen, **start), [])  # a start that is known is that at 0
    assert known.chi2 / known.n_free == pytest.approx(1.0, abs=0.2)


@pytest.mark.parametrize("free", [False, True])
def test_feet_of_elastic_contacts_need_no_start(free: bool) -> None:
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), stiffness=4.0)
    model = ss.Structure(mass=[1.0], stiffness=[[1.0]], damping=[0.1], contacts=[contact])
    t = np.linspace(0.0, 8.0, 80)
    values, sigma = noisy(ss.simulate(model, [2.0], [0.0], t_end=8.0).x(t)[:, :1])
    seen = ss.Record(t, values, sigma=sigma, x0=[2.0], v0=[0.0], blocks=[1], free_start=free)
    found = ss.fit(model.replace(mu_1=0.4), seen, ["mu_1"])
    assert inside(found, {"mu_1": 0.5})


@pytest.mark.parametrize("free", [False, True])
def test_states_of_a_state_space_form_are_displacements_alone(free: bool) -> None:
    # Two masses that rub, and a filter of the first one's displacement that pulls it back.
    A = np.zeros((5, 5))
    A[:2, 2:4] = np.eye(2)
    A[2:] = [[-2.0, 1.0, -0.05, 0.0, -0.1], [1.0, -2.0, 0.0, -0.05, 0.0], [0.3, 0, 0, 0, -0.5]]
    at = np.eye(5)[2:4]
    laws = [ss.Coulomb(mu=0.5), ss.Coulomb(mu=0.6)]
    contacts = [
        ss.Contact(at=k, friction=law, static=limit, V=V)
        for k, (law, limit, V) in enumerate(zip(laws, (1.0, 0.7), (0.25, -0.15), strict=True))
    ]
    model = ss.Structure.from_state_space(A, at.T, at, contacts=contacts)
    start = np.array([0.3, 0.0, 0.0, 0.1, 0.0])
    motion = ss.simulate(model, start, t_end=30)
    t = np.linspace(0.0, 30.0, 200)
    x, sigma = noisy(motion.x(t))
    known = {"x0": start, "v0": [], "free_start": free}
    seen = ss.Record(t, x, sigma=sigma, **known)
    sought = {"mu_1": 0.5, "static_2": 0.7, "A_3_1": -2.0}
    begin = model.replace(mu_1=0.52, static_2=0.71, A_3_1=-2.02)
    found = ss.fit(begin, seen, list(sought))
    assert inside(found, sought)
    assert found.chi2 / found.n_free == pytest.approx(1.0, abs=0.2)
    for told, bad, more in (
        ("have no velocities", ss.Record(t, v=x, **known), {}),
        ("a state has no velocities", ss.Record(t, x), {}),
        ("state-space form is not cut", seen, {"pieces": 3}),
    ):
        with pytest.raises(ValueError, match=told):
            ss.fit(begin, bad, list(sought), **more)


def test_times_of_events() -> None:
    model = ss.examples.coulomb()
    motion = ss.simulate(model, d=0.1, t_end=200)
    exact = [e.time for e in motion.events if e.block == 1 and e.kind == "stick"]
    times = np.array(exact) + np.random.default_rng(2).normal(scale=0.05, size=len(exact))
    data = ss.EventTimes(times, "stick", block=1, sigma=0.05, d=0.1)
    found = ss.fit(model.replace(V=0.0368, mu=0.221), data, ["V", "mu"])
    assert inside(found, {"V": 0.0366, "mu": 0.22})
    assert found.matched == (f"{len(exact)} of {len(exact)} events: block 1, stick",)


def test_times_of_events_after_a_state_of_two_blocks_that_is_a_guess() -> None:
    model = ss.examples.coulomb()
    motion = ss.simulate(model, d=0.1, t_end=500.0)
    since = next(t for t, mode in zip(motion.t, motion.modes, strict=False) if mode.all()) + 0.05
    exact = [e.time - since for e in motion.events if e.kind == "stick" and e.block == 1]
    times = [time for time in exact if time > 0.0]
    x, v = motion.x(since), motion.v(since)
    guess = ss.EventTimes(times, block=1, x0=x + np.array([1e-4, -1e-4]), v0=v, free_start=True)
    found = ss.fit(model.replace(mu=0.2199), guess, ["mu"])
    assert found.values[0] == pytest.approx(0.22, abs=1e-5)
    assert len(found.starts[0]) == 4


def test_a_chaotic_motion_from_fifty_points_of_its_map() -> None:
    model = ss.examples.law9()
    orbit = ss.event_map(model).iterate(0.38, 50)
    values, sigma = noisy(orbit[1:], share=0.01)
    data = ss.MapPoints(orbit[:-1], values, sigma=sigma)
    found = ss.fit(model.replace(gamma=2.9, alpha=1.22), data, ["gamma", "alpha"])
    assert inside(found, {"gamma": 3.0, "alpha": model.alpha})


def test_periods_of_cycles_over_the_speed_of_the_belt() -> None:
    V = np.linspace(0.05, 0.35, 12)
    cycles = [ss.find_cycle(BLOCK.replace(V=speed), [0.0], [0.0]) for speed in V.tolist()]
    period, sigma = noisy(np.array([cycle.period for cycle in cycles]))
    data = ss.CyclePeriods(V, period, sigma=sigma)
    found = ss.fit(BLOCK.replace(mu=0.4, speed=0.25), data, ["mu", "speed"])
    assert inside(found, {"mu": 0.5, "speed": 0.3})
    assert found.matched == ("12 of 12 periods of cycles",)
    none = ss.fit(BLOCK, ss.CyclePeriods([0.2, 30.0], period[:2], sigma=sigma), ["mu"])
    assert "1 of 2 data are not met" in none.message  # it settles to slide
    with pytest.raises(ValueError, match="one belt"):
        ss.fit(BLOCK.replace(forcing=ss.Harmonic(amplitude=1.0, frequency=1.0)), data, ["mu"])


def test_a_derivative_that_there_is_not_is_no_zero() -> None:
    """A period has none, inf, where a multiplier is 1; a period that is missed moves nothing."""
    periods = ss.CyclePeriods([0.1, 0.2, 0.3], [7.0, 8.0, 9.0], sigma=0.1)
    gradient = np.array([[1.0], [np.inf], [np.nan]])
    answer = term_of(periods, BLOCK, 1).answered(np.array([7.1, 8.0, np.nan]), gradient, "")
    np.testing.assert_allclose(answer.jacobian, [[10.0], [np.inf], [0.0]], rtol=1e-12)


def test_a_fit_tells_from_when_on_it_has_no_derivatives() -> None:
    """Swinging by the belt's speed about the friction force, the block just touches the belt."""
    model, t = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.5)), np.linspace(0.0, 60.0, 300)
    motion, touch = ss.simulate(model, [0.6], [0.0], t_end=60.0), 1.5 * np.pi

    def seen(times: np.ndarray) -> ss.Record:
        values = motion.x(times), motion.v(times)
        return ss.Record(times, *values, sigma=0.01, sigma_v=0.01, x0=[0.6], v0=[0.0])

    before, whole = (ss.fit(model, seen(t[t <= end]), ["mu"], pieces=1) for end in (touch, 60.0))
    np.testing.assert_array_equal(whole.differentiated[0], np.tile(t <= touch, 2))
    np.testing.assert_allclose(whole.standard_errors, before.standard_errors, rtol=1e-9)
    assert (
        "552 of 600 values of data 1 have no derivatives, the first at t = 4.81605" in whole.message
    )
    assert before.message == "converged"
    of_belt = ss.fit(model, seen(t), ["V"], pieces=1)  # not felt before the touch
    assert "what has derivatives cannot tell V" in of_belt.message
    assert of_belt.profile("V", [0.0995, 0.1]).root[0] < -20.0  # all that was measured tells it


@pytest.mark.parametrize(
    ("loss", "sigma"),
    [("soft_l1", None), ("huber", None), ("soft_l1", 0.01), ("huber", 0.01), ("cauchy", 0.01)],
)
def test_outliers_that_a_loss_does_not_feel_are_not_in_the_errors(
    loss: Loss, sigma: float | None
) -> None:
    s, law = np.linspace(0.0, 1.5, 100), BLOCK.friction
    rng, off = np.random.default_rng(1), []
    for _ in range(20):
        force = law.force(s) + rng.normal(scale=0.01, size=100)
        force[rng.integers(100, size=4)] += 1.0
        found = ss.fit(BLOCK, ss.ForcePoints(s, force, sigma), ["mu"], loss=loss)
        off.append((found.values[0] - 0.5) / found.standard_errors[0])
    assert found.tells
    assert 0.6 < np.sqrt(np.mean(np.square(off))) < 1.7  # 20 of scatter 1, by five of their errors


def test_a_loss_to_which_all_is_far_tells_no_error() -> None:
    points = ss.ForcePoints(np.linspace(0.1, 1.0, 50), 0.5 + 0.1 * (-1.0) ** np.arange(50), 1e-3)
    found = ss.fit(ss.Oscillator(V=0.2, friction=ss.Coulomb(0.5)), points, ["mu"], loss="cauchy")
    assert np.isinf(found.standard_errors).all()
    assert not found.tells


def test_forces_over_speeds_and_a_record_together() -> None:
    s = np.linspace(0.01, 1.5, 40)
    force, sigma = noisy(BLOCK.friction.force(s))
    points = ss.ForcePoints(s, force, sigma=sigma)
    law_alone = ss.fit(BLOCK.replace(mu=0.3, speed=0.5), points, ["mu", "speed"])
    both = ss.fit(
        BLOCK.replace(mu=0.45), [points, record(BLOCK, x=[0.0], v=[0.0])], ["mu", "speed"]
    )
    true = {"mu": 0.5, "speed": 0.3}
    assert inside(law_alone, true)
    assert inside(both, true)
    assert (both.standard_errors < law_alone.standard_errors).all()
    assert len(both.matched) == 2
    other = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3.0), damping=0.1)
    assert ss.fit(other, points, ["gamma"]).aic > law_alone.aic + 10.0


def test_laws_are_compared_by_what_they_tell_of_a_record_left_out() -> None:
    def short(seed: int, x: float) -> ss.Record:
        values, sigma = noisy(ss.simulate(BLOCK, [x], [0.0], t_end=20.0).x(T[:200]), seed)
        return ss.Record(T[:200], values, sigma=sigma, x0=[x], v0=[0.0])

    fitted, left_out = short(1, 0.0), short(2, -0.4)
    unknown = ss.Record(T[:200], left_out.x, sigma=left_out.sigma)  # its start is estimated
    right = ss.fit(BLOCK.replace(mu=0.45), fitted, ["mu", "speed"])
    other = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.45), damping=0.1)
    wrong = ss.fit(other, fitted, ["mu"])
    for record in (left_out, unknown):
        assert 140 < right.misfit(record) < 260  # 200 data
        assert wrong.misfit(record) > 10 * right.misfit(record)
    assert right.misfit(unknown) < right.misfit(left_out)
    assert right.misfit(fitted) == pytest.approx(right.chi2, rel=1e-9)
    with pytest.raises(ValueError, match="data = "):
        right.misfit([])


@pytest.mark.parametrize("free_zero", [False, True])
@pytest.mark.parametrize("pieces", [1, 4])
@pytest.mark.parametrize(
    ("model", "names", "first"),
    [
        (BLOCK, ("mu", "V"), 0),
        (FORCED, ("mu", "forcing.frequency"), 90),
        (FORCED, ("forcing.phase", "forcing.frequency"), 90),
    ],
)
def test_jacobians_are_the_limits_of_differences(
    model: ss.Oscillator, names: tuple[str, ...], first: int, pieces: int, free_zero: bool
) -> None:
    whole = record(model, x=[0.0], v=[0.0])
    data = replace(whole, t=T[first:], x=whole.x[first:], free_zero=free_zero)
    term = term_of(data, model, pieces)
    values = np.array([model.parameters[name] for name in names])

    def answer(unknowns: np.ndarray):  # type: ignore[no-untyped-def]
        moved = model.replace(**dict(zip(names, unknowns[:2].tolist(), strict=True)))
        return term.answer(moved, names, unknowns[2:])

    here = np.concatenate([values, term.start])
    found = answer(here)
    step = 1e-6
    for part, slope in (("residuals", found.jacobian), ("links", found.link_jacobian)):
        for k in range(len(here) if slope.size else 0):
            unit = step * np.eye(len(here))[k]
            high, low = (getattr(answer(here + sign * unit), part) for sign in (1, -1))
            off = np.abs(slope[:, k] - (high - low) / (2 * step))
            # A riding block that is pushed lands at once, having gone the push squared over how
            # far its force is from the limit: a difference is of the order of the push.
            rides = part == "residuals" and not slope[:, k].any()
            size = 1e-5 * (1.0 + np.abs(slope[:, k]).max()) + rides * 20.0 * step / data.sigma
            assert np.mean(off > size) <= 0.02, (part, k)  # an event may be between samples


def test_what_the_data_cannot_tell_is_said() -> None:
    resting = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.5), damping=0.1)
    t = np.linspace(0.0, 3.0, 30)  # it rides all the time
    x = ss.simulate(resting, [0.0], [0.2], t_end=3.0).x(t)
    data = ss.Record(t, x, sigma=0.01, x0=[0.0], v0=[0.2])
    found = ss.fit(resting.replace(mu=0.4), data, ["mu"])
    assert found.undetermined == ("mu",)
    assert np.isinf(found.standard_errors).all()
    assert "cannot tell mu" in found.message
    known = ss.fit(resting, data, ["mu"], priors={"mu": (0.45, 0.02)})
    assert known.undetermined == ()
    np.testing.assert_allclose(known.values, [0.45], rtol=1e-6)
    np.testing.assert_allclose(known.standard_errors, [0.02], rtol=1e-6)


def test_without_standard_errors_the_scatter_is_estimated() -> None:
    weighed = record(BLOCK, x=[0.0], v=[0.0])
    bare = ss.Record(T, weighed.x)
    one, other = (ss.fit(BLOCK, data, ["mu", "speed"]) for data in (weighed, bare))
    np.testing.assert_allclose(other.values, one.values, rtol=1e-4)
    np.testing.assert_allclose(other.standard_errors, one.standard_errors, rtol=0.1)


def test_rounding_of_equal_data_is_no_scatter() -> None:
    force = np.full(600, 0.3)
    assert force.std() > 0.0
    found = ss.fit(
        BLOCK.replace(friction=ss.Coulomb(mu=0.5)), ss.ForcePoints(0.1 * T, force), ["mu"]
    )
    assert found.message == "converged"
    assert found.values == pytest.approx([0.3], rel=1e-12)


def test_noise_about_a_constant_is_its_error() -> None:
    block, noise = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.5)), 0.01
    force = np.random.default_rng(1).normal(0.4, noise, size=20)
    s = np.linspace(0.1, 1.0, 20)
    bare, weighed = (
        ss.fit(block, ss.ForcePoints(s, force, sigma), ["mu"]) for sigma in (None, noise)
    )
    assert bare.message == weighed.message == "converged"
    np.testing.assert_allclose(bare.standard_errors, np.std(force) / np.sqrt(19), rtol=1e-6)
    falling = ss.fit(block, ss.ForcePoints(s, force - 0.1 * s), ["mu"])
    assert not falling.tells
    assert "does not tell these data" in falling.message
    assert not ss.fit(block, ss.ForcePoints(s, force), ["mu"], bounds={"mu": (0.5, 1)}).tells


def test_what_the_model_does_not_reach_is_told() -> None:
    model = ss.examples.coulomb()
    few = ss.simulate(model, d=0.1, t_end=30)
    times = [e.time for e in few.events if e.block == 1 and e.kind == "stick"]
    with pytest.raises(ValueError, match="nothing of the data"):  # nothing ever slips forward
        ss.fit(model, ss.EventTimes(times, "slip forward", d=0.1), ["mu"])
    orbit = ss.event_map(model).iterate(0.1, 20)
    d = np.append(orbit[:-1], 5.0)  # no d of the model
    found = ss.fit(model, ss.MapPoints(d, np.append(orbit[1:], 0.1), sigma=1e-3), ["mu"])
    assert "1 of 21 data are not met" in found.message


def test_bounds_hold_and_are_told() -> None:
    found = ss.fit(
        BLOCK.replace(mu=0.3), record(BLOCK, x=[0.0], v=[0.0]), ["mu"], bounds={"mu": (0.1, 0.4)}
    )
    assert found.at_bound == ("mu",)
    assert "at a bound" in found.message
    with pytest.raises(ValueError, match="outside"):
        ss.fit(BLOCK, record(BLOCK, x=[0.0], v=[0.0]), ["mu"], bounds={"mu": (0.1, 0.4)})


GOOD = np.linspace(0.0, 9.0, 10)
NONE = np.array([0.0, np.nan])
MISSES = np.column_stack([GOOD, np.where(GOOD < 4, GOOD, np.nan)])


@pytest.mark.parametrize(
    ("told", "make"),
    [
        (r"x\[9, 0\] = inf .* NaN stands for", lambda: ss.Record(GOOD, [*GOOD[1:], np.inf])),
        ("x and v of block 2 hold 4 and 0 numbers", lambda: ss.Record(GOOD, MISSES, MISSES + NONE)),
        ("free_zero: all displacements x of block 1 are missing",
         lambda: ss.Record(GOOD, GOOD + np.nan, GOOD, free_zero=True)),
        (r"sigma\[3, 0\] = nan", lambda: ss.Record(GOOD, GOOD, sigma=[1, 1, 1, np.nan] + [1] * 6)),
        ("V = inf", lambda: ss.Record(GOOD, GOOD, V=np.inf)),
        (r"t\[5\] = 4 does not come after t\[4\] = 5",
         lambda: ss.Record([0, 1, 2, 3, 5, 4, 6], np.zeros(7))),
        (r"x has the shape \(9,\)", lambda: ss.Record(GOOD, np.zeros(9))),
        ("at least 5", lambda: ss.Record([0.0, 1.0], [0.0, 1.0])),
        ("needs x", lambda: ss.Record(GOOD)),
        ("sigma = -1", lambda: ss.Record(GOOD, GOOD, sigma=-1.0)),
        ("blocks", lambda: ss.Record(GOOD, GOOD, blocks=(1, 2))),
        ("both x0= and v0=", lambda: ss.Record(GOOD, GOOD, x0=[0.0])),
        ("do not tell where", lambda: ss.EventTimes([1.0, 2.0])),
        (r"times\[1\] = 1 does not come after", lambda: ss.EventTimes([2.0, 1.0], d=0.1)),
        (r"times\[0\] = -1: events come after", lambda: ss.EventTimes([-1.0, 1.0], d=0.1)),
        ("times is empty", lambda: ss.EventTimes([], d=0.1)),
        ("hold 2 and 3 numbers", lambda: ss.MapPoints([0.1, 0.2], [0.1, 0.2, 0.3])),
        (r"speed\[0\] = -0.1", lambda: ss.ForcePoints([-0.1], [0.3])),
        (r"period\[0\] = -1", lambda: ss.CyclePeriods([0.1], [-1.0])),
    ],
)  # fmt: skip
def test_bad_data_are_refused_by_name(told: str, make) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=told):
        make()


def test_a_datum_with_its_error_tells_one_parameter() -> None:
    seen = ss.ForcePoints([0.1], [0.5], sigma=0.01)
    block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    found = ss.fit(block, seen, ["mu"])
    assert (found.message, found.n_free, found.tells) == ("converged", 0, True)
    np.testing.assert_allclose(found.values, 0.5, rtol=1e-9)
    np.testing.assert_allclose(found.standard_errors, 0.01, rtol=1e-9)
    np.testing.assert_allclose(found.intervals, [[0.5 - 0.0195996, 0.5 + 0.0195996]], rtol=1e-6)
    for unknown in ({"loss": "huber"}, {"n_starts": 2, "loss": "cauchy"}):
        with pytest.raises(ValueError, match=r"1 data cannot tell 1 unknowns .* their scatter"):
            ss.fit(block, seen, ["mu"], **unknown)


def test_a_record_without_a_mass_is_in_one_piece() -> None:
    two = ss.Chain(static=[1, 1.3], alpha=1.2, V=0.1, friction=ss.Coulomb(mu=0.4))
    motion = ss.simulate(two, [0.3, 0.1], [0.1, 0.1], t_end=T[-1])
    one = ss.Record(T, motion.x(T)[:, 0], x0=[0.3, 0.1], v0=[0.1, 0.1])
    with pytest.raises(ValueError, match=r"pieces = 3: data 1 is not cut, .*; take pieces=1"):
        ss.fit(two, one, ["mu"], pieces=3)


def test_data_that_do_not_belong_to_the_model_are_refused() -> None:
    good = record(BLOCK, x=[0.0], v=[0.0])
    two = ss.examples.coulomb()
    speeds = np.array([0.01, 0.1, 1.0])
    cases = [
        (two, good, ["mu"], "not measured"),
        (BLOCK, ss.Record(T, good.x, blocks=(2,)), ["mu"], "block 2 is not one"),
        (BLOCK, ss.MapPoints([0.1], [0.2]), ["mu"], "two blocks"),
        (BLOCK, good, ["sped"], "Did you mean 'speed'"),
        (BLOCK, good, ["mu", "mu"], "each once"),
        (BLOCK, replace(good, V=0.2), ["mu", "V"], "all data have V = 0.2 of their own"),
        (BLOCK, [], ["mu"], "data = "),
        (BLOCK, [good, record(BLOCK, x=[0.0], v=[0.0])], ["mu"], "data 2 and data 1 are the same"),
        (BLOCK, ss.ForcePoints([0.1], [0.5]), ["mu", "speed"], "1 data cannot tell 2 unknowns"),
        (BLOCK, ss.Record(T[:5], np.asarray(good.x)[:5]), ["mu", "speed", "damping"],
         "5 data cannot tell 5 unknowns"),
        (BLOCK, ss.ForcePoints(speeds, 1000.0 * BLOCK.friction.force(speeds)), ["mu"], "forces"),
        (BLOCK, ss.ForcePoints(1000.0 * speeds, speeds), ["mu"], "speeds reach 1000, .* are some"),
        (BLOCK, ss.ForcePoints(1e-3 * speeds, 1.0 - 0.1 * speeds), ["mu"], "speeds reach 0.001"),
    ]  # fmt: skip
    for model, data, names, told in cases:
        with pytest.raises(ValueError, match=told):
            ss.fit(model, data, names)


@pytest.mark.parametrize("factor", [1000.0, 0.001])
def test_units_that_are_wrong_by_a_thousand_are_told(factor: float) -> None:
    good = record(BLOCK, x=[0.0], v=[0.0])
    x, v = np.asarray(good.x), ss.simulate(BLOCK, [0.0], [0.0], t_end=T[-1]).v(T)
    long = np.linspace(0.0, 2000.0, 20000)  # a thousandth of it is one period
    later = ss.simulate(BLOCK, [0.0], [0.0], t_end=long[-1]).x(long)
    two = ss.examples.coulomb()
    orbit = ss.event_map(two).iterate(0.1, 20)
    motion = ss.simulate(two, d=0.1, t_end=200)
    times = np.array([e.time for e in motion.events if e.block == 1 and e.kind == "stick"])
    cases = [
        (BLOCK, ss.Record(T, factor * x), "x reaches .* same units"),
        (BLOCK, ss.Record(T, v=factor * v), "v reaches .* same units"),
        (BLOCK, ss.Record(factor * T, x), "it lasts .* same units"),
        (BLOCK, ss.Record(factor * long, later), "it lasts|an oscillation takes some"),
        (two, ss.EventTimes(factor * times, d=0.1), "from one event to the next"),
        (two, ss.MapPoints(factor * orbit[:-1], factor * orbit[1:]), "d reaches"),
        (BLOCK, ss.CyclePeriods([0.1, 0.2], [factor * 9.0, factor * 9.0]), "periods reach"),
        (BLOCK, ss.CyclePeriods([factor * 0.1, factor * 0.2], [9.0, 9.0]), "V reaches"),
    ]
    for model, data, told in cases:
        with pytest.raises(ValueError, match=told):
            ss.fit(model, data, ["mu"])
    slow = ss.Oscillator(V=0.2 * factor, friction=BLOCK.friction, damping=0.1)
    with pytest.raises(ValueError, match=r"x changes by|v reaches|x reaches"):
        ss.fit(slow, ss.Record(T, x, v=factor * v), ["mu"])


def test_physical_units_are_divided_out() -> None:
    units = ss.Units(m=2.0, k=8.0, fs1=4.0)
    good = record(BLOCK, x=[0.0], v=[0.0])
    t, x = units.to_physical("time", good.t), units.to_physical("displacement", good.x)
    physical = ss.Record(t, x, sigma=float(units.to_physical("displacement", good.sigma)))
    back = physical.to_dimensionless(units)
    np.testing.assert_allclose(back.t, good.t, rtol=1e-14)
    np.testing.assert_allclose(back.x, good.x, rtol=1e-14)
    assert back.sigma == pytest.approx(good.sigma, rel=1e-14)
    points = ss.ForcePoints([0.5], [2.0]).to_dimensionless(units)
    assert (points.speed[0], points.force[0]) == (0.5, 0.5)


def test_a_fit_is_a_result() -> None:
    s = np.linspace(0.01, 1.5, 40)
    force, sigma = noisy(BLOCK.friction.force(s))
    found = ss.fit(BLOCK, ss.ForcePoints(s, force, sigma=sigma), ["mu", "speed"])
    assert list(found.table()["parameter"]) == ["mu", "speed"]
    low, high = found.intervals.T
    assert ((low < found.values) & (found.values < high)).all()
    np.testing.assert_allclose(np.diag(found.correlation), 1.0, rtol=1e-12)
    assert found.model.friction.mu == found.values[0]
    assert "mu" in repr(found)


def test_an_error_is_carried_to_what_follows() -> None:
    found = ss.fit(BLOCK.replace(mu=0.45), record(BLOCK, x=[0.0], v=[0.0]), ["mu", "speed"])
    own = found.predict(lambda model: [model.friction.mu, model.friction.speed])
    np.testing.assert_allclose(own.value, found.values, rtol=1e-15)
    np.testing.assert_allclose(own.standard_error, found.standard_errors, rtol=1e-9)
    assert (np.abs(own.curvature) < 1e-9 * own.standard_error).all()
    threshold = found.predict(lambda model: ss.equilibria(model)[0].hopf_points[0].V)
    true = ss.equilibria(BLOCK)[0].hopf_points[0].V
    assert 0.0 < threshold.standard_error < 0.02 * threshold.value
    assert abs(threshold.value - true) < 4.0 * threshold.standard_error
    # F' = -c: V = speed log((1 - mu) / (c speed)), differentiated by hand.
    mu, speed = found.values
    slopes = np.array([-speed / (1 - mu), np.log((1 - mu) / (0.1 * speed)) - 1.0])
    error = np.sqrt(slopes @ found.covariance @ slopes)
    assert threshold.standard_error == pytest.approx(error, rel=1e-3)
    with pytest.raises(ValueError, match="quantity = 3"):
        found.predict(3)  # type: ignore[arg-type]


def test_errors_of_any_sizes_are_carried_on() -> None:
    # Speeds of some 1e-8, as of creep in m/s: errors of the coefficients lie 18 decades apart, and
    # rounding of the largest variance is more than all of the least.
    s = np.linspace(0.1, 1.5, 30)
    names = ("c", "a", "b")

    def fitted(unit: float) -> ss.Fit:  # type: ignore[name-defined]
        text = f"a + b * (s / {unit}) + c * (s / {unit}) ** 2"
        law = ss.friction_law(text, parameters=dict(a=0.7, b=-0.2 * unit, c=0.05 * unit**2))
        force = np.random.default_rng(1).normal(0.7 - 0.2 * s + 0.05 * s**2, 0.01)
        block = ss.Oscillator(V=0.2, friction=law)
        seen = ss.ForcePoints(s, force, sigma=0.01)
        return ss.fit(block, seen, names, bounds={"c": (0.0, 0.1 * unit**2)})

    one, other = fitted(1.0), fitted(1e-9)
    assert one.message == other.message == "converged"
    scales = np.array([1e-18, 1.0, 1e-9])
    own = other.predict(lambda model: [model.parameters[name] for name in names])
    np.testing.assert_allclose(own.standard_error, other.standard_errors, rtol=1e-9)
    drawn = np.array(list(other.sample(1000, rng=1).values()))
    np.testing.assert_allclose(
        drawn, scales[:, None] * list(one.sample(1000, rng=1).values()), rtol=1e-7
    )


def test_curvatures_along_several_axes_do_not_cancel() -> None:
    s = np.linspace(0.01, 1.5, 30)
    seen = ss.ForcePoints(s, BLOCK.friction.force(s), sigma=0.01)
    found = ss.fit(BLOCK, seen, ["mu", "speed"])
    inverse = np.linalg.inv(found._axes())

    def saddle(model: ss.Oscillator) -> float:
        off = np.array([model.friction.mu, model.friction.speed]) - found.values
        one, other = off @ inverse  # in standard errors along the axes
        return float(one**2 - other**2)

    told = found.predict(saddle)
    assert told.standard_error == pytest.approx(0.0, abs=1e-9)
    assert told.curvature == pytest.approx(np.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("given", [True, False])
def test_a_sample_is_drawn_from_the_distribution_of_the_estimates(given: bool) -> None:
    s = np.linspace(0.01, 1.5, 8)
    force, sigma = noisy(BLOCK.friction.force(s))
    points = ss.ForcePoints(s, force, sigma=sigma if given else None)
    found = ss.fit(BLOCK, points, ["mu", "speed"])
    n = 100_000
    drawn = found.sample(n, rng=1)
    assert drawn["mu"].tobytes() == found.sample(n, rng=1)["mu"].tobytes()
    both = np.stack([drawn[name] for name in found.parameters])
    # Of Student's distribution: nu / (nu - 2) times the covariance of its scale.
    wider = 1.0 if given else found.n_free / (found.n_free - 2)
    np.testing.assert_allclose(np.cov(both), wider * found.covariance, rtol=0.05)
    ends = np.quantile(both, [0.025, 0.975], axis=1).T
    reach = np.diff(found.intervals, axis=1)
    assert (np.abs(ends - found.intervals) < 0.02 * reach).all()


@pytest.mark.parametrize("n", [2, 3, 12])
def test_intervals_are_those_of_a_mean(n: int) -> None:
    # Normal where its error is known, Student's where that comes from n - 1 differences.
    y = 0.5 + np.random.default_rng(n).normal(scale=0.01, size=n)
    block, s = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4)), np.linspace(0.1, 1.0, n)
    known, estimated = 1.959964 * 0.01, stats.t.ppf(0.975, n - 1) * y.std(ddof=1)
    for sigma, reach in ((0.01, known), (None, estimated)):
        found = ss.fit(block, ss.ForcePoints(s, y, sigma=sigma), ["mu"])
        ends = y.mean() + reach / np.sqrt(n) * np.array([-1.0, 1.0])
        np.testing.assert_allclose(found.intervals[0], ends, rtol=1e-6)
        np.testing.assert_allclose(found.profile("mu").interval, ends, rtol=1e-4)


def test_a_sample_stays_within_the_bounds() -> None:
    s = np.linspace(0.01, 1.5, 40)
    force, sigma = noisy(BLOCK.friction.force(s))
    points = ss.ForcePoints(s, force, sigma=sigma)
    found = ss.fit(BLOCK, points, ["mu"], bounds={"mu": (0.5, 0.6)})
    drawn = found.sample(1000, rng=1)["mu"]
    assert drawn.min() >= 0.5
    assert drawn.max() <= 0.6
    far = replace(found, bounds=np.array([[0.6, 0.7]]))
    with pytest.raises(ValueError, match="within the bounds"):
        far.sample(10)
    unknown = replace(found, undetermined=("mu",))
    with pytest.raises(ValueError, match="cannot tell mu"):
        unknown.sample(10)


def test_starts_are_states() -> None:
    two = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=ss.Coulomb(mu=0.3))
    motion = ss.simulate(two, d=0.1, t_end=60)
    x, sigma = noisy(motion.x(T))
    found = ss.fit(two, ss.Record(T, x, sigma=sigma), ["mu"])
    np.testing.assert_allclose(found.starts[0][:2], motion.x(0.0), rtol=0.02, atol=4 * sigma)
    np.testing.assert_allclose(found.starts[0][2:], 0.1, rtol=0.01)  # both ride


def test_a_profile_is_the_interval_where_linear_theory_holds() -> None:
    s = np.linspace(0.01, 1.5, 40)
    force, sigma = noisy(BLOCK.friction.force(s))
    found = ss.fit(BLOCK, ss.ForcePoints(s, force, sigma=sigma), ["mu", "speed"])
    profile = found.profile("mu")
    np.testing.assert_allclose(profile.interval, found.intervals[0], rtol=1e-3)
    np.testing.assert_allclose(profile.root[[0, -1]], [-2.94, 2.94], rtol=0.02)
    assert (np.diff(profile.others[:, 1]) < 0.0).all() or (
        np.diff(profile.others[:, 1]) > 0.0
    ).all()
    wide = ss.fit(BLOCK, record(BLOCK, x=[0.0], v=[0.0]), ["mu", "speed"])
    np.testing.assert_allclose(
        wide.profile("speed").interval,
        wide.intervals[1],
        atol=0.3 * wide.standard_errors[1],
        rtol=0.0,
    )


def test_a_profile_tells_what_is_open_to_one_side() -> None:
    s = np.linspace(2.0, 4.0, 9)  # beyond the fall of the law: its speed is at most something
    points = ss.ForcePoints(s, BLOCK.friction.force(s), sigma=0.01)
    found = ss.fit(BLOCK, points, ["mu", "speed"])
    profile = found.profile("speed", [0.05, 0.2, 0.4, 0.6, 0.8, 1.0, 1.2])
    assert profile.interval[0] == -np.inf
    assert 0.4 < profile.interval[1] < 1.2
    for name, values, told in [
        ("spam", None, "spam"),
        ("speed", [-1.0], "values"),
        ("mu", [], "values"),
    ]:
        with pytest.raises(ValueError, match=told):
            found.profile(name, values)
    robust = ss.fit(BLOCK, points, ["mu"], loss="huber")
    with pytest.raises(ValueError, match="least squares"):
        robust.profile("mu")


@pytest.mark.parametrize("sigma", [None, 0.01])
def test_a_model_that_does_not_tell_the_data_is_told(sigma: float | None) -> None:
    t = T[:60]
    noise = np.random.default_rng(3).normal(size=len(t))
    found = ss.fit(BLOCK, ss.Record(t, noise, sigma=sigma), ["mu"])
    assert not found.tells
    assert "does not tell these data" in found.message


@pytest.mark.parametrize(("mu", "alpha"), [(1.3, 1.3), (1.3, 0.7), (0.7, 1.3)])
def test_many_starts_find_what_one_start_misses(mu: float, alpha: float) -> None:
    model = ss.examples.coulomb()
    d = np.linspace(-0.6, 0.6, 60)
    values, sigma = noisy(ss.event_map(model)(d))
    data = ss.MapPoints(d, values, sigma=sigma)
    begun = model.replace(mu=0.22 * mu, alpha=1.2 * alpha)
    assert not ss.fit(begun, data, ["mu", "alpha"]).tells  # a local minimum, and it says so
    found = ss.fit(begun, data, ["mu", "alpha"], n_starts=256)
    assert found.tells
    assert inside(found, {"mu": 0.22, "alpha": 1.2})
    bounds = {"mu": (0.1, 0.4), "alpha": (0.8, 1.6)}
    again = ss.fit(begun, data, ["mu", "alpha"], n_starts=256, bounds=bounds)
    np.testing.assert_allclose(again.values, found.values, rtol=1e-6)


def test_a_start_that_meets_nothing_is_one_of_many() -> None:
    model = ss.examples.coulomb()
    _, high = ss.event_map(model).domain
    d = np.linspace(0.9 * high, high, 12)[:-1]
    data = ss.MapPoints(d, ss.event_map(model)(d), sigma=1e-3)
    begun = model.replace(alpha=1.56)  # whose domain ends before
    assert ss.event_map(begun).domain[1] < d[0]
    with pytest.raises(ValueError, match=r"cannot start.*nothing of the data"):
        ss.fit(begun, data, ["alpha"])
    found = ss.fit(begun, data, ["alpha"], n_starts=64)
    assert found.values[0] == pytest.approx(1.2, rel=1e-6)


def test_a_first_look_gives_up_what_takes_long() -> None:
    model = ss.examples.law9().replace(gamma=6.2, alpha=2.18)  # the worst of some hundred starts
    low, high = ss.event_map(model).domain
    data = ss.MapPoints(np.linspace(low, high, 40), np.linspace(low, high, 40), sigma=1e-2)
    term = term_of(data, model, 1)
    answer = term.hurried().answer(model, (), np.zeros(0))
    events = ss.event_map(model).evaluate(data.d).n_events
    assert (events > FEW).any()
    assert (np.isnan(answer.fitted) == (events > FEW)).all()
    assert answer.jacobian.shape == (40, 0)


@pytest.mark.slow
def test_a_chaotic_motion_is_found_from_thirty_per_cent_off() -> None:
    model = ss.examples.law9()
    orbit = ss.event_map(model).iterate(0.38, 50)
    values, sigma = noisy(orbit[1:])
    data = ss.MapPoints(orbit[:-1], values, sigma=sigma)
    begun = model.replace(gamma=0.7 * 3.0, alpha=0.7 * model.alpha)
    found = ss.fit(begun, data, ["gamma", "alpha"], n_starts=256)
    assert found.tells
    assert inside(found, {"gamma": 3.0, "alpha": model.alpha})


def test_pieces_are_tied_before_they_are_joined() -> None:
    # Joined while their ends are loose the pieces of this record lose it.
    model = ss.examples.law9()
    begun = model.replace(gamma=0.7 * 3.0, alpha=1.3 * model.alpha)
    x = ss.simulate(model, d=0.38, t_end=T[-1]).x(T)
    sigma = 0.01 * x.std(axis=0).max()
    noise = np.random.default_rng([2, 7]).normal(scale=sigma, size=x.shape)
    found = ss.fit(begun, ss.Record(T, x + noise, sigma=sigma), ["gamma", "alpha"])
    assert found.pieces == 1
    assert found.message == "converged"
    assert inside(found, {"gamma": 3.0, "alpha": model.alpha})


FALLING = "a + (1 - a) * exp(-s / v) + h * s"


def measured_forces() -> ss.ForcePoints:
    """Forces of a law that `FALLING` does not have."""
    rng = np.random.default_rng(2)
    s = rng.permutation(np.geomspace(0.003, 4.0, 150))
    return ss.ForcePoints(s, 0.97 - 0.07 * np.log1p(s / 0.08) + 0.01 * rng.normal(size=len(s)))


def fitted_by(text: str, **start: float) -> ss.Fit:
    """Fit a law of one's own; to check units, a motion under it would be compiled."""
    block = ss.Oscillator(V=1.0, friction=ss.friction_law(text, parameters=start), damping=0.02)
    return ss.fit(block, measured_forces(), list(start), check_units=False)


def test_what_one_motion_tells_but_for_rounding_is_not_lost() -> None:
    law9, t = ss.examples.law9(), np.linspace(0.0, 20.0, 300)
    found = ss.fit(law9, ss.Record(t, ss.simulate(law9, d=0.38, t_end=20).x(t)), ["gamma", "alpha"])
    assert found.pieces == 1
    np.testing.assert_allclose(found.values, found.start, rtol=1e-9)


def test_residuals_that_neighbours_share_are_told() -> None:
    wrong = fitted_by(FALLING, a=0.6, v=0.5, h=0.01)
    right = fitted_by("a - b * log1p(s / v)", a=1.0, b=0.1, v=0.5)
    (value, error), (small, _) = *wrong.autocorrelation, *right.autocorrelation
    assert error == pytest.approx(150**-0.5, rel=1e-12)
    assert small < 3.0 * error < value
    points = measured_forces()
    order = np.argsort(np.asarray(points.speed))
    off = (wrong.fitted[0] - np.asarray(points.force))[order]
    assert value == pytest.approx(np.sum(off[1:] * off[:-1]) / np.sum(off**2), rel=1e-9)
    assert f"not scattered about zero (neighbours correlate by {value:.2f}" in wrong.message
    assert right.message == "converged"
    assert f"correlate by {small:.2f} +- {error:.2f}" in repr(right)
    kept = ss.Record(T, ss.simulate(BLOCK, [0.0], [0.0], t_end=float(T[-1])).x(T))
    assert np.isnan(ss.fit(BLOCK, kept, ["mu"]).autocorrelation).all()  # rounding


def test_a_fit_that_no_model_allows_has_not_converged() -> None:
    # At the plateau as static limit the best law has F(0) = 1.03; refused trials ended the search.
    rng = np.random.default_rng(4)
    s = np.geomspace(0.02, 6.0, 60)
    force = (0.63 + 0.40 / (1.0 + s / 0.8)) * (1.0 + 0.01 * rng.normal(size=len(s)))
    law = ss.friction_law("a + b / (1 + s / v)", parameters={"a": 0.6, "b": 0.3, "v": 1.5})
    block = ss.Oscillator(V=1.0, friction=law, damping=0.02)
    walled = ss.fit(block, ss.ForcePoints(s, force), ["a", "b", "v"], check_units=False)
    assert not walled.converged
    assert "F(0) = 1.0" in walled.refused
    assert f"no model allows a better fit, and the estimates mean little: {walled.refused}" in (
        walled.message
    )
    free = ss.fit(block, ss.ForcePoints(s, 0.9 * force), ["a", "b", "v"], check_units=False)
    assert free.message == "converged"
    assert not free.refused
    assert free.chi2 < 0.9**2 * walled.chi2


def test_a_quantity_that_a_model_lacks_tells_which_model() -> None:
    wrong = fitted_by(FALLING, a=0.6, v=0.5, h=0.01)
    with pytest.raises(ValueError, match=r"at a = 0.8.*, the estimates: IndexError"):
        wrong.predict(lambda model: [][0])
    with pytest.raises(ValueError, match="one standard error from the estimates: KeyError"):
        wrong.predict(lambda model: {wrong.values[0]: 0.0}[model.parameters["a"]])
    edge = fitted_by("a + b * exp(-s / v)", a=0.7, b=0.29, v=0.5)
    far = replace(edge, covariance=np.eye(3))
    with pytest.raises(ValueError, match=r"no model at .*one standard error from .*: F\(0\) ="):
        far.predict(lambda model: model.V)


def test_a_picture_of_a_fit_has_residuals_below() -> None:
    ax = fitted_by(FALLING, a=0.6, v=0.5, h=0.01).plot()
    above, below = ax.figure.axes
    assert above is ax
    assert (ax.get_xscale(), below.get_xscale()) == ("log", "log")
    assert below.get_xlim() == ax.get_xlim()
    (points,) = (line for line in below.lines if len(line.get_xdata()) == 150)
    assert np.mean(np.square(points.get_ydata())) == pytest.approx(147 / 150, rel=1e-9)
    of_record = ss.fit(BLOCK, record(BLOCK, x=[0.0], v=[0.0]), ["mu"]).plot()
    assert of_record.get_xscale() == "linear"
    with pytest.raises(ValueError, match="no place in a grid"):
        fitted_by(FALLING, a=0.6, v=0.5, h=0.01).plot(ax.figure.add_axes((0, 0, 1, 1)))


def test_a_start_that_comes_to_ride_leaves_the_parameters_determined() -> None:
    """Block 1's slip at the start shrinks to 1e-15, and the landing then has no derivatives."""
    laws = (ss.Coulomb(mu=0.3), ss.PoppStelter(gamma=1.5, delta=0.1))
    model = ss.TwoBlock(alpha=0.9, beta=1.15, V=0.11, friction=laws)
    motion, t = ss.simulate(model, d=0.1, t_end=60.0), np.linspace(0.0, 60.0, 120)
    fitted = ss.fit(model.replace(V=0.12), ss.Record(t, motion.x(t), motion.v(t)), ["V", "mu_1"])
    assert fitted.undetermined == ()
    assert fitted.values == pytest.approx([0.11, 0.3], rel=1e-9)


@pytest.mark.parametrize("name", ["v0", "x0", "d", "v0_1"])
def test_a_parameter_called_as_the_start_of_a_motion_is_refused(name):
    law = ss.friction_law(f"m + (1 - m) * exp(-s / {name})", parameters={"m": 0.5, name: 0.3})
    model = ss.Oscillator(V=0.2, friction=law)
    for data in (
        ss.Record(T, np.sin(T)[:, None]),
        ss.EventTimes([1.0, 2.0], "stick", x0=[0.0], v0=[0.0]),
    ):
        with pytest.raises(ValueError, match=f"the model's parameter {name} has the name of"):
            ss.fit(model, data, ["m"])
