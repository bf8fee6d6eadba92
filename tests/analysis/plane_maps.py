"""Maps of the plane and of R^n of the literature, as functions of points."""

import math

import numpy as np

import stickslip as ss

TURN = 2 * math.pi


def points(*coordinates):
    return np.stack(np.broadcast_arrays(*coordinates), axis=-1)


def henon_points(z, a, b):
    """Images under the map of Hénon (1976)."""
    return points(1 - a * z[..., 0] ** 2 + z[..., 1], b * z[..., 0])


def henon(a=1.4, b=0.3, domain=((-2.5, 2.5), (-2.5, 2.5))):
    """Make the map of Hénon."""
    return ss.Map(henon_points, 2, parameters={"a": a, "b": b}, domain=domain)


def lozi_points(z, a, b):
    """Images under the map of Lozi (1978)."""
    return points(1 - a * np.abs(z[..., 0]) + z[..., 1], b * z[..., 0])


def lozi(a=1.7, b=0.5, domain=((-2.5, 2.5), (-2.5, 2.5))):
    """Make the map of Lozi."""
    return ss.Map(lozi_points, 2, parameters={"a": a, "b": b}, domain=domain)


def ikeda(u=0.9, domain=((-1.0, 2.2), (-2.5, 1.2))):
    """Make z' = 1 + u z exp(i (0.4 - 6 / (1 + |z|^2))) (Ikeda 1979; Hammel et al. 1985)."""

    def func(z, u):
        x, y = z[..., 0], z[..., 1]
        turn = 0.4 - 6 / (1 + x * x + y * y)
        c, s = u * np.cos(turn), u * np.sin(turn)
        return points(1 + c * x - s * y, s * x + c * y)

    return ss.Map(func, 2, parameters={"u": u}, domain=domain)


def standard(k=1.0):
    """Make p' = p + k sin t, t' = t + p' (Chirikov 1979) of the torus."""

    def func(z, k):
        p = z[..., 1] + k * np.sin(z[..., 0])
        return points(z[..., 0] + p, p)

    return ss.Map(func, 2, parameters={"k": k}, periodic=[TURN, TURN])


def grebogi(a=1.32, b=0.9, j=0.3):
    """Grebogi, McDonald, Ott and Yorke, Phys. Lett. A 99 (1983) 415."""

    def func(z, a, b, j):
        angle, x = z[..., 0], z[..., 1]
        turned = angle + a * np.sin(2 * angle) - b * np.sin(4 * angle) - x * np.sin(angle)
        return points(turned, -j * np.cos(angle))

    return ss.Map(
        func,
        2,
        parameters={"a": a, "b": b, "j": j},
        domain=[(0, TURN), (-0.5, 0.5)],
        periodic=[TURN, None],
    )


def newton(power=3.0):
    """Newton's method for z^3 = 1: in complex numbers, which are not recorded."""

    def func(x, power):
        z = x[..., 0] + 1j * x[..., 1]
        z = z - (z**power - 1) / (power * z ** (power - 1))
        return points(z.real, z.imag)

    return ss.Map(func, 2, parameters={"power": power})


def runge_kutta(rate, z, t, h, steps):
    """Carry states (..., n) over some steps of fourth order."""
    for k in range(steps):
        s = t + k * h
        k1 = rate(z, s)
        k2 = rate(z + h / 2 * k1, s + h / 2)
        k3 = rate(z + h / 2 * k2, s + h / 2)
        k4 = rate(z + h * k3, s + h)
        z = z + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return z


def duffing(force=0.2, damping=0.15):
    """x'' + damping x' - x + x^3 = force cos(t), once per period."""

    def func(z, force, damping):
        def rate(u, t):
            x, v = u[..., 0], u[..., 1]
            return points(v, force * np.cos(t) - damping * v + x - x**3)

        return runge_kutta(rate, z, 0.0, TURN / 60, 60)

    parameters = {"force": force, "damping": damping}
    return ss.Map(func, 2, parameters=parameters, domain=[(-2.2, 2.2), (-2.2, 2.2)])


def pendulum(third=1.0, damping=0.2, omega=0.8, height=0.2):
    """Three magnets (the third of another strength) under a pendulum, once per unit of time."""
    magnets = [(math.cos(k * TURN / 3), math.sin(k * TURN / 3)) for k in range(3)]

    def func(z, third, damping, omega, height):
        def rate(u, t):
            x, y, v, w = (u[..., k] for k in range(4))
            pull_x, pull_y = -(omega**2) * x - damping * v, -(omega**2) * y - damping * w
            for (a, b), strength in zip(magnets, (1.0, 1.0, third), strict=True):
                distance = ((x - a) ** 2 + (y - b) ** 2 + height**2) ** 1.5
                pull_x = pull_x - strength * (x - a) / distance
                pull_y = pull_y - strength * (y - b) / distance
            return points(v, w, pull_x, pull_y)

        return runge_kutta(rate, z, 0.0, 1 / 16, 16)

    parameters = {"third": third, "damping": damping, "omega": omega, "height": height}
    return ss.Map(func, 4, parameters=parameters, domain=[(-4, 4)] * 4)
