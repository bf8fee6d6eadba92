"""The contract of observables: settings, and the variables that they record."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from stickslip.checks import MOST_VALUES, whole_number

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from stickslip.sweeps.job import Points
    from stickslip.sweeps.system import Run

Columns: TypeAlias = "dict[str, NDArray[Any]]"


@dataclass(frozen=True)
class Output:
    """One variable of a store: ``dims`` and ``sizes`` are those besides the axes."""

    name: str
    dtype: str
    long_name: str
    dims: tuple[str, ...] = ()
    sizes: tuple[int, ...] = ()
    flags: Mapping[int, str] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Observable:
    """Settings of something to record.

    Attributes
    ----------
    name : str
        What plan files call it.
    needs : tuple of str
        What it asks of a system, of that which some lack (`System.lacks`).
    """

    name: ClassVar[str]
    needs: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        """Check that counts are whole numbers in range."""
        for each in fields(self):
            if limits := each.metadata.get("limits"):
                name = f"{each.name} of {self.name}"
                value = whole_number(name, getattr(self, each.name), limits[0], at_most=limits[1])
                object.__setattr__(self, each.name, value)

    def outputs(self) -> tuple[Output, ...]:
        """Return the variables that `compute` returns."""
        raise NotImplementedError

    def runs(self) -> dict[Run, int]:
        """Return the orbits that are needed, and how many of their last points."""
        return {}

    def compute(self, points: Points) -> Columns:
        """Return each variable by name, shape (grid points, *sizes)."""
        raise NotImplementedError

    def identity(self) -> dict[str, Any]:
        """Describe the observable in values that JSON can hold."""
        return {"name": self.name, **asdict(self)}


def whole(default: int, least: int = 1, most: int = MOST_VALUES) -> Any:
    """Make a setting that is a whole number in a range."""
    return field(default=default, metadata={"limits": (least, most)})
