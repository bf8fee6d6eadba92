"""What the page is built from: views to begin with, models, laws, parameters and bounds."""

from __future__ import annotations

import re
import unicodedata
from importlib.resources import as_file, files
from typing import Any, Final

import msgspec

from stickslip import examples
from stickslip.app import requests
from stickslip.app.exports import KNOWN, formats
from stickslip.app.requests import SLIDERS
from stickslip.mechanics.friction import LAWS
from stickslip.mechanics.friction.law import Choice
from stickslip.mechanics.model.file import model_values, read_model
from stickslip.vocabulary import TERMS

COULOMB_RANGE: Final = (0.0366, 0.0372)  # of V, figure 4
LAW9_RANGE: Final = (1.208, 1.21865)  # of alpha, figure 11
LAW9_WINDOW: Final = (0.379, 0.39)

OSCILLATOR: Final = {
    "kind": "oscillator",
    "V": 0.2,
    "damping": 0.05,
    "friction": {"law": "popp-stelter", "gamma": 3.0},
}

CHAIN: Final = {
    "kind": "chain",
    "static": [1.0, 1.1, 1.2],
    "alpha": 1.2,
    "V": 0.1,
    "friction": {"law": "coulomb", "mu": 0.22},
}

DAMPER: Final = {
    "kind": "oscillator",
    "V": 0.0,
    "friction": {"law": "coulomb", "mu": 1.0},
    "forcing": {"amplitude": 1.8, "frequency": 0.5, "phase": 0.0},
}

GREEK: Final = re.compile(r"\\([a-z]+)")

MEANINGS: Final = {
    "damping": ("c", "damping coefficient of each block"),
    "static": ("L", "static limit of a block"),
    "support": ("k", "stiffness of the support springs"),
    "mass": ("m", "mass of each block"),
    "amplitude": ("a", "amplitude of the force on each block"),
    "frequency": ("Ω", "angular frequency of the force"),
    "phase": ("φ", "phase of the force at time 0"),
}
"""Numbers of models that the vocabulary of the paper does not have: symbol and meaning."""

LAW_TITLES: Final = {
    "coulomb": ("Coulomb", "F = μ + c s"),
    "popp-stelter": ("Popp and Stelter, law (9)", "F = (1 \u2212 δ)/(1 + γ s) + δ + η s²"),
    "stribeck": ("Stribeck", "F = μ + (1 \u2212 μ) exp(\u2212(s/s₀)ᵖ) + c s"),
}

TWO_BLOCKS: Final = ("event_map", "cobweb", "motion", "locus", "law", "basins", "diagram", "cycle")
IN_TIME: Final = ("motion", "law", "cycle")


def _coulomb(V: float, **state: Any) -> dict[str, Any]:
    diagram = {"parameter": "V", "range": COULOMB_RANGE, "window": None, "max_period": 4}
    model = model_values(examples.coulomb(V=V))
    return {"model": model, "d": 0.1, "max_period": 4, "diagram": diagram, **state}


def _law9(alpha: float, **state: Any) -> dict[str, Any]:
    diagram = {
        "parameter": "alpha",
        "range": LAW9_RANGE,
        "window": LAW9_WINDOW,
        "max_period": 4,
    }
    common = {"d": 0.3812, "max_period": 4, "window": LAW9_WINDOW, "diagram": diagram}
    return {"model": model_values(examples.law9(alpha=alpha)), **common, **state}


def _studied(name: str) -> dict[str, Any]:
    """Model of a study, as its file has it."""
    with as_file(files("stickslip.studies") / name / "model.toml") as path:
        return model_values(read_model(path))


def presets() -> list[dict[str, Any]]:
    """Return names, titles and states of the page."""
    listed = {
        "coulomb": ("Coulomb friction (figure 5)", _coulomb(0.0366)),
        "fig06": ("Coulomb, before the collision (figure 6)", _coulomb(0.0369, power=4)),
        "fig08": ("Coulomb, after the collision", _coulomb(0.0370, power=4)),
        "law9": ("Friction law (9) (figure 12)", _law9(1.208)),
        "law9-map": ("Law (9), the whole map", _law9(1.208, window=None)),
        "fig14": ("Law (9), near the crisis", _law9(1.211)),
        "oscillator": ("One block", {"model": OSCILLATOR}),
        "chain": ("A chain of three", {"model": CHAIN}),
        "canards": ("Canards in stiction", {"model": _studied("canards"), "x": [-0.3]}),
        "damper": ("A friction damper", {"model": DAMPER, "x": [0.5]}),
    }
    return [{"name": name, "title": t, "state": state} for name, (t, state) in listed.items()]


