"""Dry-friction oscillators as exact, fast event maps.

Public names are listed in ``__init__.pyi`` and loaded when first used, so that
importing the package compiles and draws nothing.
"""

import sys
from importlib.util import find_spec

import lazy_loader

__version__ = "0.1.0"

_served, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def __getattr__(name: str) -> object:
    try:
        return _served(name)
    except AttributeError:
        if name.startswith("_") or name in __all__:
            raise
    from stickslip.vocabulary import closest

    told = f"stickslip has no {name!r}. {closest(name, __all__)}".rstrip()
    raise AttributeError(told, obj=sys.modules[__name__])  # with its name Python suggests again


if find_spec("flint") is None:
    # `import *` and `help` pass over what an extra brings; asked for by name, it says which extra.
    __all__ = [name for name in __all__ if name != "enclose" and not name.startswith("certify")]

    def __dir__() -> list[str]:
        return __all__
