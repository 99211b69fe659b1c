"""Fixed pattern in the dark whose noise is small against a code: intervals hold whatever the phase."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.stats import binom

from fullwell.fit.nonuniformity import dark_nonuniformity
from fullwell.fit.read_noise import analogue_read_noise
from fullwell.fit.rounded_pattern import unrounded_nonuniformity
from fullwell.fit.variance_components import temporal_variance

SHAPE = (8, 24, 32)
SETS = 50


@pytest.mark.parametrize("noise", [0.05, 0.2, 0.3, 0.4, 0.55])
@pytest.mark.parametrize("spread", [0.05, 0.2])
def test_intervals_hold_the_pattern_before_rounding(noise: float, spread: float, mean_squares_of: Callable) -> None:
    """Codes near the middle of a code lose the pattern, at the edge of two they show too much of it."""
    rng = np.random.default_rng(8)
    pixels, rounded_holds, holds, noise_holds = SHAPE[1] * SHAPE[2], 0, 0, 0
    for trial in range(SETS):
        phase = (0.0, 0.5, 0.25, rng.uniform())[trial % 4]
        level = 64.0 + phase + spread * rng.standard_normal(SHAPE[1:])
        codes = np.rint(level + noise * rng.standard_normal(SHAPE))
        squares = mean_squares_of(codes[np.newaxis])[0]
        single = codes.var(axis=0, ddof=1)
        temporal = temporal_variance(squares, SHAPE, pixel_scatter_dn4=float(single.var()))
        seen = max(codes.mean(axis=0).var(ddof=1) - single.mean() / SHAPE[0], 0.0) ** 0.5
        read = analogue_read_noise(temporal, spatial_spread_dn=seen, n=codes.size)
        rounded = dark_nonuniformity(squares, SHAPE)
        found, _ = unrounded_nonuniformity(rounded, temporal=temporal, noise=read, pixels=pixels)
        ends = [one.total.ci95 for one in (rounded, found)]
        rounded_holds += ends[0][0] <= spread**2 <= ends[0][1]
        holds += ends[1][0] <= spread**2 <= ends[1][1]
        noise_holds += read.noise.ci95[0] <= noise <= read.noise.ci95[1]
    least = binom.ppf(1e-4, SETS, 0.95)
    assert holds >= least
    assert noise_holds >= least
    if noise < 0.4 and spread > 0.1:
        assert rounded_holds < least


def test_noise_of_a_code_and_more_leaves_the_pattern_as_it_is(mean_squares_of: Callable) -> None:
    rng = np.random.default_rng(9)
    codes = np.rint(64.0 + 0.5 * rng.standard_normal(SHAPE[1:]) + 1.1 * rng.standard_normal(SHAPE))
    squares = mean_squares_of(codes[np.newaxis])[0]
    temporal = temporal_variance(squares, SHAPE)
    read = analogue_read_noise(temporal, spatial_spread_dn=0.5)
    rounded = dark_nonuniformity(squares, SHAPE)
    assert unrounded_nonuniformity(rounded, temporal=temporal, noise=read, pixels=768) == (rounded, False)
