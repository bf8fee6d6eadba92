"""What the event maps of two and of many blocks share: settings, and what they tell of motions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from stickslip import status as status_codes
from stickslip.checks import whole_number
from stickslip.mechanics.eventmap.records import Controls, Outputs
from stickslip.mechanics.flow.engine import time_limit, tolerance
from stickslip.numerics.arrays import Floats
from stickslip.numerics.targets import available_threads
from stickslip.results.result import Result
from stickslip.results.table import numbered


class ModelMap:
    """The model and the settings of an event map; equal ones compare equal."""

    model: Any
    _settings: ClassVar[tuple[str, ...]] = ("rtol", "max_events", "max_time", "threads")

    def _set(self, rtol: float, max_events: int, max_time: float, threads: int | None) -> None:
        """Check the settings."""
        self.rtol = tolerance(rtol)
        self.max_events = whole_number("max_events", max_events, what="events of one motion")
        self.max_time = time_limit(max_time)
        self.threads = (
            available_threads()
            if threads is None
            else whole_number("threads", threads, what="processor cores used")
        )
        self._controls = Controls(self.rtol, self.max_events, self.max_time)

    @property
    def parameters(self) -> dict[str, float]:
        """Parameters of the model by name."""
        return dict(self.model.parameters)

    @property
    def settings(self) -> dict[str, Any]:
        """Keyword arguments that make this map from its model."""
        return {name: getattr(self, name) for name in self._settings}

    def replace(self, **changes: Any) -> Self:
        """Make the map of a changed model, with the same settings."""
        return type(self)(self.model.replace(**changes), **self.settings)  # type: ignore[call-arg]

    def __eq__(self, other: object) -> bool:
        """Equal models and settings."""
        if not isinstance(other, ModelMap) or type(self) is not type(other):
            return NotImplemented
        return bool((self.model, self.settings) == (other.model, other.settings))

    def __hash__(self) -> int:
        """Hash of the model and the settings."""
        return hash((self.model, *self.settings.values()))

    def _result(
        self, d: Floats, outputs: Outputs, shape: tuple[int, ...], slopes: tuple[int, ...]
    ) -> EventMapResult:
        """Shape what motions left: one number a motion by `shape`, derivatives by `slopes`."""
        shapes = {"value": d.shape, "derivative": slopes}
        told: dict[str, Any] = {
            name: array.reshape(shapes.get(name, shape))[()]
            for name, array in outputs._asdict().items()
        }
        return EventMapResult(**told, d=d)


@dataclass(frozen=True, eq=False, repr=False)
class EventMapResult(Result):
    """What `EventMap.evaluate` knows of each motion; every field is shaped like `d`.

    Attributes
    ----------
    value : ndarray of float
        d of the next global stick phase, units of f_s1 / k; NaN where there is none.
    derivative : ndarray of float
        Slope of the map, one-sided at a breakpoint.
    duration : ndarray of float
        Time between the two phases, units of sqrt(m / k).
    n_events : ndarray of int
        Changes of mode after the onset, the return to global stick included.
    label : ndarray of uint64
        Hash of the itinerary: equal on a branch.
    margin : ndarray of float
        Smallest clearance of the motion from another itinerary, >= 0: of lobes of w that
        turned back, of riders' forces at their extremes, of landings from the static limit
        and from a touch (w'), and between consecutive events of different blocks.
    status : ndarray of int
        `stickslip.status`; anything but OK goes with a NaN value.
    d : ndarray of float
        What was asked for: `value` is its image.
    """

    value: Floats
    derivative: Floats
    duration: Floats
    n_events: NDArray[np.int64]
    label: NDArray[np.uint64]
    margin: Floats
    status: NDArray[np.int64]
    d: Floats
    _drawn: ClassVar = ("d", "value")

    @property
    def message(self) -> NDArray[np.str_]:
        """What each status means and what to do about it."""
        return np.asarray(status_codes.MESSAGES)[self.status]

    def __repr__(self) -> str:
        """Count the statuses, then show the first motions as a table."""
        statuses = np.atleast_1d(self.status).ravel()
        names, counts = np.unique(statuses, return_counts=True)
        lines = [
            "EventMapResult: "
            + ", ".join(f"{c} {status_codes.NAMES[n]}" for n, c in zip(names, counts, strict=True))
        ]
        lines += self._rows(statuses.size) if statuses.size else []
        if statuses.size > 8:
            lines.append(f"... {statuses.size - 8} more")
        return "\n".join(lines)

    def _rows(self, n: int) -> list[str]:
        """Lines of the first motions; of many blocks the differences and the largest slope."""
        value, slope = (np.reshape(field, (n, -1))[:8] for field in (self.value, self.derivative))
        others = (self.duration, self.n_events, self.margin)
        rest = zip(*(np.atleast_1d(field).ravel()[:8] for field in others), strict=True)
        if value.shape[1] == 1:
            head = "       value  derivative    duration  events    margin"
            cells = [f"{v[0]:12.8g}{s[0]:12.5g}" for v, s in zip(value, slope, strict=True)]
        else:
            head = "  max |slope|    duration  events    margin  value"
            cells = [f"{np.abs(s).max():13.5g}" for s in slope]
        lines = [
            f"{cell}{t:12.6g}{k:8d}{m:10.2g}" for cell, (t, k, m) in zip(cells, rest, strict=True)
        ]
        if value.shape[1] > 1:
            shown = (", ".join(f"{x:.8g}" for x in row[:4]) for row in value)
            more = ", ..." if value.shape[1] > 4 else ""
            lines = [f"{line}  {text}{more}" for line, text in zip(lines, shown, strict=True)]
        return [head, *lines]

    def _columns(self) -> dict[str, Any]:
        facts = ("duration", "n_events", "label", "margin", "status")
        n = np.size(self.status)
        return {
            **numbered("d", np.reshape(self.d, (n, -1))),
            **numbered("value", np.reshape(self.value, (n, -1))),
            **numbered("derivative", np.reshape(self.derivative, (n, -1))),
            **{name: np.ravel(getattr(self, name)) for name in facts},
            "status_name": np.asarray(status_codes.NAMES)[np.ravel(self.status)],
        }
