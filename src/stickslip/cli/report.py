"""Bifurcations of a user's own system told to readers and to programs."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from stickslip.analysis.attractors.attractor import AttractorND
from stickslip.analysis.bifurcations.bifurcation import OUTSIDE, place
from stickslip.analysis.orbits.orbits_nd import PeriodicOrbitND, multipliers_text
from stickslip.files import plain
from stickslip.results.table import aligned, listed
from stickslip.studies.claim import digits, table, with_error

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stickslip.analysis.attractors.attractor import Attractor
    from stickslip.analysis.bifurcations.bifurcation import Bifurcation, BifurcationList, Cascade
    from stickslip.analysis.bifurcations.outcome import Outcome
    from stickslip.analysis.orbits.orbit import PeriodicOrbit
    from stickslip.numerics.arrays import Floats


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
        "unresolved": [asdict(change) for change in found.unresolved],
        "outside": [asdict(change) for change in found.outside],
        "picture": picture,
    }
    written: dict[str, Any] = plain(content)
    return written


def agrees(item: Bifurcation) -> bool | None:
    """Whether the outcome observed is the one predicted; None without either of them."""
    if item.outcome is None or item.predicted_outcome is None:
        return None
    return not item.disagreement


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


def _orbit_data(orbit: PeriodicOrbit | PeriodicOrbitND) -> dict[str, Any]:
    name = "multipliers" if isinstance(orbit, PeriodicOrbitND) else "multiplier"
    return {
        "kind": orbit.kind,
        "period": orbit.period,
        name: getattr(orbit, name),
        "points": orbit.points.tolist(),
        "itinerary": list(orbit.itinerary),
    }


def _attractor_data(attractor: Attractor | AttractorND) -> dict[str, Any]:
    name = "points" if isinstance(attractor, AttractorND) else "bands"
    return {
        "kind": attractor.kind,
        "period": attractor.period,
        name: getattr(attractor, name).tolist(),
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


BANDS_SHOWN: Final = 4  # of an attractor, in a line
POINTS_SHOWN: Final = 4  # of an orbit, in a line


@dataclass(frozen=True)
class Report:
    """The bifurcations over a range of a parameter, each with all that is known of it."""

    found: BifurcationList
    picture: str = ""  # path of a diagram, relative to the page of `as_markdown`
    title: str = ""

    def text(self) -> str:
        """Lines for a terminal."""
        found = self.found
        lines = [*([self.title] if self.title else []), _headline(found)]
        lines += [f"  {line}" for line in _searched(found)]
        if len(found):
            lines += ["", *aligned([_HEAD, *map(_row, found)], "<" * len(_HEAD))]
        for number, item in enumerate(found, start=1):
            lines += ["", f"{number}. {_name(item)} at {_where(item)}"]
            width = max(len(label) for label, _ in _facts(item))
            lines += [f"   {label:{width}s}  {fact}" for label, fact in _facts(item)]
        for heading, entries in _remainder(found):
            lines += ["", f"{heading}:", *(f"  {entry}" for entry in entries)]
        return "\n".join(lines) + "\n"

    def as_markdown(self) -> str:
        """Page for readers, with the diagram if there is a picture of one."""
        found = self.found
        lines = [f"# {self.title or 'Bifurcations'}", "", f"{_headline(found)}.", ""]
        lines += [f"- {line}" for line in _searched(found)]
        if self.picture:
            embed = "" if self.picture.endswith(".pdf") else "!"
            lines += ["", f"{embed}[Bifurcation diagram]({self.picture})"]
        if len(found):
            lines += ["", *table(_HEAD, [_row(item) for item in found])]
        for number, item in enumerate(found, start=1):
            lines += ["", f"## {number}. {_name(item)} at {_where(item)}", ""]
            lines += table(("", ""), _facts(item))
        for heading, entries in _remainder(found):
            lines += ["", f"## {heading}", "", *(f"- {entry}" for entry in entries)]
        return "\n".join(lines) + "\n"

    def as_json(self) -> str:
        """Document for programs; numbers in full precision, those not finite as null."""
        data = document(self.found, title=self.title, picture=self.picture)
        return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


# ---------------------------------------------------------------- words


_HEAD: Final = ("value", "error", "kind", "period", "orbits", "attractors", "as predicted")


def _headline(found: BifurcationList) -> str:
    lo, hi = found.range
    count = f"{len(found) or 'no'} bifurcation{'' if len(found) == 1 else 's'}"
    return f"{count} over {found.parameter} in ({lo:.10g}, {hi:.10g})"


def _searched(found: BifurcationList) -> Iterator[str]:
    """Say what was searched, and for which system."""
    rest = ", ".join(
        f"{name} = {value:.10g}"
        for name, value in found.parameters.items()
        if name != found.parameter
    )
    if rest:
        yield f"parameters: {rest}"
    window = "the whole domain"
    if found.window is not None:
        window = "the window ({:.10g}, {:.10g})".format(*found.window)
    yield f"searched: orbits to period {found.max_period} in {window}"
    if found.n_lists:
        kind = "complete lists" if found.coverage is None else "lists, which may lack some,"
        yield f"{kind} of orbits at {found.n_lists} values of {found.parameter}"
    if (seen := found.coverage) is not None and seen.n_lists > 1:
        told = f"{seen.again} of {seen.known} known orbits again, and {seen.new} new"
        yield f"the last half of these lists found {told}"
    if found.looks:
        yield f"attractors at {len(found.looks)} values of {found.parameter}"


def _name(item: Bifurcation) -> str:
    kind = item.kind.replace("_", " ")
    if item.criticality:
        kind = f"{item.criticality}critical {kind}"
    return f"{kind} of period {item.period}"


def _where(item: Bifurcation) -> str:
    return f"{item.parameter} = {with_error(item.value, item.error)}"


def _row(item: Bifurcation) -> tuple[str, ...]:
    """Cells of the overview."""
    kind = item.kind.replace("_", " ")
    return (
        digits(item.value, item.error),
        f"{item.error:.0e}",
        f"{kind} ({item.criticality})" if item.criticality else kind,
        str(item.period),
        f"{len(item.orbits_before)} -> {len(item.orbits_after)}",
        f"{_short(item.attractors_before)} -> {_short(item.attractors_after)}",
        {True: "yes", False: "no", None: ""}[agrees(item)],
    )


def _short(attractors: Sequence[Attractor | AttractorND]) -> str:
    return ", ".join(map(_shortest, attractors)) or "none"


def _shortest(attractor: Attractor | AttractorND) -> str:
    if attractor.kind == "periodic":
        return f"period {attractor.period}"
    if attractor.kind != "chaotic":
        return attractor.kind
    return "chaos" if isinstance(attractor, AttractorND) else f"{len(attractor.bands)}-band chaos"


def _facts(item: Bifurcation) -> list[tuple[str, str]]:
    """All that is known of one bifurcation, as labels and texts."""
    facts = [
        ("orbit there", _listed(item.points, 12)),
        _slopes(item),
        ("orbits before", _orbits(item.orbits_before)),
        ("orbits after", _orbits(item.orbits_after)),
        ("attractors before", _attractors(item.attractors_before)),
        ("attractors after", _attractors(item.attractors_after)),
        ("observed", _outcome(item.outcome)),
        ("predicted", _outcome(item.predicted_outcome)),
        ("as predicted", _agreement(item)),
        ("mechanism", item.mechanism),
        ("block", "" if item.block is None else str(item.block)),
        ("located", _quality(item)),
        ("note", item.note),
    ]
    return [(label, text) for label, text in facts if text]


def _slopes(item: Bifurcation) -> tuple[str, str]:
    slopes = item.multipliers
    if item.points.ndim > 1:
        return "multipliers", multipliers_text(np.asarray(slopes))
    label = "multiplier" if len(slopes) == 1 else "multipliers, left and right"
    return label, ", ".join(f"{m:.10g}" for m in slopes)


def _orbits(orbits: Sequence[PeriodicOrbit | PeriodicOrbitND]) -> str:
    return "; ".join(_orbit(orbit) for orbit in orbits) or "none"


def _orbit(orbit: PeriodicOrbit | PeriodicOrbitND) -> str:
    if isinstance(orbit, PeriodicOrbitND):
        slopes = f"multipliers {multipliers_text(orbit.multipliers)}"
    else:
        slopes = f"multiplier {orbit.multiplier:.8g}"
    return f"{orbit.kind}, period {orbit.period}, {slopes} at {_listed(orbit.points, 10)}"


def _listed(points: Floats, places: int) -> str:
    """Write an orbit's points, the first few if there are many: the JSON document has all."""
    return listed((place(point, places) for point in points), POINTS_SHOWN)


