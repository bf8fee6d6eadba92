"""The skew tent: its attractor by renormalisation against known regions and brute force."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.bifurcations.border_collision.classification import (
    observed,
    predicted_at_corner,
)
from stickslip.analysis.bifurcations.border_collision.skew_tent import (
    attractor_of_skew_tent,
    doubled_side,
    paired_side,
)
from stickslip.analysis.bifurcations.outcome import LocalAttractor, disagreement
from stickslip.analysis.orbits.periodic import periodic_orbits

CLEAR = 0.03  # relative distance of slopes from a border between regions
DOMAIN = 25.0

slopes = st.one_of(st.just(0.0), st.floats(1e-3, 4), st.floats(-4, -1e-3))
folded = st.tuples(st.floats(0.05, 1.6), st.floats(-9, -1))


def _clear(a, b, side):
    """Whether slopes nearby have the same attractor."""
    around = {
        attractor_of_skew_tent(a * (1 + i * CLEAR), b * (1 + j * CLEAR), side)
        for i in (-1, 0, 1)
        for j in (-1, 0, 1)
    }
    return len(around) == 1


def _brute_force(a, b, side):
    """Follow many orbits of the map and look at where they are in the end."""
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, 64)
    noise = 1e-14 * rng.standard_normal((8_200, 64))  # floats have few bits
    late = []
    with np.errstate(over="ignore", invalid="ignore"):
        for k, push in enumerate(noise):
            x = np.where(x < 0, a, b) * x + side + push
            if k >= 8_000:
                late.append(x)
    end = np.array(late)[:, np.abs(x) < 1e3]
    if not end.size:
        return LocalAttractor("none")
    for p in range(1, 65):
        if np.abs(end[p:] - end[:-p]).max() < 1e-9:
            return LocalAttractor("periodic", p)
    return LocalAttractor("chaotic")


@settings(max_examples=50)
@given(ab=st.one_of(st.tuples(slopes, slopes), folded), side=st.sampled_from([-1, 1]))
def test_kind_and_period_are_those_of_orbits_followed(ab, side):
    a, b = ab
    assume(_clear(a, b, side))
    predicted = attractor_of_skew_tent(a, b, side)
    found = _brute_force(a, b, side)
    assert found.kind == predicted.kind
    if predicted.kind == "periodic":
        assert found.period == predicted.period


@settings(max_examples=25)
@given(ab=folded)
def test_bands_are_those_that_the_search_for_attractors_finds(ab):
    a, b = ab
    predicted = attractor_of_skew_tent(a, b)
    assume(predicted.kind == "chaotic" and predicted.period <= 8 and _clear(a, b, 1))
    # A domain that holds the unstable fixed point beside the attractor, if there is one.
    found = attractors(examples.border_collision(a, b, 1.0, size=DOMAIN))
    assert {(x.kind, len(x.bands)) for x in found} == {("chaotic", predicted.period)}


@settings(max_examples=30)
@given(
    ab=st.one_of(st.tuples(slopes, slopes), folded),
    direction=st.sampled_from([-1, 1]),
)
def test_predicted_outcomes_are_observed(ab, direction):
    a, b = ab
    assume(_clear(a, b, 1) and _clear(a, b, -1))
    assume(min(abs(abs(s) - 1) for s in (a, b, a * b)) > 2 / DOMAIN)  # all orbits inside
    maps = [examples.border_collision(a, b, side * direction, size=DOMAIN) for side in (-1.0, 1.0)]
    predicted = predicted_at_corner(a, b, direction)
    seen = observed(
        *(periodic_orbits(f, 2) for f in maps), *(attractors(f) for f in maps), width=2 * DOMAIN
    )
    assert seen.orbits == predicted.orbits
    assert disagreement(predicted, seen) == ""


# Known answers: Maistrenko et al. 1993; Sushko et al. 2016; values by their formulas.
@pytest.mark.parametrize("n", [2, 3, 4, 5])
@pytest.mark.parametrize("a", [0.2, 0.45])
def test_maximal_cycles_exist_and_are_stable_between_their_borders(a, n):
    born = -(1 - a ** (n - 1)) / ((1 - a) * a ** (n - 2))
    lost = -1 / a ** (n - 1)
    cycle = LocalAttractor("periodic", n)
    assert attractor_of_skew_tent(a, born * (1 + 1e-9)) == cycle
    assert attractor_of_skew_tent(a, lost * (1 - 1e-9)) == cycle
    assert attractor_of_skew_tent(a, born * (1 - 1e-9)) != cycle
    after = attractor_of_skew_tent(a, lost * (1 + 1e-9))
    # Chaos follows; next to a cycle of period 2 in many bands, else in two at every point.
    assert after.kind == "chaotic"
    assert after.period % (2 * n) == 0
    if n > 2:
        assert after.period == 2 * n


def test_tent_maps_have_bands_that_double_at_roots_of_two():
    for k in range(5):
        slope = 2 ** (0.5 ** (k + 0.5))  # between 2^(1/2^(k + 1)) and 2^(1/2^k)
        assert attractor_of_skew_tent(slope, -slope) == LocalAttractor("chaotic", 2**k)


@given(a=st.floats(1.01, 5))
def test_chaos_ends_where_the_corner_reaches_the_fixed_point(a):
    border = -a / (a - 1)
    assert attractor_of_skew_tent(a, border * (1 - 1e-9)).kind == "chaotic"
    assert attractor_of_skew_tent(a, border * (1 + 1e-9)).kind == "none"


def test_square_roots():
    inf = math.inf
    assert attractor_of_skew_tent(0.2, -inf).kind == "period-incrementing"
    assert attractor_of_skew_tent(0.7, -inf).kind == "chaotic"
    assert attractor_of_skew_tent(0.2, -inf, -1) == LocalAttractor("periodic", 1)
    assert attractor_of_skew_tent(0.2, inf) == LocalAttractor("none")
    assert attractor_of_skew_tent(1.5, -inf) == LocalAttractor("none")
    assert attractor_of_skew_tent(-0.5, -inf) == LocalAttractor("none")
    assert attractor_of_skew_tent(0.0, -inf) == LocalAttractor("periodic", 2)


@pytest.mark.parametrize("lam", [0.2, 0.7])
def test_square_roots_are_followed_by_what_is_predicted(lam):
    found = attractors(examples.square_root(lam, 2e-3))
    kinds = {x.kind for x in found}
    if lam < 0.25:
        assert kinds == {"periodic"}
        assert min(x.period for x in found) > 2
    else:
        assert kinds == {"chaotic"}


@given(a=slopes, b=slopes, mu=st.sampled_from([-1.0, 1.0]))
def test_orbits_are_where_feigin_says(a, b, mu):
    assume(min(abs(abs(s) - 1) for s in (a, b, a * b)) > 1e-3)
    left, right = mu / (1 - a) <= 0, mu / (1 - b) >= 0
    assert (left and right) == (paired_side(a, b) == mu)
    assert (left or right) == (paired_side(a, b) in (0, mu))
    low, high = mu * (1 + b) / (1 - a * b), mu * (1 + a) / (1 - a * b)
    assert (low < 0 < high) == (doubled_side(a, b) == mu)


@pytest.mark.parametrize("ab", [(0.5, -1.0), (math.nan, 2.0), (0.5, -2.0), (0.5, -3.0)])
def test_neutral_slopes_are_undecided(ab):
    assert attractor_of_skew_tent(*ab).kind == "undecided"
