"""A block on a resting surface, shaken harmonically against dry friction.

Den Hartog (1931), Forced vibrations with combined Coulomb and viscous friction, Transactions of
the ASME 53: source not read; of the paper of the same title in the Philosophical Magazine 9 (1930)
the first page, which states the problem without damping. The formulas are derived anew
(docs/studies/den_hartog1931.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Den Hartog (1930, 1931)"
TITLE: Final = "Forced vibrations with combined viscous and Coulomb damping"
