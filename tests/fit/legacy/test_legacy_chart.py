import math

import numpy as np
import pytest

from fullwell.fit.legacy.chart import PUBLISHED_RATIO, legacy_max_noise_patch, legacy_offset, legacy_patch_range

MAXIMUM = 16383.0
A, B, C = np.array([1.672e-4, 5.554e-3, 5.477e-3]) ** 2 * np.array([MAXIMUM**2, MAXIMUM, 1.0])
DENSITIES = 0.2486 * np.arange(36)


def _chart():
    """The A6000: V_sat 0.9169 in the second lightest patch, the lightest one saturated and quiet."""
    signal = 0.9169 * MAXIMUM * 10.0 ** -(DENSITIES - 0.2486)
    signal[0] = 0.955 * MAXIMUM
    variance = A + B * signal + C * signal**2
    variance[0] *= 0.01
    return signal, variance


def test_published_offset_of_the_published_numbers():
    """The ratio rules: highest less offset is 1e5 times lowest less offset; or what the chart's densities allow."""
    means = np.array([16148.0, 4000.0, 511.15])
    found = legacy_offset(means)
    assert found.ratio == PUBLISHED_RATIO
    offset = found.offset.value
    assert (means.max() - offset) / (means.min() - offset) == pytest.approx(1e5)
    assert offset == pytest.approx(511.0, abs=0.01)
    assert found.offset.std_error is None
    assert legacy_offset(means, [0.133, 3.0, 8.833]).ratio == 1e5
    short = legacy_offset(means, [0.05, np.nan, 1.55])
    assert short.ratio == pytest.approx(10.0**1.5)
    assert legacy_offset(means, ratio=1e4).offset.value < offset
    with pytest.raises(ValueError, match="above 1"):
        legacy_offset(means, [0.5, 0.5, 0.5])


def test_published_saturation_of_the_a6000():
    """METHOD 8: C_sat 29724 e- from V_sat 0.9169; the bracket is the grid's, up to 31 % away."""
    signal, variance = _chart()
    found = legacy_max_noise_patch(signal, variance, system_gain=B)
    assert found.patch == 1
    assert found.electrons.value == pytest.approx(29724.0, abs=1.0)
    assert found.signal.ci95 == (signal[2], signal[0])
    assert found.electrons.ci95 == pytest.approx((signal[2] / B, signal[0] / B))
    assert found.electrons.std_error is None
    assert found.flags == ()
    rising = legacy_max_noise_patch(signal[1:], variance[1:], system_gain=B)
    assert rising.flags == ("lower-bound",)
    assert rising.signal.ci95 is None


def test_published_range_is_a_difference_of_densities():
    """METHOD 8: the coefficients give 73.98 dB; the patches can only give whole steps of 4.97 dB about it."""
    signal, variance = _chart()
    order = np.random.default_rng(243).permutation(36)
    for densities in (DENSITIES[order], None):
        found = legacy_patch_range(signal[order], variance[order], densities)
        assert order[found.brightest] == 1
        steps = found.decibel.value / (20.0 * 0.2486)
        assert steps == pytest.approx(round(steps), abs=1e-9)
        assert found.decibel.value == pytest.approx(73.98, abs=0.5 * 20.0 * 0.2486)
        low, high = found.decibel.ci95
        assert low <= 73.98 <= high
        assert low <= found.decibel.value <= high
        assert found.stops.value == pytest.approx(found.decibel.value / (20.0 * math.log10(2.0)))
        assert found.decibel.std_error is None
        assert found.flags == ()


def test_a_short_scale_gives_a_lower_bound():
    signal, variance = _chart()
    short = legacy_patch_range(signal[:10], variance[:10], DENSITIES[:10])
    assert short.flags == ("lower-bound",)
    assert short.decibel.value == pytest.approx(20.0 * 8 * 0.2486)
    assert short.decibel.ci95 is None
    assert legacy_patch_range(-signal, variance) is None
    assert legacy_patch_range(signal[:1], variance[:1]) is None


def test_published_quality_levels():
    signal, variance = _chart()
    ranges = [legacy_patch_range(signal, variance, DENSITIES, snr=snr).decibel.value for snr in (1.0, 3.16, 10.0)]
    assert ranges == sorted(ranges, reverse=True)
