"""What the page is built from: views to begin with, models, laws, parameters and bounds."""

from __future__ import annotations

import re
import unicodedata
from importlib.resources import as_file, files
from typing import TYPE_CHECKING, Any, Final

import msgspec

from stickslip import examples
from stickslip.app import requests
from stickslip.app.exports import KNOWN, formats
from stickslip.app.folder import presets
from stickslip.app.requests import SLIDERS
from stickslip.app.views.model import told_map
from stickslip.mechanics.friction import LAWS
from stickslip.mechanics.friction.law import Choice
from stickslip.mechanics.model.file import model_of_values, model_values, read_model, read_toml
from stickslip.vocabulary import TERMS

if TYPE_CHECKING:
    from pathlib import Path

    from stickslip.mechanics.model.arguments import Model

COULOMB_RANGE: Final = (0.0366, 0.0372)  # of V, figure 4
LAW9_RANGE: Final = (1.208, 1.21865)  # of alpha, figure 11
LAW9_WINDOW: Final = (0.379, 0.39)
APPROACH: Final[dict[str, Any]] = {
    "d": 0.2785,
    "power": 4,
    "windows": {"map": (0.274, 0.284, -0.27, -0.2), "power": (0.274, 0.284, 0.274, 0.284)},
}
"""Where a point of S4 and a jump meet, figure 6."""

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

BLOCKS: Final = {  # of period two: where blocks move chaotically a diagram takes long
    "kind": "blocks",
    "mass": [1.0, 2.7],
    "stiffness": [[2.3, -1.3], [-1.3, 1.9]],
    "static": [1.0, 1.4],
    "V": 0.08,
    "friction": {"law": "coulomb", "mu": 0.35},
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
    "coulomb": "Coulomb",
    "popp-stelter": "Popp and Stelter, law (9)",
    "stribeck": "Stribeck",
}


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


def of_model(model: Model, section: requests.Section | None = None, **state: Any) -> dict[str, Any]:
    """Begin the page with a model; its return map is told here, so that nothing has to be asked."""
    values = model_values(model)
    taken = {} if section is None else {"section": msgspec.to_builtins(section)}
    told = told_map(requests.Returns(values, section=section))
    return {"model": values, "map": told, **taken, **state}


def _along(parameter: str, low: float, high: float) -> dict[str, Any]:
    return {"parameter": parameter, "range": (low, high), "window": None, "max_period": 2}


def _helmholtz() -> dict[str, Any]:
    from stickslip.studies.bowed_string.string import MODEL, PLACE, helmholtz  # loads SciPy

    x, v = helmholtz(PLACE, MODEL.contacts[0].static)
    return {"x": x.tolist(), "v": v.tolist()}


FORWARD: Final = requests.Section(direction="forward")


def _of_studies() -> dict[str, tuple[str, dict[str, Any]]]:
    """Presets of the studies, from ``studies.toml``: their titles and states."""
    with as_file(files("stickslip")) as folder:
        return {
            name: (given.pop("title"), _studied(folder, name, given))
            for name, given in read_toml(folder / "app" / "studies.toml").items()
        }


def _studied(folder: Path, name: str, state: dict[str, Any]) -> dict[str, Any]:
    """State of a study's preset: its model, and what is looked at."""
    model = read_model(folder / "studies" / state.pop("model"))
    section = (
        msgspec.convert(state.pop("section"), requests.Section) if "section" in state else None
    )
    if "along" in state:
        state["diagram"] = _along(*state.pop("along"))
    if name == "bowed-string":
        state |= _helmholtz()
    return of_model(model, section, **state)


def opened(path: Path) -> dict[str, Any]:
    """Return a preset of a model file's plant."""
    return {"name": "model", "title": path.name, "state": of_model(read_model(path))}


def made_presets() -> list[dict[str, Any]]:
    """Make the presets that are shipped: those of studies take SciPy and most of a second."""
    damper = of_model(
        model_of_values(DAMPER),
        section=FORWARD,
        d=4.0,
        diagram=_along("forcing.amplitude", 1.2, 2.4),
    )
    listed = {
        "coulomb": ("Coulomb friction (figure 5)", _coulomb(0.0366)),
        "fig06": ("Coulomb, before the collision (figure 6)", _coulomb(0.0369, **APPROACH)),
        "fig08": ("Coulomb, after the collision", _coulomb(0.0370, **APPROACH)),
        "law9": ("Friction law (9) (figure 12)", _law9(1.208)),
        "law9-map": ("Law (9), the whole map", _law9(1.208, window=None)),
        "fig14": ("Law (9), near the crisis", _law9(1.211)),
        "oscillator": ("One block", of_model(model_of_values(OSCILLATOR))),
        "chain": ("A chain of three", {"model": CHAIN}),
        **_of_studies(),
        "damper": ("A friction damper", damper),
    }
    return [{"name": name, "title": t, "state": state} for name, (t, state) in listed.items()]


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
        _model("Two blocks", two_blocks, ("alpha", "beta", "V", "damping"), (2, 2)),
        _model("Oscillator", OSCILLATOR, ("V", "damping"), (1, 1)),
        _model(
            "Chain",
            CHAIN,
            ("static", "alpha", "V", "support", "mass", "damping"),
            (2, requests.MOST_BLOCKS),
        ),
        _model("Blocks with full matrices", BLOCKS, (), (1, requests.MOST_BLOCKS)),
        _structure("Structure", "brake"),
        _structure("State space", "hunting-axis"),
    ]


def _structure(title: str, preset: str) -> dict[str, Any]:
    """Describe models whose numbers the page reads off themselves."""
    default = next(one for one in presets() if one["name"] == preset)["state"]["model"]
    return _model(title, default, (), (1, requests.MOST_BLOCKS)) | {"forcing": []}


def _model(
    title: str,
    default: dict[str, Any],
    names: tuple[str, ...],
    blocks: tuple[int, int],
) -> dict[str, Any]:
    return {
        "kind": default["kind"],
        "title": title,
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
        return {"name": name, "symbol": symbol, "meaning": meaning, **SLIDERS[name]}
    term = TERMS[name]
    return {
        "name": name,
        "symbol": _unicode(term.symbol),
        "meaning": term.meaning.replace("_", ""),  # words have no subscripts
        **SLIDERS.get(name, {}),
    }


def _unicode(mathtext: str) -> str:
    r"""Write mathtext without markup: ``\alpha`` becomes α, ``V_{\mathrm{dr}}`` V_dr."""
    bare = mathtext.replace(r"\mathrm", "").replace("{", "").replace("}", "")
    return GREEK.sub(lambda m: unicodedata.lookup(f"GREEK SMALL LETTER {m[1].upper()}"), bare)


def _law(name: str) -> dict[str, Any]:
    fields = LAWS[name].fields()
    parameters = []
    for field, allowed in fields.items():
        described = _parameter(field)
        if isinstance(allowed, Choice):
            described |= {"default": allowed.values[0], "values": list(allowed.values)}
        parameters.append(described)
    default = {"law": name} | {item["name"]: item["default"] for item in parameters}
    return {
        "law": name,
        "title": LAW_TITLES[name],
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
