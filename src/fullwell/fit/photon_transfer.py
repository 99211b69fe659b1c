"""Photon transfer: system gain and noise from how variance grows with signal (METHOD 1).

`fit_photon_transfer` takes one variance per point (temporal from bursts or pairs, or total from single frames);
`fit_burst_photon_transfer` takes the temporal and the spatial variance of the same points and separates all four causes
(METHOD 1.4; preferred where there are bursts).
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.goodness import CheckedFit, fit_checked
from fullwell.units import DN2, DN_PER_ELECTRON, ONE, Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferFit(CheckedFit):
    """What every photon transfer fit has: the temporal variance A + B S."""

    @property
    def system_gain(self) -> Measured:
        """Return B [DN/e-]."""
        return self.coefficient(1, DN_PER_ELECTRON)

    @property
    def intercept(self) -> Measured:
        """Return A, the variance without signal, quantization included [DN^2]."""
        return self.coefficient(0, DN2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PhotonTransferFit(TransferFit):
    """variance = A + B S + C S^2, fitted: ``coefficients`` are A [DN^2], B [DN/e-] and, with three terms, C [1]."""

    def single_frame(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return A, B, C and their covariance, shapes (3,) and (3, 3); C is zero where the fit has two terms."""
        coefficients, covariance = np.zeros(3), np.zeros((3, 3))
        terms = self.coefficients.size
        coefficients[:terms], covariance[:terms, :terms] = self.coefficients, self.covariance
        return coefficients, covariance


