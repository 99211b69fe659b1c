import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest

from fullwell.figures.conversions import to_electrons, to_volts
from fullwell.figures.dynamic_range import dynamic_range
from fullwell.figures.ratios import ratio
from fullwell.figures.saturation import last_consistent_level, plateau, temporal_variance_peak
from fullwell.figures.snr import snr_curve, snr_maximum
from fullwell.units import DN, DN2, DN_PER_ELECTRON, DN_PER_SECOND, VOLT, Measured, combined_dof, square_root

A6000 = np.array([1.672e-4, 5.554e-3, 5.477e-3]) ** 2
NO_ERROR = np.zeros((3, 3))


def test_conversion_errors_follow_student():
    rng = np.random.default_rng(70)
    sets, pulls, covered = 4000, [], []
    for _ in range(sets):
        noise_error, system_gain_error = 0.05 * np.sqrt(rng.chisquare(5) / 5), 0.005 * np.sqrt(rng.chisquare(8) / 8)
        noise = Measured.student(rng.normal(2.0, 0.05), noise_error, 5.0, DN)
        system_gain = Measured.student(rng.normal(0.5, 0.005), system_gain_error, 8.0, DN_PER_ELECTRON)
        electrons = to_electrons(noise, system_gain)
        pulls.append((electrons.value - 4.0) / electrons.std_error)
        covered.append(electrons.ci95[0] <= 4.0 <= electrons.ci95[1])
    assert abs(np.mean(covered) - 0.95) <= 4.0 * math.sqrt(0.95 * 0.05 / sets)
    dof = combined_dof((0.05 / 0.5, 5.0), (4.0 * 0.01, 8.0))
    assert kstest(pulls, "t", args=(dof,)).pvalue > 1e-3


def test_conversion_keeps_units_and_asymmetric_intervals():
    system_gain = Measured.normal(0.5, 0.0, DN_PER_ELECTRON)
    assert to_electrons(Measured.normal(1.0, 0.1, DN2), system_gain).unit == "e-^2"
    assert to_electrons(Measured.normal(1.0, 0.1, DN2), system_gain).value == 4.0
    assert to_electrons(Measured.normal(1.0, 0.1, DN_PER_SECOND), system_gain).unit == "e-/s"
    limit = square_root(Measured.normal(-0.1, 0.2, DN2), DN)
    electrons = to_electrons(limit, Measured.normal(0.5, 0.01, DN_PER_ELECTRON))
    assert (electrons.value, electrons.std_error) == (0.0, None)
    assert electrons.ci95 == pytest.approx((0.0, limit.ci95[1] / 0.5))
    skewed = Measured.interval(1.0, 0.2, (0.8, 1.6), DN)
    assert to_electrons(skewed, system_gain).ci95 == pytest.approx((1.6, 3.2))
    with pytest.raises(ValueError, match="DN"):
        to_electrons(Measured.exact(1.0, VOLT), system_gain)
    with pytest.raises(ValueError, match="above zero"):
        to_electrons(Measured.exact(1.0, DN), Measured.normal(-1.0, 0.1, DN_PER_ELECTRON))


def test_brackets_in_electrons_hold_a_truth_on_either_end():
    """A full pixel lies on the upper end of the bracket that exposures leave; the system gain is an estimate too."""
    rng = np.random.default_rng(6)
    bracket = Measured.interval(2000.0, 2000.0 / np.sqrt(12.0), (1000.0, 3000.0), DN)
    gains = [Measured.normal(value, 0.005, DN_PER_ELECTRON) for value in 1.0 + 0.005 * rng.standard_normal(4000)]
    ends = np.array([to_electrons(bracket, one).ci95 for one in gains])
    within = np.array([(ends[:, 0] < 1000.0).mean(), (ends[:, 1] > 3000.0).mean()])
    np.testing.assert_allclose(within, 0.975, atol=5.0 * np.sqrt(0.975 * 0.025 / 4000))


def test_volts_are_exact():
    """METHOD 4.2: .064 DN/s of a 0.459 V swing over 1023 codes are 28.7 uV/s."""
    rate = to_volts(Measured.normal(0.064, 0.001, DN_PER_SECOND), 0.459 / 1023)
    assert rate.value == pytest.approx(28.7e-6, abs=0.05e-6)
    assert rate.std_error == pytest.approx(rate.value / 64.0)
    assert rate.unit == "V/s"


def test_published_dynamic_range():
    """METHOD 8: the A6000's coefficients give 73.98 dB (V_sat/V_1), not the published 75.2 dB; SNR maximum 41.96 dB."""
    saturation = Measured.exact(0.9169, DN)
    found = dynamic_range(A6000, NO_ERROR, saturation)
    assert found.range.decibel.value == pytest.approx(73.98, abs=0.005)
    assert found.range.stops.value == pytest.approx(math.log2(found.range.plain.value))
    assert snr_maximum(A6000, NO_ERROR, saturation).total.decibel.value == pytest.approx(41.96, abs=0.005)
    assert float(snr_curve(0.9169, A6000)) == pytest.approx(10 ** (41.96 / 20), rel=1e-3)


def test_published_snr_maxima_of_the_sony():
    """METHOD 8: total noise at C_sat 38.39 dB, shot only 39.21 dB; EMVA 39.59 dB from 9091 e-."""
    k_shot2, k_fpn2 = 0.010006**2, 0.00499**2
    coefficients = np.array([0.0003207**2, k_shot2, k_fpn2])
    found = snr_maximum(coefficients, NO_ERROR, Measured.exact(8334.0 * k_shot2, DN))
    assert found.total.decibel.value == pytest.approx(38.39, abs=0.01)
    assert found.shot_only.decibel.value == pytest.approx(39.21, abs=0.005)
    emva = snr_maximum(np.array([0.0, 1.0, 0.0]), NO_ERROR, Measured.exact(9091.0, DN))
    assert emva.shot_only.decibel.value == pytest.approx(39.59, abs=0.005)


