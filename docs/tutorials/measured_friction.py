"""
From measured friction to a squeal map
======================================

A brake block or a rubber seal comes with a table: slip speed and friction coefficient, from a
tribometer. Does it squeal, and at which speeds? That is the stability of steady sliding, and the
stick-slip motion that takes its place.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# The measurement
# ---------------
# Force over the static limit, against slip speed in units of ``f_s / sqrt(k m)``. (`ss.Units`
# converts to and from metres and seconds.) The cubics between the points rise and fall only as
# the points do.

speed = [0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0]
force = [0.98, 0.86, 0.76, 0.63, 0.51, 0.45, 0.44, 0.46, 0.50]
law = ss.TabulatedFriction(speed=speed, force=force)
s = np.linspace(0, 2, 400)
fig, ax = plt.subplots(figsize=(5, 3), layout="constrained")
ax.plot(s, law.force(s))
ax.plot(speed, force, "o", ms=4)
ax.set(xlabel="slip speed $s$", ylabel="$F(s)$", ylim=(0, 1))

# %%
# Steady sliding
# --------------
# One block on the belt. Where the law falls faster than the damper can follow, steady sliding is
# unstable: the squeal analysis.

block = ss.Oscillator(V=0.3, friction=law, damping=0.1)
(sliding,) = ss.equilibria(block)
print(sliding)

# %%
# What the block does instead: it sticks and slips. The multiplier of the cycle is zero, because a
# block that sticks forgets where it came from.

cycle = ss.find_cycle(block, [0.0], [0.0])
print(f"period {cycle.period:.10f}, multipliers {cycle.multipliers}")
motion = ss.simulate(block, [0.0], [0.0], t_end=60)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
motion.plot(ax=ax)

# %%
# The squeal map
# --------------
# Steady sliding is unstable where the law falls faster than the damper can follow, ``c <
# -F'(V)``. But the stick-slip cycle lives on beside stable sliding: there a knock starts a
# squeal. Following the cycle in the damping finds where it ends, at a ``landing``: its slip no
# longer reaches the belt.

ends = []
for V in (speeds := np.linspace(0.1, 0.6, 6)):
    cycle = ss.find_cycle(block.replace(V=V), [0.0], [0.0])
    curve = ss.follow(cycle, "damping", (0.0, 3.0))
    ends.append(max(found.value for found in curve.bifurcations))  # the curve may turn back
print(curve)

# %%

V = np.linspace(0.05, 1.4, 300)
fig, ax = plt.subplots(figsize=(6, 4), layout="constrained")
ax.fill_between(V, 0, np.maximum(-law.slope(V), 0), color="#E69F00", label="squeals by itself")
ax.plot(speeds, ends, "o-", ms=4, label="squeals after a knock, below this line")
ax.set(xlabel="belt speed $V$", ylabel="damping $c$", xlim=(0.05, 1.4), ylim=(0, 2.5))
ax.legend()

# %%
# How sure is this?
# -----------------
# **Proved.** The cubics between the points rise and fall only where the points do.
#
# **Checked.** The curve against scipy's, to 1e-15; where a measured law begins to squeal, to 1e-9
# (``tests/mechanics/cycle/test_equilibria.py``); that just beyond its end the cycle is gone
# (``test_continuation.py``).
#
# **Fails, or is only evidence.** The program knows nothing of the errors of the measurement, nor
# of what friction does besides depending on speed: move the points by their error and see what
# changes.
