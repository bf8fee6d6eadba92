"""Event maps by other people's solvers, one module each, and why one cannot be had."""

from __future__ import annotations

from importlib import import_module
from typing import Any

# Module by name; what it takes is in the extra `bench-peers`.
PEERS = {
    "scipy DOP853": "scipy_solver",
    "CyRK DOP853": "cyrk",
    "SUNDIALS CVODE": "sundials",
    "heyoka.py Taylor": "heyoka_taylor",
    "diffrax Dopri8": "diffrax_dopri8",
}


def peer(name: str) -> tuple[Any, str]:
    """Return the peer's ``Map``, to be made from a model, and ""; or None and the reason."""
    try:
        return import_module(f"benchmarks.peers.{PEERS[name]}").Map, ""
    except ImportError as missing:
        return None, str(missing)
