"""Branches of orbits as pictures: heavy up to the bifurcation, thin from there."""

import numpy as np

from stickslip.plot.bifurcations import STABLE, UNSTABLE, draw_stretches
from stickslip.plot.style import new_figure


def test_an_orbit_is_heavy_up_to_its_flip_and_thin_from_there():
    ax = new_figure().add_subplot()
    values = np.array([0.0, 1.0, 3.0, 4.0])
    multipliers = np.array([-0.5, -0.8, -1.0, -1.5])
    draw_stretches(ax, values, values[:, None], multipliers)
    shown = {line.get_linewidth(): np.isfinite(line.get_ydata()) for line in ax.lines}
    assert shown[STABLE["lw"]].tolist() == [True, True, True, False]
    assert shown[UNSTABLE["lw"]].tolist() == [False, False, True, True]


def test_without_the_point_itself_the_thin_line_reaches_to_the_heavy_one():
    ax = new_figure().add_subplot()
    values = np.array([0.0, 1.0, 2.0])
    draw_stretches(ax, values, values[:, None], np.array([0.5, 0.9, 1.1]))
    shown = {line.get_linewidth(): np.isfinite(line.get_ydata()) for line in ax.lines}
    assert shown[STABLE["lw"]].tolist() == [True, True, False]
    assert shown[UNSTABLE["lw"]].tolist() == [False, True, True]
