"""The black level from several exposures of one still scene, their ratios unknown (METHOD 2.3 (i), 2.5).

Patch i at exposure e has the mean x = b + r_e s_i: light, flare, texture and shading all scale with exposure, the
offset does not. `fit_exposure_bracket` solves one bracket; `solve_bracket` is its engine, for many at once.
`frame_drift` tells by how much the offset itself moves from frame to frame.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.units import Measured


@dataclass(frozen=True, slots=True, kw_only=True)
class ExposureBracket:
    """A bracket of exposures, solved.

    Parameters
    ----------
    offset
        The black level b with its error: that of the means, scaled where ``misfit``, and the drift of the offset [DN].
    ratios
        Exposure of each row of the means over that of the first, the first one exactly 1, length E [1].
    signals_dn
        Profiled signal above black of each patch at the first exposure, shape (N,); NaN where a patch took no part
        [DN].
    chi_square, dof
        Of the residuals, and their degrees of freedom.
    misfit
        Whether chi-square lies beyond its 99 % point even so: errors are scaled and have ``dof`` degrees of freedom.
    restricted
        Whether the response shows a bend, so that only means below a tenth of the digital maximum were used.
    used
        Means that took part, shape (E, N).
    residuals
        (x - b - r_e s_i) over its standard error, shape (E, N); NaN where a patch took no part.

    """

    offset: Measured
    ratios: tuple[Measured, ...]
    signals_dn: NDArray[np.float64]
    chi_square: float
    dof: int
    misfit: bool
    restricted: bool
    used: NDArray[np.bool_]
    residuals: NDArray[np.float64]


def fit_exposure_bracket(
    means_dn: ArrayLike,
    variances_of_means_dn2: ArrayLike,
    *,
    used: ArrayLike | None = None,
    digital_maximum: float | None = None,
    drift_dn: float = 0.0,
    frames: ArrayLike = 1,
) -> ExposureBracket:
    """Return the offset that makes exposures of one still scene proportional (METHOD 2.3, 2.5).

    Parameters
    ----------
    means_dn
        Mean of each patch at each exposure, black level included, shape (E, N), any order of exposures [DN].
    variances_of_means_dn2
        Variance of each of them, s^2 / n of all pixel values behind it, shape (E, N) [DN^2].
    used
        Means that may take part, shape (E, N); all finite ones by default. Leave clipped patches out here.
    digital_maximum
        White level less black level D; where the response shows a bend, means with a signal below D / 10 alone are
        used. The brightest mean's signal by default [DN].
    drift_dn
        Standard deviation of the offset of single frames, see `frame_drift` [DN].
    frames
        Frames averaged in each exposure, shape (E,) or one for all.

    Returns
    -------
    ExposureBracket
        Patches whose residuals exceed 4 are dropped, one at a time, at most a tenth of them (hot pixels, dust).

    Raises
    ------
    ValueError
        With fewer than two exposures, with fewer than three patches seen at two exposures or more, or where no exposure
        differs from the first beyond four standard errors: then nothing identifies the offset.

    """
    raise NotImplementedError


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
    raise NotImplementedError


def repeat_levels(
    means_dn: ArrayLike, variances_of_means_dn2: ArrayLike, *, offset_dn: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the offset of each of several frames of one exposure about their mean, free of flicker (METHOD 2.5).

    Parameters
    ----------
    means_dn, variances_of_means_dn2
        Mean of each patch in each frame and its variance, shape (L, N) [DN, DN^2].
    offset_dn
        The black level [DN].

    Returns
    -------
    tuple of ndarray
        Intercept at black of each frame's patches against the mean of all frames, and its variance, shape (L,)
        [DN, DN^2]; for `frame_drift`.

    """
    raise NotImplementedError
