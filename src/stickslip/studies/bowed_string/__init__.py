"""A bowed string: Helmholtz motion, its neighbours, and Schelleng's limits of the bow force.

Schelleng (1973), The bowed string and the player, Journal of the Acoustical Society of America
53: source not read; his limits as derived by Woodhouse, euphonics.org, section 9.3.1 (read).
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Schelleng (1973)"
TITLE: Final = "The bowed string and the player"
