"""Parameter grids of any size -> labelled arrays on disk; `stickslip.sweep` runs them.

The package is not called like the function, which it would hide as soon as it is imported.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(__name__, submodules=["observables"])
