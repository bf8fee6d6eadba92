"""The explorer in a notebook: a frame onto a server in a thread of the notebook's own process."""

from __future__ import annotations

import atexit
import html
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Final
from urllib.parse import quote

import msgspec

from stickslip.app import EXTRA
from stickslip.checks import whole_number
from stickslip.extras import require_extra
from stickslip.mechanics.model.arguments import checked_model
from stickslip.mechanics.model.file import model_values
from stickslip.vocabulary import suggests

if TYPE_CHECKING:
    from stickslip.app.server import BackgroundServer
    from stickslip.mechanics.model.arguments import Model

NOTEBOOKS: Final = (
    "http://localhost:*",
    "http://127.0.0.1:*",
    "https://localhost:*",
    "vscode-webview:",
)
"""Where notebooks are shown from: Jupyter on this machine, and editors."""


@dataclass(frozen=True)
class Explorer:
    """The explorer's page, which a notebook shows as a frame.

    Attributes
    ----------
    url : str
        Its address, for a browser of this machine, with the model in it.
    height : int
        Of the frame, in pixels.
    """

    url: str
    height: int

    def _repr_html_(self) -> str:
        """Return the frame: what Jupyter shows, without any of its widgets."""
        source = html.escape(self.url, quote=True)
        return (
            f'<iframe src="{source}" title="stickslip explorer" width="100%" '
            f'height="{self.height}" style="border: 0"></iframe>'
        )


@suggests
def explore(model: Model | None = None, *, height: int = 820) -> Explorer:
    """Show the explorer in a notebook.

    Parameters
    ----------
    model : TwoBlock, Blocks, Chain, Oscillator or Structure, optional
        What it begins with, with built-in friction laws or formulas; by default the paper's
        system with Coulomb friction.
    height : int
        Of the frame, in pixels, > 0.

    Returns
    -------
    Explorer
        Shown as the last line of a cell; elsewhere ``.url`` opens in any browser. All of a
        process share one server, at a free port of this machine alone, which ends with it.

    Raises
    ------
    ValueError
        A friction law that is a Python function, which an address cannot hold; a height that is
        not positive.
    ModuleNotFoundError
        The extra ``app`` is not installed.

    Notes
    -----
    The notebook must run on the machine whose browser shows it, or have the port forwarded.

    Examples
    --------
    >>> import stickslip as ss
    >>> ss.explore(ss.examples.law9())  # doctest: +SKIP
    Explorer(url='http://127.0.0.1:40213/#...', height=820)
    """
    height = whole_number("height", height, at_most=100_000, what="pixels")
    fragment = ""
    if model is not None:
        checked_model(model)
        values = msgspec.json.encode(model_values(model)).decode()
        fragment = f"#model={quote(values, safe='')}"
    return Explorer(_server().url + fragment, height)


@cache
def _server() -> BackgroundServer:
    require_extra("app", "explorers", *EXTRA)
    from stickslip.app.server import BackgroundServer

    server = BackgroundServer(framed_by=NOTEBOOKS)
    atexit.register(server.stop)
    return server
