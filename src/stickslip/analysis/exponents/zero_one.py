"""The 0-1 test for chaos in a series of values."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

import numpy as np
from scipy import signal

from stickslip.checks import MOST_KEPT, random_generator, real_numbers, shown, whole_number
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from stickslip.analysis.maps.protocol import Floats

LAGS: Final = 10  # displacements over a tenth of the series ...
SHORTEST: Final = LAGS**2  # ... and as many of them at least


@dataclass(frozen=True, eq=False, repr=False)
class ZeroOneTest(Result):
    """Whether a series is regular (0) or chaotic (1).

    Attributes
    ----------
    value : float
        Median of `growth`: near 0 for regular motion, near 1 for chaos.
    error : float
        Its standard error over the frequencies; what a longer series would change is not in it.
    frequencies, growth : ndarray of float
        Each frequency, and how nearly linearly displacements driven by the series grow there.
    n : int
        Length of the series.
    """

    value: float
    error: float
    frequencies: Floats
    growth: Floats
    n: int
    _column_names: ClassVar = ("frequencies", "growth")
    _drawn: ClassVar = ("frequencies", "growth")

    @property
    def chaotic(self) -> bool:
        """Whether the value is nearer to 1 than to 0."""
        return self.value > 0.5

    def __repr__(self) -> str:
        """One line."""
        return f"ZeroOneTest({self.value:.4f} ± {self.error:.1g}, n={self.n})"


@waits
@suggests
def zero_one_test(
    series: ArrayLike, *, n_frequencies: int = 100, rng: np.random.Generator | int | None = None
) -> ZeroOneTest:
    """Test a series of values along an orbit for chaos.

    Parameters
    ----------
    series : array_like of float, shape (n,)
        Values of one observable, such as ``f.iterate(x0, 5000)[:, 0]``; at least 100. Of a motion
        in time far apart: values that hardly change look regular.
    n_frequencies : int
        Frequencies at which the series drives a point of the plane, between pi/5 and 4 pi/5.
    rng : Generator or int, optional
        For the frequencies; by default fixed ones.

    Returns
    -------
    ZeroOneTest

    Raises
    ------
    ValueError
        A series that is too short or not of numbers; a count below 1.

    Notes
    -----
    Gottwald and Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129-145: correlation with time of
    the mean square displacement of what deviates from the mean. It needs no equations and
    proves nothing: weak chaos needs long series.

    Examples
    --------
    >>> import stickslip as ss
    >>> f = ss.PiecewiseMap(lambda x, r: r * x * (1 - x), (0, 1), parameters={"r": 4.0})
    >>> ss.zero_one_test(f.iterate(0.3, 2000)).chaotic
    True
    """
    values = real_numbers("series", series)
    if values.ndim != 1 or len(values) < SHORTEST or not np.isfinite(values).all():
        raise ValueError(
            f"series = {shown(series)} is not allowed: {SHORTEST} finite numbers or more, in the "
            "order of time, are needed."
        )
    count = whole_number("n_frequencies", n_frequencies, at_most=MOST_KEPT)
    generator = random_generator("rng", 0 if rng is None else rng)
    c = np.sort(generator.uniform(np.pi / 5, 4 * np.pi / 5, count))
    deviations = _about_mean(values)
    growth = np.array([_growth(deviations, one) for one in c])
    # 1.2533 is the standard error of a median of many normal values over that of their mean.
    error = 1.2533 * float(growth.std() / np.sqrt(count))
    return ZeroOneTest(float(np.median(growth)), error, c, growth, len(values))


def _about_mean(values: Floats) -> Floats:
    """Deviations from the mean, in units of the largest value: squares neither over- nor underflow.

    A mean would drive an oscillation that hides the growth, however exactly it is known.
    """
    scaled = values / (np.abs(values).max() or 1.0)
    return np.asarray(scaled - scaled.mean())


def _growth(values: Floats, c: float) -> float:
    """Correlation of displacements with time, for a point driven at frequency c."""
    n, lags = len(values), len(values) // LAGS
    time = np.arange(n)
    z = np.cumsum(values * np.exp(1j * c * (time + 1)))
    kept = z[: n - lags]
    # mean |z(t + lag) - z(t)|^2 over the same times t for every lag
    sums = np.cumsum(np.abs(np.append(0.0, z)) ** 2)
    lag = np.arange(1, lags + 1)
    ahead = sums[lag + len(kept)] - sums[lag]
    together = signal.correlate(z, kept, mode="valid", method="fft")[lag].real
    moved = (ahead + sums[len(kept)] - 2.0 * together) / len(kept)
    if np.ptp(moved) == 0.0:
        return 0.0  # nothing moves
    return float(np.corrcoef(lag, moved)[0, 1])
