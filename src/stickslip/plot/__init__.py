"""Pictures: a result in, `matplotlib.axes.Axes` out. Nothing here shows a window."""
