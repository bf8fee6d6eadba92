"""``stickslip diagram``: the library's diagram as a picture and as rows, one for each point."""

import numpy as np

from stickslip.analysis.diagram import AttractorTable, BreakLine, Diagram, OrbitCurve
from stickslip.analysis.one_d.strands import StrandEnd
from stickslip.cli.diagram import _rows

NAN = np.nan


def by_hand():
    """One orbit of period 2 that ends, two attractors at the first value, a jump."""
    end = StrandEnd(0.0, np.zeros(2), "end of range")
    points = np.array([[0.1, 0.2], [0.3, 0.4], [NAN, NAN]])
    orbit = OrbitCurve(2, points, np.array([0.5, -1.5, NAN]), (end, end))
    attractors = AttractorTable(
        where=np.array([0, 0, 2]),
        kind=np.array(["periodic", "chaotic", "undecided"]),
        period=np.array([1, 0, 0]),
        lyapunov=np.array([-0.5, 0.25, NAN]),
        points=np.array([[0.7, NAN], [0.8, 0.9], [0.6, NAN]]),
    )
    jump = BreakLine("jump", np.array([NAN, 0.0, 0.5]))
    values = np.array([1.0, 1.5, 2.0])
    return Diagram("V", values, 2, None, {}, (orbit,), attractors, (jump,))


def test_every_point_has_a_row_and_nothing_else_does():
    table = _rows(by_hand())
    rows = list(zip(*(column.tolist() for column in table.values()), strict=True))
    expected = [
        (1.0, "orbit", 1, "stable", 2, 1, 0.1, 0.5, NAN),
        (1.0, "orbit", 1, "stable", 2, 2, 0.2, 0.5, NAN),
        (1.5, "orbit", 1, "unstable", 2, 1, 0.3, -1.5, NAN),
        (1.5, "orbit", 1, "unstable", 2, 2, 0.4, -1.5, NAN),
        (1.0, "attractor", 1, "periodic", 1, 1, 0.7, NAN, -0.5),
        (1.0, "attractor", 2, "chaotic", 0, 1, 0.8, NAN, 0.25),
        (1.0, "attractor", 2, "chaotic", 0, 2, 0.9, NAN, 0.25),
        (2.0, "attractor", 1, "undecided", 0, 1, 0.6, NAN, NAN),
        (1.5, "breakpoint", 1, "jump", 0, 1, 0.0, NAN, NAN),
        (2.0, "breakpoint", 1, "jump", 0, 1, 0.5, NAN, NAN),
    ]
    assert list(map(str, rows)) == list(map(str, expected))
    names = ["V", "what", "number", "kind", "period", "point", "d", "multiplier", "lyapunov"]
    assert list(table) == names
