"""One verb for following a solution along a parameter, whatever it is."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from stickslip.analysis.bifurcations.bifurcation import Bifurcation
from stickslip.analysis.bifurcations.curves.breakpoint_curves import follow_breakpoint
from stickslip.analysis.bifurcations.curves.curves import follow_bifurcation
from stickslip.analysis.bifurcations.in_space.curves_nd import follow_bifurcation_nd
from stickslip.analysis.branches.along.tracked import TrackedDiscontinuity
from stickslip.analysis.branches.breakpoints import Breakpoint
from stickslip.analysis.continuation.continuation import follow_on, follow_orbit
from stickslip.analysis.continuation.curve import Curve
from stickslip.analysis.continuation.orbit_follower import OrbitProblem
from stickslip.analysis.maps.arguments import line_family
from stickslip.analysis.maps.protocol import FamilyND
from stickslip.analysis.orbits.orbit import PeriodicOrbit
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND
from stickslip.analysis.work import Work
from stickslip.checks import shown
from stickslip.mechanics.cycle.along import follow_equilibrium
from stickslip.mechanics.cycle.continuation import follow_cycle
from stickslip.mechanics.cycle.cycle import Cycle
from stickslip.mechanics.cycle.equilibria import Equilibrium
from stickslip.numerics.waiting import waits
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from collections.abc import Callable

# What each option is for, and why the others have none.
MEANT_FOR: Final = {
    "solve_for": "bifurcations, which are followed in the plane of two parameters",
    "window": "orbits of maps of a line",
    "max_step": "orbits, whose steps have a length",
    "max_points": "orbits and cycles",
}


@waits
@suggests
def follow(
    thing: Any,
    parameter: str,
    range: tuple[float, float],
    *,
    solve_for: str | None = None,
    window: tuple[float, float] | None = None,
    max_step: float | None = None,
    max_points: int | None = None,
    progress: Callable[[float], None] | None = None,
    partial: bool = False,
) -> Curve:
    """Follow a solution along a parameter of its system, both ways, through folds.

    Parameters
    ----------
    thing : PeriodicOrbit, PeriodicOrbitND, Cycle, Equilibrium, Breakpoint, Bifurcation or Curve
        An orbit from `periodic_orbits`, a cycle from `find_cycle` or `limit_cycles`, steady
        sliding from `equilibria`, a breakpoint from `breakpoints`, a bifurcation from
        `bifurcations`; or the curve of an orbit of a map of a line, which goes on from its ends
        that are ends of its range. Each knows its system and the parameters that it has.
    parameter : str
        Parameter that is varied.
    range : pair of float
        Lowest and highest value, about the one that the system has.
    solve_for : str, optional
        For a bifurcation, and only for one: the other parameter, whose value at the bifurcation
        is solved for.
    window : pair of float, optional
        Part of the domain that an orbit of a map of a line may not leave; of a curve its own.
    max_step : float, optional
        Of an orbit: longest step, as a share of the range and of the domain; 1/32 by default.
    max_points : int, optional
        Of an orbit or a cycle: solutions computed to either side at most; 2000 by default.
    progress : callable, optional
        Called now and then with the share of the range that has been reached, 0 to 1.
    partial : bool
        Whether Ctrl-C returns the curve as far as it was followed; its ends then say
        ``interrupted``.

    Returns
    -------
    Curve
        ``ends`` tell why it ends, ``bifurcations`` what happens on the way;
        ``curve.at(V=0.037)`` solves anew.

    Raises
    ------
    ValueError
        Nothing that can be followed, or loaded without its system; an option that has no meaning
        for it; an unknown parameter; a range that does not contain the start; an infinitely
        unstable orbit, a cycle of a neutral family, a crossing of two curves of orbits; a system
        in which there is no such solution.

    Notes
    -----
    Orbits, cycles and bifurcations are followed by pseudo-arclength with exact derivatives, ends
    and bifurcations solved for as conditions of their own (docs/theory/continuation.md,
    docs/theory/cycles.md); breakpoints from value to value; steady sliding is solved in closed
    form at 401 values, and its Hopf points are located between these.

    Examples
    --------
    >>> import stickslip as ss
    >>> model = ss.examples.coulomb()
    >>> s4 = ss.periodic_orbits(model, period=4)[0]
    >>> curve = ss.follow(s4, "V", (0.0366, 0.0372))
    >>> curve.end_reasons, round(float(curve.values[-1]), 12)
    (('end of range', 'breakpoint'), 0.03697592352)
    """
    options = {
        "solve_for": solve_for,
        "window": window,
        "max_step": max_step,
        "max_points": max_points,
    }
    given = {name: value for name, value in options.items() if value is not None}
    work = Work(progress, partial)
    if isinstance(thing, Curve):
        if not isinstance(thing.problem, OrbitProblem):
            raise ValueError(
                f"a curve of kind {thing.kind!r} does not go on from its ends: follow a solution "
                f"on it in a wider range, such as curve[0] or curve.at({thing.parameter}=...)."
            )
        in_space = isinstance(_known_system(thing, "curve of orbits"), FamilyND)
        what, known = ("a curve in R^n", ORBIT[1:]) if in_space else ("a curve", ORBIT)
        return _call(follow_on, what, given, (thing, parameter, range), known, work)
    if isinstance(thing, PeriodicOrbit):
        f = line_family(_known_system(thing, "orbit"))
        return _call(follow_orbit, "an orbit", given, (thing, f, parameter, range), ORBIT, work)
    if isinstance(thing, PeriodicOrbitND):
        f_nd = _known_system(thing, "orbit")
        if not isinstance(f_nd, FamilyND):
            raise ValueError(f"system = {shown(f_nd)} has no parameters to vary.")
        what, begin = "an orbit in R^n", (thing, f_nd, parameter, range)
        return _call(follow_orbit, what, given, begin, ORBIT[1:], work)
    if isinstance(thing, Breakpoint | TrackedDiscontinuity):
        f = line_family(_known_system(thing, "breakpoint"))
        what, begun = "a breakpoint", (thing, f, parameter, range)
        return _call(follow_breakpoint, what, given, begun, (), work)
    if isinstance(thing, Bifurcation):
        f = _known_system(thing, "bifurcation")
        if solve_for is None:
            raise ValueError(
                f"solve_for: a bifurcation is followed along {parameter} in the plane of two "
                f"parameters; say which other one is solved for, such as {thing.parameter!r}."
            )
        in_space = isinstance(f, FamilyND)
        run = follow_bifurcation_nd if in_space else follow_bifurcation
        start = (thing, f if in_space else line_family(f), parameter, range)
        return _call(run, "a bifurcation", given, start, ("solve_for",), work)
    if isinstance(thing, Cycle):
        return _call(follow_cycle, "a cycle", given, (thing, parameter, range), ORBIT[2:], work)
    if isinstance(thing, Equilibrium):
        return _call(follow_equilibrium, "an equilibrium", given, (thing, parameter, range), ())
    raise ValueError(
        f"thing = {shown(thing)} cannot be followed. What can: an orbit, a cycle, an equilibrium, "
        "a breakpoint, a bifurcation, or a curve of orbits, such as ss.periodic_orbits(system)[0]."
    )


ORBIT: Final = ("window", "max_step", "max_points")


def _call(
    function: Callable[..., Curve],
    what: str,
    given: dict[str, Any],
    start: tuple[Any, ...],
    known: tuple[str, ...],
    work: Work | None = None,
) -> Curve:
    for name in given:
        if name not in known:
            raise ValueError(f"{name} is for {MEANT_FOR[name]}; {what} takes none.")
    return function(*start, **given) if work is None else function(*start, **given, work=work)


def _known_system(thing: Any, what: str) -> Any:
    system = getattr(thing, "system", None)
    if system is None:
        raise ValueError(
            f"the {what} was loaded without its system: load(path, system=...) gives it back."
        )
    return system
