import numpy as np

from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.statistics.patch import patch_statistics

EDGE = 50
DSNU_E = 1.5
SETS = 160  # kFPN scatters by 1.6 % a set (METHOD 1.6): 4 sd / sqrt(160) is the 0.5 % that is asked for


def _gradient():
    v, u = np.mgrid[0:EDGE, 0:EDGE] / EDGE - 24.5 / EDGE
    factor = 1.0 + 0.02 * u + 0.006 * v - 0.01 * (u**2 + v**2)
    return factor / factor.mean()


def _patches(rng, camera, factor):
    """One frame of every patch [DN above black]: charge is Poisson, PRNU, DSNU and read noise are normal."""
    dark, system_gain, prnu = camera.truth
    read_dn = np.sqrt(dark - (DSNU_E * system_gain) ** 2)
    for signal in camera.signal_dn:
        response = 1.0 + np.sqrt(prnu) * rng.standard_normal(factor.shape)
        charge = rng.poisson(signal / system_gain * factor * response)
        offset_dn = DSNU_E * system_gain * rng.standard_normal(factor.shape)
        yield system_gain * charge + offset_dn + read_dn * rng.standard_normal(factor.shape)


def test_T5_a_surface_takes_the_gradient_off_the_patches(chart):  # noqa: N802 - METHOD's name of the test
    camera = chart()
    factor = _gradient()
    rng = np.random.default_rng(5)
    k_fpn = {1: [], 6: []}
    for _ in range(SETS):
        patches = list(_patches(rng, camera, factor))
        for terms, found in k_fpn.items():
            one = [patch_statistics(patch, terms=terms) for patch in patches]
            fit = fit_photon_transfer(
                [patch.mean for patch in one],
                [patch.variance for patch in one],
                [patch.dof for patch in one],
                n=EDGE**2,
                reject_outliers=False,
            )
            found.append(np.sqrt(fit.coefficients[2]))
    plain, detrended = (np.mean(k_fpn[terms]) / camera.k[2] - 1.0 for terms in (1, 6))
    assert abs(detrended) <= 0.005, detrended
    assert abs(plain - 0.50) <= 0.01, plain
