"""The high-pass filter of EMVA 1288: equal to its readable twin, and the worked numbers E6."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest

from fullwell.kernels import filtered_products, high_pass, high_pass_reference
from fullwell.kernels.filtered_products import WIDEST_RANGE
from fullwell.statistics.high_pass import (
    LINE_SPREAD,
    LINE_VARIANCE_GAIN,
    PIXEL_SPREAD,
    VARIANCE_GAIN,
    filtered,
    filtered_covariance,
)


@pytest.mark.parametrize("shape", [(20, 20), (37, 64), (150, 31)])
@pytest.mark.parametrize("dtype", [np.uint16, np.float64])
def test_equal_to_its_twin(shape, dtype):
    plane = np.random.default_rng(1).integers(0, 65536, shape).astype(dtype)
    fast, slow = (np.empty((shape[0] - 18, shape[1] - 18)) for _ in range(2))
    high_pass.high_pass(plane, fast)
    high_pass_reference.high_pass(plane, slow)
    assert fast == pytest.approx(slow, abs=1e-9)


def test_pair_sums_equal_their_twin():
    first, second = np.random.default_rng(2).integers(0, 65536, (2, 40, 33)).astype(np.uint16)
    fast, slow = np.zeros(4, np.int64), np.zeros(4, np.int64)
    high_pass.pair_sums(first, second, fast)
    high_pass_reference.pair_sums(first, second, slow)
    assert fast.tolist() == slow.tolist()


@pytest.mark.parametrize("span", [1, 1000, WIDEST_RANGE])
@pytest.mark.parametrize(
    ("lowest", "shape"), [(0, (20, 20)), (42_000, (37, 64)), (65_535 - WIDEST_RANGE, (50, 31)), (77, (23, 2100))]
)
def test_filtered_products_equal_their_twin(lowest, shape, span):
    rng = np.random.default_rng(4)
    first = (lowest + span * rng.integers(0, 2, shape)).astype(np.uint16)
    second = (lowest + rng.integers(0, span + 1, shape)).astype(np.uint16)
    a, b = np.empty((2, shape[0] - 18, shape[1] - 18))
    high_pass_reference.high_pass(first, a)
    high_pass_reference.high_pass(second, b)
    a, b = (np.rint(one * 308**2).astype(np.int64).astype(np.object_) for one in (a, b))
    totals, passed = np.zeros(4, np.int64), filtered_products.nothing_passed(shape[1])
    for top, bottom in pairwise((0, 1, 12, 19, shape[0])):
        rows = slice(max(0, top - 9), bottom)
        part = filtered_products.Part(first[rows], second[rows], rows.start, top, bottom)
        filtered_products.add_filtered_products(part, (lowest, span), passed, totals)
    low, high, *sums = totals.tolist()
    assert low + (high << 32) == (a * b).sum()
    assert sums == [a.sum(), b.sum()]


def test_codes_of_any_range_have_their_covariance():
    rng = np.random.default_rng(5)
    for span in (WIDEST_RANGE, 65_535):
        first, second = (span * rng.integers(0, 2, (2, 160, 40))).astype(np.uint16)
        a, b = filtered(first.astype(float)), filtered(second.astype(float))
        expected = (a * b).mean() - a.mean() * b.mean()
        assert filtered_covariance(first, second, extremes=(0, span)) == pytest.approx(expected, rel=1e-9)


def test_e6a_impulse():
    plane = np.zeros((37, 37))
    plane[18, 18] = 1.0
    out = filtered(plane)
    assert out[9, 9] == pytest.approx(120 / 121)
    assert (out[9, 10], out[10, 10]) == pytest.approx((-1 / 121, -1 / 121))
    assert (out[9, 11], out[9, 12]) == pytest.approx((-27 / 3388, -24 / 3388))
    assert (out[9, 18], out[18, 18]) == pytest.approx((-1 / 3388, -1 / 94864))
    assert out.sum() == pytest.approx(0.0, abs=1e-12)


def test_e6b_planes_vanish_and_parabolas_become_constant():
    m, n = np.mgrid[:30, :25].astype(float)
    for plane, left in ((3 * m - 2 * n + 7, 0.0), (n**2, -14.5), (m**2 + n**2, -29.0), (m * n, 0.0)):
        assert filtered(plane) == pytest.approx(np.full((12, 7), left), abs=1e-9)


def test_e6c_alternation_passes():
    m, n = np.mgrid[:30, :25]
    for plane in ((-1.0) ** n, (-1.0) ** (m + n)):
        assert filtered(plane) == pytest.approx(plane[9:-9, 9:-9])


def test_e6d_a_small_plane():
    m, n = np.mgrid[:20, :20]
    out = filtered(((7 * m + 3 * n + 5 * m * n) % 11).astype(float))
    assert np.rint(out * 94864).tolist() == [[-508816, -129360], [250096, 60368]]


def test_e6e_gains_follow_from_the_weights():
    weights = [Fraction(int(weight), 308) for weight in high_pass_reference.SMOOTHER]
    line = 1 - 2 * weights[9] + sum(weight**2 for weight in weights)
    pixel = 1 - 2 * weights[9] ** 2 + sum(weight**2 for weight in weights) ** 2
    assert float(line) == LINE_VARIANCE_GAIN
    assert float(pixel) == VARIANCE_GAIN


def test_spreads_follow_from_the_autocorrelation():
    line = -high_pass_reference.SMOOTHER / 308
    plane = np.outer(-line, line)
    line[9] += 1.0
    plane[9, 9] += 1.0
    correlation = np.correlate(line, line, "full")
    assert pytest.approx(np.sum(correlation**2) / correlation.max() ** 2, rel=1e-6) == LINE_SPREAD**2
    power = np.abs(np.fft.fft2(plane, (64, 64))) ** 2
    assert pytest.approx((power**2).mean() / power.mean() ** 2, rel=1e-6) == PIXEL_SPREAD**2
