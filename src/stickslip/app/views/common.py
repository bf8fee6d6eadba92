"""What several views need of a model."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stickslip.analysis.maps.arguments import checked_range
from stickslip.app.ranges import refuse_far
from stickslip.app.requests import BadRequestError, is_ours, model_of
from stickslip.app.watched import WatchedMap, watched_map
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from stickslip.analysis.maps.protocol import MapFamily
    from stickslip.app.requests import Diagram, Request


def two_blocks(request: Request) -> TwoBlock:
    """Make the model of a view that only two blocks have."""
    model = model_of(request)
    if isinstance(model, TwoBlock):
        return model
    raise BadRequestError(
        f"kind = {request.model['kind']!r}: this view is of two blocks, whose event map is one "
        "of the line.",
        "model.kind",
    )


def map_of(request: Request) -> WatchedMap:
    """Make the event map of the model."""
    with naming("model"):
        return watched_map(two_blocks(request))


def range_of(f: MapFamily, request: Diagram) -> tuple[float, float]:
    """Return the ends of the range that a diagram is asked for."""
    with naming("range" if request.parameter in f.parameters else "parameter"):
        for end in request.range:
            refuse_far({request.parameter: end})
        return checked_range(f, request.parameter, request.range)


@contextmanager
def naming(field: str) -> Iterator[None]:
    """Say of a ValueError which field of the request it is about."""
    try:
        yield
    except BadRequestError:
        raise
    except ValueError as error:
        if not is_ours(error):
            raise
        raise BadRequestError(str(error), field) from error
