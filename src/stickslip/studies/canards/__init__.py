"""Stiction where it is not unique: a shaken block whose needed force touches its limit.

Bossolini, Brøns and Kristiansen (2017), Canards in stiction: on solutions of a friction oscillator
by regularization, SIAM Journal on Applied Dynamical Systems 16: source not read; the formulas are
derived anew (docs/studies/canards.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Bossolini et al. (2017)"
TITLE: Final = "Canards in stiction"