@dataclass(frozen=True, slots=True, kw_only=True)
class BurstPhotonTransferFit(TransferFit):
    """Temporal variance A + B S and spatial variance (A + B S) / L + C S^2 + E of L-frame bursts, fitted together.

    ``coefficients`` are A [DN^2], B [DN/e-], C = PRNU^2 [1], E = DSNU^2 [DN^2]; ``residuals`` and ``used`` have shape
    (2, N): temporal, spatial.
    """

    @property
    def prnu_variance(self) -> Measured:
        """Return C, the squared photo-response non-uniformity, signed [1]."""
        return self.coefficient(2, ONE)

    @property
    def dsnu_variance(self) -> Measured:
        """Return E, the squared dark-signal non-uniformity, signed [DN^2]."""
        return self.coefficient(3, DN2)

    def single_frame(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return A + E, B, C of one frame and their covariance, shapes (3,) and (3, 3)."""
        collect = np.array([[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
        return collect @ self.coefficients, collect @ self.covariance @ collect.T


def fit_photon_transfer(
    signal_dn: ArrayLike,
    variance_dn2: ArrayLike,
    dof: ArrayLike,
    *,
    n: ArrayLike | None,
    terms: Literal[2, 3] = 3,
    reject_outliers: bool = True,
) -> PhotonTransferFit:
    """Fit variance = A + B S (+ C S^2) by gamma likelihood (METHOD 1.2, 1.3, 1.8).

    Parameters
    ----------
    signal_dn
        Mean above the black level of each point, shape (N,); may be slightly negative [DN].
    variance_dn2
        Variance estimate of each point, shape (N,) [DN^2].
    dof
        Its degrees of freedom, shape (N,) or one for all.
    n
        Pixel values (pixels x frames) behind each point, shape (N,) or one for all; None leaves the low-signal weights
        of METHOD 1.3 out.
    terms
        2 fits a line, 3 a signed quadratic.
    reject_outliers
        Drop points with |r| > 4, at most 10 %.

    Returns
    -------
    PhotonTransferFit

    Raises
    ------
    ValueError
        Where there are fewer points than coefficients.

    """
    signal, variance = _points(signal_dn, variance_dn2, coefficients=terms)
    return fit_checked(
        PhotonTransferFit,
        photon_transfer_design(signal, terms=terms),
        variance,
        _each(dof, signal),
        low_signal=None if n is None else 1.0 / _each(n, signal),
        reject_outliers=reject_outliers,
    )


def photon_transfer_design(signal_dn: NDArray[np.float64], *, terms: int) -> NDArray[np.float64]:
    """Return the columns 1, S (, S^2), shape (..., N, terms)."""
    return np.stack([signal_dn**power for power in range(terms)], axis=-1)


def fit_burst_photon_transfer(
    signal_dn: ArrayLike,
    temporal_variance_dn2: ArrayLike,
    temporal_dof: ArrayLike,
    spatial_variance_dn2: ArrayLike,
    spatial_dof: ArrayLike,
    *,
    frames: ArrayLike,
    n: ArrayLike | None,
    mean_square_dn2: ArrayLike | None = None,
    pattern_pixels: float | None = None,
    reject_outliers: bool = True,
) -> BurstPhotonTransferFit:
    """Fit temporal and spatial variances of bursts together (METHOD 1.4).

    Parameters
    ----------
    signal_dn
        Mean above the black level of each point, shape (N,) [DN].
    temporal_variance_dn2, temporal_dof
        Mean per-pixel variance over the frames and its degrees of freedom n (L - 1), shape (N,) [DN^2, 1].
    spatial_variance_dn2, spatial_dof
        Variance of the L-frame mean about a smooth surface and its degrees of freedom n - p, shape (N,) [DN^2, 1].
    frames
        L of each point.
    n
        Pixel values (pixels x frames) behind each point; None leaves the low-signal weights out.
    mean_square_dn2
        Mean of the squared signal over the pixels of each point, where it varies over them (shading); the squared
        signal by default, shape (N,) [DN^2].
    pattern_pixels
        Distinct pixels behind all points, where the same pixels were seen at several exposures: their pattern is one
        draw, so C and E are never known better than sqrt(2 / pattern_pixels), whatever the number of exposures. None
        where every point has pixels of its own.
    reject_outliers
        Drop points with |r| > 4, at most 10 %.

    Returns
    -------
    BurstPhotonTransferFit

    Raises
    ------
    ValueError
        Where there are fewer than two points.

    """
    signal, temporal = _points(signal_dn, temporal_variance_dn2, coefficients=2)
    per_point = _each(frames, signal)
    low_signal = None
    if n is not None:
        share = 1.0 / _each(n, signal)
        low_signal = np.concatenate([share, share / per_point**2])
    fit = fit_checked(
        BurstPhotonTransferFit,
        burst_design(signal, per_point, signal**2 if mean_square_dn2 is None else _each(mean_square_dn2, signal)),
        np.concatenate([temporal, _each(spatial_variance_dn2, signal)]),
        np.concatenate([_each(temporal_dof, signal), _each(spatial_dof, signal)]),
        low_signal=low_signal,
        reject_outliers=reject_outliers,
    )
    return replace(
        fit,
        covariance=fit.covariance + _pattern_covariance(fit, pattern_pixels),
        residuals=fit.residuals.reshape(2, -1),
        used=fit.used.reshape(2, -1),
    )


def burst_design(
    signal_dn: NDArray[np.float64], frames: NDArray[np.float64], mean_square_dn2: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the columns for A, B, C, E: temporal rows first, then spatial rows; shape (..., 2 N, 4)."""
    one, none = np.ones_like(signal_dn), np.zeros_like(signal_dn)
    temporal = np.stack([one, signal_dn, none, none], axis=-1)
    spatial = np.stack([one / frames, signal_dn / frames, mean_square_dn2, one], axis=-1)
    return np.concatenate([temporal, spatial], axis=-2)


def _pattern_covariance(fit: CheckedFit, pattern_pixels: float | None) -> NDArray[np.float64]:
    """Return the variance that one draw of the pattern adds to C and E."""
    if pattern_pixels is None:
        return np.zeros((4, 4))
    pattern = np.where([False, False, True, True], fit.coefficients, 0.0)
    return np.diag(2.0 * pattern**2 / pattern_pixels)


def _points(
    signal_dn: ArrayLike, variance_dn2: ArrayLike, *, coefficients: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    signal = np.atleast_1d(np.asarray(signal_dn, np.float64))
    variance = np.atleast_1d(np.asarray(variance_dn2, np.float64))
    if signal.size < coefficients:
        raise ValueError(f"{coefficients} coefficients need at least as many points, here are {signal.size}")
    return signal, variance


def _each(values: ArrayLike, signal: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.broadcast_to(np.asarray(values, np.float64), signal.shape)
