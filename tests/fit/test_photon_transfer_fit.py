import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.stats import norm

from fullwell.fit.gamma_likelihood import fit_gamma
from fullwell.fit.legacy.imatest import fit_legacy_imatest
from fullwell.fit.noise_coefficients import (
    CRITICAL_RATIO,
    dark_sensitivity_to_offset,
    fixed_pattern_test,
    k_coefficients,
)
from fullwell.fit.photon_transfer import (
    fit_burst_photon_transfer,
    fit_photon_transfer,
    photon_transfer_design,
)

N = 2500
SETS = 2000
FISHER = np.array([9.1, 14.5, 78.0])  # METHOD 1.6: 1-sigma error of the k's in percent, times sqrt(n)


def _fit_many(signal, variance, *, terms=3, n=N):
    return fit_gamma(
        photon_transfer_design(signal, terms=terms),
        variance,
        np.array(n - 1.0),
        low_signal=np.full(variance.shape, 1.0 / n),
    )


def _errors(fit):
    return np.sqrt(np.diagonal(fit.covariance, axis1=-2, axis2=-1))


@pytest.fixture
def many(chart):
    camera = chart()
    signal, variance = camera.simulate(np.random.default_rng(20240101), sets=SETS, n=N)
    return camera, signal, variance, _fit_many(signal, variance)


def test_T1_gamma_fit_is_unbiased_and_covers(many):  # noqa: N802 - METHOD's name of the test
    camera, _, _, fit = many
    assert fit.converged.all()
    k = np.sqrt(np.maximum(fit.coefficients, 0.0))
    bias = 100.0 * (k.mean(axis=0) / np.sqrt(camera.truth) - 1.0)
    assert np.all(np.abs(bias) <= [0.02, 0.03, 0.15]), bias
    covered = np.mean(np.abs(fit.coefficients - camera.truth) <= norm.ppf(0.975) * _errors(fit), axis=0)
    assert np.all((covered >= 0.935) & (covered <= 0.965)), covered


def test_T2_scatter_is_fishers_and_the_published_fit_is_noisier(many):  # noqa: N802 - METHOD's name of the test
    camera, signal, variance, fit = many
    truth = np.sqrt(camera.truth)
    scatter = (np.sqrt(np.maximum(fit.coefficients, 0.0)) / truth).std(axis=0)
    ratio = 100.0 * scatter / (FISHER / np.sqrt(N))
    assert np.all((ratio >= 0.95) & (ratio <= 1.05)), ratio
    truth_k = np.array(camera.k)
    for objective in ("sigma", "variance"):
        published = [
            fit_legacy_imatest(s, v, digital_maximum=camera.digital_maximum, objective=objective)
            for s, v in zip(signal[:400], variance[:400], strict=True)
        ]
        k = np.array([[one.k_dark.value, one.k_shot.value, one.k_fpn.value] for one in published])
        assert np.all((k / truth_k).std(axis=0) >= 1.4 * scatter)


@pytest.mark.parametrize("read_noise", [0.3, 1.0, 2.0])
def test_T3_low_read_noise(chart, read_noise):  # noqa: N802 - METHOD's name of the test
    sets, system_gain = 400, 0.5
    rng = np.random.default_rng(3)
    electrons = chart(flare=0.0, planes=(1.0,), digital_maximum=16383.0).signal_dn / system_gain
    noise = rng.standard_normal
    mean, variance = np.empty((sets, electrons.size)), np.empty((sets, electrons.size))
    for one in range(sets):
        expected = electrons[:, None] * (1.0 + 0.005 * noise((electrons.size, N)))
        pixels = system_gain * (rng.poisson(expected) + read_noise * noise(expected.shape))
        mean[one], variance[one] = pixels.mean(axis=1), pixels.var(axis=1, ddof=1)
    fit = _fit_many(mean, variance)
    truth = (system_gain * read_noise) ** 2
    dark, error = fit.coefficients[:, 0], _errors(fit)[:, 0]
    assert abs(dark.mean() / truth - 1.0) <= 0.01
    covered = np.mean(np.abs(dark - truth) <= norm.ppf(0.975) * error)
    assert 0.92 <= covered <= 0.98, covered
    weights = fit.effective_dof / (2.0 * fit.predicted**2)
    chi_square = np.sum(weights * (variance - fit.predicted) ** 2, axis=1) / (electrons.size - 3)
    assert 0.98 <= chi_square.mean() <= 1.02, chi_square.mean()
    if read_noise == 0.3:
        plain = fit_gamma(photon_transfer_design(mean, terms=3), variance, np.array(N - 1.0))
        unweighted = np.mean(np.abs(plain.coefficients[:, 0] - truth) <= norm.ppf(0.975) * _errors(plain)[:, 0])
        assert unweighted < 0.75  # METHOD 1.3: 63 % without the low-signal weights


