"""Views to begin with: the paper's two systems, its figures, an oscillator, a chain."""

from __future__ import annotations

from typing import Any, Final

from stickslip import examples
from stickslip.mechanics.model.values import model_values

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
    }
    return [{"name": name, "title": t, "state": state} for name, (t, state) in listed.items()]


def preset_names() -> list[str]:
    """Return what a page can be opened with."""
    return [preset["name"] for preset in presets()]
