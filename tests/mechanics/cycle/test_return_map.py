"""Return maps against motions, cycles, differences, on plants nobody tuned for."""

from __future__ import annotations

import numpy as np
import pytest
from tests.reference.structures import random_structure
from tests.sizes import slow

import stickslip as ss
from stickslip.analysis.maps.protocol import apart

TURN = 2 * np.pi
COULOMB = (ss.Coulomb(mu=0.4), ss.Coulomb(mu=0.6))


def axis(gain: float = 4.0, mu: float = 0.7) -> ss.Structure:
    """A mass on rough ground under PID control; states: integral, position, velocity."""
    return ss.Structure.from_state_space(
        [[0, 1, 0], [0, 0, 1], [-gain, -6.0, -1.5]],
        [[0], [0], [1]],
        [[0, 0, 1]],
        contacts=[ss.Contact(at=0, friction=ss.Coulomb(mu=mu))],
    )


def shaken(amplitude: float = 0.3, V: float = 0.02) -> ss.Oscillator:
    forcing = ss.Harmonic(amplitude=amplitude, frequency=0.45)
    return ss.Oscillator(V=V, friction=ss.Coulomb(mu=0.4), damping=0.02, forcing=forcing)


def returns(model, event, contact, direction, motion):  # type: ignore[no-untyped-def]
    """Times at which a motion makes the event of a section."""
    mode = {"backward": -1, "forward": 1}[direction]
    found = []
    for k in range(1, len(motion.modes)):
        before, after = motion.modes[k - 1, contact], motion.modes[k, contact]
        if event == "release" and (before, after) == (0, mode):
            found.append(motion.t[k])
        if event == "landing" and before == mode and after != mode:
            found.append(motion.t[k])
    return found


def drawn(seed: int):  # type: ignore[no-untyped-def]
    """Random return map, and two points that one motion visits; None if it has none."""
    rng = np.random.default_rng(seed)
    model = random_structure(rng, COULOMB)
    frequencies = [name for name in model.parameters if name.endswith("frequency")]
    model = model.replace(**dict.fromkeys(frequencies, rng.uniform(0.3, 3.0)))
    n = len(model.mass)
    contact = int(rng.integers(len(model.contacts)))
    event = ["release", "landing"][int(rng.integers(2))]
    motion = ss.simulate(model, rng.normal(size=n), rng.normal(size=n), t_end=40.0)
    if not model.plant.is_forced and n == 1 and event == "release":
        return None  # one state
    f = ss.return_map(model, contact=contact, event=event)  # type: ignore[arg-type]
    if f.dimension == 1 and f.coordinates != ("phase",):
        f = ss.return_map(model, contact=contact, event=event, domain=(-10.0, 10.0))  # type: ignore[arg-type]
    times = returns(model, event, contact, f.direction, motion)
    if len(times) < 2:
        return None
    first, second = (f.point(motion.x(t), motion.v(t), t) for t in times[:2])
    return f, first, second, times[1] - times[0]


@pytest.mark.parametrize("first", [0, pytest.param(60, marks=pytest.mark.slow)])
def test_maps_of_random_structures_go_where_their_motions_go(first: int) -> None:
    seen = dimensions = 0
    for seed in range(first, first + 60):
        if (case := drawn(seed)) is None:
            continue
        f, start, end, duration = case
        found = f.evaluate(start)
        assert found.status == ss.status.OK, seed
        np.testing.assert_allclose(found.value, end, rtol=1e-9, atol=1e-9, err_msg=str(seed))
        np.testing.assert_allclose(found.duration, duration, rtol=1e-10)
        seen, dimensions = seen + 1, max(dimensions, f.dimension)
    assert seen > 10
    assert dimensions > 4


def test_a_limit_that_falls_while_all_contacts_stick_is_met() -> None:
    """Needed forces and limits are straight lines then: no series ends the step."""
    law = ss.Coulomb(mu=0.4)
    loaded = ss.Contact(at=1, friction=law, static=1.0, V=0.2, load=[-0.5, -0.5])
    model = ss.Structure(
        [1.0, 1.0], [[2.0, 1.0], [1.0, 3.0]],
        contacts=[loaded, ss.Contact(at=0, friction=law, static=1.0, V=0.2)],
    )  # fmt: skip
    f = ss.return_map(model, contact=1, event="landing")
    start = [-0.2, 0.1], [0.2, 0.2]
    motion = ss.simulate(model, *start, t_end=20.0)
    (first, *_) = returns(model, "landing", 1, f.direction, motion)
    found = f.evaluate(f.point(*start))
    np.testing.assert_allclose(found.duration, first, rtol=1e-13)
    np.testing.assert_allclose(found.value, f.point(motion.x(first), motion.v(first)), rtol=1e-12)
    # Contact 0 needs 0.1 + 0.8 t and has 1.05 - 0.2 t.
    assert motion.modes[1].tolist() == [-1, 0]
    np.testing.assert_allclose(motion.t[1], 0.95, rtol=1e-14)


