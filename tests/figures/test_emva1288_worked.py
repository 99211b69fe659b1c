"""The worked numbers of the specification (EMVA1288 17, E1 to E17), in both profiles."""

import math

import numpy as np
import pytest

from fullwell.figures.emva1288.histogram import stack_histogram
from fullwell.figures.emva1288.line import fit_line, slope_through_origin
from fullwell.figures.emva1288.linearity import measure_linearity
from fullwell.figures.emva1288.nonuniformity import split_literal, stack_moments
from fullwell.figures.emva1288.package import PackageFigures, saturation_step, split_unfiltered
from fullwell.figures.emva1288.saturation import find_saturation
from fullwell.figures.emva1288.sensitivity import (
    QUANTIZATION,
    dark_variance,
    snr_model,
    threshold_at,
    threshold_electrons,
)
from fullwell.figures.emva1288.spectrogram import power_spectrum
from fullwell.figures.emva1288.spline_gate import basis, basis_slope
from fullwell.figures.emva1288.sweep import Sweep
from fullwell.model.irradiation import PLANCK, photons_per_pixel
from fullwell.statistics.pairs import pair_of

CASES = {
    "E3a": (0.4, 0.24, 1.0049333333, 15151.6667),
    "E3b": (0.098, 0.0778, 9.15, 51576.0),
    "E3d": (2.0, 1.6, 13 / 12, 2500.0),
}


def close(value: float, rel: float = 1e-9) -> object:
    return pytest.approx(value, rel=rel)


def package_figures(gain: float, responsivity: float, variance: float, photons: float) -> PackageFigures:
    return PackageFigures(
        saturation=0,
        fit_last=0,
        linearity_first=0,
        linearity_last=0,
        system_gain=gain,
        responsivity=responsivity,
        dark_variance=variance,
        saturation_photons=photons,
        linearity_min=None,
        linearity_max=None,
        linearity_offset=None,
        linearity_slope=None,
        dark_mean_slope=None,
        dark_variance_slope=None,
    )


def test_e1_photons_per_pixel():
    one = photons_per_pixel(area_um2=1, exposure_s=1e-3, wavelength_nm=1000, irradiance_uw_cm2=1)
    assert one == close(50.341125029)
    exact = photons_per_pixel(area_um2=1, exposure_s=1e-3, wavelength_nm=1000, irradiance_uw_cm2=1, planck=PLANCK)
    assert exact == close(50.341165675)
    found = photons_per_pixel(area_um2=11.9, exposure_s=2e-3, wavelength_nm=530, irradiance_uw_cm2=1.5)
    assert found == close(952.504426727)


def test_e2_a_pair_of_frames():
    first = np.array([[10, 12, 11], [13, 10, 10]], np.uint16)
    pair = pair_of(first, np.array([[11, 13, 11], [13, 12, 12]], np.uint16))
    assert (pair.means, pair.mean) == ((11.0, 12.0), 11.5)
    assert pair.temporal_variance == close(1 / 3)
    assert pair.spatial_variance == close(2 / 3)
    assert pair.filtered_variance is None


@pytest.mark.parametrize(
    ("case", "expected"),
    [
        ("E3a", (2.4, 3.055549517, 5.092582528, 9091.0, 2975.242244)),
        ("E3b", (30.725414396, 31.370342240, 39.515341124, 40945.028571, 1305.214595963)),
        ("E3d", (0.5, 1.221687836, 1.527109796, 2000.0, 1637.079408)),
    ],
)
def test_e3_thresholds_and_range(case, expected):
    dark_e, threshold_e, threshold_p, capacity_e, ratio = expected
    gain, responsivity, variance, photons = CASES[case]
    efficiency = responsivity / gain
    found = threshold_electrons((variance, gain))
    assert math.sqrt(variance - QUANTIZATION) / gain == close(dark_e)
    assert found == close(threshold_e)
    assert found / efficiency == close(threshold_p)
    assert threshold_at(1.0, variance, gain) == close(threshold_e)
    assert efficiency * photons == close(capacity_e, rel=1e-8)
    assert photons * efficiency / found == close(ratio, rel=1e-8)


