"""Maps of one value per pixel, each a fixed linear combination of bursts: differences, slopes, intercepts."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def combine(
    sums: Sequence[NDArray[np.uint32]],
    coefficients: NDArray[np.float64],
    *,
    cell: int,
    offset: NDArray[np.float64] | None = None,
    workers: int = 1,
    out: NDArray[np.float32] | None = None,
) -> NDArray[np.float32]:
    """Return linear combinations of burst sums.

    Each is added up in double precision and rounded to float32 at the end.

    Parameters
    ----------
    sums
        K maps of shape (height, width): sum over the frames of each burst, or any other map of numbers [DN].
    coefficients
        Shape (maps to make, K, sites): by the site of the colour filter array, row by row.
    cell
        Period of the mosaic; ``sites`` is its square [pixel].
    offset
        Added at the end, shape (maps to make, sites); None: nothing [unit of the result].
    workers
        Threads; the maps do not depend on their number.
    out
        Memory for the maps, to be used again; None takes new memory.

    Returns
    -------
    ndarray
        Shape (maps to make, height, width).

    """
    raise NotImplementedError


def line_coefficients(exposures_s: Sequence[float], weights: Sequence[float] | None = None) -> NDArray[np.float64]:
    """Return slope and intercept of the least-squares line as linear combinations of the means (METHOD 5.2).

    Parameters
    ----------
    exposures_s
        K exposure times, not all the same [s].
    weights
        Inverse variance of each mean, up to a common factor; None: all the same.

    Returns
    -------
    ndarray
        Shape (2, K): coefficients of the slope [1/s] and of the intercept [1].

    """
    raise NotImplementedError


def response_maps(
    means: Sequence[NDArray[np.float32]] | NDArray[np.float32],
    exposures_s: Sequence[float],
    *,
    weights: Sequence[float] | None = None,
    workers: int = 1,
    out: NDArray[np.float32] | None = None,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return slope and intercept of each pixel's line of mean against exposure time (METHOD 5.2).

    Parameters
    ----------
    means
        K maps of shape (height, width) [DN].
    exposures_s, weights
        As `line_coefficients`.
    workers
        Threads; the maps do not depend on their number.
    out
        Memory for both maps, shape (2, height, width), to be used again; None takes new memory.

    Returns
    -------
    tuple
        Slope [DN/s] and intercept [DN], each of shape (height, width).

    """
    raise NotImplementedError
