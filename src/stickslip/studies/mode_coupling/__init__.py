"""A brake that squeals because two of its modes couple through friction.

Hoffmann, Fischer, Allgaier and Gaul (2002), A minimal model for studying properties of the
mode-coupling type instability in friction induced oscillations, Mechanics Research Communications
29: source not read; the formulas are derived anew (docs/studies/mode_coupling.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Hoffmann et al. (2002)"
TITLE: Final = "A minimal model of the mode-coupling type instability"
