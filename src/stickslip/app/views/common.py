"""What several views need of a model."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from stickslip.app.requests import BadRequestError, model_of
from stickslip.app.watched import WatchedMap, watched_map
from stickslip.mechanics.model.two_block import TwoBlock

if TYPE_CHECKING:
    from stickslip.app.requests import Request

__all__ = ["map_of", "naming", "two_blocks"]


def two_blocks(request: Request) -> TwoBlock:
    """Make the model of a view that only two blocks have.

    Raises
    ------
    BadRequestError
        A model that cannot be made, or another kind.
    """
    model = model_of(request)
    if isinstance(model, TwoBlock):
        return model
    raise BadRequestError(
        f"kind = {request.model['kind']!r}: this view is of two blocks, whose event map is one "
        "of the line.",
        "model.kind",
    )


def map_of(request: Request) -> WatchedMap:
    """Make the event map of the model.

    Raises
    ------
    BadRequestError
        As `two_blocks`; a model without an event map.
    """
    with naming("model"):
        return watched_map(two_blocks(request))


@contextmanager
def naming(field: str) -> Iterator[None]:
    """Say of a ValueError which field of the request it is about."""
    try:
        yield
    except BadRequestError:
        raise
    except ValueError as error:
        raise BadRequestError(str(error), field) from error
