import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from fullwell.fit.exposure_bracket import fit_exposure_bracket, solve_bracket
from fullwell.fit.legacy.chart import legacy_offset
from fullwell.fit.offset_drift import frame_drift, repeat_levels

OFFSET = 511.0
SETS = 200


def _bracket(rng, camera, ratios, *, n, sets=SETS, bend=0.0):
    """Means and variances of the means, shapes (sets, E, N); response x = s - bend s^2 / D."""
    light = np.array(ratios)[:, None] * camera.signal_dn
    level = light - bend * light**2 / camera.digital_maximum
    a, b, c = camera.truth
    variance = a + b * level + c * level**2
    shape = (sets, *variance.shape)
    measured = variance * rng.chisquare(n - 1, shape) / (n - 1)
    return OFFSET + level + rng.standard_normal(shape) * np.sqrt(variance / n), measured / n


@pytest.mark.parametrize(("n", "scatter", "bias"), [(2500, 0.006, 0.0017), (10000, 0.003, 0.0009)])
def test_T9_bracket_finds_the_offset(chart, n, scatter, bias):  # noqa: N802 - METHOD's name of the test
    means, variances = _bracket(np.random.default_rng(9), chart(flare=2.4e-4), (1.0, 0.125), n=n)
    found = solve_bracket(means, variances)
    assert abs(found.offset.mean() - OFFSET) <= bias
    assert 0.8 <= found.offset.std() / scatter <= 1.2, found.offset.std()
    error = np.sqrt(found.covariance[:, 0, 0])
    covered = np.mean(np.abs(found.offset - OFFSET) <= 1.96 * error)
    assert abs(covered - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / SETS), covered
    dof = means.shape[-1] - 2
    assert abs(found.chi_square.mean() / dof - 1.0) <= 4.0 * np.sqrt(2.0 / dof / SETS) + 2.0 / n
    for one in range(3):
        alone = fit_exposure_bracket(means[one], variances[one])
        assert alone.offset.value == pytest.approx(found.offset[one], abs=1e-9)
        assert alone.offset.std_error == pytest.approx(error[one], rel=1e-9)
        assert alone.dof == dof
        assert not alone.misfit


def test_T9_a_third_exposure_helps(chart):  # noqa: N802 - METHOD's name of the test
    """METHOD 2.3: .004 and .002 DN once 1/16 is added."""
    for n, scatter in ((2500, 0.004), (10000, 0.002)):
        means, variances = _bracket(np.random.default_rng(93), chart(flare=2.4e-4), (1.0, 0.125, 0.0625), n=n)
        found = solve_bracket(means, variances)
        assert 0.8 <= found.offset.std() / scatter <= 1.2
        assert abs(found.offset.mean() - OFFSET) <= 4.0 * scatter / np.sqrt(SETS)


PUBLISHED = [  # METHOD 2.2, patches of 10^4 pixels: flare, bias of the offset [DN], of k_dark [%]
    (0.0, -0.19, -0.65),
    (1e-5, -0.04, -0.14),
    (1e-4, 1.31, 4.3),
    (2.4e-4, 3.42, 10.9),
    (1e-3, 14.8, 41.0),
    (3e-3, 44.8, 101.0),
]


@pytest.mark.parametrize(("flare", "bias", "k_bias"), PUBLISHED)
def test_T9_the_published_offset_takes_flare_for_pedestal(chart, flare, bias, k_bias):  # noqa: N802 - METHOD's name
    camera, n, sets = chart(flare=flare, planes=(1.0,)), 10000, 2000
    signal, _ = camera.simulate(np.random.default_rng(99), sets=sets, n=n)
    found = np.array([legacy_offset(OFFSET + means).offset.value for means in signal]) - OFFSET
    rounding = 0.005 if abs(bias) < 10.0 else 0.05
    assert abs(found.mean() - bias) <= 0.02 + rounding + 4.0 * found.std() / np.sqrt(sets), found.mean()
    a, b, c = camera.truth
    k_dark = np.sqrt((a + b * found + c * found**2) / a)
    assert 100.0 * (k_dark.mean() - 1.0) == pytest.approx(k_bias, abs=0.02 * abs(k_bias) + 0.1)


def test_a_bend_is_seen_and_the_bright_end_left_out(chart):
    """METHOD 2.3: a bend of 1 % biases by -.015 DN and is detected; below a tenth of D the bias is -.001 DN."""
    camera, n, sets = chart(flare=2.4e-4), 10000, 100
    means, variances = _bracket(np.random.default_rng(91), camera, (1.0, 0.125), n=n, sets=sets, bend=0.01)
    everything = solve_bracket(means, variances)
    assert everything.offset.mean() - OFFSET == pytest.approx(-0.015, abs=0.002)
    found = [
        fit_exposure_bracket(x, v, digital_maximum=camera.digital_maximum)
        for x, v in zip(means, variances, strict=True)
    ]
    assert all(one.restricted for one in found)
    bias = np.mean([one.offset.value for one in found]) - OFFSET
    assert abs(bias + 0.001) <= 4.0 * 0.003 / np.sqrt(sets)
    covered = np.mean([one.offset.ci95[0] <= OFFSET <= one.offset.ci95[1] for one in found])
    assert covered >= 0.93 - 4.0 * np.sqrt(0.93 * 0.07 / sets)