@pytest.mark.parametrize(
    ("case", "threshold_e", "ratio"), [("E3a", 3.006159080, 3024.124725), ("E3d", 1.020416500, None)]
)
def test_e3_thresholds_of_the_package(case, threshold_e, ratio):
    found = package_figures(*CASES[case])
    assert found.threshold_e == close(threshold_e)
    if ratio is not None:
        photons = found.saturation_photons
        assert photons * found.quantum_efficiency / found.threshold_e == close(ratio, rel=1e-8)


def test_e3c_the_floor_of_quantization():
    variance, floored = dark_variance(0.15, 1000)
    assert floored
    assert math.sqrt(variance.value) == close(0.489897949)
    assert math.sqrt(variance.value - QUANTIZATION) / 0.02 == close(19.790570145)
    found = threshold_electrons((variance.value, 0.02))
    assert found == close(25.0)
    assert 16000 * 0.6 / found == close(384.0)


def test_e4_signal_to_noise():
    electrons = 0.6 * np.array([10.0, 100.0, 1000.0, 1e4])
    dark_e2 = 2.4**2 + QUANTIZATION / 0.4**2
    snr = snr_model(electrons, dark_e2=dark_e2)
    total = snr_model(electrons, dark_e2=dark_e2, dsnu_e2=0.49, prnu=0.0068)
    assert snr == pytest.approx([1.712132344, 7.369826610, 24.367688312, 77.419156122], rel=1e-9)
    assert total == pytest.approx([1.678855544, 7.333599078, 24.030446961, 68.503636990], rel=1e-9)
    variance = dark_e2 * 0.4**2
    assert threshold_at(10.0, variance, 0.4) / 0.6 == close(176.548784683)
    assert threshold_at(1.0, variance, 0.4) / 0.6 == close(5.092582528)


def test_e5_split_of_the_standard_and_of_the_package():
    average = np.array([[4.0, 6, 5], [8, 9, 10], [3, 5, 7], [9, 8, 10]])
    moments = stack_moments(average, frames=10, temporal=0.5)
    split = split_literal(moments)
    assert moments.measured == close(31 / 6)
    assert (split.total, split.column_means, split.row_means) == pytest.approx((307 / 60, 157 / 240, 239 / 60))
    assert (split.column, split.row, split.pixel) == pytest.approx((11 / 30, 18 / 5, 23 / 20))
    package = split_unfiltered(
        rows=4,
        columns=3,
        measured=float(average.var(ddof=1)),
        column_means=moments.column_means,
        row_means=moments.row_means,
        left=0.05,
    )
    found = (package.total, package.column, package.row, package.pixel)
    assert found == pytest.approx((5.586363636, 0.084848485, 3.224242424, 2.277272727), rel=1e-8)


def test_e7_linearity():
    y = np.array([101.0, 199, 302, 398, 505])
    found = measure_linearity(np.arange(1000.0, 5001.0, 1000.0), y, np.ones(5))
    assert found is not None
    assert (found.offset, found.slope) == pytest.approx((0.686460021, 0.100011078), rel=1e-8)
    expected = [0.300366898, -0.851291724, 0.425747393, -0.681447956, 0.850368397]
    assert found.deviation == pytest.approx(expected, rel=1e-8)
    assert found.error == close(0.621844474, rel=1e-8)


def test_e8_system_gain_with_its_sigma():
    x, y = np.array([100.0, 200, 300, 400]), np.array([41.0, 80, 119, 162])
    line = fit_line(x, y)
    assert (line.slope, line.slope_error, line.offset_error) == pytest.approx((0.402, 0.006928203, 1.897366596))
    assert line.offset == pytest.approx(0.0, abs=1e-12)
    assert slope_through_origin(x, y) == close(0.402)


def test_e9_dark_current():
    t = np.array([0.1, 0.3, 0.5, 0.7, 0.9, 1.1])
    mean = fit_line(t, np.array([64.10, 64.31, 64.48, 64.71, 64.90, 65.11]))
    variance = fit_line(t, np.array([1.02, 1.11, 1.17, 1.28, 1.33, 1.42]))
    assert (mean.slope, mean.slope_error, mean.offset) == pytest.approx((1.007142857, 0.015208304, 63.997380952))
    found = (variance.slope, variance.slope_error, variance.offset)
    assert found == pytest.approx((0.395714286, 0.015474359, 0.984238095), rel=1e-7)


