"""Lists of bifurcations as plain data, for programs."""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

from stickslip.analysis.bifurcations.outcome import disagreement

if TYPE_CHECKING:
    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.bifurcation import Bifurcation, BifurcationList, Cascade
    from stickslip.analysis.bifurcations.outcome import Outcome
    from stickslip.analysis.orbits.orbit import PeriodicOrbit

SCHEMA: Final = 1


def document(found: BifurcationList, *, title: str = "", picture: str = "") -> dict[str, Any]:
    """Turn a list of bifurcations into a document; numbers that are not finite are None."""
    content = {
        "schema": SCHEMA,
        "kind": "bifurcation report",
        "version": version("stickslip"),
        "title": title,
        "parameter": found.parameter,
        "range": found.range,
        "parameters": found.parameters,
        "searched": {
            "max_period": found.max_period,
            "window": found.window,
            "n_lists": found.n_lists,
        },
        "bifurcations": [_as_data(item) for item in found],
        "cascades": [_cascade_data(cascade) for cascade in found.cascades],
        "unresolved": [
            {"reason": u.reason, "lo": u.lo, "hi": u.hi, "period": u.period, "x": u.x}
            for u in found.unresolved
        ],
        "picture": picture,
    }
    plain: dict[str, Any] = _finite(content)
    return plain


def agrees(item: Bifurcation) -> bool | None:
    """Whether the outcome observed is the one predicted; None without either of them."""
    if item.outcome is None or item.predicted_outcome is None:
        return None
    return not disagreement(item.predicted_outcome, item.outcome)


def _as_data(item: Bifurcation) -> dict[str, Any]:
    """One bifurcation as plain data."""
    return {
        **item.row(),
        "orbits_before": [_orbit_data(orbit) for orbit in item.orbits_before],
        "orbits_after": [_orbit_data(orbit) for orbit in item.orbits_after],
        "attractors_before": [_attractor_data(a) for a in item.attractors_before],
        "attractors_after": [_attractor_data(a) for a in item.attractors_after],
        "outcome": _outcome_data(item.outcome),
        "predicted_outcome": _outcome_data(item.predicted_outcome),
        "as_predicted": agrees(item),
        "interval": list(item.interval),
        "residual": item.residual,
    }


def _orbit_data(orbit: PeriodicOrbit) -> dict[str, Any]:
    return {
        "kind": orbit.kind,
        "period": orbit.period,
        "multiplier": orbit.multiplier,
        "points": orbit.points.tolist(),
        "itinerary": list(orbit.itinerary),
    }


def _attractor_data(attractor: Attractor) -> dict[str, Any]:
    return {
        "kind": attractor.kind,
        "period": attractor.period,
        "bands": attractor.bands.tolist(),
        "lyapunov": attractor.lyapunov.value,
        "lyapunov_error": attractor.lyapunov.error,
    }


def _outcome_data(outcome: Outcome | None) -> dict[str, Any] | None:
    if outcome is None:
        return None
    return {"orbits": outcome.orbits, "attractors": outcome.attractors, "text": outcome.text}


def _cascade_data(cascade: Cascade) -> dict[str, Any]:
    return {
        "periods": [flip.period for flip in cascade.flips],
        "values": list(cascade.values),
        "errors": [flip.error for flip in cascade.flips],
        "accumulation": cascade.accumulation,
        "error": cascade.error,
        "ratios": cascade.ratios.tolist(),
    }


def _finite(data: Any) -> Any:
    """Replace numbers that JSON cannot write by None."""
    if isinstance(data, dict):
        return {name: _finite(value) for name, value in data.items()}
    if isinstance(data, list | tuple):
        return [_finite(value) for value in data]
    if isinstance(data, float) and not math.isfinite(data):
        return None
    return data