def test_a_hot_pixel_is_dropped_and_clipped_patches_take_no_part(chart):
    camera, n = chart(flare=2.4e-4), 2500
    means, variances = (part[0] for part in _bracket(np.random.default_rng(92), camera, (1.0, 0.125), n=n, sets=1))
    means[:, 60] += 1.0
    means[0, 36:39] = np.nan
    found = fit_exposure_bracket(means, variances, digital_maximum=camera.digital_maximum)
    np.testing.assert_array_equal(np.flatnonzero(~found.used.any(axis=0)), [36, 37, 38, 60])
    assert np.isnan(found.signals_dn[36])
    assert abs(found.offset.value - OFFSET) <= 4.0 * found.offset.std_error
    assert not found.misfit
    clipped = np.isfinite(means)
    means[0, 36:39] = 4095.0
    same = fit_exposure_bracket(means, variances, used=clipped, digital_maximum=camera.digital_maximum)
    assert same.offset.value == found.offset.value


def test_a_misfit_scales_the_error(chart):
    camera = chart(flare=2.4e-4)
    rng = np.random.default_rng(94)
    means, variances = (part[0] for part in _bracket(rng, camera, (1.0, 0.125), n=2500, sets=1))
    found = fit_exposure_bracket(means + 3.0 * np.sqrt(variances) * rng.standard_normal(means.shape), variances)
    assert found.misfit
    assert found.offset.dof == found.dof
    plain = solve_bracket(means, variances, used=found.used)
    assert found.offset.std_error == pytest.approx(
        np.sqrt(plain.covariance[0, 0] * found.chi_square / found.dof), rel=0.1
    )


