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
        Local slope of ``log_signal`` from the patches on either side; 1 for a linear response without stray light, less
        where flare flattens it; NaN at both ends and beside values that are.

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
    means, density = np.asarray(means_dn, np.float64), np.asarray(densities, np.float64)
    known = np.flatnonzero(np.isfinite(density) & np.isfinite(means))
    patch = known[np.argsort(-density[known], kind="stable")]
    exposure = -density[patch]
    signal = _log10((means[patch] - offset_dn) / (white_dn - offset_dn))
    slope = np.full(patch.shape, np.nan)
    wide = exposure[2:] - exposure[:-2]
    slope[1:-1] = (signal[2:] - signal[:-2]) / np.where(wide > 0.0, wide, np.nan)
    return TonalResponse(
        patch=patch,
        log_exposure=exposure,
        log_pixel=_log10(means[patch] / white_dn),
        log_signal=signal,
        slope=slope,
    )


def _log10(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.log10(np.where(values > 0.0, values, np.nan))
