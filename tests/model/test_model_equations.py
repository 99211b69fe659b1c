import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import norm

from fullwell.model.noise import NoiseCoefficients, noise_coefficients
from fullwell.model.photon_transfer import noise_variance, signal_at_snr, signal_at_snr_gradient, signal_to_noise
from fullwell.model.quantization import (
    rounded_pattern,
    rounded_pattern_at_phase,
    rounded_variance,
    rounded_variance_at_phase,
    rounded_variance_slope,
)
from fullwell.model.sensor import SensorParameters


@given(snr=st.floats(0.5, 30.0), dark=st.floats(0.01, 100.0), shot=st.floats(0.01, 10.0), fixed=st.floats(0.0, 1e-4))
def test_threshold_signal_has_the_ratio(snr, dark, shot, fixed):
    level = signal_at_snr(snr, dark=dark, shot=shot, fixed_pattern=fixed)
    assert float(signal_to_noise(level, dark=dark, shot=shot, fixed_pattern=fixed)) == pytest.approx(snr, rel=1e-9)


def test_threshold_gradient_is_the_difference_quotient():
    point = np.array([7.5, 0.5, 3e-5])

    def level(values):
        return signal_at_snr(10.0, dark=values[0], shot=values[1], fixed_pattern=values[2])

    gradient = signal_at_snr_gradient(10.0, dark=7.5, shot=0.5, fixed_pattern=3e-5)
    for index in range(3):
        step = np.zeros(3)
        step[index] = 1e-5 * point[index]
        quotient = (level(point + step) - level(point - step)) / (2.0 * step[index])
        assert gradient[index] == pytest.approx(quotient, rel=1e-6)


def test_thresholds_that_are_never_reached():
    assert signal_at_snr(200.0, dark=1.0, shot=0.5, fixed_pattern=1e-4) == float("inf")
    assert np.isnan(signal_at_snr(1.0, dark=-10.0, shot=0.5))


def test_published_noise_coefficients():
    """METHOD 8: the Sony sensor by EMVA 1288, with quantization; the A6000's system gain."""
    sony = noise_coefficients(
        system_gain=0.425, digital_maximum=4095.0, dark_noise=2.36, offset_spread=0.703, prnu=0.00678
    )
    assert sony.k_dark == pytest.approx(0.0002651, abs=5e-8)
    assert sony.k_shot == pytest.approx(0.010187, abs=5e-7)
    a6000 = NoiseCoefficients(k_dark=1.672e-4, k_shot=5.554e-3, k_fpn=5.477e-3)
    dark, shot, _ = a6000.variances_dn(16383.0)
    assert shot == pytest.approx(0.5054, abs=5e-5)
    assert np.sqrt(dark) / shot == pytest.approx(5.42, abs=0.005)


def test_published_total_dark_noise():
    """METHOD 4.6: at 10 s and 2.22 e-/s it is 5.3 e-, not 22.3 e-."""
    sensor = SensorParameters(
        width=2,
        height=2,
        cfa="mono",
        bit_depth=12,
        black_level=(0.0,),
        white_level=4095,
        base_iso=100.0,
        system_gain=0.425,
        full_well=1e4,
        response=(1.0,),
        read_noise=2.36,
        dark_current=2.22,
    )
    assert sensor.dark_noise_at(100.0, 10.0) == pytest.approx(5.3, abs=0.05)


@given(noise=st.floats(0.01, 3.0))
def test_rounding_law_is_smooth_and_its_slope_is_its_slope(noise):
    step = 1e-4 * noise
    quotient = (rounded_variance(noise + step) - rounded_variance(noise - step)) / (
        (noise + step) ** 2 - (noise - step) ** 2
    )
    assert rounded_variance_slope(noise) == pytest.approx(quotient, rel=1e-5)


@pytest.mark.parametrize("noise", [0.05, 0.099999, 0.100001, 0.2, 0.35, 0.7])
def test_rounding_law_is_the_mean_over_phases(noise):
    phases = np.linspace(-0.5, 0.5, 2000, endpoint=False)
    assert rounded_variance(noise) == pytest.approx(float(rounded_variance_at_phase(noise, phases).mean()), rel=1e-6)


def test_rounding_at_one_phase_by_simulation():
    rng = np.random.default_rng(1)
    codes = np.rint(0.2 + 0.3 * rng.standard_normal((4, 200_000)))
    variances = codes.var(axis=0, ddof=1)
    expected = float(rounded_variance_at_phase(0.3, 0.2))
    assert abs(variances.mean() - expected) <= 4.0 * variances.std() / np.sqrt(variances.size)


@pytest.mark.parametrize("noise", [0.01, 0.05, 0.2, 0.5])
@pytest.mark.parametrize("phase", [0.0, 0.2, 0.5])
def test_a_pattern_is_rounded_as_its_mean_codes_are(noise, phase):
    """The mean code of a level by the normal law, over the levels of a normal pattern."""
    for spread in (0.05, 0.2, 0.6):
        levels = phase + spread * norm.ppf((np.arange(20_000) + 0.5) / 20_000)
        codes = norm.cdf((levels[:, np.newaxis] - np.arange(-6.5, 8.0)) / noise).sum(axis=1)
        found = float(rounded_pattern_at_phase(spread, phase, noise=noise))
        assert found == pytest.approx(codes.var(), rel=2e-3, abs=1e-6)


def test_a_rounded_pattern_is_the_mean_over_phases():
    phases = np.linspace(-0.5, 0.5, 400, endpoint=False)
    for spread in (0.05, 0.2, 0.6):
        mean = float(rounded_pattern_at_phase(spread, phases, noise=0.2).mean())
        assert float(rounded_pattern(spread, noise=0.2)) == pytest.approx(mean, rel=1e-9)


@pytest.mark.parametrize("noise", [0.002, 0.01, 0.05, 0.3, 1.2])
@pytest.mark.parametrize("spread", [0.003, 0.02, 0.1, 0.6])
def test_noise_and_pattern_are_rounded_as_the_noise_of_both(noise, spread):
    """By the law of total variance; the closed form for little noise holds to 1e-11."""
    both = rounded_variance(float(np.hypot(noise, spread)))
    assert float(rounded_pattern(spread, noise=noise)) == pytest.approx(both - rounded_variance(noise), abs=2e-11)


def test_published_errors_of_one_twelfth():
    """METHOD 3.3: taking 1/12 off is -3.5 % wrong at .25 q, -14 % at .2, -76 % at .15."""
    for noise, published, digits in ((0.25, -3.5, 0.05), (0.2, -14.0, 0.5), (0.15, -76.0, 0.5)):
        naive = np.sqrt(rounded_variance(noise) - 1.0 / 12.0)
        assert 100.0 * (naive / noise - 1.0) == pytest.approx(published, abs=digits)


def test_variance_of_an_array():
    np.testing.assert_allclose(noise_variance([0.0, 10.0], dark=1.0, shot=0.5, fixed_pattern=0.01), [1.0, 7.0])