@pytest.mark.parametrize("k_fpn", [0.0, 3e-4, 6e-4, 1e-3, 1.5e-3])
def test_T6_intervals_cover_at_the_boundary(chart, k_fpn):  # noqa: N802 - METHOD's name of the test
    sets = 4000
    camera = chart(k=(1.672e-4, 5.554e-3, k_fpn))
    signal, variance = camera.simulate(np.random.default_rng(6), sets=sets, n=N)
    fit = _fit_many(signal, variance)
    intervals = np.array(
        [
            k_coefficients(fit.coefficients[one], fit.covariance[one], digital_maximum=16383.0).k_fpn.ci95
            for one in range(sets)
        ]
    )
    covered = np.mean((intervals[:, 0] <= k_fpn) & (k_fpn <= intervals[:, 1]))
    assert 0.94 <= covered <= 0.99, covered


def test_T6_likelihood_ratio_has_its_size(chart):  # noqa: N802 - METHOD's name of the test
    sets = 4000
    camera = chart(k=(1.672e-4, 5.554e-3, 0.0))
    signal, variance = camera.simulate(np.random.default_rng(66), sets=sets, n=N)
    curve, line = _fit_many(signal, variance), _fit_many(signal, variance, terms=2)

    def deviance(fit):
        ratio = variance / fit.predicted
        return np.sum(fit.effective_dof * (ratio - 1.0 - np.log(ratio)), axis=1)

    ratio = np.where(curve.coefficients[:, 2] > 0.0, deviance(line) - deviance(curve), 0.0)
    size = np.mean(ratio > CRITICAL_RATIO)
    assert 0.04 <= size <= 0.06, size
    for one in range(5):
        test = fixed_pattern_test(signal[one], variance[one], N - 1, n=N)
        assert test.ratio == pytest.approx(max(ratio[one], 0.0), abs=1e-6)
        assert test.significant == (ratio[one] > CRITICAL_RATIO)


def test_one_set_is_fitted_as_in_the_batch(many):
    _, signal, variance, fit = many
    for one in range(5):
        alone = fit_photon_transfer(signal[one], variance[one], N - 1, n=N, reject_outliers=False)
        np.testing.assert_allclose(alone.coefficients, fit.coefficients[one], rtol=1e-8)
        np.testing.assert_allclose(np.sqrt(np.diagonal(alone.covariance)), _errors(fit)[one], rtol=1e-8)


def test_a_general_optimizer_on_the_likelihood_agrees(chart):
    camera = chart()
    signal, variance = (values[0] for values in camera.simulate(np.random.default_rng(5), sets=1, n=N))
    scale = camera.truth

    def negative_log_likelihood(scaled):
        model = photon_transfer_design(signal, terms=3) @ (scaled * scale)
        return 0.5 * (N - 1) * np.sum(np.log(model) + variance / model) if model.min() > 0.0 else np.inf

    oracle = minimize(negative_log_likelihood, np.ones(3), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-9})
    fit = fit_photon_transfer(signal, variance, N - 1, n=None, reject_outliers=False)
    errors = np.sqrt(np.diagonal(fit.covariance))
    np.testing.assert_allclose((fit.coefficients - oracle.x * scale) / errors, 0.0, atol=1e-3)


def test_goodness_of_fit_has_its_size_and_misfit_scales_errors(many):
    _, signal, variance, _ = many
    fits = [
        fit_photon_transfer(s, v, N - 1, n=N, reject_outliers=False)
        for s, v in zip(signal[:1000], variance[:1000], strict=True)
    ]
    assert all(fit.dof is None for fit in fits if not fit.misfit)
    share = np.mean([fit.misfit for fit in fits])
    assert abs(share - 0.01) <= 4.0 * np.sqrt(0.01 * 0.99 / len(fits))
    bent = variance[0] * (1.0 + 0.1 * np.sin(np.arange(variance[0].size)))
    misfit = fit_photon_transfer(signal[0], bent, N - 1, n=N, reject_outliers=False)
    assert misfit.misfit
    assert misfit.dof == misfit.deviance_dof == bent.size - 3
    plain = _fit_many(signal[:1], bent[None, :])
    scale = np.sqrt(misfit.deviance / misfit.deviance_dof)
    np.testing.assert_allclose(np.sqrt(np.diagonal(misfit.covariance)), scale * _errors(plain)[0], rtol=1e-6)