def test_delta_method_covers():
    rng = np.random.default_rng(71)
    truth = np.array([7.5, 0.5, 3e-5])
    covariance = np.diag([0.05, 0.003, 1e-6]) ** 2
    covariance[0, 1] = covariance[1, 0] = -0.4 * 0.05 * 0.003
    covariance[1, 2] = covariance[2, 1] = -0.5 * 0.003 * 1e-6
    saturation_error, sets = 30.0, 3000
    exact = dynamic_range(truth, NO_ERROR, Measured.exact(15000.0, DN), snr=10.0).range.decibel.value
    best = snr_maximum(truth, NO_ERROR, Measured.exact(15000.0, DN))
    pulls = []
    for values in rng.multivariate_normal(truth, covariance, sets):
        saturation = Measured.normal(rng.normal(15000.0, saturation_error), saturation_error, DN)
        decibel = dynamic_range(values, covariance, saturation, snr=10.0).range.decibel
        maxima = snr_maximum(values, covariance, saturation)
        pulls.append(
            [
                (decibel.value - exact) / decibel.std_error,
                (maxima.total.decibel.value - best.total.decibel.value) / maxima.total.decibel.std_error,
                (maxima.shot_only.plain.value - best.shot_only.plain.value) / maxima.shot_only.plain.std_error,
            ]
        )
    covered = np.mean(np.abs(pulls) <= 1.96, axis=0)
    assert np.all(np.abs(covered - 0.95) <= 4.0 * math.sqrt(0.95 * 0.05 / sets)), covered


def test_what_cannot_be_told_is_refused():
    with pytest.raises(ValueError, match="never reaches"):
        dynamic_range(np.array([1.0, 0.5, 1.0]), NO_ERROR, Measured.exact(100.0, DN))
    vague = np.diag([1e-3, 0.0, 0.0]) ** 2
    with pytest.raises(ValueError, match="tells nothing"):  # it ended in an overflow
        dynamic_range(np.array([1e-9, 1e-9, 1e-9]), vague, Measured.exact(100.0, DN))
    with pytest.raises(ValueError, match="positive at saturation"):
        snr_maximum(np.array([-100.0, 0.5, 0.0]), NO_ERROR, Measured.exact(100.0, DN))


@given(value=st.floats(1.0, 1e6), error=st.floats(1e-6, 0.1))
def test_a_ratio_is_the_same_in_every_dress(value, error):
    dressed = ratio(value, error, None)
    assert dressed.decibel.value == pytest.approx(20.0 * math.log10(value), abs=1e-9)
    low, high = dressed.plain.ci95
    assert dressed.decibel.ci95 == pytest.approx((20.0 * math.log10(low), 20.0 * math.log10(high)), abs=1e-9)
    assert dressed.stops.ci95 == pytest.approx((math.log2(low), math.log2(high)), abs=1e-9)


def test_variance_peak_with_its_bracket():
    signal = np.array([1000.0, 100.0, 500.0, 3900.0, 3000.0, 2000.0])
    variance = np.array([500.0, 50.0, 250.0, 10.0, 1400.0, 1000.0])
    found = temporal_variance_peak(signal, variance, np.where(signal > 3500.0, 0.9, 0.0))
    assert found.signal.value == 3000.0
    assert found.signal.ci95 == (2000.0, 3900.0)
    assert found.signal.std_error == pytest.approx(1900.0 / math.sqrt(12.0))
    assert found.flags == ("adc-limited", "grid-limited")


def test_ends_of_a_bracket_are_as_doubtful_as_their_levels():
    """A pixel that is full lies on the upper end itself, so the interval must hold what the level's error allows."""
    signal, variance = [1000.0, 2000.0, 3000.0], [500.0, 1000.0, 10.0]
    found = temporal_variance_peak(signal, variance, [0.0, 0.0, 0.0], std_error_dn=[1.0, 1.0, 2.0])
    assert found.signal.ci95 == pytest.approx((1000.0 - 1.959964, 3000.0 + 2.0 * 1.959964))


def test_variance_that_still_rises_is_a_lower_bound():
    found = temporal_variance_peak([1.0, 2.0, 3.0], [1.0, 2.0, 3.0], [0.0, 0.0, 0.0])
    assert found.flags == ("lower-bound",)
    assert (found.signal.std_error, found.signal.ci95) == (None, None)


def test_plateau():
    assert plateau([1.0, 2.0, 4.0], [0.0, 0.0, 0.0], [0.1, 0.1, 0.1]) is None
    found = plateau([1000.0, 3990.0, 4000.0], [0.0, 0.6, 0.9], [0.1, 0.1, 0.1])
    assert found is not None
    assert (found.signal.value, found.flags) == (4000.0, ("adc-limited",))
    soft = plateau([1000.0, 3990.0, 4000.0], [0.0, 0.0, 0.0], [0.1, 0.1, 0.1])
    assert soft is not None
    assert soft.flags == ()


def test_last_consistent_level():
    found = last_consistent_level([3.0, 1.0, 2.0, 4.0], [0.5, 0.1, -3.0, -60.0])
    assert found is not None
    assert found.signal.value == 3.0
    assert found.signal.ci95 == (3.0, 4.0)
    assert last_consistent_level([1.0], [9.0]) is None
    every = last_consistent_level([1.0, 2.0], [0.0, 0.0])
    assert every is not None
    assert every.flags == ("lower-bound",)
