"""All limit cycles that a search from many states finds, the event map's orbits among them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.analysis.work import Work
from stickslip.checks import MOST_KEPT, random_generator, whole_number
from stickslip.errors import NoCycleError
from stickslip.mechanics.cycle.cycle import Cycle, multiplier_text, same_cycle
from stickslip.mechanics.cycle.equilibria import equilibria
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.model.arguments import checked_model
from stickslip.mechanics.model.two_block import TwoBlock
from stickslip.numerics.processes import in_processes
from stickslip.numerics.unseen import unseen_share
from stickslip.numerics.waiting import waits
from stickslip.results.result import ResultList
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.mechanics.cycle.neutral import NeutralFamily
    from stickslip.mechanics.cycle.sliding import Model
    from stickslip.numerics.arrays import Floats

SHOWN: Final = 12


@dataclass(frozen=True, eq=False, repr=False)
class CycleList(ResultList[Cycle]):
    """Distinct limit cycles of a model, those that most starts led to first.

    Attributes
    ----------
    cycles : tuple of Cycle
    hits : ndarray of int
        Starts that led to each; 0 for one known from the event map alone.
    n_starts : int
    n_sliding : int
        Starts from which all blocks slip for ever: onto steady sliding, or in its neutral family.
    n_undecided : int
        Starts from which no cycle was found: chaotic motions, or too few events.
    unseen : float
        Estimated share of the starts that lead to cycles not found (Good–Turing): an estimate,
        and of cycles that attract from the states sampled alone.
    neutral_family : NeutralFamily or None
        All-slipping motions that are no cycles, where the model has such.
    """

    cycles: tuple[Cycle, ...]
    hits: NDArray[np.int64]
    n_starts: int
    n_sliding: int
    n_undecided: int
    neutral_family: NeutralFamily | None = field(default=None)
    _number: ClassVar = "cycle"
    _column_names: ClassVar = Cycle._column_names
    _plot: ClassVar = "cycles.plot_cycles"
    _of: ClassVar = "cycles"

    @property
    def unseen(self) -> float:
        """Estimated share of the starts that lead to cycles not found."""
        return unseen_share(self.hits.tolist())

    def _columns(self) -> Mapping[str, Any]:
        return {**super()._columns(), "hits": self.hits}

    def __repr__(self) -> str:
        """Return one line a cycle, then what else the starts led to."""
        lines = [f"CycleList: {len(self)} cycles from {self.n_starts} starts"]
        for cycle, hits in zip(self.cycles[:SHOWN], self.hits, strict=False):
            multiplier = multiplier_text(cycle.largest_multiplier)
            lines.append(
                f"  period {cycle.period:14.10g}  multiplier {multiplier:<13} "
                f"{len(cycle.events)} events, {len(cycle.d)} global sticks, {hits} hits"
            )
        if len(self) > SHOWN:
            lines.append(f"  ... {len(self) - SHOWN} more")
        lines.append(f"  {self.n_sliding} starts slide for ever, {self.n_undecided} undecided")
        lines.append(f"  estimated share of starts to cycles not found: {self.unseen:.2g}")
        return "\n".join(lines)


@waits
@suggests
def limit_cycles(
    model: Model,
    *,
    n_starts: int = 50,
    max_period: int = 1,
    max_events: int = 5000,
    rtol: float = 1e-15,
    rng: np.random.Generator | int | None = None,
    progress: Callable[[float], None] | None = None,
) -> CycleList:
    """Search the limit cycles of a model from many states.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    n_starts : int
        States drawn (``model.sample_state``), half of them with all blocks on the belt.
    max_period : int
        Of two undamped blocks the event map's orbits up to this period, unstable ones too, are
        looked up as well.
    max_events : int
        Changes of mode (of a forced model: periods of the forcing) that a motion is followed for.
    rtol : float
        Local truncation error of the flow.
    rng : numpy.random.Generator or int, optional
    progress : callable, optional
        Called with the share of the starts that is done, from 0 to 1.

    Returns
    -------
    CycleList
        Each cycle once, up to a shift of time.

    Raises
    ------
    ValueError
        A count that is not allowed.

    Notes
    -----
    The search finds the cycles that attract from the sampled states, and those that repel where a
    motion passes close by; `CycleList.unseen` estimates what it misses. It proves nothing.

    Examples
    --------
    >>> import stickslip as ss
    >>> block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
    >>> found = ss.limit_cycles(block, n_starts=6, rng=1)
    >>> len(found), found[0].stable
    (1, True)
    """
    checked_model(model)
    max_period = whole_number("max_period", max_period, at_most=MOST_KEPT)
    count = whole_number("n_starts", n_starts, at_most=MOST_KEPT, what="states that are followed")
    generator = random_generator("rng", rng)
    cycles: list[Cycle] = []
    hits: list[int] = []
    missed: Counter[str] = Counter()

    def note(cycle: Cycle, found: int) -> None:
        for k, known in enumerate(cycles):
            if same_cycle(cycle, known):
                hits[k] += found
                return
        cycles.append(cycle)
        hits.append(found)

    starts = [model.sample_state(generator, riding=k % 2 == 0) for k in range(count)]
    search = partial(_cycle_from, model, max_events, rtol)
    for found in in_processes(search, starts, Work(progress).tell):
        if isinstance(found, Cycle):
            note(found, 1)
        else:
            missed[found] += 1
    for cycle in _of_the_event_map(model, max_period):
        note(cycle, 0)
    sliding = () if model.plant.is_forced else equilibria(model)
    order = sorted(range(len(cycles)), key=lambda k: (-hits[k], cycles[k].period))
    return CycleList(
        cycles=tuple(cycles[k] for k in order),
        hits=np.array([hits[k] for k in order], dtype=np.int64),
        n_starts=count,
        n_sliding=missed["slides"],
        n_undecided=missed["undecided"],
        neutral_family=next((each.neutral_family for each in sliding), None),
    )


def _cycle_from(
    model: Model, max_events: int, rtol: float, start: tuple[Floats, Floats]
) -> Cycle | str:
    """Search a cycle from a state; the kind of failure if there is none."""
    try:
        return find_cycle(model, *start, max_events=max_events, rtol=rtol)
    except NoCycleError as reason:
        return reason.kind


def _of_the_event_map(model: Model, max_period: int) -> Iterator[Cycle]:
    """Cycles that the orbits of the event map of two undamped blocks are."""
    if not isinstance(model, TwoBlock) or model.damping != 0.0:
        return
    for orbit in periodic_orbits(model, max_period):
        start = model.onset(float(orbit.points[0]))
        try:
            yield find_cycle(model, start, np.full(2, model.V), max_events=200 * orbit.period)
        except NoCycleError:
            continue  # so unstable that rounding leads away: `periodic_orbits` still tells it
