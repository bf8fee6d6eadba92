"""How near, how well and how many: numbers that mean the same in several rooms of analysis.

Shares are of a natural scale: a domain's width, a parameter's range, the size of values, and 1
beside slopes, multipliers and scaled unknowns. Finer than all of these are roundings of one place,
`stickslip.analysis.maps.protocol.SAME`.
"""

from __future__ import annotations

from typing import Final

NEARBY: Final = 1e-3  # a guess may be so far off; what belongs to a place is looked for so close
CLOSE: Final = 1e-6  # what was found in two ways, each with errors of its own, agrees so well
HALF_DIGITS: Final = 1e-7  # what differences tell, and steps over which a map is straight
FINE: Final = 1e-9  # what was solved for, or made to fit, is known so well
ORBIT_NOISE: Final = 1e-10  # roundings that a long orbit gathers: no places so close differ

PROBED: Final = 64  # points at which two ways to compute the same are compared
HALVINGS: Final = 16  # of cells, or of distances: what is left is too small to matter
IN_A_ROW: Final = 10  # agreements, one after the other, that are no chance
FEW_SHOWN: Final = 3  # periods, or multipliers, in a sentence

BLOCK: Final = 256  # steps of orbits, or images of intervals, until they are looked at, at first
RECOGNISED: Final = 64  # periods of cycles, and orders of preimages, up to which these are known
CELLS: Final = 256  # of a domain, along each axis: what visits the same ones is one motion
SAMPLE: Final = 256  # points, or starts, that stand for all of an attractor or basin ...
FEW: Final = 32  # ... and where each of them costs more
PASSING: Final = (
    0.05  # of a domain's width: an orbit that comes so near may belong to a cycle there
)
ON_CURVE: Final = (
    1e-4  # beside a curve: what is looked for is so close, and moves so short are none
)
DIFFERENCE: Final = 1e-5  # of a scale: steps of differences, where their errors matter little
