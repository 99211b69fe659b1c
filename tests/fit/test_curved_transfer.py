import numpy as np
import pytest

from fullwell.fit.gamma_likelihood import fit_gamma, signed_deviance
from fullwell.fit.photon_transfer import fit_photon_transfer, photon_transfer_design

GAIN, READ_E, FULL_E, BEND = 0.5, 5.4, 30_000.0, -2e-6
DOF = 100_000.0


def _simulated(rng, sets):
    """Temporal pairs at 50 levels up to 30,000 e-: variance A + B V (1 + a N_e), METHOD 10.1."""
    electrons = FULL_E * np.arange(1, 51) / 50.0
    signal = GAIN * electrons
    variance = (GAIN * READ_E) ** 2 + GAIN * signal * (1.0 + BEND * electrons)
    shape = (sets, signal.size)
    means = signal + rng.standard_normal(shape) * np.sqrt(variance / DOF / 2.0)
    return means, variance * rng.chisquare(DOF, shape) / DOF


def test_T19_brighter_fatter():  # noqa: N802 - METHOD's name of the test
    sets = 2000
    signal, variance = _simulated(np.random.default_rng(19), sets)
    curve = fit_gamma(photon_transfer_design(signal, terms=3), variance, np.array(DOF))
    system_gain, error = curve.coefficients[:, 1], np.sqrt(curve.covariance[:, 1, 1])
    assert abs(system_gain.mean() / GAIN - 1.0) <= 5e-4
    covered = np.mean(np.abs(system_gain - GAIN) <= 1.96 * error)
    assert 0.93 <= covered <= 0.97, covered
    bend = curve.coefficients[:, 2] / curve.coefficients[:, 1] * GAIN
    assert bend.mean() == pytest.approx(BEND, rel=0.01)

    low = signal.mean(axis=0) <= 0.7 * GAIN * FULL_E
    shot = variance[:, low] - (GAIN * READ_E) ** 2
    through_origin = np.sum(shot * signal[:, low], axis=1) / np.sum(signal[:, low] ** 2, axis=1)
    assert 100.0 * (through_origin.mean() / GAIN - 1.0) == pytest.approx(-3.2, abs=0.1)

    line = fit_gamma(photon_transfer_design(signal, terms=2), variance, np.array(DOF))
    assert 100.0 * (line.coefficients[:, 1].mean() / GAIN - 1.0) == pytest.approx(-3.7, abs=0.3)
    deviance = np.sum(signed_deviance(variance, line.predicted, line.effective_dof) ** 2, axis=1)
    assert deviance.min() / 48.0 > 5.0
    assert fit_photon_transfer(signal[0], variance[0], DOF, n=None, terms=2, reject_outliers=False).misfit
    assert not fit_photon_transfer(signal[0], variance[0], DOF, n=None, terms=3, reject_outliers=False).misfit
