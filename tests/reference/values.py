"""Numbers of the paper's two systems to 30 digits, and the command that makes them.

    python -m tests.reference.values

prints the block of constants below; a test makes them again.
"""

from __future__ import annotations

from collections.abc import Iterator

from flint import arb

from .coulomb import Coulomb
from .law9 import Smooth
from .laws import PoppStelter
from .motion import System
from .precision import digits

COULOMB = {"alpha": 1.2, "beta": 1.3, "V": 0.0366, "mu": 0.22}
LAW9 = {"alpha": 1.208, "beta": 1.301, "V": 0.295, "gamma": 3.0}

# Period: where a search may start (the paper's figures 5 and 12).
NEAR = {"S1": (1, "-0.0399"), "U1": (1, "0.0886"), "U2": (1, "0.3716"), "S4": (4, "0.2774")}
NEAR_LAW9 = {"P1": (1, "0.3833")}
# Where the itinerary of the Coulomb map changes with a jump: brackets.
JUMPS_NEAR = ("-0.198", "-0.1103", "0.1707", "0.27913", "0.3018", "0.4494")

# --- made by the command above -------------------------------------------------------------
# (point, multiplier) of periodic orbits of the Coulomb map at V = 0.0366
COULOMB_ORBITS = {
    "S1": ("-0.0399143134102819060842513992877", "-0.56200852250274264490"),
    "U1": ("0.0886133238942024270908042580428", "9.1822953528306500699"),
    "U2": ("0.371625700599026140078387977522", "-1.7450118960516336918"),
    "S4": ("0.277393364786090965914287695813", "0.75077266610857124961"),
}
# (d, value to the left, value to the right) of the jumps of the same map
COULOMB_JUMPS = (
    (
        "-0.197978350595151402751149837873",
        "0.547058823529411791405017374204",
        "-0.410541983806020223618743735291",
    ),
    (
        "-0.110290547244720914504679110772",
        "-0.550686269510776246529020631425",
        "0.0462767565629161939809550221868",
    ),
    (
        "0.170700344096786724298098742245",
        "0.225792621676881340471812573659",
        "-0.356500103204797458324639400083",
    ),
    (
        "0.279135399094166590351992501933",
        "-0.253783283811809700534302866854",
        "-0.223535825814436508084199294499",
    ),
    (
        "0.301836704244552421959433136876",
        "-0.193298956621827268001100865495",
        "0.481264540357511200634254585434",
    ),
    (
        "0.449365513217784936458238190641",
        "0.236801880006916115590644293224",
        "-0.508235294117647078565522918854",
    ),
)
# (point, multiplier) of the law (9) map at alpha = 1.208
LAW9_ORBITS = {
    "P1": ("0.383295374038358345474145214085", "-0.93689573973324602543"),
}
# --- end -----------------------------------------------------------------------------------


def paper_coulomb() -> Coulomb:
    """Figure 5's system."""
    return Coulomb(**COULOMB)


def paper_law9() -> Smooth:
    """Figure 12's system."""
    return Smooth(LAW9["alpha"], LAW9["beta"], LAW9["V"], PoppStelter(LAW9["gamma"]))


def iterate(system: System, d: arb, period: int) -> arb:
    """f^period(d)."""
    for _ in range(period):
        d = system.motion(d).value
    return d


def orbit(system: System, guess: str, period: int) -> tuple[arb, arb]:
    """A point with f^period(d) = d by secants, and its multiplier by a central difference."""
    a, b = arb(guess), arb(guess) + arb("1e-6")
    residual_a = iterate(system, a, period) - a
    while abs(b - a) > arb("1e-34"):
        residual_b = iterate(system, b, period) - b
        a, b, residual_a = b, b - residual_b * (b - a) / (residual_b - residual_a), residual_b
        b = b.mid()
    h = arb("1e-12")
    plus, minus = iterate(system, b + h, period), iterate(system, b - h, period)
    return b, ((plus - minus) / (2 * h)).mid()


def jump(system: System, near: str) -> tuple[arb, arb, arb]:
    """d* where the itinerary changes, and the values to its left and right (1e-34 away)."""
    low, high = arb(near) - arb("1e-3"), arb(near) + arb("1e-3")
    left = system.motion(low).itinerary
    while high - low > arb("1e-40"):
        middle = ((low + high) / 2).mid()
        if system.motion(middle).itinerary == left:
            low = middle
        else:
            high = middle
    beside = arb("1e-34")
    return high, system.motion(low - beside).value, system.motion(high + beside).value


def lines() -> Iterator[str]:
    """The constants as source text."""
    coulomb, law9 = paper_coulomb(), paper_law9()
    yield "# (point, multiplier) of periodic orbits of the Coulomb map at V = 0.0366"
    yield "COULOMB_ORBITS = {"
    for name, (period, guess) in NEAR.items():
        point, multiplier = orbit(coulomb, guess, period)
        yield f'    "{name}": ("{digits(point)}", "{digits(multiplier, 20)}"),'
    yield "}"
    yield "# (d, value to the left, value to the right) of the jumps of the same map"
    yield "COULOMB_JUMPS = ("
    for near in JUMPS_NEAR:
        yield "    ("
        for part in jump(coulomb, near):
            yield f'        "{digits(part)}",'
        yield "    ),"
    yield ")"
    yield "# (point, multiplier) of the law (9) map at alpha = 1.208"
    yield "LAW9_ORBITS = {"
    for name, (period, guess) in NEAR_LAW9.items():
        point, multiplier = orbit(law9, guess, period)
        yield f'    "{name}": ("{digits(point)}", "{digits(multiplier, 20)}"),'
    yield "}"


if __name__ == "__main__":
    for line in lines():
        print(line)