def test_dusty_patches_are_dropped_and_clean_ones_kept(chart):
    camera = chart()
    signal, variance = camera.simulate(np.random.default_rng(18), sets=300, n=N)
    clean = [fit_photon_transfer(s, v, N - 1, n=N) for s, v in zip(signal, variance, strict=True)]
    dropped = np.mean([np.sum(~fit.used) for fit in clean])
    assert dropped <= 0.007 + 4.0 * np.sqrt(0.007 / 300)  # METHOD 1.8: .007 patches a set
    dusty = variance.copy()
    dusty[:, [40, 70, 100]] *= 1.3
    fits = [fit_photon_transfer(s, v, N - 1, n=N) for s, v in zip(signal, dusty, strict=True)]
    inside = np.mean(
        [np.abs(fit.coefficients - camera.truth) <= 1.96 * np.sqrt(np.diagonal(fit.covariance)) for fit in fits], axis=0
    )
    assert np.all(inside >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / 300))
    assert np.mean([np.sum(~fit.used[[40, 70, 100]]) for fit in fits]) > 2.9


def test_at_most_a_tenth_of_the_points_is_dropped(chart):
    """Every eighth point is far too noisy: the others agree, so only the cap keeps the rest of those."""
    camera = chart()
    noisy = np.arange(camera.signal_dn.size) % 8 == 0
    fit = fit_photon_transfer(camera.signal_dn, camera.variance_dn2 * np.where(noisy, 1.6, 1.0), N - 1, n=N)
    assert np.sum(~fit.used) == int(0.1 * noisy.size)
    assert noisy[~fit.used].all()
    assert fit.misfit


def test_a_misfit_everywhere_has_no_outliers_and_its_errors_cover(chart):
    """Scatter beyond the model's, alike at every point: none is an outlier, and scaled errors cover (Student)."""
    camera, sets = chart(), 400
    rng = np.random.default_rng(19)
    signal, variance = camera.simulate(rng, sets=sets, n=N)
    variance = variance * (1.0 + 0.06 * rng.standard_normal(variance.shape))
    fits = [fit_photon_transfer(s, v, N - 1, n=N) for s, v in zip(signal, variance, strict=True)]
    assert all(fit.misfit for fit in fits)
    assert np.mean([np.sum(~fit.used) for fit in fits]) < 0.1
    covered = np.mean([fit.system_gain.ci95[0] <= camera.truth[1] <= fit.system_gain.ci95[1] for fit in fits])
    assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)


def test_burst_fit_separates_all_four_causes(chart):
    """Closed loop: temporal and spatial variances drawn from their laws, pulls standard normal (METHOD 1.4)."""
    camera, frames, sets = chart(), 4, 400
    rng = np.random.default_rng(14)
    a, b, c = camera.truth
    e = 0.3 * a
    signal = camera.signal_dn
    temporal, spatial = a + b * signal, (a + b * signal) / frames + c * signal**2 + e
    pulls = []
    for _ in range(sets):
        fit = fit_burst_photon_transfer(
            signal + rng.normal(size=signal.size) * np.sqrt(temporal / (N * frames)),
            temporal * rng.chisquare(N * (frames - 1), signal.size) / (N * (frames - 1)),
            N * (frames - 1),
            spatial * rng.chisquare(N - 6, signal.size) / (N - 6),
            N - 6,
            frames=frames,
            n=N * frames,
            reject_outliers=False,
        )
        pulls.append((fit.coefficients - [a, b, c, e]) / np.sqrt(np.diagonal(fit.covariance)))
    mean, covered = np.mean(pulls, axis=0), np.mean(np.abs(pulls) <= 1.96, axis=0)
    assert np.all(np.abs(mean) <= 4.0 / np.sqrt(sets)), mean
    assert np.all(np.abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)), covered
    together, covariance = fit.single_frame()
    assert together[0] == pytest.approx(fit.intercept.value + fit.dsnu_variance.value)
    assert covariance[1, 1] == pytest.approx(fit.system_gain.std_error**2)


def test_pooled_tiles_count_their_mean_square(chart):
    """Tiles of unequal signal pooled into one point: C multiplies the mean of S^2, not the square of the mean."""
    camera = chart()
    signal, (a, b, c) = camera.signal_dn, camera.truth
    mean_square = 1.1 * signal**2
    spatial = (a + b * signal) / 4 + c * mean_square + a
    arguments = (signal, a + b * signal, 10000, spatial, 2494)
    fit = fit_burst_photon_transfer(*arguments, frames=4, n=None, mean_square_dn2=mean_square)
    np.testing.assert_allclose(fit.coefficients, [a, b, c, a], rtol=1e-8)


