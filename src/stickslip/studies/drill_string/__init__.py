"""A drill string of two discs: a motor turns the upper one, rock rubs on the lower one.

Mihajlovic, van Veggel, van de Wouw and Nijmeijer (2004), Analysis of friction-induced limit
cycling in an experimental drill-string system, ASME Journal of Dynamic Systems, Measurement, and
Control 126; de Bruin, Doris, van de Wouw, Heemels and Nijmeijer (2009), Automatica 45: sources
not read. The formulas are derived anew (docs/studies/drill_string.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Mihajlovic et al. (2004)"
TITLE: Final = "Friction-induced limit cycling in a drill-string system"
