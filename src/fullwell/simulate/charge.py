"""The photodiode: photo-electrons and dark electrons, counted one by one, up to the full well."""

import numpy as np

from fullwell.kernels.random import poisson
from fullwell.simulate.shot import FloatArray, Shot, Stream


def collected(expected: FloatArray, shot: Shot) -> FloatArray:
    """Return the charge of each pixel: a Poisson number, exact at every level [e-].

    Photo-electrons and dark electrons are Poisson each, so their sum is Poisson with the sum of the means.

    Parameters
    ----------
    expected
        Mean photo-electrons without response non-uniformity [e-].
    shot
        What is taken.

    """
    sensor = shot.sensor
    mean = np.full_like(expected, sensor.dark_current * shot.exposure.exposure_s)
    if shot.exposure.electrons:
        mean += expected * _response(shot) if sensor.prnu else expected
    charge = poisson(mean, shot.draws(Stream.CHARGE))
    return np.minimum(charge, sensor.full_well, out=charge)


def _response(shot: Shot) -> FloatArray:
    """Return the response of each pixel relative to the mean of its CFA plane, never below 0 [1]."""
    response = 1.0 + shot.sensor.prnu * shot.camera.prnu[shot.tile.window]
    return np.maximum(response, 0.0, out=response)
