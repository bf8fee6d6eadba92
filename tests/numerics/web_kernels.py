"""Two small kernels that share arrays."""

from stickslip.numerics.targets import kernel


@kernel
def exchange(pair, i, by):
    """Swap an entry of two arrays, and add a number to what becomes the first."""
    first = pair[0][i]
    pair[0][i] = pair[1][i] + by
    pair[1][i] = first


@kernel
def move(by, pair, steps):
    """Exchange all entries, some times."""
    for _ in range(steps):
        for i in range(pair[0].shape[0]):
            exchange(pair, i, by)


@kernel
def total(of, out):
    """Sum."""
    out[0] = 0.0
    for i in range(of.shape[0]):
        out[0] += of[i]
