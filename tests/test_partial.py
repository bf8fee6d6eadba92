"""Progress rises to 1; Ctrl-C returns what has been found, and says what has not."""

import numpy as np
import pytest
from tests.analysis.known_maps import logistic
from tests.sizes import slow

import stickslip as ss

SHARES_ADD_UP = 1e-9
CUBIC = ss.PiecewiseMap(lambda x, r: r * x - x**3, (-1.8, 1.8), parameters={"r": 2.3})


def henon(a):
    def func(z, a):
        return np.stack([1 - a * z[..., 0] ** 2 + z[..., 1], 0.3 * z[..., 0]], axis=-1)

    return ss.Map(func, 2, parameters={"a": a}, domain=[(-1.3, 1.3), (-0.4, 0.4)])


class Interrupt:
    """Ctrl-C at the first report beyond a share; notes all."""

    def __init__(self, after=np.inf):
        self.after, self.told = after, []

    def __call__(self, share):
        self.told.append(share)
        if share > self.after:
            self.after = np.inf
            raise KeyboardInterrupt


def orbit_curve(**how):
    f = logistic(3.2)
    (orbit,) = ss.periodic_orbits(f, period=2)
    return ss.follow(orbit, "r", (3.1, 3.4), **how)


def plane_curve(**how):
    (flip,) = ss.bifurcations(CUBIC_AND_LIFT, "r", (1.9, 2.1), max_period=1).of_kind("flip")[:1]
    return ss.follow(flip, "b", (-0.2, 0.2), solve_for="r", **how)


CUBIC_AND_LIFT = ss.PiecewiseMap(
    lambda x, r, b: b + r * x - x**3, (-1.6, 1.6), parameters={"r": 2.0, "b": 0.05}
)
CALLS = {
    "attractors": lambda **how: ss.attractors(logistic(3.9), **how),
    "attractors of the plane": lambda **how: ss.attractors(henon(1.4), n_starts=8, **how),
    "basins": lambda **how: ss.basins(CUBIC, **how),
    "basins of the plane": lambda **how: ss.basins(
        henon(1.0), grid=[(-1, 1, 300), (-0.3, 0.3, 300)], **how
    ),
    "shares along a parameter": lambda **how: ss.basin_fractions(
        henon(1.0), "a", [1.0, 1.1], n_samples=100, n_starts=8, **how
    ),
    "a spectrum": lambda **how: ss.lyapunov_spectrum(henon(1.4), [0.1, 0.1], 2000, **how),
    "spectra along a parameter": lambda **how: ss.lyapunov_spectra(
        henon(1.0), "a", [1.3, 1.4], [0.1, 0.1], 600, **how
    ),
    "a motion": lambda **how: ss.simulate(ss.examples.coulomb(), d=0.1, t_end=50, **how),
    "an orbit": orbit_curve,
    "a bifurcation": plane_curve,
}


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_progress_rises_to_the_end(call):
    watch = Interrupt()
    call(progress=watch)
    assert watch.told == sorted(watch.told)
    assert len(watch.told) > 1
    assert 0 <= watch.told[0]
    assert 0.5 <= watch.told[-1] <= 1


@pytest.mark.parametrize("call", CALLS.values(), ids=CALLS)
def test_an_interrupt_is_one_unless_a_part_is_wanted(call):
    with pytest.raises(KeyboardInterrupt):
        call(progress=Interrupt(0.0))


def test_interrupted_attractors_count_the_seeds_left_out():
    found = ss.attractors(logistic(3.2), progress=Interrupt(-1.0), partial=True)
    assert len(found) == 0
    assert found.unfollowed > found.n_starts
    assert f"interrupted: {found.unfollowed} not followed" in repr(found)
    assert not ss.attractors(logistic(3.2)).unfollowed


def test_interrupted_attractors_of_the_plane_keep_what_was_found():
    found = ss.attractors(henon(1.4), n_starts=8, progress=Interrupt(0.3), partial=True)
    (chaos,) = found
    assert chaos.kind == "chaotic"
    assert 0 < found.unfollowed < 8
    assert found.left + chaos.basin_share + found.unfollowed / 8 == pytest.approx(1, rel=1e-12)
    assert f"interrupted: {found.unfollowed} not followed" in repr(found)


@pytest.mark.parametrize("after", [-1.0, 0.3, 0.55, *slow(0.0, 0.49)])
def test_interrupted_basins_prove_less_and_say_so(after):
    whole, found = ss.basins(CUBIC), ss.basins(CUBIC, progress=Interrupt(after), partial=True)
    shares = [found.share(k) for k in range(len(found.attractors))]
    assert abs(sum(shares) + found.left + found.undecided - 1) < SHARES_ADD_UP
    assert "interrupted" in found.reason
    assert "interrupted" in repr(found)
    middle = 0.5 * (found.edges[:-1] + found.edges[1:])
    known = found.index >= 0
    for k, x in zip(found.index[known], middle[known], strict=True):
        mine = found.attractors[k].point
        assert whole.attractors[int(whole.at(x))].contains(mine, 1e-6)


def test_interrupted_basins_of_the_plane_count_the_starts_left_out():
    grid = [(-1, 1, 300), (-0.3, 0.3, 300)]
    whole = ss.basins(henon(1.0), grid=grid)
    found = ss.basins(
        henon(1.0), whole.attractors, grid=grid, progress=Interrupt(0.3), partial=True
    )
    assert 0 < found.unfollowed < found.index.size
    assert (found.index == -1).sum() >= found.unfollowed
    followed = found.index != -1
    assert (found.index == whole.index)[followed].all()
    assert f"{found.unfollowed} starts were not followed" in repr(found)


@pytest.mark.parametrize("after", [0.1, 0.8])
@pytest.mark.parametrize("call", [orbit_curve, plane_curve])
def test_an_interrupted_curve_ends_there(call, after):
    whole, curve = call(), call(progress=Interrupt(after), partial=True)
    assert 1 < len(curve) < len(whole)
    assert "interrupted" in curve.end_reasons
    assert (curve.end_reasons == ("interrupted", "interrupted")) == (after < 0.5)
    assert np.isin(curve.values, whole.values).all()
