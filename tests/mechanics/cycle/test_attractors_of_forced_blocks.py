"""A forced block by its return map: attractors, basins, spectra, bifurcations."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import stickslip as ss

TURN = 2 * np.pi
BOX = [(0.0, TURN), (-3.0, 3.0)]
BLOCK = ss.Oscillator(
    V=0.09, friction=ss.Coulomb(mu=0.32), damping=0.063, forcing=ss.Harmonic(1.45, 0.6)
)
CHAOTIC = ss.Oscillator(
    V=0.1, friction=ss.Coulomb(mu=0.23), damping=0.039, forcing=ss.Harmonic(0.41, 1.5)
)
SIGMA = 4.0


def landings(block: ss.Oscillator) -> Any:
    return ss.return_map(block, event="landing", domain=BOX)


@pytest.fixture(scope="module")
def found() -> Any:
    return ss.attractors(landings(BLOCK))


def test_two_cycles_attract_and_are_those_of_the_motion_in_time(found: Any) -> None:
    f = landings(BLOCK)
    assert [(each.kind, each.period) for each in found] == [("periodic", 1)] * 2
    for each in found:
        x, v, t = f.state(each.points[0])
        forced = BLOCK.replace(**{"forcing.phase": 0.6 * t})
        duration = float(np.ravel(f.evaluate(each.points).duration)[0])
        end = ss.simulate(forced, x, v, t_end=duration).final_state
        np.testing.assert_allclose([*end.x, *end.v], [*x, *v], rtol=0, atol=1e-11)


@pytest.mark.parametrize("n", [4000, pytest.param(100_000, marks=pytest.mark.slow)])
def test_shares_agree_with_those_of_random_starts(found: Any, n: int) -> None:
    f = landings(BLOCK)
    basins = ss.basins(f, found, n_samples=4096)
    assert basins.mistaken == 0
    low, high = np.array(BOX).T
    here = np.random.default_rng(0).uniform(low, high, (n, 2))
    for _ in range(40):
        here[~f.contains(here)] = np.nan
        inside = np.isfinite(here).all(axis=1)
        here[inside] = f(here[inside])
    away = [np.abs(here - each.points[0]).max(axis=1) for each in found]
    for k in (0, 1, -2):
        share, error = basins.share(k)
        p = (np.isnan(here[:, 0]) if k < 0 else away[k] < 1e-6).mean()
        assert abs(share - p) < SIGMA * np.hypot(error, np.sqrt(p * (1 - p) / n))


def test_exponents_are_those_of_plain_iteration_of_differences() -> None:
    """One direction is forgotten in a stick, the other one stretched."""
    f, n, h = landings(CHAOTIC), 4000, 1e-7
    start = ss.attractors(f, n_starts=16)[0].points[0]
    spectrum = ss.lyapunov_spectrum(f, start, 20_000)
    path = f.iterate(start, n + 100)[100:-1]
    sides = [f(path[:, None] + sign * h * np.eye(2)) for sign in (1, -1)]
    off = (sides[0] - sides[1] + np.array([TURN / 2, 0.0])) % TURN - np.array([TURN / 2, 0.0])
    off[..., 1] = (sides[0] - sides[1])[..., 1]
    slopes = np.swapaxes(off, 1, 2) / (2 * h)
    tangent, growth = np.array([0.6, 0.8]), []
    for slope in slopes:
        tangent = slope @ tangent
        growth.append(np.log(np.linalg.norm(tangent)))
        tangent /= np.linalg.norm(tangent)
    batches = np.array(growth).reshape(40, -1).mean(axis=1)
    error = batches.std(ddof=1) / np.sqrt(40)
    assert abs(batches.mean() - spectrum.values[0]) < SIGMA * (error + spectrum.errors[0])
    assert np.isneginf(spectrum.values[1])


@pytest.mark.slow
def test_everything_along_the_speed_is_located() -> None:
    """A cycle takes over at a jump, and ends in a fold with one that is born at another jump."""
    f, span = landings(CHAOTIC), (0.168, 0.184)
    found = ss.bifurcations(f, "V", span, max_period=1, n_lists=2, n_starts=32)
    diagram = ss.bifurcation_diagram(f, "V", (*span, 3), max_period=1, n_lists=2)
    ends = {end.value for curve in diagram.orbits for end in curve.ends} - set(span)
    for end in ends:
        assert min(abs(end - item.value) for item in found) < 1e-11
    assert found.unresolved == ()
    onset, birth, fold = found
    kinds = ["border_collision", "border_collision", "fold"]
    assert [item.kind for item in found] == kinds
    assert all(item.error < 1e-11 for item in found)
    assert onset.mechanism.startswith("block 1 sticks at the start on one side")
    assert birth.mechanism == "the force on riding block 1 touches its upper static limit"
    assert [item.period for item in onset.attractors_after] == [1]
    assert [item.kind for item in fold.attractors_after] != ["periodic"]
    value = f.replace(V=fold.value)(fold.points)
    np.testing.assert_allclose(np.sin(value - fold.points), 0.0, rtol=0, atol=1e-10)


def test_folds_and_collisions_along_the_amplitude_are_located() -> None:
    found = ss.bifurcations(
        landings(BLOCK), "forcing.amplitude", (1.0, 1.2), max_period=1, n_lists=2
    )
    assert found.unresolved == ()
    assert [item.outcome.orbits for item in found] == ["born in pairs", "persist"]
    assert [len(item.attractors_after) for item in found] == [2, 2]
