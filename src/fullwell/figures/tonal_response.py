"""Tonal response: the logarithm of the pixel value against the logarithm of the exposure, -density."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray


@dataclass(frozen=True, slots=True, kw_only=True)
class TonalResponse:
    """Patches by ascending exposure; every array has shape (N,).

    Parameters
    ----------
    patch
        Index of each patch in the arguments.
    log_exposure
        -density: log10 of the exposure but for a constant.
    log_pixel
        log10(mean / white level), offset left in: it flattens towards the offset.
    log_signal
        log10((mean - offset) / (white level - offset)); NaN at or below the offset.
    slope
        Local slope of ``log_signal`` (central differences); 1 for a linear response without stray light, less where
        flare flattens it.

    """

    patch: NDArray[np.int64]
    log_exposure: NDArray[np.float64]
    log_pixel: NDArray[np.float64]
    log_signal: NDArray[np.float64]
    slope: NDArray[np.float64]


def tonal_response(means_dn: ArrayLike, densities: ArrayLike, *, offset_dn: float, white_dn: float) -> TonalResponse:
    """Return the tonal response of one channel, with and without the offset.

    Parameters
    ----------
    means_dn
        Mean of each patch, offset included, shape (N,) [DN].
    densities
        Density of each; patches without one (NaN) are left out.
    offset_dn
        Black level [DN].
    white_dn
        White level [DN].

    """
    raise NotImplementedError
