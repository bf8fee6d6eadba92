"""
Reading a discontinuous bifurcation
===================================

Smooth bifurcation theory reads the future of an orbit off its multiplier. In a system with dry
friction an orbit can vanish with a multiplier anywhere. What does one read instead?
"""

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# A border collision has two multipliers, one for each side of the breakpoint that the orbit
# hits, and a gap, if the map jumps there. The skew tent shows all that can happen without a gap.


def tent(x, left, right, mu):
    return np.where(x < 0, left * x + mu, right * x + mu)


def tent_map(left, right):
    return ss.PiecewiseMap(
        tent,
        domain=(-3, 3),
        parameters={"left": left, "right": right, "mu": -0.5},
        breakpoints=[0.0],
    )


for left, right in ((0.5, -0.7), (0.5, -1.5), (1.6, -1.4), (1.5, 0.5)):
    (b,) = ss.bifurcations(tent_map(left, right), "mu", (-0.5, 0.5))
    print(f"slopes {left:+}, {right:+}: {b.outcome.text}")

# %%
# A persisting orbit, a doubling, chaos at once, a stable orbit out of nothing: the two slopes
# decide (Nusse and Yorke 1992). `predicted_outcome` is what they say, `outcome` what was seen.

(b,) = ss.bifurcations(tent_map(0.4, -4.0), "mu", (-0.5, 0.5))
print("predicted:", b.predicted_outcome.text)
print("seen:     ", b.outcome.text)

# %%
# In a mechanical system there is something more to read: *why* the map has a breakpoint there.
# At the paper's V* a stable orbit of period 4 meets a jump.

(collision,) = ss.bifurcations(ss.examples.coulomb(), "V", (0.0366, 0.0372))
print(collision)

# %%
# The mechanism names the block, the place and the event. The motion just before shows it: block 2
# slows down, almost reaches the belt's velocity, and slips on.

model = ss.examples.coulomb(V=collision.value - 1e-6)
f = ss.event_map(model)
orbit = min(ss.periodic_orbits(f, period=4), key=lambda o: abs(o.multiplier))
margins = f.evaluate(orbit.points).margin
closest = orbit.points[np.argmin(margins)]
motion = ss.simulate(model, d=closest, until="stick")
t = np.linspace(0, motion.t[-1], 2000)
fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
ax.plot(t, motion.v(t)[:, 1] - model.V)
ax.axhline(0, color="0.6", lw=0.8)
ax.set(xlabel="time", ylabel="$X_2' - V$")

# %%
# Along a second parameter the bifurcation is a curve, along which the cause may change.

curve = ss.follow(collision, "alpha", (1.198, 1.204), solve_for="V")
fig, ax = plt.subplots(figsize=(5, 3.5), layout="constrained")
curve.plot(ax=ax)

# %%
# How sure is this?
# -----------------
# **Proved.** What the two slopes at a corner lead to, in the normal form
# (:doc:`/theory/bifurcations`); that the paper's S4 meets its jump (:doc:`/theorems`).
#
# **Checked.** Predictions for random slopes against orbits followed by brute force
# (``tests/analysis/bifurcations/border_collision/test_skew_tent.py``); mechanisms against the
# motions on both sides (``tests/mechanics/eventmap/test_mechanism.py``).
#
# **Fails, or is only evidence.** The prediction holds close to the collision, how close it does
# not say: hence `outcome` beside it. At a jump the local slopes are not enough.
