"""Steady sliding along a parameter: its eigenvalues, and the Hopf points where cycles are born."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem
from stickslip.analysis.continuation.follower import contained
from stickslip.checks import checked_interval
from stickslip.mechanics.cycle.equilibria import Equilibrium, equilibrium_at
from stickslip.mechanics.cycle.hopf import FollowedModes, effect
from stickslip.mechanics.cycle.sliding import Model, steady_states
from stickslip.mechanics.model.arguments import checked_parameter
from stickslip.results.parts import part

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Complexes, Floats

N_VALUES: Final = 401  # over the range; two crossings between neighbours may be missed
BESIDE: Final = 1e-6  # of the range: where stability is looked at beside a Hopf point
ROUNDING: Final = 4e-16  # of a value
EFFECTS: Final = {-1: "calms", 0: "another mode", 1: "starts to grow"}


@part
@dataclass(frozen=True, eq=False)
class EquilibriumProblem(Problem):
    """Steady sliding of a model, in closed form."""

    system: Model
    picture: ClassVar = "cycles.draw_equilibrium_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Equilibrium:
        """Solve for steady sliding at a value."""
        model, x = self.system.replace(**{name: value}), curve.points[row]
        nearest = min(steady_states(model), key=lambda each: float(np.abs(each.x - x).max()))
        return equilibrium_at(model, nearest)


def follow_equilibrium(
    equilibrium: Equilibrium, parameter: str, range: tuple[float, float]
) -> Curve:
    """Follow steady sliding along a parameter of its model; see `stickslip.follow`."""
    model = equilibrium.model
    checked_parameter("parameter", model, parameter)
    low, high = checked_interval("range", range)
    own = contained(low, high, parameter, model.parameters[parameter], "equilibrium")
    for end in (low, high):
        model.replace(**{parameter: end})
    values = np.union1d(np.linspace(low, high, N_VALUES), own)
    solved = _followed(model, parameter, values, equilibrium.w)
    speeds = np.array([solved[value].w for value in values.tolist()])

    def at(value: float) -> Equilibrium:
        if value not in solved:
            w = [np.interp(value, values, column) for column in speeds.T]
            beside = float(values[np.argmin(np.abs(values - value))])
            solved[value] = _sliding(model, parameter, value, np.array(w), beside)
        return solved[value]

    def eigenvalues(value: float) -> Complexes:
        return at(value).eigenvalues

    points = np.array([at(value).x for value in values.tolist()])
    spectra = np.array([eigenvalues(value) for value in values.tolist()])
    # The product of all modes changes its sign where the balance of forces is singular.
    turned = np.cos(np.angle(spectra).sum(axis=1)) < 0.0
    (ends,) = (turned[:-1] != turned[1:]).nonzero()
    if ends.size:
        raise _ended(parameter, *values[ends[0] : ends[0] + 2])
    events = []
    followed = FollowedModes(eigenvalues, values)
    found = [("hopf", *each) for each in followed.crossings()]
    found += [("flutter", *each) for each in followed.coalescences()]
    for kind, value, mode in sorted(found, key=lambda each: each[1]):
        step = BESIDE * (high - low)
        what = EFFECTS[effect(eigenvalues(value - step), eigenvalues(value + step))]
        events.append(
            CurveEvent(
                kind,
                {parameter: value},
                at(value).x,
                np.array([mode]),
                ROUNDING * abs(value),
                int(np.searchsorted(values, value, side="right")) - 1,
                f"frequency {mode.imag:.10g}, {what} as {parameter} grows",
            )
        )
    return Curve(
        kind="equilibrium",
        parameters={parameter: values},
        points=points,
        multipliers=spectra,
        stable=spectra.real.max(axis=1) < 0.0,
        ends=(
            CurveEnd("end of range", {parameter: low}, points[0], spectra[0]),
            CurveEnd("end of range", {parameter: high}, points[-1], spectra[-1]),
        ),
        bifurcations=tuple(events),
        data={},
        problem=EquilibriumProblem(model),
    )


def _sliding(model: Model, parameter: str, value: float, w: Floats, beside: float) -> Equilibrium:
    """Steady sliding at a value, with velocities of slip nearest to those beside it."""
    there = model.replace(**{parameter: value})
    states = steady_states(there, near=w)
    if not states:
        raise _ended(parameter, value, beside)
    return equilibrium_at(there, min(states, key=lambda each: float(np.abs(each.w - w).max())))


def _ended(parameter: str, *values: float) -> ValueError:
    low, high = sorted(values)
    return ValueError(
        "the steady sliding ends within the range: no forces balance between "
        f"{parameter} = {low:.15g} and {high:.15g}, or a contact opens there."
    )


def _followed(model: Model, parameter: str, values: Floats, w: Floats) -> dict[float, Equilibrium]:
    """Steady sliding at ascending values, followed from the model's own."""
    solved: dict[float, Equilibrium] = {}
    own = int(np.searchsorted(values, model.parameters[parameter]))
    for way in (values[own:], values[own::-1]):
        here, beside = w, float(values[own])
        for value in way.tolist():
            solved[value] = _sliding(model, parameter, value, here, beside)
            here, beside = solved[value].w, value
    return solved
