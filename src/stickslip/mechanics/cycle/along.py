"""Steady sliding along a parameter: its eigenvalues, and the Hopf points where cycles are born."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np

from stickslip.analysis.continuation.curve import Curve, CurveEnd, CurveEvent, Problem
from stickslip.analysis.continuation.follower import contained
from stickslip.checks import checked_interval
from stickslip.mechanics.cycle.equilibria import Equilibrium, equilibria
from stickslip.mechanics.cycle.hopf import NEUTRAL, crossings
from stickslip.mechanics.cycle.sliding import Model, modes, steady_displacements
from stickslip.mechanics.model.arguments import checked_parameter
from stickslip.results.parts import part

if TYPE_CHECKING:
    from numpy.typing import NDArray

N_VALUES: Final = 401  # over the range; two crossings between neighbours may be missed
BESIDE: Final = 1e-6  # of the range: where stability is looked at beside a Hopf point
ROUNDING: Final = 4e-16  # of a value


@part
@dataclass(frozen=True, eq=False)
class EquilibriumProblem(Problem):
    """Steady sliding of a model, in closed form."""

    system: Model
    picture: ClassVar = "cycles.draw_equilibrium_curve"

    def solve(self, curve: Curve, row: int, share: float, name: str, value: float) -> Equilibrium:
        """Solve for steady sliding at a value."""
        return equilibria(self.system.replace(**{name: value}))[0]

    def row(self, curve: Curve, row: int) -> Equilibrium:
        """Solve for the steady sliding of a row."""
        return self.solve(curve, row, 0.0, curve.parameter, float(curve.values[row]))


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

    def at(value: float) -> Model:
        return model.replace(**{parameter: value})

    def eigenvalues(value: float) -> NDArray[np.complex128]:
        here = at(value)
        return modes(here, here.V).values

    values = np.union1d(np.linspace(low, high, N_VALUES), own)
    points = np.array([steady_displacements(m, m.V) for m in map(at, values.tolist())])
    spectra = np.array([eigenvalues(value) for value in values.tolist()])
    events = []
    for value in crossings(eigenvalues, values):
        here, spectrum = at(value), eigenvalues(value)
        growing = spectrum[spectrum.imag > 0]
        critical = growing[[np.argmin(np.abs(growing.real))]]
        beside = [eigenvalues(value + sign * BESIDE * (high - low)) for sign in (-1, 1)]
        below, above = (each.real.max() for each in beside)
        what = "another mode" if below * above > 0 else "calms" if below > 0 else "starts to grow"
        events.append(
            CurveEvent(
                "hopf",
                {parameter: value},
                steady_displacements(here, here.V),
                critical,
                ROUNDING * abs(value),
                int(np.searchsorted(values, value, side="right")) - 1,
                f"frequency {critical[0].imag:.10g}, {what} as {parameter} grows",
            )
        )
    return Curve(
        kind="equilibrium",
        parameters={parameter: values},
        points=points,
        multipliers=spectra,
        stable=spectra.real.max(axis=1) < -NEUTRAL * np.abs(spectra).max(axis=1),
        ends=(
            CurveEnd("end of range", {parameter: low}, points[0], spectra[0]),
            CurveEnd("end of range", {parameter: high}, points[-1], spectra[-1]),
        ),
        bifurcations=tuple(events),
        data={},
        problem=EquilibriumProblem(model),
    )
