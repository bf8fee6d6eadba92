"""Two blocks on a belt that hardly moves, as seismologists study them.

Nussbaum and Ruina (1987), Pure and Applied Geophysics 125: source not read. Huang and Turcotte
(1990), Geophysical Research Letters 17, and (1992), Pure and Applied Geophysics 138; Narkounskaia
and Turcotte (1992), Geophysical Journal International 111: of the last two the abstracts.
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Huang and Turcotte (1990, 1992)"
TITLE: Final = "Two blocks as V -> 0: symmetry and chaos"
