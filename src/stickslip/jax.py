"""Operations of JAX: event map, motion and period of a cycle, with their exact derivatives."""

# Each is computed by the package on the host; JAX sees a function of numbers, and its Jacobian.

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from stickslip.checks import shown
from stickslip.errors import NoCycleError
from stickslip.extras import require_extra
from stickslip.identification.data import series
from stickslip.identification.terms import sampled
from stickslip.mechanics.cycle.search import find_cycle
from stickslip.mechanics.eventmap.of_model import event_map as exact_map
from stickslip.mechanics.model.arguments import Model, checked_model, checked_parameter

require_extra("jax", "operations of JAX", "jax")

import jax  # noqa: E402  # after the word about the extra
import jax.numpy as jnp  # noqa: E402

if TYPE_CHECKING:
    from stickslip.numerics.arrays import Floats

__all__ = ["event_map", "motion", "period"]

Operation: TypeAlias = Callable[..., Any]
"""Takes arrays, returns one; `jax.jit`, `grad`, `jacfwd`, `jacrev` and `vmap` take it."""


def event_map(model: Model, *names: str) -> Operation:
    """Event map of two blocks, as a function of points and parameters.

    Parameters
    ----------
    model : TwoBlock, Blocks or Chain
        Of two blocks.
    *names : str
        Parameters that are arguments, among ``model.parameters``.

    Returns
    -------
    callable
        ``f(d, values)`` with `d` of any shape and `values` of shape (names,), or (..., names) with
        leading axes as of `d`; shaped like `d`. NaN where there is no such model, `d` is outside
        its domain, or the motion does not return to global stick.

    Raises
    ------
    ValueError
        A model of other than two blocks, or an unknown name.

    Examples
    --------
    >>> import stickslip as ss
    >>> from stickslip.jax import event_map  # doctest: +SKIP
    >>> f = event_map(ss.examples.coulomb(), "mu")  # doctest: +SKIP
    >>> jax.grad(f, argnums=1)(0.1, jnp.array([0.22]))  # doctest: +SKIP
    """
    model, names = _checked(model, names)
    if model.d_shape != ():
        raise ValueError(f"model = {shown(model)}: an event map of one number needs two blocks")

    def carried(rows: Floats) -> tuple[Floats, Floats]:
        f: Any = exact_map(_changed(model, names, rows[0, 1:]))
        values, slopes = np.full(len(rows), np.nan), np.full(rows.shape, np.nan)
        here = (rows[:, 0] >= f.domain[0]) & (rows[:, 0] <= f.domain[1])
        d = rows[here, 0]
        values[here], slopes[here, 0] = f.value_and_derivative(d)
        for column, name in enumerate(names, start=1):
            slopes[here, column] = f.parameter_derivative(d, name)
        return values, slopes

    operation = _operation(carried, (), first=1)

    def f(d: Any, values: Any = ()) -> Any:
        d, own = jnp.asarray(d, float), jnp.asarray(values, float)
        own = jnp.broadcast_to(own, (*d.shape, len(names)))
        return operation(jnp.concatenate([d[..., None], own], axis=-1))

    return f


def motion(model: Model, t: Any, *names: str) -> Operation:
    """Sample a motion, as a function of its start and parameters.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    t : array_like of float, shape (n,)
        Times >= 0, ascending; the motion starts at 0.
    *names : str
        Parameters that are arguments, among ``model.parameters``.

    Returns
    -------
    callable
        ``f(x0, v0, values)`` of starting displacements and velocities, shape (N,), and parameters,
        shape (names,): displacements, then velocities at the times, shape (n, 2 N). NaN where
        there is no such motion, or beyond its end.

    Raises
    ------
    ValueError
        Times that do not ascend from 0 on, or an unknown name.
    """
    model, names = _checked(model, names)
    times, n = series("t", t), len(model.plant.mass)
    if not len(times) or times[0] < 0.0 or not (np.diff(times) > 0.0).all():
        raise ValueError(f"t = {shown(t)}: times >= 0 are needed, ascending")
    columns = 2 * n + np.arange(len(names))
    state = np.arange(2 * n if model.plant.n_positions else n)
    asked = (*names, *(("x0", "v0") if model.plant.n_positions else ("x0",)))
    shape = len(times), 2 * n

    def followed(rows: Floats) -> tuple[Floats, Floats]:
        slopes = np.zeros((1, *shape, rows.shape[1]))
        start = {"x": rows[0, :n], "v": rows[0, n : 2 * n]}
        now = _changed(model, names, rows[0, 2 * n :])
        values, slopes[0][..., [*columns, *state]] = sampled(now, start, asked, times)
        return values[None], slopes

    operation = _operation(followed, shape)

    def f(x0: Any, v0: Any, values: Any = ()) -> Any:
        return operation(jnp.concatenate([jnp.asarray(each, float) for each in (x0, v0, values)]))

    return f


