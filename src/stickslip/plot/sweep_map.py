"""Maps of sweeps: a colour for each grid point, and exact bifurcation curves over them."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm, ListedColormap
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stickslip.plot.bifurcations import parameter_label
from stickslip.plot.style import PALETTE, axes_or_new
from stickslip.vocabulary import did_you_mean

SCALE: Final = "viridis"  # even to the eye, and to colour-blind ones
CLIPPED: Final = 1.0  # percent of the values at each end that may lie beyond the scale
CYCLES: Final = 2.0  # how far a scale of exponents goes down, times how far it goes up
CATEGORIES: Final = ("sky", "orange", "green", "purple", "blue", "vermillion")
NONE: Final = {"undecided": "light", "left": "grey"}  # kinds that are no attractors
LONG: Final = {7: "7 to 15", 16: "16 to 31", 32: "32 to 63", 64: "64 and more"}  # by first one
LONG_SCALE: Final = "copper_r"  # their colours
EVEN: Final = 1e-6  # relative differences of steps of an axis that is called even
CURVE: Final[dict[str, Any]] = {"color": "black", "lw": 1.0}
CASING: Final[dict[str, Any]] = {"color": "white", "lw": 2.4}  # keeps curves apart from dark cells


def sweep(
    dataset: Any,
    variable: str | None = None,
    ax: Axes | None = None,
    *,
    curves: tuple[Any, ...] = (),
) -> Axes:
    """Draw a variable of a sweep over its two axes, or as a line over its one.

    Parameters
    ----------
    dataset : xarray.Dataset
        From `stickslip.sweep` or `stickslip.open_sweep`, with two axes left, or one.
    variable : str, optional
        By default the first one that has these axes alone.
    ax : matplotlib.axes.Axes, optional
        Where to draw; by default a new figure.
    curves : tuple of Curve
        Of bifurcations,
        In the two parameters of the axes.

    Returns
    -------
    matplotlib.axes.Axes
        The first axis of the sweep to the right, the second one up. Nothing is drawn where nothing
        was computed yet, or where there is no value.

    Raises
    ------
    ValueError
        There is no such variable, it has more axes or none, or a curve has other parameters.
    """
    array = _chosen(dataset, variable)
    for curve in curves:
        if set(curve.parameters) != set(array.dims):
            raise ValueError(
                f"a curve of {curve.solve_for} over {curve.parameter} does not lie in the plane of "
                f"{' and '.join(array.dims)}."
            )
    ax = axes_or_new(ax)
    values = np.ma.masked_invalid(array.values.T.astype(float))
    if array.dtype.kind == "i":
        values = np.ma.masked_equal(values, float(np.iinfo(array.dtype).min))
    if array.ndim == 1:
        return _line(array, values, ax)
    across, up = array.dims
    x, y = array[across].values, array[up].values
    if "flag_values" in array.attrs or array.name == "period":
        _categories(array, values, x, y, ax)
    else:
        low, high = _limits(values, str(array.name))
        mesh = ax.pcolormesh(x, y, values, cmap=SCALE, vmin=low, vmax=high, shading="nearest")
        mesh.set_rasterized(True)
        ax.get_figure().colorbar(mesh, ax=ax, label=_title(array), extend="both")  # type: ignore[union-attr]
    for name, ticks in ((across, x), (up, y)):
        _name_axis(ax, "x" if name == across else "y", name, ticks)
    _draw_curves(curves, across, ax)
    return ax


def _chosen(dataset: Any, variable: str | None) -> Any:
    names, axes = list(dataset.data_vars), set(dataset.coords)
    drawn = [n for n in names if dataset[n].ndim in (1, 2) and axes.issuperset(dataset[n].dims)]
    if variable is None:
        variable = next(iter(drawn), names[0])
    if variable not in names:
        raise ValueError(f"variable = {variable!r} is unknown. {did_you_mean(variable, names)}")
    array = dataset[variable]
    if variable not in drawn:
        raise ValueError(
            f"variable {variable!r} has the axes {', '.join(array.dims) or 'none'}: a picture has "
            "one or two of the sweep's. Choose values of the others: --at NAME=VALUE, or "
            "dataset.sel(...)."
        )
    return array


def _title(array: Any) -> str:
    return str(array.attrs.get("long_name", array.name))


def _line(array: Any, values: Any, ax: Axes) -> Axes:
    """Draw values over one axis, kinds by their names; whole numbers do not go from one to one."""
    (across,) = array.dims
    ax.plot(array[across].values, values, "." if array.dtype.kind == "i" else ".-")
    _name_axis(ax, "x", across, array[across].values)
    ax.set_ylabel(_title(array), wrap=True)
    if "flag_values" in array.attrs:
        ax.set_yticks(array.attrs["flag_values"], array.attrs["flag_meanings"].split())
    return ax


def _limits(values: Any, name: str) -> tuple[float | None, float | None]:
    """Return the ends of a scale on which single extreme values do not hide the rest."""
    known = values.compressed()
    if not known.size:
        return None, None
    low, high = np.percentile(known[np.isfinite(known)], (CLIPPED, 100 - CLIPPED))
    if name == "lyapunov_exponent" and high > 0:
        # Exponents of cycles have no lower bound; shown to their end they would hide chaos.
        low = max(low, -CYCLES * high)
    return float(low), float(high)


def _categories(array: Any, values: Any, x: NDArray[Any], y: NDArray[Any], ax: Axes) -> None:
    """Give each kind, or each small period, a colour of its own, named in a legend."""
    if array.name == "period":
        values, names, colours = _periods(values)
    else:
        meanings = array.attrs["flag_meanings"].split()
        names = dict(zip(array.attrs["flag_values"], meanings, strict=True))
        free = iter(CATEGORIES)
        colours = {code: PALETTE[NONE.get(name) or next(free)] for code, name in names.items()}
    codes = sorted(names)
    edges = [*(code - 0.5 for code in codes), codes[-1] + 0.5]
    scale = ListedColormap([colours[code] for code in codes])
    mesh = ax.pcolormesh(
        x, y, values, cmap=scale, norm=BoundaryNorm(edges, len(codes)), shading="nearest"
    )
    mesh.set_rasterized(True)
    there = set(np.unique(values.compressed()).astype(int).tolist())
    title = "period" if array.name == "period" else None
    patches = [Patch(color=colours[code], label=names[code]) for code in codes if code in there]
    ax.legend(handles=patches, title=title, loc="upper left", bbox_to_anchor=(1.01, 1.0))


def _periods(values: Any) -> tuple[Any, dict[int, str], dict[int, Any]]:
    """Group long periods; give names and colours by the first period of each group."""
    first = np.array([0, *range(1, min(LONG)), *LONG])
    groups = first[np.searchsorted(first, np.ma.getdata(values), side="right") - 1]
    names = {0: "not periodic", **{p: str(p) for p in range(1, min(LONG))}, **LONG}
    colours: dict[int, Any] = {0: PALETTE["light"]}
    colours |= {p: PALETTE[name] for p, name in enumerate(CATEGORIES[: min(LONG) - 1], start=1)}
    shades = colormaps[LONG_SCALE](np.linspace(0.25, 1.0, len(LONG)))
    colours |= dict(zip(LONG, shades, strict=True))
    return np.ma.array(groups, mask=np.ma.getmaskarray(values)), names, colours


def _name_axis(ax: Axes, which: str, name: str, ticks: NDArray[Any]) -> None:
    getattr(ax, f"set_{which}label")(parameter_label(str(name)))
    if ticks.size < 3 or (ticks <= 0).any():
        return
    steps, ratios = np.diff(ticks), np.diff(np.log(ticks))
    if np.ptp(steps) > EVEN * abs(steps).max() and np.ptp(ratios) <= EVEN * abs(ratios).max():
        getattr(ax, f"set_{which}scale")("log")


def _draw_curves(curves: tuple[Any, ...], across: str, ax: Axes) -> None:
    limits = ax.get_xlim(), ax.get_ylim()
    for curve in curves:
        (other,) = set(curve.parameters) - {across}
        line = curve.parameters[across], curve.parameters[other]
        ax.plot(*line, **CASING)
        kind = curve.kind.removeprefix("bifurcation: ").replace("_", " ")
        label = f"{kind} of period {curve.period}"
        ax.plot(*line, **CURVE, label=label)
    ax.set_xlim(limits[0])
    ax.set_ylim(limits[1])
