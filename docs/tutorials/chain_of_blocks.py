"""
A chain of blocks
=================

Any number of blocks on one belt: a chain of springs (Burridge and Knopoff 1967), or any symmetric
stiffness and damping. The event map of N blocks is a map of N - 1 distances: of two blocks, equal
or not, a map of the line, for which everything is there that the tutorials do with `TwoBlock`.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

chain = ss.Chain(static=[1, 1.3, 1.1], alpha=1.2, V=0.0366, friction=ss.Coulomb(mu=0.22))
f = ss.event_map(chain)
print(f([0.1, -0.2]), f.itinerary([0.1, -0.2]))
print(f.derivative([0.1, -0.2]))

# %%
# Orbits are found by Newton's method from many random distances. The list says how many of its
# orbits it may have missed, from how often the same ones came back.

orbits = ss.periodic_orbits(f, max_period=2)
print(orbits)

# %%
# A random cloud of distances, and where the map sends it.

rng = np.random.default_rng(1)
d = chain.sample_domain(400, rng)
result = f.evaluate(d)
for _ in range(30):
    result = f.evaluate(result.value)
fig, ax = plt.subplots(figsize=(5, 5), layout="constrained")
ax.plot(*d.T, ".", ms=2, color="0.7", label="at random")
ax.plot(*result.value.T, ".", ms=4, label="31 phases later")
ax.set(xlabel="$X_2 - X_1$", ylabel="$X_3 - X_2$", aspect="equal")
ax.legend()

# %%
# A longer chain in time: slips nucleate, spread and stop.

long_chain = ss.Chain(
    static=1 + 0.2 * np.random.default_rng(2).random(20),
    alpha=3.0,
    V=0.01,
    friction=ss.Coulomb(mu=0.5),
)
rng = np.random.default_rng(3)
x, v = long_chain.sample_state(rng)
motion = ss.simulate(long_chain, x, v, t_end=400)
t = np.linspace(0, 400, 2000)
fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
ax.plot(t, motion.x(t) + 0.3 * np.arange(20), lw=0.7, color="C0")
ax.set(xlabel="time", ylabel="displacement, a line a block")

# %%
# How sure is this?
# -----------------
# **Proved.** No event is stepped over on the steps that the program takes, up to rounding
# (:doc:`/theory/blocks`).
#
# **Checked.** Two blocks treated as a chain have the orbits of the complete list, to 1e-13
# (``tests/mechanics/eventmap/test_orbits_of_chains.py``); chains of three and five agree with 30
# digits on short motions (``tests/mechanics/eventmap/test_blocks_map.py``).
#
# **Fails, or is only evidence.** The list of orbits may have gaps, which it estimates; that a
# cloud has settled after 31 phases is only what the picture shows.
