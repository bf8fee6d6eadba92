"""
A friction law of your own
==========================

A law is the kinetic friction over the static limit, as a function of the slip speed ``s >= 0``. One
line of Python is compiled into the engine, with its derivatives, and named parameters can be varied
and continued like those of the model.
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

law = ss.friction_law(
    lambda s, fall, s0, rise: fall + (1 - fall) / (1 + s / s0) + rise * s,
    parameters={"fall": 0.4, "s0": 0.2, "rise": 0.1},
)
s = np.linspace(0, 2, 200)
fig, ax = plt.subplots(figsize=(5, 3), layout="constrained")
ax.plot(s, law.force(s))
ax.set(xlabel="slip speed $s$", ylabel="$F(s)$", ylim=(0, 1.05))

# %%
# Written as text, it is the same law, and fits into a model file and on the command line.

same = ss.friction_law("fall + (1 - fall) / (1 + s / s0) + rise * s", parameters=dict(law.values))
print(same, same.formula == law.formula)

# %%
# From here on it is like any other law.

model = ss.TwoBlock(alpha=1.2, beta=1.3, V=0.1, friction=law)
f = ss.event_map(model)
orbits = ss.periodic_orbits(f)
print(orbits)

# %%
# How a value changes with a parameter of the law is known exactly, not by a difference:

print(f.parameter_derivative(0.1, "fall"))

# %%
# A motion, at any time you ask for.

motion = ss.simulate(model, d=0.1, t_end=60)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
motion.plot(ax=ax)

# %%
# And where the fixed point becomes unstable as the law changes:

curve = ss.follow(orbits[0], "fall", (0.2, 0.6))
print(curve)

# %%
# How sure is this?
# -----------------
# **Proved.** Derivatives, in parameters too, follow from the formula by the rules of calculus, not
# by differences.
#
# **Checked.** Laws written by users against mpmath: values to 4e-15, slopes to 1e-13
# (``tests/contracts/test_friction_laws.py``).
#
# **Fails, or is only evidence.** A function that branches on ``s`` has no formula: it still
# works, by another stepper and with slopes by differences, good to 1e-9 in the tests. See
# :doc:`/theory/friction-laws`.
