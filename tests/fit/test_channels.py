import numpy as np
import pytest
from scipy.special import chdtri

from fullwell.fit.channels import ChannelPoints, fit_shared_curve
from fullwell.fit.gamma_likelihood import fit_gamma, signed_deviance
from fullwell.fit.photon_transfer import photon_transfer_design

N = 2500
PLANES = 4


def _deviance(signal, variance):
    fit = fit_gamma(
        photon_transfer_design(signal, terms=3),
        variance,
        np.array(N - 1.0),
        low_signal=np.full(variance.shape, 1.0 / N),
    )
    return np.sum(signed_deviance(variance, fit.predicted, fit.effective_dof) ** 2, axis=-1)


def _ratios(signal, variance):
    apart = _deviance(signal.reshape(-1, PLANES, 36), variance.reshape(-1, PLANES, 36)).sum(axis=-1)
    return _deviance(signal, variance) - apart


def test_T7_channels_that_share_a_curve(chart):  # noqa: N802 - METHOD's name of the test
    sets = 4000
    signal, variance = chart().simulate(np.random.default_rng(7), sets=sets, n=N)
    ratios = _ratios(signal, variance)
    size = np.mean(ratios > chdtri(9, 0.05))
    assert 0.04 <= size <= 0.06, size
    for one in range(3):
        shared = fit_shared_curve(_channels(signal[one], variance[one]))
        assert shared.ratio_dof == 9
        assert shared.ratio == pytest.approx(ratios[one], abs=1e-6)


def test_T7_digital_white_balance_is_seen(chart):  # noqa: N802 - METHOD's name of the test
    signal, variance = chart().simulate(np.random.default_rng(77), sets=300, n=N)
    scale = np.repeat([1.02, 1.0, 1.0, 1.02], 36)
    power = np.mean(_ratios(signal * scale, variance * scale**2) > chdtri(9, 0.05))
    assert power >= 0.9
    assert fit_shared_curve(_channels(signal[0] * scale, variance[0] * scale**2)).p_value < 0.05


def test_curves_that_do_not_fit_are_compared_by_their_misfit(chart):
    """Scatter beyond the model's would make chi-square cry wolf; the ratio of misfits does not."""
    camera, sets = chart(), 150
    signal, variance = camera.simulate(np.random.default_rng(78), sets=sets, n=N)
    variance = variance * (1.0 + 0.06 * np.random.default_rng(79).standard_normal(variance.shape))
    found = [fit_shared_curve(_channels(s, v)) for s, v in zip(signal, variance, strict=True)]
    by_chi_square = np.mean([one.ratio > chdtri(9, 0.05) for one in found])
    by_misfit = np.mean([one.p_value < 0.05 for one in found])
    assert by_chi_square > 0.5
    assert by_misfit <= 0.05 + 4.0 * np.sqrt(0.05 * 0.95 / sets)


def _channels(signal, variance):
    return [
        ChannelPoints(signal_dn=s, variance_dn2=v, dof=np.full(36, N - 1.0), n=np.full(36, float(N)))
        for s, v in zip(signal.reshape(PLANES, 36), variance.reshape(PLANES, 36), strict=True)
    ]
