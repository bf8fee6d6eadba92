"""One step of the event map on a box: d -> f(d), with every possible itinerary.

Docs: proofs, events and their order.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from flint import arb

from stickslip.proofs.events import Decision, possible_events
from stickslip.proofs.jet import Jet, Number, spread, tight
from stickslip.proofs.landing import at_turn
from stickslip.proofs.system import Modes, Pair, System
from stickslip.proofs.wave import Undecided

MOST_PHASES: Final = 1000  # of constant modes, or Taylor steps
GLYPHS: Final = {-1: "-", 0: ".", 1: "+"}


@dataclass(frozen=True)
class Piece:
    """What f does for those parameters of a box whose motion has this itinerary."""

    itinerary: str
    value: Any  # the next d; outside these parameters, the smooth continuation from them
    decisions: tuple[Decision, ...]  # empty if the whole box is proven to have this itinerary

    @property
    def margin(self) -> Jet:
        """Of the one question that stays open."""
        (decision,) = self.decisions
        assert isinstance(decision.margin, Jet)
        return decision.margin


@dataclass(frozen=True)
class _State:
    modes: Modes
    w: Pair
    e: Pair
    released: int | None  # the block whose force has just reached its limit
    phases: int = 0  # so far
    words: tuple[Modes, ...] = ()
    decisions: tuple[Decision, ...] = ()

    def decided(self, decision: Decision) -> _State:
        return replace(self, decisions=(*self.decisions, decision))


def images(system: System, d: Number, *, forks: int = 8, at_touch: bool = False) -> list[Piece]:
    """Return f on a box: one piece for each itinerary that cannot be excluded.

    At most so many questions as `forks` stay open, else `Undecided`; `at_touch` as in
    `possible_events`.
    """
    waiting = _onsets(system, d)
    if len(waiting) > 1 and forks == 0:
        raise Undecided("both blocks reach their limits together at the onset")
    done: list[Piece] = []
    while waiting:
        state = waiting.pop()
        if state.modes == (0, 0):
            words = " ".join(GLYPHS[a] + GLYPHS[b] for a, b in (*state.words, (0, 0)))
            value = tight(system.distance(state.e))
            done.append(Piece(words, value, state.decisions))
            continue
        if state.phases > MOST_PHASES:
            raise Undecided(f"no global stick within {MOST_PHASES} phases")
        after = _after(system, state, at_touch)
        if len(after) > 1 and len(done) + len(waiting) + len(after) > forks + 1:
            raise Undecided(next(s.decisions[-1].question for s in after if s.decisions))
        waiting += after
    return done


def _onsets(system: System, d: Number) -> list[_State]:
    """Start at the end of global stick (eq. 6a): the first upper limit that is reached."""
    one, beta = system.limits
    gap = (2 * system.alpha + 1) * d  # e_2 - e_1
    none = arb(0)
    margin = tight(beta - one - gap)  # positive: block 1 first
    first = _State((-1, 0), (none, none), (one, tight(one + gap)), 0)
    second = _State((0, -1), (none, none), (tight(beta - gap), beta), 1)
    if spread(margin) > 0:
        return [first]
    if spread(margin) < 0:
        return [second]
    return [
        first.decided(Decision("onset", (1, 2), margin, 1, "block 1 is released first")),
        second.decided(Decision("onset", (1, 2), margin, -1, "block 2 is released first")),
    ]


def _after(system: System, state: _State, at_touch: bool) -> list[_State]:
    """Follow a phase to its end: the states that may come next."""
    phase = system.phase(state.modes, state.w, state.e, state.released)
    words = state.words if state.words[-1:] == (state.modes,) else (*state.words, state.modes)
    found = []
    for event in possible_events(phase, at_touch=at_touch):
        basis = phase.w[0].basis(event.time)
        waves: tuple[Any, ...] = phase.w
        w = [wave.at(basis) if m else arb(0) for wave, m in zip(waves, state.modes, strict=True)]
        e: list[Number] = [wave.at(basis) for wave in phase.e]
        i, released = event.block, None
        choices: list[tuple[int, tuple[Decision, ...]]] = [(0, ())]
        if i is not None:
            w[i] = arb(0)
            if event.end:
                e[i] = system.limits[i] * arb(event.end)
                choices, released = [(-event.end, ())], i
            else:
                choices = _landing(system, i, e[i])
        for mode, asked in choices:
            first, second = (mode if k == i else before for k, before in enumerate(state.modes))
            speeds, forces = (w[0], w[1]), (e[0], e[1])
            tied = any(decision.kind == "tie" for decision in event.decisions)
            if i is not None and not (event.end or mode or tied or asked):
                speeds, forces = at_turn(
                    system, phase, i, event.time, (first, second), speeds, forces
                )
            found.append(
                _State(
                    (first, second),
                    speeds,
                    forces,
                    released,
                    state.phases + 1,
                    words,
                    state.decisions + event.decisions + asked,
                )
            )
    return found


def _landing(system: System, i: int, force: Number) -> list[tuple[int, tuple[Decision, ...]]]:
    """Return the modes that a block may take when its velocity reaches the belt's (rule 2)."""
    above = tight(system.limits[i] - force)
    below = tight(system.limits[i] + force)
    choices: list[tuple[int, tuple[Decision, ...]]] = []
    for mode, margin in ((-1, above), (1, below)):
        if spread(margin) < 0:
            return [(mode, ())]
        if not spread(margin) > 0:
            choices += [
                (0, (Decision("rest", (i + 1,), margin, 1, "sticks"),)),
                (mode, (Decision("rest", (i + 1,), margin, -1, "slips on"),)),
            ]
    if len(choices) > 2:
        raise Undecided(f"the force at the landing of block {i + 1} is not enclosed")
    return choices or [(0, ())]
