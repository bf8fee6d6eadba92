"""Beside a graze: both programs hold the oracle's values and slopes, and stay narrow there."""

import numpy as np
import pytest

pytest.importorskip("flint", reason="needs the extra 'certify'")

from flint import arb, ctx
from tests.proofs.test_enclosures import binary, random_model
from tests.reference.coulomb import Coulomb
from tests.sizes import sizes

import stickslip as ss
from stickslip.proofs import landing
from stickslip.proofs.jet import precision, variables
from stickslip.proofs.power import FORKS, Setting, step
from stickslip.proofs.system import exact_parameters
from stickslip.proofs.verify import motion
from stickslip.proofs.verify.motion import Motion
from stickslip.proofs.verify.words import Refused
from stickslip.proofs.wave import Undecided

NARROW = 0.03  # of the distance from the graze: what both programs decide
SHARES = (-1.0, -0.4, 0.0, 0.7, 1.0)  # of a box's radius: where the oracle looks


def grazes(rng):
    """Random systems with a jump at which a block grazes."""
    while True:
        model = random_model(rng)
        for jump in ss.breakpoints(model).of_kind("jump"):
            if "grazes" in jump.mechanism:
                yield model, jump.d


def certifier(model, middle, radius):
    """Value and derivative on a box."""
    with precision(200):
        box = variables([arb(middle)], [arb(radius)])
        (piece,) = step(Setting(exact_parameters(model, binary(model))), box[0])
    return piece.value.range, piece.value.gradient[0]


def verifier(model, middle, radius):
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = 200, 2
    try:
        values = {n: str(x) for n, x in exact_parameters(model, binary(model)).items()}
        _, value, slope = Motion(values).step(arb(middle) + arb(0, radius))
    finally:
        ctx.prec, ctx.cap = before
    return value, slope


def oracle_slope(oracle, x, h):
    """A difference quotient in the oracle's precision."""
    (a,), (b,) = ([arb(oracle.motion(arb(x) + sign * arb(h)).value)] for sign in (-1, 1))
    return (b - a) / (2 * arb(h))


@pytest.mark.parametrize("program", [certifier, verifier])
@pytest.mark.parametrize("systems", sizes(6, 40))
def test_enclosures_beside_a_graze_hold_the_oracle(program, systems):
    rng, found = np.random.default_rng(3), grazes(np.random.default_rng(3))
    decided = 0
    for _ in range(systems):
        model, d = next(found)
        oracle = Coulomb(**model.parameters)
        for side in (-1, 1):
            delta = 10 ** rng.uniform(-7, -4)
            middle, radius = d + side * delta, NARROW * delta
            try:
                value, slope = program(model, middle, radius)
            except (Undecided, Refused):
                continue
            decided += 1
            for share in SHARES:
                x = middle + share * radius
                assert value.overlaps(arb(oracle.motion(arb(x)).value))
                if abs(share) < 1:
                    assert slope.overlaps(oracle_slope(oracle, x, 1e-6 * radius))
    assert decided > systems // 3  # the rest has other events that are not told apart


@pytest.mark.parametrize(("program", "where"), [(certifier, landing), (verifier, motion)])
def test_slopes_beside_a_graze_are_known_to_a_hundredth(program, where, monkeypatch):
    # Without the turn the same boxes give them to hundreds.
    model, touching = ss.examples.coulomb(V=0.037), 0.2794509358746959 + 1e-6
    _, slope = program(model, touching, NARROW * 1e-6)
    assert float(slope) == pytest.approx(1.4819, abs=1e-3)
    assert float(slope.rad()) < 0.01
    monkeypatch.setattr(where, "SOON", -1.0)
    _, before = program(model, touching, NARROW * 1e-6)
    assert before.contains(slope.mid())
    assert float(before.rad()) > 100


def forked(program, model, middle, radius):
    """Itinerary, value and slope of every outcome of a box."""
    values = exact_parameters(model, binary(model))
    if program == "certifier":
        with precision(128):
            box = variables([arb(middle)], [arb(radius)])
            pieces = step(Setting(values), box[0], forks=FORKS)
            return [(p.itinerary, p.value.range, p.value.gradient[0]) for p in pieces]
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = 128, 2
    try:
        return list(
            Motion({n: str(x) for n, x in values.items()}).outcomes(arb(middle) + arb(0, radius))
        )
    finally:
        ctx.prec, ctx.cap = before


@pytest.mark.parametrize("program", ["certifier", "verifier"])
@pytest.mark.parametrize("systems", sizes(8, 300))
def test_values_and_slopes_across_breaks_of_every_kind(program, systems):
    seen, bounded, boxes = set(), 0, 0
    for seed in range(systems):
        rng = np.random.default_rng((3, seed))
        model = random_model(rng)
        f = ss.event_map(model)
        breaks = ss.breakpoints(model)
        for k in rng.permutation(len(breaks))[:2]:
            radius = 10 ** rng.uniform(-8, -4)
            try:
                found = forked(program, model, breaks[k].d, radius)
            except (Undecided, Refused):
                continue
            boxes += 1
            bounded += all(slope.is_finite() for *_, slope in found)
            seen.add(breaks[k].mechanism)
            x = breaks[k].d + radius * rng.uniform(-0.999, 0.999, 20)
            values = f.evaluate(x)
            for d, value, rate in zip(x, values.value, values.derivative, strict=True):
                ours = [(v, s) for word, v, s in found if word == f.itinerary(d)]
                assert any(
                    (v + arb(0, 1e-11)).contains(float(value))
                    and (s + arb(0, 1e-6 * max(1, abs(rate)))).contains(float(rate))
                    for v, s in ours
                )
    assert any("grazes" in mechanism for mechanism in seen)
    assert len(seen) > 3
    assert bounded > 0.8 * boxes > 0.8 * systems
