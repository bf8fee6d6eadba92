"""Pictures: a result in, `matplotlib.axes.Axes` out. Nothing here shows a window.

Every result has `.plot()`; here is what has no result of its own.

>>> import stickslip as ss
>>> ss.plot.event_map(ss.event_map(ss.examples.coulomb())).get_xlabel()
'$d_{n}$'
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
