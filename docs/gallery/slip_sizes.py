"""
How large slips are
===================

The share of slips of a chain with at least a given moment: a stream of slips, in flat memory.
"""

import itertools

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

limits = 1 + 0.1 * np.random.default_rng(2).random(30)
chain = ss.Chain(static=limits, alpha=10.0, V=0.01, friction=ss.Coulomb(mu=0.5))
rng = np.random.default_rng(3)
stream = ss.slips(chain, *chain.sample_state(rng), t_end=20_000)
moments = np.sort([slip.moment for slip in itertools.islice(stream, 300, 2300)])
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
ax.loglog(moments, 1 - np.arange(len(moments)) / len(moments))
ax.set(xlabel="moment $M$", ylabel="share of slips of at least $M$")
