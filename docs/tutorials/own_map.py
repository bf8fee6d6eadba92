"""
A map of your own
=================

Everything that is asked of the event map can be asked of any piecewise-smooth map of an interval:
orbits, breakpoints, basins, bifurcations with border collisions and crises.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# A map with a square-root edge, as grazing oscillators have it (Nordmark 1991): smooth on one
# side of zero, steep beyond.


def grazing(x, a, b, mu):
    return np.where(x < 0, a * x + mu, mu - b * np.sqrt(np.maximum(x, 0)))


def slope(x, a, b, mu):
    with np.errstate(divide="ignore"):  # infinite at the edge
        return np.where(x < 0, a, -b / (2 * np.sqrt(np.maximum(x, 0))))


f = ss.PiecewiseMap(
    grazing,
    domain=(-1.0, 0.5),
    parameters={"a": 0.4, "b": 1.0, "mu": 0.05},
    derivative=slope,  # by differences where it is not given, which takes longer
    breakpoints=[0.0],
)
fig, ax = plt.subplots(figsize=(4.5, 4.5), layout="constrained")
ss.branches(f).plot(ax=ax)

# %%
# As ``mu`` passes zero the stable fixed point hits the edge.

for b in ss.bifurcations(f, "mu", (-0.05, 0.15), max_period=3):
    print(f"mu = {b.value:+.10f}  {b.kind}: {b.outcome.text if b.outcome else ''}")

# %%
# What lives beyond: period adding.

diagram = ss.bifurcation_diagram(f, "mu", np.linspace(-0.02, 0.15, 80), max_period=3)
fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
diagram.plot(ax=ax)

# %%
# How sure is this?
# -----------------
# **Proved.** What two finite slopes at a corner lead to, in the normal form
# (:doc:`/theory/bifurcations`). For an infinite slope, as here, the rule is quoted (Nordmark 1997).
#
# **Checked.** Orbits of maps with a square root against closed forms, in ``tests/analysis``;
# predictions against what is seen, for random slopes.
#
# **Fails, or is only evidence.** A map without labels is known by samples: a jump below 1e-7 of
# its range, or a branch narrower than the cells, is not noticed. Naming ``breakpoints`` helps.
# See :doc:`/theory/maps`.
