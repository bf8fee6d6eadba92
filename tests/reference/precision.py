"""How exact the oracles are: one place for the precision and for what "equal" means."""

from __future__ import annotations

from flint import arb, ctx

PRECISION = 320  # bits, 96 digits
ctx.prec = PRECISION

# A signal is at its limit, exactly, when it is closer than this: far below what doubles can tell
# apart (1e-16) and far above what the oracles lose (Coulomb 1e-90, Taylor steps 1e-48, each times
# the growth of errors).
TIE = arb("1e-36")
# A first root is accepted below this and then polished; smaller than TIE, so that what is found
# as a root is also recognised as a tie when the next phase starts.
ROOT = arb("1e-40")
# What Newton's last step may still be, relative to the time scale 1.
POLISHED = arb("1e-85")

ZERO = arb(0)
ONE = arb(1)


def exact(value: object) -> arb:
    """The number itself: a double is taken exactly, text to full precision."""
    return value if isinstance(value, arb) else arb(value)


def digits(value: arb, n: int = 30) -> str:
    """``value`` as a decimal with ``n`` digits."""
    return str(value.mid().str(n, radius=False))
