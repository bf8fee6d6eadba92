"""
A lesson: why does a violin string, a brake, a fault stick and slip?
====================================================================

One notebook for one hour (download it at the end of the page). Each section ends with a question;
answers come last.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# 1. One block
# ------------
# A block on a belt, held by a spring. It rides until the spring pulls harder than static friction
# can hold, slips back, is caught again.

block = ss.Oscillator(V=0.1, friction=ss.Coulomb(mu=0.4))
motion = ss.simulate(block, [0.0], [0.1], t_end=60)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
motion.plot(ax=ax)

# %%
# *Question.* The slip lasts almost the same whatever the belt's speed, the stick does not. Why?
# Vary `V` and see.

# %%
# 2. What friction does not remember
# ----------------------------------
# The multiplier of the cycle is exactly zero: two motions that differ a little are the same motion
# after the next stick. Friction forgets.

cycle = ss.find_cycle(block, [0.0], [0.1])
print(cycle.period, cycle.multipliers)

# %%
# *Question.* How can a system that forgets so well be chaotic? (It takes a second block.)

# %%
# 3. Two blocks: a map of one number
# ----------------------------------
# When both blocks ride, only their distance counts. So the whole motion is a map of a line.

f = ss.event_map(ss.examples.law9(alpha=1.215))
fig, ax = plt.subplots(figsize=(5, 5), layout="constrained")
d = np.linspace(0.379, 0.390, 1500)
ax.plot(d, f(d), lw=1)
ax.plot(d, d, "k:", lw=0.8)
ax.set(xlabel="$d$", ylabel="next $d$")

# %%
# *Question.* Where are the fixed points, and which of them can be seen in an experiment?

# %%
# 4. Chaos
# --------
# Two motions that start 1e-9 apart.

orbits = f.iterate(np.array([0.38, 0.38 + 1e-9]), 60)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.semilogy(np.abs(orbits[1] - orbits[0]))
ax.set(xlabel="stick phases", ylabel="how far apart")
exponent = ss.lyapunov_exponent(f, 0.38, n=20_000)
print(exponent)

# %%
# *Question.* After how many phases is nothing left of a measurement with three digits?

# %%
# 5. The end of a stable motion
# -----------------------------
# In a smooth system a motion loses its stability before it vanishes. Here it does not.

(end,) = ss.bifurcations(ss.examples.coulomb(), "V", (0.0366, 0.0372))
print(end.value, end.multipliers)
print(end.mechanism)

speeds, multipliers, ways = np.linspace(0.0366, end.value, 13)[:-1], [], []
for V in speeds:
    f = ss.event_map(ss.examples.coulomb(V=V))
    (four,) = ss.periodic_orbits(f, period=4)
    (graze,) = [at for at in ss.breakpoints(f) if at.mechanism.startswith("block 2 grazes")]
    multipliers.append(four.multiplier)
    ways.append(np.abs(four.points - graze.d).min())
fig, (left, right) = plt.subplots(1, 2, figsize=(7, 3), layout="constrained")
left.plot(speeds, multipliers)
left.set(xlabel="$V$", ylabel="multiplier", ylim=(-1.1, 1.1))
right.plot(speeds, ways)
right.set(xlabel="$V$", ylabel="way to the jump", ylim=(0, None))

# %%
# *Question.* Which measurement on the machine could have warned you?

# %%
# Answers
# -------
# 1. A slip is about half a free oscillation: it lasts about pi. In a stick the belt carries the
#    block as far as the slip threw it back, about 2 (1 - mu): that takes 2 (1 - mu) / V.
# 2. Both blocks stick at a distance that the slips before have left: one number is remembered, and
#    the map from one to the next may stretch.
# 3. Where the curve meets the dotted line. Those with a slope between -1 and 1 attract: only these
#    are seen.
# 4. A thousandth grows to one when exp(exponent times phases) is 1000: after as many phases as the
#    next line prints.
# 5. Not how slowly disturbances die out: the multiplier stays far from 1 and -1. But how near block
#    2 comes to the speed of the belt without being caught: that way ends at 0.

print(2 * (1 - 0.4) / 0.1 + np.pi, cycle.period)
print(np.log(1000) / exponent.value)

# %%
# How sure is this?
# -----------------
# **Proved.** That a stick forgets: while a block rides, where it came from does not count.
# Where the stable motion of section 5 ends: by interval arithmetic, :doc:`/theorems`.
#
# **Checked.** The period of one block against its closed form, to 1e-13
# (``tests/mechanics/cycle/test_cycle.py``); the end of the stable motion, to 1e-13
# (``tests/mechanics/eventmap/test_bifurcations_of_models.py``).
#
# **Fails, or is only evidence.** Chaos is told by an exponent and its error. No program, this one
# included, can follow such a motion for long: see the picture of section 4.
