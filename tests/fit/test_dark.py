import numpy as np
import pytest
from scipy.special import ndtr
from scipy.stats import kstest

from fullwell.fit.dark import (
    burst_effect,
    fit_dark_line,
    fit_dark_variance_slope,
    fit_doubling_temperature,
    slopes_disagree,
)
from fullwell.fit.legacy.dark import legacy_frame_slope
from fullwell.units import DN_PER_ELECTRON, DN_PER_SECOND, Measured, student_975

EXPOSURES = np.array([0.01, 0.02, 0.04, 0.08, 0.16])
FRAMES = 5
PIXEL_ERROR = 1.5 / np.sqrt(3e6)  # of one frame's mean [DN]
JITTER = 0.003
SLOPE = 0.064


def _bursts(rng, *, shared, sets=2000):
    """Frame means, shape (sets, bursts, frames): the Pixel study with offset jitter, shared by a burst or not."""
    shape = (sets, EXPOSURES.size, 1 if shared else FRAMES)
    jitter = JITTER * rng.standard_normal(shape)
    pixels = PIXEL_ERROR * rng.standard_normal((sets, EXPOSURES.size, FRAMES))
    return 64.0 + SLOPE * EXPOSURES[:, None] + jitter + pixels


def test_T14_burst_means_cover_and_pixel_errors_do_not():  # noqa: N802 - METHOD's name of the test
    pixel_slope_error = PIXEL_ERROR / np.sqrt(FRAMES) / np.sqrt(np.sum((EXPOSURES - EXPOSURES.mean()) ** 2))
    covered, pixel_covered, by_frames, pulls = [], [], [], []
    for means in _bursts(np.random.default_rng(14), shared=True):
        line = fit_dark_line(EXPOSURES, means.mean(axis=1))
        covered.append(line.slope.ci95[0] <= SLOPE <= line.slope.ci95[1])
        pixel_covered.append(abs(line.slope.value - SLOPE) <= 1.96 * pixel_slope_error)
        frames = fit_dark_line(np.repeat(EXPOSURES, FRAMES), means.ravel())
        by_frames.append(frames.slope.ci95[0] <= SLOPE <= frames.slope.ci95[1])
        pulls.append((line.slope.value - SLOPE) / line.slope.std_error)
    by_pixels = 2.0 * ndtr(1.96 * PIXEL_ERROR / np.hypot(PIXEL_ERROR, JITTER * np.sqrt(FRAMES))) - 1.0
    for found, expected in ((covered, 0.95), (pixel_covered, by_pixels), (by_frames, 0.50)):  # METHOD 4.1: 50 %
        assert abs(np.mean(found) - expected) <= 4.0 * np.sqrt(expected * (1.0 - expected) / len(found)), expected
    assert kstest(pulls, "t", args=(3,)).pvalue > 1e-3


def test_intercept_covers_too():
    covered = []
    for means in _bursts(np.random.default_rng(15), shared=True, sets=1000):
        intercept = fit_dark_line(EXPOSURES, means.mean(axis=1)).intercept
        covered.append(intercept.ci95[0] <= 64.0 <= intercept.ci95[1])
    assert abs(np.mean(covered) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / 1000)


def test_drift_between_bursts_is_seen():
    shared = [
        burst_effect(EXPOSURES, list(means)) for means in _bursts(np.random.default_rng(16), shared=True, sets=300)
    ]
    alone = [
        burst_effect(EXPOSURES, list(means)) for means in _bursts(np.random.default_rng(17), shared=False, sets=1000)
    ]
    assert np.mean([effect.p_value < 0.05 for effect in shared]) > 0.95
    assert np.mean([effect.intraburst_correlation for effect in shared]) > 0.8
    assert abs(np.mean([effect.p_value < 0.05 for effect in alone]) - 0.05) <= 4.0 * np.sqrt(0.05 * 0.95 / 1000)


def test_two_bursts_have_no_scatter():
    bare = fit_dark_line([0.1, 1.1], [64.0, 65.0])
    assert bare.slope.value == pytest.approx(1.0)
    assert bare.slope.std_error is None
    assert bare.resolvable_slope_dn_per_s is None
    known = fit_dark_line([0.1, 1.1], [64.0, 65.0], mean_std_error_dn=0.003)
    assert known.slope.std_error == pytest.approx(0.003 * np.sqrt(2.0))
    assert known.intercept.std_error == pytest.approx(0.003 * np.hypot(1.1, 0.1))
    few = fit_dark_line([0.1, 1.1], [64.0, 65.0], mean_std_error_dn=0.003, mean_dof=3.0)
    assert few.slope.dof == pytest.approx(6.0)
    with pytest.raises(ValueError, match="two or more different exposures"):
        fit_dark_line([0.1, 0.1], [64.0, 64.1])


