import numpy as np
import pytest

from fullwell.fit.black_level import declared, fuse
from fullwell.fit.noise_coefficients import dark_sensitivity_to_offset
from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.fit.unidentified_offset import offset_range, unidentified_dark

N = 2500
OFFSET = 511.0


def _fit(means, variance, offset):
    return fit_photon_transfer(means - offset, variance, N - 1, n=None, reject_outliers=False)


def test_T8_no_fit_tells_the_offset(chart):  # noqa: N802 - METHOD's name of the test
    """-2 ln L of the best fit is the same for every offset, while k_dark runs from imaginary upwards."""
    camera = chart(flare=2.4e-4)
    signal, variance = (part[0] for part in camera.simulate(np.random.default_rng(8), sets=1, n=N))
    offsets = np.arange(480.0, 513.5, 0.5)
    deviance, dark = [], []
    for offset in offsets:
        fit = _fit(signal + OFFSET, variance, offset)
        assert not fit.misfit
        deviance.append(fit.deviance)
        dark.append(fit.coefficients[0])
    assert np.ptp(deviance) < 1e-4, np.ptp(deviance)
    assert dark[0] < 0.0
    k_dark = np.sqrt(dark[-1]) / camera.digital_maximum
    assert k_dark > camera.k[0]
    per_dn = dark_sensitivity_to_offset(_fit(signal + OFFSET, variance, OFFSET).coefficients)
    assert per_dn == pytest.approx(0.0337, abs=0.0002)
    step = np.diff(np.log(np.array(dark)[np.abs(offsets - OFFSET) <= 0.5])) / 2.0 / 0.5
    assert step.mean() == pytest.approx(per_dn, rel=1e-2)


def test_T8_k_dark_is_no_more_than_an_interval(chart):  # noqa: N802 - METHOD's name of the test
    """A declared level identifies nothing; k_dark's interval holds the truth wherever in the range the offset is."""
    assert not fuse([declared(OFFSET)]).identified
    camera = chart(flare=2.4e-4)
    rng, sets, covered, plain = np.random.default_rng(88), 300, [], []
    signal, variance = camera.simulate(rng, sets=sets, n=N)
    for means, scatter in zip(signal + OFFSET, variance, strict=True):
        fit = _fit(means, scatter, OFFSET + rng.uniform(-0.5, 0.5))
        found = unidentified_dark(
            *fit.single_frame(), shifts_dn=(-0.5, 0.5), digital_maximum=camera.digital_maximum, dof=fit.dof
        )
        low, high = found.k_dark.ci95
        covered.append(low <= camera.k[0] <= high)
        error = np.sqrt(fit.covariance[0, 0])
        plain.append(abs(fit.coefficients[0] - camera.truth[0]) <= 1.96 * error)
        assert (high - low) / found.k_dark.value >= 2.0 * 0.5 * found.sensitivity
    assert np.mean(covered) >= 0.95
    assert np.mean(plain) < 0.5


def test_the_interval_follows_the_exact_shift(chart):
    """METHOD 2.1: an offset higher by d makes A of A + B d + C d^2; ends are those, and the fit's error beyond."""
    camera = chart()
    coefficients, scale = camera.truth, camera.digital_maximum**-2
    covariance = np.diag([0.1, 1e-3, 1e-7]) ** 2
    found = unidentified_dark(coefficients, covariance, shifts_dn=(-2.0, 5.0), digital_maximum=camera.digital_maximum)
    ends = []
    for shift, side in ((-2.0, -1.0), (5.0, 1.0)):
        powers = np.array([1.0, shift, shift**2])
        ends.append(powers @ coefficients + side * 1.959963984540054 * np.sqrt(powers @ covariance @ powers))
    assert found.k_dark_variance.ci95 == pytest.approx(tuple(scale * end for end in ends), rel=1e-12)
    assert found.k_dark.ci95 == pytest.approx(tuple(np.sqrt(scale * np.array(ends))), rel=1e-12)
    assert found.k_dark.value == pytest.approx(camera.k[0])
    spread = coefficients[1] * 7.0 / np.sqrt(12.0)
    assert found.k_dark_variance.std_error == pytest.approx(scale * np.hypot(0.1, spread))


def test_physics_alone_bounds_the_offset(chart):
    """No evidence at all: A is not negative, no patch lies below black; k_dark is at most the darkest patch's noise."""
    camera = chart(flare=1e-3)
    darkest = float(camera.signal_dn.min())
    low, high = offset_range(camera.truth, darkest_dn=darkest)
    assert high == darkest
    a, b, c = camera.truth
    assert a + b * low + c * low**2 == pytest.approx(0.0, abs=1e-9)
    found = unidentified_dark(
        camera.truth, np.zeros((3, 3)), shifts_dn=(low, high), digital_maximum=camera.digital_maximum
    )
    noise = np.sqrt(a + b * darkest + c * darkest**2) / camera.digital_maximum
    assert found.k_dark.ci95 == pytest.approx((0.0, noise), abs=1e-9)
