import math

import numpy as np
import pytest

from fullwell.figures.camera_dynamic_range import (
    QUALITY_DECIBELS,
    camera_dynamic_range,
    iso15739_like,
    patch_nearest,
    patch_variance,
    scene_snr_curve,
)
from fullwell.figures.dynamic_range import dynamic_range
from fullwell.figures.tonal_response import tonal_response
from fullwell.fit.gamma_likelihood import fit_gamma
from fullwell.fit.photon_transfer import photon_transfer_design
from fullwell.units import DN, DN2, ONE, Measured

MAXIMUM = 16383.0
A6000 = np.array([1.672e-4, 5.554e-3, 5.477e-3]) ** 2 * np.array([MAXIMUM**2, MAXIMUM, 1.0])
SATURATION = 0.9169 * MAXIMUM
NO_ERROR = np.zeros((3, 3))
DENSITIES = 0.2486 * np.arange(36)


def _fits(rng, sets, *, n=2500, flare=2.4e-4):
    """Fits of simulated charts, four planes: coefficients and covariances."""
    light = SATURATION * (10.0**-DENSITIES + flare)
    signal = (np.array([0.306, 1.0, 1.0, 0.606])[:, None] * light).ravel()
    variance = np.polynomial.polynomial.polyval(signal, A6000)
    shape = (sets, signal.size)
    measured = variance * rng.chisquare(n - 1, shape) / (n - 1)
    means = signal + rng.standard_normal(shape) * np.sqrt(variance / n)
    design = photon_transfer_design(means, terms=3)
    return fit_gamma(design, measured, np.array(n - 1.0), low_signal=np.full(shape, 1.0 / n))


def test_T18_dynamic_range_and_system_gain_cover():  # noqa: N802 - METHOD's name of the test
    sets = 2000
    fit = _fits(np.random.default_rng(18), sets)
    saturation = Measured.exact(SATURATION, DN)
    flare = Measured.exact(5.5e-4, ONE)
    for snr in (1.0, 10.0):
        truth = dynamic_range(A6000, NO_ERROR, saturation, snr=snr).range.decibel.value
        found = [
            dynamic_range(c, v, saturation, snr=snr).range.decibel
            for c, v in zip(fit.coefficients, fit.covariance, strict=True)
        ]
        _assert_unbiased_and_covering(found, truth)
        truth = camera_dynamic_range(A6000, NO_ERROR, saturation, flare, snr=snr).range.decibel.value
        found = [
            camera_dynamic_range(c, v, saturation, flare, snr=snr).range.decibel
            for c, v in zip(fit.coefficients, fit.covariance, strict=True)
        ]
        _assert_unbiased_and_covering(found, truth)
    error = np.sqrt(fit.covariance[:, 1, 1])
    covered = np.mean(np.abs(fit.coefficients[:, 1] - A6000[1]) <= 1.96 * error)
    assert 0.935 <= covered <= 0.965, covered


def _assert_unbiased_and_covering(found, truth):
    assert abs(np.mean([one.value for one in found]) - truth) <= 0.002
    covered = np.mean([one.ci95[0] <= truth <= one.ci95[1] for one in found])
    assert 0.935 <= covered <= 0.965, covered


@pytest.mark.parametrize(
    ("flare", "decibel"), [(0.0, 73.98), (2.4e-4, 73.05), (5.5e-4, 72.1), (1e-3, 71.0), (3e-3, 68.0)]
)
def test_published_camera_ranges(flare, decibel):
    """METHOD 7, flare there as a fraction of D."""
    found = camera_dynamic_range(A6000, NO_ERROR, Measured.exact(SATURATION, DN), Measured.exact(flare / 0.9169, ONE))
    places = 0.005 if decibel > 73.0 else 0.05
    assert found.range.decibel.value == pytest.approx(decibel, abs=places)


def test_at_the_threshold_the_scene_stands_out_by_the_threshold():
    flare = Measured.exact(1e-3, ONE)
    for decibel in QUALITY_DECIBELS:
        snr = 10.0 ** (decibel / 20.0)
        found = camera_dynamic_range(A6000, NO_ERROR, Measured.exact(SATURATION, DN), flare, snr=snr)
        level = found.threshold_signal.value
        assert float(scene_snr_curve(level, A6000, flare_dn=1e-3 * SATURATION)) == pytest.approx(snr, rel=1e-9)
        assert found.range.plain.value == pytest.approx(SATURATION / level)
    with pytest.raises(ValueError, match="never reaches"):
        camera_dynamic_range(A6000, NO_ERROR, Measured.exact(SATURATION, DN), flare, snr=1000.0)


