"""
A map of a parameter plane
==========================

The Lyapunov exponent over belt speed and coupling, with the exact curve on which the stable orbit
ends. Sweeps use all cores, and go on where they were stopped.
"""

import tempfile

import stickslip as ss
from stickslip.plot.sweep_map import sweep

model = ss.examples.coulomb()
(collision,) = ss.bifurcations(model, "V", (0.0366, 0.0372))
plane = {"V": (0.0366, 0.0374), "alpha": (1.198, 1.204)}
curve = ss.follow(collision, "alpha", plane["alpha"], solve_for="V")
swept = ss.sweep(
    model,
    {"V": (*plane["V"], 36), "alpha": (*plane["alpha"], 24)},
    observables=[ss.observables.LyapunovExponent(transient=300, n=300)],
    store=tempfile.mkdtemp() + "/plane.zarr",
    d=-0.4676,  # on the orbit of period 4
)
sweep(swept, curves=(curve,))
