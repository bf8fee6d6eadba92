"""An axis with a PID controller that hunts about its target because friction holds more at rest.

Armstrong-Helouvry and Amin (1996), PID control in the presence of static friction, Automatica 32;
Hensen, van de Molengraft and Steinbuch (2003), Friction induced hunting limit cycles, Automatica
39; Canudas de Wit et al. (1995), for the law named LuGre: sources not read. The formulas are
derived anew (docs/studies/hunting_axis.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Armstrong and Amin (1996)"
TITLE: Final = "PID control in the presence of static friction"
