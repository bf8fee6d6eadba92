"""Enclosures of the event map: they hold what floating point and the oracle find, or say no."""

from fractions import Fraction

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from flint import arb
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.reference.coulomb import Coulomb

import stickslip as ss
from stickslip.proofs import flow
from stickslip.proofs.jet import Jet, precision, variables
from stickslip.proofs.power import Setting, step
from stickslip.proofs.system import exact_parameters, fraction
from stickslip.proofs.wave import Undecided
from stickslip.status import OK

BLOCKS = {"alpha": (0.1, 3), "beta": (0.5, 2), "V": (0.005, 0.3)}
MU = (0.05, 0.9)
LAW9 = {"gamma": (0.3, 4), "delta": (0, 0.5), "eta": (0, 0.1)}
TOLERANCE = {"coulomb": 1e-14, "popp-stelter": 1e-13}  # the design's, times kappa


def random_model(rng):
    blocks = {name: rng.uniform(*ends) for name, ends in BLOCKS.items()}
    return ss.TwoBlock(**blocks, friction=ss.Coulomb(mu=rng.uniform(*MU)))


def random_law9(rng):
    blocks = {name: rng.uniform(*ends) for name, ends in (BLOCKS | {"V": (0.02, 0.3)}).items()}
    law = {name: rng.uniform(*ends) for name, ends in LAW9.items()}
    return ss.TwoBlock(**blocks, friction=ss.PoppStelter(**law))


def binary(model):
    """The model's parameters as the binary numbers that the kernels compute with."""
    return {name: Fraction(value) for name, value in model.parameters.items()}


def disagreements(rng, systems, points, monkeypatch, draw=random_model):
    """Errors over tolerance, and how many points with a value stayed undecided."""
    grown = []
    after = flow._after

    def watched(*arguments):
        states = after(*arguments)
        jets = (x for s in states for x in (*s.w, *s.e) if isinstance(x, Jet))
        grown.extend(float(x.gradient[0].abs_upper()) for x in jets)
        return states

    monkeypatch.setattr(flow, "_after", watched)
    wrong, undecided = [], 0
    for _ in range(systems):
        model = draw(rng)
        tolerance = TOLERANCE[model.friction.name]
        setting = Setting(exact_parameters(model, binary(model)))
        d = rng.uniform(*model.domain, points)
        result = ss.event_map(model).evaluate(d)
        found = (result.value, result.derivative, result.status)
        for x, value, slope, status in zip(d, *found, strict=True):
            if status != OK and draw is random_law9:  # that none returns takes long to try
                continue
            for bits in (128, 512):  # thin balls widen over dozens of events
                grown.clear()
                with precision(bits):
                    try:
                        (piece,) = step(setting, variables([arb(float(x))], [arb(0)])[0])
                    except Undecided:
                        piece = None
                        break
                    if piece.value.range.rad() < 1e-18 and piece.value.gradient[0].rad() < 1e-12:
                        break
            if piece is None:
                undecided += int(status == OK)  # that none returns is never proven
                continue
            kappa = max([1.0, *grown])
            error = float(abs(piece.value.range - float(value)).upper())
            error_of_slope = float(abs(piece.value.gradient[0] - float(slope)).upper())
            if not error <= tolerance * kappa or not error_of_slope <= 1e-9 * kappa**2:
                wrong.append((model, x, value, error, kappa, error_of_slope))
    return wrong, undecided


def test_floating_point_lies_in_the_enclosures(monkeypatch):
    wrong, undecided = disagreements(np.random.default_rng(1), 20, 10, monkeypatch)
    assert wrong == []
    assert undecided <= 10


@pytest.mark.slow
def test_ten_thousand_random_points(monkeypatch):
    wrong, undecided = disagreements(np.random.default_rng(2), 1000, 10, monkeypatch)
    print(f"undecided: {undecided} of 10000")
    assert wrong == []
    assert undecided < 300


@pytest.mark.slow
def test_law_9_at_random_points(monkeypatch):
    wrong, undecided = disagreements(np.random.default_rng(4), 100, 1, monkeypatch, random_law9)
    print(f"undecided: {undecided} of 100")
    assert wrong == []
    assert undecided < 10


def compared(rng, model, middle, width):
    """Check an enclosure at points of its box; how much wider it is than values there.

    None if nothing is proven, as where motions do not return, or after very many events.
    """
    ends = [Fraction(middle + sign * width / 2) for sign in (-1, 1)]
    box = ss.enclose(model, tuple(ends), exact=binary(model))
    if not box.itineraries:
        return None
    oracle = Coulomb(**model.parameters)
    points = [*map(float, ends), *rng.uniform(*map(float, ends), 11)]
    motions = [oracle.motion(arb(x)) for x in points]
    assert all(each.value is not None for each in motions)
    assert {motion.itinerary for motion in motions} <= set(box.itineraries)
    lowest, highest = (pick((motion.value for motion in motions), key=float) for pick in (min, max))
    low, high = map(arb, box.value)
    assert low <= lowest
    assert highest <= high
    rounding = 2 * np.spacing(np.abs(box.value)).max()  # outward, to floats
    return float((high - low - rounding) / (highest - lowest))


