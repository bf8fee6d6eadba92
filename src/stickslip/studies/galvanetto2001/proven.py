"""Figure 4 as theorems: what is proven for every V of it, and what is not.

Docs: theorems, figure 4.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stickslip import examples
from stickslip.analysis.orbits.periodic import periodic_orbits
from stickslip.mechanics.eventmap.of_model import event_map
from stickslip.numerics.arrays import Floats
from stickslip.plot.style import DASHED, PALETTE, panel_letter
from stickslip.proofs.certify import certify_branch, certify_orbits
from stickslip.studies.proven import Proof

RANGE: Final = (Fraction("0.0366"), Fraction("0.0372"))
BEYOND: Final = Fraction(1, 10**6)  # after V*: as near as orbits are looked for
DIGITS: Final = 10  # of what is stated
WIDER: Final = Fraction(3, 2)  # more than the ratio of distances from V* of the ends of an interval
INSIDE: Final = Fraction(87, 100)  # of the distance from V* of one interval's end: in the next one
SETTLED: Final = 4000  # steps after which an orbit is its attractor
CLUSTER: Final = 1e-3  # around the jump: points of an orbit that come nearer to it step by step
SAME: Final = 1e-11  # two points of an orbit
SOLID: Final[dict[str, Any]] = {"color": PALETTE["blue"], "lw": 0.8}
THIN: Final[dict[str, Any]] = {"color": PALETTE["vermillion"], "lw": 0.5}
BROKEN: Final[dict[str, Any]] = {"color": PALETTE["grey"], "ls": DASHED, "lw": 0.8}
LOOKS: Final = 60  # values of V at which floating point looks for what is not proven


def proofs() -> Iterator[Proof]:
    """Prove one part of the figure after the other."""
    model = examples.coulomb()
    low, high = RANGE
    yield Proof(
        "fixed-points",
        "exactly three fixed points: S1 stable, U1 and U2 unstable",
        low,
        high,
        certify_orbits(model, 1, along="V", range=(str(low), str(high)), digits=DIGITS),
    )
    (s4,) = periodic_orbits(model, 4).of_period(4)
    before = certify_branch(model, s4.points[-1], 4, "V", _decimals(low, high), digits=DIGITS)
    if not before or not before.document["lost"]:
        yield Proof("S4", "S4, stable, of period 4", low, high, before)
        return
    star = Fraction(before.document["lost"][0]["value"].split()[0])
    yield Proof("S4", "S4, stable, of period 4, lost at V* = upper end", low, star, before)
    jump = float(before.document["lost"][0]["points"][0].split()[0])
    yield from _after(star, jump)


def _after(star: Fraction, jump: float) -> Iterator[Proof]:
    """Prove the stable orbits of period 4n + 3 beyond V*, from the largest V down."""
    (_, top), least = RANGE, star + BEYOND
    V = top
    while top > least:
        ends = max(star + (V - star) / WIDER, least), min(star + (V - star) * WIDER, RANGE[1])
        near, period = _attractor(float(V), jump)
        model = examples.coulomb(V=float(V))
        proof = certify_branch(model, near, period, "V", _decimals(*ends), digits=DIGITS)
        nodes = proof.document.get("nodes", [[end] for end in ends])
        low, high = (Fraction(nodes[k][0]) for k in (0, -1))
        yield Proof(f"P{period}", f"a stable orbit of period {period}", low, high, proof)
        top = low
        V = Fraction(repr(float(star + (top - star) * INSIDE)))


def _decimals(*ends: Fraction) -> Any:
    return tuple(Fraction(repr(float(end))) for end in ends)


def _attractor(V: float, jump: float) -> tuple[float, int]:
    """Find the point of the stable orbit that is the last before the jump, and its period."""
    points = _orbit(V, jump - CLUSTER / 2)
    cluster = np.sort(points[np.abs(points - jump) < CLUSTER])
    return float(cluster[-2]), len(points)


def _orbit(V: float, start: float) -> Floats:
    """Points of the stable orbit that a start tends to."""
    points = event_map(examples.coulomb(V=V)).iterate(start, SETTLED)[-SETTLED // 2 :]
    again = np.flatnonzero(np.abs(points[1:] - points[0]) < SAME)
    return np.asarray(points[: int(again[0]) + 1])


def covered(proofs: Sequence[Proof]) -> tuple[Fraction, Fraction]:
    """Return V*, and the share of V from V* + 1e-6 to the end at which a stable orbit is proven."""
    star = proofs[1].high
    low, top, length = star + BEYOND, RANGE[1], Fraction(0)
    for each in proofs[2:]:
        if each.certificate:
            a, b = max(each.low, low), min(each.high, top)
            length += max(b - a, Fraction(0))
            top = min(top, a)
    return star, length / (RANGE[1] - low)


def unproven(proofs: Sequence[Proof]) -> list[str]:
    """Say what of the figure is not proven, and why."""
    if len(proofs) < 3:
        return ["what follows S4: it was not shown where S4 is lost"]
    star, share = covered(proofs)
    left = (
        f"{float(100 * (1 - share)):.4g} % of V from V* + 1e-6 to {float(RANGE[1])}: in no interval"
    )
    return [
        f"stable orbits for V from V* = {float(star):.10g} to V* + 1e-6: their intervals shrink to "
        "V*, infinitely many, and each takes a proof of its own",
        *([left] if share < 1 else []),
        "that there is no other attractor for V beyond V*: lists end at fixed points, and basins "
        "are proven at single values",
    ]


def draw(proofs: Sequence[Proof], figure: Figure) -> None:
    """Draw the figure: what is proven is solid, what is not is dashed."""
    left, right = figure.subplots(1, 2, width_ratios=(1, 1.2))
    for each in proofs:
        for branch in each.certificate.document.get("branches", [each.certificate.document]):
            if "nodes" in branch:
                values, points = _lines(branch)
                left.plot(values, points, **(SOLID if branch["stable"] else THIN))
    _enlarge(right, proofs)
    left.set(xlabel="$V$", ylabel="$d$", xlim=tuple(map(float, RANGE)))
    for letter, ax in zip("ab", (left, right), strict=True):
        panel_letter(ax, letter)


def _enlarge(ax: Axes, proofs: Sequence[Proof]) -> None:
    """Draw the orbits after V* by their points beside the jump, over log(V - V*)."""
    if len(proofs) < 3:
        return
    star = float(proofs[1].high)
    jump = float(proofs[1].certificate.document["lost"][0]["points"][0].split()[0])
    beyond = [(float(BEYOND) / 10, float(BEYOND))]
    for each in proofs[2:]:
        if not each.certificate:
            beyond.append((float(each.low) - star, float(each.high) - star))
            continue
        values, points = _lines(each.certificate.document)
        points[np.abs(points - jump) > CLUSTER] = np.nan
        ax.plot(values - star, points, **SOLID)
    for ends in beyond:
        _dash(ax, star, jump, np.geomspace(*ends, LOOKS))
    ax.axvline(float(BEYOND), color=PALETTE["grey"], lw=0.5)
    ax.set(xscale="log", xlabel="$V - V^*$", ylabel="$d$ beside the jump")


def _dash(ax: Axes, star: float, jump: float, beyond: Floats) -> None:
    """Draw the orbits that floating point finds, those of one period joined."""
    found: dict[int, list[tuple[float, Floats]]] = {}
    for away in beyond.tolist():
        orbit = _orbit(star + away, jump - CLUSTER / 2)
        near = np.sort(orbit[np.abs(orbit - jump) < CLUSTER])
        found.setdefault(len(orbit), []).append((away, near))
    for rows in found.values():
        n = min(len(near) for _, near in rows)
        ax.plot([away for away, _ in rows], np.array([near[-n:] for _, near in rows]), **BROKEN)


def _lines(branch: dict[str, Any]) -> tuple[Floats, Floats]:
    """Points of the orbit at some nodes of a branch, in the order in which they come."""
    nodes = np.array([[float(x) for x in node] for node in branch["nodes"]])
    rows = [
        event_map(examples.coulomb(V=V)).iterate(d, branch["period"] - 1) for V, d in nodes.tolist()
    ]
    return nodes[:, 0], np.array(rows)
