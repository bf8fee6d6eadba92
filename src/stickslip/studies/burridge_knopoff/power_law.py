"""Exponents of power laws with their errors, after Clauset, Shalizi and Newman (2009)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import stats

from stickslip.numerics.arrays import Floats

CUTS: Final = 100  # places tried for the lower end
FEWEST: Final = 100  # sizes above the lower end
REPEATS: Final = 200  # of the fit with sizes drawn from it


@dataclass(frozen=True)
class PowerLaw:
    """Density proportional to ``size ** -exponent`` above a smallest size."""

    exponent: float  # by maximum likelihood
    error: float  # standard error (exponent - 1) / sqrt(n)
    smallest: float  # where the law begins
    distance: float  # Kolmogorov-Smirnov, from the sizes above
    n: int  # sizes above the smallest
    p_value: float  # share of samples of the fitted law that are farther from their own fits
    exponential: float  # Vuong's log likelihood ratio against an exponential law; > 2: power law

    def share_above(self, size: Floats) -> Floats:
        """Share of the sizes above the smallest that are larger than these."""
        return np.asarray((size / self.smallest) ** (1.0 - self.exponent))


def fit_power_law(
    sizes: Floats, rng: np.random.Generator, *, smallest: float | None = None
) -> PowerLaw:
    """Fit a power law to the upper end of some sizes; it begins where it is least distant."""
    ordered = np.sort(sizes)
    if smallest is None:
        cuts = np.unique(ordered[np.linspace(0, ordered.size - FEWEST, CUTS).astype(int)])
        tails = [ordered[np.searchsorted(ordered, cut) :] for cut in cuts]
        tail = min(tails, key=_distance)
    else:
        tail = ordered[np.searchsorted(ordered, smallest) :]
    slope, distance, n = _slope(tail), _distance(tail), tail.size
    repeats = tail[0] * (1.0 + rng.pareto(slope, size=(REPEATS, n)))
    farther = [_distance(np.sort(sample), smallest=tail[0]) > distance for sample in repeats]
    steep = stats.expon(loc=tail[0], scale=tail.mean() - tail[0])
    ratio = stats.pareto(slope, scale=tail[0]).logpdf(tail) - steep.logpdf(tail)
    return PowerLaw(
        exponent=1.0 + slope,
        error=float(slope / np.sqrt(n)),
        smallest=float(tail[0]),
        distance=distance,
        n=n,
        p_value=float(np.mean(farther)),
        exponential=float(ratio.sum() / (np.sqrt(n) * ratio.std())),
    )


def _slope(tail: Floats, smallest: float | None = None) -> float:
    """Most likely slope of the share above a size."""
    return float(1.0 / np.log(tail / (smallest or tail[0])).mean())


def _distance(tail: Floats, smallest: float | None = None) -> float:
    """Kolmogorov-Smirnov distance of sizes from the law fitted to them."""
    law = stats.pareto(_slope(tail, smallest), scale=smallest or tail[0])
    return float(stats.kstest(tail, law.cdf).statistic)