def preset_names() -> list[str]:
    """Return the names of the views that a page can be opened with."""
    return [preset["name"] for preset in presets()]


def described_limits() -> dict[str, Any]:
    """Return models, laws and bounds of requests as plain values."""
    return {
        "models": _models(),
        "laws": [_law(name) for name in LAWS],
        "requests": _bounds(),
        "exports": {view: formats(view) for view in KNOWN},
    }


def _models() -> list[dict[str, Any]]:
    two_blocks = model_values(examples.coulomb())
    return [
        _model("Two blocks", two_blocks, TWO_BLOCKS, ("alpha", "beta", "V", "damping"), (2, 2)),
        _model("Oscillator", OSCILLATOR, IN_TIME, ("V", "damping"), (1, 1)),
        _model(
            "Chain",
            CHAIN,
            (*IN_TIME, "basins"),
            ("static", "alpha", "V", "support", "mass", "damping"),
            (2, requests.MOST_BLOCKS),
        ),
    ]


def _model(
    title: str,
    default: dict[str, Any],
    views: tuple[str, ...],
    names: tuple[str, ...],
    blocks: tuple[int, int],
) -> dict[str, Any]:
    return {
        "kind": default["kind"],
        "title": title,
        "views": views,
        "parameters": [_parameter(name) | {"per_block": name == "static"} for name in names],
        "forcing": [] if default["kind"] == "two_block" else _forcing(),
        "blocks": {"min": blocks[0], "max": blocks[1]},
        "default": default,
    }


def _forcing() -> list[dict[str, Any]]:
    """Describe the numbers of harmonic forces, named as models name them."""
    names = ("amplitude", "frequency", "phase")
    return [_parameter(name) | {"name": f"forcing.{name}"} for name in names]


def _parameter(name: str) -> dict[str, Any]:
    if name in MEANINGS:
        symbol, meaning = MEANINGS[name]
        return {"name": name, "symbol": symbol, "meaning": meaning, "unit": "", **SLIDERS[name]}
    term = TERMS[name]
    return {
        "name": name,
        "symbol": _unicode(term.symbol),
        "meaning": term.meaning,
        "unit": term.scale,
        **SLIDERS.get(name, {}),
    }


def _unicode(mathtext: str) -> str:
    r"""Write mathtext without markup: ``\alpha`` becomes α, ``V_{\mathrm{dr}}`` V_dr."""
    bare = mathtext.replace(r"\mathrm", "").replace("{", "").replace("}", "")
    return GREEK.sub(lambda m: unicodedata.lookup(f"GREEK SMALL LETTER {m[1].upper()}"), bare)


def _law(name: str) -> dict[str, Any]:
    fields = LAWS[name].fields()
    title, formula = LAW_TITLES[name]
    parameters = []
    for field, allowed in fields.items():
        described = _parameter(field)
        if isinstance(allowed, Choice):
            described |= {"default": allowed.values[0], "values": list(allowed.values)}
        parameters.append(described)
    default = {"law": name} | {item["name"]: item["default"] for item in parameters}
    return {
        "law": name,
        "title": title,
        "formula": formula,
        "parameters": parameters,
        "default": default,
    }


def _bounds() -> dict[str, Any]:
    """Read the bounds of the requests' fields from their types."""
    described: dict[str, Any] = {}
    for view, kind in requests.REQUESTS.items():
        schema = msgspec.json.schema(kind)
        properties = schema["$defs"][kind.__name__]["properties"]
        described[view] = {
            name: {
                "min": field.get("minimum", field.get("exclusiveMinimum")),
                "max": field.get("maximum"),
                "default": field.get("default"),
            }
            for name, field in properties.items()
            if "maximum" in field
        }
    return described
