import numpy as np
from scipy.stats import norm

from fullwell.fit.exposure_bracket import fit_exposure_bracket
from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.statistics.patch import patch_statistics

EDGE = 50
SETS = 300
EXPOSURES = np.array([1.0, 1.0 / 8.0])
QUANTIZATION = 1.0 / 12.0


def _surface_basis():
    """Orthonormal basis of the quadratic surfaces over a patch, shape (pixels, 6)."""
    v, u = (axis.ravel() / EDGE - 0.5 for axis in np.mgrid[:EDGE, :EDGE])
    return np.linalg.qr(np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1))[0].astype(np.float32)


def _frames(rng, camera, offset_dn):
    """Two exposures of one scene on the same pixels: rounded codes of every patch, shape (2, patches, pixels)."""
    dark, system_gain, prnu = camera.truth
    shape = (camera.signal_dn.size, EDGE**2)
    response = 1.0 + np.sqrt(prnu) * rng.standard_normal(shape, np.float32)
    electrons = (camera.signal_dn / system_gain).astype(np.float32)[:, None] * response
    for exposure in EXPOSURES:
        charge = rng.poisson(exposure * electrons).astype(np.float32)
        noise = np.sqrt(dark, dtype=np.float32) * rng.standard_normal(shape, np.float32)
        yield np.rint(offset_dn + system_gain * charge + noise)


def _patches(codes, basis):
    """Mean and variance about a quadratic surface of every patch, 6 terms."""
    mean = codes.mean(axis=-1, dtype=np.float64)
    about = codes - mean[:, None].astype(np.float32)
    squares = np.einsum("pn,pn->p", about, about, dtype=np.float64) - np.sum(
        (about @ basis).astype(float) ** 2, axis=-1
    )
    return mean, squares / (EDGE**2 - 6)


def test_T4_a_chart_with_flare_and_an_unknown_offset(chart):  # noqa: N802 - METHOD's name of the test
    """Pixels of two exposures, 14 bits, flare 2.4e-4: offset by bracket, then one curve through all patches."""
    camera = chart(flare=2.4e-4)
    rng, basis = np.random.default_rng(4), _surface_basis()
    truth = camera.truth + np.array([QUANTIZATION, 0.0, 0.0])
    offsets, errors, found, deviance = [], [], [], []
    for one in range(SETS):
        offset = 511.0 + rng.uniform(-0.5, 0.5)
        mean, variance = (
            np.array(part)
            for part in zip(*(_patches(codes, basis) for codes in _frames(rng, camera, offset)), strict=True)
        )
        bracket = fit_exposure_bracket(mean, variance / EDGE**2, digital_maximum=camera.digital_maximum)
        fit = fit_photon_transfer(
            (mean - bracket.offset.value).ravel(), variance.ravel(), EDGE**2 - 6, n=EDGE**2, reject_outliers=False
        )
        widened = fit.covariance + np.diag([(fit.coefficients[1] * bracket.offset.std_error) ** 2, 0.0, 0.0])
        offsets.append(bracket.offset.value - offset)
        found.append(fit.coefficients)
        errors.append(np.sqrt(np.diagonal(widened)))
        deviance.append(fit.deviance / fit.deviance_dof)
        if one == 0:
            codes = next(_frames(np.random.default_rng(44), camera, offset))
            by_hand = _patches(codes, basis)
            for patch in (0, 50, 143):
                ours = patch_statistics(codes[patch].reshape(EDGE, EDGE))
                np.testing.assert_allclose([ours.mean, ours.variance], [part[patch] for part in by_hand], rtol=1e-5)
    assert abs(np.mean(offsets)) <= 0.002, np.mean(offsets)
    k = np.sqrt(np.array(found) - [QUANTIZATION, 0.0, 0.0])
    bias = 100.0 * (k.mean(axis=0) / np.sqrt(camera.truth) - 1.0)
    assert np.all(np.abs(bias) <= [0.04, 0.08, 0.45]), bias
    covered = np.mean(np.abs(np.array(found) - truth) <= norm.ppf(0.975) * np.array(errors), axis=0)
    assert np.all((covered >= 0.915) & (covered <= 0.98)), covered
    assert abs(np.mean(deviance) - 1.0) <= 0.02, np.mean(deviance)
