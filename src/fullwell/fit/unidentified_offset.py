"""What is left of k_dark where nothing identifies the black level (METHOD 2.1, 2.4).

Photon transfer cannot tell the offset: a shift of it goes into A without trace. Where the offset is only declared, or
comes from the published optimizer, k_dark is an interval and no more.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fullwell.fit.noise_coefficients import dark_sensitivity_to_offset
from fullwell.units import ONE, Measured, square_root, student_975


@dataclass(frozen=True, slots=True, kw_only=True)
class UnidentifiedDark:
    """k_dark for an offset known to lie in a range.

    Parameters
    ----------
    k_dark
        At the offset used; its interval holds every k_dark that an offset in the range gives, with the error of the
        fit beyond [1].
    k_dark_variance
        Its signed square, interval alike [1].
    sensitivity
        d ln k_dark / d b = B / (2 A) [1/DN].

    """

    k_dark: Measured
    k_dark_variance: Measured
    sensitivity: float


def unidentified_dark(
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    *,
    shifts_dn: tuple[float, float],
    digital_maximum: float,
    dof: float | None = None,
) -> UnidentifiedDark:
    """Return k_dark with the interval that a range of offsets leaves it (METHOD 2.1, 2.4).

    Parameters
    ----------
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] of a single frame at the offset used, shapes (3,) and (3, 3).
    shifts_dn
        Lowest and highest offset that may be true, less the one used: (-0.5, 0.5) for a declared level; `offset_range`
        where there is not even that [DN].
    digital_maximum
        D [DN].
    dof
        Degrees of freedom of the covariance; None for many.

    """
    reach = student_975(dof)
    low, high = min(*shifts_dn, 0.0), max(*shifts_dn, 0.0)
    ends: list[float] = []
    for shift, side in ((low, -1.0), (high, 1.0)):
        powers = np.array([1.0, shift, shift**2])
        error = math.sqrt(float(powers @ covariance @ powers))
        dark = float(powers @ coefficients)
        ends.append((dark if side < 0.0 else max(dark, 0.0)) + side * reach * error)
    spread = float(coefficients[1]) * (high - low) / math.sqrt(12.0)
    scale = digital_maximum**-2
    variance = Measured(
        value=float(coefficients[0]) * scale,
        unit=ONE,
        std_error=math.hypot(math.sqrt(float(covariance[0, 0])), spread) * scale,
        dof=dof,
        ci95=(ends[0] * scale, ends[1] * scale),
    )
    return UnidentifiedDark(
        k_dark=square_root(variance, ONE),
        k_dark_variance=variance,
        sensitivity=dark_sensitivity_to_offset(coefficients),
    )


def offset_range(coefficients: NDArray[np.float64], *, darkest_dn: float) -> tuple[float, float]:
    """Return the offsets that physics allows, less the one used: A above zero, no patch below black (METHOD 2.1).

    Parameters
    ----------
    coefficients
        A, B, C at the offset used, shape (3,).
    darkest_dn
        Signal of the darkest patch above the offset used [DN].

    """
    dark, shot, fixed = (float(value) for value in coefficients)
    root = math.sqrt(max(shot**2 - 4.0 * dark * fixed, 0.0))
    return min(-2.0 * dark / (shot + root), darkest_dn), darkest_dn