def drawn(rng):
    """A random system, a point of its domain and a width."""
    model = random_model(rng)
    return model, rng.uniform(*model.domain) * 0.9, 10 ** rng.uniform(-9, -3)


@settings(max_examples=15)
@given(seed=st.integers(0, 10**6))
def test_an_enclosure_holds_every_point_of_its_box(seed):
    rng = np.random.default_rng(seed)
    ratio = compared(rng, *drawn(rng))
    assert ratio is None or ratio < 100


@pytest.mark.slow
def test_a_thousand_random_intervals():
    rng = np.random.default_rng(33)
    ratios = [compared(rng, *drawn(rng)) for _ in range(1000)]
    known = np.array([ratio for ratio in ratios if ratio is not None])
    print(f"nothing proven: {1000 - len(known)}; largest ratio {known.max():.3g}")
    assert len(known) > 850
    assert np.median(known) < 1.5
    assert known.max() < 100


def test_gradients_agree_with_the_kernels():
    model = ss.examples.coulomb()
    f = ss.event_map(model)
    names = ("alpha", "beta", "V", "mu")
    box = {name: (model.parameters[name],) * 2 for name in names}
    found = ss.enclose(model, "0.27", **box)
    assert found.derivative == pytest.approx((f.derivative(0.27),) * 2, rel=1e-11)
    for name, ends in found.parameter_derivatives.items():
        assert ends == pytest.approx((f.parameter_derivative(0.27, name),) * 2, rel=1e-10)


@pytest.mark.parametrize(
    ("ends", "reason"),
    [
        (("-0.1979", "-0.1980"), "lower end comes first"),
        (("0.6", "0.9"), "outside the domain"),
    ],
)
def test_bad_intervals_are_errors(ends, reason):
    with pytest.raises(ValueError, match=reason):
        ss.enclose(ss.examples.coulomb(), ends)


@pytest.mark.parametrize(
    ("name", "ends", "reason"),
    [
        ("alpha", ("-0.5", "0.1"), "alpha = -1/2 is out of range"),
        ("beta", ("-2", "-1.5"), "beta = -2 is out of range"),
        ("V", ("-1", "-0.5"), "V = -1 is out of range"),
        ("mu_1", ("0.9", "1.2"), "mu_1 = 6/5 is out of range"),
        ("mu", ("0", "0.1"), "mu = 0 cannot be certified"),
    ],
)
def test_nothing_is_enclosed_for_values_that_no_model_may_have(name, ends, reason):
    with pytest.raises(ValueError, match=reason):
        ss.enclose(ss.examples.coulomb(), "0.1", **{name: ends})


@pytest.mark.parametrize(
    ("ends", "reason"),
    [
        (("-0.198", "-0.1979"), "either order"),
        (("-0.1103", "-0.1102"), "block 1 may graze"),
        (("0.088", "0.089"), "both blocks reach their limits"),
        (("0.1707", "0.1708"), "block 1 comes to rest with its force"),
        (("0.2791", "0.2792"), "block 2 may graze"),
    ],
)
def test_an_interval_with_a_breakpoint_has_both_itineraries_and_the_reason(ends, reason):
    f = ss.event_map(ss.examples.coulomb())
    found = ss.enclose(ss.examples.coulomb(), ends)
    assert not found.proven
    assert reason in found.reason
    assert set(found.itineraries) == {str(f.itinerary(float(end))) for end in ends}
    at = np.linspace(*map(float, ends), 101)
    for bounds, values in ((found.value, f(at)), (found.derivative, f.derivative(at))):
        assert bounds[0] <= min(values) <= max(values) <= bounds[1]
        assert bounds[1] - bounds[0] < 50 * np.ptp(values)  # grazes included


def test_the_whole_domain_can_be_enclosed():
    model = ss.examples.coulomb()
    low, high = ss.enclose(model, model.domain).value
    values = ss.event_map(model)(np.linspace(*model.domain, 10001))
    assert low <= min(values) <= max(values) <= high
    assert high - low < 2 * np.ptp(values)


def test_numbers_are_read_exactly():
    assert fraction("x", 0.1) == Fraction(1, 10)
    assert fraction("x", "6/5") == Fraction(6, 5)
    assert type(fraction("x", np.int64(3)).numerator) is int
    for value in (float("nan"), "one", float("inf"), None):
        with pytest.raises(ValueError, match=r"x = .* exact number"):
            fraction("x", value)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"friction": (ss.Coulomb(mu=0.2), ss.PoppStelter(gamma=3.0))}, "cannot be certified"),
        ({"friction": ss.Coulomb(mu=0.2, viscous=0.1)}, "cannot be certified"),
        ({"damping": 0.1}, "damping"),
        ({"friction": ss.Coulomb(mu=0.0)}, "mu_1 = 0 .* exactly at the lower limit"),
        ({"friction": ss.Coulomb(mu=1.0)}, "mu_1 = 1 .* by a touch"),
    ],
)
def test_models_without_a_closed_form_are_errors(change, message):
    with pytest.raises(ValueError, match=message):
        ss.enclose(ss.examples.coulomb().replace(**change), 0.1)
    with pytest.raises(ValueError, match="gamma"):
        ss.enclose(ss.examples.coulomb(), 0.1, exact={"gamma": 1})
