"""Branches of orbits, bifurcations on them, and curves of bifurcations in two parameters."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes

from stickslip.numerics.arrays import Floats
from stickslip.plot.style import PALETTE, axes_or_new, label_once
from stickslip.vocabulary import TERMS, symbol

ROUNDING: Final = 1e-12
MARGINAL: Final = 1e-6  # of a multiplier of a located fold or flip, from 1 or -1
STABLE: Final[dict[str, Any]] = {"color": "black", "lw": 1.6, "zorder": 4}
UNSTABLE: Final[dict[str, Any]] = {"color": PALETTE["vermillion"], "lw": 0.6, "zorder": 3}
BREAK: Final[dict[str, Any]] = {"color": PALETTE["grey"], "lw": 0.7, "ls": (0, (5, 3)), "zorder": 1}

MARKS: Final[dict[str, tuple[str, str]]] = {
    "fold": (">", PALETTE["blue"]),
    "flip": ("o", PALETTE["green"]),
    "neimark_sacker": ("h", PALETTE["green"]),
    "transcritical": ("x", PALETTE["blue"]),
    "pitchfork": ("<", PALETTE["blue"]),
    "border_collision": ("s", PALETTE["purple"]),
    "boundary_crisis": ("X", PALETTE["orange"]),
    "interior_crisis": ("P", PALETTE["orange"]),
    "band_merging": ("D", PALETTE["sky"]),
    "enters_gap": ("v", PALETTE["grey"]),
    "attractor_change": ("d", PALETTE["orange"]),
}
"""Marker and colour of each kind of bifurcation; markers alone tell them apart."""

_OTHER: Final = ("*", PALETTE["black"])


def draw_orbit_curve(
    curve: Any, ax: Axes | None = None, *, proven: Any = None, **style: Any
) -> Axes:
    """Draw an orbit along a parameter: heavy where stable, thin where not; folds, flips marked.

    With a certificate of its branch as `proven`, what is not proven is dashed.
    """
    ax = axes_or_new(ax)
    known = np.ones(len(curve.values), bool) if proven is None else _in_tube(curve, proven.document)
    beyond = ~known
    beyond[1:] |= ~known[:-1]  # dashes reach to what is proven
    beyond[:-1] |= ~known[1:]
    for shown, looks in ((known, {}), (beyond, {"ls": (0, (5, 4))})):
        if shown.any():
            points = curve.points.copy()
            points[~shown] = np.nan
            draw_stretches(ax, curve.values, points, curve.multipliers, **{**looks, **style})
    for item in curve.bifurcations:
        draw_bifurcation(item, ax)
    _name_axes(ax, curve, coordinate_label(curve, 0 if curve.points.ndim > 2 else None))
    return ax


def _in_tube(curve: Any, document: dict[str, Any]) -> Any:
    """Rows of an orbit's curve that pass the tube of a certificate."""
    if document.get("parameter") != curve.parameter or "nodes" not in document:
        raise ValueError("proven is no certificate of a branch along the curve's parameter")
    nodes = np.array([[float(x) for x in node] for node in document["nodes"]])
    radii = np.array([float(radius) for radius in document["radii"]])
    rows = np.clip(np.searchsorted(nodes[:, 0], curve.values) - 1, 0, len(radii) - 1)
    line = np.interp(curve.values, nodes[:, 0], nodes[:, 1])
    away = np.abs(curve.points - line[:, None]).min(axis=1)
    slack = ROUNDING * np.abs(nodes).max(axis=0)  # of V, d: nodes have more digits than doubles
    inside = (curve.values >= nodes[0, 0] - slack[0]) & (curve.values <= nodes[-1, 0] + slack[0])
    return inside & (away < radii[rows] + slack[1])


def draw_stretches(
    ax: Axes,
    values: Floats,
    points: Floats,
    multipliers: Floats,
    **style: Any,
) -> None:
    """Draw points (n, p) or (n, p, m) of an orbit over a parameter, heavy where stable."""
    if points.ndim > 2:
        points = points[..., 0]
        multipliers = np.abs(multipliers).reshape(len(points), -1).max(axis=1)
    # Both meet at a bifurcation that is among the points; else thin lines reach to heavy ones.
    stable = np.abs(multipliers) < 1 + MARGINAL
    unstable = np.abs(multipliers) > 1 - MARGINAL
    unstable[1:] |= ~stable[:-1]
    unstable[:-1] |= ~stable[1:]
    for shown, looks in ((stable, STABLE), (unstable, UNSTABLE)):
        lines = np.where(shown[:, None], points, np.nan)
        if np.isfinite(lines).any():
            ax.plot(values, lines, **{**looks, **style})


