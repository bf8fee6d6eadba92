"""One block on a belt whose friction falls with speed.

Leine, van Campen, de Kraker and van den Steen (1998), Stick-slip vibrations induced by alternate
friction models, Nonlinear Dynamics 16: source not read.
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Leine et al. (1998)"
TITLE: Final = "Stick-slip vibrations induced by alternate friction models"