@pytest.mark.parametrize("seed", [*range(12), *slow(*range(12, 40))])
def test_derivatives_are_the_limits_of_differences(seed: int) -> None:
    if (case := drawn(seed)) is None:
        return
    f, start, _, _ = case
    own = f.evaluate(start)

    def check(exact, move) -> None:  # type: ignore[no-untyped-def]
        h = min(1e-4, 1e-3 * float(own.margin))
        try:
            ends = [move(k * h) for k in (-2, -1, 1, 2)]
        except ValueError:
            return  # a parameter at the end of its range
        if any(end.status != ss.status.OK or end.label != own.label for end in ends):
            return
        low2, low, high, high2 = (end.value for end in ends)
        expected = (8 * (high - low) - (high2 - low2)) / (12 * h)
        size = 1.0 + np.abs(expected).max()
        assert np.abs(exact - expected).max() < (1e-7 + 1e-13 / h) * size, seed

    start = np.atleast_1d(start)
    jacobian = np.reshape(own.derivative, (f.dimension, f.dimension))
    for j in range(f.dimension):
        unit = np.eye(f.dimension)[j]
        shape = start.shape if f.dimension > 1 else ()
        check(jacobian[:, j], lambda h, u=unit, s=shape: f.evaluate((start + h * u).reshape(s)))
    for name, value in f.parameters.items():
        if name.endswith("frequency") and f.model.plant.n_waves > 2:
            continue
        point = start if f.dimension > 1 else float(start[0])
        change = f.parameter_derivative(point, name)
        check(change, lambda h, n=name, v=value, p=point: f.replace(**{n: v + h}).evaluate(p))


def test_a_hunting_axis_is_a_map_of_the_line() -> None:
    f = ss.return_map(axis(), coordinates=["x_2"])
    low, high = f.domain
    assert low < 1e-15  # the integral of a positive error grows up to the limit
    image = f(np.linspace(low, high, 200))
    assert low <= image.min() <= image.max() <= high
    (orbit,) = ss.periodic_orbits(f, max_period=3)
    x, v, _ = f.state(orbit.points[0])
    cycle = ss.find_cycle(f.model, x, v)
    np.testing.assert_allclose(f.evaluate(orbit.points[0]).duration, cycle.period, rtol=1e-12)
    np.testing.assert_allclose(orbit.multiplier, cycle.multipliers[0].real, rtol=1e-9)
    # It is its own mirror image: half of it maps x to -x.
    forward = ss.return_map(axis(), coordinates=["x_2"], direction="forward")
    (mirrored,) = ss.periodic_orbits(forward, max_period=3)
    np.testing.assert_allclose(mirrored.points, -orbit.points, rtol=1e-12)


def test_an_axis_without_a_gap_of_friction_does_not_hunt() -> None:
    f = ss.return_map(axis(mu=1.0), coordinates=["x_2"], domain=(1e-9, 0.04))
    assert (f(np.linspace(1e-3, 0.04, 50)) < np.linspace(1e-3, 0.04, 50)).all()
    assert not ss.periodic_orbits(f, max_period=2)


def test_orbits_end_where_they_leave_the_domain() -> None:
    f = ss.return_map(axis(mu=1.0), coordinates=["x_2"], domain=(1e-3, 0.04))
    inside = f.iterate([0.002, 0.04], 40)
    assert np.isfinite(inside[:, 0]).all()
    for orbit in inside:
        known = orbit[np.isfinite(orbit)]
        assert (known[:-1] >= 1e-3).all()
        assert 0 < known[-1] < 1e-3  # the point that has left is told, none after it
        assert np.isnan(orbit[len(known) :]).all()