@settings(max_examples=25)
@given(seed=st.integers(0, 10_000), exposures=st.integers(2, 4), offset=st.floats(-100.0, 3000.0))
def test_a_general_optimizer_agrees(seed, exposures, offset):
    """Oracle: all unknowns at once, no profiling; and the minimum's curvature is the covariance."""
    rng = np.random.default_rng(seed)
    ratios = np.array([1.0, 0.4, 2.2, 0.1])[:exposures]
    signal = 10.0 ** rng.uniform(0.5, 3.5, 12)
    errors = 0.02 + 0.01 * np.sqrt(ratios[:, None] * signal)
    means = offset + ratios[:, None] * signal + errors * rng.standard_normal(errors.shape)

    def residuals(parameters):
        b, r, s = parameters[0], np.append(1.0, parameters[1:exposures]), parameters[exposures:]
        return ((means - b - r[:, None] * s) / errors).ravel()

    start = np.concatenate([[offset], ratios[1:], signal])
    oracle = least_squares(residuals, start, x_scale=np.abs(start) + 1e-3, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found = solve_bracket(means, errors**2)
    error = np.sqrt(np.linalg.inv(oracle.jac.T @ oracle.jac)[0, 0])
    assert abs(found.offset - oracle.x[0]) <= 1e-4 * error
    assert np.sqrt(found.covariance[0, 0]) == pytest.approx(error, rel=1e-2)
    assert found.chi_square == pytest.approx(2.0 * oracle.cost, rel=1e-6)
    assert found.influence.sum() == pytest.approx(1.0)


def test_noiseless_brackets_are_met_exactly(chart):
    signal, ratios = chart().signal_dn[:36], np.array([1.0, 0.125, 0.3])
    means = 64.25 + ratios[:, None] * signal
    found = fit_exposure_bracket(means, np.full(means.shape, 0.01))
    assert found.offset.value == pytest.approx(64.25, abs=1e-9)
    np.testing.assert_allclose([one.value for one in found.ratios], ratios, rtol=1e-12)
    np.testing.assert_allclose(found.signals_dn, signal, atol=1e-8)


def test_what_identifies_nothing_is_refused(chart):
    camera = chart()
    means, variances = (part[0] for part in _bracket(np.random.default_rng(95), camera, (1.0, 1.0), n=2500, sets=1))
    with pytest.raises(ValueError, match="do not differ"):
        fit_exposure_bracket(means, variances)
    for rows, patches in ((1, 36), (2, 2)):
        with pytest.raises(ValueError, match="two exposures or more"):
            fit_exposure_bracket(means[:rows, :patches], variances[:rows, :patches])


def test_drift_of_the_offset_joins_the_error(chart):
    """METHOD 2.5: sigma_f sqrt(1 + r^2) / (1 - r); and with it the interval covers."""
    camera, drift, sets, r = chart(flare=2.4e-4), 0.02, 200, 0.125
    rng = np.random.default_rng(96)
    means, variances = _bracket(rng, camera, (1.0, r), n=2500, sets=sets)
    means = means + drift * rng.standard_normal((sets, 2, 1))
    pulls = []
    for x, v in zip(means, variances, strict=True):
        still, moving = (fit_exposure_bracket(x, v, drift_dn=one) for one in (0.0, drift))
        added = np.sqrt(moving.offset.std_error**2 - still.offset.std_error**2)
        assert added == pytest.approx(drift * np.sqrt(1.0 + r**2) / (1.0 - r), rel=1e-3)
        pulls.append((moving.offset.value - OFFSET) / moving.offset.std_error)
    assert abs(np.mean(np.abs(pulls) <= 1.96) - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets)
    averaged = fit_exposure_bracket(means[0], variances[0], drift_dn=drift, frames=[1, 4])
    plain = fit_exposure_bracket(means[0], variances[0], drift_dn=0.0)
    assert np.sqrt(averaged.offset.std_error**2 - plain.offset.std_error**2) == pytest.approx(
        drift * np.sqrt(0.25 + r**2) / (1.0 - r), rel=1e-3
    )


def test_noise_that_patches_share_joins_the_error(chart):
    """Rows of noise across six patches each: without their covariance one interval in six misses."""
    camera, shared, sets, r = chart(flare=2.4e-4, planes=(1.0,)), 0.02, 200, 0.125
    rng = np.random.default_rng(98)
    means, variances = _bracket(rng, camera, (1.0, r), n=10000, sets=sets)
    band = np.arange(means.shape[-1]) // 6
    means = means + shared * rng.standard_normal((sets, 2, band.max() + 1))[..., band]
    alike = shared**2 * (band[:, None] == band)
    covariance = np.eye(2)[:, None, :, None] * (alike - np.diag(np.diagonal(alike)))[None, :, None]
    covered = {}
    for name, common in (("alone", 0.0), ("together", covariance)):
        found = [
            fit_exposure_bracket(x, v + shared**2, covariance_dn2=common).offset
            for x, v in zip(means, variances, strict=True)
        ]
        covered[name] = np.mean([one.ci95[0] <= OFFSET <= one.ci95[1] for one in found])
    assert covered["alone"] < 0.85
    assert abs(covered["together"] - 0.95) <= 4.0 * np.sqrt(0.95 * 0.05 / sets), covered


def test_rows_of_noise_are_no_drift(chart):
    """Twelve frames of patches in bands: noise of the bands alone is not taken for an offset that moves."""
    camera, frames, shared, n, sets = chart(planes=(1.0,)), 12, 0.05, 2500, 200
    rng = np.random.default_rng(99)
    noise = np.sqrt(camera.variance_dn2 / n)
    band = np.arange(noise.size) // 6
    alike = shared**2 * (band[:, None] == band)
    own = np.broadcast_to(noise**2 + shared**2, (frames, noise.size))
    found = []
    for _ in range(sets):
        means = OFFSET + camera.signal_dn + noise * rng.standard_normal(own.shape)
        means = means + shared * rng.standard_normal((frames, band.max() + 1))[:, band]
        common = alike - np.diag(np.diagonal(alike))
        found.append(frame_drift(*repeat_levels(means, own, offset_dn=OFFSET, covariance_dn2=common)).value)
    assert abs(np.mean(found)) <= 4.0 * np.std(found) / np.sqrt(sets)


def test_drift_is_told_from_flicker(chart):
    """Repeats that flicker by 1 % and drift by 0.05 DN: the drift comes out, unbiased, its error Student's."""
    camera, frames, drift, n, sets = chart(planes=(1.0,)), 12, 0.05, 2500, 400
    rng = np.random.default_rng(97)
    noise = np.sqrt(camera.variance_dn2 / n)
    found = []
    for _ in range(sets):
        flicker = 1.0 + 0.01 * rng.standard_normal((frames, 1))
        means = OFFSET + camera.signal_dn * flicker + drift * rng.standard_normal((frames, 1))
        means = means + noise * rng.standard_normal(means.shape)
        levels, variances = repeat_levels(means, np.broadcast_to(noise**2, means.shape), offset_dn=OFFSET)
        found.append(frame_drift(levels, variances))
    values = np.array([one.value for one in found])
    assert abs(values.mean() - drift**2) <= 4.0 * values.std() / np.sqrt(sets)
    assert np.mean([one.std_error for one in found]) == pytest.approx(values.std(), rel=0.15)
    with pytest.raises(ValueError, match="two frames"):
        frame_drift([1.0], [0.1])
