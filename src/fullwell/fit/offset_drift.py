"""By how much the offset itself moves from frame to frame (METHOD 2.5).

From masked pixels: their mean in each frame, to `frame_drift`. From repeated exposures of a chart: `repeat_levels`
first, which takes the flicker of the light out.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.noise_coefficients import boundary_variance
from fullwell.units import DN2, Measured


def frame_drift(levels_dn: ArrayLike, variances_dn2: ArrayLike) -> Measured:
    """Return the variance of the offset from frame to frame, signed (METHOD 2.5).

    Parameters
    ----------
    levels_dn
        Level of each frame: mean of its masked pixels, or `repeat_levels` of repeated exposures, shape (L,) [DN].
    variances_dn2
        What the noise of the pixels puts into each of them, shape (L,) [DN^2].

    Returns
    -------
    Measured
        Sample variance of the levels less the mean of ``variances_dn2`` [DN^2].

    """
    levels, expected = np.asarray(levels_dn, np.float64), np.asarray(variances_dn2, np.float64)
    if levels.size < 2:
        raise ValueError("drift from frame to frame needs at least two frames")
    scatter, dof = float(np.var(levels, ddof=1)), float(levels.size - 1)
    return boundary_variance(scatter - float(np.mean(expected)), scatter * math.sqrt(2.0 / dof), dof=dof, unit=DN2)


def repeat_levels(
    means_dn: ArrayLike, variances_of_means_dn2: ArrayLike, *, offset_dn: float, covariance_dn2: ArrayLike = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the offset of each of several frames of one exposure about their mean, free of flicker (METHOD 2.5).

    Parameters
    ----------
    means_dn, variances_of_means_dn2
        Mean of each patch in each frame and its variance, shape (L, N) [DN, DN^2].
    offset_dn
        The black level [DN].
    covariance_dn2
        What the means of one frame have in common, such as the noise of the rows they share, shape (N, N); zero for
        each with itself [DN^2].

    Returns
    -------
    tuple of ndarray
        Intercept at black of each frame's patches against the mean of all frames, and its variance, shape (L,)
        [DN, DN^2]; for `frame_drift`.

    """
    signal = np.asarray(means_dn, np.float64) - offset_dn
    variances = np.asarray(variances_of_means_dn2, np.float64)
    weights = 1.0 / variances
    level = np.broadcast_to(signal.mean(axis=0), signal.shape)
    design = np.stack([np.ones_like(level), level / np.abs(level).max()], axis=-1)
    information = np.einsum("lnp,ln,lnq->lpq", design, weights, design)
    inverse = np.linalg.inv(information)
    influence = np.einsum("lp,lnp,ln->ln", inverse[:, 0], design, weights)
    common = np.broadcast_to(np.asarray(covariance_dn2, np.float64), (signal.shape[1],) * 2)
    shared = np.einsum("ln,nm,lm->l", influence, common, influence)
    return np.einsum("ln,ln->l", influence, signal - level), inverse[:, 0, 0] + shared