def test_one_pattern_seen_often_is_one_draw(chart):
    camera = chart()
    signal, (a, b, c) = camera.signal_dn, camera.truth
    arguments = (signal, a + b * signal, 10000, (a + b * signal) / 4 + c * signal**2 + a, 2494)
    free = fit_burst_photon_transfer(*arguments, frames=4, n=None)
    tied = fit_burst_photon_transfer(*arguments, frames=4, n=None, pattern_pixels=2500.0)
    assert tied.prnu_variance.std_error == pytest.approx(
        np.hypot(free.prnu_variance.std_error, c * np.sqrt(2.0 / 2500.0)), rel=1e-6
    )
    assert tied.system_gain.std_error == pytest.approx(free.system_gain.std_error)


@settings(max_examples=30)
@given(scale=st.floats(0.01, 100.0), seed=st.integers(0, 1000))
def test_units_and_order_of_the_points_do_not_matter(scale, seed):
    rng = np.random.default_rng(seed)
    signal = np.linspace(-0.5, 3000.0, 40)
    variance = (4.0 + 0.5 * signal + 2e-5 * signal**2) * rng.chisquare(999, 40) / 999
    fit = fit_photon_transfer(signal, variance, 999, n=1000, reject_outliers=False)
    order = rng.permutation(40)
    other = fit_photon_transfer(scale * signal[order], scale**2 * variance[order], 999, n=1000, reject_outliers=False)
    errors = np.sqrt(np.diagonal(fit.covariance))
    units = np.array([scale**2, scale, 1.0])
    np.testing.assert_allclose((other.coefficients / units - fit.coefficients) / errors, 0.0, atol=1e-6)
    assert other.deviance == pytest.approx(fit.deviance, rel=1e-6)


def test_noiseless_points_are_met_exactly(chart):
    camera = chart()
    fit = fit_photon_transfer(camera.signal_dn, camera.variance_dn2, N - 1, n=N)
    np.testing.assert_allclose(fit.coefficients, camera.truth, rtol=1e-9)
    assert fit.used.all()


def test_too_few_points_are_refused():
    with pytest.raises(ValueError, match="3 coefficients"):
        fit_photon_transfer([1.0, 2.0], [1.0, 2.0], 10, n=None)


def test_points_without_a_gamma_law_take_no_part(chart):
    """Constant tiles, where everything is clipped, and tiles too small for a variance."""
    camera = chart()
    variance, dof = camera.variance_dn2.copy(), np.full(camera.signal_dn.size, N - 1.0)
    variance[3], variance[4], dof[5] = 0.0, np.nan, 0.0
    fit = fit_photon_transfer(camera.signal_dn, variance, dof, n=N)
    np.testing.assert_allclose(fit.coefficients, camera.truth, rtol=1e-9)
    np.testing.assert_array_equal(np.flatnonzero(~fit.used), [3, 4, 5])
    assert np.all(np.isnan(fit.residuals[3:6]))
    assert fit.deviance_dof == camera.signal_dn.size - 3 - 3


def test_too_few_levels_are_refused():
    with pytest.raises(ValueError, match="different levels"):
        fit_photon_transfer([100.0, 100.0, 200.0, 200.0], [1.0, 1.1, 2.0, 2.1], 10, n=None)


def test_error_of_the_offset_widens_k_dark_alone(chart):
    camera = chart()
    fit = fit_photon_transfer(camera.signal_dn, camera.variance_dn2, N - 1, n=N)
    known, guessed = (
        k_coefficients(*fit.single_frame(), digital_maximum=16383.0, offset_std_error_dn=error) for error in (0.0, 0.29)
    )
    by_offset = dark_sensitivity_to_offset(fit.coefficients) * 0.29 * known.k_dark.value
    assert guessed.k_dark.std_error == pytest.approx(np.hypot(known.k_dark.std_error, by_offset))
    assert guessed.k_shot.std_error == known.k_shot.std_error


def test_k_dark_is_known_as_well_as_the_offset(chart):
    camera, trials = chart(), 2000
    rng = np.random.default_rng(18)
    off, errors = rng.normal(0.0, 0.3, trials), 0.3 * np.sqrt(rng.chisquare(1, trials))
    held = 0
    for shift, error in zip(off, errors, strict=True):
        coefficients = camera.truth + np.array([camera.truth[1] * shift, 0.0, 0.0])
        ks = k_coefficients(
            coefficients,
            np.diag((1e-3 * camera.truth) ** 2),
            digital_maximum=16383.0,
            offset_std_error_dn=error,
            offset_dof=1.0,
        )
        low, high = ks.k_dark_variance.ci95 or (0.0, 0.0)
        held += low <= camera.truth[0] / 16383.0**2 <= high
    # 95 %, and four Monte Carlo errors; 70 % where the offset's degrees of freedom are forgotten
    assert held / trials >= 0.95 - 4.0 * np.sqrt(0.95 * 0.05 / trials)
