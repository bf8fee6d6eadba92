"""Fitting the parameters of a model to measurements, by least squares with exact derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from itertools import pairwise
from statistics import NormalDist
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple, TypeAlias, get_args

import numpy as np

from stickslip.analysis.maps.protocol import box_points
from stickslip.checks import (
    MOST_KEPT,
    checked_interval,
    finite_number,
    flag,
    grid,
    instance,
    one_of,
    random_generator,
    shown,
    whole_number,
)
from stickslip.identification.belonging import check_belongs
from stickslip.identification.data import (
    Data,
    EventTimes,
    ForcePoints,
    Record,
    compared,
    under_conditions,
    weighed,
)
from stickslip.identification.errors import (
    HELD,
    POINTS,
    REACH,
    Prediction,
    Profile,
    crossings,
    predict,
)
from stickslip.identification.terms import MISSED, Answer, Term, natural_period, term_of
from stickslip.mechanics.model.arguments import Model, checked_model, checked_parameter
from stickslip.numerics.waiting import waits
from stickslip.results.result import Result
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from stickslip.numerics.arrays import Floats

Loss: TypeAlias = Literal["linear", "soft_l1", "huber", "cauchy"]
LOSSES = ("linear", "soft_l1", "huber", "cauchy")
# Of the largest singular value of scaled derivatives: what is less determines nothing.
SINGULAR = 1e-7
# Share of a direction that is not determined, above which a parameter takes part in it.
TAKES_PART = 1e-2
# From one approach to the next pieces become fewer by this factor.
FEWER = 3
# Standard error of links between pieces, of the scatter of the record: first, then at the end.
LOOSE, TIGHT = 1e-2, 1e-4
# Root mean square of residuals above which a model does not tell its data: in errors that were
# given, or in hundredths of the scatter where none were.
POOR, POOR_UNWEIGHED, SCATTER = 2.0, 30.0, 100.0
# Standard errors above which neighbouring residuals are alike, and the share of the data's scatter
# below which they are rounding.
ALIKE, ROUNDING = 3.0, 1e-5
# Spread of starts about the model's parameters; of these the best are followed for some steps.
ABOUT, KEPT, STEPS = 1.6, 16, 12
MOST = 200  # evaluations in an approach
MOST_DRAWN = 100  # times as many draws as are asked for, where most are outside the bounds
# Times the median of residuals above which one is told: 6.7 standard errors of normal ones.
FAR = 10.0
# How much worse one motion may fit than its pieces did before it counts as lost.
WORSE = 4.0
# Rounds in which the errors of data and the weight of what was known besides are found together,
# and the relative change of these errors that ends them.
ROUNDS, SETTLED = 20, 1e-4
# Relative changes of the sum of squares that end an approach: the last one, and those before it.
FINE, COARSE = 1e-8, 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """Parameters with their errors; `fit` makes it.

    Attributes
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        With the parameters that fit best.
    parameters : tuple of str
    values, standard_errors : ndarray, shape (k,)
        A standard error is inf where the data cannot tell.
    intervals : ndarray, shape (k, 2)
        95 per cent: normal where all errors were given, else by Student's distribution.
    covariance : ndarray, shape (k, k)
        Of what is determined.
    start : ndarray, shape (k,)
        Values that the search began with.
    undetermined : tuple of str
        Parameters about which the data say nothing, alone or together.
    at_bound : tuple of str
    residuals : ndarray, shape (n,)
        (model - data) / sigma, one set of data after the other.
    chi2 : float
        Sum of their squares.
    n_free : int
        Number of data less that of the unknowns.
    scale : float
        Factor of the errors that were given or assumed, as estimated from the residuals as `loss`
        feels them; 1 where all were given and the loss is "linear".
    starts : tuple of ndarray
        States (displacements, then velocities) that the motions of each set of data start from,
        where these are estimated, piece after piece; or the differences in global stick.
    matched : tuple of str
        What of each set of data was compared.
    n_evaluations : int
    converged : bool
    refused : str
        Why no model is as the next step of the search would have it, though that fits better; empty
        where the search was free to converge.
    data : tuple
    fitted : tuple of ndarray
        What the model gives for each set of data.
    differentiated : tuple of ndarray of bool
        Whether that has derivatives by the unknowns: not after the motion has just touched the
        belt, or once rounding has grown too much. The errors are those of the data that have.
    pieces : int
        Of a record in the answer; more than 1 where one motion has lost the data.
    bounds, priors : ndarray, shape (k, 2)
        Ranges that were searched; mean and standard error, NaN without a prior.
    loss : str
    """

    model: Model
    parameters: tuple[str, ...]
    values: Floats
    standard_errors: Floats
    intervals: Floats
    covariance: Floats
    start: Floats
    undetermined: tuple[str, ...]
    at_bound: tuple[str, ...]
    residuals: Floats
    chi2: float
    n_free: int
    scale: float
    starts: tuple[Floats, ...]
    matched: tuple[str, ...]
    n_evaluations: int
    converged: bool
    refused: str
    data: tuple[Any, ...]
    fitted: tuple[Floats, ...]
    differentiated: tuple[NDArray[np.bool_], ...]
    pieces: int
    bounds: Floats
    priors: Floats
    loss: Loss
    _column_names: ClassVar = ("parameter", "value", "standard_error", "low", "high", "start")
    _plot: ClassVar = "identification.plot_fit"

    @property
    def message(self) -> str:
        """What to know of the estimates."""
        told: list[str] = []
        if self.refused:
            told.append(
                "the search ended where no model allows a better fit, and the estimates mean "
                f"little: {self.refused}"
            )
        elif not self.converged:
            told.append("the search has not converged: raise max_evaluations")
        if not self.tells:
            known = _weighed(self.data)
            size, unit = (1.0, "times their errors") if known else (0.01, "of their scatter")
            look = "Look" if known else "Give sigma= if that is their noise, else look"
            told.append(
                "the model does not tell these data: residuals are some "
                f"{self._size * size:.2g} {unit}. {look} at units, at what is fixed, at where the "
                "search starts (n_starts=), at whether displacements count from where springs are "
                "slack (free_zero=)"
            )
        told += [
            f"residuals of data {k} are not scattered about zero (neighbours correlate by "
            f"{value:.2f} +- {error:.2f}): the law or the model has another form, or the noise "
            "is not white, and the errors mean little"
            for k, value, error in self._alike
        ]
        pairs = list(zip(self.data, self.fitted, strict=True))
        if self.loss == "linear":
            far = ((k, *_farthest(*each)) for k, each in enumerate(pairs, start=1))
            rounding = np.isnan(self.autocorrelation[:, 0])
            told += [
                f"data {k}: {place} is {times:.3g} times as far off as most: an outlier? "
                "(loss='huber' feels it less)"
                for k, place, times in far
                if times > FAR and not rounding[k - 1]
            ]
        missed = sum(int(np.sum(~np.isfinite(each[data.known]))) for data, each in pairs)
        if missed:
            told.append(f"{missed} of {len(self.residuals)} data are not met by the model")
        for k, (data, there) in enumerate(zip(self.data, self.differentiated, strict=True), 1):
            if not there.all():
                found = (at[~known.all(axis=1)] for _, at, _, known, _ in compared(data, there))
                first = min(np.min(at, initial=np.inf) for at in found)
                told.append(
                    f"{np.sum(~there)} of {data.known.sum()} values of data {k} have no "
                    f"derivatives, the first at {data.abscissa[0]} = {first:.6g}: the errors are "
                    "those of the others (a profile tells more)"
                )
        if self.undetermined:
            names = ", ".join(self.undetermined)
            all_felt = all(there.all() for there in self.differentiated)
            which = "the data" if all_felt else "what has derivatives"
            told.append(f"{which} cannot tell {names}: fix one, or measure something else")
        if self.at_bound:
            told.append(f"{', '.join(self.at_bound)} at a bound: the errors mean little there")
        return "; ".join(told) or "converged"

    @property
    def tells(self) -> bool:
        """Whether residuals are of the size of errors, given or seen, or small beside the data.

        Forces tell their errors where residuals of neighbouring speeds are not alike.
        """
        if _weighed(self.data):
            return self._size < POOR
        # A law that is a constant leaves all the scatter that there is: no share of it is too much.
        is_noise = all(isinstance(each, ForcePoints) for each in self.data) and not self._alike
        return self._size < (POOR * SCATTER if is_noise else POOR_UNWEIGHED)

    @property
    def _alike(self) -> list[tuple[int, float, float]]:
        """Sets of data whose neighbouring residuals correlate, counted from 1; how much."""
        found = enumerate(self.autocorrelation, start=1)
        return [(k, value, error) for k, (value, error) in found if value > ALIKE * error]

    @property
    def _size(self) -> float:
        return _scatter(self.residuals, self.n_free, self.loss)

    @property
    def autocorrelation(self) -> Floats:
        """Correlation of neighbouring residuals and its standard error, (sets of data, 2).

        In the order of times, speeds or events: near 0 where the model tells the data, near 1 where
        it has another form. NaN where the residuals are rounding.
        """
        return np.array([_alike(*each) for each in zip(self.data, self.fitted, strict=True)])

    @property
    def misfit_in_words(self) -> str:
        """`chi2`, or without any errors of the data the size of the residuals beside them."""
        of = f"{self.n_free} free data"
        if any(each.is_weighed for each in self.data):
            return f"chi2 = {self.chi2:.6g} for {of}"
        return f"residuals {self._size:.3g} per cent of the scatter of {of}"

    @property
    def correlation(self) -> Floats:
        """Correlations of the estimates, (k, k); NaN of what is not determined."""
        errors = np.sqrt(np.diag(self.covariance))
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.covariance / np.outer(errors, errors))

    @property
    def n_unknowns(self) -> int:
        """Number of parameters and numbers of starts that were estimated."""
        n_priors = int(np.isfinite(self.priors[:, 0]).sum())
        return len(self.residuals) + n_priors - self.n_free

    @property
    def aic(self) -> float:
        """Akaike's criterion, to compare laws on the same data: less is better.

        What was known besides (`priors`) counts as data. `stickslip.compare_fits` compares several.
        """
        n = len(self.residuals)
        misfit = self.chi2 if _weighed(self.data) else n * float(np.log(self.chi2 / n))
        return misfit + self._misfit(self.values) + 2.0 * self.n_unknowns

    def predict(self, quantity: Callable[[Model], Any]) -> Prediction:
        """Carry the errors of the estimates to a quantity of the model.

        Parameters
        ----------
        quantity : callable
            Takes a model, returns a float or an array of one shape, such as
            ``lambda model: ss.equilibria(model)[0].hopf_points[0].V``.

        Returns
        -------
        Prediction
            `value`, `standard_error` and `curvature`, by differences over one standard error along
            each axis of the correlation. Where curvature is not small beside the error, or models
            beside have no such quantity, `stickslip.propagate` takes a `sample`.

        Raises
        ------
        ValueError
            The data cannot tell a parameter, or a model that far from the estimates is illegal.
        """
        if not callable(quantity):
            raise ValueError(f"quantity = {shown(quantity)}: a function of a model is needed")
        return predict(self, quantity, self._axes())

    def sample(self, n: int, *, rng: np.random.Generator | int | None = None) -> dict[str, Floats]:
        """Draw parameters from the distribution of the estimates.

        Parameters
        ----------
        n : int
            Draws.
        rng : Generator or int, optional
            Source of random numbers, or its seed.

        Returns
        -------
        dict of str to ndarray, shape (n,)
            By the distribution of `intervals` about the estimates with their covariance; draws
            outside the bounds are drawn again. `stickslip.propagate` carries them on.

        Raises
        ------
        ValueError
            The data cannot tell a parameter, or next to no draw is within the bounds.

        Examples
        --------
        >>> import stickslip as ss
        >>> block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.4))
        >>> seen = ss.ForcePoints([0.1, 0.2, 0.3, 0.4], [0.52, 0.47, 0.51, 0.5])
        >>> fitted = ss.fit(block, seen, ["mu"])
        >>> fitted.sample(1000, rng=1)["mu"].mean().round(2)
        np.float64(0.5)
        """
        n = whole_number("n", n, at_most=MOST_KEPT)
        generator = random_generator("rng", rng)
        nu, axes, low, high = self._freedom, self._axes(), *self.bounds.T
        found = np.empty((0, len(self.parameters)))
        for _ in range(MOST_DRAWN):
            squares = generator.chisquare(nu, size=(n, 1)) / nu if np.isfinite(nu) else 1.0
            normal = generator.standard_normal((n, len(axes))) @ axes
            drawn = self.values + normal / np.sqrt(squares)
            inside = ((low <= drawn) & (drawn <= high)).all(axis=1)
            found = np.concatenate([found, drawn[inside]])
            if len(found) >= n:
                return dict(zip(self.parameters, found[:n].T.copy(), strict=True))
        raise ValueError(f"of {MOST_DRAWN * n} draws {len(found)} are within the bounds")

    def _axes(self) -> Floats:
        """Axes of the ellipsoid of errors, one standard error long; ValueError if it is open."""
        if self.undetermined:
            raise ValueError(f"the data cannot tell {', '.join(self.undetermined)}: no error of it")
        # Of the correlation: beside the largest variance rounding may be more than all of others.
        sizes, axes = np.linalg.eigh(np.nan_to_num(self.correlation))
        errors = np.sqrt(np.diag(self.covariance))
        return np.asarray((axes * np.sqrt(np.maximum(sizes, 0.0))).T * errors)

    def misfit(self, data: Data | Sequence[Data], *, check_units: bool = True) -> float:
        """Compare the fitted model with data that were not fitted.

        Parameters
        ----------
        data, check_units : as of `fit`

        Returns
        -------
        float
            Sum of the squares of (model - data) / sigma, as `chi2`; states that motions start from
            are estimated where they are not given. Summed over records that are left out in turn
            it compares laws (cross-validation): less is better.

        Raises
        ------
        ValueError
            Data that do not belong to the model, or of which it meets nothing.
        """
        given, check_units = _listed(data), flag("check_units", check_units)
        for number, each in enumerate(given, start=1):
            check_belongs(self.model, each, number, check_units=check_units)
        ends = np.zeros(0), np.zeros(0)
        found, _ = _searched(self.model, given, (), ends, {}, self.loss, None, 1, MOST)
        return found.chi2

    def profile(self, name: str, values: ArrayLike | None = None) -> Profile:
        """Fit all other unknowns for each value of one parameter (profile likelihood).

        Parameters
        ----------
        name : str
            Among `parameters`.
        values : array_like of float, shape (n,), optional
            Values to go through; nine over one and a half times `intervals` if not given.

        Returns
        -------
        Profile

        Raises
        ------
        ValueError
            An unknown name; no values where the data cannot tell the parameter; a value that is
            outside the bounds; a fit whose `loss` is not "linear".
        """
        if self.loss != "linear":
            raise ValueError(f"loss = {self.loss!r}: only least squares have a profile")
        k = self.parameters.index(one_of("name", name, self.parameters))
        best, error = float(self.values[k]), float(self.standard_errors[k])
        if values is None:
            if not np.isfinite(error):
                raise ValueError(f"the data cannot tell {name}: give the values to go through")
            low, high = np.clip(best + REACH * (self.intervals[k] - best), *self.bounds[k])
            values = np.linspace(low, high, POINTS)
        held = np.sort(grid("values", values))
        if held[0] < self.bounds[k, 0] or held[-1] > self.bounds[k, 1]:
            raise ValueError(f"values: {name} is in [{self.bounds[k, 0]}, {self.bounds[k, 1]}]")
        exact = HELD * (error if np.isfinite(error) else np.ptp(held) or abs(best) or 1.0)
        scale = self.scale or 1.0  # 0 of data without noise
        weighted = replace(self, data=tuple(weighed(each, scale) for each in self.data))
        chi2, others = np.zeros(len(held)), np.zeros((len(held), len(self.parameters)))
        for side in (np.flatnonzero(held >= best), np.flatnonzero(held < best)[::-1]):
            now = weighted
            for at in side:
                now = now._held(k, float(held[at]), exact)
                chi2[at], others[at] = now.chi2 + self._misfit(now.values), now.values
        least = self.chi2 / scale**2 + self._misfit(self.values)
        root = np.sign(held - best) * np.sqrt(np.maximum(chi2 - least, 0.0))
        return Profile(name, held, others, root, crossings(held, root, best, self._reach))

    def _held(self, k: int, value: float, error: float) -> Fit:
        """Fit again from here, with a parameter that is all but known."""
        name = self.parameters[k]
        data = [self._started(*each) for each in zip(self.data, self.starts, strict=True)]
        again = self._again(data, {name: (value, error)}, self.model.replace(**{name: value}))
        return replace(again, bounds=self.bounds, priors=self.priors)

    def _again(
        self,
        data: Sequence[Data],
        held: Mapping[str, tuple[float, float]] | None = None,
        model: Model | None = None,
    ) -> Fit:
        """Fit again from here, in as many pieces: other data, or what is held besides."""
        known = dict(zip(self.parameters, self.priors, strict=True))
        priors = {name: tuple(pair) for name, pair in known.items() if np.isfinite(pair[0])}
        bounds = dict(zip(self.parameters, self.bounds, strict=True))
        return fit(
            self.model if model is None else model,
            data,
            self.parameters,
            bounds={name: tuple(ends) for name, ends in bounds.items() if np.isfinite(ends).all()},
            priors={**priors, **(held or {})},
            pieces=self.pieces,
            loss=self.loss,
            check_units=False,
        )

    def _started(self, data: Data, start: Floats) -> Data:
        """Give data the start that was estimated, as a guess."""
        if not len(start) or not isinstance(data, Record | EventTimes) or self.pieces > 1:
            return data
        if data.d is not None:
            return replace(data, d=start)
        n = len(self.model.plant.mass)
        return replace(data, x0=start[:n], v0=start[n:], free_start=True)

    def _misfit(self, values: Floats) -> float:
        """Sum of squares of what was known besides."""
        return float(np.nansum(((values - self.priors[:, 0]) / self.priors[:, 1]) ** 2))

    @property
    def _reach(self) -> float:
        """Standard errors on either side of 95 per cent."""
        from scipy.stats import t as student  # loads linear algebra

        return float(student.ppf(0.975, self._freedom))

    @property
    def _freedom(self) -> float:
        """Degrees of freedom of the estimated errors of the data; inf where they were given."""
        return np.inf if _errors_given(self.data, self.loss) else self.n_free

    def __repr__(self) -> str:
        """Headline, estimates, data."""
        lines = [f"Fit: {self.message}, {self.misfit_in_words}"]
        width = max(map(len, self.parameters), default=0)
        lines += [
            f"  {name:{width}s} = {value:.8g} +- {error:.2g}"
            for name, value, error in zip(
                self.parameters, self.values, self.standard_errors, strict=True
            )
        ]
        for text, (value, error) in zip(self.matched, self.autocorrelation, strict=True):
            alike = f", neighbouring residuals correlate by {value:.2f} +- {error:.2f}"
            lines.append(f"  {text}{alike * bool(np.isfinite(value))}")
        return "\n".join(lines)

    def _columns(self) -> dict[str, Any]:
        low, high = self.intervals.T
        columns = self.parameters, self.values, self.standard_errors, low, high, self.start
        return dict(zip(self._column_names, columns, strict=True))


@waits
@suggests
def fit(
    model: Model,
    data: Data | Sequence[Data],
    parameters: Sequence[str],
    *,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    priors: Mapping[str, tuple[float, float]] | None = None,
    pieces: int | None = None,
    loss: Loss = "linear",
    n_starts: int = 1,
    max_evaluations: int = MOST,
    check_units: bool = True,
) -> Fit:
    """Fit parameters of a model to measurements.

    Least squares with derivatives that are exact through all events; the states that records start
    from are estimated with the parameters.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
        Its parameters are where the search starts; those not listed stay.
    data : Record, EventTimes, MapPoints, ForcePoints or CyclePeriods, or several of them
    parameters : sequence of str
        Names among ``model.parameters``; none to compare a model as it is.
    bounds : mapping of str to (lo, hi), optional
        Ranges of parameters. Without, those that the model allows.
    priors : mapping of str to (mean, standard error), optional
        What is known of parameters besides.
    pieces : int, optional
        Cut each record into so many pieces, each of which starts from a state of its own and
        leads to the next (multiple shooting): for long or chaotic motions. Without, a record is cut
        for the first approach only, and then is one motion, unless that loses the data. Not of a
        record in which a mass is missing.
    loss : {"linear", "soft_l1", "huber", "cauchy"}
        "linear" is least squares; the others feel outliers less (`scipy.optimize.least_squares`).
    n_starts : int
        Look at so many values of the parameters first, the model's and others spread over the
        bounds (without bounds to a factor 1.6 about the model's), and search from the best: where
        there are many local minima, as for points of a map with jumps. 256 are good for two
        parameters.
    max_evaluations : int
        Of the model, in each of the approaches.
    check_units : bool
        Refuse data whose size or duration is some hundred times that of the model's motions.

    Returns
    -------
    Fit

    Raises
    ------
    ValueError
        An unknown parameter, fewer data than unknowns, data that do not belong to the model, or
        that seem to have other units.

    Notes
    -----
    Each residual is a smooth function of the parameters as long as the order of events stays.
    Where no standard error is given, the scatter is estimated from the residuals.

    Examples
    --------
    >>> import numpy as np, stickslip as ss
    >>> block = ss.Oscillator(V=0.2, friction=ss.Coulomb(mu=0.5), damping=0.1)
    >>> t = np.linspace(0, 40, 400)
    >>> x = ss.simulate(block, [0.0], [0.0], t_end=40).x(t)
    >>> record = ss.Record(t, x + np.random.default_rng(1).normal(scale=0.01, size=x.shape))
    >>> found = ss.fit(block.replace(mu=0.4), record, ["mu"])
    >>> abs(found.model.friction.mu - 0.5) < 0.01
    True
    """
    model = checked_model(model)
    given = _listed(data)
    names = _names(model, parameters)
    one_of("loss", loss, LOSSES)
    check_units = flag("check_units", check_units)
    evaluations = whole_number("max_evaluations", max_evaluations)
    n_starts = whole_number("n_starts", n_starts, at_most=MOST_KEPT)
    ranges = _ranges(model, names, _by_name("bounds", bounds, names))
    known = _priors(_by_name("priors", priors, names))
    for number, each in enumerate(given, start=1):
        check_belongs(model, each, number, check_units=check_units)
    for name in names:
        if name not in known and all(name in each.conditions for each in given):
            raise ValueError(
                f"parameters: all data have {name} = "
                f"{', '.join(f'{each.conditions[name]:.6g}' for each in given)} of their own, and "
                f"nothing tells that of the model. Leave {name} out, there or here."
            )
    found, spent = _searched(
        model, given, names, ranges, known, loss, pieces, n_starts, evaluations
    )
    if known and not _errors_given(given, loss):
        found, more = _balanced(found, ranges, evaluations, loss)
        spent += more
    return _result(model, found, ranges, given, known, spent, loss)


def _searched(
    model: Model,
    data: tuple[Data, ...],
    names: tuple[str, ...],
    ranges: tuple[Floats, Floats],
    priors: dict[str, tuple[float, float]],
    loss: Loss,
    pieces: int | None,
    n_starts: int,
    evaluations: int,
) -> tuple[_Stage, int]:
    """Search in fewer and fewer pieces; the last stage that has not lost the data, evaluations."""
    spent = 0
    found: _Stage | None = None
    stages = _stages(model, data, pieces)
    spare = 0 if _errors_given(data, loss) else 1  # else their scatter is estimated, too
    for approach, (counts, link) in enumerate(stages, start=1):
        now = model if found is None else found.problem.changed(found.unknowns)
        before = [None] * len(data) if found is None else [a.states for a in found.answers]
        triples = zip(data, counts, before, strict=True)
        terms = [
            term_of(each, under_conditions(each, now), n, states) for each, n, states in triples
        ]
        search = _Search(_Problem(now, names, terms, priors, link, spare), ranges)
        begin = search.problem.start
        if found is None and n_starts > 1:
            hurried = [term.hurried() for term in terms]
            first = _Search(_Problem(now, names, hurried, priors, link, spare), ranges)
            begin = first.begin(n_starts)
            spent += first.spent
        stage = search.run(begin, evaluations, loss, FINE if approach == len(stages) else COARSE)
        spent += search.spent
        if found is not None and pieces is None and stage.has_lost(found):
            search = _Search(found.problem, ranges)  # one motion has lost the data: its pieces
            found = search.run(found.unknowns, evaluations, loss)  # have not
            spent += search.spent
            break
        found = stage
    assert found is not None
    return found, spent


def _balanced(
    stage: _Stage, ranges: tuple[Floats, Floats], evaluations: int, loss: Loss
) -> tuple[_Stage, int]:
    """Weigh what was known besides by the errors of the data that are estimated, evaluations."""
    # Residuals count in the errors that the data were taken to have: too small by `scale`.
    priors, scale, spent = stage.problem.priors, 1.0, 0
    for _ in range(ROUNDS):
        before, scale = scale, stage.scale(loss)
        if not 0.0 < scale < np.inf or abs(scale - before) <= SETTLED * scale:
            break
        problem = copy(stage.problem)
        problem.priors = {name: (mean, error / scale) for name, (mean, error) in priors.items()}
        search = _Search(problem, ranges)
        stage = search.run(stage.unknowns, evaluations, loss)
        spent += search.spent
    return stage, spent


class _Problem:
    """All terms as one function of all unknowns: parameters, then the terms' own."""

    def __init__(
        self,
        model: Model,
        names: tuple[str, ...],
        terms: list[Term],
        priors: dict[str, tuple[float, float]],
        link: float,
        spare: int,
    ) -> None:
        self.model, self.names, self.terms = model, names, terms
        self.priors, self.link = priors, link
        self.spare = spare  # data beyond the unknowns that are needed
        own = np.cumsum([len(names), *(len(term.start) for term in terms)])
        self.own = [slice(a, b) for a, b in pairwise(own.tolist())]
        self.n_own = int(own[-1]) - len(names)
        self.n_unknown = len(names) + sum(term.n_unknown for term in terms)
        values = np.array([model.parameters[name] for name in names])
        self.start = np.concatenate([values, *(term.start for term in terms)])
        self._last: tuple[bytes | None, list[Answer] | None] = (None, None)
        self.refused = ""  # why there was no answer
        self.n_residuals = 0

    def check(self, unknowns: Floats) -> None:
        """ValueError where a search cannot start, or has too few data."""
        answers = self.answers(unknowns)
        if answers is None:
            raise ValueError(f"the search cannot start: {self.refused}")
        n_data = sum(len(each.residuals) for each in answers)
        n_links = sum(len(each.links) for each in answers)
        if n_data + len(self.priors) < self.n_unknown + self.spare:
            errors = " and their scatter, which sigma= and loss='linear' give" * self.spare
            raise ValueError(
                f"{n_data} data cannot tell {self.n_unknown} unknowns ({len(self.names)} "
                f"parameters, and starts of motions){errors}: give more data, or fix parameters."
            )
        self.n_residuals = n_data + n_links + len(self.priors)

    def changed(self, unknowns: Floats) -> Model:
        """Model with the parameters among the unknowns."""
        return self.model.replace(**dict(zip(self.names, map(float, unknowns), strict=False)))

    def answers(self, unknowns: Floats) -> list[Answer] | None:
        """Answers of all terms; None where there is no such model, or a start is illegal."""
        key = unknowns.tobytes()
        if self._last[0] != key:
            self._last = key, self._answered(unknowns, self.names)
        return self._last[1]

    def _answered(self, unknowns: Floats, names: tuple[str, ...]) -> list[Answer] | None:
        try:
            model = self.changed(unknowns)
            return [
                term.answered_under_conditions(model, names, unknowns[own])
                for term, own in zip(self.terms, self.own, strict=True)
            ]
        except ValueError as error:
            self.refused = str(error)
            return None

    def residuals(self, unknowns: Floats) -> Floats:
        """Residuals of the data, the links and the priors."""
        answers = self.answers(unknowns)
        if answers is None:
            return np.full(self.n_residuals, np.inf)  # the search takes a smaller step
        return self._joined(answers, unknowns)

    def misfit(self, unknowns: Floats) -> float:
        """Badness of a start: what is far off counts little more than what is off."""
        answers = self._answered(unknowns, ())  # no derivatives
        if answers is None:
            return float(np.inf)
        return float(np.sum(np.log1p(self._joined(answers, unknowns) ** 2)))

    def _joined(self, answers: list[Answer], unknowns: Floats) -> Floats:
        known = [
            (unknowns[self.names.index(name)] - mean) / error
            for name, (mean, error) in self.priors.items()
        ]
        links = [each.links / self.link for each in answers]
        return np.concatenate([*(each.residuals for each in answers), *links, np.array(known)])

    def slopes(self, unknowns: Floats) -> Floats:
        """Differentiate the residuals for a search, to which what has no derivatives is level."""
        return np.nan_to_num(self.jacobian(unknowns), posinf=0.0, neginf=0.0)

    def jacobian(self, unknowns: Floats) -> Floats:
        """Differentiate the residuals; not finite where there are no derivatives."""
        answers = self.answers(unknowns)
        assert answers is not None  # a trial that is refused is no step
        n = len(self.names)
        blocks = []
        for part, scale in (("jacobian", 1.0), ("link_jacobian", self.link)):
            for own, each in zip(self.own, answers, strict=True):
                rows = getattr(each, part) / scale
                wide = np.zeros((len(rows), len(unknowns)))
                wide[:, :n], wide[:, own] = rows[:, :n], rows[:, n:]
                blocks.append(wide)
        priors = np.zeros((len(self.priors), len(unknowns)))
        for row, (name, (_, error)) in zip(priors, self.priors.items(), strict=True):
            row[self.names.index(name)] = 1.0 / error
        return np.concatenate([*blocks, priors])


class _Search:
    """Least squares of a problem, within ranges of its parameters."""

    def __init__(self, problem: _Problem, ranges: tuple[Floats, Floats]) -> None:
        self.problem, self.spent = problem, 0
        free = np.full(problem.n_own, np.inf)
        self.low, self.high = (
            np.concatenate([end, sign * free]) for end, sign in zip(ranges, (-1, 1), strict=True)
        )

    def run(
        self, begin: Floats, evaluations: int, loss: Loss, change: float = FINE, far: float = 1.0
    ) -> _Stage:
        """Search from one start, until the sum changes little; `far` is where losses bend."""
        from scipy.optimize import least_squares  # loads linear algebra

        begin = np.clip(begin, self.low, self.high)
        self.problem.check(begin)
        if not len(begin):
            return _Stage(self.problem, begin, converged=True, refused="")
        found = least_squares(
            self.problem.residuals,
            begin,
            self.problem.slopes,
            bounds=(self.low, self.high),
            x_scale="jac",
            loss=loss,
            f_scale=far,
            ftol=change,
            max_nfev=evaluations,
        )
        self.spent += int(found.nfev)
        refused = self._wall(found, change)
        return _Stage(self.problem, found.x, bool(found.status > 0) and not refused, refused)

    def _wall(self, found: Any, change: float) -> str:
        """Why the Gauss-Newton step from an end is refused, though the end is no minimum."""
        # Refused trials shrink the region that is trusted, until a step changes nothing.
        step = np.linalg.lstsq(found.jac.T @ found.jac, -found.grad)[0]
        step = np.clip(found.x + step, self.low, self.high) - found.x
        wanted = -found.grad @ step > change * found.cost  # at a minimum no motion is followed
        refused = wanted and self.problem.answers(found.x + step) is None
        return self.problem.refused if refused else ""

    def begin(self, n_starts: int) -> Floats:
        """Where to search: of many starts the best, each after a few steps."""
        # Points that a trial puts on the wrong side of a jump are far off, however near it is:
        # starts are ranked by a sum of logarithms, which hardly feels them, and followed by one
        # that feels all others.
        starts = [self.problem.start, *self._spread(n_starts - 1)]
        told = [(misfit, k) for k, misfit in enumerate(map(self.problem.misfit, starts))]
        self.spent += n_starts
        # A bound on one side, however far, bends the steps of a search; what no model has is
        # refused as a trial.
        n = len(self.problem.names)
        both = np.isfinite(self.low) & np.isfinite(self.high)
        low, high = np.where(both, self.low, -np.inf)[:n], np.where(both, self.high, np.inf)[:n]
        search, ends = _Search(self.problem, (low, high)), []
        for start in (starts[k] for misfit, k in sorted(told)[:KEPT] if np.isfinite(misfit)):
            end = search.run(start, STEPS, "cauchy", FINE, MISSED).unknowns
            ends.append(np.clip(end, self.low, self.high))
            residuals = self.problem.residuals(ends[-1])
            if float(np.mean(residuals**2)) < POOR**2:
                break  # it tells the data
        self.spent += search.spent
        return min(ends, key=self.problem.misfit, default=self.problem.start)

    def _spread(self, n: int) -> list[Floats]:
        """Spread the parameters of starts evenly over their ranges."""
        k = len(self.problem.names)
        given = self.problem.start[:k]
        about = np.sort(given * np.array([[1.0 / ABOUT], [ABOUT]]), axis=0)
        bounded = np.isfinite(self.low[:k]) & np.isfinite(self.high[:k])
        low = np.where(bounded, self.low[:k], np.maximum(about[0], self.low[:k]))
        high = np.where(bounded, self.high[:k], np.minimum(about[1], self.high[:k]))
        rest = self.problem.start[k:]
        points = box_points(np.column_stack([low, high]), n)
        return [np.concatenate([point, rest]) for point in points]


class _Stage(NamedTuple):
    """What an approach has led to."""

    problem: _Problem
    unknowns: Floats
    converged: bool
    refused: str

    @property
    def answers(self) -> list[Answer]:
        found = self.problem.answers(self.unknowns)
        assert found is not None
        return found

    @property
    def chi2(self) -> float:
        """Of the data alone."""
        return float(np.sum(self.residuals**2))

    @property
    def residuals(self) -> Floats:
        """Of the data alone."""
        return np.concatenate([each.residuals for each in self.answers])

    def has_lost(self, before: _Stage) -> bool:
        """Whether the data are told much worse than before, and not only for rounding."""
        told = [np.nan_to_num(each.fitted, nan=np.inf) for each in self.answers]
        pairs = zip(self.problem.terms, told, strict=True)
        return self.chi2 > WORSE * before.chi2 and not all(
            _is_rounding(term.data, fitted) for term, fitted in pairs
        )

    @property
    def n_free(self) -> int:
        """Number of data, and of what was known besides, less that of the unknowns."""
        return len(self.residuals) + len(self.problem.priors) - self.problem.n_unknown

    def scale(self, loss: Loss) -> float:
        """Scatter of the residuals."""
        return _scatter(self.residuals, self.n_free, loss)


def _stages(
    model: Model, data: tuple[Data, ...], pieces: int | None
) -> list[tuple[list[int], float]]:
    """Numbers of pieces of each set of data, and how tightly pieces are linked, in turn."""
    if pieces is not None:
        n = whole_number("pieces", pieces)
        if n > 1 and not model.plant.n_positions:
            raise ValueError("pieces: the motion of a state-space form is not cut; take pieces=1")
        short = [k for k, each in enumerate(data, 1) if n > 1 and not _is_whole(model, each)]
        if short:
            raise ValueError(
                f"pieces = {n}: data {short[0]} is not cut, for where a piece starts is not known "
                "of a mass that was not measured; take pieces=1 (and more of n_starts)"
            )
        counts = [n if isinstance(each, Record) else 1 for each in data]
        return [(counts, LOOSE), (counts, TIGHT)] if n > 1 else [(counts, 1.0)]
    counts = [_pieces_of(model, each) if isinstance(each, Record) else 1 for each in data]
    # All pieces are tied before the first are joined: joined while loose they may lose the data.
    stages = [(counts, LOOSE)] if max(counts) > 1 else []
    while max(counts) > 1:
        stages.append((counts, TIGHT))
        counts = [max(n // FEWER, 1) for n in counts]
    return [*stages, (counts, 1.0)]


def _pieces_of(model: Model, record: Record) -> int:
    """Count the pieces of the first approach: about one for each fast period."""
    t = np.asarray(record.t)
    if not (_is_whole(model, record) and model.plant.n_positions):
        return 1
    return int(np.clip((t[-1] - t[0]) / natural_period(model), 1, max(len(t) // 12, 1)))


def _is_whole(model: Model, data: Data) -> bool:
    """Whether all masses were measured, where a motion is recorded."""
    return not isinstance(data, Record) or len(data.blocks) == len(model.plant.mass)


def _is_rounding(data: Data, fitted: Floats) -> bool:
    """Whether what the model does not tell of any quantity is rounding."""
    return all(
        np.abs(np.nan_to_num(model - values)).max()
        <= ROUNDING * max(np.ptp(kept), np.abs(kept).max())
        for _, _, values, model, _ in compared(data, fitted)
        for kept in [values[np.isfinite(values)]]
    )


def _alike(data: Data, fitted: Floats) -> tuple[float, float]:
    """Correlate neighbouring residuals, about zero; what the model does not meet is left out."""
    together = squares = 0.0
    if _is_rounding(data, fitted):
        return np.nan, np.nan
    for _, _, values, model, sigma in compared(data, fitted):
        known = np.isfinite(values)
        off = np.nan_to_num(model - values)
        for column, there in zip((off / sigma).T, known.T, strict=True):
            one = column[there]
            together += float(one[1:] @ one[:-1])
            squares += float(one @ one)
    return together / squares, float(np.isfinite(fitted[data.known]).sum()) ** -0.5


def _farthest(data: Data, fitted: Floats) -> tuple[str, float]:
    """Tell where the largest residual is, and how many times as large as most, the median one."""
    rows = [(name, at, abs((a - b) / sigma)) for name, at, a, b, sigma in compared(data, fitted)]
    sizes = [float(np.nanmax(off, initial=0.0)) for _, _, off in rows]
    most = float(np.nanmedian(np.concatenate([off.ravel() for *_, off in rows])))
    if data.is_weighed:  # what a few data happen to miss by may be less than their errors
        most = max(most, NormalDist().inv_cdf(0.75))
    name, at, off = rows[int(np.argmax(sizes))]
    row, column = np.unravel_index(int(np.nanargmax(off)), off.shape)
    block = f" of block {data.blocks[column]}" if isinstance(data, Record) else ""
    place = f"{name}{block} at {data.abscissa[0]} = {at[row]:.6g}"
    return place, max(sizes) / most if most else np.inf


def _listed(data: Any) -> tuple[Data, ...]:
    kinds = get_args(Data)
    listed = [data] if isinstance(data, kinds) else list(data) if np.iterable(data) else []
    what = "a Record, EventTimes, MapPoints, ForcePoints or CyclePeriods, or several of them"
    if not listed:
        raise ValueError(f"data = {shown(data)} is not {what}.")
    given: tuple[Data, ...] = tuple(instance("data", each, kinds, what) for each in listed)
    for k, each in enumerate(given):
        if (first := given.index(each)) < k:
            raise ValueError(
                f"data {k + 1} and data {first + 1} are the same {type(each).__name__}: counted "
                "twice it would make the errors too small. Leave one out; put what was measured "
                "again, with the same result, beside the first in one set."
            )
    return given


def _weighed(data: tuple[Data, ...]) -> bool:
    """Whether all standard errors are given."""
    return all(each.is_weighed for each in data)


def _errors_given(data: tuple[Data, ...], loss: Loss) -> bool:
    """Whether the errors of the data are those given, not estimated from residuals."""
    return _weighed(data) and loss == "linear"


def _names(model: Model, parameters: Any) -> tuple[str, ...]:
    listed = (
        [parameters] if isinstance(parameters, str) or not np.iterable(parameters) else parameters
    )
    names = tuple(checked_parameter("parameters", model, name) for name in listed)
    if len(set(names)) < len(names):
        raise ValueError(f"parameters = {shown(parameters)}: names are needed, each once.")
    return names


def _ranges(
    model: Model, names: tuple[str, ...], bounds: Mapping[str, tuple[float, float]]
) -> tuple[Floats, Floats]:
    """Lowest and highest values of parameters: given, or what the model allows."""
    low, high = np.full(len(names), -np.inf), np.full(len(names), np.inf)
    for k, name in enumerate(names):
        value = model.parameters[name]
        if name in bounds:
            low[k], high[k] = checked_interval(f"bounds[{name!r}]", bounds[name])
            if not low[k] <= value <= high[k]:
                raise ValueError(
                    f"{name} = {value:.6g} of the model, where the search starts, is outside "
                    f"bounds[{name!r}] = ({low[k]:.6g}, {high[k]:.6g})"
                )
            continue
        beside = 1e-6 * (abs(value) or 1.0)
        if value >= 0.0 and not _allows(model, name, -beside):
            low[k] = 0.0 if _allows(model, name, 0.0) else beside
        if value <= 1.0 and not _allows(model, name, 1.0 + beside):
            high[k] = 1.0
    return low, np.maximum(high, np.nextafter(low, np.inf))


def _allows(model: Model, name: str, value: float) -> bool:
    try:
        model.replace(**{name: value})
    except ValueError:
        return False
    return True


def _by_name(what: str, given: Any, names: tuple[str, ...]) -> dict[str, Any]:
    """Return what is given for some of the parameters that are fitted."""
    pairs = {} if given is None else instance(what, given, Mapping, "pairs of numbers by name")
    return {one_of(what, name, names): pair for name, pair in pairs.items()}


def _priors(priors: dict[str, Any]) -> dict[str, tuple[float, float]]:
    known = {}
    for name, pair in priors.items():
        if not np.iterable(pair) or len(listed := list(pair)) != 2:
            raise ValueError(f"priors[{name!r}] = {shown(pair)}: (mean, standard error) is needed")
        known[name] = (
            finite_number(f"priors[{name!r}][0]", listed[0]),
            finite_number(f"priors[{name!r}][1]", listed[1], above=0.0),
        )
    return known


def _result(
    model: Model,
    stage: _Stage,
    ranges: tuple[Floats, Floats],
    data: tuple[Data, ...],
    priors: dict[str, tuple[float, float]],
    evaluations: int,
    loss: Loss,
) -> Fit:
    problem, unknowns = stage.problem, stage.unknowns
    names, n = problem.names, len(problem.names)
    scale = 1.0 if _errors_given(data, loss) else stage.scale(loss)
    jacobian = problem.jacobian(unknowns)
    there = np.isfinite(jacobian).all(axis=1)
    covariance, undetermined = _covariance(jacobian[there], names)
    if not np.isfinite(scale):
        scale, undetermined = 1.0, names
    covariance = covariance * scale**2
    values = unknowns[:n]
    errors = np.sqrt(np.diag(covariance))
    errors[[name in undetermined for name in names]] = np.inf
    known = [priors.get(name, (np.nan, np.nan)) for name in names]
    start = np.array([model.parameters[name] for name in names])
    near = 1e-9 * (np.abs(start) + np.abs(values))
    at_bound = (values - ranges[0] <= near) | (ranges[1] - values <= near)
    best = problem.changed(unknowns)
    found = Fit(
        model=best,
        parameters=names,
        values=values,
        standard_errors=errors,
        intervals=np.zeros((n, 2)),
        covariance=covariance,
        start=start,
        undetermined=undetermined,
        at_bound=tuple(name for name, there in zip(names, at_bound, strict=True) if there),
        residuals=stage.residuals,
        chi2=stage.chi2,
        n_free=stage.n_free,
        scale=scale,
        starts=tuple(
            term.states(under_conditions(term.data, best), unknowns[own])
            for term, own in zip(problem.terms, problem.own, strict=True)
        ),
        matched=tuple(each.matched for each in stage.answers),
        n_evaluations=evaluations,
        converged=stage.converged,
        refused=stage.refused,
        data=data,
        fitted=tuple(each.fitted for each in stage.answers),
        differentiated=tuple(
            _spread_out(each.known, np.asarray(np.isfinite(answer.jacobian).all(axis=1)))
            for each, answer in zip(data, stage.answers, strict=True)
        ),
        pieces=max(term.n_pieces for term in problem.terms),
        bounds=np.column_stack(ranges),
        priors=np.reshape(known, (n, 2)),
        loss=loss,
    )
    reach = found._reach * errors
    return replace(found, intervals=np.column_stack([values - reach, values + reach]))


def _spread_out(known: NDArray[np.bool_], there: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Say of all values what is said of those that are known."""
    every = np.full(len(known), True)
    every[known] = there
    return every


def _scatter(residuals: Floats, n_free: int, loss: Loss) -> float:
    """Scatter of residuals as a loss feels it (Huber 1981, section 7.6); inf where all are far."""
    z = residuals**2
    by_loss: dict[Loss, tuple[Any, Any]] = {
        "linear": (1.0, 1.0),
        "soft_l1": ((1.0 + z) ** -0.5, (1.0 + z) ** -1.5),
        "huber": (np.maximum(z, 1.0) ** -0.5, z <= 1.0),
        "cauchy": (1.0 / (1.0 + z), (1.0 - z) / (1.0 + z) ** 2),
    }
    felt, bend = by_loss[loss]
    size = float(np.sqrt(np.sum((residuals * felt) ** 2) / max(n_free, 1)))
    mean = float(np.mean(bend))
    return size / mean if mean > 0.0 else np.inf


def _covariance(jacobian: Floats, names: tuple[str, ...]) -> tuple[Floats, tuple[str, ...]]:
    """Covariance of the parameters for unit errors, and those that take part in what is free."""
    n = len(names)
    sizes = np.linalg.norm(jacobian, axis=0)
    felt = sizes > 0.0
    _, singular, rows = np.linalg.svd(jacobian[:, felt] / sizes[felt], full_matrices=False)
    kept = singular > SINGULAR * singular[0] if len(singular) else np.zeros(0, dtype=bool)
    spread = (rows[kept] / singular[kept, None]).T / sizes[felt, None]
    every = np.zeros((len(sizes), spread.shape[1]))
    every[felt] = spread
    free = np.zeros(len(sizes))
    free[felt] = np.abs(rows[~kept]).max(axis=0, initial=0.0)
    free[~felt] = 1.0
    undetermined = tuple(
        name for name, share in zip(names, free, strict=False) if share > TAKES_PART
    )
    return (every @ every.T)[:n, :n], undetermined