def test_e10_spectrogram():
    row = 2 * np.cos(2 * np.pi * 3 * np.arange(16) / 16)
    power = power_spectrum(np.stack((row, row)))
    assert power[3] == close(16.0)
    assert 2 * math.sqrt(power.sum() / 16) == close(2.0)
    whole = power[0] + 2 * power[1:-1].sum() + power[-1]
    assert whole / 16 == close(row.var())


@pytest.mark.parametrize(("top", "width", "bins"), [(130.0, 0.75, 174), (63.75, 0.25, 256), (64.0, 0.5, 129)])
def test_e11_histogram(top, width, bins):
    values = np.array([0, 0.25, 0.25, 0.5, 0.75, 1, 1, 1.25, 2, top])
    found = stack_histogram(values, frames=4)
    assert (found.width, found.counts.size, found.counts.sum()) == (width, bins, 10)
    if top == 130.0:
        assert found.counts[[0, 1, 2, 173]].tolist() == [4, 4, 1, 1]
        assert found.centres[[0, 1, 173]].tolist() == [0.25, 1.0, 130.0]


def saturating(fractions: np.ndarray, means: np.ndarray) -> Sweep:
    return Sweep(
        n=10**6,
        exposure_s=means / 1e6,
        photons=means * 4,
        mean=means,
        dark_mean=np.full(means.size, 60.0),
        variance=np.full(means.size, 1500.0),
        dark_variance=np.ones(means.size),
        mean_difference=np.zeros(means.size),
        spatial_variance=np.zeros(means.size),
        top_fraction=fractions,
        dark_measured=np.ones(means.size, np.bool_),
    )


def test_e12_saturation_is_interpolated_in_z():
    z = np.array([4.0, 3.2, 2.4, 1.0])
    fractions = np.array([3.167124e-05, 6.871379e-04, 8.197536e-03, 0.1586553])
    sweep = saturating(fractions, np.array([3700.0, 3800.0, 3900.0, 4000.0]))
    found = find_saturation(sweep, top_code=4095.0, values_per_step=np.full(4, 2e6))
    share = (z[1] - 2.967737925) / (z[1] - z[2])
    assert (found.mode, found.bracket) == ("interpolated", (1, 2))
    assert found.mean == close(3800 + 100 * share, rel=1e-7)
    assert found.exposure == close(4 * found.mean)


@pytest.mark.parametrize("upper", [3970.0, 4095.0])
def test_saturation_that_the_noise_tells_lies_in_its_bracket(upper: float) -> None:
    sweep = saturating(np.array([0.0, 0.0, 1.0]), np.array([3700.0, 3800.0, upper]))
    found = find_saturation(sweep, top_code=4095.0, values_per_step=np.full(3, 2e6))
    assert (found.mode, found.bracket) == ("bracketed", (1, 2))
    assert found.mean == close(min(upper, 4094.5 - 2.967737925 * math.sqrt(1 + 1499 * found.signal / 3740)), rel=1e-6)


def test_e13_spline():
    x = np.array([0, 0.5, 1, 1.5, 2])
    assert basis(x) == pytest.approx([2 / 3, 0.479166667, 1 / 6, 1 / 48, 0], rel=1e-8)
    assert basis_slope(x) == pytest.approx([0, -0.625, -0.5, -0.125, 0])


def test_e15_saturation_of_the_package():
    assert saturation_step(np.array([1.0, 2, 3, 4, 5, 4, 1])) == 4
    assert saturation_step(np.array([1.0, 2, 3, 5, 4, 6, 1])) == 5
    assert saturation_step(np.array([1.0, 2, 3, 9, 4, 3, 3.5, 0])) == 3


def test_e17_constants():
    measured, floored = dark_variance(1.0, 10**6)
    assert not floored
    assert measured.std_error == close(0.00141421356, rel=1e-8)
    assert math.sqrt(0.24 - QUANTIZATION) == close(0.395811403)
