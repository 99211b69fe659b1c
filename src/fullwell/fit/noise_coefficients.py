"""From fitted variances to the noise coefficients k_dark, k_shot and k_fpn, and a test for fixed pattern noise.

k enters the model squared, so intervals live in variance space and are mapped by the square root; C may come out
negative, which says that there is no fixed pattern to be seen (METHOD 0, 1.7).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.fit.photon_transfer import fit_photon_transfer
from fullwell.units import ONE, Measured, combined_dof, square_root, student_975

DIGITAL_MAXIMUM_IS: Final = "highest code"
"""What D is of measured k's, in words: the converter's highest code, the black level not taken off."""
CRITICAL_RATIO: Final = 2.71
"""95 % point of half a chi-square with none and half with one degree of freedom: the boundary's law (METHOD 1.7)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseCoefficientFit:
    """The k's of sigma^2 = k_dark^2 + k_shot^2 V + k_fpn^2 V^2, V = S / D.

    Parameters
    ----------
    k_dark, k_shot, k_fpn
        Standard deviations [1], intervals mapped from variance space.
    k_dark_variance, k_shot_variance, k_fpn_variance
        Their signed squares [1].
    digital_maximum
        D [DN].

    """

    k_dark: Measured
    k_shot: Measured
    k_fpn: Measured
    k_dark_variance: Measured
    k_shot_variance: Measured
    k_fpn_variance: Measured
    digital_maximum: float


@dataclass(frozen=True, slots=True, kw_only=True)
class FixedPatternTest:
    """Likelihood-ratio test of C > 0.

    Parameters
    ----------
    ratio
        Twice what C adds to the log-likelihood; zero where C came out negative.
    significant
        Whether the ratio exceeds 2.71 (size 5 %).

    """

    ratio: float
    significant: bool


def k_coefficients(
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    *,
    digital_maximum: float,
    dof: float | None = None,
    offset_std_error_dn: float = 0.0,
    offset_dof: float | None = None,
) -> NoiseCoefficientFit:
    """Return the k's of a fit in DN (METHOD 0, 1.7).

    Parameters
    ----------
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] of a single frame, shapes (3,) and (3, 3), as ``single_frame()`` of a fit gives them.
    digital_maximum
        D [DN].
    dof
        Degrees of freedom of the covariance; None for many.
    offset_std_error_dn
        Standard error of the black level: a shift of it goes into A as B times the shift, unseen by the fit
        (METHOD 2.1) [DN].
    offset_dof
        Degrees of freedom of that error; None for many.

    """
    of_dark, of_shot, of_fixed = np.sqrt(np.diagonal(covariance)).tolist()
    by_offset = abs(float(coefficients[1])) * offset_std_error_dn
    errors = (math.hypot(of_dark, by_offset), of_shot, of_fixed)
    known = (combined_dof((of_dark, dof), (by_offset, offset_dof)), dof, dof)
    scales = (digital_maximum**-2, 1.0 / digital_maximum, 1.0)
    dark, shot, fixed = (
        boundary_variance(scale * value, scale * error, dof=own)
        for scale, value, error, own in zip(scales, coefficients, errors, known, strict=True)
    )
    return NoiseCoefficientFit(
        k_dark=square_root(dark, ONE),
        k_shot=square_root(shot, ONE),
        k_fpn=square_root(fixed, ONE),
        k_dark_variance=dark,
        k_shot_variance=shot,
        k_fpn_variance=fixed,
        digital_maximum=digital_maximum,
    )


def dark_sensitivity_to_offset(coefficients: NDArray[np.float64]) -> float:
    """Return d ln k_dark / d b = B / (2 A) [1/DN]: what an offset does to k_dark, unseen by any fit (METHOD 2.1).

    Examples
    --------
    >>> a6000 = np.array([(1.672e-4 * 16383) ** 2, 5.554e-3**2 * 16383, 5.477e-3**2])
    >>> round(100 * dark_sensitivity_to_offset(a6000), 2)
    3.37

    """
    return float(coefficients[1] / (2.0 * coefficients[0]))


def boundary_variance(value: float, std_error: float, *, dof: float | None, unit: str = ONE) -> Measured:
    """Return a variance that may be negative, its interval [v - t se, max(v, 0) + t se] (METHOD 1.7)."""
    half = student_975(dof) * float(std_error)
    return Measured(
        value=float(value),
        unit=unit,
        std_error=float(std_error),
        dof=dof,
        ci95=(float(value) - half, max(float(value), 0.0) + half),
    )


def fixed_pattern_test(
    signal_dn: ArrayLike, variance_dn2: ArrayLike, dof: ArrayLike, *, n: ArrayLike | None
) -> FixedPatternTest:
    """Test whether single-frame variances show fixed pattern noise, C > 0 (METHOD 1.7); arguments as the fit's."""
    line = fit_photon_transfer(signal_dn, variance_dn2, dof, n=n, terms=2, reject_outliers=False)
    curve = fit_photon_transfer(signal_dn, variance_dn2, dof, n=n, terms=3, reject_outliers=False)
    ratio = max(line.deviance - curve.deviance, 0.0) if curve.coefficients[2] > 0.0 else 0.0
    return FixedPatternTest(ratio=ratio, significant=ratio > CRITICAL_RATIO)
