"""Exposures off the proportion: errors of what they are held against count too."""

from types import SimpleNamespace

import numpy as np

from fullwell.workflow.measure.steadiness import deviations

EXPOSURES_S = np.array([0.001, 0.002, 0.004, 0.008])
ERRORS_DN = np.array([0.4, 0.5, 1.0, 1.2])
BLACK_ERROR_DN = 0.3
REPEATS = 4000


def points(signals):
    def burst(exposure_s, error):
        plane = SimpleNamespace(mean_std_error=error)
        return SimpleNamespace(exposure_s=exposure_s, plane=lambda _channel: plane)

    return [
        SimpleNamespace(burst=burst(exposure_s, error), channel="G1", plane_signal_dn=signal)
        for exposure_s, error, signal in zip(EXPOSURES_S, ERRORS_DN, signals, strict=True)
    ]


def test_errors_are_those_that_deviations_have() -> None:
    rng = np.random.default_rng(11)
    true = 20_000.0 * EXPOSURES_S
    noise = ERRORS_DN * rng.standard_normal((REPEATS, 4)) + BLACK_ERROR_DN * rng.standard_normal((REPEATS, 1))
    found = np.array([[one for one, _ in deviations(points(true + part))] for part in noise])
    told = np.array([error for _, error in deviations(points(true), black_error_dn=BLACK_ERROR_DN)])
    # the median of two rates is their mean; errors of 2 % make the ratio linear to 0.1 %
    np.testing.assert_allclose(found.std(axis=0), told, rtol=5.0 / np.sqrt(2.0 * REPEATS) + 1e-3)
    assert np.abs(found.mean(axis=0)).max() < 5.0 * told.max() / np.sqrt(REPEATS) + 1e-3


def test_the_longest_of_few_exposures_is_not_accused_of_the_noise_of_the_next() -> None:
    """It lies 2 % above the mean of both by noise of the other, 3.5 of its errors off."""
    signals = 20_000.0 * EXPOSURES_S
    signals[2] -= 3.5
    deviation, error = deviations(points(signals), black_error_dn=BLACK_ERROR_DN)[3]
    assert 0.02 < deviation < 4.0 * error
