"""An elastic friction damper on one mass and on a blade of three.

Griffin (1980), Friction damping of resonant stresses in gas turbine engine airfoils, Journal of
Engineering for Power 102: source not read. The formulas are derived anew
(docs/studies/friction_dampers.md).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Griffin (1980)"
TITLE: Final = "Friction damping of resonant stresses"
