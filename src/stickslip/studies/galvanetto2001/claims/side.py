"""The Coulomb system at one driving velocity near the collision of S4 with U4."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np

from stickslip import examples
from stickslip.analysis.attractors.basins import Basins, basins
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.studies.galvanetto2001.orbits import from_point_1, jump_of_s4

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.attractors.attractor import Attractor

COLLISION: Final = "V where S4 meets the jump"
BESIDE: Final = 1e-8  # of V: just below and just above the collision


@dataclass(frozen=True)
class Side:
    """The map at one driving velocity near the collision.

    ``gap`` is f^4(c-) - c at the jump c; ``slopes`` those of f^4 left and right of it. ``s4`` and
    ``u4`` start with the point at the jump and are empty where the orbit does not exist;
    ``multiplier`` is that of S4 (NaN without it), ``fixed_points`` the number of fixed points.
    """

    V: float
    jump: float
    gap: float
    slopes: tuple[float, float]
    s4: NDArray[np.float64]
    u4: NDArray[np.float64]
    multiplier: float
    basins: Basins

    @property
    def basin_of_s1(self) -> NDArray[np.float64]:
        """Ends of the intervals of the basin of S1, shape (n, 2)."""
        found = self.basins
        ends = np.stack([found.edges[:-1], found.edges[1:]], axis=1)
        owned = [k >= 0 and found.attractors[k].period == 1 for k in found.index]
        return np.asarray(ends[owned])

    @property
    def others(self) -> tuple[Attractor, ...]:
        """The attractors besides S1."""
        return tuple(item for item in self.basins.attractors if item.period != 1)


@lru_cache(maxsize=8)  # the claims about the collision and about what follows share two
def side(V: float) -> Side:
    """List orbits around the jump that S4 meets, and find the basins.

    Parameters
    ----------
    V : float
        In the range of figure 4.

    Returns
    -------
    Side
    """
    f = event_map(examples.coulomb(V=V))
    jump = jump_of_s4(f)
    f4 = f.power(4)
    left, right = jump.interval
    inside = 1e-9  # at the last float the slope may be the other branch's
    slopes = f4.evaluate([left - inside, right + inside]).derivative
    found = periodic_orbits(f, period=4, infinitely_unstable=True)
    stable = [orbit for orbit in found if orbit.stable]
    crossing = [o for o in found if o.jump is not None and o.jump.d == jump.d]
    return Side(
        V,
        jump.d,
        float(f4(left)) - left,
        (float(slopes[0]), float(slopes[1])),
        from_point_1(stable[0], jump.d) if stable else np.empty(0),
        from_point_1(crossing[0], jump.d) if crossing else np.empty(0),
        stable[0].multiplier if stable else float("nan"),
        basins(f),
    )
