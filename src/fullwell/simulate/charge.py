"""The photodiode: photo-electrons and dark electrons counted one by one, attracted, filled and spilt."""

import numpy as np

from fullwell.kernels.fixed_patterns import multiply_by_response
from fullwell.kernels.random import poisson
from fullwell.simulate.geometry import Stream
from fullwell.simulate.shot import FloatArray, Shot


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
    if shot.exposure.electrons:
        _respond(expected, shot)
    expected += _dark_electrons(shot)
    return poisson(expected, shot.draws(Stream.CHARGE))


def attracted(charge: FloatArray, shot: Shot) -> FloatArray:
    """Return the charge where full pixels repel it: the brighter-fatter effect, to first order [e-].

    The border of two pixels moves towards the fuller one in proportion to their difference, and what it sweeps is in
    proportion to their mean: a pair exchanges c (Q1^2 - Q2^2) / 2. With c an eighth of the coefficient a, an even field
    of N electrons loses the share a N of its variance to covariances of neighbours; no charge is lost.

    Parameters
    ----------
    charge
        Charge as it arrived, of the whole mosaic [e-].
    shot
        What is taken.

    """
    coefficient = shot.sensor.brighter_fatter / 8.0
    if not coefficient:
        return charge
    squares = 0.5 * coefficient * charge * charge
    out = charge.copy()
    for axis in (0, 1):
        flow = np.diff(squares, axis=axis)
        rows, columns = flow.shape
        out[:rows, :columns] += flow
        out[-rows:, -columns:] -= flow
    return np.maximum(out, 0.0, out=out)


def held(charge: FloatArray, shot: Shot) -> FloatArray:
    """Return the charge that pixels hold: no more than the full well, of the rest a share flows along the column [e-].

    Half of what flows goes up, half down; each pixel takes what it can hold and passes the share on of what is left.

    Parameters
    ----------
    charge
        Charge, of the whole mosaic where it flows [e-].
    shot
        What is taken.

    """
    sensor = shot.sensor
    if not sensor.blooming:
        return np.minimum(charge, sensor.full_well, out=charge)
    spilt = np.maximum(charge - sensor.full_well, 0.0) * (0.5 * sensor.blooming)
    filled = np.minimum(charge, sensor.full_well)
    for rows in (range(charge.shape[0]), range(charge.shape[0] - 1, -1, -1)):
        flowing = np.zeros(charge.shape[1])
        for row in rows:
            taken = np.minimum(flowing, sensor.full_well - filled[row])
            filled[row] += taken
            flowing = (flowing - taken) * sensor.blooming + spilt[row]
    return filled


def _respond(expected: FloatArray, shot: Shot) -> None:
    """Multiply by the response of each pixel relative to the mean of its CFA plane, never below 0, in place."""
    sensor, individual, window = shot.sensor, shot.camera.individual, shot.tile.window
    rows, columns = (np.zeros(length) for length in expected.shape)
    if sensor.prnu_row:
        rows += sensor.prnu_row * individual.prnu_row[window[0], 0]
    if sensor.prnu_column:
        columns += sensor.prnu_column * individual.prnu_column[0, window[1]]
    if sensor.prnu:
        multiply_by_response(sensor.prnu, individual.prnu[window], rows, columns, expected)
    elif sensor.prnu_row or sensor.prnu_column:
        expected *= np.maximum(1.0 + rows[:, np.newaxis] + columns, 0.0)


def _dark_electrons(shot: Shot) -> FloatArray | float:
    """Return the mean dark electrons, of each pixel where pixels differ [e-]."""
    sensor, rate = shot.sensor, shot.camera.individual.dark_current
    time = shot.exposure.exposure_s * sensor.warmth(shot.exposure.temperature_c)
    if not rate.size:
        return sensor.dark_current * time
    return np.multiply(rate[shot.tile.window], time, dtype=np.float64)
