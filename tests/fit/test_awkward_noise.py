import numpy as np
import pytest

from fullwell.fit.correlated_noise import dof_divisor
from fullwell.fit.gamma_likelihood import fit_gamma
from fullwell.fit.photon_transfer import fit_photon_transfer, photon_transfer_design
from fullwell.fit.variance_components import temporal_variance

EDGE = 50
N = EDGE**2


def _covered(coefficients, covariance, truth):
    error = np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))
    return np.mean(np.abs(coefficients - truth) <= 1.96 * error, axis=0)


def test_T20_three_dusty_patches(chart):  # noqa: N802 - METHOD's name of the test
    """Variances of three patches 1.3 times too large: coverage of C falls to about a half and is won back."""
    camera, sets = chart(), 1000
    signal, variance = camera.simulate(np.random.default_rng(20), sets=sets, n=N)
    variance[:, [5, 45, 110]] *= 1.3
    share = np.full(variance.shape, 1.0 / N)
    plain = fit_gamma(photon_transfer_design(signal, terms=3), variance, np.array(N - 1.0), low_signal=share)
    assert _covered(plain.coefficients, plain.covariance, camera.truth).min() < 0.7
    fits = [fit_photon_transfer(s, v, N - 1, n=N) for s, v in zip(signal, variance, strict=True)]
    covered = _covered(
        np.array([fit.coefficients for fit in fits]), np.array([fit.covariance for fit in fits]), camera.truth
    )
    assert np.all(covered >= 0.93), covered


@pytest.mark.parametrize(("share", "divisor"), [(0.1, 1.49), (0.3, 5.41)])
def test_T20_row_noise(chart, share, divisor):  # noqa: N802 - METHOD's name of the test
    """Rows of a 50 x 50 patch share 10 or 30 % of the dark variance: by the exact law of two mean squares."""
    camera, sets = chart(), 2000
    rng = np.random.default_rng(201)
    row = share * camera.truth[0]
    pixel, shape = camera.variance_dn2 - row, (sets, camera.signal_dn.size)
    between = (EDGE * row + pixel) * rng.chisquare(EDGE - 1, shape)
    variance = (between + pixel * rng.chisquare(N - EDGE, shape)) / (N - 1)
    lost = row / (EDGE + 1)
    signal = camera.signal_dn + rng.standard_normal(shape) * np.sqrt(camera.variance_dn2 / N + row / EDGE)
    truth = camera.truth - [lost, 0.0, 0.0]
    dividers = np.array([dof_divisor(rows=EDGE, columns=EDGE, row_share=row / total) for total in camera.variance_dn2])
    assert dof_divisor(rows=EDGE, columns=EDGE, row_share=share) == pytest.approx(divisor, abs=0.005)
    scatter = variance.var(axis=0, ddof=1) / (2.0 * (camera.variance_dn2 - lost) ** 2 / (N - 1))
    np.testing.assert_allclose(scatter / dividers, 1.0, atol=0.2)
    design = photon_transfer_design(signal, terms=3)
    covered = []
    for dof in (np.full(dividers.shape, N - 1.0), (N - 1.0) / dividers):
        fit = fit_gamma(design, variance, dof, low_signal=np.full(variance.shape, 1.0 / N))
        covered.append(_covered(fit.coefficients, fit.covariance, truth))
    untreated, treated = covered
    assert untreated[0] < 0.92
    assert np.all(treated >= 0.93), treated


def test_T20_telegraph_pixels(mean_squares_of):  # noqa: N802 - METHOD's name of the test
    """One pixel in a hundred jumps by 8 DN either way: the scatter of the pixels' variances sets the error."""
    frames, edge, sets, noise = 10, 40, 400, 2.0
    rng = np.random.default_rng(202)
    truth = noise**2 + 0.01 * 64.0
    covered = {"chi-square": 0, "scatter": 0}
    for _ in range(sets // 20):
        x = noise * rng.standard_normal((20, frames, edge, edge))
        jumping = rng.random((20, 1, edge, edge)) < 0.01
        x += np.where(jumping, rng.choice([-8.0, 8.0], x.shape), 0.0)
        per_pixel = x.var(axis=1, ddof=1).reshape(20, -1)
        for squares, scatter in zip(mean_squares_of(x), per_pixel.var(axis=1, ddof=1), strict=True):
            found = temporal_variance(squares, (frames, edge, edge), pixel_scatter_dn4=float(scatter))
            by_chi_square = found.value * np.sqrt(2.0 / (edge**2 * (frames - 1)))
            covered["scatter"] += found.ci95[0] <= truth <= found.ci95[1]
            covered["chi-square"] += abs(found.value - truth) <= 1.96 * by_chi_square
    assert covered["chi-square"] / sets < 0.88
    assert covered["scatter"] / sets >= 0.93
