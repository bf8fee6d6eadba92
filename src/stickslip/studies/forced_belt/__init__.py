"""One block on a moving belt, shaken harmonically.

Popp and Stelter (1990), Stick-slip vibrations and chaos, Philosophical Transactions of the Royal
Society A 332: source not read.
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Popp and Stelter (1990)"
TITLE: Final = "Stick-slip vibrations and chaos: one block, shaken"
