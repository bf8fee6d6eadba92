"""Pictures: a result in, `matplotlib.axes.Axes` out. Nothing here shows a window.

Every result has `.plot()`; here is what has no result of its own.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
