"""``stickslip explore``: the explorer, a page in the browser."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from stickslip.cli.failure import UsageError
from stickslip.cli.options import Flag, Whole
from stickslip.cli.progress import note

EXAMPLES = """\
stickslip explore
stickslip explore --preset law9 --port 0
stickslip explore --host 0.0.0.0 --no-browser
"""

HIGHEST_PORT = 65535


def command(
    *,
    host: str = "127.0.0.1",
    port: Whole = 8421,
    no_browser: Annotated[Flag, Parameter(name="--no-browser")] = False,
    preset: str | None = None,
) -> None:
    """Open the explorer: map, motions and bifurcations of a model, linked, in the browser.

    Prints the address and serves until interrupted. Everything is computed on this machine,
    and only this machine is served unless --host says otherwise. Needs the extra "app".

    Parameters
    ----------
    host
        Address to serve at; 0.0.0.0 serves every machine that reaches this one.
    port
        Port to serve at; 0 takes a free one.
    no_browser
        Do not open a browser.
    preset
        View to begin with, such as coulomb, law9, oscillator or chain.
    """
    if not 0 <= port <= HIGHEST_PORT:
        raise UsageError(f"--port {port}: a port is a number from 0 to {HIGHEST_PORT}")
    if not host:  # sockets take it for every address
        raise UsageError("--host: name an address; 0.0.0.0 serves every machine")
    from stickslip.app import EXTRA
    from stickslip.extras import require_extra

    require_extra("app", "explorers", *EXTRA)
    from stickslip.app.presets import preset_names
    from stickslip.app.serving import listening_socket, serve, url_of

    if preset is not None and preset not in preset_names():
        raise UsageError(f"--preset {preset}: choose one of {', '.join(preset_names())}")
    try:
        listener = listening_socket(host, port)
    except OSError as error:
        raise UsageError(
            f"cannot serve at {host}, port {port}: {error.strerror or error}. "
            "--port 0 takes a free port"
        ) from error
    url = url_of(listener) + ("" if preset is None else f"#preset={preset}")
    print(url, flush=True)
    note("serving; Ctrl-C ends it", quiet=False)
    serve(listener, host, page=None if no_browser else url)
