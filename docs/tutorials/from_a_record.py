"""
From a tribometer's record to a squeal threshold
================================================

A pin on a spring rubs on a disc and sticks and slips; a file holds time, displacement and force.
Which friction law is it, and from which speed on is it quiet, with which error?
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# The record
# ----------
# Mass, stiffness, damper and static limit of the pin, and the speed of the disc, were measured
# before. Mass, stiffness and limit are the units of the model. A file in millimetres wants tonnes,
# N/mm, N s/mm and mm/s, and nothing else changes.

m, k, c, fs1, disc = 2.0, 800.0, 4.0, 4.0, 0.020  # kg, N/m, N s/m, N, m/s
units = ss.Units(m=m, k=k, fs1=fs1)
u = units.scale("velocity")  # m/s
setup = {"V": disc / u, "damping": c / np.sqrt(k * m)}

# %%
# The record here is synthetic, so that we know what is to be found: Stribeck friction, ``mu =
# 0.5``, ``speed = 0.3`` (times ``u``: 30 mm/s), and a noise of 1 per cent. The sensor counts from
# a place 7 mm off.

true = ss.Oscillator(friction=ss.Stribeck(mu=0.5, speed=0.3), **setup)
t = np.linspace(0.0, 60.0, 600)
motion = ss.simulate(true, [0.0], [0.0], t_end=60.0)
x, force = motion.x(t)[:, 0], motion.friction(t)[:, 0]
x += 0.01 * x.std() * np.random.default_rng(1).normal(size=t.size)
metres = 0.007 + units.to_physical("displacement", x)
columns = units.to_physical("time", t), metres, units.to_physical("force", force)
path = Path(mkdtemp(), "record.csv")
rows = [f"{a:.6f},{b:.9f},{f:.3f}" for a, b, f in zip(*columns, strict=True)]
path.write_text("\n".join(["t [s],x [m],F [N]", *rows]), encoding="utf-8")
print(path.read_text(encoding="utf-8")[:120])

# %%
# The file names its columns, we say which is which, and the units make the numbers those of the
# model. A gap, unsorted times or millimetres taken for metres would be an error that says so. The
# force is not needed. ``free_zero`` because nobody knows at which number the spring is slack: that
# is estimated, too. Where it is known errors are a fifth of those below.

record = ss.read_measurements(path, {"t": "t [s]", "x": "x [m]"}, units=units, free_zero=True)

# %%
# The fit
# -------
# The search starts from a guess that is a third off. Where the motion starts is estimated, too. The
# derivatives go through every stick and slip exactly.

guess = ss.Oscillator(friction=ss.Stribeck(mu=0.35, speed=0.4), **setup)
found = ss.fit(guess, record, ["mu", "speed"])
print(found)

# %%

fig, ax = plt.subplots(figsize=(7, 3), layout="constrained")
found.plot(ax=ax)

# %%
# Which law?
# ----------
# Another law that falls with the speed, on the same record. Akaike's criterion is lower for the law
# that made the data; ten less is much. A single record is not cut: nothing is left out.

other = ss.fit(guess.replace(friction=ss.PoppStelter(gamma=3.0)), record, ["gamma", "delta"])
print(ss.compare_fits([found, other]))

# %%
# The threshold
# -------------
# Steady sliding is stable from the belt speed on at which the law no longer falls faster than the
# damper can follow. `predict` carries the errors of the estimates there.


def threshold(model):
    """Belt speed in m/s above which steady sliding is stable."""
    (sliding,) = ss.equilibria(model)
    return u * sliding.hopf_points[0].V


quiet = found.predict(threshold)
print(f"quiet from {1e3 * quiet.value:.2f} +- {1e3 * quiet.standard_error:.2f} mm/s")
print(f"true: {1e3 * threshold(true):.2f} mm/s")
worse = other.predict(threshold)
print(f"by the other law: {1e3 * worse.value:.2f} +- {1e3 * worse.standard_error:.2f} mm/s")

# %%
# The threshold lies far above the belt's 20 mm/s, beyond the slips of the record: each law is
# extrapolated, and no error of one law tells of another. Inside the record both are nearly the
# same, and their errors thinner than a line. A second record at a higher speed is worth more than a
# longer one.

s = np.linspace(0.0, 1.5, 200)
speed = 1e3 * units.to_physical("velocity", s)
slowest = ss.simulate(found.model, [0.0], [0.0], t_end=60).v(t).min()
fig, ax = plt.subplots(figsize=(6, 3.5), layout="constrained")
fastest_slip = 20.0 - 1e3 * units.to_physical("velocity", slowest)
ax.axvspan(0.0, fastest_slip, color="0.93", label="slip speeds of the record")
for fitted, told, name, color in (
    (found, quiet, "Stribeck", "#0072B2"),
    (other, worse, "Popp and Stelter", "#D55E00"),
):
    force = units.to_physical("force", fitted.model.friction.force(s))
    ax.plot(speed, force, color=color, label=name)
    ax.axvline(1e3 * told.value, color=color, ls=":", label="quiet from here on, if so")
ax.plot(speed, units.to_physical("force", true.friction.force(s)), "k--", lw=1, label="true")
ax.set(xlabel="slip speed, mm/s", ylabel="friction, N", xlim=(0, 150), ylim=(1, 4.1))
ax.legend(loc="upper center", bbox_to_anchor=(0.62, 1.0))

# %%
# The same from a shell, with the guess in ``mine.toml``:
#
# .. code-block:: none
#
#    stickslip fit record.csv --model mine.toml --parameters mu speed --free-zero \
#        --columns "t=t [s]" "x=x [m]" --units m=2 k=800 fs1=4 --out fitted
#
# How sure is this?
# -----------------
# **Proved.** Nothing.
#
# **Checked.** That true parameters lie in the intervals told, and that the error of the threshold
# is that of its closed form (``tests/identification/test_fit.py``).
#
# **Fails, or is only evidence.** A mass, a stiffness or a static limit that is wrong makes the law
# wrong; their errors are not in those above.
