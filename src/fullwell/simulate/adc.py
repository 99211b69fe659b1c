"""The converter: the black level is added, everything is rounded once, and nothing passes the rails."""

import numpy as np
from numpy.typing import NDArray

from fullwell.model.sensor import SensorParameters
from fullwell.simulate.shot import FloatArray, Shot


def converted(signal: FloatArray, shot: Shot) -> FloatArray:
    """Return the codes, whole numbers from 0 to the white rail; stored codes where they are companded [DN].

    With two amplifications the bright half of the range is rounded to steps as much coarser.

    Parameters
    ----------
    signal
        Signal at the converter, without the black level [DN].
    shot
        What is taken.

    """
    sensor, companding = shot.sensor, shot.camera.companding
    if sensor.dual_conversion_ratio:
        ratio = sensor.dual_conversion_ratio
        bright = signal >= sensor.knee
        signal[bright] = np.rint(signal[bright] / ratio) * ratio
    shot.add_by_site(signal, sensor.black_level)
    if companding is not None:
        return np.searchsorted(_borders(companding), signal).astype(np.float64)
    np.rint(signal, out=signal)
    return np.clip(signal, 0.0, white_rail(sensor), out=signal)


def white_rail(sensor: SensorParameters) -> float:
    """Return the highest code: what the bits hold or the white level, whichever is lower [DN]."""
    return float(min(sensor.white_level, 2**sensor.bit_depth - 1))


def as_codes(codes: FloatArray) -> NDArray[np.uint16]:
    """Return whole numbers as a raw file stores them."""
    return codes.astype(np.uint16)


def companding_table(sensor: SensorParameters, bits: int) -> NDArray[np.uint16]:
    """Return the linear code of each stored code: one to one at 0, a parabola that ends on the white rail [DN].

    Steps grow with the signal, as shot noise does.

    Parameters
    ----------
    sensor
        Where the range ends.
    bits
        Of the stored codes, fewer than those of the converter [bit].

    Examples
    --------
    >>> from fullwell.testing import simulation
    >>> table = companding_table(simulation().sensor, 10)
    >>> table[[0, 1, 512, 1023]].tolist()
    [0, 1, 1282, 4095]

    """
    stored = np.arange(2**bits, dtype=np.float64)
    last = float(stored[-1])
    return np.rint(stored + (white_rail(sensor) - last) * (stored / last) ** 2).astype(np.uint16)


def _borders(table: NDArray[np.uint16]) -> FloatArray:
    """Return the signals at which one stored code gives way to the next [DN]."""
    linear = table.astype(np.float64)
    return 0.5 * (linear[:-1] + linear[1:])
