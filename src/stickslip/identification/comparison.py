"""Which of several fits to the same data to prefer, by criteria and by data left out."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from stickslip.checks import flag, instance, shown
from stickslip.identification.data import CyclePeriods, ForcePoints, MapPoints
from stickslip.identification.fit import Fit
from stickslip.numerics.waiting import waits
from stickslip.results.parts import equal
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from stickslip.identification.data import Data
    from stickslip.numerics.arrays import Floats

SAME = 2.0  # rise of a criterion that is none
FOLDS = 10  # parts of a single set of points, of which each is left out in turn
POINTS = (ForcePoints, MapPoints, CyclePeriods)


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(Result):
    """Fits to the same data, the best by `Fit.aic` first; `compare_fits` makes it.

    Attributes
    ----------
    law : tuple of str
        Names of the fits.
    fits : tuple of Fit
    unknowns : ndarray of int, shape (n,)
        Parameters and starts of motions that were estimated.
    aic_rise : ndarray, shape (n,)
        Of `Fit.aic` over that of the best.
    weight : ndarray, shape (n,)
        Akaike's: ``exp(-aic_rise / 2)``, with the sum 1.
    left_out : ndarray, shape (n,)
        Root mean square of the residuals of data that were left out in turn, of fits to the others,
        in standard errors, or where none is given in hundredths of the scatter. NaN where nothing
        can be left out, inf where a law meets nothing of it.
    """

    law: tuple[str, ...]
    fits: tuple[Fit, ...]
    unknowns: Any
    aic_rise: Floats
    weight: Floats
    left_out: Floats
    _column_names: ClassVar = ("law", "unknowns", "aic_rise", "weight", "left_out")
    _plot: ClassVar = "identification.plot_comparison"

    @property
    def message(self) -> str:
        """What to know besides: fits that say something of themselves, criteria that disagree."""
        told = []
        for law, fit in zip(self.law, self.fits, strict=True):
            if fit.message != "converged":
                each = (re.split(r":| \(", text)[0] for text in fit.message.split("; "))
                told.append(f"{law}: {', '.join(each)}")
            if fit.pieces > 1:
                told.append(f"{law}: in {fit.pieces} pieces, with more unknowns than are counted")
        if np.isfinite(self.left_out).any():
            best = int(np.nanargmin(self.left_out))
            better = 2.0 * np.log(self.left_out[0] / self.left_out[best])
            if len(self.fits[0].residuals) * better > SAME:
                told.append(f"{self.law[best]} tells best what was left out")
        return "\n".join(told)

    def __repr__(self) -> str:
        """Headline, table, what to know besides."""
        n = len(self.fits[0].residuals)
        headline = f"Comparison of {len(self.law)} fits to {n} data: best by aic is {self.law[0]}"
        return "\n".join([headline, repr(self.table()), *filter(None, [self.message])])


@waits
@suggests
def compare_fits(fits: Mapping[str, Fit] | Sequence[Fit], *, left_out: bool = True) -> Comparison:
    """Compare fits of several laws or models to the same data.

    Parameters
    ----------
    fits : mapping of str to Fit, or sequence of Fit
        By name; those of a sequence are called by their laws.
    left_out : bool
        Fit again without a part of the data, each in turn, and compare with that part: sets of
        data one by one, or tenths of a single set of points. A single record is not cut.

    Returns
    -------
    Comparison
        A row for each, the best by Akaike's criterion first.

    Raises
    ------
    ValueError
        Fewer than two fits, fits to other data, or one without residuals.

    Notes
    -----
    A rise of the criterion by less than 2 is none, by more than 10 leaves hardly any support
    (Burnham and Anderson 2002). It holds for independent residuals: look at
    `Fit.autocorrelation`. Data left out count no unknowns and assume less.

    Examples
    --------
    >>> import numpy as np, stickslip as ss
    >>> s = np.linspace(0.05, 1.5, 30)
    >>> law = ss.Stribeck(mu=0.5, speed=0.3)
    >>> noise = np.random.default_rng(1).normal(scale=0.005, size=s.size)
    >>> seen = ss.ForcePoints(s, law.force(s) + noise, sigma=0.005)
    >>> block = ss.Oscillator(V=0.2, friction=law)
    >>> other = block.replace(friction=ss.PoppStelter(gamma=3.0))
    >>> fits = {
    ...     "Stribeck": ss.fit(block, seen, ["mu", "speed"]),
    ...     "law (9)": ss.fit(other, seen, ["gamma", "eta"]),
    ... }
    >>> ss.compare_fits(fits).law
    ('Stribeck', 'law (9)')
    """
    named = _named(fits)
    leave = flag("left_out", left_out)
    listed = list(named.values())
    for name, found in named.items():
        if not equal(found.data, listed[0].data):
            raise ValueError(
                f"fits: {name} is a fit to other data than {next(iter(named))}; only fits to the "
                "same data can be compared."
            )
        if found.chi2 == 0.0:
            raise ValueError(
                f"fits: {name} meets the data without residuals, as a table of these very points "
                "does; make it of other measurements."
            )
    criteria = np.array([found.aic for found in listed])
    order = np.argsort(criteria, kind="stable")
    rise = criteria[order] - criteria.min()
    best = [listed[k] for k in order]
    weight = np.exp(-0.5 * rise)
    return Comparison(
        law=tuple(list(named)[k] for k in order),
        fits=tuple(best),
        unknowns=np.array([found.n_unknowns for found in best]),
        aic_rise=rise,
        weight=weight / weight.sum(),
        left_out=np.array([_left_out(found) if leave else np.nan for found in best]),
    )


def _named(fits: Any) -> dict[str, Fit]:
    """Fits by name: as given, or of a sequence that of their laws."""
    what = "two or more fits by name, such as {'Coulomb': fit_1, 'Stribeck': fit_2}"
    by_name = dict(fits) if isinstance(fits, Mapping) else {}
    listed = list(by_name.values()) or (list(fits) if np.iterable(fits) else [])
    if len(listed) < 2:
        raise ValueError(f"fits = {shown(fits)}: {what} are needed.")
    for each in listed:
        instance("fits", each, Fit, what)
    laws = [[re.split("[:(]", str(law))[0] for law in each.model.laws] for each in listed]
    names = list(map(str, by_name)) or [", ".join(dict.fromkeys(each)) for each in laws]
    if len(set(names)) < len(names):
        raise ValueError(f"fits: two have the same law; give names, {what}.")
    return dict(zip(names, listed, strict=True))


def _left_out(found: Fit) -> float:
    """Root mean square of parts of the data under fits to all others."""
    misfits = []
    for kept, other in _parts(found):
        try:
            again = found._again([found._started(*each) for each in kept])
            misfits.append(again.misfit(other, check_units=False))
        except ValueError:  # of the part, or without it, the law meets nothing
            return float(np.inf)
    return float(np.sqrt(np.sum(misfits) / len(found.residuals))) if misfits else float(np.nan)


def _parts(found: Fit) -> Iterator[tuple[list[tuple[Data, Floats]], Data]]:
    """Yield what is kept, with the starts that were found, and what is left out."""
    pairs = list(zip(found.data, found.starts, strict=True))
    if len(pairs) > 1:
        for k, each in enumerate(found.data):
            yield pairs[:k] + pairs[k + 1 :], each
    elif isinstance(one := found.data[0], POINTS):
        ((_, _, sigma),) = one.rows
        order = np.argsort(one.abscissa[1], kind="stable")
        for k in range(min(FOLDS, len(order))):
            out = np.isin(np.arange(len(order)), order[k::FOLDS])
            kept, other = (
                replace(
                    one,
                    sigma=sigma[rows],
                    **{name: getattr(one, name)[rows] for name in one._axes},
                )
                for rows in (~out, out)
            )
            yield [(kept, found.starts[0])], other