def test_published_worked_example():
    """EMVA1288.md E9: slope 1.007142857 +- 0.015208304 DN/s, intercept 63.997380952."""
    time = [0.1, 0.3, 0.5, 0.7, 0.9, 1.1]
    line = fit_dark_line(time, [64.10, 64.31, 64.48, 64.71, 64.90, 65.11])
    assert line.slope.value == pytest.approx(1.007142857, rel=1e-9)
    assert line.slope.std_error == pytest.approx(0.015208304, rel=1e-7)
    assert line.slope.dof == 4
    assert line.intercept.value == pytest.approx(63.997380952, rel=1e-9)
    assert line.resolvable_slope_dn_per_s == pytest.approx(student_975(4.0) * 0.015208304, rel=1e-7)
    assert line.exposure_for_10_percent_s == pytest.approx(1.1 * 0.015208304 / 0.1007142857, rel=1e-6)


def test_weights_repeat_points():
    weighted = fit_dark_line([0.0, 1.0, 2.0], [1.0, 2.1, 2.9], weights=[1.0, 2.0, 1.0])
    repeated = np.polyfit([0.0, 1.0, 1.0, 2.0], [1.0, 2.1, 2.1, 2.9], 1)
    assert weighted.slope.value == pytest.approx(repeated[0])


def test_legacy_slope_is_plain_least_squares():
    line = legacy_frame_slope([0.0, 1.0, 2.0], [1.0, 2.1, 2.9])
    assert (line.slope.value, line.slope.std_error) == (pytest.approx(0.95), None)


def test_variance_slope_covers():
    system_gain = Measured.normal(0.5, 0.002, DN_PER_ELECTRON)
    rng = np.random.default_rng(43)
    time, dof, current, sets = np.linspace(0.5, 8.0, 6), 20_000, 6.0, 600
    truth = 4.0 + current * 0.5**2 * time
    covered, pulls = [], []
    for _ in range(sets):
        measured_system_gain = Measured.normal(rng.normal(0.5, 0.002), 0.002, DN_PER_ELECTRON)
        slope = fit_dark_variance_slope(
            time, truth * rng.chisquare(dof, 6) / dof, dof, system_gain=measured_system_gain
        )
        covered.append(slope.electrons.ci95[0] <= current <= slope.electrons.ci95[1])
        pulls.append((slope.dn.value - current * 0.5) / slope.dn.std_error)
    assert abs(np.mean(covered) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)
    assert abs(np.mean(pulls)) <= 4.0 / np.sqrt(sets)
    exact = fit_dark_variance_slope(time, truth, dof, system_gain=system_gain)
    assert exact.electrons.value == pytest.approx(current)
    assert exact.dn.value == pytest.approx(3.0)


def test_slopes_that_disagree():
    mean = Measured.normal(0.0, 0.1, DN_PER_SECOND)
    assert slopes_disagree(mean, Measured.normal(1.0, 0.3, DN_PER_SECOND))
    assert not slopes_disagree(mean, Measured.normal(0.9, 0.3, DN_PER_SECOND))


def test_doubling_temperature_covers():
    """Errors of 0.3 % keep the bias of this non-linear fit, which is of the order of their square, out of the pulls."""
    rng = np.random.default_rng(45)
    temperature = np.linspace(10.0, 60.0, 8)
    truth = 2.0 * 2.0 ** ((temperature - 30.0) / 6.5)
    error = np.hypot(0.005, 0.003 * truth)
    pulls = []
    for _ in range(500):
        fit = fit_doubling_temperature(
            temperature, truth + error * rng.standard_normal(8), error, reference_c=30.0, unit="e-/s"
        )
        pulls.append(
            (
                (fit.doubling_c.value - 6.5) / fit.doubling_c.std_error,
                (fit.dark_current.value - 2.0) / fit.dark_current.std_error,
            )
        )
    assert np.all(np.abs(np.mean(pulls, axis=0)) <= 4.0 / np.sqrt(500))
    assert np.all(np.abs(np.std(pulls, axis=0) - 1.0) <= 4.0 / np.sqrt(1000))
