"""One noise model for frames, bursts and exposures of a chart, against known truth at the level of variances."""

import numpy as np
import pytest

from fullwell.fit.chart_noise import Observations, fit_chart_noise, fit_shared_noise
from fullwell.fit.photon_transfer import fit_burst_photon_transfer, fit_photon_transfer

TRUTH = np.array([7.5, 0.5054, 3.0e-5])
OFFSET = 2.0
N = 2500
CHANNELS = (0.306, 1.0, 1.0, 0.606)


def observations(rng, *, exposures=(1.0,), frames=1, prnu=(None,) * 4, factor=(1.0,) * 4):
    """Variances of 36 patches in four channels; the pattern of a patch is one draw for all its exposures."""
    rows = []
    for channel, response in enumerate(CHANNELS):
        fixed = TRUTH[2] if prnu[channel] is None else prnu[channel]
        for patch in range(36):
            light = 15000.0 * response * (10.0 ** (-0.2486 * patch) + 2.4e-4)
            pattern = rng.standard_normal(N)
            for exposure in exposures:
                signal = exposure * light
                temporal = factor[channel] * (TRUTH[0] + TRUTH[1] * signal)
                if frames > 1:
                    dof = (frames - 1) * (N - 6)
                    rows.append((signal, temporal * rng.chisquare(dof) / dof, dof, frames, True, channel, patch))
                noise = pattern * np.sqrt(fixed) * signal + np.sqrt(temporal / frames) * rng.standard_normal(N)
                rows.append((signal, noise.var() * N / (N - 1), N - 1, frames, False, channel, patch))
    signal, variance, dof, count, temporal, channel, patch = (np.array(column) for column in zip(*rows, strict=True))
    return Observations(
        signal_dn=signal,
        variance_dn2=variance,
        dof=dof.astype(float),
        low_signal=1.0 / N / count ** np.where(temporal, 1, 3),
        frames=count.astype(float),
        temporal=temporal,
        channel=channel,
        patch=patch,
    )


def test_single_frames_are_the_plain_fit():
    found = observations(np.random.default_rng(1))
    plain = fit_photon_transfer(found.signal_dn, found.variance_dn2, found.dof, n=N)
    fit = fit_chart_noise(found)
    np.testing.assert_allclose(fit.coefficients, plain.coefficients, rtol=1e-9)
    np.testing.assert_allclose(fit.covariance, plain.covariance, rtol=1e-9)


def test_bursts_are_the_burst_fit():
    found = observations(np.random.default_rng(2), frames=4)
    temporal, spatial = found.where(found.temporal), found.where(~found.temporal)
    plain = fit_burst_photon_transfer(
        temporal.signal_dn,
        temporal.variance_dn2,
        temporal.dof,
        spatial.variance_dn2,
        spatial.dof,
        frames=4,
        n=4 * N,
    )
    fit = fit_chart_noise(found)
    np.testing.assert_allclose(fit.coefficients, plain.coefficients, rtol=1e-6)
    assert fit.single_frame()[0][0] == pytest.approx(fit.coefficients[0] + fit.coefficients[3])


@pytest.mark.parametrize("frames", [1, 4])
def test_errors_hold_where_exposures_share_the_pattern(frames):
    """Equal exposures, where what they have in common is largest: scatter over sets within 4 sigma of the errors."""
    rng = np.random.default_rng(3 + frames)
    sets = 120
    fits = [fit_chart_noise(observations(rng, exposures=(1.0, 0.9, 0.8), frames=frames)) for _ in range(sets)]
    found = np.array([fit.single_frame()[0] for fit in fits])
    errors = np.sqrt(np.mean([np.diagonal(fit.single_frame()[1]) for fit in fits], axis=0))
    ratio = found.std(axis=0, ddof=1) / errors
    assert np.all(np.abs(ratio - 1.0) < 4 / np.sqrt(2 * sets))
    assert np.all(np.abs(found.mean(axis=0) - TRUTH) < 4 * errors / np.sqrt(sets))


def test_channels_that_share_are_told_to_and_others_not():
    """Size of both tests under the null, power for a scaled channel and for patterns of their own."""
    rng = np.random.default_rng(7)
    null = [fit_shared_noise(observations(rng), channels=4) for _ in range(100)]
    for name in ("p_value", "physical_p_value"):
        rejected = np.mean([getattr(one, name) < 0.05 for one in null])
        assert abs(rejected - 0.05) < 4 * np.sqrt(0.05 * 0.95 / 100)
    scaled = fit_shared_noise(observations(rng, factor=(1.04, 1.0, 1.0, 1.04)), channels=4)
    assert max(scaled.p_value, scaled.physical_p_value) < 0.01
    own = fit_shared_noise(observations(rng, prnu=(6e-5, 3e-5, 3e-5, 6e-5)), channels=4)
    assert own.p_value < 0.01 < own.physical_p_value
    for group, truth in enumerate((6e-5, 3e-5, 3e-5, 6e-5)):
        coefficients, covariance = own.physical.single_frame(group)
        assert abs(coefficients[2] - truth) < 4 * covariance[2, 2] ** 0.5


def test_too_few_patches_are_said():
    found = observations(np.random.default_rng(9))
    assert found.of_channel(1).sufficient
    assert not found.where((found.patch < 4) & (found.channel == 1)).sufficient
    with pytest.raises(ValueError, match="different levels"):
        fit_chart_noise(found.where((found.patch < 2) & (found.channel == 1)))
