"""A long chain of blocks whose friction falls with speed: slips of all sizes.

Carlson and Langer (1989), Physical Review A 40, 6470: first page and abstract read. Carlson,
Langer, Shaw and Tang (1991), Physical Review A 44, 884, whence the law of friction with a drop:
source not read. De Sousa Vieira (1996), cond-mat/9602108: abstract. Clauset, Shalizi and Newman
(2009), SIAM Review 51, 661, on fitting power laws: abstract; its estimator is the usual one.
"""

from __future__ import annotations

from typing import Final

SOURCE: Final = "Carlson and Langer (1989)"
TITLE: Final = "Mechanical model of an earthquake fault: a Burridge-Knopoff chain of 200 blocks"
