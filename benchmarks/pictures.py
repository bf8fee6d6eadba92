"""Pictures of the last benchmark run, from ``results/latest.json``.

python -m benchmarks.pictures [folder]
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from benchmarks.bench_peers import OURS
from benchmarks.bench_peers import TABLE as PEERS
from benchmarks.bench_scaling import BATCH, EVENTS
from benchmarks.report import RESULTS

from stickslip.plot.style import PALETTE, new_figure, save, style

Rows = list[dict[str, Any]]


def draw_peers(axes: Any, rows: Rows, law: str) -> None:
    """Time of a map by each program, and its wrong answers next to breakpoints."""
    rows = sorted((r for r in rows if r["law"] == law), key=lambda r: -r["us/map"])
    least = min(row["us/map"] for row in rows)
    for place, row in enumerate(rows):
        colour = PALETTE["vermillion" if row["by"] == OURS else "blue"]
        axes.plot([least / 3, row["us/map"]], [place, place], color=PALETTE["light"], zorder=0)
        axes.plot(row["us/map"], place, "o", color=colour)
        axes.annotate(
            row["wrong, near breakpoints"], (row["us/map"], place), xytext=(6, 0),
            textcoords="offset points", va="center", fontsize=7,
        )  # fmt: skip
    axes.set_yticks(range(len(rows)), [row["by"] for row in rows])
    axes.tick_params(axis="y", which="both", left=False, right=False)
    axes.set(xscale="log", xlabel="time of a map (µs), one core", title=law)
    axes.set_xlim(least / 3, 40 * max(row["us/map"] for row in rows))


def draw_batch(axes: Any, rows: Rows) -> None:
    """Draw the maps per second against the size of the array."""
    for law in dict.fromkeys(row["law"] for row in rows):
        points = [(row["n"], row["maps/s"]) for row in rows if row["law"] == law]
        axes.plot(*zip(*points, strict=True), "o-", label=law)
    axes.set(xscale="log", yscale="log", xlabel="maps asked at once", ylabel="maps per second")
    axes.legend(loc="center right")


def draw_events(axes: Any, rows: Rows) -> None:
    """Time of an event against the events of a map."""
    rows = sorted(rows, key=lambda row: row["events/map"])
    x = [row["events/map"] for row in rows]
    axes.plot(x, [row["ns/event"] for row in rows], "o-", label="stickslip")
    c = [row["ns/event"] * row["times faster than C"] for row in rows]
    axes.plot(x, c, "s--", color=PALETTE["grey"], label="scalar C")
    axes.set(xscale="log", xlabel="events of a map", ylabel="time of an event (ns)")
    axes.set_ylim(0, None)
    axes.legend()


def main(folder: Path) -> list[Path]:
    """Draw what has been measured."""
    tables = json.loads((RESULTS / "latest.json").read_text())["tables"]
    written = []
    with style():
        if PEERS in tables:
            laws = list(dict.fromkeys(row["law"] for row in tables[PEERS]))
            figure = new_figure("two", height=2.6)
            for axes, law in zip(
                figure.subplots(1, len(laws), squeeze=False)[0], laws, strict=True
            ):
                draw_peers(axes, tables[PEERS], law)
            written += save(figure, folder / "benchmark-peers", formats=("svg", "png"))
        if BATCH in tables and EVENTS in tables:
            figure = new_figure("two", height=2.6)
            left, right = figure.subplots(1, 2)
            draw_batch(left, tables[BATCH])
            draw_events(right, tables[EVENTS])
            written += save(figure, folder / "benchmark-scaling", formats=("svg", "png"))
    return written


if __name__ == "__main__":
    print(*main(Path(sys.argv[1]) if len(sys.argv) > 1 else RESULTS), sep="\n")