def period(model: Model, x: Any, v: Any, *names: str) -> Operation:
    """Period of a limit cycle, as a function of parameters.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure
    x, v : array_like of float, shape (N,)
        Where the search of `stickslip.find_cycle` begins, for all values.
    *names : str
        Parameters that are arguments, among ``model.parameters``.

    Returns
    -------
    callable
        ``f(values)`` with `values` of shape (..., names); NaN where no cycle is found.

    Raises
    ------
    ValueError
        No cycle for the model's own values, no name, or an unknown one.
    """
    model, names = _checked(model, names)
    find_cycle(model, x, v).period_derivative(*names)

    def found(rows: Floats) -> tuple[Floats, Floats]:
        cycle = find_cycle(_changed(model, names, rows[0]), x, v)
        return np.array([cycle.period]), cycle.period_derivative(*names)[None]

    operation = _operation(found, ())
    return lambda values: operation(jnp.asarray(values, float))


def _checked(model: Model, names: tuple[str, ...]) -> tuple[Model, tuple[str, ...]]:
    model = checked_model(model)
    return model, tuple(checked_parameter("names", model, name) for name in names)


def _changed(model: Model, names: tuple[str, ...], values: Floats) -> Model:
    return model.replace(**dict(zip(names, values.tolist(), strict=True)))


def _operation(
    of: Callable[[Floats], tuple[Floats, Floats]], shape: tuple[int, ...], first: int = 0
) -> Operation:
    """Make an operation on rows of numbers (..., n) of what gives values and Jacobians of some."""

    # `of` takes rows that differ in their first columns only, or a single one.
    def on_host(rows: Any) -> tuple[Any, Any]:
        flat = np.asarray(rows, dtype=np.float64).reshape(-1, rows.shape[-1])
        values = np.full((len(flat), *shape), np.nan)
        slopes = np.full((*values.shape, flat.shape[1]), np.nan)
        sets, which = np.unique(flat[:, first:], axis=0, return_inverse=True)
        for k in range(len(sets)):
            here = np.flatnonzero(which.ravel() == k)
            with contextlib.suppress(ValueError, NoCycleError):
                values[here], slopes[here] = of(flat[here])
        lead, kind = rows.shape[:-1], rows.dtype
        wide = slopes.reshape((*lead, *shape, flat.shape[1]))
        return values.reshape((*lead, *shape)).astype(kind), wide.astype(kind)

    def called(rows: Any) -> Any:
        lead = rows.shape[:-1]
        like = [
            jax.ShapeDtypeStruct((*lead, *shape, *last), rows.dtype)
            for last in ((), rows.shape[-1:])
        ]
        return jax.pure_callback(on_host, tuple(like), rows, vmap_method="expand_dims")

    def pushed(rows: Any, moved: Any) -> tuple[Any, Any]:
        values, slopes = called(rows[0])
        wide = moved[0].reshape(*rows[0].shape[:-1], *(1 for _ in shape), rows[0].shape[-1])
        return values, (slopes * wide).sum(-1)

    operation: Any = jax.custom_jvp(lambda rows: called(rows)[0])
    operation.defjvp(pushed)
    return operation
