"""Law (9) at one alpha between birth and crisis of its chaos: P1, its doubles A and B, the cusp."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.studies.galvanetto2001.orbits import cusp_of, in_window

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.analysis.orbits.orbit import PeriodicOrbit


@dataclass(frozen=True)
class Moment:
    """The map of the window at one alpha.

    ``twice`` are its orbits of period 2; ``a``, ``b`` those born at the cusp, None where they do
    not exist: b has a negative multiplier. ``images`` are f(c) .. f^4(c), c the cusp.
    """

    alpha: float
    cusp: float
    images: NDArray[np.float64]
    p1: PeriodicOrbit
    twice: tuple[PeriodicOrbit, ...]
    a: PeriodicOrbit | None
    b: PeriodicOrbit | None

    @property
    def bands(self) -> NDArray[np.float64]:
        """Widths of the two bands between images of the cusp, and the gap between them."""
        first, second, third, fourth = self.images
        return np.array([fourth - second, first - third, third - fourth])


def moment(alpha: float) -> Moment:
    """List the orbits of the window up to period 2 and follow the cusp.

    Parameters
    ----------
    alpha : float
        Below the crisis, so that P1 is the only fixed point right of the cusp.

    Returns
    -------
    Moment
    """
    f = in_window(alpha)
    cusp = cusp_of(f).d
    found = periodic_orbits(f, 2)
    (p1,) = (o for o in found.of_period(1) if o.points[0] > cusp)
    twice = found.of_period(2)
    # A and B have a point on either side of P1, all four between the cusp's first two images.
    images = f.iterate(cusp, 4)[1:]
    born = [o for o in twice if o.points[0] > images[1] and o.points[1] < images[0]]
    a, b = (next((o for o in born if (o.multiplier > 0) is up), None) for up in (True, False))
    return Moment(alpha, cusp, images, p1, twice, a, b)
