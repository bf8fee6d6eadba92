"""A matrix applied to many rows."""

import numpy as np
import pytest

from stickslip.numerics.arrays import applied


@pytest.mark.parametrize("shape", [(), (7,), (2, 3), (0,)])
@pytest.mark.parametrize("n", [0, 1, 4])
def test_each_row_is_the_product(shape, n):
    rng = np.random.default_rng(n)
    matrix, rows = rng.normal(size=(3, n)), rng.normal(size=(*shape, n))
    found = applied(matrix, rows)
    assert found.shape == (*shape, 3)
    for k in np.ndindex(shape):
        expected = [sum(a * b for a, b in zip(row, rows[k], strict=True)) for row in matrix]
        np.testing.assert_allclose(found[k], expected, rtol=1e-14, atol=1e-15)


def test_rows_may_be_one_row_repeated():
    rows = np.broadcast_to([1.0, 2.0], (5, 2))
    np.testing.assert_array_equal(applied(np.eye(2), rows), rows)
