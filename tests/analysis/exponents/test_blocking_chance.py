"""Standard errors of series of few values, whose long blocks may agree by chance."""

import numpy as np

from stickslip.analysis.exponents.blocking import blocking_error


def test_two_halves_that_agree_by_chance_are_no_period() -> None:
    half = np.random.default_rng(1).permutation(np.repeat([0.3, 1.3], [192, 64]))
    other = np.random.default_rng(2).permutation(half)
    error = blocking_error(np.concatenate([half, other]))
    np.testing.assert_allclose(error, np.std(half) / np.sqrt(512), rtol=0.5)
    assert blocking_error(np.tile([0.3, 1.3], 256)) == 0.0