def _attractors(attractors: Sequence[Attractor | AttractorND]) -> str:
    return "; ".join(_attractor(attractor) for attractor in attractors)


def _attractor(attractor: Attractor | AttractorND) -> str:
    exponent = f"exponent {attractor.lyapunov.value:.6g} ± {attractor.lyapunov.error:.0e}"
    if attractor.kind == "periodic":
        return f"periodic, period {attractor.period}, {exponent}"
    if isinstance(attractor, AttractorND):
        return f"{attractor.kind}, at {_listed(attractor.points, 8)}, {exponent}"
    bands = listed((f"[{a:.8g}, {b:.8g}]" for a, b in attractor.bands), BANDS_SHOWN)
    count = f"{len(attractor.bands)} band{'' if len(attractor.bands) == 1 else 's'}"
    return f"{attractor.kind}, {count} {bands}, {exponent}"


def _outcome(outcome: Outcome | None) -> str:
    if outcome is None:
        return ""
    text = f"orbits {outcome.orbits}, attractors {outcome.attractors}"
    return f"{text}: {outcome.text}" if outcome.text else text


def _agreement(item: Bifurcation) -> str:
    if item.outcome is None or item.predicted_outcome is None:
        return ""
    return f"no: {item.disagreement}" if item.disagreement else "yes"


