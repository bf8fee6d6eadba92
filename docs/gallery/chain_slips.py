"""
Slips of a chain
================

Which of 40 blocks slip when. Blocks that slip together are one event; the size of its dot is its
moment, how far the belt left these blocks behind.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

limits = 1 + 0.1 * np.random.default_rng(2).random(40)
chain = ss.Chain(static=limits, alpha=3.0, V=0.01, friction=ss.Coulomb(mu=0.5))
x, v = chain.sample_state(np.random.default_rng(3))
motion = ss.simulate(chain, x, v, t_end=400)
fig, ax = plt.subplots(figsize=(7, 4), layout="constrained")
for slip in motion.slips:
    blocks = np.array(slip.blocks)
    ax.vlines(slip.start, blocks.min() - 0.5, blocks.max() + 0.5, color="0.75", lw=1)
    ax.plot(slip.start, blocks.mean(), "o", ms=2 + 3 * np.sqrt(slip.moment), color="C0", alpha=0.6)
ax.set(xlabel="time", ylabel="block")
