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
# Force over the static limit, against slip speed in units of ``f_s / sqrt(k m)``. (`ss.Units` converts
# to and from metres and seconds.) The cubics between the points rise and fall only as the points do.

speed = [0.0, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0, 1.5, 2.0]
force = [0.98, 0.86, 0.76, 0.63, 0.51, 0.45, 0.44, 0.46, 0.50]
law = ss.TabulatedFriction(speed=speed, force=force)
s = np.linspace(0, 2, 400)
fig, ax = plt.subplots(figsize=(5, 3))
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
fig, ax = plt.subplots(figsize=(7, 3))
motion.plot(ax=ax)

# %%
# The squeal map
# --------------
# Over belt speed and damping: where steady sliding is unstable (squeal), and where it is stable.
# A stick-slip cycle may live on beside stable sliding: hysteresis, a squeal that starts with a knock.

speeds, dampings = np.linspace(0.02, 1.4, 70), np.linspace(0.0, 1.5, 60)
unstable = np.empty((dampings.size, speeds.size))
for i, c in enumerate(dampings):
    for j, V in enumerate(speeds):
        unstable[i, j] = law.slope(V) + c < 0
fig, ax = plt.subplots(figsize=(6, 4))
ax.contourf(speeds, dampings, unstable, levels=[-0.5, 0.5, 1.5], colors=["white", "#E69F00"])
ax.set(xlabel="belt speed $V$", ylabel="damping $c$")
ax.text(0.15, 0.3, "squeal")

# %%
# Following the cycle in the damping finds the other edge: how strong a damper must be before the
# stick-slip motion itself disappears.

branch = ss.continue_cycle(cycle, block, "damping", (0.0, 2.0))
fig, ax = plt.subplots(figsize=(6, 4))
branch.plot(ax=ax)
for b in branch.bifurcations:
    print(b)
