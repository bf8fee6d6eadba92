"""Derivatives of motions in time against differences of high order, and what they say of events."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest
from tests.mechanics.flow.systems import UNTRACED_LAW_9, random_model
from tests.reference.elastic import random_elastic
from tests.reference.structures import FEW_LAWS, LAWS, random_structure
from tests.sizes import sizes

import stickslip as ss
from stickslip.mechanics.flow.trajectory import Trajectory as Motion
from stickslip.status import ONE_SIDED

T_END = 25.0
TOLERANCE = 1e-8
CONVERGED = 1e-9  # two steps of a difference must agree so well before it can judge
WEIGHTS = np.array([-1, 9, -45, 45, -9, 1]) / 60
OFFSETS = (-3, -2, -1, 1, 2, 3)

Move = Callable[[str, float], Motion | None]


def quantities(motion: Motion, t: np.ndarray) -> dict[str, np.ndarray]:
    """What is differentiated, by name."""
    return {
        "x": motion.x(t),
        "v": motion.v(t),
        "event_times": np.array([event.time for event in motion.events]),
        "slip_starts": np.array([slip.start for slip in motion.slips]),
        "slip_durations": np.array([slip.duration for slip in motion.slips]),
        "slip_moments": np.array([slip.moment for slip in motion.slips]),
        "d": motion.d,
    }


def exact(by, t: np.ndarray, column: int) -> dict[str, np.ndarray]:  # type: ignore[no-untyped-def]
    found = {"x": by.x(t), "v": by.v(t)} | {
        name: getattr(by, name)
        for name in ("event_times", "slip_starts", "slip_durations", "slip_moments", "d")
    }
    return {name: values[..., column] for name, values in found.items()}


def word(motion: Motion) -> list[tuple[int, str]]:
    return [event[1:] for event in motion.events]


def differences(  # type: ignore[type-arg]
    motion: Motion, move: Move, name: str, t: np.ndarray, widest: float
) -> dict | None:
    """Differences of order six, where two steps agree; None where the modes beside are others."""
    both = []
    for step in (widest, 0.5 * widest):
        moved = [move(name, k * step) for k in OFFSETS]
        for other in moved:
            if other is None or word(other) != word(motion) or other.t[-1] < t[-1]:
                return None
            if (other._mode(t) != motion._mode(t)).any():
                return None
        each = [quantities(other, t) for other in moved]
        both.append(
            {
                key: np.tensordot(WEIGHTS, np.array([values[key] for values in each]), 1) / step
                for key in each[0]
            }
        )
    return {
        key: value
        for key, value in both[1].items()
        if np.abs(value - both[0][key]).max(initial=0) <= CONVERGED * size(value)
    }


def size(values: np.ndarray) -> float:
    return 1.0 + float(np.abs(values).max(initial=0.0))


def checked(  # type: ignore[no-untyped-def]
    model, names: tuple[str, ...], t_end: float = T_END, widest: float = 4e-5, **start
) -> int:
    """Compare all derivatives with differences; return how many could be compared."""
    motion = ss.simulate(model, t_end=t_end, **start)
    by = motion.derivative(*names)
    middles = 0.5 * (motion.t[1:] + motion.t[:-1])
    t = middles[np.diff(motion.t) > 0.02]
    if motion.status or by.status or not t.size:
        return 0

    def move(name: str, step: float) -> Motion | None:
        changed, moved = model, {key: np.array(value, float) for key, value in start.items()}
        stem, _, number = name.partition("_")
        if name in model.parameters:
            try:
                changed = model.replace(**{name: model.parameters[name] + step})
            except ValueError:
                return None
        else:
            moved[stem.removesuffix("0")].flat[int(number or 1) - 1] += step
        if "d" in moved and np.ndim(start["d"]) == 0:
            moved["d"] = float(moved["d"])
        try:
            return ss.simulate(changed, t_end=t_end, **moved)
        except ValueError:
            return None

    compared = 0
    for column, name in enumerate(by.names):
        expected = differences(motion, move, name, t, widest)
        found = exact(by, t, column)
        for key, value in (expected or {}).items():
            off = np.abs(found[key] - value).max(initial=0)
            assert off <= TOLERANCE * size(value), (name, key, off, size(value))
            compared += value.size > 0
    return compared


@pytest.mark.parametrize("law", ["coulomb", "law9"])
@pytest.mark.parametrize("n", sizes(2, 6))
def test_two_blocks(n: int, law: str) -> None:
    rng = np.random.default_rng(1)
    compared = 0
    for _ in range(n):
        model = random_model(rng, law)
        d = float(rng.uniform(*model.domain))
        compared += checked(model, (*model.parameters, "d"), d=d)
        x, v = model.sample_state(rng)
        compared += checked(model, (*model.parameters, "x0", "v0"), x=x, v=v)
    assert compared > 25 * n


@pytest.mark.parametrize("law", ["coulomb", "law9"])
@pytest.mark.parametrize("n", sizes(2, 3))
def test_two_blocks_next_to_grazing(n: int, law: str) -> None:
    """States, events and slips of motions that all but lose, or have just won, a landing."""
    rng, compared, nearest = np.random.default_rng(6), 0, 1.0
    for _ in range(n):
        model = random_model(rng, law)
        f = ss.event_map(model, max_events=300)
        grazes = [found.d for found in ss.breakpoints(f) if "graz" in found.mechanism]
        for d in grazes[:1]:
            for near in (-1e-3, -1e-4, 1e-4, 1e-3):
                names, steps = (*model.parameters, "d"), {"widest": abs(near) / 50}
                compared += checked(model, names, 12.0, **steps, d=d + near)
                by = ss.simulate(model, d=d + near, t_end=12.0).derivative("d")
                nearest = min(nearest, by.margin)
    assert compared > 50 * n
    assert nearest < 1e-3


def test_a_chain_from_a_global_stick_phase() -> None:
    model = ss.Chain(
        static=[1, 1.3, 1.1], alpha=1.2, V=0.1, friction=ss.Stribeck(mu=0.3, speed=0.2)
    )
    assert checked(model, (*model.parameters, "d"), d=[0.1, 0.2]) > 50


def oscillators(n: int) -> Iterator[ss.Oscillator]:
    rng = np.random.default_rng(5)
    for law in (ss.Coulomb(mu=0.4, viscous=0.05), ss.PoppStelter(2.0, 0.1, 0.02)):
        for _ in range(n):
            forcing = ss.Harmonic(rng.uniform(0.2, 1.5), rng.uniform(0.4, 1.5), 0.3)
            V, damping = rng.uniform(0.05, 0.5), rng.uniform(0.02, 0.5)
            yield ss.Oscillator(V=V, friction=law, damping=damping, forcing=forcing)


@pytest.mark.parametrize("n", sizes(2, 4))
def test_forced_oscillators(n: int) -> None:
    compared = 0
    for model in oscillators(n):
        compared += checked(model, (*model.parameters, "x0", "v0"), x=[0.3], v=[0.1])
    assert compared > 37 * n


@pytest.mark.parametrize(("n", "laws"), sizes((2, FEW_LAWS), (10, LAWS)))
@pytest.mark.parametrize("elastic", [False, True])
def test_structures(elastic: bool, n: int, laws: tuple[ss.FrictionLaw, ...]) -> None:
    rng = np.random.default_rng(3)
    compared = 0
    for _ in range(n):
        model = random_elastic(rng) if elastic else random_structure(rng, laws)
        x, v = model.sample_state(rng)
        names = (*list(model.parameters)[:12], "x0")
        compared += checked(model, names, t_end=6.0, x=x, v=v)
    assert compared > 15 * n


def test_left_and_right_of_an_event() -> None:
    model = ss.examples.coulomb()
    motion = ss.simulate(model, d=0.1, t_end=60)
    by = motion.derivative("V", "mu")
    for k, event in enumerate(motion.events):
        if event.kind == "stick":
            before, after = (by.v(event.time, side=side) for side in ("left", "right"))
            # On the belt the velocity is V; before it fell towards that at the rate w'.
            np.testing.assert_allclose(after[event.block - 1], [1.0, 0.0], rtol=0, atol=1e-13)
            rate = _rate(motion, event)
            expected = after[event.block - 1] - rate * by.event_times[k]
            np.testing.assert_allclose(before[event.block - 1], expected, rtol=1e-9)


def _rate(motion: Motion, event) -> float:  # type: ignore[no-untyped-def,type-arg]
    """Acceleration of a block just before it lands."""
    block = event.block - 1
    h = 1e-4
    k = motion._step(np.array(event.time)) - 1
    t = event.time - motion._record.t[k] - h * np.arange(5)
    v = motion._inside(np.full(5, k), t)[1][:, block]
    return float(v @ [25, -48, 36, -16, 3]) / (12 * h)


@pytest.mark.parametrize("side", [-1, 1])
@pytest.mark.parametrize("distance", [1e-3, 1e-5, 1e-7])
def test_near_grazing_derivatives_are_right_and_the_margin_says_how_near(
    side: int, distance: float
) -> None:
    """A block that slides and swings up to just below, or just beyond, the speed of the belt."""
    model = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5))
    swing = model.V + side * distance  # about x = mu
    motion = ss.simulate(model, [0.5 - swing], [0.0], t_end=1.2 * np.pi)
    assert len(motion.events) == (0 if side < 0 else 2)
    by = motion.derivative("mu", "V", "x0", "v0")
    if side < 0:
        np.testing.assert_allclose(by.margin, distance, rtol=1e-6)
        t = np.array([1.0, 2.0, 3.5])
        np.testing.assert_allclose(by.x(t)[:, 0, 0], 1 - np.cos(t), rtol=1e-12)
        np.testing.assert_allclose(by.x(t)[:, 0, 2], np.cos(t), rtol=1e-12)
        np.testing.assert_allclose(by.x(t)[:, 0, 3], np.sin(t), rtol=1e-12)
        return
    # It lands where swing sin t = V; at x with |x| < 1 it sticks until x = 1.
    landing = np.arcsin(model.V / swing)
    np.testing.assert_allclose(motion.events[0].time, landing, rtol=1e-12)
    by_V = 1.0 / (swing * np.cos(landing))
    # The state of a start so near a touch is told to rounding, its root to the root of that.
    slack = 1e-15 / distance
    np.testing.assert_allclose(by.event_times[0, 1], by_V, rtol=1e-10 + slack)
    by_swing = -np.tan(landing) / swing
    np.testing.assert_allclose(by.event_times[0, 2], -by_swing, rtol=1e-10 + slack)
    assert by.margin <= 1.01 * np.sqrt(swing**2 - model.V**2)


def test_at_a_touch_the_derivatives_end() -> None:
    # The speed of the block comes to V exactly, and its force is within the limits there.
    model = ss.Oscillator(V=0.5, friction=ss.Coulomb(mu=0.5))
    motion = ss.simulate(model, [0.0], [0.0], t_end=6.0)
    assert [event.kind for event in motion.events][:1] == ["stick"]
    by = motion.derivative("mu", "x0")
    assert by.status == ONE_SIDED
    assert by.margin <= 1e-12
    np.testing.assert_allclose(by.t_end, np.pi / 2, rtol=1e-7)
    assert np.isfinite(by.x([0.5, 1.5])).all()
    assert np.isnan(by.x([2.0, 6.0])).all()
    assert np.isnan(by.event_times).all()
    assert "one side" in by.message


def test_two_events_at_once_are_told() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.0366, friction=ss.Coulomb(mu=0.22))
    tie = (model.beta - 1.0) / (1.0 + 2.0 * model.alpha)  # both blocks leave together
    by = ss.simulate(model, d=tie, t_end=5.0).derivative("mu", "d")
    assert by.status == ONE_SIDED


def test_a_rider_that_starts_at_its_limit_is_told() -> None:
    model = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.5))
    at_limit = ss.simulate(model, [-1.0], [0.2], t_end=1.0).derivative("mu", "x0")
    assert at_limit.status == ONE_SIDED
    inside = ss.simulate(model, [-0.9], [0.2], t_end=1.0).derivative("mu", "x0")
    assert inside.status == ss.status.OK
    np.testing.assert_allclose(inside.margin, 0.1, rtol=1e-12)


def test_a_motion_that_ends_at_an_event_has_the_derivative_of_its_end() -> None:
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    motion = ss.simulate(model, d=0.1, until="stick")
    by = motion.derivative("V", "d")
    assert by.event_times.shape == (len(motion.events), 2)
    np.testing.assert_allclose(
        by.d[-1], [f.parameter_derivative(0.1, "V"), f.derivative(0.1)], rtol=1e-11
    )


def test_a_chaotic_motion_is_differentiated_as_far_as_it_can_be_repeated() -> None:
    model = ss.examples.coulomb().replace(V=0.1)
    motion = ss.simulate(model, d=0.1, t_end=20_000, record="events")
    by = motion.derivative("d")
    known = np.array([event.time for event in motion.events]) < by.t_end
    if by.t_end < motion.t[-1]:
        assert by.status == ss.status.UNDECIDED
        assert np.isnan(by.event_times[~known]).all()
    assert np.isfinite(by.event_times[known]).all()


def test_names() -> None:
    model = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.5))
    motion = ss.simulate(model, [0.3], [0.0], t_end=1.0)
    assert motion.derivative("x0", "mu").names == ("x0_1", "mu")
    with pytest.raises(ValueError, match="Did you mean 'mu'"):
        motion.derivative("mU")
    with pytest.raises(ValueError, match="each once"):
        motion.derivative()
    with pytest.raises(ValueError, match="each once"):
        motion.derivative("x0", "x0_1")
    with pytest.raises(ValueError, match="'d' is not a parameter"):
        motion.derivative("d")
    with pytest.raises(ValueError, match="'x0' is not a parameter"):
        ss.simulate(ss.examples.coulomb(), d=0.1, t_end=1.0).derivative("x0")
    # The formula of Coulomb(mu, viscous), whose kernels it shares.
    law = ss.friction_law(lambda s, v0, b: v0 + b * s, parameters={"v0": 0.5, "b": 0.1})
    named = ss.simulate(ss.Oscillator(V=0.2, friction=law), [0.3], [0.0], t_end=1.0)
    by = named.derivative("v0", "v0_1")  # the law's, and the start's
    assert by.names == ("v0", "v0_1")
    np.testing.assert_allclose(by.v(0.0)[0], [0.0, 1.0], rtol=1e-14)


def test_what_cannot_be_differentiated_is_refused() -> None:
    model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.2, friction=UNTRACED_LAW_9)
    with pytest.raises(ValueError, match="cannot be traced"):
        ss.simulate(model, d=0.1, t_end=1.0).derivative("alpha")
    slip = ss.quasistatic_map(ss.examples.coulomb()).slip_from(0.1, 100)
    with pytest.raises(ValueError, match="quasistatic"):
        slip.derivative("mu")


def test_times_outside_are_refused() -> None:
    by = ss.simulate(ss.examples.coulomb(), d=0.1, t_end=5.0).derivative("mu")
    with pytest.raises(ValueError, match=r"t = -1\.0"):
        by.x(-1.0)
    with pytest.raises(ValueError, match="side"):
        by.x(1.0, side="up")  # type: ignore[arg-type]
    assert by.x(np.zeros((2, 3))).shape == (2, 3, 2, 1)


def test_laws_of_blocks_whose_parameters_are_called_as_the_start_are_told() -> None:
    law = ss.friction_law("m + (1 - m) * exp(-s / v0)", parameters={"m": 0.5, "v0": 0.3})
    model = ss.TwoBlock(alpha=1.0, beta=1.2, V=0.1, friction=(law, law))
    motion = ss.simulate(model, [0.0, 0.0], [0.1, 0.1], t_end=0.1)
    assert motion.derivative("v0_2").names == ("v0_2",)  # the parameter, as is promised
    with pytest.raises(ValueError, match="v0_1, v0_2 of the start are parameters of the model"):
        motion.derivative("v0")
