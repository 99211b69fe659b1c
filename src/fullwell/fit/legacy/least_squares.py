"""The line of the published studies: ordinary least squares, every value alike."""

import numpy as np
from numpy.typing import ArrayLike, NDArray


def line_weights(exposures_s: ArrayLike) -> NDArray[np.float64]:
    """Return slope and intercept of ordinary least squares as weights of the values, shape (2, K).

    Raises
    ------
    ValueError
        Where there are fewer than two different exposures.

    """
    time = np.asarray(exposures_s, np.float64)
    if np.unique(time).size < 2:
        raise ValueError("the published lines need frames of two or more different exposures")
    centred = time - time.mean()
    slope = centred / float(centred @ centred)
    return np.stack([slope, 1.0 / time.size - time.mean() * slope])
