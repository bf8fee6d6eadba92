"""Strips along the axis of a map: basins of attraction, bands of attractors, densities."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch

from stickslip.plot.bifurcations import coordinate_label, parameter_label
from stickslip.plot.style import PALETTE, axes_or_new

BASIN_COLORS: Final = tuple(
    PALETTE[name] for name in ("sky", "orange", "green", "purple", "vermillion", "blue")
)
HATCHES: Final = ("", "////", "\\\\\\\\", "....", "xxxx")  # tell basins apart in print
LEFT, UNDECIDED = -2, -1


def draw_basins(basins: Any, ax: Axes | None = None, *, attractors: bool = True) -> Axes:
    """Draw basins as a strip: a colour and hatch per attractor, light grey where orbits leave."""
    ax = axes_or_new(ax)
    widths = np.diff(basins.edges)
    for k in np.unique(basins.index):
        mine = basins.index == k
        spans = list(zip(basins.edges[:-1][mine], widths[mine], strict=True))
        ax.broken_barh(spans, (0.0, 1.0), label=_name(basins, int(k)), **_looks(int(k)))
    if attractors:
        for k, attractor in enumerate(basins.attractors):
            _draw_attractor(ax, attractor, k, height=1.12)
    ax.set_xlim(basins.edges[0], basins.edges[-1])
    return _as_strip(ax, 1.25 if attractors else 1.0, basins.attractors)


def draw_bands(attractors: Sequence[Any], ax: Axes | None = None) -> Axes:
    """Draw the bands of attractors as strips, the first one lowest, cycles as points."""
    ax = axes_or_new(ax)
    for k, attractor in enumerate(attractors):
        _draw_attractor(ax, attractor, k, height=k + 0.5)
    return _as_strip(ax, max(len(attractors), 1), attractors)


def draw_attractor(attractor: Any, ax: Axes | None = None) -> Axes:
    """Draw the bands of one attractor; as `draw_bands`."""
    return draw_bands([attractor], ax)


def draw_basins_nd(basins: Any, ax: Axes | None = None, *, attractors: bool = True) -> Axes:
    """Draw basins in a plane with the attractors on top, light grey where orbits leave.

    Along one axis they are a strip; without a grid, or with three axes, the shares are bars.
    """
    ax = axes_or_new(ax)
    found, n = basins.attractors, len(basins.attractors)
    if basins.index.ndim != len(basins.axes) or len(basins.axes) > 2:
        shares = np.array([basins.share(k) for k in (LEFT, UNDECIDED, *range(n))])
        colors = [_looks(k)["facecolor"] for k in (LEFT, UNDECIDED, *range(n))]
        names = ["leave", "undecided", *(_kind(found, k) for k in range(n))]
        ax.bar(names, shares[:, 0], yerr=shares[:, 1], color=colors, edgecolor=PALETTE["grey"])
        ax.set_ylabel("share of starts")
        return ax
    x, y = (*basins.axes, np.array([0.25, 0.75]))[:2]  # a strip: two rows fill 0 to 1
    index = np.broadcast_to(basins.index.reshape(len(x), -1), (len(x), len(y)))
    colors = [mpl.colors.to_rgb(_looks(k)["facecolor"]) for k in (*range(n), LEFT, UNDECIDED)]
    image = np.array(colors)[index.T]  # -2, -1 count from the end
    ax.pcolormesh(x, y, image, shading="nearest").set_rasterized(True)
    limits = ax.get_xlim(), ax.get_ylim()
    first, *other = basins.coordinates
    ax.set_xlabel(coordinate_label(basins, first))
    if not other:
        ax.set_yticks([])
        return ax
    ax.set_ylabel(coordinate_label(basins, other[0]))
    if attractors and len(basins.point) == 2:
        for attractor in found:
            _draw_points(ax, attractor, PALETTE["black"])
        ax.set(xlim=limits[0], ylim=limits[1])
    _tell_shares(ax, basins)
    return ax


def _tell_shares(ax: Axes, basins: Any) -> None:
    """Explain the colours above a plane of basins, with the shares of its points."""
    patches = []
    for k in (*range(len(basins.attractors)), LEFT, UNDECIDED):
        share = basins.share(k).value
        name = {LEFT: "leaves", UNDECIDED: "undecided"}.get(k) or _kind(basins.attractors, k)
        if share > 0.0:
            patches.append(Patch(label=f"{name}, {100 * share:.3g} %", **_looks(k)))
    ax.legend(handles=patches, loc="lower left", bbox_to_anchor=(0, 1), ncols=3, fontsize="small")


def _kind(attractors: Sequence[Any], k: int) -> str:
    period = attractors[k].period
    return f"{k}: {attractors[k].kind}" + (f" {period}" if period else "")


def draw_fractions(fractions: Any, ax: Axes | None = None) -> Axes:
    """Draw shares of basins along a parameter as bands above each other; leaving orbits on top."""
    ax = axes_or_new(ax)
    numbers = sorted({number for known in fractions.numbers for number in known})
    drawn = [*numbers, UNDECIDED, LEFT]
    colors = [_looks(k)["facecolor"] for k in drawn]
    labels = [*map(str, numbers), "undecided", "leave"]
    order = np.argsort(fractions.values)
    values, bands = fractions.values[order], np.array([fractions.share(k)[order] for k in drawn])
    if values[0] == values[-1]:  # bands of no width are not seen
        ax.set_xticks(values[:1])
        values, bands = values[0] + np.array([-0.5, 0.5]), bands[:, [0, -1]]
    ax.stackplot(values, bands, colors=colors, labels=labels)
    ax.set_xlim(values[0], values[-1])
    ax.set_ylim(0.0, 1.0)
    ax.set_xlabel(parameter_label(fractions.parameter, fractions.basins[0]))
    ax.set_ylabel("share of starts")
    ax.legend(loc="best", fontsize="small")
    return ax


def draw_attractors_nd(attractors: Sequence[Any], ax: Axes | None = None) -> Axes:
    """Draw attractors of R^n in their first two coordinates, a colour each; in time on a line."""
    ax = axes_or_new(ax)
    for k, attractor in enumerate(attractors):
        color = BASIN_COLORS[k % len(BASIN_COLORS)]
        _draw_points(ax, attractor, color, _kind(attractors, k))
    ax.set_xlabel(coordinate_label(attractors, 0))
    ax.set_ylabel(coordinate_label(attractors, 1))
    if len(attractors):
        ax.legend(loc="best", fontsize="small")
    return ax


def draw_attractor_nd(attractor: Any, ax: Axes | None = None) -> Axes:
    """Draw one attractor of R^n; as `draw_attractors_nd`."""
    return draw_attractors_nd([attractor], ax)


def _draw_points(ax: Axes, attractor: Any, color: str, label: str = "") -> None:
    x, y = attractor.points[:, 0], attractor.points[:, min(1, attractor.points.shape[1] - 1)]
    cycle = attractor.kind == "periodic"
    style = {"marker": "o" if cycle else ".", "ms": 5.0 if cycle else 1.0, "lw": 0.0}
    white = {"mec": "white"} if cycle else {"mew": 0.0}
    ax.plot(x, y, color=color, label=label, **style, **white)  # type: ignore[arg-type]


def draw_density(density: Any, ax: Axes | None = None) -> Axes:
    """Draw an invariant density over its bands."""
    # The highest half per cent of the density may reach above the axes: inverse square roots have
    # no height.
    ax = axes_or_new(ax)
    breaks = np.flatnonzero(density.left[1:] > density.right[:-1]) + 1
    for cells in np.split(np.arange(len(density.left)), breaks):
        edges = np.append(density.left[cells], density.right[cells[-1]])
        ax.stairs(density.density[cells], edges, color=PALETTE["blue"], lw=0.8)
    ax.set_xlim(density.left[0], density.right[-1])
    ax.set_ylim(0.0, 1.1 * float(np.quantile(density.density, 0.995)))
    ax.set_xlabel(coordinate_label(density))
    ax.set_ylabel("probability density")
    return ax


def _draw_attractor(ax: Axes, attractor: Any, k: int, height: float) -> None:
    color = BASIN_COLORS[k % len(BASIN_COLORS)]
    if attractor.kind in ("chaotic", "neutral"):
        left, right = attractor.bands.T
        ax.hlines(np.full(len(left), height), left, right, colors=color, lw=3.0)
        return
    marker = "o" if attractor.kind == "periodic" else "x"
    points = attractor.bands[:, 0]
    ax.plot(points, np.full(len(points), height), marker, color=color, ms=4.0, clip_on=False)


def _looks(k: int) -> dict[str, Any]:
    if k == LEFT:
        return {"facecolor": PALETTE["light"], "edgecolor": "none"}
    if k == UNDECIDED:
        return {"facecolor": "white", "edgecolor": PALETTE["grey"], "linewidth": 0.3}
    return {
        "facecolor": BASIN_COLORS[k % len(BASIN_COLORS)],
        "edgecolor": "white",
        "linewidth": 0.0,
        "hatch": HATCHES[(k // len(BASIN_COLORS)) % len(HATCHES)],
    }


def _name(basins: Any, k: int) -> str:
    if k == UNDECIDED:
        return "not proved"
    share, error = basins.sampled(k)
    name = "leaves"
    if k != LEFT:
        attractor = basins.attractors[k]
        name = f"attractor {k}: {attractor.kind}, period {attractor.period}"
    return f"{name} (and {share:.3g} ± {error:.1g}, sampled)" if share else name


def _as_strip(ax: Axes, top: float, attractors: Sequence[Any]) -> Axes:
    ax.set_ylim(0.0, top)
    ax.set_yticks([])
    ax.set_xlabel(coordinate_label(next(iter(attractors), None)))
    return ax
