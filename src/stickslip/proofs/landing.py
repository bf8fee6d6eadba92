"""A block that lands soon before it would have turned back: the state at the time of the turn.

There the state has bounded second derivatives but for a term of order 3/2, while at the landing
itself they grow without bound as the block comes to a graze. Docs: proofs, beside a graze.
"""

from __future__ import annotations

from typing import Final

from flint import arb

from stickslip.proofs.events import Signal
from stickslip.proofs.jet import Jet, Number, hull, spread
from stickslip.proofs.system import Modes, Pair, Phase, System
from stickslip.proofs.taylor import TaylorStep
from stickslip.proofs.wave import Undecided, root

SOON: Final = 0.1  # between landing and turn, in units of sqrt(m / k)


def at_turn(
    system: System, phase: Phase | TaylorStep, i: int, time: Number, modes: Modes, w: Pair, e: Pair
) -> tuple[Pair, Pair]:
    """Return velocities and forces at the turn of block i, which has landed and rides on.

    Where there is no turn soon, or it is not proven that nothing happens before it, those at the
    landing, which are given. A block may also have just touched, or missed: then the time of its
    landing is vague, and the state at the turn without it is among those returned.
    """
    if isinstance(phase, TaylorStep) or not isinstance(time, Jet):
        return w, e
    speed = phase.w[i] * arb(phase.modes[i])
    slope = speed.derivative()
    rate, bend = spread(slope(time)), spread(slope.derivative()(time))
    if not bend > 0 or not -rate < SOON * bend:
        return w, e
    start = time.range.lower()
    window = hull(start, start + 2 * (-rate / bend).upper() + 4 * time.range.rad())
    if not (spread(slope(window.lower())) < 0 < spread(slope(window.upper()))):
        return w, e
    try:
        turn = root(slope, window)
    except Undecided:
        return w, e
    rest = turn - time
    later = _riding(system, modes, w, e, rest)
    if later is None:
        return w, e
    slip = _values(phase, turn)
    gaps = _gaps(system, phase, i, turn, rest)
    slip[i] = arb(0)  # it rides
    found = [_sharper(*three) for three in zip(later, slip, gaps, strict=True)]
    return (found[0], found[1]), (found[2], found[3])


def _riding(system: System, modes: Modes, w: Pair, e: Pair, rest: Jet) -> list[Number] | None:
    """Follow the motion with the new modes for a time; None if something may happen in it."""
    if modes == (0, 0):
        return [*w, *(force + system.V * rest for force in e)]
    after = system.phase(modes, w, e)
    assert isinstance(after, Phase)
    for each in after.signals:
        signal = Signal(*each)
        signal.reach(signal.wave.basis(arb(0)), float("inf"))
        if not signal.stays(rest.range.upper()):
            return None
    return _values(after, rest)


def _values(phase: Phase, t: Number) -> list[Number]:
    basis = phase.e[0].basis(t)
    return [wave.at(basis) for wave in (*phase.w, *phase.e)]


def _gaps(system: System, phase: Phase, i: int, turn: Jet, rest: Jet) -> list[Number]:
    """Return what the gradients of the motion with the landing have over those without it."""
    # As functions: integrals over r from 0 to `rest` of a kernel times the velocity at turn - r,
    # which vanishes at the landing, so that the gradient of `rest` does not count.
    r = hull(arb(0), rest.range.upper())
    alpha, none = system.alpha, arb(0)
    speed = phase.w[i].at(phase.w[i].basis(turn - r))
    kernels: list[Number] = [none, none, -(1 + alpha), alpha]
    if phase.modes[1 - i]:
        omega = (1 + alpha).sqrt()
        angle = omega * r
        sine, cosine = angle.sin_cos()
        kernels = [none, -alpha * sine / omega, none, alpha * cosine]
        kernels[2] = -(1 + alpha) + alpha * alpha * (1 - cosine) / (1 + alpha)
    if i:
        kernels = [kernels[k] for k in (1, 0, 3, 2)]
    length = rest.range.nonnegative_part()
    return [kernel * speed * length for kernel in kernels]


def _sharper(later: Number, slip: Number, gap: Number) -> Number:
    """Intersect a quantity with what it is without the landing and the gap."""
    if not (isinstance(later, Jet) and isinstance(slip, Jet)):
        return later
    other = slip + gap
    gradient = (
        a.intersection(b) if a.is_finite() else b
        for a, b in zip(later.gradient, other.gradient, strict=True)
    )
    centre, range = (
        a.intersection(b) for a, b in ((later.centre, other.centre), (later.range, other.range))
    )
    return Jet(centre, range, tuple(gradient), later.box).tight()
