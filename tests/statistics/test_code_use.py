"""Gaps and doubles of histograms: what was done to the codes is found, and nothing where nothing was done."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fullwell.statistics.codes import CodeUse, Pattern, code_use, straight_slope
from fullwell.statistics.series import Histogram


def used(values: np.ndarray) -> CodeUse:
    counts = np.bincount(values.ravel().astype(np.int64))
    first = int(np.flatnonzero(counts)[0])
    return code_use(Histogram(first_code=first, counts=counts[first:].astype(np.int64), frames=1))


def scene(rng: np.random.Generator, pixels: int = 200_000) -> np.ndarray:
    """Return converter codes of a scene: photon noise over levels of two decades."""
    electrons = np.exp(rng.uniform(np.log(20.0), np.log(1500.0), pixels))
    return np.round(64.0 + 0.5 * rng.poisson(electrons) + rng.normal(0.0, 1.5, pixels)).astype(np.int64)


def noises(rng: np.random.Generator) -> list[np.ndarray]:
    """Return what cameras write that nobody touched: flats, darks, a dark of few electrons, scenes, a step chart."""
    level, spread = rng.uniform(100.0, 3000.0), rng.uniform(0.4, 40.0)
    steps = rng.choice(rng.uniform(100.0, 4000.0, 12), 120_000)
    return [
        np.round(rng.normal(level, spread, 100_000)).clip(0.0),
        np.round(np.maximum(rng.normal(rng.uniform(-1.0, 3.0), spread, 100_000), 0.0)),
        rng.poisson(rng.uniform(0.05, 4.0), 100_000),
        scene(rng, 100_000),
        np.minimum(scene(rng, 100_000), 500),
        np.round(rng.normal(steps, spread)).clip(0.0),
    ]


def test_nothing_is_found_where_nothing_was_done() -> None:
    found = [used(values) for seed in range(50) for values in noises(np.random.default_rng(seed))]
    odd = [one for one in found if one.pattern is not Pattern.EVERY]
    # none in 300; at a rate of 1 % that would happen in 5 % of all runs
    assert odd == []


@given(scale=st.floats(1.02, 20.0), seed=st.integers(0, 2**31))
@settings(max_examples=40)
def test_a_scaled_channel_tells_its_factor(scale: float, seed: int) -> None:
    found = used(np.floor(scale * scene(np.random.default_rng(seed))))
    if abs(scale - round(scale)) < 1e-3:
        return
    assert found.pattern is Pattern.SCALED_UP
    first, last = found.judged or (0, 0)
    # a straight line of m codes fixes its slope to two codes over its length
    assert found.scale == pytest.approx(scale, abs=2.0 * scale / (last - first))


@pytest.mark.parametrize(("scale", "seed"), [(0.55, 1), (0.61, 2), (0.7, 3), (0.8, 4), (0.873, 5), (0.95, 6)])
def test_a_channel_scaled_down_tells_its_factor(scale: float, seed: int) -> None:
    found = used(np.floor(scale * scene(np.random.default_rng(seed), 1_000_000)))
    assert found.pattern is Pattern.SCALED_DOWN
    assert found.scale == pytest.approx(scale, abs=0.01)


@pytest.mark.parametrize(("step", "offset"), [(2, 0), (4, 0), (16, 0), (4, 3)])
def test_a_shift_is_a_step(step: int, offset: int) -> None:
    found = used(step * scene(np.random.default_rng(step)) + offset)
    assert (found.pattern, found.step, found.scale) == (Pattern.STEPPED, step, step)
    assert found.lowest % step == offset


def test_bits_repeated_to_fill_sixteen_are_a_scale() -> None:
    codes = scene(np.random.default_rng(5))
    found = used((codes << 4) | (codes >> 8))
    assert found.pattern is Pattern.SCALED_UP
    assert found.scale == pytest.approx(16.0 + 1.0 / 256.0, abs=0.02)


def test_a_square_root_curve_is_companding() -> None:
    codes = scene(np.random.default_rng(6), 1_000_000)
    table = np.round(np.arange(256) ** 2 / 255.0**2 * 900.0)
    found = used(table[np.clip(np.searchsorted(table, codes), 0, 255)])
    assert found.pattern is Pattern.COMPANDED
    assert found.widest > 3


@given(seed=st.integers(0, 2**31), count=st.integers(1, 10))
@settings(max_examples=20)
def test_codes_that_are_left_out_are_named(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    left_out = np.sort(rng.choice(np.arange(100, 220), count, replace=False))
    codes = scene(rng, 400_000)
    found = used(codes[~np.isin(codes, left_out)])
    assert (found.pattern, found.missing) == (Pattern.MISSING, tuple(left_out.tolist()))


def test_a_valley_between_two_peaks_is_no_gap() -> None:
    rng = np.random.default_rng(7)
    for spread in (0.3, 0.5, 1.0):
        peaks = np.concatenate([rng.normal(level, spread, 300_000) for level in (100.0, 109.3, 230.0)])
        assert used(np.round(peaks)).pattern is Pattern.EVERY


def test_a_straight_line_of_whole_numbers() -> None:
    assert straight_slope(np.floor(2.5 * np.arange(50) + 0.3)) == pytest.approx(2.5, abs=0.01)
    assert straight_slope(np.array([0, 1, 2, 3, 5, 6, 9])) is None
