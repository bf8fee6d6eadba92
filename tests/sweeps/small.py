"""Small sweeps that tests, and the processes that tests start, run."""

import sys
import time

import numpy as np

import stickslip as ss

AXES = {"V": (0.03, 0.05, 12), "alpha": (1.1, 1.3, 10)}
SHORT = {"transient": 40, "n": 64, "max_period": 16}
CHUNKS = {"V": 4, "alpha": 3}


def observables():
    return [
        ss.observables.Attractor(**SHORT),
        ss.observables.LyapunovExponent(**SHORT),
        ss.observables.OrbitPoints(**SHORT, count=3),
    ]


def run(store, **more):
    settings = {"axes": AXES, "observables": observables(), "chunks": CHUNKS, "threads": 1}
    return ss.sweep(ss.examples.coulomb(), store=store, **{**settings, **more})


def logistic(x, r):
    return r * x * (1 - x)


SCALE = 1.0


def damped(x, r):
    return SCALE * r * x * (1 - x)


def scaled(scale):
    def map_of(x, r, scale=scale):
        return scale * r * x * (1 - x)

    return map_of


class Family:
    def member(self, x, r):
        return r * x * (1 - x)


def tent(x, s):
    return s * np.minimum(x, 1 - x)


def second_iterate(f, d):
    return f(f(d))


def fails_somewhere(f, d):
    if f.parameters["V"] > 0.045:
        raise ArithmeticError("on purpose")
    return d


def both(f, d):
    return [d, f(d)]


def half(f, d):
    return 0.5


def start_of(f, d):
    return d


def mass_of(model, d):
    return model.plant.mass[0]


def many_slow(f, d):
    time.sleep(0.004)
    return f(d)


def run_slowly(store, **more):
    """Take a second or two, so that there is time to be killed."""
    wanted = [*observables(), ss.observables.Function(function="tests.sweeps.small:many_slow")]
    return run(store, **{"observables": wanted, "chunks": {"V": 3, "alpha": 2}, **more})


if __name__ == "__main__":  # a process to be killed
    run_slowly(sys.argv[1])