def test_a_shaken_block_is_a_map_of_the_circle() -> None:
    f = ss.return_map(shaken())
    assert f.coordinates == ("phase",)
    breaks = ss.breakpoints(f)
    texts = [b.mechanism for b in breaks]
    assert any("touches its upper static limit" in text for text in texts)
    assert any("grazes its stick interval" in text for text in texts)
    assert sum("makes no release" in text for text in texts) == 2
    orbits = ss.periodic_orbits(f, max_period=1)
    stable = next(orbit for orbit in orbits if abs(orbit.multiplier) < 1)
    x, v, t = f.state(stable.points[0])
    # The period of the forcing later the block is where it was: a point of the stroboscopic map.
    strobe = ss.stroboscopic_map(f.model)
    ahead = ss.simulate(f.model.replace(**{"forcing.phase": 0.45 * t}), x, v, t_end=100.0)
    rest = strobe.period - t
    state = np.concatenate([ahead.x(rest), ahead.v(rest)])
    cycle = strobe.periodic_point(state)
    rounds = round(cycle.period / strobe.period)
    duration = f.evaluate(stable.points[0]).duration
    np.testing.assert_allclose(duration, rounds * strobe.period, rtol=1e-12)
    np.testing.assert_allclose(stable.multiplier, cycle.multipliers[0].real, rtol=1e-8)


def test_a_forced_motion_that_never_comes_back_is_known_by_its_cycle() -> None:
    # Contact 0, on a fast belt, sticks no more; block 2 sticks and slips with the force.
    model = ss.Structure(
        mass=[1.0, 1.0],
        stiffness=[[1.5, -0.5], [-0.5, 1.5]],
        damping=[0.2, 0.2],
        contacts=[ss.Contact(0, ss.Coulomb(0.3), V=3.0), ss.Contact(1, ss.Coulomb(0.3), V=0.2)],
        forcing=ss.Harmonic(amplitude=[0.0, 0.4], frequency=0.7),
    )
    points = np.random.default_rng(0).uniform([0, -1, -1], [6, 1, 1], (7, 3))
    found = ss.return_map(model).evaluate(points)
    assert set(found.status.tolist()) == {ss.status.NEVER_CYCLE}
    assert (found.n_events < 100).all()
    cycle = ss.find_cycle(model, [1.0, 0.0], [0.0, 0.2])
    assert cycle.stable
    assert cycle.period == pytest.approx(2 * np.pi / 0.7, rel=1e-9)


def test_bifurcations_of_a_shaken_block() -> None:
    found = ss.bifurcations(ss.return_map(shaken()), "V", (0.0303, 0.0304), max_period=1, n_lists=3)
    kinds = [b.kind for b in found]
    assert "border_collision" in kinds


def test_nothing_bifurcates_where_an_orbit_passes_the_phase_0() -> None:
    """It was said to enter a gap, or to meet the border where a block touches its limit."""
    f = ss.return_map(shaken())
    orbits = [
        *ss.periodic_orbits(f.replace(V=0.141), 1),
        *ss.periodic_orbits(f.replace(V=0.142), 1),
    ]
    assert np.ptp([orbit.points[0] for orbit in orbits if not orbit.stable]) > 6.0
    found = ss.bifurcations(f, "V", (0.141, 0.142), max_period=1, n_lists=3)
    assert len(found) == len(found.unresolved) == 0
    block = shaken(0.0408, V=0.0279).replace(friction=ss.Stribeck(mu=0.66, speed=0.046, exponent=2))
    f = ss.return_map(block.replace(damping=0.0376, **{"forcing.frequency": 0.537}))
    cuts = [b for b in ss.breakpoints(f) if abs(abs(b.left - b.right) - TURN) < 1e-9]
    assert {b.mechanism for b in cuts} == {"the next event comes at the phase 0 of the forcing"}
    found = ss.bifurcations(f, "V", (0.0279, 0.028), max_period=2, n_lists=3)
    assert len(found) == len(found.unresolved) == 0


def test_each_phase_of_an_orbit_is_compared_the_short_way_round() -> None:
    """Points of a line are numbers, not rows: curves of orbits of period 2 met an IndexError."""
    f = ss.return_map(shaken())
    phases = np.array([0.1, TURN - 0.1, 3.0])
    assert apart(f, phases, np.roll(phases, -1)) == pytest.approx([0.2, -3.1, 2.9])


def test_a_creep_that_the_map_ends_is_no_orbit() -> None:
    """Contact 2 crept at 6e-12, came to stick, and went elsewhere: listed as a stable orbit."""
    belts = [ss.Contact(0, friction=ss.Coulomb(0.634381998525305), V=0.1)]
    belts.append(ss.Contact(1, friction=ss.Coulomb(0.5), V=-0.1))
    brake = ss.Structure(
        mass=[1.0, 1.4],
        stiffness=[[1.5, -0.5], [-0.5, 1.2]],
        damping=[[0.05, 0.0], [0.0, 0.05]],
        contacts=belts,
    )
    f = ss.return_map(brake, domain=[(-3.0, 3.0), (-3.0, 3.0)])
    for orbit in ss.periodic_orbits(f, n_starts=16):
        assert f(f(orbit.points)) == pytest.approx(orbit.points, abs=1e-9)