def test_errors_of_flare_saturation_and_model_all_count():
    rng, sets = np.random.default_rng(181), 4000
    covariance = np.diag([0.2, 2e-3, 1e-6]) ** 2
    truth = camera_dynamic_range(
        A6000, NO_ERROR, Measured.exact(SATURATION, DN), Measured.exact(1e-3, ONE)
    ).range.decibel.value
    pulls = []
    for values in rng.multivariate_normal(A6000, covariance, sets):
        saturation = Measured.normal(rng.normal(SATURATION, 150.0), 150.0, DN)
        flare = Measured.normal(rng.normal(1e-3, 4e-5), 4e-5, ONE)
        found = camera_dynamic_range(values, covariance, saturation, flare).range.decibel
        pulls.append((found.value - truth) / found.std_error)
    assert abs(np.std(pulls) - 1.0) <= 4.0 / math.sqrt(2.0 * sets)
    assert abs(np.mean(np.abs(pulls) <= 1.96) - 0.95) <= 4.0 * math.sqrt(0.95 * 0.05 / sets)


def test_a_wrong_offset_drops_out_of_the_camera_range():
    """An offset too high by 3 DN takes 3 DN off flare and levels and adds B d + C d^2 to A: nothing else moves."""
    shift, flare_dn = 3.0, 20.0
    a, b, c = A6000
    moved = np.array([a + b * shift + c * shift**2, b + 2.0 * c * shift, c])
    saturation = Measured.exact(SATURATION, DN)
    one, other = (
        camera_dynamic_range(coefficients, NO_ERROR, saturation, Measured.exact(flare / SATURATION, ONE))
        for coefficients, flare in ((A6000, flare_dn), (moved, flare_dn - shift))
    )
    assert other.range.decibel.value == pytest.approx(one.range.decibel.value, abs=1e-9)


def test_iso_like_range():
    saturation = Measured.normal(4000.0, 40.0, DN)
    found = iso15739_like(saturation, patch_variance(4.0, 5000.0), flare_dn=100.0)
    assert found.plain.value == pytest.approx(1950.0)
    expected = math.hypot(40.0 / 3900.0, 0.5 * math.sqrt(2.0 / 5000.0))
    assert found.plain.std_error == pytest.approx(1950.0 * expected)
    assert found.stops.value == pytest.approx(math.log2(1950.0))
    for clip, noise in ((4000.0, 0.0), (50.0, 4.0)):
        with pytest.raises(ValueError, match="black patch"):
            iso15739_like(Measured.exact(clip, DN), Measured.exact(noise, DN2), flare_dn=100.0)


def test_patch_nearest_to_a_density():
    assert patch_nearest(DENSITIES, 2.0) == 8
    assert patch_nearest([np.nan, 1.2, 1.9, 3.0], 2.0) == 2


def test_tonal_response_with_and_without_offset():
    """METHOD 8: with the offset left in the curve flattens at log10(511/16383) = -1.506; without, its slope is 1."""
    order = np.random.default_rng(182).permutation(36)
    means = 511.0 + SATURATION * 10.0 ** -DENSITIES[order]
    found = tonal_response(means, DENSITIES[order], offset_dn=511.0, white_dn=MAXIMUM)
    np.testing.assert_array_equal(order[found.patch], np.arange(36)[::-1])
    assert found.log_pixel[0] == pytest.approx(-1.506, abs=5e-4)
    np.testing.assert_allclose(found.slope[1:-1], 1.0, rtol=1e-6)
    assert np.isnan(found.slope[[0, -1]]).all()
    assert found.log_signal[-1] == pytest.approx(math.log10(SATURATION / (MAXIMUM - 511.0)))
    foggy = tonal_response(means + 20.0, DENSITIES[order], offset_dn=511.0, white_dn=MAXIMUM)
    assert foggy.slope[1] < 0.1
    below = tonal_response([500.0, 600.0], [2.0, np.nan], offset_dn=511.0, white_dn=MAXIMUM)
    assert below.patch.size == 1
    assert np.isnan(below.log_signal).all()
