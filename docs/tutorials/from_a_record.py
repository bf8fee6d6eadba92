"""
From a tribometer's record to a squeal threshold
================================================

A pin on a spring rubs on a disc; a sensor writes its displacement against time, in metres and
seconds. Which friction law is it, and from which speed on is it quiet, with which error?
"""

from pathlib import Path
from tempfile import mkdtemp

import matplotlib.pyplot as plt
import numpy as np

import stickslip as ss

# %%
# The record
# ----------
# Mass, stiffness and static limit of the pin were measured before: 2 kg, 800 N/m, 4 N. They are the
# units of the model. The record here is synthetic, so that we know what is to be found: Stribeck
# friction, ``mu = 0.5``, ``speed = 0.3`` (30 mm/s), and a noise of 1 per cent.

units = ss.Units(m=2.0, k=800.0, fs1=4.0)
true = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.5, speed=0.3), damping=0.1)
t = np.linspace(0.0, 60.0, 600)
x = ss.simulate(true, [0.0], [0.0], t_end=60.0).x(t)[:, 0]
x += 0.01 * x.std() * np.random.default_rng(1).normal(size=t.size)
seconds, metres = units.to_physical("time", t), units.to_physical("displacement", x)
path = Path(mkdtemp(), "record.csv")
rows = [f"{a:.6f},{b:.9f}" for a, b in zip(seconds, metres, strict=True)]
path.write_text("\n".join(["t [s],x [m]", *rows]), encoding="utf-8")
print(path.read_text(encoding="utf-8")[:120])

# %%
# The file names its columns, we say which is which, and the units make the numbers those of the
# model. A gap, unsorted times or millimetres taken for metres would be an error that says so.

record = ss.read_measurements(path, {"t": "t [s]", "x": "x [m]"}, units=units)

# %%
# The fit
# -------
# The search starts from a guess that is a third off. Where the motion starts is estimated, too. The
# derivatives go through every stick and slip exactly.

guess = ss.Oscillator(V=0.2, friction=ss.Stribeck(mu=0.35, speed=0.4), damping=0.1)
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
    return float(units.to_physical("velocity", sliding.hopf_points[0].V))


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
#    stickslip fit record.csv --model mine.toml --parameters mu speed \
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