def test_a_free_rotor_loses_its_angle() -> None:
    law = ss.Coulomb(mu=0.5)
    discs = ss.Structure(
        mass=[2.0, 0.5],
        stiffness=[[1.0, -1.0], [-1.0, 1.0]],
        damping=[[0.4, 0.0], [0.0, 0.0]],
        force=[0.8, 0.0],
        contacts=[ss.Contact(at=1, friction=law)],
    )
    f = ss.return_map(discs, direction="forward")
    assert f.dimension == 1
    (orbit,) = (o for o in ss.periodic_orbits(f, max_period=1) if abs(o.multiplier) < 1)
    x, v, _ = f.state(orbit.points[0])
    cycle = ss.find_cycle(discs, x, v)
    np.testing.assert_allclose(f.evaluate(orbit.points[0]).duration, cycle.period, rtol=1e-12)
    np.testing.assert_allclose(orbit.multiplier, cycle.multipliers[0].real, rtol=1e-8, atol=1e-10)


def test_a_motion_that_comes_to_slide_steadily_returns_no_more() -> None:
    discs = ss.Structure(
        mass=[2.0, 0.5],
        stiffness=[[1.0, -1.0], [-1.0, 1.0]],
        damping=[[0.4, 0.0], [0.0, 0.1]],
        force=[1.5, 0.0],
        contacts=[ss.Contact(at=1, friction=ss.Coulomb(mu=0.5))],
    )
    f = ss.return_map(discs, direction="forward", domain=(0.0, 10.0))
    found = f.evaluate([1.0, 4.0])
    assert (found.status == ss.status.NEVER_CYCLE).all()
    x, v, _ = f.state(4.0)
    end = ss.simulate(discs, x, v, t_end=1000.0).final_state
    assert end.v[1] > 0.0  # turns without sticking
    assert np.ptp(end.v) < 1e-9


def test_a_motion_whose_contact_is_lost_returns_no_more() -> None:
    """A load that follows a free oscillation, 1 + 0.3 x_2, vanishes before the block comes back."""
    contact = ss.Contact(at=0, friction=ss.Coulomb(mu=0.5), V=1.0, load=[0.0, 0.3])
    model = ss.Structure(mass=[1.0, 1.0], stiffness=np.eye(2), contacts=[contact])
    f = ss.return_map(model)
    release = {speed: f.point([1.0, 0.0], [1.0, -speed]) for speed in (2.0, 4.0)}
    assert f.evaluate(release[2.0]).status == ss.status.OK
    found = f.evaluate(release[4.0])  # x_2 = -4 sin t
    assert found.status == ss.status.CONTACT_LOST
    assert np.isnan(found.value).all()
    np.testing.assert_allclose(found.duration, np.arcsin(1 / 1.2), rtol=1e-14)


def test_a_map_is_saved_and_made_again(tmp_path) -> None:  # type: ignore[no-untyped-def]
    f = ss.return_map(axis(), coordinates=["x_2"])
    branches = ss.branches(f)
    branches.save(tmp_path / "branches.json")
    assert ss.load(tmp_path / "branches.json").f == f
    assert f.replace(A_3_1=-3.0) != f


