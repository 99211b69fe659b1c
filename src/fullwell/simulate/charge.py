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
        mean += expected * shot.camera.response[shot.tile.window] if sensor.prnu else expected
    charge = poisson(mean, shot.draws(Stream.CHARGE))
    return np.minimum(charge, sensor.full_well, out=charge)
