"""What every branch followed along one parameter has in common."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from stickslip.checks import finite_number


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

    def _checked_value(self, given: dict[str, Any]) -> float:
        """Return the value of the varied parameter, given by its name, if the branch reaches it."""
        name = self.parameter
        if list(given) != [name]:
            raise ValueError(
                f"at({', '.join(given)}): the branch is one along {name}; "
                f"give its value as at({name}=...)."
            )
        value = finite_number(name, given[name])
        low, high = self.values.min(), self.values.max()
        if not low <= value <= high:
            raise ValueError(
                f"{name} = {value:.15g} is outside the branch, [{low:.15g}, {high:.15g}]."
            )
        return value

    def __len__(self) -> int:
        """Return the number of solutions computed."""
        return len(self.values)
