"""Where the event map is defined, and what holds the motions that never come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import stickslip as ss

LAW9 = ss.examples.law9()
COULOMB = ss.examples.coulomb()


def test_law_9_has_a_gap_at_the_papers_own_speed() -> None:
    """It opens where the motion without global stick begins to attract: a flip of its cycle."""
    region = ss.return_region(LAW9, "V", (0.25, 0.295), n_values=2, n_points=61)
    assert region.gaps[0] == ()
    (gap,) = region.gaps[1]
    np.testing.assert_allclose(gap.d, (0.57089, 0.66729), rtol=0, atol=1e-5)
    f = ss.event_map(LAW9)
    assert np.isnan(f(list(gap.d))).all()
    assert np.isfinite(f([gap.d[0] - 1e-9, gap.d[1] + 1e-9])).all()
    assert gap.shown
    (branch,) = region.curves
    ((low, high),) = region.attracting(0)
    flip = next(item for item in branch.bifurcations if item.kind == "flip")
    assert (low, high) == (flip.value, 0.295)
    assert low == pytest.approx(0.2557005970104, abs=1e-12)
    assert region.lost[1] == pytest.approx((gap.d[1] - gap.d[0]) / np.ptp(LAW9.domain))
    assert region.undecided.sum() == 0
    cycle = branch[-1]
    assert cycle.period == pytest.approx(4.380753446647, abs=1e-12)
    np.testing.assert_allclose(
        sorted(cycle.multipliers, key=np.imag),
        [-0.827798 - 0.382536j, 0, -0.827798 + 0.382536j],
        rtol=0,
        atol=1e-6,
    )


def test_the_coulomb_system_is_defined_everywhere_at_small_speeds() -> None:
    region = ss.return_region(COULOMB, "V", (0.0366, 0.5), n_values=2)
    assert region.gaps[0] == ()
    assert len(region.gaps[1]) == 2
    assert all(gap.shown for gap in region.gaps[1])
    assert region.lost[1] == pytest.approx(0.35, abs=0.005)
    order = np.argsort([region.attracting(number)[0][0] for number in range(2)])
    first, second = (region.curves[number] for number in order)
    starts = [region.attracting(number)[0][0] for number in order]
    np.testing.assert_allclose(starts, [0.3052777301711, 0.3726915672690], rtol=0, atol=1e-12)
    ends = [branch[-1] for branch in (first, second)]
    assert [cycle.model.V for cycle in ends] == [0.5, 0.5]
    periods = [cycle.period for cycle in ends]
    np.testing.assert_allclose(periods, [3.628666666835, 7.196866258368], rtol=0, atol=1e-12)
    sizes = [np.abs(cycle.multipliers).max() for cycle in ends]
    np.testing.assert_allclose(sizes, [0.611530, 0.763548], rtol=0, atol=1e-6)
    (tie,) = [item.value for item in first.bifurcations if item.kind == "tie"]
    assert tie == pytest.approx(0.298002973386, abs=2e-12)
    table = region.table()
    assert set(table["status"]) == {"NEVER_CYCLE"}
    axes = region.plot()
    assert axes.get_ylabel() == "$d$"
    assert "defined everywhere" in repr(region)


@pytest.mark.parametrize(
    ("alpha", "gap", "percent"),
    [
        (1.208, (0.5708915706, 0.6672922268), 7.16),
        (1.209859795641, (0.5701856255, 0.6666943880), 7.17),
        (1.2153, (0.5681204384, 0.6649603417), 7.22),
    ],
)
def test_the_gaps_of_law_9_end_where_the_docs_say(alpha, gap, percent) -> None:
    f = ss.event_map(LAW9.replace(alpha=alpha))
    low, high = gap
    inside = f.evaluate([low + 1e-10, *np.linspace(low, high, 9)[1:-1], high - 1e-10])
    assert (inside.status == ss.status.NEVER_CYCLE).all()
    assert np.isfinite(f([low - 1e-10, high + 1e-10])).all()
    assert 100 * (high - low) / np.ptp(f.domain) == pytest.approx(percent, abs=0.005)


@pytest.mark.parametrize("seed", range(3))
def test_a_ball_takes_motions_in_and_holds_them(seed: int) -> None:
    """States drawn anywhere in it are back inside after a return, closer by the factor told."""
    cycle = ss.find_cycle(LAW9, LAW9.onset(0.62), [LAW9.V] * 2)
    ball = ss.trapping_ball(cycle)
    assert ball is not None
    assert ball.rate == pytest.approx(0.953, abs=5e-4)
    assert ball.curvature == pytest.approx(19.4, abs=0.05)
    assert ball.radius == pytest.approx(0.0020, abs=5e-5)
    assert ball.contraction == pytest.approx(0.992, abs=5e-4)
    rng = np.random.default_rng(seed)
    center, free = ball.section
    offset = rng.normal(size=len(ball.norm))
    offset *= ball.radius * rng.uniform() / np.sqrt(offset @ ball.norm @ offset)
    z = center.copy()
    z[free] += offset
    before = np.sqrt(offset @ ball.norm @ offset)
    motion = ss.simulate(LAW9, z[:2], z[2:] + LAW9.V, t_end=1.2 * cycle.period)
    landed = [e.time for e in motion.events if abs(e.time - cycle.period) < 0.2]
    distances = []
    for time in landed:
        end = np.concatenate([motion.x(time), motion.v(time) - LAW9.V])
        back = (end - center)[free]
        distances.append(np.sqrt(back @ ball.norm @ back))
    assert min(distances) <= ball.contraction * before
    assert ball.entered(LAW9.onset(0.6), [LAW9.V] * 2) is not None
    assert ball.entered(LAW9.onset(0.1), [LAW9.V] * 2, max_events=400) is None


def test_cycles_that_repel_have_no_ball() -> None:
    cycle = ss.find_cycle(LAW9, LAW9.onset(0.62), [LAW9.V] * 2)
    branch = ss.follow(cycle, "V", (0.2, 0.3))
    assert not branch[0].stable
    assert branch[0].model == LAW9.replace(V=0.2)
    # where it leaves the event map
    (tie,) = [item.value for item in branch.bifurcations if item.kind == "tie"]
    assert tie == pytest.approx(0.208512996650, abs=2e-12)
    assert ss.trapping_ball(branch[0]) is None
    block = ss.Oscillator(V=0.2, friction=ss.PoppStelter(gamma=3), damping=1.25)
    slip = ss.find_cycle(block, ss.equilibria(block)[0].x + 0.198, [0.0])
    with pytest.raises(ValueError, match="no landing"):
        ss.trapping_ball(slip)


def test_bad_input_is_told() -> None:
    with pytest.raises(ValueError, match="two blocks"):
        ss.return_region(ss.Oscillator(V=1, friction=ss.Coulomb(0.2)), "V", (0.1, 1))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="not a parameter"):
        ss.return_region(COULOMB, "v", (0.1, 1))
    with pytest.raises(ValueError, match="n_values"):
        ss.return_region(COULOMB, "V", (0.1, 1), n_values=0)


def test_a_region_comes_back_from_its_file(tmp_path: Path) -> None:
    region = ss.return_region(LAW9, "V", (0.294, 0.295), n_values=2, n_points=21)
    region.save(tmp_path / "region.json")
    again = ss.load(tmp_path / "region.json")
    assert repr(again) == repr(region)
    assert again.model == LAW9
    (gap,), (same,) = region.gaps[1], again.gaps[1]
    assert same.d == gap.d
    cycle, read = gap.ball.cycle, same.ball.cycle
    assert read.events == cycle.events
    assert read.events[0].kind == cycle.events[0].kind
    np.testing.assert_array_equal(read.multipliers, cycle.multipliers)
    # ... and goes on working
    x, v = LAW9.onset(0.6), [LAW9.V] * 2
    assert same.ball.entered(x, v) == gap.ball.entered(x, v)
    again.curves[0].save(tmp_path / "branch.json")
    branch = ss.load(tmp_path / "branch.json")
    np.testing.assert_array_equal(branch.data["period"], region.curves[0].data["period"])
    assert repr(branch) == repr(region.curves[0])
