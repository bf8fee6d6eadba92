"""The paper's Coulomb system on faster belts, where motions need not stick together again.

Galvanetto (2001) states the equations and stays at small V; the rest is computed here.
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "After Galvanetto (2001)"
TITLE: Final = "Two blocks on faster belts: where the event map ceases to exist"
