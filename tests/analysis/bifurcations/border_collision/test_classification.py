"""Outcomes of border collisions at jumps and gaps: closed forms, and the paper's systems."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.analysis import known_maps as examples

import stickslip as ss
from stickslip.analysis.attractors.attractors import attractors
from stickslip.analysis.bifurcations.border_collision import jump_return
from stickslip.analysis.bifurcations.border_collision.classification import (
    observed,
    predicted_at_corner,
    predicted_at_gap,
    predicted_at_jump,
)
from stickslip.analysis.bifurcations.border_collision.jump_return import far_image
from stickslip.analysis.bifurcations.outcome import LocalAttractor, Outcome, disagreement
from stickslip.analysis.branches.branches import breakpoints
from stickslip.analysis.maps.derived import EvaluatedMap
from stickslip.analysis.maps.piecewise_map import PiecewiseMap
from stickslip.analysis.orbits.periodic import periodic_orbits

SIZE = 3.0  # of the domains of normal forms
LINEAR = 1e-6  # relative: u is divided by a power of a slope that is itself extrapolated

near = st.floats(0.1, 0.9)
way_back = st.one_of(st.floats(-2, -0.05), st.floats(0.05, 0.95))


def _jump(a, b, jump, mu=0.0):
    f = examples.border_collision(a, b, mu, jump, size=SIZE)
    return f, breakpoints(f)[0]


def _mirrored(f):
    """The map seen from the other side: -f(-x)."""
    return PiecewiseMap(
        lambda x, **q: -f.func(-x, **q),
        f.domain,
        parameters=f.parameters,
        derivative=lambda x, a, b, mu, jump: np.where(x <= 0, b, a),
        breakpoints=[0.0],
    )


# ------------------------------------------------------------------ jumps: the way back


def growth(a, n):
    """The sum of a^-k from 1 to n."""
    return (a**-n - 1) / (1 - a)


def window(far, n):
    """The mu = f^p(c near) - c > 0 with a cycle of n p + r steps that crosses once.

    growth(n - 1) + b <= H / mu < growth(n) to first order; empty: the lower end is above.
    """
    bottom = growth(far.multiplier, n - 1) + far.slope
    return far.height / growth(far.multiplier, n), far.height / bottom if bottom > 0 else math.inf


def periods(far, mu):
    """The periods n p + r of stable cycles that cross once, mu past the collision."""
    windows = ((n, *window(far, n)) for n in range(1, 1000))
    there = itertools.takewhile(lambda item: item[2] >= mu, windows)
    return tuple(
        n * far.period + far.steps
        for n, low, _ in there
        if low < mu and abs(far.multiplier**n * far.slope) < 1
    )


@settings(max_examples=25)
@given(a=near, b=way_back)
def test_in_the_normal_form_one_step_leads_back(a, b):
    f, border = _jump(a, b, -1.0)
    far = far_image(f, border, -1, 1)
    assert (far.fate, far.steps) == ("returns", 1)
    assert far.multiplier == pytest.approx(a, rel=LINEAR)
    assert far.height == pytest.approx(1.0, rel=LINEAR)
    assert far.slope == pytest.approx(b, rel=LINEAR)
    assert (far.local_height, far.local_slope) == pytest.approx((-1.0, b), rel=LINEAR)


@settings(max_examples=25)
@given(a=near, b=way_back, n=st.integers(2, 9))
def test_windows_to_first_order_are_the_exact_ones_but_for_one(a, b, n):
    f, border = _jump(a, b, -1.0)
    first_order = window(far_image(f, border, -1, 1), n)
    exact = examples.maximal_window(a, b, n)
    assume(math.isfinite(first_order[1]))
    # The far branch moves with mu too, which the first order leaves out.
    for mine, closed in zip(first_order, exact, strict=True):
        assert 1 / mine == pytest.approx(1 / closed - 1, rel=1e-4, abs=1e-4)


@settings(max_examples=25)
@given(a=near, b=st.floats(-3, -1.05))
def test_two_steps_lead_back_over_a_steep_far_branch(a, b):
    # The far image l is thrown away; only the next one, b l + l, is on the near side. Whole
    # turns are divided out, here one: the height is that of which b l + l is the image.
    f, border = _jump(a, b, 0.9)
    far = far_image(f, border, -1, 1)
    assert (far.fate, far.steps) == ("returns", 1)
    assert far.slope == pytest.approx(b * b / a, rel=LINEAR)
    assert far.height == pytest.approx(0.9 * (-b - 1) / a, rel=LINEAR)
    outcome = predicted_at_jump(f, border, -1, 1)
    assert outcome.after == LocalAttractor("period-adding", base=1, offset=1)


@given(a=near, b=way_back, jump=st.sampled_from([-0.1, 0.1]))
@settings(max_examples=25)
def test_in_the_normal_form_slopes_alone_say_the_same(a, b, jump):
    assume(abs(abs(b) - 1) > 0.02)
    f, border = _jump(a, b, jump)
    outcome = predicted_at_jump(f, border, -1, 1)
    alone = outcome.text.rsplit("alone: ", 1)[1]
    if outcome.after.kind == "none":
        assert ("settles on the cycle of period 1" in outcome.text) == ("fixed point" in alone)
    else:
        assert alone.startswith(outcome.after.kind.replace("-", " "))


@pytest.mark.parametrize("n", [6, 8])
def test_the_way_back_tells_the_periods(n):
    a, b, jump = 0.5, -2.0, 0.9
    f, border = _jump(a, b, jump)
    far = far_image(f, border, -1, 1)
    low, high = window(far, n)
    mu = math.sqrt(low * high)
    assert periods(far, mu) == (n + 1,)
    found = attractors(f.replace(mu=mu))
    assert [x.period for x in found] == [n + 1]


def test_the_mirrored_map_gives_the_same():
    f, border = _jump(0.6, -0.7, -1.0)
    g = _mirrored(f)
    here, there = far_image(f, border, -1, 1), far_image(g, breakpoints(g)[0], 1, 1)
    assert (there.fate, there.steps) == (here.fate, here.steps)
    assert there.height == pytest.approx(here.height, rel=LINEAR)
    assert there.slope == pytest.approx(here.slope, rel=LINEAR)
    assert there.local_height == pytest.approx(here.local_height, rel=LINEAR)
    mirrored = predicted_at_jump(g, breakpoints(g)[0], 1, -1)
    assert mirrored.attractors == predicted_at_jump(f, border, -1, 1).attractors
    assert mirrored.orbits == "lost at a jump"


@pytest.mark.parametrize(
    ("a", "b", "jump", "fate", "after"),
    [
        (0.5, 0.3, 1.0, "settles", LocalAttractor("none")),  # on the far fixed point
        (-0.5, -0.9, -1.0, "settles", LocalAttractor("none")),  # on a cycle of period 2
        (0.5, 1.5, 1.0, "leaves", LocalAttractor("none")),
        (0.5, 0.4, -1.0, "returns", LocalAttractor("period-adding", base=1, offset=1)),
        (0.5, -0.4, -1.0, "returns", LocalAttractor("period-incrementing", base=1, offset=1)),
        (1.5, 0.4, 1.0, "settles", LocalAttractor("none")),  # an unstable orbit is lost
    ],
)
def test_outcomes_at_jumps_are_observed(a, b, jump, fate, after):
    f, border = _jump(a, b, jump)
    direction = 1 if a < 1 else -1  # so that the orbit is lost
    assert far_image(f, border, -1, 1).fate == fate
    predicted = predicted_at_jump(f, border, -1, direction)
    assert predicted.orbits == "lost at a jump"
    assert predicted.after == after
    maps = [f.replace(mu=1e-3 * direction * side) for side in (-1, 1)]
    orbits = [[o for o in periodic_orbits(g) if abs(o.points[0]) < 0.1] for g in maps]
    seen = observed(*orbits, *(attractors(g) for g in maps), width=2 * SIZE)
    assert disagreement(predicted, seen) == ""
    if fate == "settles":  # what attracts then was there before, and only looks on
        assert {x.period for x in attractors(maps[1])} == {far_image(f, border, -1, 1).cycle}
    back = predicted_at_jump(f, border, -1, -direction)
    assert (back.orbits, back.before, back.after) == (
        "born at a jump",
        predicted.after,
        predicted.before,
    )


@pytest.mark.parametrize("a", [1.5, -1.5])
def test_where_an_unstable_orbit_meets_a_jump_no_image_is_followed(a, monkeypatch):
    """Images that wander in chaos took nine tenths of the time of a list."""
    f, border = _jump(a, 0.4, -1.0)
    monkeypatch.setattr(PiecewiseMap, "iterate", None)
    predicted = predicted_at_jump(f, border, -1, 1, multiplier=a)
    assert predicted.attractors == "none"
    assert predicted.text.endswith("no attractor takes part")


def test_the_image_of_a_jump_is_followed_from_where_it_was_left(monkeypatch):
    steps = []

    def iterate(self, x, n):
        steps.append(n)
        return EvaluatedMap.iterate(self, x, n)

    # From 1 on a tent, whose chaos fills an interval that does not reach the border at 0.
    formulas = ["0.5*x", "0.3*x + 1.5", "1.9*x - 0.9", "6.7 - 1.9*x"]
    f = PiecewiseMap(formulas, (-1, 4), breakpoints=[0.0, 1.0, 2.0])
    border = next(b for b in breakpoints(f) if abs(b.d) < 1e-9)
    monkeypatch.setattr(PiecewiseMap, "iterate", iterate)
    monkeypatch.setattr(jump_return, "MAX_STEPS", 512)
    assert far_image(f, border, -1, 1).fate == "wanders"
    assert sum(steps) < 512


# ------------------------------------------------------------------ adding and incrementing


@settings(max_examples=15)
@given(a=st.floats(0.2, 0.85), b=way_back, n=st.integers(1, 6), share=st.floats(0.02, 0.98))
def test_maximal_cycles_attract_in_their_exact_windows(a, b, n, share):
    low, high = examples.maximal_window(a, b, n)
    assume(low < high < 2 and abs(a**n * b) < 0.98)
    f = examples.border_collision(a, b, low + share * (high - low), -1.0, size=SIZE)
    assert n + 1 in {x.period for x in attractors(f) if x.kind == "periodic"}


@settings(max_examples=15)
@given(a=st.floats(0.2, 0.85), b=way_back, n=st.integers(1, 6), side=st.sampled_from([0, 1]))
def test_maximal_cycles_are_born_and_lost_at_the_exact_borders(a, b, n, side):
    window = examples.maximal_window(a, b, n)
    assume(window[0] < window[1] and window[1] < 5)
    inward = (window[1] - window[0]) * (1e-6 if side == 0 else -1e-6)
    for shift, there in ((inward, True), (-inward, False)):
        f = examples.border_collision(a, b, window[side] + shift, -1.0, size=9.0)
        assert bool(_cycles(f, n)) == there


def _cycles(f, n):
    """Cycles of the word L^n R."""
    found = periodic_orbits(f, period=n + 1)
    return [o for o in found if (o.points < 0).sum() == n]


@given(a=near, b=way_back, n=st.integers(1, 8))
def test_neighbouring_windows_overlap_for_a_falling_way_back_only(a, b, n):
    here, there = examples.maximal_window(a, b, n), examples.maximal_window(a, b, n + 1)
    assert (there[1] > here[0]) == (b < 0)


@settings(max_examples=10)
@given(a=st.floats(0.3, 0.8), b=st.floats(-1.5, -0.2), n=st.integers(1, 5))
def test_in_the_overlap_two_cycles_attract(a, b, n):
    low, _ = examples.maximal_window(a, b, n)
    _, high = examples.maximal_window(a, b, n + 1)
    assume(abs(a**n * b) < 0.95)
    f = examples.border_collision(a, b, (low + high) / 2, -1.0, size=SIZE)
    assert {x.period for x in attractors(f)} == {n + 1, n + 2}


@pytest.mark.parametrize(("a", "b", "n"), [(0.5, 0.5, 1), (0.6, 0.4, 2), (0.4, 0.8, 3)])
def test_between_two_windows_cycles_add(a, b, n):
    # Between L^n R and L^(n+1) R lie all words made of both, the rarer ones in narrower
    # windows, in the order of their share of R (Farey).
    low, high = examples.maximal_window(a, b, n + 1)[1], examples.maximal_window(a, b, n)[0]
    mu = low + (high - low) * np.linspace(0.001, 0.999, 2000)
    x, right = np.zeros(mu.shape), np.zeros(mu.shape)
    steps = 3000
    for k in range(steps + 500):
        if k >= 500:
            right += x >= 0
        x = np.where(x < 0, a * x, b * x - 1) + mu
    share = right / steps
    assert (np.diff(share) > -2 / steps).all()
    shares = [(r, (n + 1) * r + m) for r, m in ((2, 1), (3, 1), (3, 2))]
    for r, period in shares:
        assert np.isclose(share, r / period, rtol=0, atol=1.5 / steps).any()
    f = examples.border_collision(a, b, mu[np.argmin(np.abs(share - 2 / (2 * n + 3)))], -1.0)
    assert [x.period for x in attractors(f)] == [2 * n + 3]


# ------------------------------------------------------------------ gaps, vocabulary, errors


def test_a_stable_orbit_is_lost_in_a_gap():
    f = PiecewiseMap(
        lambda x, mu: np.where(x <= 0, 0.5 * x + mu, np.nan), (-1, 1), parameters={"mu": 0.0}
    )
    maps = [f.replace(mu=mu) for mu in (-1e-3, 1e-3)]
    predicted = predicted_at_gap(0.5, -1, 1)
    seen = observed(
        *(periodic_orbits(g) for g in maps), *(attractors(g) for g in maps), gap=True, width=2.0
    )
    assert (predicted.orbits, seen.orbits) == ("lost in a gap", "lost in a gap")
    assert predicted.before == LocalAttractor("periodic", 1)
    assert disagreement(predicted, seen) == ""
    assert predicted_at_gap(0.5, -1, -1).orbits == "born at a gap"
    assert predicted_at_gap(1.5, -1, 1).orbits == "born at a gap"
    assert predicted_at_gap(0.5, 1, 1).orbits == "born at a gap"


@pytest.mark.parametrize(("left", "right"), [(1.5, -1.2), (-1.2, 1.5)])
def test_the_number_that_tells_chaos_from_escape_does_not_depend_on_the_side(left, right):
    # Nusse and Yorke (1992): (a - 1)(|b| - 1) of the rising and the falling slope
    assert "(|b| - 1)(a - 1) = 0.1, chaos" in predicted_at_corner(left, right, 1).text
    assert "chaos up to" not in predicted_at_corner(0.9, -1.2, 1).text


def test_a_disagreement_names_both():
    predicted = predicted_at_corner(0.5, -1.5, 1)
    other = predicted_at_corner(0.5, -0.5, 1)
    text = disagreement(predicted, other)
    assert "predicted 'period-doubled', observed 'persist'" in text
    assert "predicted a cycle of period 2, observed a cycle of period 1" in text
    assert disagreement(predicted, predicted) == ""
    assert disagreement(Outcome("undecided", "undecided"), other) == ""


def test_a_family_agrees_with_its_members_only():
    predicted = predicted_at_jump(*_jump(0.5, -0.4, -1.0), -1, 1)
    for period, fits in ((7, True), (0, True)):
        seen = Outcome("lost at a jump", "periodic", after=LocalAttractor("periodic", period))
        assert (disagreement(predicted, seen) == "") == fits
    family = Outcome(
        "lost at a jump",
        "period-incrementing",
        after=LocalAttractor("period-incrementing", 0, 4, 3),
    )
    for period, fits in ((83, True), (84, False)):
        seen = Outcome("lost at a jump", "periodic", after=LocalAttractor("periodic", period))
        assert (disagreement(family, seen) == "") == fits


def test_a_gap_is_no_corner():
    with pytest.raises(ValueError, match="NaN shows a gap"):
        predicted_at_corner(math.nan, 2, 1)


# ------------------------------------------------------------------ the paper's systems


def _breakpoint(model, kind, place):
    f = ss.event_map(model)
    beside = [b for b in ss.breakpoints(f) if b.kind == kind and abs(b.d - place) < 2e-3]
    assert len(beside) == 1
    return f, beside[0]


@pytest.mark.paper
def test_what_follows_the_coulomb_cycle_of_period_4():
    model = ss.examples.coulomb()
    f, jump = _breakpoint(model.replace(V=0.036975923520307), "jump", 0.2794)
    far = far_image(f, jump, -1, 4)
    # The slopes on both sides and the step promise that orbits are thrown away for good.
    assert far.multiplier == pytest.approx(0.7341838857, abs=1e-9)
    assert far.local_slope == pytest.approx(1.48312693, abs=1e-7)
    assert far.local_height == pytest.approx(0.0305388791, abs=1e-9)
    # But they come back.
    assert (far.fate, far.steps) == ("returns", 3)
    assert far.height == pytest.approx(0.0437725, rel=1e-5)
    assert far.slope == pytest.approx(-6.31088, rel=1e-5)
    predicted = predicted_at_jump(f, jump, -1, 1, period=4)
    assert predicted.orbits == "lost at a jump"
    assert predicted.attractors == "period-incrementing"
    assert predicted.text.endswith("alone: no attractor: orbits leave")
    for velocity, period in ((0.0370, 83), (0.0371, 63), (0.0372, 55)):
        g, moved = _breakpoint(model.replace(V=velocity), "jump", 0.2794)
        mu = float(g.iterate(moved.left, 3)[-1]) - moved.d
        assert periods(far, mu) == (period,)


@pytest.mark.paper
@pytest.mark.parametrize(
    ("velocity", "periods"),
    [
        (0.0369770, {123}),
        (0.0370000, {83}),
        (0.0370690, {63, 67}),  # where windows overlap
        (0.0371000, {63}),
        (0.0372120, {51, 55}),
        (0.0374300, {43, 47}),
        (0.0376000, {39, 43}),
    ],
)
def test_coulomb_cycles_of_period_4n_plus_3(velocity, periods):
    found = ss.attractors(ss.examples.coulomb(V=velocity))
    assert {x.kind for x in found} == {"periodic"}
    assert {x.period for x in found} == periods | {1}  # and S1


@pytest.mark.paper
@pytest.mark.parametrize(
    ("alpha", "place", "power", "slopes", "after"),
    [
        (1.209121691649, 0.3814, 2, (-3.769111, 1.329872), LocalAttractor("chaotic", 2)),
        (1.218624503830, 0.3804, 1, (7.601367, -1.964582), LocalAttractor("none")),
    ],
)
def test_the_slopes_tell_the_two_cusps_apart(alpha, place, power, slopes, after):
    f, cusp = _breakpoint(ss.examples.law9(alpha=alpha), "corner", place)
    rest = [float(f.derivative(cusp.left))] if power == 2 else [1.0]
    found = [s * rest[0] for s in (cusp.left_slope, cusp.right_slope)]
    assert found == pytest.approx(slopes, abs=1e-5)
    # Seen in the direction in which the orbits are born; mu has the sign of 1 - steeper slope.
    born = 1 if found[0] > 1 else -1
    outcome = predicted_at_corner(*found, born, period=power)
    assert outcome.orbits == "born in pairs"
    assert outcome.before == LocalAttractor("none")
    assert outcome.after == after


def test_a_long_way_back_to_a_strong_contraction_has_a_height():
    """The contraction of all turns of the way would be 1e-453, which is 0."""
    f = ss.PiecewiseMap(
        lambda x: np.select(
            [x < 0, x < 0.1, x < 1], [0.001 * x, 150.5 + x, -0.1 * x], default=x - 1
        ),
        (-3, 200),
        breakpoints=[0.0, 0.1, 1.0],
    )
    far = far_image(f, ss.breakpoints(f)[0], side=-1, period=1)
    assert far.fate == "returns"
    assert 1 <= far.steps < 152
    assert far.height * 0.001 ** (152 - far.steps) == pytest.approx(0.05)
    assert far.slope * 0.001 ** (152 - far.steps) == pytest.approx(-0.1, rel=1e-6)
