"""What a model is before anything moves: its friction laws and its global stick locus."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from stickslip.app.answers import Part
from stickslip.app.requests import model_of
from stickslip.app.views.common import two_blocks
from stickslip.mechanics.model import locus as geometry

if TYPE_CHECKING:
    from stickslip.app import requests


def law(request: requests.Law) -> Iterator[Part]:
    """Tabulate the friction law of each block."""
    model = model_of(request)
    s = np.linspace(0.0, request.range, request.points)
    arrays = {
        "s": s,
        "force": np.stack([law.force(s) for law in model.laws], axis=-1),
        "forward": np.stack([law.force(s, forward=True) for law in model.laws], axis=-1),
    }
    yield Part("law", arrays, {"names": [law.title for law in model.laws]})


def locus(request: requests.Locus) -> Iterator[Part]:
    """Give the corners of the locus and the edges on which global stick ends."""
    model = two_blocks(request)
    a, b, c, d = geometry.corners(model.alpha, model.beta)
    data = {
        "corners": [a, b, c, d],
        "domain": model.domain,
        "edges": [
            {"name": "block 1 slips", "from": a, "to": b},
            {"name": "block 2 slips", "from": b, "to": c},
        ],
        "AC": [a, c],
    }
    yield Part("locus", data=data)
