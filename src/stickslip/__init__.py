"""Dry-friction oscillators as exact, fast event maps.

Public names are listed in ``__init__.pyi`` and loaded when first used, so that
importing the package compiles and draws nothing.
"""

import lazy_loader

__version__ = "0.1.0"

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
