"""The converter: the black level is added, everything is rounded once, and nothing passes the rails."""

import numpy as np
from numpy.typing import NDArray

from fullwell.model.sensor import SensorParameters
from fullwell.simulate.shot import FloatArray, Shot


def converted(signal: FloatArray, shot: Shot) -> FloatArray:
    """Return the codes, whole numbers from 0 to the white rail [DN].

    Parameters
    ----------
    signal
        Signal at the converter, without the black level [DN].
    shot
        What is taken.

    """
    codes = signal + shot.by_site(shot.sensor.black_level)
    np.rint(codes, out=codes)
    return np.clip(codes, 0.0, white_rail(shot.sensor), out=codes)


def white_rail(sensor: SensorParameters) -> float:
    """Return the highest code: what the bits hold or the white level, whichever is lower [DN]."""
    return float(min(sensor.white_level, 2**sensor.bit_depth - 1))


def as_codes(codes: FloatArray) -> NDArray[np.uint16]:
    """Return whole numbers as a raw file stores them."""
    return codes.astype(np.uint16)