def draw_bifurcations(bifurcations: Any, ax: Axes | None = None, *, legend: bool = True) -> Axes:
    """Draw the orbits of a range, stable ones heavy, and a mark per bifurcation."""
    ax = axes_or_new(ax)
    for curve in bifurcations.curves:
        draw_stretches(ax, curve.values, curve.points, curve.multipliers)
    for item in bifurcations:
        draw_bifurcation(item, ax)
    in_space = any(np.ndim(item.points) > 1 for item in bifurcations)
    _name_axes(ax, bifurcations, coordinate_label(bifurcations, 0 if in_space else None))
    ax.set_xlim(bifurcations.range)
    if bifurcations.window is not None:
        ax.set_ylim(bifurcations.window)
    if legend and ax.get_legend_handles_labels()[1]:
        ax.legend(loc="best", handletextpad=0.2)
    return ax


def draw_bifurcation(item: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Mark a bifurcation at its parameter value, on its orbit."""
    new = ax is None
    ax = axes_or_new(ax)
    mark(ax, item.kind, np.full(len(item.points), item.value), item.points, **style)
    if new:
        _name_axes(ax, item, coordinate_label(item, 0 if item.points.ndim > 1 else None))
    return ax


def draw_curve(curve: Any, ax: Axes | None = None, *, names: bool = True, **style: Any) -> Axes:
    """Draw a bifurcation in the plane of two parameters, codimension-two points as circles."""
    ax = axes_or_new(ax)
    x, y = curve.parameters.values()
    kind = curve.kind.removeprefix("bifurcation: ")
    _, color = MARKS.get(kind, _OTHER)
    label = f"{_words(kind)}, period {curve.period}"
    ax.plot(x, y, **{"color": color, "lw": 1.2, "label": label, **style})
    for item in curve.bifurcations:
        where = tuple(item.parameters.values())
        ax.plot(*where, "o", mfc="white", mec=color, ms=4.5, zorder=5)
        if names:
            ax.annotate(item.kind, where, (5, 4), textcoords="offset points", fontsize=7.0)
    _name_axes(ax, curve, parameter_label(curve.solve_for, curve))
    return ax


def draw_breakpoint_curve(curve: Any, ax: Axes | None = None, **style: Any) -> Axes:
    """Draw a breakpoint of a map along a parameter: a dashed line, as D in the paper."""
    ax = axes_or_new(ax)
    ax.plot(curve.values, curve.points[:, 0], **{**BREAK, **style})
    _name_axes(ax, curve, coordinate_label(curve))
    return ax


def parameter_label(name: str, result: Any = None) -> str:
    """Axis label of a parameter: its symbol if a model has it, else its name.

    A map of one's own may have a ``mu`` that is not friction's; every model has a ``V``.
    """
    of_model = "V" in (name, *getattr(_holder(result), "parameters", ("V",)))
    base, _, block = name.rpartition("_")
    known = name in TERMS or (base in TERMS and block.isdigit())
    return symbol(name) if known and of_model else name


def coordinate_label(result: Any, k: int | None = None) -> str:
    """Axis label of a map's coordinate, the only one by default: the map's own name if it has one.

    Else d of an event map, as of a model, and x of a map of one's own.
    """
    holder = _holder(result)
    names = getattr(holder, "coordinates", ())
    if len(names) > (k or 0) and isinstance(names[k or 0], str):
        return str(names[k or 0])
    unknown = ("V",) if k is None else ()  # a list, a loaded result
    known = (getattr(result, "parameter", ""), *getattr(holder, "parameters", unknown))
    base = "d" if hasattr(holder, "model") or "V" in known else "x"
    return f"${base}$" if k is None else f"${base}_{k + 1}$"


def _holder(result: Any) -> Any:
    """Return what knows the parameters of a result: its system, its attractors' one, or itself."""
    inner = getattr(result, "attractors", None)
    known = getattr(result, "system", None) or getattr(inner, "system", None) or result
    return getattr(known, "base", known)  # of a power of a map


def symbol_of(result: Any) -> str:
    """Symbol of the coordinate of a map of the line, as `coordinate_label` without dollars."""
    name = coordinate_label(result).strip("$")
    return r"\varphi" if name == "phase" else name


def name_steps(ax: Axes, symbol: str, power: int = 1) -> None:
    """Name the axes of a map's graph: the coordinate, and that so many steps later."""
    base, index = f"{symbol}_".split("_")[:2]
    index = index and f"{index},"
    ax.set_xlabel(rf"${base}_{{{index}n}}$")
    ax.set_ylabel(rf"${base}_{{{index}n+{power}}}$")


def mark(ax: Axes, kind: str, x: Floats, y: Floats, **style: Any) -> None:
    """Draw the mark of a kind of bifurcation; its label, for a legend, once per axes."""
    y = y[:, 0] if y.ndim > 1 else y
    marker, color = MARKS.get(kind, _OTHER)
    looks: dict[str, Any] = {
        "ls": "none",
        "marker": marker,
        "ms": 4.5,
        "mfc": color,
        "mec": "white",
        "mew": 0.4,
        "zorder": 6,
        "label": label_once(ax, _words(kind)),
    }
    ax.plot(x, y, **{**looks, **style})


def _words(kind: str) -> str:
    return kind.replace("_", " ")


def _name_axes(ax: Axes, result: Any, vertical: str) -> None:
    ax.set_xlabel(parameter_label(result.parameter, result))
    ax.set_ylabel(vertical)
