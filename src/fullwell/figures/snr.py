"""Signal-to-noise ratio: its curve, and its maximum at saturation by two definitions that differ (METHOD 7, 8)."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fullwell.figures.ratios import Ratio, ratio
from fullwell.model.photon_transfer import noise_variance, signal_to_noise
from fullwell.units import Measured, combined_dof


@dataclass(frozen=True, slots=True, kw_only=True)
class SnrMaximum:
    """Signal-to-noise ratio at saturation.

    Parameters
    ----------
    total
        All noise of the model.
    shot_only
        Photon noise alone: the square root of the electrons at saturation.

    """

    total: Ratio
    shot_only: Ratio


def snr_curve(signal_dn: ArrayLike, coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the model's signal-to-noise ratio at signals above the black level, A, B, C as in `dynamic_range`."""
    dark, shot, fixed = (float(value) for value in coefficients)
    return signal_to_noise(signal_dn, dark=dark, shot=shot, fixed_pattern=fixed)


def snr_maximum(
    coefficients: NDArray[np.float64],
    covariance: NDArray[np.float64],
    saturation: Measured,
    *,
    dof: float | None = None,
) -> SnrMaximum:
    """Return the signal-to-noise ratio at saturation (METHOD 7).

    Parameters
    ----------
    coefficients, covariance
        A [DN^2], B [DN/e-], C [1] of a single frame and their covariance, shapes (3,) and (3, 3).
    saturation
        Saturation signal above the black level, with its error where it has one [DN].
    dof
        Degrees of freedom of the covariance; None for many.

    Raises
    ------
    ValueError
        Where the model's variance at saturation is not positive.

    """
    dark, shot, fixed = (float(value) for value in coefficients)
    level = saturation.value
    variance = float(noise_variance(level, dark=dark, shot=shot, fixed_pattern=fixed))
    if variance <= 0.0 or shot <= 0.0 or level <= 0.0:
        raise ValueError("a signal-to-noise ratio needs a noise model that is positive at saturation")
    by_coefficients = -0.5 * np.array([1.0, level, level**2]) / variance
    by_level = 1.0 / level - 0.5 * (shot + 2.0 * fixed * level) / variance
    saturation_error = saturation.std_error or 0.0
    total = _with_parts(
        level / math.sqrt(variance),
        (float(np.sqrt(by_coefficients @ covariance @ by_coefficients)), dof),
        (abs(by_level) * saturation_error, saturation.dof),
    )
    shot_only = _with_parts(
        math.sqrt(level / shot),
        (0.5 * float(np.sqrt(covariance[1, 1])) / shot, dof),
        (0.5 * saturation_error / level, saturation.dof),
    )
    return SnrMaximum(total=total, shot_only=shot_only)


def _with_parts(value: float, *parts: tuple[float, float | None]) -> Ratio:
    return ratio(value, math.sqrt(sum(error**2 for error, _ in parts)), combined_dof(*parts))