def test_what_no_section_is_made_of_is_refused() -> None:
    block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.3))
    with pytest.raises(ValueError, match="release of contact 1 is one state"):
        ss.return_map(block)
    assert ss.return_map(block, event="landing").coordinates == ("x_1",)
    with pytest.raises(ValueError, match="contact = 3"):
        ss.return_map(axis(), contact=3)
    for names in (["x_3"], ["x_1", "x_2"], ["x_2", "x_3"]):  # one is needed, and x_3 is 0
        with pytest.raises(ValueError, match="such as"):
            ss.return_map(axis(), coordinates=names)
    with pytest.raises(ValueError, match="release of contact 1 is one state"):
        ss.return_map(axis().replace(A_3_1=0.0), coordinates=["x_2"])  # x_1 acts on nothing
    with pytest.raises(ValueError, match="event = 'slip'"):
        ss.return_map(axis(), event="slip")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="pair"):
        ss.return_map(axis(), domain=[1, 2, 3])
    f = ss.return_map(axis(), coordinates=["x_2"])
    with pytest.raises(ValueError, match="outside the domain"):
        f(-1.0)
    with pytest.raises(ValueError, match="no release of contact 1"):
        f.point([0.0, 0.3, 0.2], [])
    with pytest.raises(ValueError, match="t = "):
        f.point([0.0, 0.3, 0.2], [], t=10**400)
    for one in (f.state, f.begun):
        with pytest.raises(ValueError, match="one point is needed"):
            one([])
    chain = ss.Chain([1.0, 1.2, 0.9], alpha=1.1, V=0.1, friction=ss.Coulomb(mu=0.4))
    wide = ss.return_map(chain)
    assert wide.dimension == 4
    with pytest.raises(ValueError, match="bounded domain"):
        ss.periodic_orbits(wide)
    with pytest.raises(ValueError, match="4 finite numbers"):
        wide([0.0, 1.0])
    with pytest.raises(ValueError, match="d = None"):
        wide.contains(None)
    with pytest.raises(ValueError, match="hold 4 numbers"):
        wide.contains(0.5)
    with pytest.raises(ValueError, match="one global stick phase"):
        ss.simulate(chain, d=[[0.1, 0.2]], t_end=1.0)


def test_orbits_end_where_they_leave_the_ranges_that_were_given() -> None:
    """Attractors were followed outside of them, where nothing has a derivative."""
    block = ss.Oscillator(
        V=0.1, friction=ss.Coulomb(mu=0.23), damping=0.039, forcing=ss.Harmonic(0.41, 1.5)
    )
    free = ss.return_map(block, event="landing")
    narrow = ss.return_map(block, event="landing", domain=[(0.0, TURN), (-0.1, 0.1)])
    points = np.array([[1.0, 0.0], [4.0, 0.05]])
    there, here = free.iterate(points, 5), narrow.iterate(points, 5)
    stays = np.logical_and.accumulate(narrow.contains(there[:, :-1]), axis=1)
    np.testing.assert_array_equal(here[:, 1:][stays], there[:, 1:][stays])
    assert np.isnan(here[:, 1:][~stays]).all()
    assert 0 < stays.sum() < stays.size
    left = ss.attractors(narrow, n_starts=8).left
    assert left == ss.basins(narrow, n_samples=8).left == 1.0


def test_orbits_are_followed_across_the_turn_of_the_phase() -> None:
    """A phase has no ends: orbits were lost where one of their events came to phase 2 pi."""
    block = ss.Oscillator(
        V=0.1, friction=ss.Coulomb(mu=0.23), damping=0.039, forcing=ss.Harmonic(0.41, 1.5)
    )
    f = ss.return_map(block, event="landing", domain=[(0.0, TURN), (-3.0, 3.0)])
    assert f.contains([[TURN + 0.1, 0.0], [-0.1, 0.0], [1.0, 3.1]]).tolist() == [True, True, False]
    narrow = ss.return_map(block, event="landing", domain=[(1.0, 2.0), (-3.0, 3.0)])
    assert narrow.contains([[TURN + 1.5, 0.0], [0.5, 0.0]]).tolist() == [True, False]
    at = f.replace(V=0.1702)
    near = [orbit for orbit in ss.periodic_orbits(at, n_starts=32) if orbit.points[0, 0] > 6.2]
    curve = ss.follow(near[0], "V", (0.1698, 0.1703))
    assert curve.end_reasons == ("end of range", "end of range")
    assert np.ptp(curve.points[:, 0, 0]) > 0.0
    phases = curve.points[:, 0, 0]
    assert phases.min() < TURN < phases.max() or phases.min() < 0.0 < phases.max()


def test_a_contact_that_acts_on_nothing_else_is_felt_by_its_friction() -> None:
    """A drill string whose bit acts on nothing: its speed was taken for a turn of a free rotor."""
    drill = ss.Structure.from_state_space(
        A=[[0.0, 1.0, 0.0], [-0.2, -5.0, 0.0], [2.0, 0.0, 0.0]],
        B=[[0.0], [0.0], [25.0]],
        C=[[0.0, 0.0, 1.0]],
        a=[0.0, 30.0, 0.0],
        contacts=[ss.Contact(at=0, static=0.3, friction=ss.Coulomb(mu=0.5))],
    )
    f = ss.return_map(drill, direction="forward", domain=[(1.0, 15.0)])
    assert f.coordinates == ("x_2",)
    assert np.isnan(f([2.0])).all()  # x_1 goes to 150, and pulls the bit on for ever
