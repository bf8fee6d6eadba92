"""How near, how well and how many: numbers that mean the same in several rooms of analysis.

Shares are of a natural scale: a domain's width, a parameter's range, the size of values, and 1
beside slopes, multipliers and scaled unknowns. Finer than all of these are roundings of one place,
`stickslip.analysis.maps.protocol.SAME`.
"""

from __future__ import annotations

from typing import Final

# How far off something may be.
PASSING: Final = 0.05  # an orbit that comes so near may belong to a cycle, or an event, there
ON_THE_WAY: Final = 0.02  # what settles, or moves along a parameter, may have so far to go
NEARBY: Final = 1e-3  # a guess may be so far off; what belongs to a place is looked for so close
ON_CURVE: Final = 1e-4  # beside a curve: looked for so close, and moves so short are none
DIFFERENCE: Final = 1e-5  # steps of differences, where their errors matter little

# How well something is known.
CLOSE: Final = 1e-6  # what was found in two ways, each with errors of its own, agrees so well
HALF_DIGITS: Final = 1e-7  # what differences tell, and steps over which a map is straight
FINE: Final = 1e-9  # what was solved for, or made to fit, is known so well
ORBIT_NOISE: Final = 1e-10  # roundings that a long orbit gathers: no places so close differ

# How many.
BLOCK: Final = 256  # steps of orbits, or images of intervals, until they are looked at, at first
SAMPLE: Final = 256  # points, or starts, that stand for all of an attractor or basin ...
FEW: Final = 32  # ... and where each of them costs more
CELLS: Final = 256  # of a domain, along each axis: what visits the same ones is one motion
RECOGNISED: Final = 64  # periods of cycles, and orders of preimages, up to which these are known
PROBED: Final = 64  # points at which two ways to compute the same are compared
ROUNDS: Final = 64  # of a search that goes on where the last ones ended, at most
HALVINGS: Final = 16  # of cells, or of distances: what is left is too small to matter
IN_A_ROW: Final = 10  # agreements, one after the other, that are no chance
LISTED: Final = 8  # points, or rows, in a text that stands for all ...
FEW_SHOWN: Final = 3  # ... and periods, or multipliers, in a sentence