def _quality(item: Bifurcation) -> str:
    lo, hi = item.interval
    where = f", between {lo:.17g} and {hi:.17g}" if math.isfinite(lo) else ""
    residual = f", residual {item.residual:.0e}" if math.isfinite(item.residual) else ""
    return f"{item.quality}{where}{residual}" if item.quality != "located" or where else ""


def _remainder(found: BifurcationList) -> Iterator[tuple[str, list[str]]]:
    """Cascades, then what stayed open: headings with their entries."""
    if found.cascades:
        yield "Cascades", [_cascade(cascade) for cascade in found.cascades]
    if found.unresolved:
        yield "Unresolved", [str(item) for item in found.unresolved]
    elif found.coverage is None:
        yield "Unresolved", ["nothing: every change between the lists is explained"]
    else:
        yield "Unresolved", ["nothing of what lists show; they may lack orbits, and what these do"]
    if found.outside:
        reasons = (replace(c, reason=c.reason.removeprefix(f"{OUTSIDE}: ")) for c in found.outside)
        yield "Outside the question", [str(item) for item in reasons]


def _cascade(cascade: Cascade) -> str:
    periods = ", ".join(str(flip.period) for flip in cascade.flips)
    ratios = ", ".join(f"{ratio:.6g}" for ratio in cascade.ratios)
    text = f"flips of the periods {periods} from {digits(cascade.flips[0].value, 1e-12)}"
    if math.isfinite(cascade.accumulation):
        text += f", accumulating at {with_error(cascade.accumulation, cascade.error)}"
    return f"{text}; ratios of the gaps {ratios}" if ratios else text
