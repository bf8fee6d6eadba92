"""What every branch followed along one parameter has in common."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ["AlongParameter"]


class AlongParameter:
    """A curve of solutions whose ``parameters`` holds the one that varies, by its name."""

    parameters: dict[str, NDArray[np.float64]]

    @property
    def parameter(self) -> str:
        """Name of the varied parameter."""
        (name,) = self.parameters
        return name

    @property
    def values(self) -> NDArray[np.float64]:
        """Values of the varied parameter, shape (m,), in order along the branch."""
        return self.parameters[self.parameter]

    def __len__(self) -> int:
        """Return the number of solutions computed."""
        return len(self.values)
