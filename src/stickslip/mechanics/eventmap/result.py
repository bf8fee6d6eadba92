"""What the motions from points of an event map leave, as a result."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from stickslip import status as status_codes
from stickslip.numerics.arrays import Floats
from stickslip.results.result import Result
from stickslip.results.table import aligned, listed, numbered, per_point


@dataclass(frozen=True, eq=False, repr=False)
class EventMapResult(Result):
    """What ``evaluate`` knows of each motion; on the line every field is shaped like `d`.

    Attributes
    ----------
    value : ndarray of float
        d of the next global stick phase, units of f_s1 / k; NaN where there is none.
    derivative : ndarray of float
        Slope of the map, one-sided at a breakpoint; the Jacobian of more than two blocks.
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
        lines += self._rows() if statuses.size else []
        if statuses.size > 8:
            lines.append(f"... {statuses.size - 8} more")
        return "\n".join(lines)

    def _rows(self) -> list[str]:
        """Lines of the first motions; of many blocks the differences and the largest slope."""
        shape = np.shape(self.status)
        value, slope = (per_point(field, shape)[:8] for field in (self.value, self.derivative))
        facts = (self.duration, self.n_events, self.margin)
        formats = ("{:.6g}", "{:d}", "{:.2g}")
        rest = [
            [text.format(x) for x in np.atleast_1d(fact).ravel()[:8]]
            for fact, text in zip(facts, formats, strict=True)
        ]
        head = ("duration", "events", "margin")
        values = [listed((f"{x:.8g}" for x in row), 4) for row in value]
        if value.shape[1] == 1:
            slopes = [f"{s:.5g}" for s in slope[:, 0]]
            rows = zip(values, slopes, *rest, strict=True)
            return aligned([("value", "derivative", *head), *rows], ">>>>>")
        slopes = [f"{s:.5g}" for s in np.abs(slope).max(axis=1)]
        rows = zip(slopes, *rest, values, strict=True)
        return aligned([("max |slope|", *head, "value"), *rows], ">>>><")

    def _columns(self) -> dict[str, Any]:
        facts = ("duration", "n_events", "label", "margin", "status")
        shape = np.shape(self.status)
        return {
            **numbered("d", per_point(self.d, shape)),
            **numbered("value", per_point(self.value, shape)),
            **numbered("derivative", per_point(self.derivative, shape)),
            **{name: np.ravel(getattr(self, name)) for name in facts},
            "status_name": np.asarray(status_codes.NAMES)[np.ravel(self.status)],
        }
